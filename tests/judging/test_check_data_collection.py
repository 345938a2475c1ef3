"""The checks of Data collection, on made-up recorders."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from grader.labs.imu.data_collection import checks
from tests.judging.fake_students import FakeStudent, Marked, Row, finding, is_as_marked, marked, truth

NAMED, COUNT, TIME, TRUTH, RESET, PUSH = (
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


def telling(change: Callable[[Any, Any, Any, Any], tuple[Any, Any, Any]]) -> Callable[[], Recorder]:
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
        state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        states, sensors = rollout.rollout(model, data, state[None], nstep=self.steps(model, duration_seconds))
        a, g = model.sensor_adr[accel_id], model.sensor_adr[gyro_id]
        return self.returned(states[0, :, 0], sensors[0, :, a : a + 3], sensors[0, :, g : g + 3], model)


class Keeping(Recorder):
    """Lists that outlive the call."""

    def __init__(self) -> None:
        self.kept: list[Any] = []

    def row(self, model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
        self.kept.append(super().row(model, data, accel_id, gyro_id))
        return self.kept[-1]

    def returned(self, time: Any, accel: Any, gyro: Any, model: Any) -> Any:
        return super().returned(*(np.array(column) for column in zip(*self.kept, strict=True)), model)


class Skipping(Recorder):
    """Two steps a row, and as many steps as were asked for."""

    def steps(self, model: Any, duration: float) -> int:
        return super().steps(model, duration) // 2

    def step(self, model: Any, data: Any, n: int) -> None:
        mujoco.mj_step(model, data, 2)


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


def _heavier(self: Any, model: Any, data: Any) -> None:
    model.opt.gravity[2] = -9.0
    mujoco.mj_resetData(model, data)


def _own_timestep(self: Any, model: Any, data: Any) -> None:
    model.opt.timestep = 0.001
    mujoco.mj_resetData(model, data)


def _other_gravity_and_timestep(self: Any, model: Any, data: Any) -> None:
    model.opt.gravity[2] = -9.0
    _own_timestep(self, model, data)


def _keeps_pose(self: Any, model: Any, data: Any) -> None:
    """A reset of the velocities and the time alone."""
    data.qvel[:], data.time = 0.0, 0.0


def _for_the_run(*changes: Callable[..., None], **more: Any) -> Callable[[], Recorder]:
    """A recorder that changes the model for its run and puts it back."""

    def begin(self: Any, model: Any, data: Any) -> None:
        self.before = model.opt.gravity.copy(), model.opt.timestep
        for change in changes:
            change(self, model, data)

    def returned(self: Any, time: Any, accel: Any, gyro: Any, model: Any) -> Any:
        model.opt.gravity[:], model.opt.timestep = self.before
        return Recorder.returned(self, time, accel, gyro, model)

    return of(begin=begin, returned=returned, **more)


def _pushed(index: int, by: float) -> Callable[..., None]:
    def push(_self: Any, data: Any) -> None:
        data.qvel[index] = by

    return push


def _in_pose(index: int, by: float) -> Callable[..., None]:
    """A start in another pose than the model's own."""

    def begin(_self: Any, model: Any, data: Any) -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[index] += by

    return begin


def _with_velocities(self: Any, data: Any) -> None:
    data.qvel[:4] = (0.5, 0.1, -0.2, 0.3)


def _with_three_velocities(self: Any, data: Any) -> None:
    data.qvel[:3] = (0.5, 0.1, -0.2)


def _later(self: Any, model: Any, data: Any, n: int) -> None:
    if n == 40:
        data.qvel[0] = 0.5
    mujoco.mj_step(model, data)


def _forced(self: Any, data: Any) -> None:
    data.qvel[0] = 0.5
    data.qfrc_applied[0] = 30.0


def _head(self: Any, model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
    a, g = (model.sensor(name).adr[0] for name in ("head_accelerometer", "head_gyroscope"))
    return data.time, data.sensordata[a : a + 3].copy(), data.sensordata[g : g + 3].copy()


def _last(self: Any, model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
    return Recorder.row(self, model, data, -1, -1)


def _constant(self: Any, model: Any, data: Any, n: int) -> None:
    data.time += model.opt.timestep


def _raises(*_: Any) -> Any:
    raise RuntimeError("broken")


def _raises_with_another_time_step(self: Any, model: Any, data: Any) -> None:
    if model.opt.timestep != 0.002:
        raise RuntimeError("broken")
    mujoco.mj_resetData(model, data)


def _recorded(*_: Any) -> tuple[Any, Any, Any]:
    push = truth()["push"]
    return push["time"][:600], push["acceleration"][:600] * 1.01, push["angular_velocity"][:600] * 1.01


def _recorded_as_it_was(*_: Any) -> tuple[Any, Any, Any]:
    push = truth()["push"]
    return push["time"][:600], push["acceleration"][:600], push["angular_velocity"][:600]


def _noisy(t: Any, a: Any, g: Any, _m: Any) -> Any:
    rng = np.random.default_rng(3)
    return t, a + rng.normal(0, 0.05, a.shape), g + rng.normal(0, 0.005, g.shape)


def _noisy_with_a_gap(t: Any, a: Any, g: Any, m: Any) -> Any:
    t, a, g = _noisy(t, a, g, m)
    g[7, 1] = np.nan
    return t, a, g


def _squared(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """Rows that follow the simulation in a way that no origin tells."""
    return t, np.sign(a) * a**2, np.sign(g) * np.abs(g) ** 1.5


def _smoothed(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """The mean of nine rows, which come near the true ones."""

    def mean(rows: Any) -> Any:
        return np.stack([np.convolve(column, np.ones(9) / 9, "same") for column in rows.T], axis=1)

    return t, mean(a), mean(g)


def _first_row_empty(t: Any, a: Any, g: Any, _m: Any) -> Any:
    return tuple(np.concatenate([column[:1] * 0, column]) for column in (t, a, g))


def _empty(rows: int) -> Callable[[], Recorder]:
    """The last rows never filled."""

    def emptied(*columns: Any) -> Any:
        return tuple(np.concatenate([column[:-rows], 0 * column[-rows:]]) for column in columns[:3])

    return telling(emptied)


def _room(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """Sixty rows more than there are steps, never filled."""
    return tuple(np.concatenate([column, np.zeros((60, *column.shape[1:]))]) for column in (t, a, g))


def _late(t: float) -> Any:
    return stamped(lambda time, _dt: np.where(np.arange(len(time)) == 7, t, time))


NO_PUSH = of(push=lambda *_: None)
COUNTED = telling(lambda t, a, g, _m: (np.arange(len(t)) * 0.002, a, g))
WITHOUT_TIME = of(returned=lambda _s, _t, a, g, _m: {"acceleration": a, "angular_velocity": g})

_NOT_REACHED = dict.fromkeys((TIME, TRUTH, RESET, PUSH), "skipped")
"""Without rows nothing else can be asked."""
_UNKNOWN = dict.fromkeys((COUNT, RESET, PUSH), "skipped")
"""Where rows follow no simulation, nothing tells what was simulated."""
_FORM, _KEYS, _PUSHED = (0.0, ["wrong-return-type"]), (0.0, ["wrong-keys"]), (0.0, ["wrong-perturbation"])
_STAMPED, _HALF_A_STEP, _USUAL = (0.0, ["time-axis-wrong"]), (0.5, ["time-axis-wrong"]), (0.5, ["hard-coded-timestep"])
_LENGTH, _ALTERED, _EMPTY = (0.0, ["ignores-duration"]), (0.0, ["rows-altered"]), (0.5, ["rows-left-zero"])
_KEPT, _WORLD = (0.0, ["no-reset"]), (0.0, ["modifies-model"])

KINDS: list[tuple[str, Callable[[], Recorder], dict[Any, Marked]]] = [
    ("sound", Recorder, {}),
    # the form
    ("other keys", of(returned=lambda _s, t, a, g, _m: {"t": t, "acc": a, "gyro": g}), {NAMED: _KEYS}),
    ("a tuple", of(returned=lambda _s, t, a, g, _m: (t, a, g)), {NAMED: _FORM}),
    ("a list", of(returned=lambda _s, t, a, g, _m: [t, a, g]), {NAMED: _FORM}),
    ("transposed", telling(lambda t, a, g, _m: (t, a.T, g)), {NAMED: (0.0, ["arrays-transposed"])}),
    ("all that can be odd", of(returned=lambda _s, t, a, g, _m: {"t": t[:, None], "a": a.T, "w": g.T, "dt": 0.002}), {NAMED: (0.0, ["wrong-keys", "wrong-return-type", "arrays-transposed"])}),
    ("a shorter one", telling(lambda t, a, g, _m: (t, a, g[:-2])), {NAMED: _FORM, TRUTH: _EMPTY}),
    ("magnitudes", telling(lambda t, a, g, _m: (t, np.linalg.norm(a, axis=1), g)), {NAMED: _FORM, TRUTH: (0.5, [])}),
    ("two axes of both", telling(lambda t, a, g, _m: (t, a[:, :2], g[:, :2])), {**_NOT_REACHED, NAMED: _FORM, TIME: None}),
    ("nothing", of(returned=lambda *_: None), {**_NOT_REACHED, NAMED: _FORM, COUNT: (0.0, [])}),
    ("no stamp under its name", of(returned=lambda _s, t, a, g, _m: {"time": [], "acceleration": a, "angular_velocity": g}), {NAMED: _FORM}),
    ("nothing under all names", of(returned=lambda *_: {key: [] for key in KEYS}), {**_NOT_REACHED, NAMED: (0.0, []), COUNT: (0.0, [])}),
    ("without the gyroscope", of(returned=lambda _s, t, a, _g, _m: {"time": t, "acceleration": a}), {NAMED: _KEYS, TRUTH: (0.5, [])}),
    ("without the accelerometer", of(returned=lambda _s, t, _a, g, _m: {"time": t, "angular_velocity": g}), {NAMED: _KEYS, TRUTH: (0.5, [])}),
    ("one axis of the gyroscope", telling(lambda t, a, g, _m: (t, a, g[:, 2])), {NAMED: (0.0, ["wrong-return-type"]), TRUTH: (0.5, [])}),
    ("without time", WITHOUT_TIME, {NAMED: _KEYS}),
    ("time alone", of(returned=lambda _s, t, _a, _g, _m: {"time": t}), {**_NOT_REACHED, NAMED: _KEYS, TIME: None}),
    ("raises", of(begin=_raises), dict.fromkeys((NAMED, COUNT, TIME, TRUTH, RESET, PUSH), "raised")),
    ("raises with another time step", of(begin=_raises_with_another_time_step), dict.fromkeys((COUNT, TIME, RESET), "raised")),
    # how many rows there are
    ("one more", counting(lambda duration, dt: duration / dt + 1), {}),
    ("one less", counting(lambda duration, dt: duration / dt - 1), {}),
    ("two less", counting(lambda duration, dt: duration / dt - 2), {COUNT: (0.0, [])}),
    ("two more", counting(lambda duration, dt: duration / dt + 2), {COUNT: (0.0, [])}),
    ("twenty too few", counting(lambda duration, dt: duration / dt - 20), {COUNT: (0.0, [])}),
    ("always as many", of(steps=lambda *_: 600), {COUNT: _LENGTH}),
    ("whole seconds", counting(lambda duration, dt: int(duration) / dt), {COUNT: _LENGTH}),
    ("at a fixed rate", counting(lambda duration, _dt: duration / 0.002), {COUNT: (0.0, ["hard-coded-timestep"])}),
    ("fifty a second", FiftyHertz, {COUNT: (0.0, ["fixed-rate"])}),
    ("every second", Skipping, {COUNT: (0.0, ["samples-skipped"])}),
    ("two steps a row, for twice the time", of(step=lambda _s, m, data, _n: mujoco.mj_step(m, data, 2)), {TRUTH: (0.0, ["samples-skipped"])}),
    # the stamps
    ("before each step", Before, {TRUTH: (0.5, ["read-before-step"])}),
    ("stamps half a step too late", stamped(lambda t, dt: t + dt / 2), {TIME: _HALF_A_STEP}),
    ("stamps a step and a half too late", stamped(lambda t, dt: t + 1.5 * dt), {TIME: _STAMPED}),
    ("one stamp that is none", _late(np.nan), {TIME: (0.0, ["not-finite"])}),
    ("a usual time step", COUNTED, {TIME: _USUAL}),
    ("a usual time step, two rows", both(COUNTED, of(steps=lambda *_: 2)), {TIME: _USUAL, TRUTH: (0.0, [])}),
    ("no stamps in another time step", of(returned=lambda s, t, a, g, m: Recorder.returned(s, t, a, g, m) if m.opt.timestep == 0.002 else {KEYS[1]: a, KEYS[2]: g}), {}),
    # the rows
    ("four rows of ones", telling(lambda t, a, g, _m: (t[:4] * 0, a[:4] * 0 + 1, g[:4])), {TIME: _STAMPED, TRUTH: (0.0, [])}),
    ("exchanged", telling(lambda t, a, g, _m: (t, g, a)), {TRUTH: (0.0, ["channels-swapped"])}),
    ("all like the last", telling(lambda t, a, g, _m: (t, a[-1] + 0 * a, g[-1] + 0 * g)), {TRUTH: (0.0, ["aliased-rows"])}),
    ("one sensor like its last row", telling(lambda t, a, g, _m: (t, a, g[-1] + 0 * g)), {TRUTH: (0.0, [])}),
    ("of the last sensor", of(row=_last), {TRUTH: (0.0, ["sensor-not-found"])}),
    ("of the head", of(row=_head), {TRUTH: (0.0, [])}),
    ("room for more", telling(_room), {TRUTH: _EMPTY}),
    ("two rows that are never filled", _empty(2), {TRUTH: _EMPTY}),
    ("one row that is never filled", _empty(1), {TRUTH: (0.75, ["rows-left-zero"])}),
    ("a first row that is empty", telling(_first_row_empty), {TRUTH: (0.5, ["first-row-empty"])}),
    ("a step early, at the stamps of mj_forward", telling(lambda t, a, g, _m: (t[:-1], a[1:], g[1:])), {}),
    ("a step early", telling(lambda t, a, g, _m: (t[1:], a[1:], g[1:])), {TRUTH: (0.5, [])}),
    ("without the first ones", telling(lambda t, a, g, _m: (t[30:], a[30:], g[30:])), {TRUTH: (0.5, [])}),
    ("other signs", telling(lambda t, a, g, _m: (t, a, -g)), {TRUTH: _ALTERED}),
    ("mixed", telling(lambda t, a, g, _m: (t, a @ [[1, 0.3, 0], [0, 1, 0], [0, 0.2, 1]] + 0.7, g)), {TRUTH: _ALTERED}),
    ("with digits cut off", telling(lambda t, a, g, _m: (t, a.round(2), g)), {TRUTH: (0.5, ["rows-altered"])}),
    ("zeros in one", telling(lambda t, a, g, _m: (t, a * 0, g)), {TRUTH: (0.0, [])}),
    ("noise on the accelerometer", telling(lambda t, a, g, m: (t, _noisy(t, a, g, m)[1], g)), {TRUTH: (0.0, [])}),
    ("noise on the gyroscope", telling(lambda t, a, g, m: (t, a, _noisy(t, a, g, m)[2])), {TRUTH: (0.0, [])}),
    ("noise, and one number that is none", telling(_noisy_with_a_gap), {TRUTH: (0.0, ["not-finite"])}),
    ("no numbers in one", telling(lambda t, a, g, _m: (t, a * np.nan, g)), {TRUTH: (0.0, ["not-finite"])}),
    ("no numbers", telling(lambda t, a, g, _m: (t, a * np.nan, g * np.nan)), {**_UNKNOWN, TRUTH: (0.0, ["not-finite"])}),
    ("no simulation", of(step=_constant), {**_UNKNOWN, TRUTH: (0.0, ["nothing-simulated"])}),
    ("a recording of the hidden run", telling(_recorded_as_it_was), {COUNT: _LENGTH, TIME: _USUAL, RESET: "skipped"}),
    ("a recording, altered", telling(_recorded), {COUNT: _LENGTH, TIME: _USUAL, TRUTH: _ALTERED, RESET: "skipped"}),
    ("another gravity for the run", _for_the_run(_heavier), {TRUTH: _WORLD}),
    ("its own time step, put back", _for_the_run(_own_timestep), {COUNT: _LENGTH, TIME: _STAMPED, TRUTH: _WORLD}),
    # the reset
    ("no reset", of(begin=lambda *_: None), {RESET: _KEPT}),
    ("until the time, without a reset", UntilTime, {RESET: _KEPT}),
    ("a reset of all but the pose", of(begin=_keeps_pose), {RESET: _KEPT}),
    ("another pose", of(begin=_in_pose(2, 0.05)), {RESET: _KEPT}),
    ("another gravity", of(begin=_heavier), {RESET: _WORLD}),
    ("another time step", of(begin=_own_timestep), {RESET: _WORLD}),
    ("another gravity and time step", of(begin=_other_gravity_and_timestep), {RESET: _WORLD}),
    ("lists that stay", Keeping, {RESET: (0.0, ["keeps-old-rows"])}),
    # the push
    ("a rollout", Rollout, {}),
    ("a rollout with half of it", both(Rollout, of(push=_pushed(0, 0.25))), {PUSH: _PUSHED}),
    ("no push", NO_PUSH, {PUSH: (0.0, ["no-perturbation"])}),
    ("no push, of altered rows", both(telling(lambda t, a, g, _m: (t, a * 1.01, g)), NO_PUSH), {TRUTH: (0.0, []), PUSH: (0.0, ["no-perturbation"])}),
    ("a later push, in a model that is changed for the run", _for_the_run(_heavier, push=lambda *_: None, step=_later), {TRUTH: _WORLD, PUSH: _PUSHED}),
    *((f"a push of {by} on {which}", of(push=_pushed(which, by)), {PUSH: _PUSHED}) for which, by in [(0, 0.25), (0, 0.4), (0, 1.0), (0, -0.5), (1, 0.5), (2, 0.5), (3, 0.5)]),
    ("a later push", of(push=lambda *_: None, step=_later), {PUSH: _PUSHED}),
    ("one more push", of(step=_later), {PUSH: _PUSHED}),
    ("three other velocities beside it", of(push=_with_velocities), {PUSH: _PUSHED}),
    ("two other velocities beside it", of(push=_with_three_velocities), {PUSH: _PUSHED}),
    ("with a force", of(push=_forced), {PUSH: _PUSHED}),
    ("in every step", ResetInTheLoop, {TRUTH: (0.0, ["starts-over"])}),
    ("another push each time", Random, {PUSH: (0.0, ["random-push"])}),
]  # fmt: skip
TREATMENTS: list[tuple[str, Callable[[], Recorder], dict[Any, Marked]]] = [
    ("with noise", telling(_noisy), {TRUTH: (0.0, [])}),
    ("squared", telling(_squared), {TRUTH: (0.0, [])}),
    ("smoothed", telling(_smoothed), {TRUTH: (0.0, [])}),
    ("without time", WITHOUT_TIME, {NAMED: _KEYS}),
]
"""What is done to the rows at the end, with what it costs alone."""
_BY_NAME = {kind[0]: kind for kind in KINDS}
FAULTS = [
    _BY_NAME[name]
    for name in (
        "twenty too few", "no reset", "a reset of all but the pose", "another pose", "a push of 0.25 on 0", "a push of 0.4 on 0",
        "a push of 0.5 on 1", "a later push", "another push each time",
    )
]  # fmt: skip


def _turned(data: Any, model: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None) -> Any:
    return Recorder()(model, data, duration_seconds, accel_id, gyro_id)


def _function(recorder: Recorder) -> Callable[..., Any]:
    def simulate_and_collect(
        model: Any, data: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None
    ) -> Any:
        return recorder(model, data, duration_seconds, accel_id, gyro_id)

    return simulate_and_collect


OUT_OF_SIGHT = {
    ("squared", "another pose"),
    ("squared", "another push each time"),
    ("smoothed", "a push of 0.25 on 0"),
}
"""Rows that are altered so much that nothing tells what was simulated."""
CHECKS = (NAMED, COUNT, TIME, TRUTH, RESET, PUSH)
ROWS = [
    *(
        Row(name, lambda kind=kind: FakeStudent(simulate_and_collect=_function(kind())), marks)
        for name, kind, marks in KINDS
    ),  # type: ignore[misc]
    Row("in another order", lambda: FakeStudent(simulate_and_collect=_turned), {NAMED: (0.0, ["other-parameters"])}),
]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_recorder_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))


@pytest.mark.quick
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[0])
@pytest.mark.parametrize("treatment", TREATMENTS, ids=lambda treatment: treatment[0])
def test_a_fault_costs_the_same_whatever_is_done_to_the_rows(treatment: Any, fault: Any) -> None:
    recorder = both(treatment[1], fault[1])
    marks = treatment[2] | (_UNKNOWN if (treatment[0], fault[0]) in OUT_OF_SIGHT else fault[2])
    row = Row("both", lambda: FakeStudent(simulate_and_collect=_function(recorder())), marks)
    assert {case.check: marked(finding(case)) for case in row.cases(CHECKS)} == dict.fromkeys(CHECKS) | marks


def _squaring(model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
    """A reader of numbers that no treatment of a reading explains."""
    _, accel, gyro = Recorder().row(model, data, accel_id, gyro_id)
    return np.sin(accel) + accel**2, np.sin(gyro) + gyro**2


class OwnReader(Recorder):
    """One that stores what its submission's own reader gives."""

    def row(self, model: Any, data: Any, accel_id: int, gyro_id: int) -> tuple[Any, Any, Any]:
        return data.time, *_squaring(model, data, accel_id, gyro_id)


@pytest.mark.quick
def test_rows_that_the_submissions_own_reader_gives_are_the_readers_fault_alone() -> None:
    parts = {"simulate_and_collect": _function(OwnReader()), "get_imu_readings": _squaring}
    row = Row("of its own reader", lambda: FakeStudent(**parts), {})
    assert [finding(case) for case in row.cases(CHECKS)] == [None] * len(CHECKS)


@pytest.mark.quick
def test_the_charts_of_a_report_find_the_recording() -> None:
    student = FakeStudent(simulate_and_collect=_function(Recorder()))
    COUNT(student, truth())
    assert len(student.stored_answer("push").time) == 600


def _two_of_three(values: np.ndarray) -> np.ndarray:
    return values[np.arange(len(values)) % 3 > 0]


_SHAPE, _ROWS = (0.0, ["wrong-return-type"]), (0.0, ["rows-altered"])


@pytest.mark.quick
@pytest.mark.parametrize(
    ("stamps", "rows", "scale", "kept"),
    [
        (lambda t: t[::2], slice(None), 0.5, [_SHAPE, None, None, _ROWS, None, None]),
        (_two_of_three, slice(None), 0.5, [_SHAPE, None, None, _ROWS, None, None]),
        (_two_of_three, slice(7, None), 1.0, [_SHAPE, None, None, (0.5, []), None, None]),
        (_two_of_three, slice(0, 50), 0.5, [_SHAPE, (0.0, ["ignores-duration"]), None, _ROWS, None, None]),
        (lambda t: t[:0], slice(None), 1.0, [_SHAPE, None, None, None, None, None]),
        (lambda t: t, slice(0), 1.0, [_SHAPE, None, None, "skipped", "skipped", "skipped"]),
    ],
    ids=["every second", "two of three", "late rows", "few rows", "no stamp", "no row"],
)
def test_stamps_and_rows_of_any_length_are_judged(
    stamps: Callable[[np.ndarray], np.ndarray], rows: slice, scale: float, kept: list[Any]
) -> None:
    kind = telling(lambda t, a, g, _m: (stamps(t), scale * a[rows], g[rows]))
    row = Row("of any length", lambda: FakeStudent(simulate_and_collect=_function(kind())), {})
    assert [marked(finding(case)) for case in row.cases(CHECKS)] == kept
