"""Which kinds of values count as numbers: the same ones, whatever the question that they answer."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from grader.labs.imu.bonuses.allan_variance import allan
from grader.labs.imu.bonuses.complementary_filter import TiltCase, tilt
from grader.labs.imu.bonuses.multiple_imus import imus
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import FilterCase
from tests.judging.fake_students import FakeStudent, truth

pytestmark = pytest.mark.quick
Kind = Callable[[Any], Any]
NUMBERS, NAN, NONE = "numbers", "NaN", "no numbers"
_POINT = [("x", float), ("y", float), ("z", float)]
KINDS: Mapping[str, tuple[Kind, str]] = {
    "array of float64": (np.array, NUMBERS),
    "array of float32": (np.float32, NUMBERS),
    "array of integers": (lambda x: np.array(x).astype(int), NUMBERS),
    "array of objects": (lambda x: np.array(x, dtype=object), NUMBERS),
    "list of numbers": (list, NUMBERS),
    "tuple of NumPy numbers": (tuple, NUMBERS),
    "list of Decimal": (lambda x: [Decimal(float(v)) for v in x], NUMBERS),
    "list of Fraction": (lambda x: [Fraction(float(v)) for v in x], NUMBERS),
    "complex without an imaginary part": (lambda x: x + 0j, NUMBERS),
    "masked array without a masked value": (np.ma.array, NUMBERS),
    "masked array, all masked": (lambda x: np.ma.array(x, mask=True), NAN),
    "list of masked values": (lambda x: [np.ma.masked] * len(x), NAN),
    "list of integers beyond float64": (lambda x: [10**400, *[-(10**400)] * (len(x) - 1)], NAN),
    "NaN": (lambda x: x * np.nan, NAN),
    "complex": (lambda x: x + 1j, NONE),
    "complex with a tiny imaginary part": (lambda x: x + 1e-300j, NONE),
    "list of complex": (lambda x: [complex(v, 1e6) for v in x], NONE),
    "array of booleans": (lambda x: x > 0, NONE),
    "list of booleans": (lambda x: [bool(v > 0) for v in x], NONE),
    "list with one boolean": (lambda x: [True, *x[1:]], NONE),
    "array of text": (lambda x: x.astype(str), NONE),
    "list of text": (lambda x: [str(v) for v in x], NONE),
    "array of objects with text": (lambda x: np.array([str(v) for v in x], dtype=object), NONE),
    "list of None": (lambda x: [None] * len(x), NONE),
    "structured array": (lambda x: np.array(tuple(np.resize(x, 3)), dtype=_POINT), NONE),
    "dates": (lambda x: np.array([datetime.datetime(2026, 1, 1)] * len(x), dtype="datetime64[s]"), NONE),
    "durations": (lambda x: np.array([1] * len(x), dtype="timedelta64[s]"), NONE),
}


def _vectors(model: Any, data: Any, *ids: int) -> list[np.ndarray]:
    return [data.sensordata[model.sensor_adr[i] : model.sensor_adr[i] + 3].copy() for i in ids]


def _noisy(kind: Kind) -> type:
    class NoisyIMU:
        def __init__(self, model: Any, data: Any, accel_id: int, gyro_id: int, **_: Any) -> None:
            self.here = model, data, accel_id, gyro_id

        def read(self) -> Any:
            return tuple(map(kind, _vectors(*self.here)))

    return NoisyIMU


def _updating(update: Callable[..., Any]) -> type:
    return type("Filter", (), {"__init__": lambda *_, **__: None, "update": lambda _self, *given: update(*given)})


def _recorded(kind: Kind) -> Callable[..., Any]:
    def simulate_and_collect(model: Any, data: Any, duration: float, accel_id: int, gyro_id: int) -> Any:
        rows = [[kind(v) for v in _vectors(model, data, accel_id, gyro_id)] for _ in range(20)]
        columns: list[Any] = [
            np.ma.array(c) if isinstance(c[0], np.ma.MaskedArray) else list(c) for c in zip(*rows, strict=True)
        ]
        return {"time": np.arange(20.0), "acceleration": columns[0], "angular_velocity": columns[1]}

    return simulate_and_collect


def _told(values: Any, odd: Any) -> str:
    if values is not None and np.isfinite(values).all():
        return NUMBERS
    return NONE if odd else NAN


_SCENE = truth()["noise"]
_PLACE: dict[str, Any] = {"qpos": _SCENE["qpos"], "qvel": _SCENE["qvel"]}
_IMU: dict[str, Any] = {**_PLACE, "ids": torso_ids(truth()), "stds": (0.1, 0.1)}
_SIGNAL = np.arange(1.0, 31.0).reshape(10, 3)


def _read(kind: Kind) -> str:
    student = FakeStudent(get_imu_readings=lambda *state: tuple(map(kind, _vectors(*state))))
    readings = student.read(model=student.robot.xml, pairs=np.array([torso_ids(truth())]), **_PLACE)
    return _told(readings.accel, readings.oddities)


def _noise(kind: Kind) -> str:
    run = FakeStudent(NoisyIMU=_noisy(kind)).noise(**_IMU, reads=3, biases=None)
    return _told(run.accel, run.odd)


def _default_bias(kind: Kind) -> str:
    run = FakeStudent(NoisyIMU=_noisy(kind)).default_bias(**_IMU, instances=2)
    return _told(run.accel, run.odd)


def _simulate(kind: Kind) -> str:
    found = FakeStudent(simulate_and_collect=_recorded(kind)).simulate(duration_s=1.0, ids=torso_ids(truth()))
    return NAN if found.unfilled else _told(found.acceleration, found.acceleration is None)


def _filter(kind: Kind) -> str:
    run = FakeStudent(LowPassFilter=_updating(kind)).filter([FilterCase(_SIGNAL, alpha=0.5)])[0]
    return _told(run.output, run.odd)


def _tilt(kind: Kind) -> str:
    student = FakeStudent(ComplementaryFilter=_updating(lambda accel, gyro: kind(accel[:2])))
    run = tilt(student, [TiltCase(0.01, _SIGNAL, _SIGNAL)])[0]
    return _told(run.output, any(word in run.odd for word in ("of type", "string", "None", "dictionary")))


def _allan(kind: Kind) -> str:
    run = allan(FakeStudent(allan_deviation=lambda x, rate: (np.arange(1.0, 4.0), kind(x[1:4]))), np.arange(9.0), 100.0)
    return _told(run.adev, run.adev is None)


def _imus(kind: Kind) -> str:
    def read_all(model: Any, data: Any) -> Any:
        return {"torso": tuple(map(kind, _vectors(model, data, *torso_ids(truth()))))}

    student = FakeStudent(read_all_imus=read_all)
    reading = imus(student, model=student.robot.xml, **_PLACE).calls[0]["torso"]
    return _told(reading.accel, reading.oddity)


QUESTIONS: Mapping[str, Callable[[Kind], str]] = {
    "read": _read, "noise": _noise, "default_bias": _default_bias, "simulate": _simulate, "filter": _filter, "tilt": _tilt,
    "allan": _allan, "imus": _imus,
}  # fmt: skip


def outcomes(name: str) -> dict[str, str]:
    """What a kind of values counts as in each question."""
    with np.errstate(all="ignore"):
        return {question: ask(KINDS[name][0]) for question, ask in QUESTIONS.items()}


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_of_values_counts_the_same_in_every_question(name: str) -> None:
    assert outcomes(name) == dict.fromkeys(QUESTIONS, KINDS[name][1])
