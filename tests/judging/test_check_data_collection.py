"""The checks of Data collection, on made-up recorders."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from grader.labs.imu.data_collection import checks
from tests.judging.fake_students import Case, FakeStudent, Marked, Row, finding, is_as_marked, marked, truth

CHECKS = NAMED, COUNT, TIME, TRUTH, RESET, PUSH = (
    checks.check_returns_named_arrays,
    checks.check_sample_count,
    checks.check_time_axis,
    checks.check_matches_truth,
    checks.check_starts_from_reset,
    checks.check_applies_push,
)
KEYS = ("time", "acceleration", "angular_velocity")


class Recorder:
    """The sheet's recorder, in steps that a faulty one changes."""

    def begin(self, model: Any, data: Any) -> None:
        mujoco.mj_resetData(model, data)

    def push(self, data: Any) -> None:
        data.qvel[0] = 0.5

    def steps(self, model: Any, duration: float) -> int:
        return round(duration / model.opt.timestep)

    def step(self, model: Any, data: Any, n: int) -> None:
        mujoco.mj_step(model, data)

    def row(self, model: Any, data: Any, accel_id: int, gyro_id: int) -> tuple[Any, Any, Any]:
        a, g = model.sensor_adr[accel_id], model.sensor_adr[gyro_id]
        return data.time, data.sensordata[a : a + 3].copy(), data.sensordata[g : g + 3].copy()

    def returned(self, time: np.ndarray, accel: np.ndarray, gyro: np.ndarray, model: Any) -> Any:
        return dict(zip(KEYS, (time, accel, gyro), strict=True))

    def rows(self, model: Any, data: Any, duration: float, *ids: int) -> Iterator[Any]:
        for n in range(self.steps(model, duration)):
            self.step(model, data, n)
            yield self.row(model, data, *ids)

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.begin(model, data)
        self.push(data)
        rows = list(self.rows(model, data, duration_seconds, accel_id, gyro_id))
        columns = [np.array(column) for column in zip(*rows, strict=True)] if rows else [np.zeros((0,))] * 3
        return self.returned(*columns, model)


def of(**steps: Any) -> Callable[[], Recorder]:
    """A recorder that differs from the sound one in these steps."""
    return type("Other", (Recorder,), steps)


def both(*kinds: Callable[[], Recorder], **steps: Any) -> Callable[[], Recorder]:
    """A recorder with the steps of several."""
    return type("Both", kinds, steps)  # type: ignore[arg-type]


def stamped(stamps: Callable[[Any, Any], Any]) -> Callable[[], Recorder]:
    """One with other stamps, made of the right ones and the time step."""
    return telling(lambda t, a, g, m: (stamps(t, m.opt.timestep), a, g))


def counting(n: Callable[[float, float], float]) -> Callable[[], Recorder]:
    """One that makes another number of steps of the duration and the time step."""
    return of(steps=lambda _s, m, duration: round(n(duration, m.opt.timestep)))


def telling(change: Callable[[Any, Any, Any, Any], Sequence[Any]]) -> Callable[[], Recorder]:
    """One that changes what it has recorded."""
    return of(returned=lambda s, t, a, g, m: Recorder.returned(s, *change(t, a, g, m), m))


class Before(Recorder):
    """Each row read before its step."""

    def rows(self, model: Any, data: Any, duration: float, *ids: int) -> Iterator[Any]:
        for n in range(self.steps(model, duration)):
            yield self.row(model, data, *ids)
            self.step(model, data, n)


class ResetInTheLoop(Recorder):
    """Every step from the reset state."""

    def step(self, model: Any, data: Any, n: int) -> None:
        self.begin(model, data)
        self.push(data)
        super().step(model, data, n)


class UntilTime(Recorder):
    """No reset, and steps until data.time is the duration: what an earlier run left shortens the next one."""

    def begin(self, model: Any, data: Any) -> None:
        pass

    def rows(self, model: Any, data: Any, duration: float, *ids: int) -> Iterator[Any]:
        while data.time < duration - 1e-9:
            mujoco.mj_step(model, data)
            yield self.row(model, data, *ids)


class Rollout(Recorder):
    """All steps at once by `mujoco.rollout`, which the worker does not see."""

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.begin(model, data)
        self.push(data)
        kinds = mujoco.mjtState  # before MuJoCo 3.1.2 a state has no time, and a single rollout no dimension of its own
        kind = kinds.mjSTATE_PHYSICS if mujoco.mj_version() < 312 else kinds.mjSTATE_FULLPHYSICS
        state = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)
        steps = self.steps(model, duration_seconds)
        _, sensors = rollout.rollout(model, data, state[None], nstep=steps)
        sensors = sensors.reshape(steps, model.nsensordata)
        a, g = model.sensor_adr[accel_id], model.sensor_adr[gyro_id]
        time = np.arange(1, steps + 1) * model.opt.timestep
        return self.returned(time, sensors[:, a : a + 3], sensors[:, g : g + 3], model)


class FiftyHertz(Recorder):
    """A row for each fiftieth of a second, whatever the time step."""

    def rows(self, model: Any, data: Any, duration: float, *ids: int) -> Iterator[Any]:
        taken = 0
        for row in super().rows(model, data, duration, *ids):
            if data.time >= taken / 50 - 1e-9:
                taken += 1
                yield row


class Random(Recorder):
    """Another push in every run."""

    def __init__(self) -> None:
        self.rng = np.random.default_rng(5)

    def push(self, data: Any) -> None:
        data.qvel[0] = self.rng.uniform(0.2, 0.9)


def _in_another_world(self: Any, model: Any, data: Any) -> None:
    model.opt.gravity[2] = -9.0
    model.opt.timestep = 0.001
    mujoco.mj_resetData(model, data)


def _in_weaker_gravity(self: Any, model: Any, data: Any) -> None:
    model.opt.gravity[2] = -9.0
    mujoco.mj_resetData(model, data)


def _as_on_earth(self: Any, t: Any, a: Any, g: Any, model: Any) -> Any:
    """Put gravity back before the recording is returned."""
    model.opt.gravity[2] = -9.81
    return Recorder.returned(self, t, a, g, model)


def _keeps_pose(self: Any, model: Any, data: Any) -> None:
    """A reset of the velocities and the time alone."""
    data.qvel[:], data.time = 0.0, 0.0


def _raises_with_another_time_step(self: Any, model: Any, data: Any) -> None:
    if model.opt.timestep != 0.002:
        raise RuntimeError("broken")
    mujoco.mj_resetData(model, data)


def _noisy(t: Any, a: Any, g: Any, _m: Any) -> Any:
    rng = np.random.default_rng(3)
    return t, a + rng.normal(0, 0.05, a.shape), g + rng.normal(0, 0.005, g.shape)


def _smoothed(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """The mean of nine rows, which come near the true ones."""

    def mean(rows: Any) -> Any:
        return np.stack([np.convolve(column, np.ones(9) / 9, "same") for column in rows.T], axis=1)

    return t, mean(a), mean(g)


WITHOUT_TIME = of(returned=lambda _s, _t, a, g, _m: {"acceleration": a, "angular_velocity": g})

_NOT_REACHED = dict.fromkeys((TIME, TRUTH, RESET, PUSH), "skipped")
"""Without rows nothing else can be asked."""
_UNKNOWN = dict.fromkeys((COUNT, RESET, PUSH), "skipped")
"""Where rows follow no simulation, nothing tells what was simulated."""
_KEYS, _USUAL, _KEPT = (0.0, ["wrong-keys"]), (0.5, ["hard-coded-timestep"]), (0.0, ["no-reset"])

KINDS: list[tuple[str, Callable[[], Recorder], dict[Any, Marked]]] = [
    ("sound", Recorder, {}),
    # the form
    ("all that can be odd", of(returned=lambda _s, t, a, g, _m: {"t": t[:, None], "a": a.T, "w": g.T, "dt": 0.002}), {NAMED: (0.0, ["wrong-keys", "wrong-return-type", "arrays-transposed"])}),
    ("a list", of(returned=lambda _s, t, a, g, _m: [t, a, g]), {NAMED: (0.0, ["wrong-return-type"])}),
    ("nothing", of(returned=lambda *_: None), {**_NOT_REACHED, NAMED: (0.0, ["wrong-return-type"]), COUNT: (0.0, [])}),
    ("no stamp under its name", of(returned=lambda _s, t, a, g, _m: {"time": [], "acceleration": a, "angular_velocity": g}), {NAMED: (0.0, ["wrong-return-type"])}),
    ("nothing under all names", of(returned=lambda *_: {key: [] for key in KEYS}), {**_NOT_REACHED, NAMED: (0.0, []), COUNT: (0.0, [])}),
    ("two axes of both", telling(lambda t, a, g, _m: (t, a[:, :2], g[:, :2])), {**_NOT_REACHED, NAMED: (0.0, ["wrong-return-type"]), TIME: None}),
    ("without time", WITHOUT_TIME, {NAMED: _KEYS}),
    ("raises with another time step", of(begin=_raises_with_another_time_step), dict.fromkeys((COUNT, TIME, RESET), "raised")),
    # how many rows there are
    ("one more", counting(lambda duration, dt: duration / dt + 1), {}),
    ("two more", counting(lambda duration, dt: duration / dt + 2), {COUNT: (0.0, [])}),
    ("twenty too few", counting(lambda duration, dt: duration / dt - 20), {COUNT: (0.0, [])}),
    ("at a fixed rate", counting(lambda duration, _dt: duration / 0.002), {COUNT: (0.0, ["hard-coded-timestep"])}),
    ("fifty a second", FiftyHertz, {COUNT: (0.0, ["fixed-rate"])}),
    ("two steps a row, for twice the time", of(step=lambda _s, m, data, _n: mujoco.mj_step(m, data, 2)), {COUNT: (0.0, ["samples-skipped"]), TRUTH: (0.5, ["samples-skipped"])}),
    # the stamps
    ("before each step", Before, {TRUTH: (0.5, ["read-before-step"])}),
    ("stamps half a step too late", stamped(lambda t, dt: t + dt / 2), {TIME: (0.5, ["time-axis-wrong"])}),
    ("one stamp that is none", stamped(lambda t, _dt: np.where(np.arange(len(t)) == 7, np.nan, t)), {TIME: (0.0, ["not-finite"])}),
    ("a usual time step, two rows", both(stamped(lambda t, _dt: np.arange(len(t)) * 0.002), steps=lambda *_: 2), {TIME: _USUAL, TRUTH: (0.0, []), **dict.fromkeys((COUNT, RESET, PUSH), "skipped")}),
    # the rows
    ("exchanged", telling(lambda t, a, g, _m: (t, g, a)), {TRUTH: (0.0, ["channels-swapped"])}),
    ("all like the last", telling(lambda t, a, g, _m: (t, a[-1] + 0 * a, g[-1] + 0 * g)), {TRUTH: (0.0, ["aliased-rows"])}),
    ("of the last sensor", of(row=lambda s, m, d, *_: Recorder.row(s, m, d, -1, -1)), {TRUTH: (0.0, ["sensor-not-found"])}),
    ("of the head", of(row=lambda s, m, d, *_: Recorder.row(s, m, d, *(m.sensor(f"head_{kind}").id for kind in ("accelerometer", "gyroscope")))), {TRUTH: (0.0, [])}),
    ("room for more", telling(lambda t, a, g, _m: [np.concatenate([x, np.zeros((60, *x.shape[1:]))]) for x in (t, a, g)]), {TRUTH: (0.5, ["rows-left-zero"])}),
    ("a first row that is empty", telling(lambda t, a, g, _m: [np.concatenate([x[:1] * 0, x]) for x in (t, a, g)]), {TRUTH: (0.5, ["first-row-empty"])}),
    ("without the first ones", telling(lambda t, a, g, _m: (t[30:], a[30:], g[30:])), {TRUTH: (0.5, [])}),
    ("with digits cut off", telling(lambda t, a, g, _m: (t, a.round(2), g)), {TRUTH: (0.5, ["rows-altered"])}),
    ("zeros in one", telling(lambda t, a, g, _m: (t, a * 0, g)), {TRUTH: (0.0, [])}),
    ("no numbers", telling(lambda t, a, g, _m: (t, a * np.nan, g * np.nan)), {**_UNKNOWN, TRUTH: (0.0, ["not-finite"])}),
    ("no simulation", of(step=lambda _s, m, data, _n: setattr(data, "time", data.time + m.opt.timestep)), {**_UNKNOWN, TRUTH: (0.0, ["nothing-simulated"])}),
    ("a recording, altered", telling(lambda *_: [(1.01 if key != "time" else 1) * truth()["push"][key][:600] for key in KEYS]), {COUNT: (0.0, ["ignores-duration"]), TIME: _USUAL, TRUTH: (0.0, ["rows-altered"]), RESET: "skipped"}),
    ("another gravity for the run", of(begin=_in_weaker_gravity, returned=_as_on_earth), {TRUTH: (0.0, ["modifies-model"])}),
    # the reset
    ("no reset", of(begin=lambda *_: None), {RESET: _KEPT}),
    ("until the time, without a reset", UntilTime, {RESET: _KEPT}),
    ("a reset of all but the pose", of(begin=_keeps_pose), {RESET: _KEPT}),
    ("another gravity and time step", of(begin=_in_another_world), {RESET: (0.0, ["modifies-model"])}),
    # the push
    ("a rollout", Rollout, {}),
    ("a rollout with half of it", both(Rollout, of(push=lambda _s, data: np.put(data.qvel, 0, 0.25))), {PUSH: (0.0, ["wrong-perturbation"])}),
    ("no push, of altered rows", both(telling(lambda t, a, g, _m: (t, a * 1.01, g)), push=lambda *_: None), {TRUTH: (0.0, []), PUSH: (0.0, ["no-perturbation"])}),
    ("in every step", ResetInTheLoop, {TRUTH: (0.0, ["starts-over"])}),
    ("in every step, with digits cut off", both(telling(lambda t, a, g, _m: (t, a.round(2), g.round(2))), ResetInTheLoop), {TRUTH: (0.0, ["starts-over"])}),
    ("another push each time", Random, {PUSH: (0.0, ["random-push"])}),
]  # fmt: skip
TREATMENTS: dict[str, tuple[Callable[[], Recorder], dict[Any, Marked]]] = {
    "with noise": (telling(_noisy), {TRUTH: (0.0, [])}),
    "smoothed": (telling(_smoothed), {TRUTH: (0.0, [])}),
    "without time": (WITHOUT_TIME, {NAMED: _KEYS}),
}
"""What is done to the rows at the end, with what it costs alone."""
FAULTS = {name: kind for name, *kind in KINDS if name in ("twenty too few", "no reset", "another push each time")}


def _turned(data: Any, model: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None) -> Any:
    return Recorder()(model, data, duration_seconds, accel_id, gyro_id)


def function(recorder: Recorder) -> Callable[..., Any]:
    def simulate_and_collect(
        model: Any, data: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None
    ) -> Any:
        return recorder(model, data, duration_seconds, accel_id, gyro_id)

    return simulate_and_collect


ROWS = [
    Row(name, lambda kind=kind: FakeStudent(simulate_and_collect=function(kind())), marks)
    for name, kind, marks in KINDS
]  # type: ignore[misc]
ROWS += [
    Row("in another order", lambda: FakeStudent(simulate_and_collect=_turned), {NAMED: (0.0, ["other-parameters"])})
]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_recorder_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))


@pytest.mark.quick
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("treatment", TREATMENTS)
def test_a_fault_costs_the_same_whatever_is_done_to_the_rows(treatment: str, fault: str) -> None:
    (treated, costs), (faulty, marks) = TREATMENTS[treatment], FAULTS[fault]
    student = FakeStudent(simulate_and_collect=function(both(treated, faulty)()))
    found = {check: marked(finding(Case("", check, lambda: student))) for check in CHECKS}
    assert found == dict.fromkeys(CHECKS) | costs | marks


_SHAPE = (0.0, ["wrong-return-type"])


@pytest.mark.quick
@pytest.mark.parametrize(
    ("rows", "scale", "kept"),
    [
        (slice(7, None), 1.0, [_SHAPE, None, None, (0.5, []), None, None]),
        (slice(0, 50), 0.5, [_SHAPE, (0.0, ["ignores-duration"]), None, (0.0, ["rows-altered"]), None, None]),
    ],
    ids=["late rows", "few rows"],
)
def test_two_stamps_of_three_and_other_rows_are_judged(rows: slice, scale: float, kept: list[Any]) -> None:
    kind = telling(lambda t, a, g, _m: (t[np.arange(len(t)) % 3 > 0], scale * a[rows], g[rows]))
    student = FakeStudent(simulate_and_collect=function(kind()))
    assert [marked(finding(Case("", check, lambda: student))) for check in CHECKS] == kept
