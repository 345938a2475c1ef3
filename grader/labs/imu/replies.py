"""Rules for the worker's reply to each of the lab's questions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grader.engine.replies import (
    Answer,
    Rule,
    Wrong,
    drawings,
    fault,
    flag,
    listed,
    long,
    maybe,
    node,
    number,
    points,
    record,
    short,
)

_PARAMETERS = frozenset({
    "model", "data", "accel_sensor_id", "gyro_sensor_id", "accel_id", "gyro_id", "duration_seconds", "accel_noise_std",
    "gyro_noise_std", "accel_bias", "gyro_bias", "alpha", "initial_value", "measurement", "dt", "imu_data", "time",
    "acceleration", "angular_velocity", "file_name", "title", "n_steps", "global model", "global data",
    "global imu_data", "global measurement", "accel", "gyro", "name for accel_sensor_id", "name for gyro_sensor_id",
})  # fmt: skip


def _parameter(value: Any) -> None:
    """Check a name of a departure: only names that the grader itself uses are accepted."""
    if value not in _PARAMETERS:
        raise Wrong("no parameter's name")


_departures = listed(_parameter, len(_PARAMETERS))


def _changes(answer: Answer, most: int) -> None:
    if len(answer.array("disturbance", None, 4)) > most:
        raise Wrong("more changes than calls")


# --- questions about the lab's parts -------------------------------------------------------------------------------------


def _read(answer: Answer) -> None:
    pairs, states = len(answer.asked["pairs"]), len(answer.asked["qpos"])
    whole = not answer.faulty
    answer.part("departs", _departures)
    answer.part("calls", listed(node(answer), pairs * states, pairs * states if whole else None))
    answer.part("later", listed(node(answer), pairs, pairs if whole else None))
    _changes(answer, pairs * (states + 1))


def _simulate(answer: Answer) -> None:
    answer.part("value", maybe(node(answer)))
    answer.part("changed", listed(short, 20))
    answer.part("departs", _departures)
    for name in answer.frame.arrays:
        if name.startswith("first_set_q") or name == "first_set_force":
            answer.array(name, None, None)
        elif name.startswith("first_"):
            answer.array(name, {"first_gravity": 3, "first_timestep": 1, "first_steps": 1}.get(name))


def _read_along(answer: Answer) -> None:
    if len(answer.array("rows", None, 6)) > answer.fields["steps"]:
        raise Wrong("more rows than steps")


def _noise(answer: Answer) -> None:
    states = len(answer.asked["qpos"])
    _draws(answer, states)
    _changes(answer, states)


def _default_bias(answer: Answer) -> None:
    _draws(answer, answer.fields["instances"])


def _noise_twins(answer: Answer) -> None:
    _draws(answer, len(answer.fields["twins"]))


def _draws(answer: Answer, rows: int) -> None:
    answer.part("odd", maybe(node(answer)))
    answer.part("departs", _departures)
    for name in ("accel", "gyro"):
        answer.array(name, rows, answer.fields["reads"], 3)


def _filter(answer: Answer) -> None:
    cases = answer.fields["cases"]
    kinds = record(
        output=maybe(short), odd=maybe(node(answer)), error=maybe(fault), departs=_departures,
        input_changed=flag, output_changed=flag,
    )  # fmt: skip
    answer.part("cases", listed(kinds, len(cases), len(cases)))
    for case, asked in zip(answer.frame.fields["cases"], cases, strict=True):
        signal = answer.asked[asked["input"]]
        _series(answer, case, len(signal), signal.shape[1:])


def _series(answer: Answer, case: Mapping[str, Any], rows: int, row: tuple[int, ...]) -> None:
    """Check rows for every measurement. Fewer rows are accepted only if the student's code raised."""
    broke_off = case["error"] is not None
    if case.get("output") is None and broke_off:
        return
    output = answer.array(case.get("output"), None, *row)
    if len(output) > rows or (len(output) < rows and not broke_off):
        raise Wrong(f"{len(output)} outputs for {rows} measurements")


def _plot(answer: Answer) -> None:
    drawings(answer)
    answer.part("departs", _departures)


# --- questions about the extensions --------------------------------------------------------------------------------------


def _tilt(answer: Answer) -> None:
    cases = answer.fields["cases"]
    kinds = record(output=short, odd=maybe(node(answer)), error=maybe(fault))
    answer.part("cases", listed(kinds, len(cases), len(cases)))
    for case, asked in zip(answer.frame.fields["cases"], cases, strict=True):
        _series(answer, case, len(answer.asked[asked["accel"]]), (2,))


def _allan(answer: Answer) -> None:
    answer.part("value", maybe(node(answer)))


def _imus(answer: Answer) -> None:
    states = len(answer.asked["qpos"])
    answer.part("calls", listed(node(answer), states, None if answer.faulty else states))
    answer.part("later", maybe(node(answer)))


def _live(answer: Answer) -> None:
    answer.array("events", None, 3)
    answer.part("returned", flag)
    answer.part("simulated", number)
    answer.part("curves", listed(record(moment=number, label=long), 1024))
    for curve in answer.frame.fields["curves"]:
        points(answer, curve)


RULES: Mapping[str, Rule] = {
    "read": _read, "simulate": _simulate, "read_along": _read_along, "noise": _noise, "noise_twins": _noise_twins,
    "default_bias": _default_bias, "filter": _filter, "plot": _plot,
    "tilt": _tilt, "allan": _allan, "imus": _imus, "live": _live,
}  # fmt: skip
