"""The checks of Sensor access, on made-up readers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.labs.imu.sensor_access import checks, explain
from grader.labs.imu.sensor_access.measure import Facts, Scene, Visit
from tests.judging.fake_students import FakeStudent, Marked, Row, is_as_marked

Reader = Callable[..., Any]
CHECKS = RETURNS, MATCHES, FOLLOWS, COPY, ALONE = (
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


def _raises(kind: type[Exception]) -> Reader:
    def read(*_: Any) -> Any:
        raise kind("torso_accelerometer")

    return read


def _stepping(by: float) -> Reader:
    def read(model: Any, data: Any, a: int, g: int) -> Any:
        data.qvel[0] += by
        return sound(model, data, a, g)

    return read


def _resetting(model: Any, data: Any, a: int, g: int) -> Any:
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    return sound(model, data, a, g)


class _Late:
    """What was read the time before."""

    last: Any = None

    def __call__(self, *state: Any) -> Any:
        now = sound(*state)
        last, self.last = self.last or now, now
        return last


_RNG = np.random.default_rng(7)


_OWN = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>"))


def _of_the_programs_own(_m: Any, d: Any, accel_sensor_id: int, gyro_sensor_id: int) -> Any:
    return np.full(3, _OWN.time), np.zeros(3)


_UNKNOWN = dict.fromkeys((FOLLOWS, COPY, ALONE), "skipped")
"""Where readings follow nothing, their place cannot be judged."""
_STRANGE, _MOVED = {MATCHES: (0.0, [])}, {ALONE: (0.0, ["disturbs-simulation"])}
_FIXED = {FOLLOWS: (0.0, ["hard-coded-address"])}
READERS: list[tuple[str, Any, dict[Any, Marked]]] = [
    ("sound", sound, {}),
    ("raises", _raises(ValueError), dict.fromkeys(CHECKS, "raised")),
    ("nothing", lambda *_: None, dict.fromkeys(CHECKS, (0.0, ["wrong-return-type"]))),
    ("in another order", lambda accel_sensor_id, gyro_sensor_id, data, model: sound(model, data, accel_sensor_id, gyro_sensor_id), {RETURNS: (0.0, ["other-parameters"])}),
    ("one of them short", altered(gyro=lambda x: x[:2]), {RETURNS: (0.0, ["wrong-length"]), MATCHES: (0.75, ["wrong-length"])}),
    ("the accelerometer alone", lambda *s: sound(*s)[0], {RETURNS: (0.0, ["wrong-return-type"]), MATCHES: (0.5, ["wrong-return-type"])}),
    # what is read
    ("no numbers", altered(lambda x: x * np.nan, lambda x: x * np.nan), {MATCHES: (0.0, ["not-finite"])} | _UNKNOWN),
    ("what was read before", _Late(), _STRANGE),
    ("one axis of another IMU", elsewhere(altered(lambda x: x * [0.9, 1.0, 1.0])), _STRANGE),
    ("reset before", _resetting, _STRANGE | _MOVED),
    ("chance", lambda *_: (_RNG.normal(size=3), _RNG.normal(size=3)), _STRANGE | _UNKNOWN),
    ("of the program's own data", _of_the_programs_own, _STRANGE | _UNKNOWN),
    # where it is read
    ("swapped elsewhere", elsewhere(lambda m, d, a, g: sound(m, d, g, a)), {FOLLOWS: (0.0, [])}),
    ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), _FIXED),
    ("by names", elsewhere(_raises(KeyError)), _FIXED),
    ("beyond the end", elsewhere(_raises(IndexError)), _FIXED),
    ("of another type", elsewhere(_raises(TypeError)), {FOLLOWS: (0.0, [])}),
    # whose array it is, and the simulation
    ("a change beyond what rounds", _stepping(by=1.5e-12), _MOVED),
    ("a change within what rounds", _stepping(by=5e-13), {}),
]  # fmt: skip
ROWS = [Row(name, lambda reader=reader: FakeStudent(get_imu_readings=reader), marks) for name, reader, marks in READERS]  # type: ignore[misc]
CASES = [case for row in ROWS for case in row.cases(CHECKS)]


@pytest.mark.quick
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_made_up_reader_is_marked_fairly(row: Row) -> None:
    is_as_marked(*row.cases(CHECKS))


# --- what readings follow, by facts that are built by hand ---------------------------------------------------------------

_HAND = np.random.default_rng(3)
_DATA, _STATES = _HAND.normal(0, 4, (13, 14)), _HAND.normal(0, 4, (13, 9))
_TURN = np.linalg.qr(_HAND.normal(size=(13, 3, 3)))[0]


def _visit(*pair: int) -> Visit:
    """Two of four sensors in one array, read through a sine."""
    addresses = np.array([0, 1, 4, 7, 8, 11])
    scene = Scene(_DATA, addresses, pair, _TURN, _TURN, _STATES, _STATES + 1, _STATES[:, :6], _STATES[:, 3:])  # type: ignore[arg-type]
    return Visit(scene, (np.sin(scene.true(0)), np.sin(scene.true(1))))


@pytest.mark.quick
@pytest.mark.parametrize(("order", "follows"), [(1, True), (-1, False)])
def test_readings_follow_the_states_and_not_the_number_of_the_call(order: int, follows: bool) -> None:
    torso = _visit(1, 2)
    now = np.array([torso.got[0][0], torso.got[1][0]])
    facts = Facts(
        torso, torso, (_visit(5, 4),), now, np.zeros(4), reverse=(torso.got[0][::order], torso.got[1][::order])
    )
    assert (explain._by_chance(facts) == "") is follows
