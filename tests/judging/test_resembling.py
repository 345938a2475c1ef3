"""For which sensor a curve may be taken, by curves of true channels in whatever unit and over whatever axis."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.figures import Curve, Sight
from grader.labs.imu.answers import KEYS, Array
from grader.labs.imu.diagnosis.channel_match import sensors_of
from tests.judging.made import truth

pytestmark = pytest.mark.quick
SERIES, PUSH = ({key: truth()[run][key] for key in KEYS} for run in ("tumbling", "push"))
TIME, RATE, ACCEL = SERIES["time"], SERIES["angular_velocity"], SERIES["acceleration"]


def curve(x: Array, y: Array) -> Curve:
    seen = Sight(np.ones(100, bool), np.ones(100, bool))
    return Curve("", "#000000", "line", len(y), x, y, "-", "None", "", 1.0, (), 1.5, seen)


def noise(size: float) -> Array:
    return np.random.default_rng(3).normal(0, size, size=len(TIME))


Y = RATE[:, 1] / 10
CURVES: dict[str, tuple[Array, Array, set[int]]] = {
    "as it is": (TIME, Y, {1}),
    "in other units, without an offset, over milliseconds": (1000 * TIME, 4 - 57.3 * Y, {1}),
    "over an axis of its own": (TIME / 60, Y, {1}),
    "over an axis of its own that begins elsewhere": (TIME / 60 - 7, Y, {1}),
    "with noise, so that it may be the other one": (TIME, Y + noise(0.1), {0, 1}),
    "of noise alone": (TIME, noise(0.2), set()),
    "at rest": (TIME, np.full_like(Y, 9.81), set()),
    "at zero": (TIME, np.zeros_like(Y), set()),
    "at rest but for the last digit": (TIME, 9.81 + 1e-12 * Y, set()),
    "at rest below zero but for the last digit": (TIME, -9.81 + 1e-12 * Y, set()),
    "beyond all numbers": (1e308 * TIME, 1e308 * Y, {1}),
    "of the other sensor": (TIME, ACCEL[:, 0], {0}),
    "of the third axis": (TIME, ACCEL[:, 2], {0}),
    "over the time from the start": (TIME - TIME[0], ACCEL[:, 1], {0}),
    "over the samples": (np.arange(len(TIME), dtype=float), ACCEL[:, 1], {0}),
    "over some of the samples": (np.arange(100.0, 300.0), ACCEL[100:300, 1], {0}),
    "over some of the samples, and beyond them": (np.arange(100.0, 900.0), np.append(ACCEL[100:, 1], np.arange(300) % 7), {0}),
    "a part of it": (TIME[100:300], ACCEL[100:300, 1], {0}),
    "a part of it, over milliseconds": (1000 * TIME[100:300], ACCEL[100:300, 1], {0}),
    "a part of it, over the time from the start": ((TIME - TIME[0])[100:300], ACCEL[100:300, 1], {0}),
    "below zero": (TIME, Y - Y.max(), {1}),
    **{f"axis {axis} of the acceleration, upside down": (TIME, -ACCEL[:, axis], {0}) for axis in range(3)},
    **{f"axis {axis} of the rate, upside down": (TIME, -RATE[:, axis], {1}) for axis in range(3)},
    "over one moment": (np.ones_like(TIME), ACCEL[:, 1], set()),
    "over moments beyond all numbers": (np.where(TIME > 1, 1e308, -1e308), ACCEL[:, 1], set()),
    "of three points": (TIME[:3], ACCEL[:3, 1], set()),
    "of four points": (TIME[:400:100], 5 - ACCEL[:400:100, 1], {0, 1}),
    "of no points": (TIME[:0], Y[:0], set()),
    "of points that are not all drawn": (TIME, np.where(TIME > 0.6, np.nan, ACCEL[:, 1]), {0}),
    "of many points": (np.linspace(TIME[0], TIME[-1], 9000), np.interp(np.linspace(TIME[0], TIME[-1], 9000), TIME, Y), {1}),
}  # fmt: skip


@pytest.mark.parametrize(("x", "y", "sensors"), CURVES.values(), ids=CURVES)
def test_a_curve_is_taken_for_whatever_sensor_it_may_show(x: Array, y: Array, sensors: set[int]) -> None:
    assert sensors_of(curve(x, y), [SERIES]) == sensors


def test_a_recording_of_an_unusual_length_counts_over_an_axis_without_a_scale() -> None:
    short = {key: rows[:400] for key, rows in SERIES.items()}
    for axis in range(3):
        assert sensors_of(curve(TIME[:400] / 60 - 1, ACCEL[:400, axis]), [short]) == {0}
        assert sensors_of(curve(TIME[:400] / 60 - 1, RATE[:400, axis]), [short]) == {1}


def _like_the_rate(size: float) -> dict[str, Array]:
    """A recording whose acceleration is much like its angular velocity."""
    return {**SERIES, "acceleration": RATE + size * ACCEL / 50}


@pytest.mark.parametrize(("points", "sensors"), [(600, {1}), (60, {1}), (50, {1}), (49, {0, 1}), (20, {0, 1})])
def test_of_few_points_the_other_sensor_may_be_meant_as_well(points: int, sensors: set[int]) -> None:
    every = np.linspace(0, len(TIME) - 1, points).round().astype(int)
    assert sensors_of(curve(TIME[every], Y[every]), [_like_the_rate(5.0)]) == sensors


@pytest.mark.parametrize("runs", [[SERIES, PUSH], [PUSH, SERIES]])
def test_a_curve_of_any_recording_counts(runs: list[dict[str, Array]]) -> None:
    other = sensors_of(curve(PUSH["time"], PUSH["acceleration"][:, 2]), runs)
    assert other == {0}
    assert sensors_of(curve(TIME, Y), runs) == {1}


@pytest.mark.parametrize("seconds", [5.0, 3.0, 10.0, 2.0, 1.2])
def test_a_recording_of_a_usual_length_counts_by_its_first_moments(seconds: float) -> None:
    """Over an axis without a scale, and of a motion that is known in its first 1.2 s alone."""
    stamps = PUSH["time"][0] + np.linspace(0, seconds, 1000)
    y = np.interp(stamps, PUSH["time"], PUSH["angular_velocity"][:, 0]) + 0.1 * np.maximum(stamps - 1.2, 0)
    assert 1 in sensors_of(curve(np.linspace(-3, 4, 1000), y), [PUSH])
