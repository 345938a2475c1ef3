"""Questions about the sheet's extensions, and what came back, as plain arrays.

An extension is asked about only where its name is defined somewhere: a submission without one costs no time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from grader.engine.findings import Fault
from grader.engine.question import Question
from grader.labs.imu.answers import Array, Arrays, Node, Reading, as_reading, numbers, shape_in_words
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame

# --- the complementary filter --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TiltCase:
    """A filter's input: specific force and angular velocity (n, 3), every `dt` seconds."""

    dt: float
    acceleration: Array
    angular_velocity: Array


@dataclass(frozen=True)
class TiltRun:
    """A filter's output: roll and pitch (n, 2), fewer rows where it raised; `odd` is the first value that is no such pair."""

    output: Array
    odd: str | None
    fault: Fault | None


def tilt(student: Student, cases: Sequence[TiltCase]) -> list[TiltRun]:
    """Run a new `ComplementaryFilter` over each case."""
    arrays = {f"a{i}": case.acceleration for i, case in enumerate(cases)}
    arrays |= {f"g{i}": case.angular_velocity for i, case in enumerate(cases)}
    rows = [{"dt": case.dt, "accel": f"a{i}", "gyro": f"g{i}"} for i, case in enumerate(cases)]
    return student.answer(Question("tilt", "ComplementaryFilter", _tilt_runs, {"cases": rows}, arrays))


def _tilt_runs(frame: Frame) -> list[TiltRun]:
    return [_tilt_run(answer, frame.arrays) for answer in frame.fields["cases"]]


def _tilt_run(answer: Mapping[str, Any], arrays: Arrays) -> TiltRun:
    odd = answer["odd"]
    return TiltRun(arrays[answer["output"]], shape_in_words(odd, arrays) if odd else None, Fault.of(answer["error"]))


# --- the Allan deviation -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class AllanRun:
    """Averaging times (k,) in s and deviations (k, c), c columns as in the input; None where they could not be made out."""

    taus: Array | None
    adev: Array | None
    shape: str
    fault: Fault | None


def allan(student: Student, samples: Array, sample_rate_hz: float) -> AllanRun:
    """Return the result of `allan_deviation` for samples (n,) or (n, 3)."""
    becomes = partial(_allan_run, columns=1 if samples.ndim == 1 else samples.shape[1])
    fields = {"sample_rate_hz": sample_rate_hz}
    return student.answer(Question("allan", "allan_deviation", becomes, fields, {"samples": samples}))


def _allan_run(frame: Frame, columns: int) -> AllanRun:
    node = frame.fields["value"]
    taus, adev = _curve(node, frame.arrays, columns)
    return AllanRun(taus, adev, shape_in_words(node, frame.arrays), Fault.of(frame.fields.get("error")))


def _curve(node: Node | None, arrays: Arrays, columns: int) -> tuple[Array | None, Array | None]:
    taus, adev = _two(node, arrays)
    if taus is None or adev is None:
        return None, None
    taus = np.ravel(taus)
    for shaped in (adev, adev.T):
        if shaped.size == len(taus) * columns and shaped.shape[:1] == taus.shape:
            return taus, shaped.reshape(len(taus), columns)
    same = adev.ndim == 2 and 1 in adev.shape and adev.size == len(taus) * columns
    return (taus, adev.reshape(len(taus), columns)) if same else (None, None)


def _two(node: Node | None, arrays: Arrays) -> tuple[Array | None, Array | None]:
    """The two parts of a pair, or of an array with two rows."""
    if node is None or node["kind"] in ("dict", "object"):
        return None, None
    if "key" in node:
        whole = arrays[node["key"]]
        return (whole[0], whole[1]) if whole.ndim == 2 and len(whole) == 2 else (None, None)
    items = node.get("items", ())
    return (numbers(items[0], arrays), numbers(items[1], arrays)) if len(items) >= 2 else (None, None)


# --- many IMUs -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ImuReadings:
    """The results of `read_all_imus` in each state, by place; `later` is the first result, examined after the next step."""

    calls: tuple[Mapping[str, Reading], ...]
    later: Mapping[str, Reading]
    shape: str
    fault: Fault | None


def imus(student: Student, *, model: str, qpos: Array, qvel: Array) -> ImuReadings:
    """Readings of all IMUs of a model in states (k, nq), (k, nv)."""
    return student.answer(
        Question("imus", "read_all_imus", _imu_readings, {"model": model}, {"qpos": qpos, "qvel": qvel})
    )


def _imu_readings(frame: Frame) -> ImuReadings:
    calls = tuple(_by_place(node, frame.arrays) for node in frame.fields["calls"])
    shape = shape_in_words(frame.fields["calls"][0], frame.arrays) if calls else "nothing"
    fault = Fault.of(frame.fields.get("error"))
    return ImuReadings(calls, _by_place(frame.fields["later"], frame.arrays), shape, fault)


def _by_place(node: Node | None, arrays: Arrays) -> dict[str, Reading]:
    """Readings by place; capitals and an ending ``_imu`` do not matter."""
    if node is None or node["kind"] not in ("dict", "object"):
        return {}
    return {name.lower().removesuffix("_imu"): as_reading(item, arrays) for name, item in node["items"]}


# --- a plot that grows ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SeenCurve:
    """A curve as it was shown when `moment` seconds had been simulated."""

    moment: float
    label: str
    x: Array
    y: Array


@dataclass(frozen=True)
class LiveRun:
    """The observations while `live_plot` ran.

    Attributes
    ----------
    events : (k, 3) ndarray, each time that the curves had changed: seconds simulated, points drawn, changes so far
    curves : the curves of a few moments; simulated : seconds in all; returned : whether it came back
    """

    events: Array
    curves: tuple[SeenCurve, ...]
    simulated: float
    returned: bool
    fault: Fault | None


def live(
    student: Student, *, model: str, ids: tuple[int, int], duration_s: float, timestep: float, push: float
) -> LiveRun:
    """Run `live_plot` on a model that starts with a push."""
    fields = {
        "model": model, "accel_id": ids[0], "gyro_id": ids[1], "duration_s": duration_s, "timestep": timestep, "push": push
    }  # fmt: skip
    return student.answer(Question("live", "live_plot", _live_run, fields))


def _live_run(frame: Frame) -> LiveRun:
    answer = frame.fields
    curves = [SeenCurve(c["moment"], c["label"], frame.arrays[c["x"]], frame.arrays[c["y"]]) for c in answer["curves"]]
    fault = Fault.of(answer.get("error"))
    return LiveRun(frame.arrays["events"], tuple(curves), float(answer["simulated"]), bool(answer["returned"]), fault)
