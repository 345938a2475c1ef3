"""The checks of Sensor access, on made-up readers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.labs.imu.sensor_access import checks
from tests.judging.fake_students import FakeStudent, Marked, Row, is_as_marked

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


def _strange(x: np.ndarray) -> np.ndarray:
    """Something that no treatment of a reading explains."""
    return np.sin(x) + x**2


def _strange_at(first: int, second: int) -> Reader:
    return lambda _model, data, _a, _g: (_strange(_at(data, first)), _strange(_at(data, second)))


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


def _x_only(x: np.ndarray) -> np.ndarray:
    return x * [0.9, 1.0, 1.0]


def _turned(accel_sensor_id: int, gyro_sensor_id: int, data: Any, model: Any) -> Any:
    return sound(model, data, accel_sensor_id, gyro_sensor_id)


_OWN = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>"))


def _of_the_programs_own(_m: Any, d: Any, accel_sensor_id: int, gyro_sensor_id: int) -> Any:
    return np.full(3, _OWN.time), np.zeros(3)


CHECKS = (RETURNS, MATCHES, FOLLOWS, COPY, ALONE)
_UNKNOWN = dict.fromkeys((FOLLOWS, COPY, ALONE), "skipped")
"""Where readings follow nothing, their place cannot be judged."""
_FORM, _STRANGE, _NOT_FINITE = (0.0, ["wrong-return-type"]), {MATCHES: (0.0, [])}, {MATCHES: (0.0, ["not-finite"])}
_FIXED, _ELSEWHERE, _MOVED = (
    {FOLLOWS: (0.0, ["hard-coded-address"])},
    {FOLLOWS: (0.0, [])},
    {ALONE: (0.0, ["disturbs-simulation"])},
)
_VIEW, _CUT = {COPY: (0.0, ["view-not-copy"])}, ["precision-lost"]
READERS: list[tuple[str, Any, dict[Any, Marked]]] = [
    ("sound", sound, {}),
    ("nothing", lambda *_: None, dict.fromkeys(CHECKS, _FORM)),
    ("raises", _raises(ValueError), dict.fromkeys(CHECKS, "raised")),
    ("a dictionary", lambda *s: dict(zip(("accel", "gyro"), sound(*s), strict=True)), {RETURNS: _FORM}),
    ("six in a line", lambda *s: np.concatenate(sound(*s)), {RETURNS: _FORM}),
    ("five in one", altered(lambda x: np.append(x, [1, 2])), {RETURNS: (0.0, ["wrong-length"])}),
    ("in another order", _turned, {RETURNS: (0.0, ["other-parameters"])}),
    ("one of them short", altered(gyro=lambda x: x[:2]), {MATCHES: (0.0, ["wrong-length"])}),
    ("two numbers each", altered(lambda x: x[:2], lambda x: x[:2]), {MATCHES: (0.0, ["wrong-length"])}),
    ("the accelerometer alone", lambda *s: sound(*s)[0], {MATCHES: _FORM}),
    # what is read
    ("in g", altered(lambda x: x / 9.81), {MATCHES: (0.0, ["wrong-units"])}),
    ("in degrees", altered(gyro=np.degrees), {MATCHES: (0.0, ["wrong-units"])}),
    ("rounded to two decimals", altered(lambda x: x.round(2), lambda x: x.round(2)), {MATCHES: (0.5, _CUT)}),
    ("no numbers in one", altered(gyro=lambda x: x * np.nan), _NOT_FINITE),
    ("no numbers", altered(lambda x: x * np.nan, lambda x: x * np.nan), _NOT_FINITE | _UNKNOWN),
    ("one axis strange", altered(lambda x: np.array([_strange(x)[0], x[1], x[2]])), _STRANGE),
    ("strange", altered(_strange, _strange), _STRANGE),
    ("what was read before", _Late(sound), _STRANGE),
    ("one axis of another IMU", elsewhere(altered(_x_only)), _STRANGE),
    ("one axis of the last IMU", _where(18, altered(_x_only), sound, 16), _STRANGE),
    ("one axis in another model", _where(26, altered(gyro=_x_only), sound), _STRANGE),
    ("strange, and a change of the pose", _strange_and_stepping, _STRANGE | _MOVED),
    ("reset before", _resetting, _STRANGE | _MOVED),
    ("a constant", _a_constant, _STRANGE | _UNKNOWN),
    ("chance", _Chance(), _STRANGE | _UNKNOWN),
    ("of the program's own data", _of_the_programs_own, _STRANGE | _UNKNOWN),
    ("the first for good", _Cached(), {MATCHES: (0.0, ["cached-reading"])} | _UNKNOWN),
    # where it is read
    ("swapped", lambda m, d, a, g: sound(m, d, g, a), {FOLLOWS: (0.0, ["swapped-sensors"])}),
    ("swapped elsewhere", elsewhere(lambda m, d, a, g: sound(m, d, g, a)), _ELSEWHERE),
    ("ids as addresses", lambda _m, d, a, g: (_at(d, a), _at(d, g)), {FOLLOWS: (0.0, ["sensor-id-as-address"])}),
    ("one behind", lambda m, d, a, g: (_at(d, m.sensor_adr[a] + 1), _at(d, m.sensor_adr[g] + 1)), {FOLLOWS: (0.0, ["off-by-one-address"])}),
    ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), _FIXED),
    ("another pair of places", lambda _m, d, _a, _g: (_at(d, 20), _at(d, 30)), _FIXED),
    ("by names", elsewhere(_raises(KeyError)), _FIXED),
    ("beyond the end", elsewhere(_raises(IndexError)), _FIXED),
    ("of another type", elsewhere(_raises(TypeError)), _ELSEWHERE),
    ("all of another IMU", elsewhere(altered(_strange, _strange)), _ELSEWHERE),
    ("strange and of the torso", _strange_at(5, 14), _STRANGE | _FIXED),
    # whose array it is, and the simulation
    ("a view of one", _views, _VIEW),
    ("one array on every call", _filled_again(), _VIEW),
    ("a change of the pose", _stepping(), _MOVED),
    ("a change beyond what rounds", _stepping(by=1.5e-12, part="qvel"), _MOVED),
    ("a change within what rounds", _stepping(by=5e-13, part="qvel"), {}),
]  # fmt: skip
ROWS = [Row(name, lambda reader=reader: FakeStudent(get_imu_readings=reader), marks) for name, reader, marks in READERS]  # type: ignore[misc]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_reader_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))
