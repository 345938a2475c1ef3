"""The checks of Visualization, on made-up figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.engine.figures import Axes, Curve, Entry, Figure, Picture, UnidentifiedPicture, VisibleParts
from grader.engine.findings import Fault
from grader.engine.load_report import Loaded, SteppedOver
from grader.labs.imu.answers import KEYS, Array, Collection, Drawing
from grader.labs.imu.student import Student
from grader.labs.imu.visualization import checks
from grader.labs.imu.visualization.measure import measure
from grader.sandbox.wire import Frame
from tests.judging.made import Case, Made, is_as_marked, truth

SAVES, PANELS, CURVES, LABELS, LEGEND, TITLES, COMPARISON = (
    checks.check_saves_image,
    checks.check_two_labelled_panels,
    checks.check_curves_match_data,
    checks.check_axis_labels_with_units,
    checks.check_legend_names_curves,
    checks.check_titles,
    checks.check_comparison_plot,
)
_COLOURS = ("#ff0000", "#00ff00", "#0000ff", "#888800", "#008888", "#880088")
_IN_FULL = VisibleParts(np.ones(100, bool), np.ones(100, bool))


class Plotted(Made):
    """A student of whom it is known what was drawn, and nothing else."""

    def __init__(
        self, drawing: Drawing, scripts: tuple[Drawing, ...] = (), pictures: Mapping[str, Picture | None] | None = None,
        broken: tuple[str, ...] = (), behind: tuple[Drawing, ...] = (),
    ) -> None:  # fmt: skip
        super().__init__(plot_imu_data=None)
        self._behind = behind
        self._drawing, self._scripts, self._pictures, self.broken = drawing, scripts, pictures or {}, set(broken)  # type: ignore[assignment, misc]

    def plot(self, *_: Any, **__: Any) -> Drawing:
        return self._drawing

    @contextmanager
    def without_standins(self) -> Iterator[dict[Any, Any]]:
        yield {}

    def scripts(self) -> Iterator[Drawing]:
        return iter(self._scripts)

    def stored_answer(self, called: str) -> Drawing:
        return self._drawing

    def replace_broken(self, names: Sequence[str]) -> None:
        self._scripts += self._behind

    def picture(self, name: str) -> Picture | None:
        return self._pictures.get(name)

    def simulate(self, *_: Any, **__: Any) -> Collection:
        series = {key: truth()["push"][key] for key in KEYS}
        return Collection(*series.values(), keys={key: key for key in KEYS})


class Imported(Made):
    """One whose file was imported, and whose statements ended so."""

    def __init__(self, *ends: str) -> None:
        super().__init__()
        faults = [Fault("NameError", how, "filters.py", line, None) for line, how in enumerate(ends, 7)]
        self._ends = tuple(
            SteppedOver("filters.py", fault.line or 0, fault.line or 0, fault.message, (), frozenset(), fault)
            for fault in faults
        )

    def load(self, path: str) -> Loaded:
        return replace(super().load(path), stepped_over=self._ends, frame=Frame({"figures": [], "strange": []}))


@pytest.mark.quick
@pytest.mark.parametrize(
    ("ends", "line"),
    [
        ((), None),
        (("raised",), 7),
        (("hints",), None),
        (("overran",), None),
        (("ended", "raised", "raised"), 8),
    ],
)
def test_a_statement_that_raised_while_a_file_was_imported_broke_off_what_it_draws(
    ends: tuple[str, ...], line: int | None
) -> None:
    drawing = Imported(*ends)._drawn_at_import("filters.py")
    assert drawing is not None
    assert (drawing.fault and drawing.fault.line) == line


class Sheet:
    """The sheet's figure of a run, which a case changes."""

    def __init__(self, run: str = "tumbling") -> None:
        series = truth()[run]
        self.time = series["time"]
        self.rows = (series["acceleration"], series["angular_velocity"])
        self.figure = _figure(
            self._axes(0, "Accelerometer", "Acceleration (m/s²)", ""),
            self._axes(1, "Gyroscope", "Angular velocity (rad/s)", "Time (s)"),
        )

    @property
    def panels(self) -> tuple[Axes, ...]:
        return self.figure.axes

    def says(self, **words: Any) -> None:
        """Change the figure."""
        self.figure = replace(self.figure, **words)

    def panel_says(self, which: int, **words: Any) -> None:
        """Change one of its panels."""
        panels = list(self.panels)
        panels[which] = replace(panels[which], **words)
        self.says(axes=tuple(panels))

    def _axes(self, sensor: int, title: str, ylabel: str, xlabel: str) -> Axes:
        curves = [
            _curve(self.time, self.rows[sensor][:, axis], "xyz"[axis], _COLOURS[3 * sensor + axis]) for axis in range(3)
        ]
        low = 0.5 - 0.45 * sensor
        place, limits = (0.1, low, 0.9, low + 0.4), ((0.0, 1.3), (-20.0, 20.0))
        axes = Axes(True, place, title, xlabel, ylabel, (), (), (), *limits, ("linear", "linear"), own_ticks=False)
        return _with_curves(axes, *curves)

    def drawing(self, *more: Figure) -> Drawing:
        return Drawing((self.figure, *more))


def _curve(x: Array, y: Array, label: str, colour: str) -> Curve:
    return Curve(label, colour, "line", len(y), x, y, "-", "None", "", 1.0, (f"{colour}ff",), 1.5, _IN_FULL)


def _with_curves(axes: Axes, *curves: Curve) -> Axes:
    """The panel with these curves, and with a legend of them."""
    return replace(
        axes, curves=curves, legend=tuple(Entry(c.label, c.colour, c.style, c.marker, c.stroke) for c in curves)
    )


def _figure(*axes: Axes) -> Figure:
    return Figure("saved", "imu_data.png", "png", (1000, 800), axes)


def drawn(change: Callable[[Sheet], Any] = lambda _sheet: None, **more: Any) -> Callable[[], Made]:
    """A student whose figure is the sheet's, but for what was changed."""

    def student() -> Made:
        sheet = Sheet()
        change(sheet)
        return Plotted(sheet.drawing(), **more)

    return student


def _with(**words: Any) -> Callable[[], Made]:
    return drawn(lambda sheet: sheet.says(**words))


def _unsaved(sheet: Sheet) -> None:
    sheet.says(event="shown")


def _panel(which: int, **words: Any) -> Callable[[], Made]:
    return drawn(_says(which, **words))


def _both(**words: Any) -> Callable[[], Made]:
    return drawn(_then(_says(0, **words), _says(1, **words)))


def _raising(sheet: Sheet) -> Drawing:
    return replace(sheet.drawing(), fault=Fault("ValueError", "broken", "imu_reader.py", 7, "plt.plot(x)"))


def _stopped_by_the_plot(*behind: Drawing) -> Callable[[], Made]:
    """A script that the plot stops: what it draws behind that is seen beside a stand-in alone."""
    stopped = _raising(Sheet())
    return lambda: Plotted(stopped, (replace(stopped, figures=()),), behind=behind)


def _broken_off() -> Student:
    sheet = Sheet()
    _unsaved(sheet)
    return Plotted(_raising(sheet))


def _nothing(**more: Any) -> Callable[[], Made]:
    return lambda: Plotted(Drawing(()), **more)


def _in_one_panel(sheet: Sheet) -> None:
    upper, lower = sheet.panels
    sheet.says(axes=(_with_curves(upper, *upper.curves, *lower.curves),))


def _without(*channels: tuple[int, int]) -> Callable[[Sheet], None]:
    def change(sheet: Sheet) -> None:
        for sensor, panel in enumerate(sheet.panels):
            left = (curve for axis, curve in enumerate(panel.curves) if (sensor, axis) not in channels)
            sheet.panel_says(sensor, curves=tuple(left))

    return change


def _curves(which: int, change: Callable[[Curve], Curve]) -> Callable[[Sheet], None]:
    return lambda sheet: sheet.panel_says(which, curves=tuple(map(change, sheet.panels[which].curves)))


def _values(sensor: int, value: Callable[[Array], Any]) -> Callable[[Sheet], None]:
    return _curves(sensor, lambda curve: replace(curve, y=value(curve.y)))


def _times(value: Callable[[Array], Any]) -> Callable[[Sheet], None]:
    return _then(*(_curves(which, lambda curve: replace(curve, x=value(curve.x))) for which in (0, 1)))


def _first_is_wrong(sheet: Sheet) -> None:
    first, *others = sheet.panels[0].curves
    sheet.panel_says(0, curves=(replace(first, y=np.cos(sheet.time)), *others))


_ALL = [(sensor, axis) for sensor in (0, 1) for axis in range(3)]


def _sights(channels: Iterable[tuple[int, int]], sight: VisibleParts) -> Callable[[Sheet], None]:
    """These channels are seen so, and the others in full."""
    chosen = set(channels)

    def change(sheet: Sheet) -> None:
        for sensor, panel in enumerate(sheet.panels):
            sheet.panel_says(sensor, curves=tuple(_seen_so(curve, sensor, chosen, sight) for curve in panel.curves))

    return change


def _seen_so(curve: Curve, sensor: int, chosen: set[tuple[int, int]], sight: VisibleParts) -> Curve:
    return replace(curve, visible_parts=sight) if (sensor, "xyz".index(curve.label)) in chosen else curve


def _unseen(*channels: tuple[int, int]) -> Callable[[Sheet], None]:
    """Drawn, and covered."""
    return _sights(channels, VisibleParts(np.ones(100, bool), np.zeros(100, bool)))


def _inside(channels: Iterable[tuple[int, int]], parts: slice) -> Callable[[Sheet], None]:
    """These parts alone lie within the limits of the axes."""
    mask = np.zeros(100, bool)
    mask[parts] = True
    return _then(_sights(channels, VisibleParts(mask, mask)), _says(0, x_limits=(0.0, 0.5)))


def _rows(channels: Iterable[tuple[int, int]], rows: slice) -> Callable[[Sheet], None]:
    """Of these channels these rows alone are drawn."""
    chosen = set(channels)

    def cut(curve: Curve, sensor: int) -> Curve:
        of_it = (sensor, "xyz".index(curve.label)) in chosen
        return replace(curve, x=curve.x[rows], y=curve.y[rows]) if of_it else curve

    def change(sheet: Sheet) -> None:
        for sensor, panel in enumerate(sheet.panels):
            sheet.panel_says(sensor, curves=tuple(cut(curve, sensor) for curve in panel.curves))

    return change


def _of_sensor_alone(sensor: int) -> Callable[[Sheet], None]:
    """Both panels take the curves of this sensor."""
    return lambda sheet: sheet.panel_says(1 - sensor, curves=sheet.panels[sensor].curves)


def _two_of_the_other(sheet: Sheet) -> None:
    (_, _, last), (first, second, _) = sheet.panels[1].curves, sheet.panels[0].curves
    sheet.panel_says(1, curves=(first, second, last))


def _inside_drawing() -> Drawing:
    sheet = Sheet()
    _inside(_ALL, slice(0, 40))(sheet)
    return sheet.drawing()


class Limited(Plotted):
    """One whose limits cut off these channels of the recording of the lab, and others of the data that the plot is given here."""

    def __init__(self, drawing: Drawing, *cut: tuple[int, int]) -> None:
        super().__init__(drawing)
        self._cut = cut

    def plot(self, *_: Any, called: str = "", **__: Any) -> Drawing:
        sheet = Sheet("push")
        _inside(self._cut, slice(0, 40))(sheet)
        return self._drawing if called else sheet.drawing()


def _cropped(sheet: Sheet) -> None:
    sheet.panel_says(0, y_limits=(-5.0, 5.0))


def _a_little_outside() -> Drawing:
    sheet = Sheet()
    _cropped(sheet)
    return sheet.drawing()


def _saved_over(first: tuple[int, ...], last: tuple[int, ...], path: str | None = "imu_data.png") -> Callable[[], Made]:
    """Panels that were saved into one file, and others that were saved over them."""

    def student() -> Made:
        panels, figure = Sheet().panels, Sheet().figure
        gone = replace(figure, event="overwritten", path=path, axes=tuple(panels[i] for i in first))
        kept = replace(figure, axes=tuple(panels[i] for i in last))
        return Plotted(Drawing((gone, kept)))

    return student


def _each_saved() -> Made:
    """A figure and a file for each sensor."""
    figure = Sheet().figure
    return Plotted(Drawing(tuple(replace(figure, axes=(panel,)) for panel in figure.axes)))


def _more_shown(*changes: Callable[[Sheet], Any]) -> Callable[[], Made]:
    """Figures that nobody saved, of which one shows most."""

    def student() -> Made:
        sheets = [Sheet() for _ in changes]
        for sheet, change in zip(sheets, changes, strict=True):
            _then(change, _unsaved)(sheet)
        return Plotted(Drawing(tuple(sheet.figure for sheet in sheets)))

    return student


def _overwritten(sheet: Sheet) -> None:
    sheet.says(event="overwritten")


def _broken(event: str, reason: str) -> Callable[[], Made]:
    """A figure that met this end, and a file that cannot be read for that reason; of a stray one there is none."""

    def student() -> Made:
        strays = (UnidentifiedPicture("whole.png", ""), UnidentifiedPicture(f"plots/\x07{'imu' * 30}.png", reason))
        return Plotted(Drawing((replace(Sheet().figure, event=event),), strange=strays))

    return student


def _then(*changes: Callable[[Sheet], Any]) -> Callable[[Sheet], None]:
    def change(sheet: Sheet) -> None:
        for each in changes:
            each(sheet)

    return change


def _says(which: int, **words: Any) -> Callable[[Sheet], None]:
    return lambda sheet: sheet.panel_says(which, **words)


def _legend(which: int, *names: str) -> Callable[[Sheet], None]:
    def change(sheet: Sheet) -> None:
        entries = zip(sheet.panels[which].legend, names, strict=True)
        sheet.panel_says(which, legend=tuple(replace(entry, text=name) for entry, name in entries))

    return change


def _one_legend(sheet: Sheet) -> None:
    sheet.says(legend=tuple(entry for panel in sheet.panels for entry in panel.legend))
    _then(_says(0, legend=()), _says(1, legend=()))(sheet)


def _exchanged(sheet: Sheet) -> None:
    upper, lower = sheet.panels
    sheet.says(axes=(_with_curves(upper, *lower.curves), _with_curves(lower, *upper.curves)))


def _untitled(**words: Any) -> Callable[[], Made]:
    """Panels without titles, in a figure that says something itself."""
    return drawn(_then(_says(0, title=""), _says(1, title=""), lambda sheet: sheet.says(**words)))


def _with_a_panel_of_lengths(sheet: Sheet) -> None:
    lengths = _curve(sheet.time, np.linalg.norm(sheet.rows[0], axis=1), "", "#123456")
    beside = replace(sheet.panels[0], title="", position=(0.92, 0.1, 0.99, 0.9), curves=(lengths,), legend=())
    sheet.says(axes=(*sheet.panels, beside))


def _smooth(x: np.ndarray) -> np.ndarray:
    y = x.copy()
    for n in range(1, len(y)):
        y[n] = 0.1 * x[n] + 0.9 * y[n - 1]
    return y


def _slow(x: np.ndarray) -> np.ndarray:
    """Smooth enough to tell from a series without noise."""
    return _smooth(_smooth(_smooth(x)))


def _compared(
    raw: str = "raw",
    smooth: str = "filtered",
    event: str = "saved",
    other: Callable[[np.ndarray], Any] = _smooth,
    noise: float = 1.0,
) -> Drawing:
    sheet = Sheet()
    noisy = sheet.rows[0][:, 0] + np.random.default_rng(1).normal(0, noise, len(sheet.time))
    curves = [
        _curve(sheet.time, noisy, raw, "#111111"),
        _curve(sheet.time, other(noisy), smooth, "#222222"),
    ]
    figure = _figure(_with_curves(sheet.panels[0], *curves))
    return Drawing((replace(figure, event=event, path="filtered_imu.png"),))


def _scripts(*drawings: Drawing, **more: Any) -> Callable[[], Made]:
    return lambda: Plotted(Drawing(()), scripts=drawings, **more)


_SEEN = Picture((800, 600), 0.2, np.zeros((60, 80), np.uint8), np.full((256, 3), 255, np.uint8))
PICTURE_HANDED_IN, _FILTERED = {"pictures": {"imu_data.png": _SEEN}}, {"pictures": {"filtered_imu.png": _SEEN}}
_STOPPED = replace(
    _compared(), figures=(), fault=Fault("RuntimeError", "broken", "filters.py", 3, None)
)  # fmt: skip
_NO_FILTER = ("LowPassFilter",)

CASES = [
    Case(name, check, student, marked)
    for check, rows in {
        SAVES: [
            ("sound", drawn(), None),
            ("too narrow", _with(size_px=(399, 800)), (0.5, ["low-resolution"])),
            ("just large enough", _with(size_px=(400, 250)), None),
            ("never saved", _with(event="shown"), (0.0, ["plot-not-saved"])),
            ("nothing drawn", _nothing(), (0.0, ["plot-not-saved"])),
            ("nothing drawn, a picture handed in", _nothing(**PICTURE_HANDED_IN), (0.5, [])),
            ("never saved, a picture handed in", drawn(_unsaved, **PICTURE_HANDED_IN), (0.0, ["plot-not-saved"])),
            ("blank", _with(axes=()), (0.0, ["blank-image"])),
            ("saved by a script", drawn(_unsaved, scripts=(Sheet().drawing(),)), None),
            ("another plot saved by a script", drawn(_unsaved, scripts=(_compared(),)), (0.0, ["plot-not-saved"])),
            ("broken off", _broken_off, "raised"),
            ("of a global", lambda: Plotted(replace(Sheet().drawing(), departs=("global imu_data",))), (0.0, ["global-for-parameter"])),
            ("by other parameters", lambda: Plotted(replace(Sheet().drawing(), departs=("imu_data", "title"))), (0.0, ["other-parameters"])),
            ("a second picture over the first", _saved_over((0,), (1,)), (0.0, ["picture-overwritten"])),
            ("the same picture twice", _saved_over((0, 1), (0, 1)), None),
            ("overwritten with something else", drawn(_overwritten), (0.0, ["picture-overwritten"])),
            ("a picture that is broken", _broken("overwritten", "cut short"), (0.0, ["picture-overwritten"])),
            ("a picture that is broken, beside a figure that is shown", _broken("shown", "cut short"), (0.0, ["plot-not-saved"])),
            ("a PDF", _with(format="pdf"), (0.8, [])),
        ],
        PANELS: [
            ("sound", drawn(), None),
            ("one panel for both", drawn(_in_one_panel), (0.0, ["one-panel"])),
            ("names exchanged", drawn(_exchanged), (0.0, ["panels-swapped"])),
            ("one label of the other", _panel(1, ylabel="Acceleration (m/s²)"), (0.5, ["panels-swapped"])),
            ("no gyroscope", drawn(lambda sheet: sheet.says(axes=sheet.panels[:1])), (0.0, [])),
            ("names that say nothing", drawn(_then(_says(0, title="Top", ylabel="a"), _says(1, title="Bottom", ylabel="b"))), (0.5, [])),
            ("axes of the gyroscope that stay empty", drawn(_then(_without((1, 0), (1, 1), (1, 2)))), None),
            ("empty axes that say nothing", drawn(_then(_without((1, 0), (1, 1), (1, 2)), _says(1, title="", ylabel="z"))), (0.0, [])),
            ("one title of the other", _panel(1, title="Accelerometer"), (0.5, ["panels-swapped"])),
            ("both of one of the other", _panel(0, title="Gyroscope", ylabel="rad/s"), (0.0, ["panels-swapped"])),
            ("a title of both", _panel(0, title="Acceleration and angular velocity"), None),
            ("a name in the legend", drawn(_then(_says(0, title="Top", ylabel="a"), _legend(0, "accel x", "accel y", "accel z"))), None),
            ("a name of the figure", drawn(_then(_says(0, title="Top", ylabel="a"), lambda s: s.says(title="Acceleration above"))), None),
            ("a title that says nothing, alone", _panel(0, title="Top", ylabel=" "), None),
            ("no words on one", _panel(0, title="", ylabel=""), (0.5, [])),
            ("titles alone", _both(ylabel=""), None),
        ],
        CURVES: [
            ("sound", drawn(), None),
            ("five of six", drawn(_without((0, 2))), (0.8333, ["curves-missing"])),
            ("three of six", drawn(_without((1, 0), (1, 1), (1, 2))), (0.5, ["curves-missing"])),
            ("one of them wrong", drawn(_first_is_wrong), (0.2, ["wrong-data-plotted"])),
            ("one behind another", drawn(_unseen((0, 1))), (0.8333, ["curves-not-seen"])),
            ("none to be seen", drawn(_unseen(*_ALL)), (0.0, ["curves-not-seen"])),
            ("the last part of all outside", drawn(_inside(_ALL, slice(0, 40))), (0.0, ["curves-not-seen"])),
            ("the first part of one outside", drawn(_inside([(0, 1)], slice(60, 100))), (0.2, ["curves-not-seen"])),
            ("half outside", drawn(_inside([(0, 0)], slice(0, 50))), None),
            ("outside, one behind another and one missing", drawn(_then(_inside([(0, 0)], slice(0, 45)), _unseen((0, 1)), _without((1, 2)))), (0.2, ["curves-missing", "curves-not-seen"])),
            ("outside, where the lab's own recording fits", lambda: Limited(_inside_drawing()), None),
            ("outside, as of the lab's own recording another one", lambda: Limited(_inside_drawing(), (0, 2)), (0.2, ["curves-not-seen"])),
            ("hardly outside, where the lab's own recording fits", lambda: Limited(_a_little_outside()), None),
            ("the last rows left out", drawn(_rows(_ALL, slice(None, -100))), (0.8, [])),
            ("the first rows left out", drawn(_rows(_ALL, slice(100, None))), (0.8, [])),
            ("the first half left out", drawn(_rows(_ALL, slice(300, None))), (0.5, [])),
            ("of one curve some rows", drawn(_rows([(1, 0)], slice(0, 300))), (0.9167, [])),
            ("accelerations in both panels", drawn(_of_sensor_alone(0)), (0.2, ["wrong-data-plotted"])),
            ("two columns of the other sensor", drawn(_two_of_the_other), (0.2, ["wrong-data-plotted"])),
            ("against milliseconds without a label", drawn(_then(_times(lambda t: 1000 * t), _says(1, xlabel=""))), None),
            ("g where the title names it", drawn(_then(_values(0, lambda a: a / 9.81), _says(0, ylabel="Acceleration", title="Acceleration (g)"))), None),
            ("a picture for each sensor", _each_saved, None),
            ("a figure that shows two channels, and one that hides six", _more_shown(_without((0, 0), (1, 0), (1, 1), (1, 2)), _unseen(*_ALL)), (0.3333, ["curves-missing"])),
            ("against the index", drawn(_times(lambda t: np.arange(len(t)))), (0.5, ["x-not-time"])),
            ("against milliseconds", drawn(_times(lambda t: 1000 * t)), (0.5, ["x-not-time"])),
            ("against milliseconds that are labelled", drawn(_then(_times(lambda t: 1000 * t), _says(1, xlabel="Time (ms)"))), None),
            ("g without a unit", drawn(_then(_values(0, lambda a: a / 9.81), _says(0, ylabel="Acceleration"))), (0.5, ["wrong-data-plotted"])),
            ("nothing drawn", _nothing(), "skipped"),
        ],
        LABELS: [
            ("sound", drawn(), None),
            ("none", _both(xlabel="", ylabel=""), (0.0, ["no-axis-labels"])),
            ("no time", _both(xlabel=""), (0.6667, ["no-axis-labels"])),
            ("no unit of two", drawn(_then(_says(0, ylabel="Acceleration"), _says(1, ylabel="Angular velocity"))), (0.3333, ["no-units"])),
            ("units in the titles", drawn(_then(_says(0, title="Acceleration (m/s²)", ylabel=""), _says(1, title="Angular velocity (rad/s)", ylabel=""))), None),
            ("no label of one", _panel(0, ylabel=" "), (0.6667, ["no-axis-labels"])),
            ("a unit in the legend", drawn(_then(_says(0, ylabel="Acceleration"), _legend(0, "x (m/s²)", "y (m/s²)", "z (m/s²)"))), None),
            ("a label of the whole figure", drawn(_then(_says(0, ylabel=""), lambda s: s.says(ylabel="Acceleration (m/s²)"))), None),
            ("time without a unit", _panel(1, xlabel="Time"), (0.6667, ["no-units"])),
            ("milliseconds on one of them", drawn(_then(_says(0, xlabel="Time (s)"), _says(1, xlabel="Time (ms)"))), None),
            ("milliseconds with own numbers", drawn(_then(_says(1, xlabel="Time (ms)", own_ticks=True))), None),
            ("milliseconds over seconds", _panel(1, xlabel="Time (ms)"), (0.6667, ["no-units"])),
            ("samples", drawn(_then(_times(lambda t: np.arange(len(t))), _says(1, xlabel="Sample"))), None),
            ("a label of the other sensor", _panel(1, ylabel="Acceleration (m/s²)"), None),
            ("for the whole figure", _with(xlabel="Time (s)"), None),
        ],
        LEGEND: [
            ("sound", drawn(), None),
            ("none", _both(legend=()), (0.0, ["no-legend"])),
            ("two names alike", drawn(_legend(0, "x", "x", "z")), (0.5, ["no-legend"])),
            ("in another order", drawn(_legend(0, "y", "x", "z")), (0.0, ["legend-order-wrong"])),
            ("names that say no axis", drawn(_legend(0, "one", "two", "three")), None),
            ("one for the figure", drawn(_one_legend), None),
        ],
        TITLES: [
            ("sound", drawn(), None),
            ("none", _both(title=""), (0.0, ["no-title"])),
            ("one of two", _panel(0, title=" "), (0.5, ["no-title"])),
            ("one for both", drawn(_then(_says(0, title="IMU readings"), _says(1, title=""))), None),
            ("one of its own sensor", drawn(_then(_says(0, title="Accelerometer"), _says(1, title=""))), (0.5, ["no-title"])),
            ("of the figure", _untitled(title="IMU"), None),
            ("in no file", drawn(_unsaved), "skipped"),
            ("in no file, a picture handed in", drawn(_unsaved, **PICTURE_HANDED_IN), None),
            ("a letter as a text", _untitled(texts=("ab",)), (0.0, ["no-title"])),
            ("a text of the figure", _untitled(texts=("IMU",)), None),
            ("another panel without, of other numbers", drawn(_with_a_panel_of_lengths), None),
        ],
        COMPARISON: [
            ("sound", _scripts(_compared()), None),
            ("not saved", _scripts(_compared(event="shown")), (0.5, ["comparison-missing"])),
            ("names exchanged", _scripts(_compared("filtered", "raw")), (0.5, ["legend-order-wrong"])),
            ("names that say nothing", _scripts(_compared("one", "two")), None),
            ("without noise", _scripts(_compared(noise=0.0, other=_slow)), (0.5, [])),
            ("none", _scripts(), (0.0, ["comparison-missing"])),
            ("a picture alone", _scripts(**_FILTERED), (0.5, ["comparison-missing"])),
            ("an unreadable picture", _scripts(pictures={"filtered_imu.png": None}), (0.0, ["comparison-missing"])),
            ("a tiny picture", _scripts(pictures={"filtered_imu.png": replace(_SEEN, size_px=(800, 149))}), (0.0, ["comparison-missing"])),
            ("the same twice", _scripts(_compared(other=np.array)), (0.0, ["comparison-wrong-data"])),
            ("another series", _scripts(_compared(other=lambda x: _slow(np.cos(x)), noise=0.1)), (0.0, ["comparison-wrong-data"])),
            ("another series by a filter that is charged", _scripts(_compared(other=np.cos), broken=_NO_FILTER), None),
            ("stopped before", _scripts(_STOPPED), (0.0, [])),
            ("stepped over on the way", _scripts(replace(_compared(), fault=_STOPPED.fault)), None),
            ("stopped by the plot, which is charged", _stopped_by_the_plot(_compared()), None),
            ("stopped by the plot, and nothing behind it", _stopped_by_the_plot(), (0.0, ["comparison-missing"])),
            ("stopped before, a picture handed in", _scripts(_STOPPED, **_FILTERED), (0.5, [])),
        ],
    }.items()
    for name, student, marked in rows
]  # fmt: skip


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_figure_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)


@pytest.mark.quick
def test_a_figure_that_is_not_meant_to_compare_is_not_described() -> None:
    panel = Sheet().panels[0]
    other = replace(_figure(_with_curves(panel, panel.curves[0])), path="a.png")
    for path, meant in (("a.png", (0, "")), ("b/filtered_imu.png", (1, "a plot with only one curve"))):
        student = Plotted(Drawing(()), (Drawing((replace(other, path=path),)),))
        assert measure(student, truth()).comparison.meant == meant
