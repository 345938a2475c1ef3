"""The checks of the extensions, on made-up filters of tilt, Allan deviations, readers of all IMUs and live plots."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from grader.engine.findings import Fault
from grader.labs.imu.bonuses import checks, complementary_filter, multiple_imus
from grader.labs.imu.bonuses.complementary_filter import RIDES
from grader.labs.imu.bonuses.live_plot import LiveRun
from grader.labs.imu.bonuses.multiple_imus import PLACES
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame
from tests.judging.fake_students import Case, FakeStudent, Marked, is_as_marked, truth

Row = tuple[str, Any, Marked]

# --- the complementary filter ---------------------------------------------------------------------------------------


class Tilt:
    """A sound filter, in steps that a faulty one changes."""

    alpha, gain, shift = 0.98, 1.0, 0.0

    def __init__(self, dt: float) -> None:
        self.dt = dt
        self.angles: Any = None

    def of_accel(self, accel: np.ndarray) -> np.ndarray:
        x, y, z = accel
        return np.array([math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))])

    def turned(self, gyro: np.ndarray) -> np.ndarray:
        roll, pitch = self.angles
        p, q, r = gyro
        across = q * math.sin(roll) + r * math.cos(roll)
        return np.array([p + across * math.tan(pitch), q * math.cos(roll) - r * math.sin(roll)])

    def update(self, accel: np.ndarray, gyro: np.ndarray) -> Any:
        held = self.of_accel(accel)
        if self.angles is None:
            self.angles = held
        turned = self.angles + self.gain * self.dt * self.turned(gyro)
        off = (held - turned + np.pi) % (2 * np.pi) - np.pi
        self.angles = turned + (1 - self.alpha) * off
        return tuple(self.angles + self.shift)


def _tilted(**steps: Any) -> type:
    return type("Other", (Tilt,), steps)


_DEGREES = {"update": lambda s, a, g: tuple(np.degrees(Tilt.update(s, a, g)))}


def _off_at_first(self: Any, accel: Any, gyro: Any) -> Any:
    at_first = self.angles is None
    roll, pitch = Tilt.update(self, accel, gyro)
    return (roll, pitch + 0.5) if at_first else (roll, pitch)


class Growing(Tilt):
    """One that goes further off with each update."""

    reads = 0

    def update(self, accel: np.ndarray, gyro: np.ndarray) -> Any:
        self.reads += 1
        roll, pitch = super().update(accel, gyro)
        return roll, pitch + 0.01 * self.reads


def _own_time_step(self: Any, dt: float) -> None:
    Tilt.__init__(self, 0.01)


TILT: list[tuple[Any, list[Row]]] = [
    (checks.check_returns_roll_and_pitch, [
        ("off by a degree", _tilted(shift=math.radians(1)), (0.0, [])),
        ("off by a turn", _tilted(shift=2 * math.pi), None),
        ("the pitch off at first", _tilted(update=_off_at_first), (0.0, [])),
        ("a list without numbers", _tilted(update=lambda *_: [math.nan, 0.0]), (0.0, ["not-finite"])),
        ("a number", _tilted(update=lambda *_: 0.0), (0.0, ["wrong-return-type"])),
        ("no numbers", _tilted(update=lambda *_: (math.nan, 0.0)), (0.0, ["not-finite"])),
        ("raises", _tilted(update=lambda *_: 1 / 0), "raised"),
    ]),
    (checks.check_settles_at_tilt, [
        ("never", _tilted(alpha=1.0), (0.0, ["gyro-only"])),
        ("further off with each update", Growing, (0.0, [])),
        ("in degrees", _tilted(**_DEGREES), (0.0, ["degrees-not-radians"])),
        ("pitch of the other sign", _tilted(of_accel=lambda s, a: Tilt.of_accel(s, a) * [1, -1]), (0.0, ["tilt-sign-wrong"])),
        ("off by two degrees", _tilted(shift=math.radians(2)), (0.0, [])),
        ("off by a turn", _tilted(shift=2 * math.pi), None),
        ("raises", _tilted(update=lambda *_: 1 / 0), "raised"),
        ("hardly anything of it", _tilted(alpha=0.9999), (0.0, [])),
        ("no numbers", _tilted(update=lambda *_: (math.nan, 0.0)), "skipped"),
    ]),
    (checks.check_beats_gyroscope_alone, [
        ("the gyroscope alone", _tilted(alpha=1.0), (0.0, ["gyro-only"])),
        ("little else", _tilted(alpha=0.999), (0.5, [])),
        ("no numbers", _tilted(update=lambda *_: (math.nan, 0.0)), "skipped"),
    ]),
    (checks.check_beats_accelerometer_alone, [
        ("without the gyroscope", _tilted(gain=0.0), (0.0, ["accel-only"])),
        ("weights exchanged", _tilted(alpha=0.02), (0.0, ["weights-swapped"])),
        ("more of it than is good", _tilted(alpha=0.7), (0.5, [])),
        ("a time step of its own", _tilted(__init__=_own_time_step), None),
    ]),
    (checks.check_holds_when_steep, [
        ("the gyroscope in degrees", _tilted(gain=math.degrees(1)), (0.0, [])),
        ("the accelerometer alone", _tilted(alpha=0.0), (0.0, ["accel-only"])),
        ("half the turn", _tilted(gain=0.5), (0.5, [])),
        ("a time step of its own", _tilted(__init__=_own_time_step), (0.5, [])),
    ]),
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


def _one_axis(samples: Any, rate: float) -> Any:
    return deviation(samples if samples.ndim == 1 else samples[:, 0], rate)


def _same_for_all(samples: Any, rate: float) -> Any:
    if samples.ndim == 1:
        return deviation(samples, rate)
    taus, adev = deviation(samples[:, 0], rate)
    return taus, np.column_stack([adev] * 3)


def _detrended(samples: Any, rate: float) -> Any:
    t = np.arange(len(samples), dtype=float)
    if samples.ndim == 1 and abs(np.corrcoef(t, samples)[0, 1]) > 0.99:
        samples = samples - np.polyval(np.polyfit(t, samples, 1), t) + 1e-6 * (-1) ** t  # rounding differs by machine
    return deviation(samples, rate)


def _spread(samples: Any, rate: float) -> Any:
    sizes = np.unique(np.geomspace(1, len(samples) // 4, 30).astype(int))
    means = [samples[: len(samples) // m * m].reshape(-1, m).mean(axis=1) for m in sizes]
    return sizes / rate, np.array([mean.std() for mean in means])


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


def _raises_for_axes(samples: Any, rate: float) -> Any:
    return deviation(samples, rate) if samples.ndim == 1 else _raises()


def _a_little_more_for_axes(samples: Any, rate: float) -> Any:
    taus, adev = deviation(samples, rate)
    return taus, adev * (1 if samples.ndim == 1 else 1 + 1e-7)


def _fewer_for_axes(samples: Any, rate: float) -> Any:
    step = 1 if samples.ndim == 1 else 2
    return tuple(part[::step] for part in deviation(samples, rate))


ALLAN: list[tuple[Any, list[Row]]] = [
    (checks.check_returns_times_and_deviations, [
        ("the deviations alone", lambda s, r: deviation(s, r)[1], (0.0, ["wrong-return-type"])),
        ("one that is no number", _changed(lambda t, a: (t, np.where(np.arange(len(a)) == 3, np.nan, a))), (0.5, ["not-finite"])),
        ("raises", _raises, "raised"),
    ]),
    (checks.check_averaging_times, [
        ("four of them, each twice", lambda s, r: tuple(np.repeat(x[::9], 2) for x in deviation(s, r)), (0.5, [])),
        ("half a sample", _changed(lambda t, a: (t * 0.4, a)), (0.5, [])),
        ("nothing", lambda *_: None, "skipped"),
        ("raises", _raises, "raised"),
        ("in samples", _changed(lambda t, a: (t * 80, a)), (0.0, ["tau-wrong"])),
        ("beyond the record", _changed(lambda t, a: (t * 1.5, a)), (0.5, [])),
        ("a hundredth beyond the half", _changed(lambda t, a: (t * 1.01, a)), None),
        ("over less than a decade", lambda s, r: tuple(x[:6] for x in deviation(s, r)), (0.5, [])),
        ("four of them", lambda s, r: tuple(x[::9] for x in deviation(s, r)), (0.5, [])),
    ]),
    (checks.check_matches_definition, [
        ("the variance", _changed(lambda t, a: (t, a**2)), (0.0, [])),
        ("without the half", _changed(lambda t, a: (t, a * 2**0.5)), (0.0, ["allan-factor-missing"])),
        ("the spread of means", _spread, (0.0, ["std-not-allan"])),
        ("another curve", _changed(lambda t, a: (t, a * 1.3)), (0.0, [])),
        ("the longest first", _changed(lambda t, a: (t[::-1], a[::-1])), None),
        ("some that are no numbers", _changed(_some_unknown), None),
        ("wrong for long times", _changed(lambda t, a: (t, np.where(t > t[len(t) // 2], 3 * a, a))), (0.0, [])),
        ("in samples, which is another check's", _changed(lambda t, a: (t * 80, a)), None),
    ]),
    (checks.check_shows_kinds_of_noise, [
        ("the variance", _changed(lambda t, a: (t, a**2)), (0.0, [])),
        ("the spread of means", _spread, (0.0, ["std-not-allan"])),
        ("a trend taken off", _detrended, (0.0, [])),
        *((f"steeper for {kind} alone", _steeper(kind), (0.0, [])) for kind in ("white", "walk", "quantised", "drift")),
        ("in samples", _changed(lambda t, a: (t * 80, a)), None),
        ("short times alone", lambda s, r: tuple(x[:4] for x in deviation(s, r)), None),
        ("the same for every record", lambda s, r: (deviation(s, r)[0], deviation(s, r)[0] ** -0.5), (0.0, [])),
    ]),
    (checks.check_takes_three_axes, [
        ("one axis of three", _one_axis, (0.0, [])),
        ("the first for all", _same_for_all, (0.0, [])),
        ("off by a ten-millionth for more than one axis", _a_little_more_for_axes, (0.0, [])),
        ("raises for more than one axis", _raises_for_axes, "raised"),
        ("half as many for more than one axis", _fewer_for_axes, (0.0, [])),
        ("nothing", lambda *_: None, (0.0, [])),
    ]),
]  # fmt: skip

# --- many IMUs ------------------------------------------------------------------------------------------------------


def every(model: Any, data: Any) -> Any:
    """Every place of the model."""
    names = [model.sensor(i).name for i in range(model.nsensor)]
    places = [name.removesuffix("_accelerometer") for name in names if name.endswith("_accelerometer")]
    return {place: _of(data, place) for place in places if f"{place}_gyroscope" in names}


def _of(data: Any, place: str) -> Any:
    return tuple(data.sensor(f"{place}_{kind}").data.copy() for kind in ("accelerometer", "gyroscope"))


def _views(model: Any, data: Any) -> Any:
    return {p: (data.sensor(f"{p}_accelerometer").data, r[1]) for p, r in every(model, data).items()}


def _those_of_the_lab(model: Any, data: Any) -> Any:
    return {p: r for p, r in every(model, data).items() if p in ("torso", "head", "left_foot", "right_foot", "keel")}


def _first_for_all(model: Any, data: Any) -> Any:
    found = every(model, data)
    return dict.fromkeys(found, next(iter(found.values())))


def _changing(change: Callable[[str, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda model, data: {p: change(p, r) for p, r in every(model, data).items()}


def _without(*places: str) -> Callable[[Any, Any], Any]:
    return lambda model, data: {p: r for p, r in every(model, data).items() if p not in places}


def _elsewhere(other: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Sound in the lab's model, and another function in any other."""
    return lambda model, data: (every if "torso" in every(model, data) else other)(model, data)


def _at_first(empty: type) -> Callable[[Any, Any], Any]:
    """Nothing on the first call for each model."""
    known: list[Any] = []

    def read_all_imus(model: Any, data: Any) -> Any:
        if model in known:
            return every(model, data)
        known.append(model)
        return empty()

    return read_all_imus


IMUS: list[tuple[Any, list[Row]]] = [
    (checks.check_finds_every_place, [
        ("none at first", _at_first(dict), (0.0, ["imu-missing"])),
        ("those of the lab", _those_of_the_lab, (0.5, ["imu-missing"])),
        ("the torso alone", lambda m, d: {"torso": every(m, d).get("torso")}, (0.0, ["imu-missing"])),
        ("a list", lambda m, d: list(every(m, d).values()), (0.0, ["wrong-return-type"])),
        ("raises", _raises, "raised"),
        ("an empty dictionary", lambda *_: {}, (0.0, ["imu-missing"])),
        ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
        ("all but one", _without("head"), (0.0, ["imu-missing"])),
        ("all but one of another model", _without("keel"), (0.5, ["imu-missing"])),
        ("raises in another model", _elsewhere(_raises), "raised"),
    ]),
    (checks.check_matches_truth, [
        ("those of the lab", _those_of_the_lab, None),
        ("the first for all", _first_for_all, (0.0, ["same-imu-repeated"])),
        ("the gyroscope first", _changing(lambda _p, r: r[::-1]), (0.0, [])),
        ("in g", _changing(lambda _p, r: (r[0] / 9.81, r[1])), (0.0, [])),
        ("one of the lab", _changing(lambda p, r: r[::-1] if p == "head" else r), (0.0, [])),
        ("limited", _changing(lambda _p, r: (r[0], np.clip(r[1], -3.5, 3.5))), (0.0, [])),
        ("the accelerometer alone", _changing(lambda _p, r: r[:1]), (0.0, [])),
        ("raises in another model", _elsewhere(_raises), "raised"),
        ("one for all of another model", _elsewhere(_first_for_all), (0.5, ["same-imu-repeated"])),
        ("one of another model", _changing(lambda p, r: r[::-1] if p == "keel" else r), (0.5, [])),
        ("a list", lambda m, d: list(every(m, d).values()), "skipped"),
    ]),
    (checks.check_readings_are_copies, [
        ("views", _views, (0.0, [])),
        ("a view of one", lambda m, d: {p: r if p == "head" else every(m, d)[p] for p, r in _views(m, d).items()}, (0.0, [])),
        ("no numbers in one", _changing(lambda _p, r: (r[0], r[1] * np.nan)), None),
        ("no numbers", _changing(lambda _p, r: (r[0] * np.nan, r[1] * np.nan)), "skipped"),
        ("raises", _raises, "raised"),
        ("a list", lambda m, d: list(every(m, d).values()), "skipped"),
    ]),
]  # fmt: skip

# --- a plot that grows ----------------------------------------------------------------------------------------------


class Watched(FakeStudent):
    """A student whose live plot was seen."""

    def __init__(self, run: LiveRun) -> None:
        super().__init__(live_plot=None)
        self.run = run

    def ask(self, *_: Any) -> Frame:
        arrays = {
            f"{axis}{n}": its for n, curve in enumerate(self.run.curves) for axis, its in zip("xy", curve, strict=True)
        }
        curves = [{"moment": 1.0, "label": "x", "x": f"x{n}", "y": f"y{n}"} for n in range(len(self.run.curves))]
        error = asdict(self.run.fault) if self.run.fault else None
        fields = {"curves": curves, "simulated": self.run.simulated, "returned": True, "error": error}
        return Frame(fields, arrays | {"events": self.run.events})


def _seen(
    moments: Any = (0.1, 0.3, 0.5, 0.7, 0.9), simulated: float = 1.0, curves: Any = None, fault: Fault | None = None
) -> LiveRun:
    pushed = truth()["watched"]["pushed"]
    time = 0.004 * np.arange(1, len(pushed) + 1)
    shown = [(time, pushed[:, i]) for i in range(6)] if curves is None else curves
    events = np.array([(moment, 10.0 * n, n + 1.0) for n, moment in enumerate(moments)]).reshape(-1, 3)
    return LiveRun(events, tuple((np.array(x), np.array(y)) for x, y in shown), simulated, fault)


_T = 0.004 * np.arange(1, 253)
_WRONG = (_T, np.cos(40 * _T))

LIVE: list[tuple[Any, list[Row]]] = [
    (checks.check_returns, [
        ("less", _seen(simulated=0.89), (0.5, [])),
        ("nothing", _seen(simulated=0.0), (0.0, [])),
        ("raises", _seen(fault=Fault("ValueError", "broken", None, None, None)), "raised"),
    ]),
    (checks.check_grows_while_stepping, [
        ("four times", _seen((0.1, 0.3, 0.5, 0.7)), None),
        ("three times", _seen((0.1, 0.4, 0.7)), (0.5, [])),
        ("twice, and at the end", _seen((0.2, 0.6, 1.0)), (0.5, [])),
        ("raises", _seen(fault=Fault("ValueError", "broken", None, None, None)), "raised"),
        ("once", _seen((0.5, 0.5)), (0.0, ["plot-not-live"])),
        ("at the end", _seen((0.5, 1.0, 1.0, 1.0, 1.0)), (0.0, [])),
    ]),
    (checks.check_shows_true_data, [
        ("nothing", _seen(()), "skipped"),
        ("wrong ones, and then right ones", _seen(curves=[_WRONG] * 30 + [(_T, truth()["watched"]["pushed"][:, 0])] * 24), None),
        ("raises", _seen(fault=Fault("ValueError", "broken", None, None, None)), "raised"),
        ("wrong ones", _seen(curves=[_WRONG] * 3), (0.0, [])),
        ("one that is right", _seen(curves=[(_T, truth()["watched"]["pushed"][:, 0])] + [_WRONG] * 2), (0.5, [])),
    ]),
]  # fmt: skip


def _cases(rows: list[tuple[Any, list[Row]]], student: Callable[[Any], Student], sound: Any) -> list[Case]:
    """Return a case for each row, and one of a sound part for each check."""
    return [
        Case(name, check, lambda part=part: student(part), marked)  # type: ignore[misc]
        for check, its in rows
        for name, part, marked in [("sound", sound, None), *its]
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


@pytest.mark.quick
@pytest.mark.parametrize("single", ["accel_alone_rms", "gyro_alone_rms"])
def test_a_steep_ride_is_to_beat_the_better_one_of_both_sensors(single: str) -> None:
    facts = complementary_filter.measure(FakeStudent(ComplementaryFilter=Tilt), truth())
    alone = {check: {**each, single: 0.001} for check, each in facts.alone.items()}
    held = replace(facts, alone=alone)
    off = [complementary_filter.TILT.checks[f"complementary_filter.{name}"][1](held) is not None for name in RIDES]
    assert off[-1]
    assert sum(off) == 2
