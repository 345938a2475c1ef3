"""The checks of Sensor access, on made-up readers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.labs.imu.checks import check_sensor_access as checks
from tests.judging.made import Case, Made, is_as_marked, misfits

Reader = Callable[..., Any]
RETURNS, MATCHES, FOLLOWS, COPY, ALONE = (
    checks.check_returns_two_vectors,
    checks.check_matches_truth,
    checks.check_follows_address,
    checks.check_reading_is_a_copy,
    checks.check_leaves_simulation_alone,
)


def _at(data: Any, first: int) -> np.ndarray:
    return np.array(data.sensordata[first : first + 3])


def sound(model: Any, data: Any, a: int, g: int) -> Any:
    return _at(data, model.sensor_adr[a]), _at(data, model.sensor_adr[g])


def altered(accel: Callable[[np.ndarray], Any] = np.array, gyro: Callable[[np.ndarray], Any] = np.array) -> Reader:
    """A sound reader whose numbers are changed."""

    def read(model: Any, data: Any, a: int, g: int) -> Any:
        first, second = sound(model, data, a, g)
        return accel(first), gyro(second)

    return read


def elsewhere(other: Reader) -> Reader:
    """Sound for the robot's own IMU in the lab model, and another reader for any other ids or model."""

    def read(model: Any, data: Any, a: int, g: int) -> Any:
        return sound(model, data, a, g) if (model.nsensor, a, g) == (18, 2, 4) else other(model, data, a, g)

    return read


def _strange(x: np.ndarray) -> np.ndarray:
    """Something that no treatment of a reading explains."""
    return np.sin(x) + x**2


def _strange_at(first: int, second: int) -> Reader:
    return lambda _model, data, _a, _g: (_strange(_at(data, first)), _strange(_at(data, second)))


def _strange_by_name(_model: Any, data: Any, _a: int, _g: int) -> Any:
    return tuple(_strange(data.sensor(f"torso_{kind}").data) for kind in ("accelerometer", "gyroscope"))


def _raises(kind: type[Exception]) -> Reader:
    def read(*_: Any) -> Any:
        raise kind("torso_accelerometer")

    return read


def _stepping(by: float = 1e-6, part: str = "qpos") -> Reader:
    def read(model: Any, data: Any, a: int, g: int) -> Any:
        answer = sound(model, data, a, g)
        getattr(data, part)[0] += by
        return answer

    return read


def _resetting(model: Any, data: Any, a: int, g: int) -> Any:
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    return sound(model, data, a, g)


class _Chance:
    """Other numbers in every call."""

    def __init__(self) -> None:
        self._rng = np.random.default_rng(7)

    def __call__(self, *_: Any) -> Any:
        return self._rng.normal(size=3), self._rng.normal(size=3)


def _a_constant(*_: Any) -> Any:
    return np.array([0.0, 0.0, -9.81]), np.zeros(3)


def _views(model: Any, data: Any, a: int, g: int) -> Any:
    first, second = model.sensor_adr[a], model.sensor_adr[g]
    return data.sensordata[first : first + 3], np.array(data.sensordata[second : second + 3])


def _limited(x: np.ndarray) -> np.ndarray:
    return np.clip(x, -9.0, 9.0)


def _x_only(x: np.ndarray) -> np.ndarray:
    return x * [0.9, 1.0, 1.0]


def _turned(accel_sensor_id: int, gyro_sensor_id: int, data: Any, model: Any) -> Any:
    return sound(model, data, accel_sensor_id, gyro_sensor_id)


CASES = [
    Case(name, check, lambda reader=reader: Made(get_imu_readings=reader), marked)  # type: ignore[misc]
    for check, rows in {
        RETURNS: [
            ("sound", sound, None),
            ("two numbers each", altered(lambda x: x[:2], lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("one of them short", altered(gyro=lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
            (
                "a dictionary",
                lambda *s: dict(zip(("accel", "gyro"), sound(*s), strict=True)),
                (0.0, ["wrong-return-type"]),
            ),
            ("six in a line", lambda *s: np.concatenate(sound(*s)), (0.0, ["wrong-length"])),
            ("raises", _raises(ValueError), "raised"),
            ("in another order", _turned, (0.0, ["other-parameters"])),
        ],
        MATCHES: [
            ("sound", sound, None),
            ("in g", altered(lambda x: x / 9.81), (0.5, ["wrong-units"])),
            ("in degrees", altered(gyro=np.degrees), (0.5, ["wrong-units"])),
            ("both signs", altered(np.negative, np.negative), (0.0, ["sign-flipped"])),
            ("no numbers in one", altered(gyro=lambda x: x * np.nan), (0.5, ["not-finite"])),
            ("no numbers in the other", altered(lambda x: x * np.nan), (0.5, ["not-finite"])),
            ("no numbers", altered(lambda x: x * np.inf, lambda x: x * np.nan), (0.0, ["not-finite"])),
            ("a strange gyroscope", altered(gyro=_strange), (0.5, [])),
            ("strange", altered(_strange, _strange), (0.0, [])),
            ("limited", altered(_limited), (0.5, ["reading-clipped"])),
            ("reset before", _resetting, (0.0, ["disturbs-simulation"])),
            ("swapped, which is a place", lambda m, d, a, g: sound(m, d, g, a), None),
            ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), None),
            ("another pair of places", lambda _m, d, _a, _g: (_at(d, 20), _at(d, 30)), None),
            ("one axis of another IMU", elsewhere(altered(_x_only)), (0.5, [])),
            ("all of another IMU", elsewhere(altered(_strange, _strange)), None),
            ("raises elsewhere", elsewhere(_raises(KeyError)), None),
        ],
        FOLLOWS: [
            ("sound", sound, None),
            ("in g, which is no place", altered(lambda x: x / 9.81), None),
            ("twice as much", altered(lambda x: 2 * x + 1), None),
            ("swapped", lambda m, d, a, g: sound(m, d, g, a), (0.0, ["swapped-sensors"])),
            ("ids as addresses", lambda _m, d, a, g: (_at(d, a), _at(d, g)), (0.0, ["sensor-id-as-address"])),
            (
                "one behind",
                lambda m, d, a, g: (_at(d, m.sensor_adr[a] + 1), _at(d, m.sensor_adr[g] + 1)),
                (0.0, ["off-by-one-address"]),
            ),
            ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), (0.0, ["hard-coded-address"])),
            ("another pair of places", lambda _m, d, _a, _g: (_at(d, 20), _at(d, 30)), (0.0, ["hard-coded-address"])),
            ("by names", elsewhere(_raises(KeyError)), (0.0, ["hard-coded-address"])),
            ("by names that are none", elsewhere(_raises(ValueError)), (0.0, ["hard-coded-address"])),
            ("beyond the end", elsewhere(_raises(IndexError)), (0.0, ["hard-coded-address"])),
            ("of another type", elsewhere(_raises(TypeError)), (0.0, [])),
            ("something else elsewhere", elsewhere(altered(_strange, _strange)), (0.0, [])),
            ("in degrees elsewhere", elsewhere(altered(gyro=np.degrees)), (0.0, [])),
            ("swapped elsewhere", elsewhere(lambda m, d, a, g: sound(m, d, g, a)), (0.0, ["swapped-sensors"])),
            ("one axis elsewhere", elsewhere(altered(_x_only)), None),
            ("strange", altered(_strange, _strange), None),
            ("strange and of the torso", _strange_at(5, 14), (0.0, [])),
            ("strange and by name", _strange_by_name, (0.0, ["hard-coded-address"])),
            ("chance", _Chance(), "skipped"),
            ("a constant", _a_constant, "skipped"),
            ("no numbers", lambda *_: None, "skipped"),
        ],
        COPY: [
            ("sound", sound, None),
            ("a view of one", _views, (0.0, ["view-not-copy"])),
            ("a constant", _a_constant, "skipped"),
        ],
        ALONE: [
            ("sound", sound, None),
            ("a forward pass", altered(), None),
            ("a change of the pose", _stepping(), (0.0, ["disturbs-simulation"])),
            ("a change of the velocity", _stepping(part="qvel"), (0.0, ["disturbs-simulation"])),
            ("a change beyond what rounds", _stepping(by=2e-12, part="qvel"), (0.0, ["disturbs-simulation"])),
            ("a change within what rounds", _stepping(by=5e-13, part="qvel"), None),
            ("reset before", _resetting, (0.0, ["disturbs-simulation"])),
        ],
    }.items()
    for name, reader, marked in rows
]
CASES += misfits(RETURNS, lambda: Made(get_imu_readings=sound), "get_imu_readings", 0.0)


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_reader_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)
