"""The checks of Data collection, on made-up recorders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from grader.labs.imu.data_collection import checks
from tests.judging.made import Case, Made, finding, is_as_marked, marked, truth

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

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.begin(model, data)
        self.push(data)
        rows = []
        for n in range(self.steps(model, duration_seconds)):
            self.step(model, data, n)
            rows.append(self.row(model, data, accel_id, gyro_id))
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

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.begin(model, data)
        self.push(data)
        rows = []
        for n in range(self.steps(model, duration_seconds)):
            rows.append(self.row(model, data, accel_id, gyro_id))
            self.step(model, data, n)
        return self.returned(*(np.array(column) for column in zip(*rows, strict=True)), model)


class StepBefore(Recorder):
    """A step more, before the loop."""

    def push(self, data: Any) -> None:
        super().push(data)
        mujoco.mj_step(data.model, data)


class Settling(Recorder):
    """Steps between the reset and the push."""

    def begin(self, model: Any, data: Any) -> None:
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data, 200)


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

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.push(data)
        rows = []
        while data.time < duration_seconds - 1e-9:
            mujoco.mj_step(model, data)
            rows.append(self.row(model, data, accel_id, gyro_id))
        return self.returned(*(np.array(column) for column in zip(*rows, strict=True)), model)


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
        self.rows: list[Any] = []

    def row(self, model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
        self.rows.append(super().row(model, data, accel_id, gyro_id))
        return self.rows[-1]

    def returned(self, time: Any, accel: Any, gyro: Any, model: Any) -> Any:
        return super().returned(*(np.array(column) for column in zip(*self.rows, strict=True)), model)


class Skipping(Recorder):
    """Two steps a row, and as many steps as were asked for."""

    def steps(self, model: Any, duration: float) -> int:
        return super().steps(model, duration) // 2

    def step(self, model: Any, data: Any, n: int) -> None:
        mujoco.mj_step(model, data, 2)


class FiftyHertz(Recorder):
    """A row for each fiftieth of a second, whatever the time step."""

    def __call__(self, model: Any, data: Any, duration_seconds: float, accel_id: int, gyro_id: int) -> Any:
        self.begin(model, data)
        self.push(data)
        rows: list[Any] = []
        for n in range(self.steps(model, duration_seconds)):
            self.step(model, data, n)
            if data.time >= len(rows) / 50 - 1e-9:
                rows.append(self.row(model, data, accel_id, gyro_id))
        return self.returned(*(np.array(column) for column in zip(*rows, strict=True)), model)


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


def _keeps_time(self: Any, model: Any, data: Any) -> None:
    """A reset of the pose and the velocities alone."""
    data.qpos[:], data.qvel[:] = model.qpos0, 0.0


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


def _later_twice(self: Any, model: Any, data: Any, n: int) -> None:
    if n in (40, 80):
        data.qvel[0] = 0.5
    mujoco.mj_step(model, data)


def _keeps_velocities(self: Any, model: Any, data: Any) -> None:
    """A reset of the pose and the time alone."""
    data.qpos[:], data.time = model.qpos0, 0.0


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


def _aliased(t: Any, a: Any, g: Any, _m: Any) -> Any:
    return t, np.tile(a[-1], (len(a), 1)), np.tile(g[-1], (len(g), 1))


def _noisy(t: Any, a: Any, g: Any, _m: Any) -> Any:
    rng = np.random.default_rng(3)
    return t, a + rng.normal(0, 0.05, a.shape), g + rng.normal(0, 0.005, g.shape)


def _noisy_with_a_gap(t: Any, a: Any, g: Any, m: Any) -> Any:
    t, a, g = _noisy(t, a, g, m)
    g[7, 1] = np.nan
    return t, a, g


def _of_chance(t: Any, a: Any, g: Any, _m: Any) -> Any:
    rng = np.random.default_rng(len(t))
    return t, rng.normal(0, 5, a.shape), rng.normal(0, 1, g.shape)


def _squared(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """Rows that follow the simulation in a way that no origin tells."""
    return t, np.sign(a) * a**2, np.sign(g) * np.abs(g) ** 1.5


def _smoothed(t: Any, a: Any, g: Any, _m: Any) -> Any:
    """The mean of nine rows, which come near the true ones."""

    def mean(rows: Any) -> Any:
        return np.stack([np.convolve(column, np.ones(9) / 9, "same") for column in rows.T], axis=1)

    return t, mean(a), mean(g)


def _last_row_of_a_recording(t: Any, _a: Any, _g: Any, _m: Any) -> Any:
    push = truth()["push"]
    return t, np.tile(push["acceleration"][599], (len(t), 1)), np.tile(push["angular_velocity"][599], (len(t), 1))


def _first_row_empty(t: Any, a: Any, g: Any, _m: Any) -> Any:
    return tuple(np.concatenate([column[:1] * 0, column]) for column in (t, a, g))


def _zeros_at_the_end(t: Any, a: Any, g: Any, _m: Any) -> Any:
    a[-9:], g[-9:] = 0, 0
    return t, a, g


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


SOUND = Recorder
FIXED = of(steps=lambda *_: 600)
HUNDRED_HERTZ = of(steps=lambda _s, _m, duration: round(duration / 0.002))
SHORT = of(steps=lambda _s, m, duration: round(duration / m.opt.timestep) - 20)
NO_STEPS = of(steps=lambda *_: 0)
ONE_MORE = of(steps=lambda _s, m, duration: round(duration / m.opt.timestep) + 1)
WHOLE_SECONDS = counting(lambda duration, dt: int(duration) / dt)
NO_RESET = of(begin=lambda *_: None)
NO_PUSH = of(push=lambda *_: None)
HALF = of(push=_pushed(0, 0.25))
SIDEWAYS = of(push=_pushed(1, 0.5))
WEAK = of(push=_pushed(0, 0.4))
LATER = of(push=lambda *_: None, step=_later)
TWICE = of(step=_later)
NEVER = of(step=_constant)
TWO_STEPS = of(step=lambda _s, m, data, _n: mujoco.mj_step(m, data, 2))
SWAPPED = telling(lambda t, a, g, _m: (t, g, a))
MILLISECONDS = telling(lambda t, a, g, _m: (1000 * t, a, g))
COUNTED = telling(lambda t, a, g, _m: (np.arange(len(t)) * 0.002, a, g))
SQUARED = telling(_squared)
SMOOTHED = telling(_smoothed)
TIME_ALONE = of(returned=lambda _s, t, _a, _g, _m: {"time": t})
WITHOUT_GYRO = of(returned=lambda _s, t, a, _g, _m: {"time": t, "acceleration": a})
WITHOUT_TIME = of(returned=lambda _s, _t, a, g, _m: {"acceleration": a, "angular_velocity": g})
NOTHING = of(returned=lambda *_: None)
STILL = telling(lambda t, a, g, _m: (t, a * 0 + 1, g * 0 + 1))
WITHOUT_ACCELERATION = telling(lambda t, a, g, _m: (t, a * 0, g))
"""As the arrays are where a line that fills one of them is missing."""

CASES = [
    Case(name, check, lambda kind=kind: Made(simulate_and_collect=_function(kind())), marked)  # type: ignore[misc]
    for check, rows in {
        NAMED: [
            ("sound", SOUND, None),
            ("other keys", of(returned=lambda _s, t, a, g, _m: {"t": t, "acc": a, "gyro": g}), (0.0, ["wrong-keys"])),
            ("a tuple", of(returned=lambda _s, t, a, g, _m: (t, a, g)), (0.0, ["wrong-return-type"])),
            ("transposed", telling(lambda t, a, g, _m: (t, a.T, g)), (0.0, ["arrays-transposed"])),
            ("without one", WITHOUT_GYRO, (0.0, ["wrong-keys"])),
            ("unequal lengths", telling(lambda t, a, g, _m: (t[:-1], a, g)), (0.0, ["wrong-return-type"])),
            ("nothing", NOTHING, (0.0, ["wrong-return-type"])),
            ("lists", telling(lambda t, a, g, _m: (t.tolist(), a.tolist(), g.tolist())), None),
            ("more beside them", of(returned=lambda s, *a: {**Recorder.returned(s, *a), "rate": 500.0}), None),
            ("a list", of(returned=lambda _s, t, a, g, _m: [t, a, g]), (0.0, ["wrong-return-type"])),
            ("without time", WITHOUT_TIME, (0.0, ["wrong-keys"])),
            (
                "no stamp under its name",
                of(returned=lambda _s, t, a, g, _m: {"time": [], "acceleration": a, "angular_velocity": g}),
                (0.0, ["wrong-return-type"]),
            ),
            (
                "None under a name",
                of(returned=lambda _s, t, a, g, _m: {"time": t, "acceleration": None, "angular_velocity": g}),
                (0.0, ["wrong-return-type"]),
            ),
            (
                "nothing under all names",
                of(returned=lambda _s, t, a, g, _m: {"time": [], "acceleration": [], "angular_velocity": []}),
                (0.0, []),
            ),
            ("a shorter one", telling(lambda t, a, g, _m: (t, a, g[:-2])), (0.0, ["wrong-return-type"])),
            (
                "magnitudes",
                telling(lambda t, a, g, _m: (t, np.linalg.norm(a, axis=1), g)),
                (0.0, ["wrong-return-type"]),
            ),
            ("two axes of both", telling(lambda t, a, g, _m: (t, a[:, :2], g[:, :2])), (0.0, ["wrong-return-type"])),
            ("no rows", NO_STEPS, (0.0, [])),
            (
                "other keys, transposed",
                of(returned=lambda _s, t, a, g, _m: {"t": t, "a": a.T, "w": g.T}),
                (0.0, ["wrong-keys", "arrays-transposed"]),
            ),
            (
                "all that can be odd",
                of(returned=lambda _s, t, a, g, _m: {"t": t[:, None], "a": a.T, "w": g.T, "dt": 0.002}),
                (0.0, ["wrong-keys", "wrong-return-type", "arrays-transposed"]),
            ),
            ("raises", of(begin=_raises), "raised"),
        ],
        COUNT: [
            ("raises with another time step", of(begin=_raises_with_another_time_step), "raised"),
            ("numbers of chance", telling(_of_chance), "skipped"),
            ("squared, twenty too few", both(SQUARED, SHORT), (0.0, [])),
            (
                "the same time always, two rows more",
                of(steps=lambda _s, m, _d: round(1.204 / m.opt.timestep)),
                (0.0, ["ignores-duration"]),
            ),
            ("zeros in one, which the rows are charged for", WITHOUT_ACCELERATION, None),
            ("rows that stand still", STILL, "skipped"),
            ("sound", SOUND, None),
            ("one more", ONE_MORE, None),
            ("always as many", FIXED, (0.0, ["ignores-duration"])),
            ("at a fixed rate", HUNDRED_HERTZ, (0.0, ["hard-coded-timestep"])),
            ("twenty too few", SHORT, (0.0, [])),
            ("every second", Skipping, (0.0, ["samples-skipped"])),
            ("none", NO_STEPS, (0.0, [])),
            ("no simulation", NEVER, "skipped"),
            ("its own time step, which is the reset's", of(begin=_own_timestep), None),
            ("one less", counting(lambda duration, dt: duration / dt - 1), None),
            ("two less", counting(lambda duration, dt: duration / dt - 2), (0.0, [])),
            ("two more", counting(lambda duration, dt: duration / dt + 2), (0.0, [])),
            ("twice as many", counting(lambda duration, dt: 2 * duration / dt), (0.0, [])),
            ("always five seconds", counting(lambda _duration, dt: 5 / dt), (0.0, ["ignores-duration"])),
            ("always half a second", counting(lambda _duration, dt: 0.5 / dt), (0.0, ["ignores-duration"])),
            ("fifty a second", FiftyHertz, (0.0, ["fixed-rate"])),
            ("always five, which the rows are charged for", of(steps=lambda *_: 5), None),
            ("room for more, which the rows are charged for", telling(_room), None),
            ("two steps a row, for twice the time", TWO_STEPS, None),
            ("twenty too few, without time", both(WITHOUT_TIME, SHORT), (0.0, [])),
            ("twenty too few, with noise", both(telling(_noisy), SHORT), (0.0, [])),
            ("a first row that is empty", telling(_first_row_empty), None),
            ("exchanged", SWAPPED, None),
            ("until the time, without a reset, which the reset is charged for", UntilTime, None),
        ],
        TIME: [
            ("sound", SOUND, None),
            ("and nothing else", TIME_ALONE, None),
            ("a step and a half too late", stamped(lambda t, dt: t + 1.5 * dt), (0.0, ["time-axis-wrong"])),
            (
                "every third step, ten too late",
                both(of(step=lambda s, m, d, n: mujoco.mj_step(m, d, 3)), stamped(lambda t, dt: t + 10 * dt)),
                (0.0, ["time-axis-wrong"]),
            ),
            (
                "two rows at a usual time step",
                both(COUNTED, of(steps=lambda *_: 2)),
                (0.5, ["hard-coded-timestep"]),
            ),
            (
                "a usual time step, with room for more",
                telling(lambda t, a, g, m: _room((1 + np.arange(len(t))) * 0.002, a, g, m)),
                (0.5, ["hard-coded-timestep"]),
            ),
            (
                "none in another time step",
                of(
                    returned=lambda s, t, a, g, m: (
                        Recorder.returned(s, t, a, g, m) if m.opt.timestep == 0.002 else {KEYS[1]: a, KEYS[2]: g}
                    )
                ),
                None,
            ),
            ("before each step", Before, None),
            ("milliseconds", MILLISECONDS, (0.0, ["time-axis-wrong"])),
            ("a step too late", telling(lambda t, a, g, _m: (t + 0.002, a, g)), (0.5, ["time-axis-wrong"])),
            ("a usual time step", COUNTED, (0.5, ["hard-coded-timestep"])),
            ("no numbers", telling(lambda t, a, g, _m: (t * np.nan, a, g)), (0.0, ["not-finite"])),
            ("none, which the form is charged for", WITHOUT_TIME, None),
            ("every second", Skipping, None),
            ("five steps too late", telling(lambda t, a, g, _m: (t + 0.01, a, g)), (0.0, ["time-axis-wrong"])),
            ("no rows", NO_STEPS, "skipped"),
            ("from zero to the end", stamped(lambda t, _: np.linspace(0, t[-1], len(t))), (0.5, ["time-axis-wrong"])),
            ("from zero on", stamped(lambda t, dt: np.arange(len(t)) * dt), None),
            ("half a step too late", stamped(lambda t, dt: t + dt / 2), (0.5, ["time-axis-wrong"])),
            ("numbers of rows", stamped(lambda t, _: np.arange(len(t))), (0.0, ["time-axis-wrong"])),
            ("that begins after settling", Settling, (0.0, ["time-axis-wrong"])),
            ("that stands still, which the push is charged for", ResetInTheLoop, None),
            ("zeros", stamped(lambda t, _: 0 * t), (0.0, ["time-axis-wrong"])),
            ("backward", stamped(lambda t, _: t[::-1]), (0.0, ["time-axis-wrong"])),
            ("one late stamp", _late(0.7), (0.0, ["time-axis-wrong"])),
            ("one stamp that is none", _late(np.nan), (0.0, ["not-finite"])),
            (
                "a usual time step, from one on",
                stamped(lambda t, _: (1 + np.arange(len(t))) * 0.002),
                (0.5, ["hard-coded-timestep"]),
            ),
            ("another time step than any", stamped(lambda t, _: np.arange(len(t)) * 0.001), (0.0, ["time-axis-wrong"])),
            ("that goes on, which the reset is charged for", NO_RESET, None),
            ("its own time step, which is the reset's", of(begin=_own_timestep), None),
            ("its own time step, put back", _for_the_run(_own_timestep), (0.0, ["time-axis-wrong"])),
            ("rows that are never filled", _empty(9), None),
            ("a first row that is empty", telling(_first_row_empty), None),
            ("a step before the loop, which the rows are charged for", StepBefore, None),
            ("one row", of(steps=lambda *_: 1), None),
            ("five rows", of(steps=lambda *_: 5), None),
            ("twenty too few", SHORT, None),
            ("beside noise", telling(_noisy), None),
        ],
        TRUTH: [
            ("always the last row of a recording", telling(_last_row_of_a_recording), (0.0, [])),
            ("squared", SQUARED, (0.0, [])),
            ("smoothed", SMOOTHED, (0.0, [])),
            ("zeros in one", WITHOUT_ACCELERATION, (0.0, [])),
            ("rows that stand still", STILL, (0.0, [])),
            ("sound", SOUND, None),
            ("before each step", Before, (0.5, ["read-before-step"])),
            (
                "late with stamps after it",
                type(
                    "Late",
                    (Before,),
                    {"returned": lambda s, t, a, g, m: Recorder.returned(s, t + m.opt.timestep, a, g, m)},
                ),
                (0.5, ["read-before-step"]),
            ),
            ("exchanged", SWAPPED, (0.0, ["channels-swapped"])),
            ("all like the last", telling(_aliased), (0.0, ["aliased-rows"])),
            ("every second, as many as fit", Skipping, None),
            ("every second, for twice the time", TWO_STEPS, (0.0, ["samples-skipped"])),
            ("of the last sensor", of(row=_last), (0.0, ["sensor-not-found"])),
            ("of the head", of(row=_head), (0.0, [])),
            ("zeros at the end", telling(_zeros_at_the_end), (0.5, ["rows-left-zero"])),
            ("without the first ones", telling(lambda t, a, g, _m: (t[30:], a[30:], g[30:])), (0.5, [])),
            ("in g", telling(lambda t, a, g, _m: (t, a / 9.81, g)), (0.0, ["rows-altered"])),
            ("both in other units", telling(lambda t, a, g, _m: (t, a / 9.81, np.degrees(g))), (0.0, ["rows-altered"])),
            ("noise on both", telling(_noisy), (0.0, [])),
            ("noise on one", telling(lambda t, a, g, m: (t, _noisy(t, a, g, m)[1], g)), (0.0, [])),
            ("no numbers in one", telling(lambda t, a, g, _m: (t, a * np.nan, g)), (0.0, ["not-finite"])),
            ("no numbers", telling(lambda t, a, g, _m: (t, a * np.nan, g * np.nan)), (0.0, ["not-finite"])),
            ("no simulation", NEVER, (0.0, ["nothing-simulated"])),
            ("without a push, which is another check's", NO_PUSH, None),
            ("a recording, altered", telling(_recorded), (0.0, ["rows-altered"])),
            ("without one sensor", WITHOUT_GYRO, (0.5, [])),
            ("another gravity for the run", _for_the_run(_heavier), (0.0, ["modifies-model"])),
            ("another gravity, which the reset is charged for", of(begin=_heavier), None),
            (
                "another time step for the run",
                _for_the_run(_own_timestep, steps=lambda *_: 600),
                (0.0, ["modifies-model"]),
            ),
            ("another pose, which the reset is charged for", of(begin=_in_pose(2, 0.05)), None),
            ("other velocities, which the push is charged for", of(push=_with_velocities), None),
            ("four rows", telling(lambda t, a, g, _m: (t[:4] * 0, a[:4] * 0 + 1, g[:4])), (0.0, [])),
            ("one row", telling(lambda t, a, g, _m: (t[:1], a[:1], g[:1])), (0.0, [])),
            ("three steps early", telling(lambda t, a, g, _m: (t[3:], a[3:], g[3:])), (0.5, [])),
            ("a step early", telling(lambda t, a, g, _m: (t[1:], a[1:], g[1:])), (0.5, [])),
            ("a step early, at the stamps of mj_forward", telling(lambda t, a, g, _m: (t[:-1], a[1:], g[1:])), None),
            ("a step before the loop", StepBefore, (0.5, [])),
            ("a first row that is empty", telling(_first_row_empty), (0.5, ["first-row-empty"])),
            ("in another order of axes", telling(lambda t, a, g, _m: (t, a[:, [1, 0, 2]], g)), (0.0, ["rows-altered"])),
            ("other signs", telling(lambda t, a, g, _m: (t, a, -g)), (0.0, ["rows-altered"])),
            ("with digits cut off", telling(lambda t, a, g, _m: (t, a.round(2), g)), (0.5, ["rows-altered"])),
            ("without gravity", telling(lambda t, a, g, _m: (t, a - [0, 0, 9.81], g)), (0.0, ["rows-altered"])),
            (
                "mixed",
                telling(lambda t, a, g, _m: (t, a @ [[1, 0.3, 0], [0, 1, 0], [0, 0.2, 1]] + 0.7, g)),
                (0.0, ["rows-altered"]),
            ),
            (
                "without the other sensor",
                of(returned=lambda _s, t, _a, g, _m: {"time": t, "angular_velocity": g}),
                (0.5, []),
            ),
            ("noise on the gyroscope", telling(lambda t, a, g, m: (t, a, _noisy(t, a, g, m)[2])), (0.0, [])),
            (
                "noise without one sensor",
                of(returned=lambda _s, t, a, g, m: {"time": t, "acceleration": _noisy(t, a, g, m)[1]}),
                (0.0, []),
            ),
            ("noise, and one number that is none", telling(_noisy_with_a_gap), (0.0, ["not-finite"])),
            ("five rows", telling(lambda t, a, g, _m: (t[:5], a[:5], g[:5])), (0.0, [])),
            ("one row that is never filled", _empty(1), (0.75, ["rows-left-zero"])),
            ("two rows that are never filled", _empty(2), (0.5, ["rows-left-zero"])),
            ("room for more", telling(_room), (0.5, ["rows-left-zero"])),
            ("fifty a second, which the count is charged for", FiftyHertz, None),
            ("twenty too few, which the count is charged for", SHORT, None),
            ("no reset, which is another check's", NO_RESET, None),
            ("half a push, which is another check's", HALF, None),
            ("a later push, which is another check's", LATER, None),
            ("a force, which is another check's", of(push=_forced), None),
            ("before each step, without time", both(WITHOUT_TIME, Before), (0.5, ["read-before-step"])),
            ("two steps early", telling(lambda t, a, g, _m: (t[2:], a[2:], g[2:])), (0.5, [])),
            (
                "one sensor like its last row",
                telling(lambda t, a, g, _m: (t, a, np.tile(g[-1], (len(g), 1)))),
                (0.0, []),
            ),
        ],
        RESET: [
            ("none of a run of less than a second, which the count is charged for", WHOLE_SECONDS, None),
            ("no rows at all", NO_STEPS, "skipped"),
            ("a recording of the hidden run", telling(_recorded_as_it_was), "skipped"),
            ("time alone", TIME_ALONE, "skipped"),
            ("squared", SQUARED, None),
            ("smoothed", SMOOTHED, None),
            ("none, squared", both(SQUARED, NO_RESET), (0.0, ["no-reset"])),
            ("of all but the pose, squared", both(SQUARED, of(begin=_keeps_pose)), (0.0, ["no-reset"])),
            ("another pose, smoothed", both(SMOOTHED, of(begin=_in_pose(2, 0.05))), (0.0, ["no-reset"])),
            ("numbers of chance", telling(_of_chance), "skipped"),
            ("zeros in one, which the rows are charged for", WITHOUT_ACCELERATION, None),
            ("rows that stand still", STILL, "skipped"),
            ("sound", SOUND, None),
            ("none", NO_RESET, (0.0, ["no-reset"])),
            ("another gravity", of(begin=_heavier), (0.0, ["modifies-model"])),
            ("another time step", of(begin=_own_timestep), (0.0, ["modifies-model"])),
            ("another pose", of(begin=_in_pose(2, 0.05)), (0.0, ["no-reset"])),
            ("a reset that leaves the velocities", of(begin=_keeps_velocities), (0.0, ["no-reset"])),
            ("another gravity for the run", _for_the_run(_heavier), None),
            ("lists that stay", Keeping, (0.0, ["keeps-old-rows"])),
            ("without a push", NO_PUSH, None),
            ("no simulation", NEVER, "skipped"),
            ("noise on both", telling(_noisy), None),
            ("without one sensor", WITHOUT_GYRO, None),
            ("another push each time", Random, None),
            ("another gravity and time step", of(begin=_other_gravity_and_timestep), (0.0, ["modifies-model"])),
            ("of all but the time", of(begin=_keeps_time), (0.0, ["no-reset"])),
            ("of all but the pose", of(begin=_keeps_pose), (0.0, ["no-reset"])),
            ("none, without time", both(WITHOUT_TIME, NO_RESET), (0.0, ["no-reset"])),
            ("none, with noise", both(telling(_noisy), NO_RESET), (0.0, ["no-reset"])),
            ("none, with noise, without time", both(WITHOUT_TIME, telling(_noisy), NO_RESET), (0.0, ["no-reset"])),
            ("none, and another push each time", both(Random, NO_RESET), (0.0, ["no-reset"])),
            ("another pose, with noise", both(telling(_noisy), of(begin=_in_pose(2, 0.05))), (0.0, ["no-reset"])),
            ("noise, and another push each time", both(telling(_noisy), Random), None),
            ("noise, and half a push", both(telling(_noisy), HALF), None),
            ("before each step", Before, None),
            ("exchanged", SWAPPED, None),
            ("a later push", LATER, None),
            ("always as many", FIXED, None),
        ],
        PUSH: [
            ("time alone", TIME_ALONE, "skipped"),
            ("squared", SQUARED, None),
            ("smoothed", SMOOTHED, None),
            ("half of it, squared", both(SQUARED, HALF), (0.0, ["wrong-perturbation"])),
            ("numbers of chance", telling(_of_chance), "skipped"),
            ("zeros in one, which the rows are charged for", WITHOUT_ACCELERATION, None),
            ("rows that stand still", STILL, "skipped"),
            ("sound", SOUND, None),
            ("none", NO_PUSH, (0.0, ["no-perturbation"])),
            ("half of it", HALF, (0.0, ["wrong-perturbation"])),
            ("sideways", SIDEWAYS, (0.0, ["wrong-perturbation"])),
            ("somewhat weak", WEAK, (0.0, ["wrong-perturbation"])),
            ("later", LATER, (0.0, ["wrong-perturbation"])),
            ("once more", TWICE, (0.0, ["wrong-perturbation"])),
            ("other velocities beside it", of(push=_with_velocities), (0.0, ["wrong-perturbation"])),
            ("two other velocities beside it", of(push=_with_three_velocities), (0.0, ["wrong-perturbation"])),
            ("twice more", of(step=_later_twice), (0.0, ["wrong-perturbation"])),
            ("another pose, which the reset is charged for", of(begin=_in_pose(2, 0.05)), None),
            (
                "none, in a model that is changed for the run",
                _for_the_run(_heavier, push=lambda *_: None),
                (0.0, ["no-perturbation"]),
            ),
            (
                "later, in a model that is changed for the run",
                _for_the_run(_heavier, push=lambda *_: None, step=_later),
                (0.0, ["wrong-perturbation"]),
            ),
            ("the sheet's, in a model that is changed for the run", _for_the_run(_heavier), None),
            ("with a force", of(push=_forced), (0.0, ["wrong-perturbation"])),
            ("in every step", ResetInTheLoop, (0.0, ["wrong-perturbation"])),
            ("another each time", Random, (0.0, ["random-push"])),
            ("noise on both", telling(_noisy), None),
            ("no simulation", NEVER, "skipped"),
            ("no reset, which is another check's", NO_RESET, None),
            ("noise and none", type("Two", (telling(_noisy),), {"push": lambda *_: None}), "skipped"),
            ("backward", of(push=_pushed(0, -0.5)), (0.0, ["wrong-perturbation"])),
            ("twice as strong", of(push=_pushed(0, 1.0)), (0.0, ["wrong-perturbation"])),
            ("upward", of(push=_pushed(2, 0.5)), (0.0, ["wrong-perturbation"])),
            ("a turn", of(push=_pushed(3, 0.5)), (0.0, ["wrong-perturbation"])),
            (
                "a force alone",
                of(push=lambda _s, d: d.qfrc_applied.__setitem__(0, 30.0)),
                (0.0, ["wrong-perturbation"]),
            ),
            ("half of it, with noise", both(telling(_noisy), HALF), (0.0, ["wrong-perturbation"])),
            ("sideways, with noise", both(telling(_noisy), SIDEWAYS), (0.0, ["wrong-perturbation"])),
            ("somewhat weak, with noise", both(telling(_noisy), WEAK), (0.0, ["wrong-perturbation"])),
            ("later, with noise", both(telling(_noisy), LATER), (0.0, ["wrong-perturbation"])),
            ("another each time, with noise", both(telling(_noisy), Random), (0.0, ["random-push"])),
            ("another pose, with noise", both(telling(_noisy), of(begin=_in_pose(2, 0.05))), None),
            ("velocities that are left", of(begin=_keeps_velocities), None),
            (
                "none, of altered rows",
                both(telling(lambda t, a, g, _m: (t, a * 1.01, g)), NO_PUSH),
                (0.0, ["no-perturbation"]),
            ),
        ],
    }.items()
    for name, kind, marked in rows
]
CASES.append(Case("in another order", NAMED, lambda: Made(simulate_and_collect=_turned), (0.0, ["other-parameters"])))


def _turned(data: Any, model: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None) -> Any:
    return Recorder()(model, data, duration_seconds, accel_id, gyro_id)


def _function(recorder: Recorder) -> Callable[..., Any]:
    def simulate_and_collect(
        model: Any, data: Any, duration_seconds: float = 5.0, accel_id: Any = None, gyro_id: Any = None
    ) -> Any:
        return recorder(model, data, duration_seconds, accel_id, gyro_id)

    return simulate_and_collect


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_recorder_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)


CHARGED = [
    (SOUND, []),
    (ONE_MORE, []),
    (FIXED, [COUNT]),
    (HUNDRED_HERTZ, [COUNT]),
    (SHORT, [COUNT]),
    (Skipping, [COUNT]),
    (FiftyHertz, [COUNT]),
    (NO_RESET, [RESET]),
    (UntilTime, [RESET]),
    (Rollout, []),
    (both(Rollout, NO_RESET), [RESET]),
    (both(Rollout, NO_PUSH), [PUSH]),
    (both(Rollout, HALF), [PUSH]),
    (of(begin=_heavier), [RESET]),
    (of(begin=_in_pose(2, 0.05)), [RESET]),
    (NO_PUSH, [PUSH]),
    (SIDEWAYS, [PUSH]),
    (WEAK, [PUSH]),
    (LATER, [PUSH]),
    (Random, [PUSH]),
    (TWO_STEPS, [TRUTH]),
    (SWAPPED, [TRUTH]),
    (Before, [TRUTH]),
    (StepBefore, [TRUTH]),
    (telling(_aliased), [TRUTH]),
    (telling(_noisy), [TRUTH]),
    (telling(_first_row_empty), [TRUTH]),
    (_empty(9), [TRUTH]),
    (_empty(1), [TRUTH]),
    (Settling, [TIME]),
    (_for_the_run(_heavier), [TRUTH]),
    (of(row=_head), [TRUTH]),
    (MILLISECONDS, [TIME]),
    (COUNTED, [TIME]),
]


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "charged"), CHARGED)
def test_one_fault_is_charged_by_one_check(kind: Callable[[], Recorder], charged: list[Any]) -> None:
    student = Made(simulate_and_collect=_function(kind()))
    cases = [Case("", check, lambda: student) for check in (NAMED, COUNT, TIME, TRUTH, RESET, PUSH)]
    assert [case.check for case in cases if finding(case) is not None] == charged


def _squaring(model: Any, data: Any, accel_id: int, gyro_id: int) -> Any:
    """A reader of numbers that no treatment of a reading explains."""
    _, accel, gyro = Recorder().row(model, data, accel_id, gyro_id)
    return np.sin(accel) + accel**2, np.sin(gyro) + gyro**2


class OwnReader(Recorder):
    """One that stores what its submission's own reader gives."""

    def row(self, model: Any, data: Any, accel_id: int, gyro_id: int) -> tuple[Any, Any, Any]:
        return data.time, *_squaring(model, data, accel_id, gyro_id)


@pytest.mark.quick
@pytest.mark.parametrize("check", [COUNT, TIME, TRUTH, RESET, PUSH], ids=lambda check: check.check.id)
def test_rows_that_the_submissions_own_reader_gives_are_the_readers_fault_alone(check: Any) -> None:
    def student() -> Made:
        return Made(simulate_and_collect=_function(OwnReader()), get_imu_readings=_squaring)

    assert finding(Case("of its own reader", check, student)) is None


@pytest.mark.quick
def test_the_charts_of_a_report_find_the_recording() -> None:
    student = Made(simulate_and_collect=_function(Recorder()))
    COUNT(student, truth())
    assert len(student.answered("push").time) == 600


def _two_of_three(values: np.ndarray) -> np.ndarray:
    return values[np.arange(len(values)) % 3 > 0]


_SHAPE, _ROWS = (0.0, ["wrong-return-type"]), (0.0, ["rows-altered"])


@pytest.mark.quick
@pytest.mark.parametrize(
    ("stamps", "rows", "scale", "kept"),
    [
        (lambda t: t[::2], slice(None), 0.5, [_SHAPE, None, None, _ROWS, None, None]),
        (_two_of_three, slice(None), 0.5, [_SHAPE, None, None, _ROWS, None, None]),
        (_two_of_three, slice(7, None), 1.0, [_SHAPE, (0.0, []), None, (0.5, []), None, None]),
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
    cases = [
        Case("of any length", check, lambda: Made(simulate_and_collect=_function(kind())))
        for check in (NAMED, COUNT, TIME, TRUTH, RESET, PUSH)
    ]
    assert [marked(finding(case)) for case in cases] == kept
