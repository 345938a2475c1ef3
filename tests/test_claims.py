"""A false report of the worker earns nothing: the table in docs/contributors/worker-reports.md, row by row."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

import grader
from grader.sandbox.wire import Frame
from tests.corpus.pieces import edit, lab, tidy
from tests.fuzz.answers import Bench
from tests.fuzz.claims import points
from tests.hostile.forging import STANDS

RAISES = lab(
    low_pass="class LowPassFilter:\n    def __init__(self, alpha=0.1, initial_value=None):\n        raise ValueError('no')\n"
)


DEPARTS = edit(tidy(), "filters.py", ("def update(self, measurement):", "def update(self, measurement, dt):"))
NAMELESS = {**tidy(), "filters.py": "x = 1\n"}


@pytest.fixture(scope="module")
def benches() -> dict[str, Bench]:
    """What the sandbox answers of each: the sound one, rows that no simulation made, filters with faults."""
    files = {
        "sound": tidy(),
        "stands": STANDS,
        "raises": RAISES,
        "nameless": NAMELESS,
        "departs": DEPARTS,
    }
    return {name: Bench(each) for name, each in files.items()}


def gained(bench: Bench, lie: object) -> dict[str, float]:
    """Checks that a lie earns more in, and by how much."""
    with bench.open():
        honest, lying = points(bench), points(bench, lie)  # type: ignore[arg-type]
    return {id_: lying[id_] - honest[id_] for id_ in honest if lying[id_] > honest[id_]}


def test_the_first_state_of_a_sound_run_earns_nothing_for_rows_that_do_not_follow_from_it(
    benches: dict[str, Bench],
) -> None:
    theirs = next(frame for key, frame in benches["sound"]._answers.items() if key.startswith("simulate "))
    first = {name: array for name, array in theirs.arrays.items() if name.startswith("first_")}
    assert first

    def lie(op: str, frame: Frame) -> Frame:
        return replace(frame, arrays={**frame.arrays, **first}) if op == "simulate" else frame

    assert gained(benches["stands"], lie) == {}


def test_a_model_that_is_said_to_be_unchanged_earns_nothing_for_rows_that_no_simulation_made(
    benches: dict[str, Bench],
) -> None:
    def lie(op: str, frame: Frame) -> Frame:
        return replace(frame, fields={**frame.fields, "changed": []}) if op == "simulate" else frame

    assert gained(benches["stands"], lie) == {}


def test_names_that_are_said_to_be_there_must_answer(benches: dict[str, Bench]) -> None:
    def lie(op: str, frame: Frame) -> Frame:
        names = ["LowPassFilter", *frame.fields.get("names", ())]
        return replace(frame, fields={**frame.fields, "names": names}) if op == "load" else frame

    assert gained(benches["nameless"], lie) == {}


def test_an_error_that_is_kept_silent_leaves_an_answer_that_is_none(benches: dict[str, Bench]) -> None:
    def lie(op: str, frame: Frame) -> Frame:
        if op != "filter":
            return frame
        return replace(
            frame, fields={**frame.fields, "cases": [{**case, "error": None} for case in frame.fields["cases"]]}
        )

    assert gained(benches["raises"], lie) == {}


def test_a_departure_that_is_not_told_hides_itself_alone(benches: dict[str, Bench]) -> None:
    def lie(op: str, frame: Frame) -> Frame:
        if op != "filter":
            return frame
        return replace(frame, fields={**frame.fields, "cases": [{**c, "departs": []} for c in frame.fields["cases"]]})

    assert gained(benches["departs"], lie) == {"filtering.follows_recursion": 3.0}


def test_every_field_of_an_answer_that_speaks_of_the_process_is_in_the_table() -> None:
    table = (Path(__file__).parent.parent / "docs/contributors/worker-reports.md").read_text(encoding="utf-8")
    rules = [Path(grader.__file__).parent / place for place in ("engine/replies.py", "labs/imu/replies.py")]
    asked = {name for path in rules for name in re.findall(r'answer\.part\("(\w+)"', path.read_text(encoding="utf-8"))}
    values = {
        "value",
        "calls",
        "cases",
        "odd",
        "curves",
        "reason",
    }  # what a student's function returned: held against the truth
    assert sorted(name for name in asked - values if f"`{name}`" not in table) == []
