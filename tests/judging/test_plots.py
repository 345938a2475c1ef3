"""Which channel a curve shows, and under which name: by figures that are made by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Axes, Curve, Entry, Placed
from grader.labs.imu.collection import KEYS
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization import curves as plots
from grader.labs.imu.visualization.curves import Panel, Shown
from tests.judging.fake_students import truth
from tests.judging.test_check_visualization import SHEET, changed, curve, figure_of, panel, says, visible, with_curves

pytestmark = pytest.mark.quick
SERIES = {key: truth()["tumbling"][key] for key in KEYS}
TIME, ACCEL, RATE = (SERIES[key] for key in KEYS)
RESTING = SERIES | {"acceleration": ACCEL / 50 + np.array([0, 0, 9.81])}
UPPER, LOWER = SHEET.axes


def panel_of(*curves: Curve, series: dict[str, Array] = SERIES, **words: object) -> Panel | None:
    found = plots.panels(figure_of(replace(with_curves(UPPER, *curves), **words)), series)  # type: ignore[arg-type]
    return found[0] if found else None


def shown(x: Array, y: Array, series: dict[str, Array] = SERIES) -> Shown | None:
    panel = panel_of(curve(x, y, "a", "#ff0000"), series=series)
    return panel.shown[0] if panel is not None and panel.shown else None


# --- channels ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(
    ("sensor", "unit", "scale"),
    [
        (0, "m/s²", 1.0), (0, "cm/s²", 100.0), (0, "g", 1 / 9.81), (0, "g", 1 / 9.80665), (0, "mg", 1000 / 9.81),
        (0, "mg", 1000 / 9.80665), (1, "rad/s", 1.0), (1, "mrad/s", 1000.0), (1, "deg/s", 180 / np.pi),
    ],
)  # fmt: skip
@pytest.mark.parametrize("series", [SERIES, RESTING], ids=["moving", "at rest"])
def test_a_channel_is_known_in_any_of_its_units(
    series: dict[str, Array], sensor: int, unit: str, scale: float, axis: int
) -> None:
    found = shown(TIME, scale * series[KEYS[1 + sensor]][:, axis], series)
    assert found is not None
    assert (found.channel, found.unit, found.x) == ((sensor, axis), unit, "s")
    assert unit in plots.UNITS[sensor]


ROWS = np.arange(float(len(TIME)))
Z, ALL = ACCEL[:, 2], range(100)
ABSCISSAE: dict[str, tuple[Array, Array, str | None, range]] = {
    "milliseconds": (1e3 * TIME, Z, "ms", ALL),
    "microseconds": (1e6 * TIME, Z, "us", ALL),
    "nanoseconds": (1e9 * TIME, Z, "ns", ALL),
    "days": (20_000 + TIME / 86_400, Z, "date", ALL),
    "from the start": (TIME - TIME[0], Z, "s from start", ALL),
    "rows": (ROWS, Z, "index", ALL),
    "every third row, by its number": (ROWS[::3], Z[::3], "index", ALL),
    "some rows, counted": (ROWS[:200], np.interp(np.linspace(0, ROWS[-1], 200), ROWS, Z), "index", ALL),
    "fifty moments": (TIME[:: len(TIME) // 50][:50], Z[:: len(TIME) // 50][:50], "s", range(98)),
    "a half, backwards": (1e3 * TIME[450:149:-1], Z[450:149:-1], "ms", range(25, 75)),
    "half of the rows": (ROWS[:300], Z[:300], "index", range(50)),
    "a twelfth of the time": (TIME[:60], Z[:60], "s", range(10)),
    "all rows over half of the time": (TIME / 2, Z, None, ALL),
    "late by ten steps": (TIME + 0.02, Z, None, ALL),
    "forty-nine moments": (TIME[:: len(TIME) // 49][:49], Z[:: len(TIME) // 49][:49], None, ALL),
}


@pytest.mark.parametrize(("x", "y", "kind", "drawn"), ABSCISSAE.values(), ids=ABSCISSAE)
def test_a_channel_is_known_over_any_measure_of_the_recorded_time(
    x: Array, y: Array, kind: str | None, drawn: range
) -> None:
    found = shown(x, y)
    assert (found and (found.x, found.drawn)) == (kind and (kind, drawn))


@pytest.mark.parametrize(
    ("change", "known"),
    [
        (lambda y: y + 0.9e-3 * np.ptp(y), True),
        (lambda y: y + 1.1e-3 * np.ptp(y), False),
        (lambda y: y + np.where(np.arange(len(y)) == 9, 0.1, 0), False),
    ],
)
def test_a_curve_is_a_channel_within_a_thousandth_of_its_range(change: Callable[[Array], Array], known: bool) -> None:
    assert (shown(TIME, change(RATE[:, 1])) is not None) is known
    assert (shown(TIME, np.degrees(change(RATE[:, 1]))) is not None) is known


# --- panels --------------------------------------------------------------------------------------------------------------

X, Y, RATE_X = UPPER.curves[0], UPPER.curves[1], LOWER.curves[0]
ODD = curve(TIME, np.cos(TIME), "odd", "#888888")
FLAT = curve(TIME, np.full(len(TIME), 9.81), "g", "#888888")
UNSEEN = visible(seen=slice(0))


def test_a_panel_holds_channels_strange_curves_and_hidden_channels() -> None:
    hidden = replace(Y, visible_parts=UNSEEN)
    panel = panel_of(X, ODD, hidden, FLAT, replace(ODD, visible_parts=UNSEEN), replace(RATE_X, kind="nothing"))
    assert panel is not None
    assert panel.shown == (Shown(0, 0, "m/s²", "s", X),)
    assert [s.curve for s in panel.hidden] == [hidden]
    assert panel.strange == (ODD,)
    assert (panel.channels, panel.sensors, panel.mainly) == ({(0, 0)}, {0}, {0})


@pytest.mark.parametrize(
    ("curves", "mainly"),
    [
        ((FLAT,), None), ((), None), ((ODD,), set()), ((replace(X, visible_parts=UNSEEN),), set()), ((RATE_X,), {1}),
        ((X, Y, RATE_X), {0}), ((X, RATE_X), {0, 1}),
    ],
)  # fmt: skip
def test_a_panel_is_of_the_sensor_that_most_of_its_curves_show(
    curves: Sequence[Curve], mainly: set[int] | None
) -> None:
    panel = panel_of(*curves)
    assert (panel and panel.mainly) == mainly
    assert panel_of(*curves, visible=False) is None


SMALL, LARGE = (0.5, 0.5, 0.8, 0.7), (0.1, 0.5, 0.9, 0.9)


@pytest.mark.parametrize(
    ("curves", "position", "inset"),
    [
        ((X,), SMALL, True), ((X, Y), SMALL, True), ((X, RATE_X), SMALL, False), ((ODD,), SMALL, False),
        ((X,), (0.1, 0.5, 0.9, 0.69), True), ((X,), (0.1, 0.5, 0.9, 0.71), False), ((X,), LARGE, False),
    ],
)  # fmt: skip
def test_what_shows_the_same_and_is_less_than_half_as_large_is_an_inset(
    curves: Sequence[Curve], position: tuple[float, float, float, float], inset: bool
) -> None:
    large, small = panel_of(X, Y, position=LARGE), panel_of(*curves, position=position)
    assert large is not None
    assert small is not None
    assert small.is_inset_of(large) is inset


def test_figures_that_are_joined_keep_their_words_and_their_places() -> None:
    entry = Entry("x", "#ff0000", "-", "None", "")
    first = changed(says(title="Upper", xlabel="t", ylabel="a", texts=("one",), legend=(entry,)))
    second = changed(says(texts=("two",), title="Lower"), panel(0, title="", ylabel="", xlabel=""))
    joined = plots.joined([first, second])
    assert [axes.title for axes in joined.axes] == ["Accelerometer", "Gyroscope", "Lower", "Gyroscope"]
    assert [axes.xlabel for axes in joined.axes] == ["t", "Time (s)", "", "Time (s)"]
    assert joined.axes[2].ylabel == ""
    assert (joined.title, joined.xlabel, joined.ylabel, joined.legend) == ("", "", "", ())
    assert joined.texts == ("one", "two")
    assert [axes.legend[-1] == entry for axes in joined.axes] == [True, True, False, False]
    assert len(joined.axes[0].legend) == 4
    own = [axes.position for axes in SHEET.axes]
    assert [axes.position for axes in joined.axes] == [*own, *(tuple(1 + share for share in place) for place in own)]


# --- names ---------------------------------------------------------------------------------------------------------------


def sample(text: str, curve: Curve, **other: str) -> Entry:
    return replace(Entry(text, curve.colour, curve.style, curve.marker, curve.stroke), **other)  # type: ignore[arg-type]


SAMPLES: dict[str, tuple[list[Entry], list[Placed], str | None]] = {
    "the first of two alike": ([sample("x", X), sample("again", X)], [], "x"),
    "by its style": ([sample("dashed", X, style="--"), sample("x", X)], [], "x"),
    "by its marker": ([sample("dots", X, marker="o"), sample("x", X)], [], "x"),
    "the likest, though it is not alike": ([sample("dashed", X, style="--", stroke="3")], [], "dashed"),
    "one without words": ([sample(" ", X), sample("_line0", X), sample("x", X)], [], "x"),
    "a text of its colour": ([], [Placed(" ", (0, 0), X.colour), Placed("red", (0, 0), X.colour)], "red"),
}


@pytest.mark.parametrize(("entries", "texts", "name"), SAMPLES.values(), ids=SAMPLES)
def test_a_curve_is_named_by_what_looks_like_it(entries: list[Entry], texts: list[Placed], name: str | None) -> None:
    assert plots.name_of(X, entries, texts) == name


def named(*legend: Entry, texts: Sequence[Placed] = (), beside: Sequence[Axes] = (), figures: Sequence[Entry] = ()) -> list[str | None]:  # fmt: skip
    axes = replace(with_curves(UPPER, X, Y), legend=legend, texts=texts)
    figure = replace(figure_of(axes, *beside), legend=tuple(figures))
    return plots.names_of(plots.panels(figure, SERIES)[0], figure)


def test_legends_of_the_panel_of_the_figure_and_of_a_twin_and_texts_among_the_curves_name_them() -> None:
    ex, why, twin = sample("ex", X), sample("why", Y), replace(UPPER, legend=(sample("why", Y),), curves=())
    assert named(ex, why) == ["ex", "why"]
    assert named(ex, figures=[why]) == ["ex", "why"]
    assert named(ex, beside=[twin]) == ["ex", "why"]
    assert named(ex, beside=[replace(LOWER, legend=twin.legend)]) == ["ex", None]
    other, text = Placed("nothing", (0, 0), "#000000"), Placed("x", (0, 0), "#000000")
    assert named(texts=(other, text)) == ["x", None]
    assert named(texts=(replace(text, colour=Y.colour),)) == [None, "x"]


@pytest.mark.parametrize(
    ("sensor", "factor", "unit"),
    [(0, 1.0, "m/s²"), (0, 1.09, "m/s²"), (0, 1.11, ""), (0, 1 / 9.81, "g"), (1, 180 / np.pi, "deg/s")],
)
def test_a_recording_is_in_the_unit_in_which_it_is_as_large_as_the_truth(sensor: int, factor: float, unit: str) -> None:
    true = SERIES[KEYS[1 + sensor]]
    assert plots.unit_in(factor * true, true, sensor) == unit
