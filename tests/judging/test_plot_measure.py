"""Which run a plot is asked to draw, which of the figures is judged, and what is seen in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.base.errors import NoAnswer
from grader.engine.figures import Axes, Figure, VisibleParts
from grader.engine.findings import Fault, Missing, Raised
from grader.labs.imu.answers import KEYS, Array, Collection, Drawing
from grader.labs.imu.visualization import measure
from grader.labs.imu.visualization.curves import CHANNELS, Panel, Plot, Shown
from tests.judging.made import truth
from tests.judging.test_check_visualization import Plotted, Sheet

pytestmark = pytest.mark.quick


class Asked(Plotted):
    """One that keeps what its plot was given."""

    own_form: bool

    def plot(
        self, *, data: Mapping[str, Array], sheet: Mapping[str, Array], ids: Any, called: str, own_form: bool
    ) -> Drawing:  # type: ignore[override]
        self.given, self.own_form = (data, sheet, ids, called), own_form
        return Sheet().drawing()


# ---- what is drawn of ----


class Recording(Asked):
    """One whose recording is known."""

    def __init__(self, recording: Collection | Exception) -> None:
        super().__init__(Drawing(()))
        self.recording = recording

    def simulate(self, *_: Any, duration_s: float, ids: Any, **__: Any) -> Collection:
        assert (duration_s, ids) == (truth()["push"].scalars["duration_s"], tuple(truth()["reading_lab"]["pairs"][0]))
        if isinstance(self.recording, Exception):
            raise self.recording
        return self.recording


def _recorded(**words: Any) -> Collection:
    return replace(Collection(*(truth()["push"][key] for key in KEYS)), **words)


@pytest.mark.parametrize(
    ("recording", "names"),
    [
        (_recorded(keys={"time": "t", "acceleration": "acc", "angular_velocity": "gyro"}), ["t", "acc", "gyro"]),
        (_recorded(keys={"time": "t"}), ["t", "acceleration", "angular_velocity"]),
        (_recorded(keys={"time": "0", "acceleration": "1", "angular_velocity": "2"}), list(KEYS)),
        *((problem, list(KEYS)) for problem in (NoAnswer("none"), Missing("a", "b", "c"), Raised(Fault("E", "", None, None, None), ""))),
    ],
)  # fmt: skip
def test_a_plot_is_given_what_the_submission_itself_records(
    recording: Collection | Exception, names: list[str]
) -> None:
    student = Recording(recording)
    measure.drawing_of_data(student, truth())
    data, sheet, _, _ = student.given
    assert list(data) == names
    assert list(sheet) == list(KEYS)
    for name, key in zip(names, KEYS, strict=False):
        assert np.array_equal(data[name], truth()["tumbling"][key])


@pytest.mark.parametrize(
    ("recording", "own"),
    [
        (_recorded(), False),
        (_recorded(oddities=(("wrong-return-type", "got a tuple"),)), True),
        (Raised(Fault("E", "", None, None, None), ""), False),
    ],
)
def test_a_recording_of_another_form_may_be_what_the_plot_is_made_for(recording: Any, own: bool) -> None:
    student = Recording(recording)
    measure.drawing_of_data(student, truth())
    assert student.own_form is own


# ---- which figure is judged ----


def _saw(drawing: Drawing) -> Plot:
    return measure.measure(Plotted(drawing), truth()).plot


def _panel_alone(which: int, **words: Any) -> Figure:
    sheet = Sheet()
    return replace(sheet.figure, axes=(sheet.panels[which],), **words)


def test_the_figure_that_shows_most_is_judged_and_of_equal_ones_the_saved_one_or_the_first() -> None:
    whole, part = Sheet().figure, _panel_alone(0)
    assert _saw(Drawing((part, whole))).figure is whole
    shown, saved = replace(whole, event="shown"), replace(whole, path="b.png")
    assert _saw(Drawing((shown, saved, whole))).figure is saved
    assert _saw(Drawing((shown, replace(shown, path="b.png")))).figure is shown


def test_a_picture_for_each_sensor_is_one_figure_where_both_were_saved() -> None:
    first, second = _panel_alone(0), _panel_alone(1, path="gyro.png")
    joined = _saw(Drawing((first, second)))
    assert (len(joined.panels), len(joined.drawn)) == (2, 6)
    lost = replace(first, event="overwritten")
    assert len(_saw(Drawing((lost, second))).drawn) == 6
    left = replace(first, event="shown")
    assert len(_saw(Drawing((left, second))).drawn) == 3


def _stopped(student: Plotted) -> str:
    """Return why the panels of a plot cannot be judged; "" if they can."""
    return str(measure.measure(student, truth()).stopped.get("titles", ""))


def test_what_a_plot_raises_counts_where_it_has_drawn_nothing() -> None:
    fault = Fault("ValueError", "no", None, None, None)
    stopped = measure.measure(Plotted(Drawing((), fault)), truth()).stopped
    assert {type(each) for each in stopped.values()} == {Raised}
    found = measure.measure(Plotted(replace(Sheet().drawing(), fault=fault)), truth())
    assert (found.fault, found.stopped) == (fault, {})


# ---- what is seen in it ----


def _sight(inside: int, seen: int) -> VisibleParts:
    """So many hundredths of a curve within the limits, and so many of it seen."""
    parts = np.arange(100)
    return VisibleParts(parts < inside, parts < seen)


def _sighted(figure: Figure, sight: VisibleParts, *channels: tuple[int, int]) -> Figure:
    """The figure with another sight of these curves, or of all."""

    def seen(axes: Axes, sensor: int) -> Axes:
        curves = (
            replace(curve, visible_parts=sight) if not channels or (sensor, axis) in channels else curve
            for axis, curve in enumerate(axes.curves)
        )
        return replace(axes, curves=tuple(curves))

    return replace(figure, axes=tuple(seen(axes, sensor) for sensor, axes in enumerate(figure.axes)))


def _plot(figure: Figure) -> Plot:
    (plot,) = measure.candidates(Plotted(Drawing((figure,))), truth(), Drawing((figure,)))
    return plot


@pytest.mark.parametrize(("inside", "cut"), [(49, True), (50, False), (100, False)])
def test_a_channel_is_cut_off_where_less_than_half_of_it_is_within_the_limits(inside: int, cut: bool) -> None:
    plot = _plot(_sighted(Sheet().figure, _sight(inside, inside), (1, 2)))
    assert list(plot.cut_off()) == [(1, 2)] * cut


def test_of_a_channel_in_two_panels_all_that_lies_in_either_counts() -> None:
    figure = _sighted(Sheet().figure, _sight(40, 20), (0, 0))
    assert list(_plot(figure).cut_off()) == [(0, 0)]
    assert _plot(replace(figure, axes=(*figure.axes, figure.axes[0]))).cut_off() == {}


def _drawn_from(first: int, last: int, *channels: tuple[int, int], figure: Figure | None = None) -> Figure:
    """The figure with these rows alone of these channels."""
    figure = Sheet().figure if figure is None else figure

    def cut(axes: Axes, sensor: int) -> Axes:
        curves = (
            replace(curve, x=curve.x[first:last], y=curve.y[first:last]) if (sensor, axis) in channels else curve
            for axis, curve in enumerate(axes.curves)
        )
        return replace(axes, curves=tuple(curves))

    return replace(figure, axes=tuple(cut(axes, sensor) for sensor, axes in enumerate(figure.axes)))


@pytest.mark.parametrize(("rows", "in_part"), [(600, False), (545, False), (535, True), (60, True)])
def test_a_channel_of_which_less_than_nine_tenths_are_drawn_is_drawn_in_part(rows: int, in_part: bool) -> None:
    plot = _plot(_drawn_from(0, rows, (1, 2)))
    assert plot.drawn == set(CHANNELS)
    assert list(plot.in_part()) == [(1, 2)] * in_part
    assert plot.cut_off() == {}


def test_halves_of_a_channel_in_two_panels_are_the_whole() -> None:
    first, second = _drawn_from(0, 300, (0, 0)), _drawn_from(300, 600, (0, 0))
    plot = _plot(replace(first, axes=(*first.axes, second.axes[0])))
    assert plot.in_part() == {}
    assert list(_plot(first).in_part()) == [(0, 0)]


def _cropped(figure: Figure) -> Figure:
    """The figure with limits that leave out the last points."""
    return replace(figure, axes=tuple(replace(axes, x_limits=(0.0, 1.19)) for axes in figure.axes))


def _outside(which: str) -> Drawing:
    """The hidden run drawn outside the limits, seen nowhere."""
    share = 0 if which == "nothing" else 30
    return Drawing((_cropped(_sighted(Sheet().figure, _sight(share, share))),))


class Limited(Plotted):
    """One whose drawing of the lab's own recording is known, too."""

    def __init__(self, drawing: Drawing, of_push: Drawing) -> None:
        super().__init__(drawing)
        self.of_push = of_push

    def plot(self, *, sheet: Mapping[str, Array], **_: Any) -> Drawing:  # type: ignore[override]
        return self.of_push if np.array_equal(sheet["time"], truth()["push"]["time"]) else self._drawing


def _of_lab(sight: VisibleParts, *channels: tuple[int, int]) -> Drawing:
    """The lab's own recording, with these channels seen so."""
    return Drawing((_sighted(Sheet("push").figure, sight, *channels),))


def test_curves_outside_the_limits_are_seen_where_these_are_chosen_for_the_labs_recording() -> None:
    assert _stopped(Limited(_outside("nothing"), Sheet("push").drawing())) == ""
    for of_push in (_of_lab(_sight(0, 0)), Drawing(())):
        assert _stopped(Limited(_outside("nothing"), of_push)) == "a figure with visible curves"
        assert _stopped(Limited(_outside("a part"), of_push)) == ""


def test_a_channel_that_the_labs_recording_does_not_show_is_cut_off_as_it_is_here() -> None:
    drawing = _outside("a part")
    plot = _plot(drawing.figures[0])
    first = replace(Sheet("push").figure, axes=Sheet("push").panels[:1])
    for of_push, cut in ((Drawing(()), CHANNELS), (Drawing((first,)), CHANNELS[3:])):
        assert tuple(measure._cut_off(Limited(drawing, of_push), truth(), plot)) == cut


_CHANCE = np.random.default_rng(3)


class Making(Plotted):
    """One whose plot makes its curves of what it is given."""

    def __init__(self, make: Any) -> None:
        super().__init__(Drawing(()))
        self._make = make

    def plot(self, *, data: Mapping[str, Array], **_: Any) -> Drawing:
        sheet = Sheet()
        curve = sheet.panels[0].curves[0]
        x, y = self._make(data["time"], data["acceleration"])
        return Drawing((replace(sheet.figure, axes=(replace(sheet.panels[0], curves=(replace(curve, x=x, y=y),)),)),))


@pytest.mark.parametrize(
    ("made_of_data", "make"),
    [
        (True, lambda t, a: (t, np.linalg.norm(a, axis=1))),
        (True, lambda t, a: (t, np.cumsum(a[:, 0]))),
        (True, lambda t, a: (np.arange(599), np.diff(a[:, 1]))),
        (False, lambda t, a: (t, _CHANCE.normal(size=len(t)))),
        (False, lambda t, a: (t, np.cumsum(_CHANCE.normal(size=len(t))))),
        (False, lambda t, a: (t, np.full(len(t), len(a)) + t)),
    ],
)
def test_a_plot_of_other_numbers_is_judged_if_they_are_made_of_the_data(made_of_data: bool, make: Any) -> None:
    assert (_stopped(Making(make)) == "") is made_of_data


# ---- panels and words ----


def _panel(position: tuple[float, float, float, float], *channels: tuple[int, int], **words: Any) -> Panel:
    axes = replace(Sheet().panels[0], position=position, **words)
    curve = axes.curves[0]
    return Panel(axes, tuple(Shown(sensor, axis, "", "time", curve) for sensor, axis in channels), ())


_LARGE, _SMALL, _OTHER = (0.0, 0.0, 1.0, 0.5), (0.6, 0.1, 0.9, 0.3), (0.0, 0.5, 1.0, 1.0)


def test_an_inset_needs_no_words_of_its_own_and_what_shows_no_data_no_title() -> None:
    accel, inset = _panel(_LARGE, (0, 0), (0, 1)), _panel(_SMALL, (0, 0))
    gyro, empty = _panel(_OTHER, (1, 0)), _panel(_OTHER)
    plot = Plot(Sheet().figure, [accel, inset, gyro, empty])
    assert plot.main_panels == [accel, gyro, empty]
    assert plot.titled_panels == [accel, gyro]
    assert Plot(Sheet().figure, [empty]).titled_panels == [empty]
