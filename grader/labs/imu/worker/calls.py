"""How the lab's functions are called: their arguments, and the other names that students give the parameters.

A slot is one argument, with the rules by which a student's parameter for it is found. Each tuple of slots belongs to one function;
`plan_call` and `adapt` match the parameters of a student's function with it.
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from types import FunctionType, NoneType
from typing import Any

import numpy as np

from grader.worker.calling import Slot, adapt, has_place_for, plan_call


def _meaning(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)


def _sensor_patterns(quantity: str, other: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return name patterns of two parameters, a `quantity` of the accelerometer and of the gyroscope, without names of `other`."""
    accel, gyro = (
        rf"^(?!.*({other}))(({own}).*({quantity})|({quantity}).*_({own}))" for own in ("a", "g|w|omega|rate")
    )
    return _meaning(accel), _meaning(gyro)


MODEL, DATA = Slot("model", _meaning(r"^m$|model")), Slot("data", _meaning(r"^d$|data"))
_ID_TYPES = (int, np.integer, NoneType)  # anything else that a parameter stands for by default is no id: a name, a list
_SIZE = "std|sigma|noise|dev|var"
_STDS = _sensor_patterns(_SIZE, "bias|offset|drift")
_ALPHA = _meaning(r"alpha|^[ak]$|smooth|coef|factor|weight|gain|beta|lam")
_DT = _meaning(r"^(dt|delta.*|time_?step|period|h)$")
_BIASES = _sensor_patterns("bias|offset|drift|(?<![a-z])b(?![a-z])", _SIZE)

READER = (
    MODEL,
    DATA,
    Slot("accel_sensor_id", _meaning(r"^a(_|cc|$)"), free=True),  # follows_address charges a reader without them
    Slot("gyro_sensor_id", _meaning(r"^g(_|yr|$)"), free=True),
)
NOISY = (
    MODEL,
    DATA,
    Slot("accel_id", _meaning(r"^a(_|cc|$)(?!.*(std|sigma|noise|dev|bias|offset))")),
    Slot("gyro_id", _meaning(r"^g(_|yr|$)(?!.*(std|sigma|noise|dev|bias|offset))")),
    Slot("accel_noise_std", _STDS[0], "option"),
    Slot("gyro_noise_std", _STDS[1], "option"),
    Slot("accel_bias", _BIASES[0], "option"),
    Slot("gyro_bias", _BIASES[1], "option"),
)
READ = (
    Slot("model", MODEL.meaning, "spare"),
    Slot("data", DATA.meaning, "spare"),
    Slot("accel_id", _meaning(r"^acc.*(id|sensor)"), "spare"),
    Slot("gyro_id", _meaning(r"^gyr.*(id|sensor)"), "spare"),
    Slot("accel", _meaning(r"acc|^a$"), "spare"),
    Slot("gyro", _meaning(r"gyr|ang|omega|rate|^[gw]$"), "spare"),
    Slot("dt", _DT, "spare"),
)
_INITIAL = Slot("initial_value", _meaning(r"init|start|first|prev|state|value|^[xy]_?0$"), "option")
FILTER = (Slot("alpha", _ALPHA, "option"), _INITIAL)
_FILTER_IN_TIME = (
    _INITIAL,
    Slot("rate", _meaning(r"^fs$|samp|rate"), "spare", (int, float)),
    Slot("dt", _DT, "spare", (int, float)),
    Slot("cutoff", _meaning(r"cut|^f_?c$|freq"), "spare", (int, float)),
    Slot("time_constant", _meaning(r"tau|const|^rc$"), "spare", (int, float)),
)
UPDATE = (
    Slot("measurement", _meaning(r"^[xz]$|meas|sample|value|new|raw|input")),
    Slot("dt", _DT, "spare"),
)
COLLECTOR = (
    MODEL,
    DATA,
    Slot("duration_seconds", _meaning(r"dur|sec|time|^t$"), free=True, anywhere=True),
    Slot("accel_id", _meaning("^acc"), "spare", _ID_TYPES, free=True),
    Slot("gyro_id", _meaning("^gyr"), "spare", _ID_TYPES, free=True),
    Slot("n_steps", _meaning("steps$|^n$|^n_|^num|samples|count"), "spare"),
)
TILT_FILTER = (Slot("dt", _DT), Slot("alpha", _ALPHA, "spare"))
TILT_UPDATE = (Slot("accel", _meaning("^a")), Slot("gyro", _meaning("^(g|w|omega|rate)")), Slot("dt", _DT, "spare"))
IMUS = (MODEL, DATA)
PLOTTER = (
    Slot("imu_data", _meaning("data|imu|record|result")),
    Slot("time", _meaning(r"^t$|time"), "spare"),
    Slot("acceleration", _meaning("^a(?!ng)"), "spare"),
    Slot("angular_velocity", _meaning("^(g|w|ang|omega|rate)"), "spare"),
    Slot("file_name", _meaning("file|path|save|out|png|name"), "spare"),
    Slot("title", _meaning("title"), "spare"),
)
PLOT_TEXTS = {"file_name": "imu_data.png", "title": "IMU data"}
"""Texts for a plot function that has parameters for them."""


class Reader:
    """Caller of a student's `get_imu_readings` with the lab sheet's arguments; sensor names replace ids if only names work.

    A call returns what the student's function returns.

    Attributes
    ----------
    departs : the sheet's names of the arguments that the student's function takes differently, complete after the first call
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._read, self.departs = adapt(function, READER)
        self._first, self._takes_names = True, False

    def __call__(self, model: Any, data: Any, *ids: int) -> Any:
        first, self._first = self._first, False
        if self._takes_names:
            return self._by_name(model, data, ids)
        try:
            return self._read(model, data, *ids)
        except Exception:
            if first:
                with suppress(Exception):
                    reading = self._by_name(model, data, ids)
                    self._takes_names = True
                    self.departs += [f"name for {slot.name}" for slot in READER if slot.free]
                    return reading
            raise

    def _by_name(self, model: Any, data: Any, ids: Iterable[int]) -> Any:
        return self._read(model, data, *(model.sensor(id_).name for id_ in ids))


def method_of(instance: Any, name: str, takes: int) -> tuple[Callable[..., Any], list[str]]:
    """Return the method `name` of an object, and a list of what differs from the lab sheet: [] if it has this method.

    If its class has just one public method that needs `takes` arguments instead, return that and ``["method <name>"]``.
    If it has none or several of those, an AttributeError is raised.
    """
    if not hasattr(instance, name):
        members = {own: each for kind in reversed(type(instance).__mro__) for own, each in vars(kind).items()}
        public = [own for own, each in members.items() if own[:1] != "_" and isinstance(each, FunctionType)]
        others = [own for own in public if _needed(getattr(instance, own)) == takes]
        if len(others) == 1:
            return getattr(instance, others[0]), [f"method {name}"]
    return getattr(instance, name), []


def _needed(function: Callable[..., Any]) -> int:
    """Return how many arguments without a default a function needs, so that a renamed method is found by their number."""
    parameters = inspect.signature(function).parameters.values()
    return sum(each.default is each.empty and each.kind is each.POSITIONAL_OR_KEYWORD for each in parameters)


def reading_arguments(fields: Mapping[str, Any], model: Any, data: Any) -> dict[str, Any]:
    """Return further arguments that a `NoisyIMU.read` may take: true ``accel``, ``gyro`` by the ids in `fields`, and ``dt`` (s)."""
    start = {name: int(model.sensor_adr[fields[f"{name}_id"]]) for name in ("accel", "gyro")}
    return {name: data.sensordata[at : at + 3].copy() for name, at in start.items()} | {"dt": BETWEEN_S}


def adapt_collector(
    function: Callable[..., Any], model: Any, duration_s: float, ids: dict[str, int]
) -> tuple[Callable[..., Any], list[str]]:
    """Return a function of model, data and duration that calls the student's `function`, and the names of what differs.

    These are the sheet's names of parameters that `function` (`simulate_and_collect` or `live_plot`) renames or moves. It also gets
    the sensor ids in `ids` (keys ``accel``, ``gyro``) and the number of steps in `duration_s` if it has parameters for them.
    """
    steps = round(duration_s / model.opt.timestep)
    return adapt(function, COLLECTOR, {"accel_id": ids["accel"], "gyro_id": ids["gyro"], "n_steps": steps})


BETWEEN_S = 0.002
"""Time between two measurements in s, for a filter that asks for it: the time step of the sheet's model."""
_ALPHA_ON_SHEET, _SMALLEST = 0.1, 1e-9


def filter_builder(kind: Callable[..., Any]) -> tuple[Callable[[Mapping[str, Any]], Any], list[str]]:
    """Return a function that builds the student's `LowPassFilter`, `kind`, from options, and the names of those it renames.

    The options are those of the lab sheet, ``alpha`` and ``initial_value``; either may be left out. If the filter takes a cutoff or
    a time constant RC instead of alpha, these follow from alpha = dt / (RC + dt), dt = 0.002 s, and cutoff = 1 / (2 pi RC).
    """
    in_time = None if has_place_for(FILTER[0], kind) else plan_call(kind, _FILTER_IN_TIME)
    if in_time is None or not {"cutoff", "time_constant"} & {*in_time.departs}:
        way = plan_call(kind, FILTER)
        return lambda options: way(kind, options), list(way.departs)

    def build(options: Mapping[str, Any]) -> Any:
        alpha = options.get("alpha", _ALPHA_ON_SHEET)
        rc = max(BETWEEN_S * (1 - alpha) / max(alpha, _SMALLEST), _SMALLEST)
        values = {"rate": 1 / BETWEEN_S, "dt": BETWEEN_S, "time_constant": rc, "cutoff": 1 / (2 * math.pi * rc)}
        return in_time(kind, {**options, **values})

    return build, ["alpha"]
