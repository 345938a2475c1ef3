"""Types and rules that the sandbox worker's reply to each of this lab's questions has to meet, or it is rejected."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from grader.engine.replies import Answer, Called, Drawings, ErrorReply, Points, Rule, Wrong, drawings, points
from grader.engine.reply_types import Long, Number, Short

_Parameter = Literal[
    "model", "data", "accel_sensor_id", "gyro_sensor_id", "accel_id", "gyro_id", "duration_seconds", "accel_noise_std",
    "gyro_noise_std", "accel_bias", "gyro_bias", "alpha", "initial_value", "measurement", "dt", "imu_data", "time",
    "acceleration", "angular_velocity", "file_name", "title", "n_steps", "global model", "global data",
    "global imu_data", "global measurement", "accel", "gyro", "name for accel_sensor_id", "name for gyro_sensor_id",
    "method read", "method update",
]  # fmt: skip
Departures = Annotated[list[_Parameter], Meta(max_length=31)]
"""Names of parameters that a call departs from: only those that the grader itself uses."""


def _changes(answer: Answer, most: int) -> None:
    if len(answer.array("disturbance", None, 4)) > most:
        raise Wrong("more changes than calls")


# --- questions about the lab's parts -------------------------------------------------------------------------------------


class Read(Called, kw_only=True):
    departs: Departures
    calls: list[Any]
    later: list[Any]


def _read(answer: Answer, reply: Read) -> None:
    pairs, states = len(answer.asked["pairs"]), len(answer.asked["qpos"])
    whole = reply.error is None
    answer.nodes(reply.calls, pairs * states, pairs * states if whole else None)
    answer.nodes(reply.later, pairs, pairs if whole else None)
    _changes(answer, pairs * (states + 1))


class Simulate(Called, kw_only=True):
    value: Any
    changed: Annotated[list[Short], Meta(max_length=20)]
    departs: Departures


def _simulate(answer: Answer, reply: Simulate) -> None:
    answer.node(reply.value)
    for name in answer.frame.arrays:
        if name.startswith("first_set_q") or name == "first_set_force":
            answer.array(name, None, None)
        elif name.startswith("first_"):
            answer.array(name, {"first_gravity": 3, "first_timestep": 1, "first_steps": 1}.get(name))


def _read_along(answer: Answer, reply: Called) -> None:
    if len(answer.array("rows", None, 6)) > answer.fields["steps"]:
        raise Wrong("more rows than steps")


class Draws(Called, kw_only=True):
    odd: Any
    departs: Departures


def _noise(answer: Answer, reply: Draws) -> None:
    states = len(answer.asked["qpos"])
    _draws(answer, reply, states)
    _changes(answer, states)


def _default_bias(answer: Answer, reply: Draws) -> None:
    _draws(answer, reply, answer.fields["instances"])


def _noise_twins(answer: Answer, reply: Draws) -> None:
    _draws(answer, reply, len(answer.fields["twins"]))


def _draws(answer: Answer, reply: Draws, rows: int) -> None:
    answer.node(reply.odd)
    for name in ("accel", "gyro"):
        answer.array(name, rows, answer.fields["reads"], 3)


class TiltCase(Struct):
    output: Short | None
    odd: Any
    error: ErrorReply | None


class FilterCase(TiltCase):
    departs: Departures
    input_changed: bool
    output_changed: bool


class Filter(Called, kw_only=True):
    cases: list[FilterCase]


class Tilt(Called, kw_only=True):
    cases: list[TiltCase]


def _filter(answer: Answer, reply: Filter) -> None:
    _cases(answer, reply, "input")


def _tilt(answer: Answer, reply: Tilt) -> None:
    _cases(answer, reply, "accel", (2,))


def _cases(answer: Answer, reply: Filter | Tilt, signal: str, row: tuple[int, ...] | None = None) -> None:
    """Check that a reply has one series for each case that was asked; its rows have the shape `row`, or if None the signal's."""
    asked = answer.fields["cases"]
    if len(reply.cases) != len(asked):
        raise Wrong(f"{len(reply.cases)} cases for {len(asked)}")
    for case, each in zip(reply.cases, asked, strict=True):
        sent = answer.asked[each[signal]]
        answer.node(case.odd)
        _series(answer, case, len(sent), sent.shape[1:] if row is None else row)


def _series(answer: Answer, case: TiltCase, rows: int, row: tuple[int, ...]) -> None:
    """Check that a case has one row for every measurement; fewer rows are accepted only if the student's code raised."""
    broke_off = case.error is not None
    if case.output is None and broke_off:
        return
    output = answer.array(case.output, None, *row)
    if len(output) > rows or (len(output) < rows and not broke_off):
        raise Wrong(f"{len(output)} outputs for {rows} measurements")


class Plot(Drawings, kw_only=True):
    departs: Departures
    given: Any


def _plot(answer: Answer, reply: Plot) -> None:
    drawings(answer, reply)
    answer.node(reply.given)


# --- questions about the extensions --------------------------------------------------------------------------------------


class Allan(Called, kw_only=True):
    value: Any


def _allan(answer: Answer, reply: Allan) -> None:
    answer.node(reply.value)


class Imus(Called, kw_only=True):
    calls: list[Any]
    later: Any


def _imus(answer: Answer, reply: Imus) -> None:
    states = len(answer.asked["qpos"])
    answer.nodes(reply.calls, states, None if reply.error else states)
    answer.node(reply.later)


class LiveCurve(Points):
    moment: Number
    label: Long


class Live(Called, kw_only=True):
    returned: bool
    simulated: Number
    curves: Annotated[list[LiveCurve], Meta(max_length=1024)]


def _live(answer: Answer, reply: Live) -> None:
    answer.array("events", None, 3)
    points(answer, reply.curves)


RULES: Mapping[str, Rule] = {
    "read": Rule(Read, _read), "simulate": Rule(Simulate, _simulate), "read_along": Rule(Called, _read_along),
    "noise": Rule(Draws, _noise), "noise_twins": Rule(Draws, _noise_twins), "default_bias": Rule(Draws, _default_bias),
    "filter": Rule(Filter, _filter), "plot": Rule(Plot, _plot),
    "tilt": Rule(Tilt, _tilt), "allan": Rule(Allan, _allan), "imus": Rule(Imus, _imus), "live": Rule(Live, _live),
}  # fmt: skip
