"""The checks of the extensions, on made-up filters of tilt, Allan deviations, readers of all IMUs and live plots."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.engine.findings import StudentError
from grader.labs.imu.bonuses import checks, multiple_imus
from grader.labs.imu.bonuses.live_plot import LiveRun
from grader.labs.imu.bonuses.multiple_imus import PLACES
from grader.labs.imu.student import Student
from tests.judging.fake_students import Case, FakeStudent, Marked, is_as_marked, truth

Row = tuple[Any, str, Any, Marked]
"""A check, what is made up, and how a fair marker marks it."""

# --- the complementary filter ---------------------------------------------------------------------------------------


class Tilt:
    """A sound filter, in steps that a faulty one changes."""

    alpha, gain, shift = 0.98, 1.0, 0.0

    def __init__(self, dt: float) -> None:
        self.dt = dt
        self.angles: Any = None

    def of_accel(self, x: float, y: float, z: float) -> tuple[float, float]:
        return math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))

    def rates(self, roll: float, pitch: float, p: float, q: float, r: float) -> tuple[float, float]:
        across = q * math.sin(roll) + r * math.cos(roll)
        return p + across * math.tan(pitch), q * math.cos(roll) - r * math.sin(roll)

    def update(self, accel: np.ndarray, gyro: np.ndarray) -> Any:
        held = self.of_accel(*accel.tolist())
        before = self.angles or held
        rates = self.rates(*before, *gyro.tolist())
        turned = [angle + self.gain * self.dt * rate for angle, rate in zip(before, rates, strict=True)]
        offs = [(angle - other + math.pi) % (2 * math.pi) - math.pi for angle, other in zip(held, turned, strict=True)]
        self.angles = tuple(angle + (1 - self.alpha) * off for angle, off in zip(turned, offs, strict=True))
        return tuple(angle + self.shift for angle in self.angles)


def _tilted(**steps: Any) -> type:
    return type("Other", (Tilt,), steps)


class Growing(Tilt):
    """One that goes further off with each update."""

    reads = 0

    def update(self, accel: np.ndarray, gyro: np.ndarray) -> Any:
        self.reads += 1
        roll, pitch = super().update(accel, gyro)
        return roll, pitch + 0.01 * self.reads


TILT: list[Row] = [
    (checks.check_returns_roll_and_pitch, "off by a turn", _tilted(shift=2 * math.pi), None),
    (checks.check_returns_roll_and_pitch, "a number", _tilted(update=lambda *_: 0.0), (0.0, ["wrong-return-type"])),
    (checks.check_returns_roll_and_pitch, "no numbers", _tilted(update=lambda *_: (math.nan, 0.0)), (0.0, ["not-finite"])),
    (checks.check_returns_roll_and_pitch, "a list without numbers", _tilted(update=lambda *_: [math.nan, 0.0]), (0.0, ["not-finite"])),
    (checks.check_settles_at_tilt, "further off with each update", Growing, (0.0, [])),
    (checks.check_settles_at_tilt, "raises", _tilted(update=lambda *_: 1 / 0), "raised"),
    (checks.check_settles_at_tilt, "no numbers", _tilted(update=lambda *_: (math.nan, 0.0)), "skipped"),
    (checks.check_beats_gyroscope_alone, "little else", _tilted(alpha=0.999), (0.5, [])),
    (checks.check_beats_accelerometer_alone, "more of it than is good", _tilted(alpha=0.7), (0.5, [])),
    (checks.check_holds_when_steep, "half the turn", _tilted(gain=0.5), (0.5, [])),
    (checks.check_holds_when_steep, "the gyroscope in degrees", _tilted(gain=math.degrees(1)), (0.0, [])),
]  # fmt: skip

# --- the Allan deviation --------------------------------------------------------------------------------------------


def deviation(samples: Any, rate: float) -> Any:
    """The sheet's, overlapping."""
    sizes = np.unique(np.geomspace(1, len(samples) // 2, 30).astype(int))
    sums = np.cumsum(np.concatenate([np.zeros_like(samples[:1]), samples]), axis=0)
    second = [sums[2 * m :] - 2 * sums[m:-m] + sums[: -2 * m] for m in sizes]
    return sizes / rate, np.array([np.sqrt(np.mean(s**2, axis=0) / 2) / m for s, m in zip(second, sizes, strict=True)])


def _changed(change: Callable[[Any, Any], Any]) -> Callable[[Any, float], Any]:
    return lambda samples, rate: change(*deviation(samples, rate))


def _same_for_all(samples: Any, rate: float) -> Any:
    if samples.ndim == 1:
        return deviation(samples, rate)
    taus, adev = deviation(samples[:, 0], rate)
    return taus, np.column_stack([adev] * 3)


def _raises(*_: Any) -> Any:
    raise RuntimeError("broken")


def _steeper(kind: str) -> Callable[[Any, float], Any]:
    """Another slope for one of the records."""

    def allan_deviation(samples: Any, rate: float) -> Any:
        taus, adev = deviation(samples, rate)
        return taus, adev * taus**0.4 if np.array_equal(samples, truth()["allan"][kind]) else adev

    return allan_deviation


def _some_unknown(taus: Any, adev: Any) -> Any:
    odd = np.arange(len(taus))
    return np.where(odd == 5, np.inf, taus), np.where((odd == 3) | (odd == 8), np.nan, adev)


ALLAN: list[Row] = [
    (checks.check_returns_times_and_deviations, "the deviations alone", lambda s, r: deviation(s, r)[1], (0.0, ["wrong-return-type"])),
    (checks.check_returns_times_and_deviations, "no numbers", _changed(lambda t, a: (t, a * np.nan)), (0.5, ["not-finite"])),
    (checks.check_returns_times_and_deviations, "raises", _raises, "raised"),
    (checks.check_averaging_times, "nothing", lambda *_: None, "skipped"),
    (checks.check_averaging_times, "beyond the record", _changed(lambda t, a: (t * 1.5, a)), (0.5, [])),
    (checks.check_averaging_times, "raises", _raises, "raised"),
    (checks.check_averaging_times, "four of them, each twice", lambda s, r: tuple(np.repeat(x[::9], 2) for x in deviation(s, r)), (0.5, [])),
    (checks.check_averaging_times, "four of them", lambda s, r: tuple(x[::9] for x in deviation(s, r)), (0.5, [])),
    (checks.check_matches_definition, "another curve", _changed(lambda t, a: (t, a * 1.3)), (0.0, [])),
    (checks.check_matches_definition, "wrong for long times", _changed(lambda t, a: (t, np.where(t > t[len(t) // 2], 3 * a, a))), (0.0, [])),
    (checks.check_matches_definition, "some that are no numbers", _changed(_some_unknown), None),
    (checks.check_shows_kinds_of_noise, "the variance", _changed(lambda t, a: (t, a**2)), (0.0, [])),
    *((checks.check_shows_kinds_of_noise, f"steeper for {kind} alone", _steeper(kind), (0.0, [])) for kind in ("walk", "quantised", "drift")),
    (checks.check_shows_kinds_of_noise, "short times alone", lambda s, r: tuple(x[:4] for x in deviation(s, r)), None),
    (checks.check_takes_three_axes, "the first for all", _same_for_all, (0.0, [])),
    (checks.check_takes_three_axes, "raises for more than one axis", lambda s, r: deviation(s, r) if s.ndim == 1 else _raises(), "raised"),
]  # fmt: skip

# --- many IMUs ------------------------------------------------------------------------------------------------------


def every(model: Any, data: Any) -> Any:
    """Every place of the model."""
    names = [model.sensor(i).name for i in range(model.nsensor)]
    places = [name.removesuffix("_accelerometer") for name in names if name.endswith("_accelerometer")]
    return {
        place: tuple(data.sensor(f"{place}_{kind}").data.copy() for kind in ("accelerometer", "gyroscope"))
        for place in places
        if f"{place}_gyroscope" in names
    }


def _changing(change: Callable[[str, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda model, data: {p: change(p, r) for p, r in every(model, data).items()}


def _elsewhere(other: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Sound in the lab's model, and another function in any other."""
    return lambda model, data: (every if "torso" in every(model, data) else other)(model, data)


def _at_second() -> Callable[[Any, Any], Any]:
    """Nothing on the first call for each model."""
    known: list[Any] = []

    def read_all_imus(model: Any, data: Any) -> Any:
        known.append(model)
        return every(model, data) if known.count(model) > 1 else {}

    return read_all_imus


IMUS: list[Row] = [
    (checks.check_finds_every_place, "a list", lambda m, d: list(every(m, d).values()), (0.0, ["wrong-return-type"])),
    (checks.check_finds_every_place, "all but one of another model", lambda m, d: {p: r for p, r in every(m, d).items() if p != "keel"}, (0.5, ["imu-missing"])),
    (checks.check_finds_every_place, "raises in another model", _elsewhere(_raises), "raised"),
    (checks.check_finds_every_place, "none at first", _at_second(), (0.0, ["imu-missing"])),
    (checks.check_matches_truth, "one of the lab", _changing(lambda p, r: r[::-1] if p == "head" else r), (0.0, [])),
    (checks.check_matches_truth, "the accelerometer alone", _changing(lambda _p, r: r[:1]), (0.0, [])),
    (checks.check_matches_truth, "raises in another model", _elsewhere(_raises), "raised"),
    (checks.check_matches_truth, "one of another model", _changing(lambda p, r: r[::-1] if p == "keel" else r), (0.5, [])),
    (checks.check_readings_are_copies, "no numbers", _changing(lambda _p, r: (r[0] * np.nan, r[1] * np.nan)), "skipped"),
]  # fmt: skip

# --- a plot that grows ----------------------------------------------------------------------------------------------


class Watched(FakeStudent):
    """A student whose live plot was seen."""

    def __init__(self, run: LiveRun) -> None:
        super().__init__(live_plot=None)
        self.run = run

    def answer(self, *_: Any) -> Any:
        return self.run


def _seen(
    moments: Any = (0.1, 0.3, 0.5, 0.7, 0.9),
    simulated: float = 1.0,
    curves: Any = None,
    error: StudentError | None = None,
) -> LiveRun:
    pushed = truth()["watched"]["pushed"]
    time = 0.004 * np.arange(1, len(pushed) + 1)
    shown = [(time, pushed[:, i]) for i in range(6)] if curves is None else curves
    events = np.array([(moment, 10.0 * n, n + 1.0) for n, moment in enumerate(moments)]).reshape(-1, 3)
    return LiveRun(events, tuple((np.array(x), np.array(y)) for x, y in shown), simulated, error)


_STEPS = 0.004 * np.arange(1, 101)
LIVE: list[Row] = [
    (checks.check_returns, "less", _seen(simulated=0.89), (0.5, [])),
    (checks.check_returns, "raises", _seen(error=StudentError("ValueError", "broken", None, None, None)), "raised"),
    (checks.check_grows_while_stepping, "three times", _seen((0.1, 0.4, 0.7)), (0.5, [])),
    (checks.check_grows_while_stepping, "once", _seen((0.5, 0.5)), (0.0, ["plot-not-live"])),
    (checks.check_grows_while_stepping, "at the end", _seen((0.5, 1.0, 1.0, 1.0, 1.0)), (0.0, [])),
    (checks.check_shows_true_data, "nothing", _seen(()), "skipped"),
    (checks.check_shows_true_data, "one that is right", _seen(curves=[(_STEPS, truth()["watched"]["pushed"][:100, 0]), *[(_STEPS, np.cos(_STEPS))] * 2]), (0.5, [])),
]  # fmt: skip


def _cases(rows: list[Row], student: Callable[[Any], Student], sound: Any) -> list[Case]:
    """Return a case for each row, and one of a sound part for each check."""
    all_sound: list[Row] = [(check, "sound", sound, None) for check in dict.fromkeys(check for check, *_ in rows)]
    return [
        Case(name, check, lambda part=part: student(part), marked)  # type: ignore[misc]
        for check, name, part, marked in [*all_sound, *rows]
    ]


CASES = [
    *_cases(TILT, lambda kind: FakeStudent(ComplementaryFilter=kind), Tilt),
    *_cases(ALLAN, lambda function: FakeStudent(allan_deviation=function), deviation),
    *_cases(IMUS, lambda function: FakeStudent(read_all_imus=function), every),
    *_cases(LIVE, Watched, _seen()),
]


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_extension_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)


@pytest.mark.quick
def test_where_another_robot_is_graded_on_the_labs_own_is_the_sheets() -> None:
    many = replace(truth()["reading_many"], name="reading_lab")
    scenarios = {**truth().scenarios, "reading_sheet": truth()["reading_lab"], "reading_lab": many}
    student = FakeStudent(read_all_imus=every)
    assert set(multiple_imus.measure(student, replace(truth(), scenarios=scenarios)).lab.read) == set(PLACES)
