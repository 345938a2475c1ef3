"""Which run a plot is asked to draw, and which of the figures is judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.base.errors import NoAnswer
from grader.engine.figures import Picture
from grader.engine.findings import NEEDS_REVIEW, StudentError
from grader.engine.load_report import SteppedOver
from grader.labs.imu.answers import Drawing
from grader.labs.imu.collection import KEYS, Collection
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization import measure, pictures
from grader.sandbox.wire import Frame
from tests.judging.fake_students import FakeStudent, truth
from tests.judging.test_check_visualization import SHEET, Plotted

pytestmark = pytest.mark.quick
FAULT = StudentError("KeyError", "", None, None, None)
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
        (_recorded("0", "1", "2", oddities=(("wrong-return-type", "got a tuple"),)), KEYS, True),
        (NoAnswer("none"), KEYS, False),
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
        (Collection(None, None, None, error=FAULT), STOPPED, True),
        (_recorded(), STOPPED, False),
        (NoAnswer("none"), Drawing((), StudentError("NotImplementedError", "", None, None, None)), False),
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


@pytest.mark.parametrize(
    ("ends", "line"),
    [((), None), (("hints",), None), (("ended", "raised", "raised"), 8)],
)
def test_a_statement_that_raised_while_a_file_was_imported_broke_off_what_it_draws(
    ends: tuple[str, ...], line: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    student = FakeStudent()
    stepped_over = tuple(
        SteppedOver("filters.py", at, at, how, (), frozenset(), StudentError("NameError", how, "filters.py", at, None))
        for at, how in enumerate(ends, 7)
    )
    loaded = replace(student.load("filters.py"), stepped_over=stepped_over, frame=Frame({"figures": []}))
    monkeypatch.setattr(student, "load", lambda path: loaded)
    drawing = student._drawn_at_import("filters.py")
    assert drawing is not None
    assert (drawing.error and drawing.error.line) == line


PICTURE = Picture((800, 600), 0.2, np.zeros((60, 80), np.uint8), np.full((256, 3), 255, np.uint8))


@pytest.mark.parametrize(
    ("picture", "something"),
    [
        (None, False),
        (replace(PICTURE, ink=0.005), False),
        (replace(PICTURE, ink=0.006), True),
        (replace(PICTURE, ink=0.59), True),
        (replace(PICTURE, ink=0.6), False),
        (replace(PICTURE, size_px=(149, 600)), False),
        (replace(PICTURE, size_px=(600, 150)), True),
    ],
)
def test_a_picture_that_may_be_a_plot_shows_something(picture: Picture | None, something: bool) -> None:
    student = Plotted(Drawing(()), pictures={"imu_data.png": picture})
    assert pictures.was_handed_in(student, "imu_data.png") is something
    assert not pictures.was_handed_in(student, "another.png")
