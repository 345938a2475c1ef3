"""What is recorded is read back as it was, whatever it holds."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.course.record import class_settings
from grader.course.record.class_settings import ClassSettings
from grader.engine import results
from grader.engine.chart_data import Chart, Curve, Evidence, Panel, packed, unpacked
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, Repair, Result, from_dict
from grader.people.final_grade import HandIn, Lateness, Person

NUMBERS = st.floats(-1e6, 1e6)
POINTS = st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), max_size=3).map(tuple)


def several(one: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(one, max_size=2).map(tuple)


CHECKS = st.builds(
    lambda check, message: CheckResult(**check, **message),
    st.fixed_dictionaries({
        "id": st.uuids().map(str), "title": st.text(), "outcome": st.sampled_from(["passed", "failed", "not_judged"]),
        "points": st.none() | NUMBERS, "max_points": NUMBERS, "hint": st.text(), "keeps": st.none() | NUMBERS, "not_understood": st.booleans(),
        "misconceptions": several(st.text()),
    }),
    st.fixed_dictionaries({"said": st.text()}) | st.fixed_dictionaries({"expected": st.text(min_size=1), "got": st.text()}),
)  # fmt: skip
RESULTS = st.builds(
    Result,
    criteria=several(st.builds(CriterionResult, max_points=NUMBERS, checks=several(CHECKS))),
    extensions=several(st.builds(ExtensionResult, max_points=NUMBERS, checks=several(CHECKS))),
    provenance=st.dictionaries(st.text(), st.text(), max_size=2),
    duration_s=NUMBERS,
    extra_credit_cap=st.none() | NUMBERS,
    repairs=several(st.builds(Repair, deduction=NUMBERS, score_before=NUMBERS)),
    unrepaired=st.just({}),
    evidence=st.just(Evidence()),
    cpu_s=st.just(0.0),
)
CURVES = st.builds(Curve, x=POINTS, y=POINTS)
CHARTS = several(st.builds(Chart, panels=several(st.builds(Panel, curves=several(CURVES), spread=NUMBERS))))
HAND_INS = st.builds(
    HandIn, people=several(st.from_type(Person)), late=st.none() | st.builds(Lateness, deduction=NUMBERS)
)
SETTINGS = st.builds(ClassSettings, own_checks=several(st.tuples(st.text(), st.binary())))


def _result_in_the_record(made: Result) -> Result:
    read = from_dict(json.loads(json.dumps(results.to_record(made))))
    assert results.to_record(read) == results.to_record(made)  # also what two results are not compared by
    return read


@pytest.mark.quick
@pytest.mark.parametrize(
    ("drawn", "read_back"),
    [
        (RESULTS, lambda made: from_dict(json.loads(results.to_json(made)))),
        (RESULTS, _result_in_the_record),
        (CHARTS, lambda made: unpacked(packed(made))),
        (HAND_INS, lambda made: msgspec.convert(json.loads(json.dumps(asdict(made))), HandIn)),
        (SETTINGS, lambda made: class_settings.from_json(class_settings.to_json(made))),
    ],
    ids=["result.json", "a result", "charts", "a hand-in", "settings"],
)
@given(data=st.data())
def test_what_is_recorded_is_read_back(
    drawn: st.SearchStrategy[Any], read_back: Callable[[Any], Any], data: st.DataObject
) -> None:
    made = data.draw(drawn)
    assert read_back(made) == made
