"""The checks of Sensor access, on made-up readers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.labs.imu.sensor_access import checks
from tests.judging.made import Case, Made, is_as_marked

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


def _filled_again() -> Reader:
    """One array of its own for all calls."""
    kept = np.zeros((2, 3))

    def read(*s: Any) -> Any:
        kept[:] = sound(*s)
        return kept[0], kept[1]

    return read


def _in_a_line(reader: Reader) -> Reader:
    return lambda *s: np.concatenate(reader(*s))


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


def _strange_and_stepping(model: Any, data: Any, a: int, g: int) -> Any:
    data.qpos[0] += 1e-6
    return altered(_strange, _strange)(model, data, a, g)


class _Lagging:
    """Half of what is read now, half of what came before."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._last = (np.zeros(3), np.zeros(3))

    def __call__(self, *state: Any) -> Any:
        self._last = tuple((now + last) / 2 for now, last in zip(self._reader(*state), self._last, strict=True))
        return self._last


class _Late:
    """What was read the time before."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._last: Any = None

    def __call__(self, *state: Any) -> Any:
        now, last = self._reader(*state), self._last
        self._last = now
        return last or now


class _Cached:
    """The first reading for each pair of ids."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], Any] = {}

    def __call__(self, model: Any, data: Any, a: int, g: int) -> Any:
        return self._known.setdefault((a, g), sound(model, data, a, g))


def _where(nsensor: int, reader: Reader, other: Reader, *ids: int) -> Reader:
    """A reader in models with so many sensors, and for these ids of the accelerometer if any are said; elsewhere another one."""

    def read(model: Any, data: Any, a: int, g: int) -> Any:
        return (reader if model.nsensor == nsensor and (not ids or a in ids) else other)(model, data, a, g)

    return read


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


_OWN = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>"))


def _of_the_programs_own(_m: Any, d: Any, accel_sensor_id: int, gyro_sensor_id: int) -> Any:
    return np.full(3, _OWN.time), np.zeros(3)


CASES = [
    Case(name, check, lambda reader=reader: Made(get_imu_readings=reader), marked)  # type: ignore[misc]
    for check, rows in {
        RETURNS: [
            ("sound", sound, None),
            ("one of them short", altered(gyro=lambda x: x[:2]), None),
            ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
            (
                "a dictionary",
                lambda *s: dict(zip(("accel", "gyro"), sound(*s), strict=True)),
                (0.0, ["wrong-return-type"]),
            ),
            ("six in a line", lambda *s: np.concatenate(sound(*s)), (0.0, ["wrong-return-type"])),
            ("the accelerometer alone", lambda *s: sound(*s)[0], None),
            ("five in one", altered(lambda x: np.append(x, [1, 2])), (0.0, ["wrong-length"])),
            ("raises", _raises(ValueError), "raised"),
            ("in another order", _turned, (0.0, ["other-parameters"])),
            ("of the program's own data", _of_the_programs_own, None),
        ],
        MATCHES: [
            ("sound", sound, None),
            ("in g", altered(lambda x: x / 9.81), (0.0, ["wrong-units"])),
            ("in degrees", altered(gyro=np.degrees), (0.0, ["wrong-units"])),
            ("a constant", _a_constant, (0.0, [])),
            ("one axis strange", altered(lambda x: np.array([_strange(x)[0], x[1], x[2]])), (0.0, [])),
            ("rounded to two decimals", altered(lambda x: x.round(2), lambda x: x.round(2)), (0.5, ["precision-lost"])),
            ("rounded to one decimal", altered(lambda x: x.round(1), lambda x: x.round(1)), (0.0, ["precision-lost"])),
            ("smoothed over calls", _Lagging(sound), (0.0, [])),
            ("two numbers each", altered(lambda x: x[:2], lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("the accelerometer alone", lambda *s: sound(*s)[0], (0.0, ["wrong-return-type"])),
            ("six in a line", _in_a_line(sound), None),
            ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
            ("one axis of the last IMU", _where(18, altered(_x_only), sound, 16), (0.0, [])),
            ("one axis in another model", _where(26, altered(gyro=_x_only), sound), (0.0, [])),
            ("no numbers in one", altered(gyro=lambda x: x * np.nan), (0.0, ["not-finite"])),
            ("strange", altered(_strange, _strange), (0.0, [])),
            ("limited", altered(_limited), (0.0, [])),
            ("strange, and a change of the pose", _strange_and_stepping, (0.0, [])),
            ("reset before", _resetting, (0.0, [])),
            ("swapped, which is a place", lambda m, d, a, g: sound(m, d, g, a), None),
            ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), None),
            ("one axis of another IMU", elsewhere(altered(_x_only)), (0.0, [])),
            ("all of another IMU", elsewhere(altered(_strange, _strange)), None),
            ("raises elsewhere", elsewhere(_raises(KeyError)), None),
        ],
        FOLLOWS: [
            ("sound", sound, None),
            ("in g, which is no place", altered(lambda x: x / 9.81), None),
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
            ("beyond the end", elsewhere(_raises(IndexError)), (0.0, ["hard-coded-address"])),
            ("of another type", elsewhere(_raises(TypeError)), (0.0, [])),
            ("something else elsewhere", elsewhere(altered(_strange, _strange)), (0.0, [])),
            ("swapped elsewhere", elsewhere(lambda m, d, a, g: sound(m, d, g, a)), (0.0, [])),
            ("strange", altered(_strange, _strange), None),
            ("strange and of the torso", _strange_at(5, 14), (0.0, ["hard-coded-address"])),
            ("strange and by name", _strange_by_name, (0.0, ["hard-coded-address"])),
            ("chance", _Chance(), "skipped"),
            ("a constant", _a_constant, "skipped"),
            (
                "strange, by another model's names",
                _where(26, _raises(KeyError), altered(_strange, _strange)),
                (0.0, ["hard-coded-address"]),
            ),
            ("what was read before", _Late(sound), None),
            ("the first for good", _Cached(), "skipped"),
        ],
        COPY: [
            ("sound", sound, None),
            ("a view of one", _views, (0.0, ["view-not-copy"])),
            ("one array on every call", _filled_again(), (0.0, ["view-not-copy"])),
            ("strange", altered(_strange, _strange), None),
            ("no numbers in one", altered(gyro=lambda x: x * np.nan), None),
            ("no numbers", altered(lambda x: x * np.nan, lambda x: x * np.nan), "skipped"),
            ("a constant", _a_constant, "skipped"),
        ],
        ALONE: [
            ("sound", sound, None),
            ("a change of the pose", _stepping(), (0.0, ["disturbs-simulation"])),
            ("a change beyond what rounds", _stepping(by=1.5e-12, part="qvel"), (0.0, ["disturbs-simulation"])),
            ("a change within what rounds", _stepping(by=5e-13, part="qvel"), None),
            ("reset before", _resetting, (0.0, ["disturbs-simulation"])),
        ],
    }.items()
    for name, reader, marked in rows
]


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_reader_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)
