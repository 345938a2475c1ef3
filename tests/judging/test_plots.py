"""Which channel a curve shows, and under which name: by figures that are made by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Axes, Curve, Entry, Figure, Placed, VisibleParts
from grader.labs.imu.answers import KEYS, Array
from grader.labs.imu.visualization import curves as plots
from grader.labs.imu.visualization.curves import Panel, Shown
from tests.judging.made import truth
from tests.judging.test_check_visualization import Sheet, _curve, _figure, _with_curves

pytestmark = pytest.mark.quick
SERIES = {key: truth()["tumbling"][key] for key in KEYS}
TIME, ACCEL, RATE = (SERIES[key] for key in KEYS)
UNSEEN = VisibleParts(np.ones(100, bool), np.zeros(100, bool))
Change = Callable[[Array], Array]


def panel_of(*curves: Curve, **words: object) -> Panel | None:
    found = plots.panels(_figure(replace(_with_curves(Sheet().panels[0], *curves), **words)), SERIES)  # type: ignore[arg-type]
    return found[0] if found else None


def shown(x: Array, y: Array) -> Shown | None:
    panel = panel_of(_curve(x, y, "a", "#ff0000"))
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
def test_a_channel_is_known_in_any_of_its_units(sensor: int, unit: str, scale: float, axis: int) -> None:
    found = shown(TIME, scale * (ACCEL, RATE)[sensor][:, axis])
    assert found is not None
    assert (found.channel, found.unit, found.x) == ((sensor, axis), unit, "s")
    assert unit in plots.UNITS[sensor]


@pytest.mark.parametrize("gravity", [9.81, 9.80665])
@pytest.mark.parametrize(("unit", "scale"), [("g", 1.0), ("mg", 1000.0)])
def test_of_a_robot_that_hardly_moves_gravity_may_be_any_of_two_numbers(
    gravity: float, unit: str, scale: float
) -> None:
    resting = SERIES | {"acceleration": ACCEL / 50 + np.array([0, 0, 9.81])}
    drawn = _curve(TIME, resting["acceleration"][:, 2] / gravity * scale, "z", "#ff0000")
    (panel,) = plots.panels(_figure(_with_curves(Sheet().panels[0], drawn)), resting)
    assert [(found.channel, found.unit) for found in panel.shown] == [((0, 2), unit)]


ROWS = np.arange(float(len(TIME)))
ABSCISSAE: dict[str, tuple[Array, Array, str | None]] = {
    "milliseconds": (1000 * TIME, ACCEL, "ms"),
    "from the start": (TIME - TIME[0], ACCEL, "s from start"),
    "rows": (ROWS, ACCEL, "index"),
    "every third row, by its number": (ROWS[::3], ACCEL[::3], "index"),
    "some rows, counted": (
        ROWS[:200],
        np.repeat(np.interp(np.linspace(0, ROWS[-1], 200), ROWS, ACCEL[:, 2])[:, None], 3, 1),
        "index",
    ),
    "fifty moments": (TIME[:: len(TIME) // 50][:50], ACCEL[:: len(TIME) // 50][:50], "s"),
    "half of the time": (TIME[:300], ACCEL[:300], "s"),
    "half of the rows": (ROWS[:300], ACCEL[:300], "index"),
    "a twelfth of the time": (TIME[:60], ACCEL[:60], "s"),
    "a moment": (np.full(60, TIME[9]), np.repeat(ACCEL[9:10], 60, 0), None),
    "the other half of the time": (TIME[:300], ACCEL[300:], None),
    "every other row over half of the time": (TIME[:300], ACCEL[::2], None),
    "all rows over half of the time": (TIME / 2, ACCEL, None),
    "minutes": (TIME / 60, ACCEL, None),
    "late by ten steps": (TIME + 0.02, ACCEL, None),
    "forty-nine moments": (TIME[:: len(TIME) // 49][:49], ACCEL[:: len(TIME) // 49][:49], None),
}


@pytest.mark.parametrize(("x", "y", "kind"), ABSCISSAE.values(), ids=ABSCISSAE)
def test_a_channel_is_known_over_any_measure_of_the_recorded_time(x: Array, y: Array, kind: str | None) -> None:
    found = shown(x, y[:, 2])
    assert (found and found.x) == kind


@pytest.mark.parametrize(
    ("change", "known"),
    [
        (lambda y: y + 0.9e-3 * np.ptp(y), True),
        (lambda y: y + 1.1e-3 * np.ptp(y), False),
        (lambda y: y + np.where(np.arange(len(y)) == 9, 0.1, 0), False),
        (np.negative, False),
        (lambda y: y.astype(np.float32).astype(float), True),
    ],
)
def test_a_curve_is_a_channel_within_a_thousandth_of_its_range(change: Change, known: bool) -> None:
    assert (shown(TIME, change(RATE[:, 1])) is not None) is known
    assert (shown(TIME, np.degrees(change(RATE[:, 1]))) is not None) is known


@pytest.mark.parametrize("start", [0.0, 5.0])
@pytest.mark.parametrize(("origin", "kind"), [(0.0, "s"), (5.0, "s from start")])
def test_a_recording_may_start_at_any_moment(start: float, origin: float, kind: str) -> None:
    late = SERIES | {"time": TIME - TIME[0] + start}
    drawn = _curve(late["time"] - min(origin, start), ACCEL[:, 2], "z", "#ff0000")
    (panel,) = plots.panels(_figure(_with_curves(Sheet().panels[0], drawn)), late)
    assert [(found.channel, found.x) for found in panel.shown] == [((0, 2), kind if start else "s")]


def test_a_channel_that_never_moves_is_known_by_its_value() -> None:
    resting = SERIES | {"acceleration": np.tile([0.0, 0.0, 9.81], (len(TIME), 1))}
    drawn = _curve(TIME, resting["acceleration"][:, 2], "z", "#ff0000")
    (panel,) = plots.panels(_figure(_with_curves(Sheet().panels[0], drawn, ODD)), resting)
    assert [found.channel for found in panel.shown] == [(0, 2)]


@pytest.mark.parametrize(
    ("rows", "part"),
    [
        (slice(None), range(100)),
        (slice(0, 300), range(50)),
        (slice(300, 600), range(50, 100)),
        (slice(450, 149, -1), range(25, 75)),
    ],
)
@pytest.mark.parametrize("axis", [1000 * TIME, TIME, ROWS, TIME - TIME[0]])
def test_a_curve_shows_a_part_of_the_recording(rows: slice, part: range, axis: Array) -> None:
    found = shown(axis[rows], RATE[rows, 1])
    assert found is not None
    assert found.drawn == part


# --- panels --------------------------------------------------------------------------------------------------------------

X, Y, RATE_X = (_curve(TIME, y, name, colour) for y, name, colour in (
    (ACCEL[:, 0], "x", "#ff0000"), (ACCEL[:, 1], "y", "#00ff00"), (RATE[:, 0], "wx", "#0000ff"),
))  # fmt: skip
ODD = _curve(TIME, np.cos(TIME), "odd", "#888888")
FLAT = _curve(TIME, np.full(len(TIME), 9.81), "g", "#888888")


def test_a_panel_holds_channels_strange_curves_and_hidden_channels() -> None:
    hidden = replace(Y, visible_parts=UNSEEN)
    panel = panel_of(X, ODD, hidden, FLAT, replace(ODD, visible_parts=UNSEEN), replace(RATE_X, kind="nothing"))
    assert panel is not None
    assert panel.shown == (Shown(0, 0, "m/s²", "s", X),)
    assert [s.curve for s in panel.hidden] == [hidden]
    assert panel.strange == (ODD,)
    assert (panel.channels, panel.sensors, panel.mainly) == ({(0, 0)}, {0}, {0})


def test_a_channel_that_hides_itself_is_shown() -> None:
    panel = panel_of(X, replace(X, visible_parts=UNSEEN))
    assert panel is not None
    assert (len(panel.shown), panel.hidden) == (2, ())


@pytest.mark.parametrize(
    ("curves", "there"), [((FLAT,), False), ((), False), ((ODD,), True), ((replace(X, visible_parts=UNSEEN),), True), ((X,), True)]
)  # fmt: skip
def test_axes_with_no_curve_of_data_are_no_panel(curves: tuple[Curve, ...], there: bool) -> None:
    assert (panel_of(*curves) is not None) is there
    assert panel_of(*curves, visible=False) is None


@pytest.mark.parametrize(
    ("curves", "mainly"),
    [((X, Y, RATE_X), {0}), ((X, RATE_X), {0, 1}), ((RATE_X,), {1}), ((ODD,), set())],
)
def test_a_panel_is_of_the_sensor_that_most_of_its_curves_show(curves: tuple[Curve, ...], mainly: set[int]) -> None:
    panel = panel_of(*curves)
    assert panel is not None
    assert panel.mainly == mainly


@pytest.mark.parametrize(
    ("curves", "position", "inset"),
    [
        ((X,), (0.5, 0.5, 0.8, 0.7), True),
        ((X, Y), (0.5, 0.5, 0.8, 0.7), True),
        ((X, RATE_X), (0.5, 0.5, 0.8, 0.7), False),
        ((ODD,), (0.5, 0.5, 0.8, 0.7), False),
        ((X,), (0.1, 0.5, 0.9, 0.69), True),
        ((X,), (0.1, 0.5, 0.9, 0.71), False),
        ((X,), (0.1, 0.5, 0.9, 0.9), False),
    ],
)
def test_what_shows_the_same_and_is_less_than_half_as_large_is_an_inset(
    curves: tuple[Curve, ...], position: tuple[float, float, float, float], inset: bool
) -> None:
    large, small = panel_of(X, Y, position=(0.1, 0.5, 0.9, 0.9)), panel_of(*curves, position=position)
    assert large is not None
    assert small is not None
    assert large.area == pytest.approx(0.32)
    assert small.is_inset_of(large) is inset


def test_figures_that_are_joined_keep_their_words_and_their_places() -> None:
    first, second = Sheet(), Sheet()
    entry = Entry("x", "#ff0000", "-", "None", "")
    first.says(title="Upper", xlabel="t", ylabel="a", texts=("one",), legend=(entry,))
    second.says(texts=("two",), title="Lower")
    second.panel_says(0, title="", ylabel="", xlabel="")
    joined = plots.joined([first.figure, second.figure])
    assert [axes.title for axes in joined.axes] == ["Accelerometer", "Gyroscope", "Lower", "Gyroscope"]
    assert [axes.xlabel for axes in joined.axes] == ["t", "Time (s)", "", "Time (s)"]
    assert joined.axes[2].ylabel == ""
    assert (joined.title, joined.xlabel, joined.ylabel, joined.legend) == ("", "", "", ())
    assert joined.texts == ("one", "two")
    assert [axes.legend[-1] == entry for axes in joined.axes] == [True, True, False, False]
    assert len(joined.axes[0].legend) == 4
    own = [axes.position for axes in first.panels]
    assert [axes.position for axes in joined.axes] == [*own, *(tuple(1 + share for share in place) for place in own)]


# --- names ---------------------------------------------------------------------------------------------------------------


def sample(text: str, curve: Curve, **other: str) -> Entry:
    return replace(Entry(text, curve.colour, curve.style, curve.marker, curve.stroke), **other)  # type: ignore[arg-type]


SAMPLES: dict[str, tuple[list[Entry], list[Placed], str | None]] = {
    "its own": ([sample("y", Y), sample("x", X)], [], "x"),
    "of another colour": ([sample("y", Y)], [], None),
    "the first of two alike": ([sample("x", X), sample("again", X)], [], "x"),
    "by its style": ([sample("dashed", X, style="--"), sample("x", X)], [], "x"),
    "by its marker": ([sample("dots", X, marker="o"), sample("x", X)], [], "x"),
    "the likest, though it is not alike": ([sample("dashed", X, style="--", stroke="3")], [], "dashed"),
    "one without words": ([sample(" ", X), sample("_line0", X), sample("x", X)], [], "x"),
    "a text of its colour": ([], [Placed(" ", (0, 0), X.colour), Placed("red", (0, 0), X.colour)], "red"),
    "a text of another colour": ([], [Placed("green", (0, 0), Y.colour)], None),
    "a sample before a text": ([sample("x", X)], [Placed("red", (0, 0), X.colour)], "x"),
}


@pytest.mark.parametrize(("entries", "texts", "name"), SAMPLES.values(), ids=SAMPLES)
def test_a_curve_is_named_by_what_looks_like_it(entries: list[Entry], texts: list[Placed], name: str | None) -> None:
    assert plots.name_of(X, entries, texts) == name


def named(*texts: Placed, legend: tuple[Entry, ...] = (), beside: Axes | None = None, figures: tuple[Entry, ...] = ()) -> list[str | None]:  # fmt: skip
    axes = replace(_with_curves(Sheet().panels[0], X, Y), legend=legend, texts=texts)
    figure: Figure = replace(_figure(axes, *([beside] if beside else [])), legend=figures)
    return plots.names_of(plots.panels(figure, SERIES)[0], figure)


def test_legends_of_the_panel_of_the_figure_and_of_a_twin_name_curves() -> None:
    lower, twin = Sheet().panels[1], replace(Sheet().panels[0], legend=(sample("why", Y),), curves=())
    assert named(legend=(sample("ex", X), sample("why", Y))) == ["ex", "why"]
    assert named(legend=(sample("ex", X),), figures=(sample("why", Y),)) == ["ex", "why"]
    assert named(legend=(sample("ex", X),), beside=twin) == ["ex", "why"]
    assert named(legend=(sample("ex", X),), beside=replace(lower, legend=twin.legend)) == ["ex", None]


def test_a_text_beside_a_curve_names_it_by_its_axis() -> None:
    other, text = Placed("nothing", (0, 0), "#000000"), Placed("x", (0, 0), "#000000")
    assert named(other, text) == ["x", None]
    assert named(replace(text, colour=Y.colour)) == [None, "x"]


@pytest.mark.parametrize(
    ("kind", "x"),
    [
        ("s", lambda t: t),
        ("ms", lambda t: 1e3 * t),
        ("us", lambda t: 1e6 * t),
        ("ns", lambda t: 1e9 * t),
        ("date", lambda t: 20_000 + t / 86_400),
    ],
)
def test_time_may_be_drawn_in_other_units_and_as_dates(kind: str, x: Callable[[Array], Array]) -> None:
    panel = Sheet().panels[0]
    drawn = replace(panel, curves=tuple(replace(curve, x=x(curve.x)) for curve in panel.curves))
    series = {key: truth()["tumbling"][key] for key in KEYS}
    (found,) = plots.panels(replace(Sheet().figure, axes=(drawn,)), series)
    assert {shown.x for shown in found.shown} == {kind}
    assert len(found.shown) == 3


@pytest.mark.parametrize(
    ("sensor", "factor", "unit"),
    [
        (0, 1.0, "m/s²"),
        (0, 1.09, "m/s²"),
        (0, 1.11, ""),
        (0, 1 / 9.81, "g"),
        (1, 180 / np.pi, "deg/s"),
    ],
)
def test_a_recording_is_in_the_unit_in_which_it_is_as_large_as_the_truth(sensor: int, factor: float, unit: str) -> None:
    true = SERIES[("acceleration", "angular_velocity")[sensor]]
    assert plots.unit_in(factor * true, true, sensor) == unit
