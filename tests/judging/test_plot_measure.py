"""Which run a plot is asked to draw, and which of the figures is judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.base.errors import NoAnswer
from grader.engine.findings import NEEDS_REVIEW, Fault, Missing, Raised
from grader.engine.load_report import Loaded, SteppedOver
from grader.labs.imu.answers import KEYS, Array, Collection, Drawing
from grader.labs.imu.visualization import measure
from grader.sandbox.wire import Frame
from tests.judging.fake_students import FakeStudent, truth
from tests.judging.test_check_visualization import SHEET, Plotted

pytestmark = pytest.mark.quick
FAULT = Fault("KeyError", "", None, None, None)
STOPPED = Drawing((), FAULT)


class Recording(Plotted):
    """A student whose recording is known, and who keeps what the plot was given."""

    def __init__(self, recording: Collection | Exception) -> None:
        super().__init__(Drawing((SHEET,)))
        self.recording = recording

    def simulate(self, *_: Any, duration_s: float, ids: Any, **__: Any) -> Collection:
        assert (duration_s, ids) == (truth()["push"].scalars["duration_s"], tuple(truth()["reading_lab"]["pairs"][0]))
        if isinstance(self.recording, Exception):
            raise self.recording
        return self.recording

    def plot(self, *, data: Mapping[str, Array], sheet: Mapping[str, Array], **given: Any) -> Drawing:
        self.data, self.own_form = data, given["own_form"]
        return super().plot(sheet=sheet)


def _recorded(*names: str, **words: Any) -> Collection:
    keys = dict(zip(KEYS, names, strict=False))
    return replace(Collection(*(truth()["push"][key] for key in KEYS)), keys=keys, **words)


@pytest.mark.parametrize(
    ("recording", "names", "own_form"),
    [
        (_recorded("t", "acc", "gyro"), ("t", "acc", "gyro"), False),
        (_recorded("t"), ("t", *KEYS[1:]), False),
        (_recorded("0", "1", "2", oddities=(("wrong-return-type", "got a tuple"),)), KEYS, True),
        (NoAnswer("none"), KEYS, False),
        (Missing("a", "b", "c"), KEYS, False),
        (Raised(FAULT, ""), KEYS, False),
    ],
)
def test_a_plot_is_given_what_the_submission_itself_records(
    recording: Collection | Exception, names: tuple[str, ...], own_form: bool
) -> None:
    student = Recording(recording)
    measure.drawing_of_data(student, truth())
    assert tuple(student.data) == tuple(names)
    assert student.own_form is own_form
    for name, key in zip(names, KEYS, strict=True):
        assert np.array_equal(student.data[name], truth()["tumbling"][key])


@pytest.mark.parametrize(
    ("recording", "drawing", "noted"),
    [
        (NoAnswer("none"), STOPPED, True),
        (Collection(None, None, None, fault=FAULT), STOPPED, True),
        (_recorded(), STOPPED, False),
        (NoAnswer("none"), Drawing((), Fault("NotImplementedError", "", None, None, None)), False),
        (NoAnswer("none"), Drawing((SHEET,)), False),
    ],
)
def test_a_plot_that_stops_where_the_recorder_returns_nothing_goes_to_a_person(
    recording: Collection | Exception, drawing: Drawing, noted: bool
) -> None:
    student = Recording(recording)
    student._drawing = drawing
    measure.measure(student, truth())
    assert [NEEDS_REVIEW in note for note in student.notes] == [True] * noted


def test_of_figures_that_show_as_much_the_saved_one_or_the_first_is_judged() -> None:
    shown, saved = replace(SHEET, event="shown"), replace(SHEET, path="b.png")
    for figures, judged in (((shown, saved, SHEET), saved), ((shown, replace(shown, path="b.png")), shown)):
        assert measure.measure(Plotted(Drawing(figures)), truth()).plot.figure is judged


class Imported(FakeStudent):
    """A student whose file was imported, and whose statements ended so."""

    def __init__(self, *ends: str) -> None:
        super().__init__()
        faults = [Fault("NameError", how, "filters.py", line, None) for line, how in enumerate(ends, 7)]
        self._ends = tuple(
            SteppedOver("filters.py", fault.line or 0, fault.line or 0, fault.message, (), frozenset(), fault)
            for fault in faults
        )

    def load(self, path: str) -> Loaded:
        return replace(super().load(path), stepped_over=self._ends, frame=Frame({"figures": []}))


@pytest.mark.parametrize(
    ("ends", "line"),
    [((), None), (("raised",), 7), (("hints",), None), (("overran",), None), (("ended", "raised", "raised"), 8)],
)
def test_a_statement_that_raised_while_a_file_was_imported_broke_off_what_it_draws(
    ends: tuple[str, ...], line: int | None
) -> None:
    drawing = Imported(*ends)._drawn_at_import("filters.py")
    assert drawing is not None
    assert (drawing.fault and drawing.fault.line) == line
