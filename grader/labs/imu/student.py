"""Ask the submitted code the questions of the lab's five criteria, and return its answers as plain arrays.

If a criterion lost points, the sandbox replaces its functions by the grader's own (stand-ins) for the criteria that follow, so that
one fault is deducted once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import Missing, StudentError
from grader.engine.question import Question, key_of
from grader.labs.imu.answers import FilterRun, NoiseRun, Readings, as_reading, three
from grader.labs.imu.collection import Collection, as_collection
from grader.labs.imu.plotting import Plotting
from grader.labs.imu.returned import Array, shape_in_words
from grader.sandbox.wire import Frame


@dataclass(frozen=True)
class FilterCase:
    """One use of the student's filter that a check asks for: the signal that goes in, and the arguments of the filter.

    Attributes
    ----------
    signal : (n, 3) ndarray, the measurements in order
    alpha : the filter's `alpha`; None leaves out this argument
    initial : (3,) ndarray, the filter's `initial_value`; None leaves it out
    handling : what else the caller does: "plain": nothing; "spoil_input", "spoil_output": overwrite each array that went in or came
        out; "beside": feed other data to a second filter in between
    """

    signal: Array
    alpha: float | None = None
    initial: Array | None = None
    handling: str = "plain"


class Student(Plotting):
    """Session with the sandbox about one submission: each method calls the student's code; equal calls share one answer.

    A call may have a name (`called`), by which the charts of a report find its answer.
    """

    def read(self, *, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        """Return what `get_imu_readings` reads for every pair of sensors in every state of a model; in `error`, what it raises.

        Parameters
        ----------
        model : MJCF text of the model
        qpos, qvel : (k, nq) and (k, nv) ndarrays, the states
        pairs : (p, 2) ndarray of int, the ids of an accelerometer and a gyroscope in each row
        """
        becomes = partial(_readings, shape=(len(pairs), len(qpos)))
        arrays = {"qpos": qpos, "qvel": qvel, "pairs": pairs}
        return self.answer(Question("read", "get_imu_readings", becomes, {"model": model}, arrays))

    def read_in_new_process(self, *, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        """Return what `read` returns for these arguments, but from a new process, so that nothing of earlier calls is remembered.

        `model` is MJCF text; `qpos` and `qvel` hold a state in each row, `pairs` the ids of an accelerometer and a gyroscope.
        """
        self.end_session()
        return self.read(model=model, qpos=qpos, qvel=qvel, pairs=pairs)

    def simulate(self, *, duration_s: float, ids: tuple[int, int], timestep: float | None = None,
                 dirty: tuple[Array, Array, float] | None = None, gravity: Array | None = None,
                 called: str = "") -> Collection:  # fmt: skip
        """Return what `simulate_and_collect` records on the robot that is graded; in `error`, what it raises.

        Parameters
        ----------
        duration_s : the duration in seconds
        ids : the ids of accelerometer and gyroscope
        timestep : the model's time step in seconds; None leaves that of the model
        dirty : qpos (nq,), qvel (nv,) and time in seconds that the data hold when they are handed over; None hands over new data
        gravity : (3,) ndarray in m/s², the model's gravity; None leaves that of the model
        called : name of the recording, by which charts find it; "" for none
        """
        fields = {
            "model": self.robot.xml, "duration_s": duration_s, "timestep": timestep,
            "accel_id": ids[0], "gyro_id": ids[1], "time_s": dirty[2] if dirty else 0.0,
        }  # fmt: skip
        arrays = {"qpos": dirty[0], "qvel": dirty[1]} if dirty else {}
        arrays |= {} if gravity is None else {"gravity": gravity}
        return self.answer(Question("simulate", "simulate_and_collect", _collected, fields, arrays), called)

    def replay(self, course: Mapping[str, Array], steps: int) -> Array | None:
        """Simulate again, in a worker without student code, a run that the student's process reported; return its sensordata.

        `course` is the reported run, its start and the changes of its state, by the names in `worker.questions.replay`. The result
        (steps, n) is None if it cannot be simulated: a student's process may report anything.
        """
        fields = {"model": self.robot.xml, "steps": steps}
        return self.once(key_of("replay", fields, course), lambda: self._replay(fields, course))

    def _replay(self, fields: Mapping[str, Any], course: Mapping[str, Array]) -> Array | None:
        try:
            frame = self.retried(lambda: self.ask_fresh_worker("replay", fields, course))
        except NoAnswer:
            return None
        rows = frame.arrays["sensordata"]
        return rows if np.isfinite(rows).all() else None

    def read_along(self, course: Mapping[str, Array], steps: int, ids: tuple[int, int]) -> Array | None:
        """Return what `get_imu_readings` reads (steps, 6) after each step of a run that is simulated again.

        `course` is the run, as for `replay`. None unless each step gives six finite numbers: the function may be missing, or raise.
        """
        fields = {"model": self.robot.xml, "steps": steps, "accel_id": ids[0], "gyro_id": ids[1]}
        question = Question("read_along", "get_imu_readings", lambda frame: frame.arrays["rows"], fields, course)
        try:
            rows = self.answer(question)
        except (Missing, NoAnswer):
            return None
        return rows if len(rows) == steps and np.isfinite(rows).all() else None

    def noise(self, *, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: tuple[float, float],
              biases: tuple[Array, Array] | None, called: str = "") -> NoiseRun:  # fmt: skip
        """Return many reads of one `NoisyIMU`, in one state after the other; in `error`, what it raises.

        Parameters
        ----------
        qpos, qvel : (k, nq) and (k, nv) ndarrays, the states
        ids : the ids of accelerometer and gyroscope
        reads : number of reads in each state
        stds : standard deviations of the noise in m/s² and rad/s
        biases : the (3,) biases in m/s² and rad/s; None leaves out these arguments
        called : name of the reads, by which charts find them; "" for none
        """
        given = {"accel_bias": biases[0], "gyro_bias": biases[1]} if biases else {}
        arrays = {"qpos": qpos, "qvel": qvel, **given}
        return self.answer(
            Question("noise", "NoisyIMU", _noise_run, self._noise_fields(ids, reads, stds), arrays), called
        )

    def noise_twins(self, *, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: Sequence[tuple[float, float]],
                    biases: Array | None, states: Sequence[int]) -> NoiseRun:  # fmt: skip
        """Return reads (twins, reads, 3) of several `NoisyIMU`s with one random seed, so that only their arguments differ.

        For each instance (twin), `stds` holds the two standard deviations, `biases` (twins, 2, 3) both biases, and `states` the row
        of its state in `qpos` and `qvel`. If `biases` is None, these arguments are left out. `reads` is the number for each twin.
        """
        fields = self._noise_fields(ids, reads, stds[0])
        fields["twins"] = [{"accel_noise_std": accel, "gyro_noise_std": gyro} for accel, gyro in stds]
        fields["states"] = list(states)
        arrays = {"qpos": qpos, "qvel": qvel} | ({} if biases is None else {"biases": biases})
        return self.answer(Question("noise_twins", "NoisyIMU", _noise_run, fields, arrays))

    def default_bias(self, *, qpos: Array, qvel: Array, ids: tuple[int, int], instances: int, stds: tuple[float, float],
                     one_draw: bool = False) -> NoiseRun:  # fmt: skip
        """Make many `NoisyIMU`s without bias arguments, so that each chooses its default; return three reads of each in one state.

        The reads are (instances, 3, 3). `qpos` and `qvel` hold the state in their first row; `ids` and `stds` (noise in m/s² and
        rad/s) are those of accelerometer and gyroscope. If `one_draw`, all random generators are seeded alike before each read, so
        that all reads have the same noise and differ by the bias alone.
        """
        fields = self._noise_fields(ids, 3, stds) | {"instances": instances, "one_draw": one_draw}
        return self.answer(Question("default_bias", "NoisyIMU", _noise_run, fields, {"qpos": qpos, "qvel": qvel}))

    def _noise_fields(self, ids: tuple[int, int], reads: int, stds: tuple[float, float]) -> dict[str, Any]:
        """Return the inputs that all calls of a `NoisyIMU` share."""
        return {
            "model": self.robot.xml, "accel_id": ids[0], "gyro_id": ids[1], "reads": reads,
            "accel_noise_std": stds[0], "gyro_noise_std": stds[1],
        }  # fmt: skip

    def filter(self, cases: Sequence[FilterCase], called: str = "") -> list[FilterRun]:
        """Run a new `LowPassFilter` for each case, in order; in `error`, what it raises. Charts find the runs by `called`."""
        arrays: dict[str, np.ndarray] = {}
        rows = []
        for number, case in enumerate(cases):
            arrays[f"s{number}"] = case.signal
            initial = None
            if case.initial is not None:
                initial = f"i{number}"
                arrays[initial] = case.initial
            rows.append({"input": f"s{number}", "alpha": case.alpha, "initial": initial, "handling": case.handling})
        return self.answer(Question("filter", "LowPassFilter", _filter_runs, {"cases": rows}, arrays), called)

    def filter_alone(self, case: FilterCase) -> FilterRun:
        """Return the output for one filter case in a new process, so that no earlier filter has changed a shared state."""
        self.end_session()
        return self.filter([case])[0]


def _readings(frame: Frame, shape: tuple[int, int]) -> Readings:
    """Convert the worker's reply to `read`: rows for `shape` = (pairs, states)."""
    calls = [as_reading(node, frame.arrays) for node in frame.fields["calls"]]
    later = [as_reading(node, frame.arrays) for node in frame.fields["later"]]
    oddities = tuple(dict.fromkeys(call.oddity for call in calls if call.oddity))
    return Readings(
        accel=_grid([call.accel for call in calls], shape),
        gyro=_grid([call.gyro for call in calls], shape),
        later_accel=_grid([call.accel for call in later], shape[:1]),
        later_gyro=_grid([call.gyro for call in later], shape[:1]),
        oddities=oddities,
        disturbance=frame.arrays["disturbance"],
        error=StudentError.of(frame.fields.get("error")),
        departs=tuple(frame.fields["departs"]),
        whole=all(call.whole for call in calls),
    )


def _collected(frame: Frame) -> Collection:
    """Convert the worker's reply to `simulate` to a recording; without any series if the student's code raised."""
    error = StudentError.of(frame.fields.get("error"))
    changed = tuple(frame.fields["changed"])
    if error is not None:
        return Collection(None, None, None, changed=changed, error=error)
    collected = as_collection(frame.fields["value"], frame.arrays).with_zeros_for_empty_rows()
    return replace(
        collected, changed=changed, first_step=_believable(frame.arrays), departs=tuple(frame.fields["departs"])
    )


def _believable(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """Return the run that the student's process reports, by name; empty if it is incomplete or impossible.

    The worker records it beside student code, which may have changed it.
    """
    names = ("qpos", "qvel", "gravity", "timestep", "force", "steps", "set_at", "set_qpos", "set_qvel", "set_force")
    claim = {name: arrays[f"first_{name}"] for name in names if f"first_{name}" in arrays}
    sound = len(claim) == len(names) and all(np.isfinite(value).all() for value in claim.values())
    sound = sound and len({len(claim[name]) for name in names if name.startswith("set_")}) == 1
    return claim if sound and 1e-6 <= claim["timestep"][0] <= 1.0 and claim["steps"][0] >= 0 else {}


def _grid(vectors: Sequence[Array | None], shape: tuple[int, ...]) -> Array:
    """Return vectors as an array of this shape and a last axis of 3; NaN for a missing vector."""
    out = np.full((int(np.prod(shape)), 3), np.nan)
    for row, vector in zip(out, vectors, strict=False):
        row[:] = three(vector)
    return out.reshape(*shape, 3)


def _noise_run(frame: Frame) -> NoiseRun:
    """Convert the worker's reply about a `NoisyIMU` to plain arrays."""
    odd = frame.fields["odd"]
    return NoiseRun(
        accel=frame.arrays["accel"],
        gyro=frame.arrays["gyro"],
        disturbance=frame.arrays.get("disturbance", np.zeros((0, 4))),
        odd=as_reading(odd, frame.arrays).oddity if odd else None,
        error=StudentError.of(frame.fields.get("error")),
        departs=tuple(frame.fields["departs"]),
    )


def _filter_runs(frame: Frame) -> list[FilterRun]:
    return [_filter_run(answer, frame) for answer in frame.fields["cases"]]


def _filter_run(answer: Mapping[str, Any], frame: Frame) -> FilterRun:
    """Convert the worker's answer about one filter case to a `FilterRun`."""
    odd = answer["odd"]
    return FilterRun(
        output=frame.arrays[answer["output"]] if answer["output"] else None,
        odd=shape_in_words(odd, frame.arrays) if odd else None,
        error=StudentError.of(answer["error"]),
        input_changed=bool(answer["input_changed"]),
        output_changed=bool(answer["output_changed"]),
        departs=tuple(answer["departs"]),
    )
