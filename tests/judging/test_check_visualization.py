"""The checks of Visualization, on made-up figures."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.engine.figures import Axes, Curve, Entry, Figure, Picture, VisibleParts
from grader.engine.findings import StudentError
from grader.labs.imu.answers import Drawing
from grader.labs.imu.collection import KEYS, Collection
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization import checks
from tests.judging.fake_students import FakeStudent, Marked, Row, is_as_marked, truth

CHECKS = SAVES, PANELS, CURVES, LABELS, LEGEND, TITLES, COMPARISON = (
    checks.check_saves_image,
    checks.check_two_labelled_panels,
    checks.check_curves_match_data,
    checks.check_axis_labels_with_units,
    checks.check_legend_names_curves,
    checks.check_titles,
    checks.check_comparison_plot,
)
ACCEL, GYRO = [(0, 0), (0, 1), (0, 2)], [(1, 0), (1, 1), (1, 2)]
_COLOURS = ("#ff0000", "#00ff00", "#0000ff", "#888800", "#008888", "#880088")
Change = Callable[[Figure], Figure]


# --- the sheet's figure, and changes of it -------------------------------------------------------------------------------


def curve(x: Array, y: Array, label: str, colour: str) -> Curve:
    return Curve(label, colour, "line", len(y), x, y, "-", "None", "", 1.0, (f"{colour}ff",), 1.5, visible())


def visible(inside: slice = slice(None), seen: slice = slice(None)) -> VisibleParts:
    """Return what is seen of a curve of which these hundredths lie within the limits, and these are not covered."""
    parts = np.arange(100)
    within = np.isin(parts, parts[inside])
    return VisibleParts(within, within & np.isin(parts, parts[seen]))


def with_curves(axes: Axes, *curves: Curve) -> Axes:
    """Return the panel with these curves, and with a legend of them."""
    legend = tuple(Entry(c.label, c.colour, c.style, c.marker, c.stroke) for c in curves)
    return replace(axes, curves=curves, legend=legend)


def figure_of(*axes: Axes) -> Figure:
    return Figure("saved", "imu_data.png", "png", (1000, 800), axes)


def sheet_figure(run: str = "tumbling") -> Figure:
    """Return the sheet's figure of a run."""
    time, *sensors = (truth()[run][key] for key in KEYS)
    words = ("Accelerometer", "", "Acceleration (m/s²)"), ("Gyroscope", "Time (s)", "Angular velocity (rad/s)")
    panels = []
    for sensor, rows in enumerate(sensors):
        low = 0.5 - 0.45 * sensor
        place, limits = (0.1, low, 0.9, low + 0.4), ((0.0, 1.3), (-20.0, 20.0))
        axes = Axes(True, place, *words[sensor], (), (), (), *limits, ("linear", "linear"), own_ticks=False)
        drawn = (curve(time, rows[:, axis], "xyz"[axis], _COLOURS[3 * sensor + axis]) for axis in range(3))
        panels.append(with_curves(axes, *drawn))
    return figure_of(*panels)


SHEET = sheet_figure()
TIME = SHEET.axes[0].curves[0].x


def says(**words: Any) -> Change:
    """Change the figure."""
    return lambda figure: replace(figure, **words)


def panel(which: int, **words: Any) -> Change:
    """Change one of its panels."""
    return lambda figure: replace(
        figure, axes=tuple(replace(axes, **words) if n == which else axes for n, axes in enumerate(figure.axes))
    )


def each_curve(change: Callable[[Curve], Curve | None], *channels: tuple[int, int]) -> Change:
    """Change the curves of these channels, or all; None leaves a curve out."""

    def with_all(figure: Figure) -> Figure:
        for sensor, axes in enumerate(figure.axes):
            drawn = (
                change(curve) if not channels or (sensor, "xyz".index(curve.label)) in channels else curve
                for curve in axes.curves
            )
            figure = panel(sensor, curves=tuple(curve for curve in drawn if curve is not None))(figure)
        return figure

    return with_all


def seen(what: VisibleParts, *channels: tuple[int, int]) -> Change:
    return each_curve(lambda curve: replace(curve, visible_parts=what), *channels)


def showing(*panels: Sequence[tuple[int, int]]) -> Change:
    """Show these channels in the panels, each with a legend of its own."""

    def shown(figure: Figure) -> Figure:
        drawn = [[figure.axes[sensor].curves[axis] for sensor, axis in channels] for channels in panels]
        return replace(
            figure, axes=tuple(with_curves(axes, *its) for axes, its in zip(figure.axes, drawn, strict=False))
        )

    return shown


def beside(panel_of: Callable[[Figure], Axes]) -> Change:
    """Add a panel."""
    return lambda figure: replace(figure, axes=(*figure.axes, panel_of(figure)))


def changed(*changes: Change, run: str = "tumbling") -> Figure:
    return functools.reduce(lambda figure, change: change(figure), changes, sheet_figure(run))


# --- raw and filtered ----------------------------------------------------------------------------------------------------


def smooth(x: Array) -> Array:
    y = x.copy()
    for n in range(1, len(y)):
        y[n] = 0.1 * x[n] + 0.9 * y[n - 1]
    return y


def slow(x: Array) -> Array:
    """Smooth enough to tell from a series without noise."""
    return smooth(smooth(smooth(x)))


def compared(
    *names: str, event: str = "saved", other: Callable[[Array], Array] = smooth, noise: float = 1.0
) -> Drawing:
    """Return what a script draws of a noisy series and another one that is made of it."""
    noisy = SHEET.axes[0].curves[0].y + np.random.default_rng(1).normal(0, noise, len(TIME))
    raw, filtered = names or ("raw", "filtered")
    curves = curve(TIME, noisy, raw, "#111111"), curve(TIME, other(noisy), filtered, "#222222")
    return Drawing((replace(figure_of(with_curves(SHEET.axes[0], *curves)), event=event, path="filtered_imu.png"),))


SOUND_SCRIPT = compared()
STOPPED = Drawing((), StudentError("RuntimeError", "broken", "filters.py", 3, None))
_BROKEN = StudentError("ValueError", "broken", "imu_reader.py", 7, "plt.plot(x)")
_PICTURE = Picture((800, 600), 0.2, np.zeros((60, 80), np.uint8), np.full((256, 3), 255, np.uint8))


# --- students ------------------------------------------------------------------------------------------------------------


class Plotted(FakeStudent):
    """A student of whom it is known what was drawn: of the tumbling run, of the lab's own, and by scripts beside a stand-in."""

    def __init__(
        self, drawing: Drawing, scripts: Sequence[Drawing] = (SOUND_SCRIPT,), pictures: Mapping[str, Picture | None] | None = None,
        broken: Sequence[str] = (), of_push: Drawing | None = None,
    ) -> None:  # fmt: skip
        super().__init__(plot_imu_data=None)
        self._drawing, self._of_push, self._scripts = drawing, of_push, scripts
        self._pictures, self.broken = pictures or {}, set(broken)  # type: ignore[misc]

    def plot(self, *, sheet: Mapping[str, Array], **_: Any) -> Drawing:  # type: ignore[override]
        of_push = self._of_push is not None and np.array_equal(sheet["time"], truth()["push"]["time"])
        return self._of_push if of_push else self._drawing  # type: ignore[return-value]

    @contextmanager
    def without_standins(self) -> Iterator[dict[Any, Any]]:
        yield {}

    def scripts(self) -> Iterator[Drawing]:
        return iter(self._scripts)

    def stored_answer(self, called: str) -> Drawing:
        return self._drawing

    def replace_broken(self, names: Sequence[str]) -> None:
        """Do nothing: what is drawn is known."""

    def picture(self, name: str) -> Picture | None:
        return self._pictures.get(name)

    def simulate(self, *_: Any, **__: Any) -> Collection:
        time, *sensors = (truth()["push"][key] for key in KEYS)
        return Collection(time, *sensors, keys={key: key for key in KEYS})


class Making(Plotted):
    """A student whose plot draws one curve, made of what it is given."""

    def __init__(self, make: Callable[[Array, Array], tuple[Array, Array]]) -> None:
        super().__init__(Drawing(()))
        self._make = make

    def plot(self, *, data: Mapping[str, Array], **_: Any) -> Drawing:  # type: ignore[override]
        made = curve(*self._make(data["time"], data["acceleration"]), "x", "#ff0000")
        return Drawing((figure_of(replace(SHEET.axes[0], curves=(made,))),))


Kind = tuple[str, Callable[[], FakeStudent], Mapping[Any, Marked]]
"""A name, a student, and the checks that a fair marker does not pass."""


def drawn(name: str, marks: Mapping[Any, Marked], *changes: Change, **more: Any) -> Kind:
    """A student whose figure is the sheet's, but for these changes."""
    return name, lambda: Plotted(Drawing((changed(*changes),)), **(of_push(*changes) | more)), marks


def figures(name: str, marks: Mapping[Any, Marked], *shown: Figure, **more: Any) -> Kind:
    return name, lambda: Plotted(Drawing(shown), **more), marks


def scripts(name: str, mark: Marked, *drawings: Drawing, **more: Any) -> Kind:
    """A student with the sheet's figure whose scripts draw these."""
    return name, lambda: Plotted(Drawing((SHEET,)), drawings, **more), {COMPARISON: mark}


# --- what a fair marker says ---------------------------------------------------------------------------------------------

_NOT_READ: dict[Any, Marked] = dict.fromkeys((PANELS, LABELS, LEGEND, TITLES), "skipped")
"""Where no curve is to be seen nothing else is read."""
_UPPER = SHEET.axes[0]
_LENGTHS = curve(TIME, np.linalg.norm([c.y for c in _UPPER.curves], axis=0), "", "#123456")


def alone(which: int, **words: Any) -> Figure:
    """Return a figure of one panel."""
    return replace(SHEET, axes=(SHEET.axes[which],), **words)


def of_push(*changes: Change) -> dict[str, Drawing]:
    """The figure of the lab's own recording."""
    return {"of_push": Drawing((changed(*changes, run="push"),))}


KINDS: list[Kind] = [
    drawn("sound", {}),
    # the file
    drawn("too narrow", {SAVES: (0.5, ["low-resolution"])}, says(size_px=(399, 800))),
    drawn("a PDF", {SAVES: (0.8, [])}, says(format="pdf")),
    drawn("never saved, a picture handed in", {SAVES: (0.0, ["plot-not-saved"])}, says(event="shown"), pictures={"imu_data.png": _PICTURE}),
    figures("nothing drawn, a picture handed in", {SAVES: (0.5, []), PANELS: (0.0, []), CURVES: (0.0, []), LABELS: (0.0, []), LEGEND: (0.0, []), TITLES: (0.0, [])}, pictures={"imu_data.png": _PICTURE}),
    drawn("blank", {**_NOT_READ, SAVES: (0.0, ["blank-image"]), CURVES: "skipped"}, says(axes=())),
    figures("nothing drawn", {**_NOT_READ, SAVES: (0.0, ["plot-not-saved"]), CURVES: "skipped"}),
    ("broken off before it", lambda: Plotted(Drawing((), _BROKEN)), dict.fromkeys((SAVES, PANELS, CURVES, LABELS, LEGEND, TITLES), "raised")),
    figures("a second picture over the first", {SAVES: (0.5, ["picture-overwritten"])}, alone(0, event="overwritten"), alone(1)),
    figures("two figures, of which one shows two channels and one hides six", {SAVES: (0.0, ["plot-not-saved"]), CURVES: (0.3333, ["curves-missing"]), TITLES: (0.0, ["plot-not-saved"])}, changed(each_curve(lambda _: None, (0, 0), *GYRO), says(event="shown")), changed(seen(visible(seen=slice(0))), says(event="shown"))),
    # the panels
    drawn("names exchanged", {PANELS: (0.0, ["panels-swapped"])}, showing(GYRO, ACCEL)),
    drawn("one panel for both", {PANELS: (0.0, ["one-panel"]), LABELS: (0.3333, ["no-axis-labels", "no-units"]), LEGEND: (0.0, ["no-legend"])}, showing(ACCEL + GYRO)),
    drawn("one title of the other", {PANELS: (0.5, ["panels-swapped"])}, panel(1, title="Accelerometer")),
    drawn("no gyroscope", {PANELS: (0.0, []), CURVES: (0.5, ["curves-missing"])}, says(axes=(_UPPER,))),
    drawn("names that say nothing", {PANELS: (0.5, []), LABELS: (0.3333, ["no-units"])}, panel(0, title="Top", ylabel="a"), panel(1, title="Bottom", ylabel="b")),
    drawn("a title of both", {}, panel(0, title="Acceleration and angular velocity")),
    drawn("no words on one", {PANELS: (0.5, []), LABELS: (0.6667, ["no-axis-labels"]), TITLES: (0.5, ["no-title"])}, panel(0, title="", ylabel="")),
    # the curves
    drawn("one of them wrong", {CURVES: (0.5, ["wrong-data-plotted"])}, each_curve(lambda c: replace(c, y=np.cos(c.y)), (0, 0))),
    drawn("two columns of the other sensor", {PANELS: (0.0, ["one-panel"]), CURVES: (0.5, ["wrong-data-plotted"])}, showing(ACCEL, [*ACCEL[:2], GYRO[2]])),
    drawn("the first part of one outside", {CURVES: (0.2, ["curves-not-seen"])}, seen(visible(slice(60, 100)), (0, 1))),
    drawn("inside by limits of its own, that leave out the lab's own recording", {CURVES: (0.0, ["curves-not-seen"])}, panel(0, own_height=True), **of_push(seen(visible(slice(0, 40))))),
    drawn("the last rows left out", {CURVES: (0.8, [])}, each_curve(lambda c: replace(c, x=c.x[:-100], y=c.y[:-100]))),
    drawn("none to be seen", {**_NOT_READ, CURVES: (0.0, ["curves-not-seen"])}, seen(visible(seen=slice(0)))),
    drawn("half outside", {}, seen(visible(slice(0, 50)), (0, 0))),
    drawn("outside, one behind another and one missing", {CURVES: (0.0333, ["curves-missing", "curves-not-seen"])}, seen(visible(slice(0, 45)), (0, 0)), seen(visible(seen=slice(0)), (0, 1)), each_curve(lambda _: None, (1, 2))),
    drawn("of one curve some rows", {CURVES: (0.9167, [])}, each_curve(lambda c: replace(c, x=c.x[:300], y=c.y[:300]), (1, 0))),
    drawn("g without a unit", {CURVES: (0.0, ["wrong-data-plotted"]), LABELS: (0.6667, ["no-units"])}, each_curve(lambda c: replace(c, y=c.y / 9.81), *ACCEL), panel(0, ylabel="Acceleration")),
    drawn("another label over what is recorded", {CURVES: (0.0, ["wrong-data-plotted"])}, panel(0, ylabel="Acceleration (g)")),
    ("sums of the data", lambda: Making(lambda t, a: (t, np.cumsum(a[:, 0]))), {PANELS: (0.0, []), CURVES: (0.0, ["wrong-data-plotted"])}),
    ("noise", lambda: Making(lambda t, _: (t, np.random.default_rng(3).normal(size=len(t)))), {**_NOT_READ, CURVES: (0.0, ["wrong-data-plotted"])}),
    # the axes
    drawn("against the index", {CURVES: (0.0, ["x-not-time"])}, each_curve(lambda c: replace(c, x=np.arange(len(c.x))))),
    drawn("against milliseconds without a label", {LABELS: (0.6667, ["no-axis-labels"])}, each_curve(lambda c: replace(c, x=1000 * c.x)), panel(1, xlabel="")),
    drawn("no unit of the time", {LABELS: (0.6667, ["no-units"])}, panel(1, xlabel="Time")),
    drawn("milliseconds over seconds", {LABELS: (0.6667, ["no-units"])}, panel(1, xlabel="Time (ms)")),
    drawn("units in the titles", {}, panel(0, title="Acceleration (m/s²)", ylabel=""), panel(1, title="Angular velocity (rad/s)", ylabel="")),
    # names and titles
    drawn("names in another order", {LEGEND: (0.0, ["legend-order-wrong"])}, panel(0, legend=tuple(replace(e, text=t) for e, t in zip(_UPPER.legend, "yxz", strict=True)))),
    drawn("a panel of lengths without a title", {}, beside(lambda _: replace(_UPPER, title="", position=(0.92, 0.1, 0.99, 0.9), curves=(_LENGTHS,), legend=()))),
    drawn("an inset without words", {}, beside(lambda _: replace(_UPPER, title="", ylabel="", position=(0.6, 0.8, 0.8, 0.88), curves=_UPPER.curves[:2], legend=()))),
    # raw and filtered
    scripts("no comparison", (0.0, ["comparison-missing"])),
    scripts("compared, not saved", (0.5, ["comparison-missing"]), compared(event="shown")),
    scripts("names exchanged in the comparison", (0.5, ["legend-order-wrong"]), compared("filtered", "raw")),
    scripts("compared without noise", (0.5, []), compared(noise=0.0, other=slow)),
    scripts("the same twice in a comparison", (0.0, ["comparison-wrong-data"]), compared(other=np.array)),
    scripts("another series by a filter that is charged", None, compared(other=np.cos), broken=("LowPassFilter",)),
    scripts("a script that stops before its comparison", (0.0, []), STOPPED),
]  # fmt: skip
ROWS = [Row(*kind) for kind in KINDS]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_figure_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))
