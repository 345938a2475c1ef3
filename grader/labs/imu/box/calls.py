"""What each of the lab's functions is given, and the other words for it that people call their parameters by."""

from __future__ import annotations

import re
from types import NoneType
from typing import Any

import numpy as np

from grader.harness.calling import Slot


def _meaning(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)


def _of_each_sensor(quantity: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Words for a quantity of the accelerometer, and of the gyroscope."""
    accel, gyro = (rf"^({own}).*({quantity})|({quantity}).*_({own})" for own in ("a", "g|w|omega|rate"))
    return _meaning(accel), _meaning(gyro)


_MODEL, _DATA = Slot("model", _meaning(r"^m$|model")), Slot("data", _meaning(r"^d$|data"))
_ID_TYPES = (int, np.integer, NoneType)  # anything else that a parameter stands for by default is no id: a name, a list
_STDS = _of_each_sensor("std|sigma|noise|dev|var")
_BIASES = _of_each_sensor("bias|offset|drift|(?<![a-z])b(?![a-z])")

READER = (
    _MODEL,
    _DATA,
    Slot("accel_sensor_id", _meaning(r"^a(_|cc|$)"), free=True),  # follows_address charges a reader without them
    Slot("gyro_sensor_id", _meaning(r"^g(_|yr|$)"), free=True),
)
NOISY = (
    _MODEL,
    _DATA,
    Slot("accel_id", _meaning(r"^a(_|cc|$)(?!.*(std|sigma|noise|dev|bias|offset))")),
    Slot("gyro_id", _meaning(r"^g(_|yr|$)(?!.*(std|sigma|noise|dev|bias|offset))")),
    Slot("accel_noise_std", _STDS[0], "option"),
    Slot("gyro_noise_std", _STDS[1], "option"),
    Slot("accel_bias", _BIASES[0], "name"),
    Slot("gyro_bias", _BIASES[1], "name"),
)
FILTER = (
    Slot("alpha", _meaning(r"alpha|^[ak]$|smooth|coef|factor|weight|gain|beta|lam"), "name"),
    Slot("initial_value", _meaning(r"init|start|first|prev|state|value|^[xy]_?0$"), "name"),
)
NAMES_OF_READER = tuple(slot.name for slot in READER)
UPDATE = (
    Slot("measurement", _meaning(r"^[xz]$|meas|sample|value|new|raw|input")),
    Slot("dt", _meaning(r"^(dt|delta.*|time_?step|period|h)$"), "spare"),
)
COLLECTOR = (
    _MODEL,
    _DATA,
    Slot("duration_seconds", _meaning(r"dur|sec|time|^t$"), free=True, anywhere=True),
    Slot("accel_id", _meaning("^acc"), "spare", _ID_TYPES, free=True),
    Slot("gyro_id", _meaning("^gyr"), "spare", _ID_TYPES, free=True),
)
PLOTTER = (
    Slot("imu_data", _meaning("data|imu|record|result")),
    Slot("time", _meaning(r"^t$|time"), "spare"),
    Slot("acceleration", _meaning("^a(?!ng)"), "spare"),
    Slot("angular_velocity", _meaning("^(g|w|ang|omega|rate)"), "spare"),
    Slot("file_name", _meaning("file|path|save|out|png|name"), "spare"),
    Slot("title", _meaning("title"), "spare"),
)
WRITTEN = {"file_name": "imu_data.png", "title": "IMU data"}
"""Words for a plot that asks for them."""


def for_collector(model: Any, data: Any, duration_s: float, ids: dict[str, int]) -> dict[str, Any]:
    """What a function that simulates is given."""
    return {
        "model": model,
        "data": data,
        "duration_seconds": duration_s,
        "accel_id": ids["accel"],
        "gyro_id": ids["gyro"],
    }
