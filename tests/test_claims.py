"""A false report of the worker earns nothing: the table in docs/contributors/worker-reports.md, row by row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.engine import replies
from grader.labs.imu.replies import RULES
from grader.sandbox.wire import Frame
from tests.corpus.pieces import edit, lab, tidy
from tests.corpus.writing import Files
from tests.fuzz.answers import Bench, recorded
from tests.hostile.forging import STANDS

RAISES = lab(
    low_pass="class LowPassFilter:\n    def __init__(self, alpha=0.1, initial_value=None):\n        raise ValueError('no')\n"
)
DEPARTS = edit(tidy(), "filters.py", ("def update(self, measurement):", "def update(self, measurement, dt):"))
NAMELESS = {**tidy(), "filters.py": "x = 1\n"}


@pytest.fixture(scope="module")
def first_state() -> dict[str, np.ndarray]:
    """The first state of a sound run, as the worker reports it."""
    answers, _ = recorded(tidy())
    sound = next(frame for key, frame in answers.items() if key.startswith("simulate "))
    found = {name: array for name, array in sound.arrays.items() if name.startswith("first_")}
    assert found
    return found


def said(frame: Frame, **fields: object) -> Frame:
    return replace(frame, fields={**frame.fields, **fields})


def said_of_each_case(frame: Frame, **fields: object) -> Frame:
    return said(frame, cases=[{**case, **fields} for case in frame.fields["cases"]])


LIES: dict[str, tuple[Files, str, Callable[[Frame], Frame] | None, dict[str, float]]] = {
    "the first state of a sound run for rows that do not follow from it": (STANDS, "simulate", None, {}),
    "no change of the model for rows that no simulation made": (STANDS, "simulate", lambda frame: said(frame, changed=[]), {}),
    "a name that is not there": (
        NAMELESS, "load", lambda frame: said(frame, names=["LowPassFilter", *frame.fields.get("names", ())]), {},
    ),
    "no error where no answer is": (RAISES, "filter", lambda frame: said_of_each_case(frame, error=None), {}),
    "no departure, which hides itself alone": (
        DEPARTS, "filter", lambda frame: said_of_each_case(frame, departs=[]), {"filtering.follows_recursion": 3.0},
    ),
}  # fmt: skip
"""By what is claimed: the submission, the question, its answer with the claim (None: with `first_state`), and what it earns."""


@pytest.mark.parametrize("claim", LIES)
def test_a_false_claim_earns_nothing_but_what_it_hides(claim: str, first_state: dict[str, np.ndarray]) -> None:
    files, question, lie, gained = LIES[claim]
    lie = lie or (lambda frame: replace(frame, arrays={**frame.arrays, **first_state}))
    with Bench(files).open() as bench:
        honest, lying = bench.points(), bench.points(lambda op, frame: lie(frame) if op == question else frame)
    assert {id_: lying[id_] - honest[id_] for id_ in honest if lying[id_] > honest[id_]} == gained


def test_every_field_of_an_answer_that_speaks_of_the_process_is_in_the_table() -> None:
    table = (Path(__file__).parent.parent / "docs/contributors/worker-reports.md").read_text(encoding="utf-8")
    asked = {name for rule in {**replies.RULES, **RULES}.values() for name in rule.reply.__struct_fields__} - {"error"}
    values = {"value", "calls", "cases", "odd", "curves", "reason"}  # what a function returned: held against the truth
    assert sorted(name for name in asked - values if f"`{name}`" not in table) == []
