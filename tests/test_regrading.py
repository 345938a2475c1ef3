"""Tests that another rubric gives the same points from the record as from a new grading in the sandbox."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from grader import __version__
from grader.base.errors import RequestError
from grader.course.publishing.out_files import publish, publish_class
from grader.course.record.store import Key, Store
from grader.course.regrading import regrade
from grader.engine import rubric
from grader.engine.marks import marked
from grader.engine.results import Result, to_json
from grader.engine.rubric import Rubric
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade, HandIn, Person
from grader.people.late_policy import judged
from tests.examples import FOLDER, folders
from tests.fake_results import lost, without_durations
from tests.recordings.marker import RecordedMarker
from tests.rubrics import SHIPPED, edited

LATE = "late: {due: 2026-11-20T23:59+01:00, per_day: 10}\n"
SOON = ("call_cpu_s: 10", "call_cpu_s: 1"), ("submission_cpu_s: 120", "submission_cpu_s: 6")
"""An endless loop is one of the examples, and this is no test of how long it may take."""
PRICES = ("limits:", "faults: {sensor-id-as-address: 4, no-units: 0.5, never-returns: 1}\nlimits:")
CHANGES = (
    ("follows_address: 6", "follows_address: 5"),
    ("time_axis: 3", "time_axis: 7.5"),
    ("follows_recursion: 6", "follows_recursion: 0"),
    PRICES,
    ("points: 20", "points: 33.33"),
    ("title: Sensor access", "title: The sensors"),
    (
        "      titles: 1\n      comparison_plot: 4 # the second of the sheet's two pictures, in one check\n",
        "      comparison_plot: 2\n      titles: 1\n",
    ),
    ("# extra_credit: {each: 5, cap: 10}", "extra_credit: {each: 5, cap: 3}"),
)


def changed(*edits: tuple[str, str], text: str = SHIPPED) -> Rubric:
    for old, new in (*SOON, *edits):
        text = edited(old, new, text)
    return rubric.parse(LAB, text.encode())


@cache
def found(name: str) -> Result:
    """One of the example class, marked by the shipped points."""
    return RecordedMarker(changed()).mark(read_submission(FOLDER / name, LAB.files))


def record(graded: Result) -> object:
    return without_durations(json.loads(to_json(graded)))


def test_marks_from_what_was_found_out_are_those_of_grading_again() -> None:
    names = [folder.name for folder in folders()]
    by = changed(*CHANGES)
    marker = RecordedMarker(by)
    again = {name: record(marker.mark(read_submission(FOLDER / name, LAB.files))) for name in names}
    assert {name: record(marked(found(name), by)) for name in names} == again
    assert {name: record(found(name)) for name in names} != again


# ---- a class on record ----


def keep(out: Path, by: Rubric, names: tuple[str, ...] = ("s02-vectorised", "s06-id-as-address", "s14-empty")) -> None:
    with Store(out) as store:
        for name in names:
            handed_in = str(found(name).provenance["submission_sha256"])
            key = Key(name, handed_in, by.sha256, bundles.shipped().sha256, __version__)
            store.keep(key, marked(found(name), by))
            hand_in = HandIn((Person(name),), "2026-11-22T00:00:00+00:00")
            store.keep_hand_in(name, judged(hand_in, by.late, (name,)))


def test_a_class_that_is_marked_by_another_rubric_has_the_files_that_grading_it_writes(tmp_path: Path) -> None:
    by = changed(PRICES, text=SHIPPED + LATE)
    anew, again = tmp_path / "anew", tmp_path / "again"
    keep(anew, changed())
    with Store(anew) as store:
        written(anew, store)
        after = regrade.remark(anew, store, by)
        for final_grade in after.values():
            publish(anew, final_grade, store, LAB)
        assert {each.result.provenance["rubric_sha256"] for each in store.final_grades().values()} == {by.sha256}
        assert store.final_grades() == after
    keep(again, by)
    with Store(again) as store:
        assert written(again, store) == after
    names = [path.relative_to(again) for path in again.rglob("*.*") if path.suffix != ".sqlite"]
    assert len(names) > 2 * 3
    for name in names:
        assert (anew / name).read_bytes() == (again / name).read_bytes(), name


def written(out: Path, store: Store) -> Mapping[str, FinalGrade]:
    """Publish every report, and return the grades in them."""
    grades = publish_class(out, store, LAB)
    for final_grade in grades.values():
        publish(out, final_grade, store, LAB)
    return grades


@pytest.mark.parametrize(
    "edit", [("call_cpu_s: 1", "call_cpu_s: 2"), ("accelerometer: torso_", "accelerometer: head_")]
)
def test_a_rubric_that_asks_something_else_is_refused_and_nothing_is_changed(
    tmp_path: Path, edit: tuple[str, str]
) -> None:
    keep(tmp_path, changed())
    told = r"rubric\.yaml: needs other measurements than those of s02-vectorised, s06"
    with Store(tmp_path) as store:
        before = store.final_grades()
        with pytest.raises(RequestError, match=told):
            regrade.remark(tmp_path, store, changed(edit))
        assert store.final_grades() == before


# ---- what a fault costs ----


@pytest.mark.parametrize(
    ("keeps", "faults", "left"),
    [
        (0.0, ("sensor-id-as-address",), 2.0),
        (0.5, ("sensor-id-as-address",), 2.0),
        (0.0, ("swapped-sensors",), 0.0),  # within its check
        (0.0, ("sensor-id-as-address", "raises"), 1.5),
        (0.5, ("sensor-id-as-address", "no-units"), 3.0),  # one has no price: the check's own share
        (0.5, (), 3.0),
    ],
)
def test_a_fault_with_a_price_costs_that_within_its_check(keeps: float, faults: tuple[str, ...], left: float) -> None:
    by = rubric.parse(LAB, (SHIPPED + "faults: {sensor-id-as-address: 4, raises: 0.5, swapped-sensors: 90}").encode())
    row = lost(id="sensor_access.follows_address", keeps=keeps, misconceptions=faults)
    whole = found("s02-vectorised")
    rows = tuple(row if check.id == row.id else check for check in whole.criteria[0].checks)
    first = replace(whole.criteria[0], checks=rows)
    graded = marked(replace(whole, criteria=(first, *whole.criteria[1:])), by)
    assert [check.points for check in graded.criteria[0].checks if check.id == row.id] == [left]
