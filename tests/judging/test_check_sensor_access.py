"""The checks of Sensor access, on made-up readers."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.base.text import printable
from grader.engine.findings import CheckFailed, Fault, Unusable
from grader.labs.imu.answers import Readings
from grader.labs.imu.checks import check_sensor_access as checks
from tests.judging.made import Case, Made, finding, is_as_marked, truth

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


def _constant_and_stopping(model: Any, data: Any, a: int, g: int) -> Any:
    data.qvel[:] = 0
    return np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0])


def _twice_as_much_and_swapped_elsewhere(model: Any, data: Any, a: int, g: int) -> Any:
    return tuple(2 * x + 1 for x in elsewhere(lambda m, d, a, g: sound(m, d, g, a))(model, data, a, g))


def _fixed_and_strange_elsewhere(model: Any, data: Any, a: int, g: int) -> Any:
    of_the_torso = (model.nsensor, a, g) == (18, 2, 4)
    return (_at(data, 20), _at(data, 30)) if of_the_torso else altered(_strange, _strange)(model, data, a, g)


def _by_chance(read: Reader) -> Reader:
    """What is known of the gyroscope, and other numbers in every call for the accelerometer."""
    rng = np.random.default_rng(7)
    return lambda *state: (rng.normal(size=3), read(*state)[1])


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


def _nothing(*_: Any) -> Any:
    return None


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
            ("two numbers each", altered(lambda x: x[:2], lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("one of them short", altered(gyro=lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
            (
                "a dictionary",
                lambda *s: dict(zip(("accel", "gyro"), sound(*s), strict=True)),
                (0.0, ["wrong-return-type"]),
            ),
            ("six in a line", lambda *s: np.concatenate(sound(*s)), (0.0, ["wrong-return-type"])),
            ("columns", altered(lambda x: x[:, None], lambda x: x[:, None]), (0.0, ["wrong-return-type"])),
            ("three vectors", lambda *s: (*sound(*s), np.zeros(3)), (0.0, ["wrong-return-type"])),
            ("one component", altered(lambda x: x[0]), (0.0, ["wrong-length"])),
            ("the accelerometer alone", lambda *s: sound(*s)[0], (0.0, ["wrong-return-type"])),
            ("none of one of them", altered(gyro=lambda x: x[:0]), (0.0, ["wrong-length"])),
            ("five in one", altered(lambda x: np.append(x, [1, 2])), (0.0, ["wrong-length"])),
            ("raises", _raises(ValueError), "raised"),
            ("in another order", _turned, (0.0, ["other-parameters"])),
            ("of the program's own data", _of_the_programs_own, (0.0, ["global-for-parameter"])),
        ],
        MATCHES: [
            ("sound", sound, None),
            ("in g", altered(lambda x: x / 9.81), (0.0, ["wrong-units"])),
            ("in degrees", altered(gyro=np.degrees), (0.0, ["wrong-units"])),
            ("a constant", _a_constant, (0.0, [])),
            ("one axis strange", altered(lambda x: np.array([_strange(x)[0], x[1], x[2]])), (0.0, [])),
            ("swapped for one of the others", _where(18, lambda m, d, a, g: sound(m, d, g, a), sound, 9), None),
            ("rounded to two decimals", altered(lambda x: x.round(2), lambda x: x.round(2)), (0.5, ["precision-lost"])),
            ("rounded to one decimal", altered(lambda x: x.round(1), lambda x: x.round(1)), (0.0, ["precision-lost"])),
            ("smoothed over calls", _Lagging(sound), (0.0, ["reading-smoothed"])),
            ("two numbers each", altered(lambda x: x[:2], lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("one of them short", altered(gyro=lambda x: x[:2]), (0.0, ["wrong-length"])),
            ("none of one of them", altered(gyro=lambda x: x[:0]), (0.0, ["wrong-length"])),
            ("the accelerometer alone", lambda *s: sound(*s)[0], (0.5, ["wrong-return-type"])),
            ("none in place of one", altered(gyro=lambda _: None), (0.0, ["wrong-return-type"])),
            ("six in a line, of which three are in g", _in_a_line(altered(lambda x: x / 9.81)), (0.0, ["wrong-units"])),
            ("six in a line", _in_a_line(sound), None),
            ("nothing", lambda *_: None, (0.0, ["wrong-return-type"])),
            ("one axis of the last IMU", _where(18, altered(_x_only), sound, 16), (0.0, [])),
            ("one axis of the second IMU", _where(18, altered(_x_only), sound, 9), (0.0, [])),
            ("one axis in another model", _where(26, altered(gyro=_x_only), sound), (0.0, [])),
            ("both signs", altered(np.negative, np.negative), (0.0, ["sign-flipped"])),
            ("no numbers in one", altered(gyro=lambda x: x * np.nan), (0.0, ["not-finite"])),
            ("no numbers in the other", altered(lambda x: x * np.nan), (0.0, ["not-finite"])),
            ("no numbers", altered(lambda x: x * np.inf, lambda x: x * np.nan), (0.0, ["not-finite"])),
            ("a strange gyroscope", altered(gyro=_strange), (0.0, [])),
            ("strange", altered(_strange, _strange), (0.0, [])),
            ("limited", altered(_limited), (0.0, ["reading-clipped"])),
            ("strange, and a change of the pose", _strange_and_stepping, (0.0, [])),
            ("a constant, and other velocities", _constant_and_stopping, (0.0, [])),
            ("reset before", _resetting, (0.0, ["disturbs-simulation"])),
            ("swapped, which is a place", lambda m, d, a, g: sound(m, d, g, a), None),
            ("always the torso's", lambda _m, d, _a, _g: (_at(d, 5), _at(d, 11)), None),
            ("another pair of places", lambda _m, d, _a, _g: (_at(d, 20), _at(d, 30)), None),
            ("one axis of another IMU", elsewhere(altered(_x_only)), (0.0, [])),
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
            ("twice as much, swapped elsewhere", _twice_as_much_and_swapped_elsewhere, (0.0, [])),
            ("another pair of places, strange elsewhere", _fixed_and_strange_elsewhere, (0.0, [])),
            ("a constant, and other velocities", _constant_and_stopping, "skipped"),
            ("strange", altered(_strange, _strange), None),
            ("strange and of the torso", _strange_at(5, 14), (0.0, [])),
            ("strange and by name", _strange_by_name, (0.0, ["hard-coded-address"])),
            ("chance", _Chance(), "skipped"),
            ("a constant", _a_constant, "skipped"),
            ("no numbers", lambda *_: None, "skipped"),
            (
                "strange, by names that are none",
                _where(20, _raises(KeyError), altered(_strange, _strange)),
                (0.0, ["hard-coded-address"]),
            ),
            (
                "strange, by another model's names",
                _where(26, _raises(KeyError), altered(_strange, _strange)),
                (0.0, ["hard-coded-address"]),
            ),
            ("strange, and nothing behind other sensors", _where(20, _nothing, altered(_strange, _strange)), (0.0, [])),
            ("strange, and nothing of other IMUs", _where(18, _nothing, altered(_strange, _strange), 9), (0.0, [])),
            ("strange, and nothing in another model", _where(26, _nothing, altered(_strange, _strange)), (0.0, [])),
            ("strange and lagging", _Lagging(altered(_strange, _strange)), None),
            ("what was read before", _Late(sound), None),
            ("the first for good", _Cached(), "skipped"),
            ("swapped for one of the others", _where(18, lambda m, d, a, g: sound(m, d, g, a), sound, 9), (0.0, [])),
        ],
        COPY: [
            ("sound", sound, None),
            ("a view of one", _views, (0.0, ["view-not-copy"])),
            ("one array on every call", _filled_again(), (0.0, ["view-not-copy"])),
            ("a view of one, and no numbers", lambda *s: (_views(*s)[0], np.full(3, np.nan)), (0.0, ["view-not-copy"])),
            ("a view of the other", lambda *s: _views(*s[:2], s[3], s[2])[::-1], (0.0, ["view-not-copy"])),
            ("chance in one", _by_chance(sound), "skipped"),
            ("strange", altered(_strange, _strange), None),
            ("no numbers in one", altered(gyro=lambda x: x * np.nan), None),
            ("in g", altered(lambda x: x / 9.81), None),
            ("no numbers", altered(lambda x: x * np.nan, lambda x: x * np.nan), "skipped"),
            ("reset before", _resetting, None),
            ("a constant", _a_constant, "skipped"),
        ],
        ALONE: [
            ("sound", sound, None),
            ("a forward pass", altered(), None),
            ("a change of the pose", _stepping(), (0.0, ["disturbs-simulation"])),
            ("a change of the velocity", _stepping(part="qvel"), (0.0, ["disturbs-simulation"])),
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


@pytest.mark.quick
def test_what_is_raised_elsewhere_is_told_with_its_place() -> None:
    fault = Fault("KeyError", "torso", "imu_reader.py", 12, "data.sensor('torso')")
    none = np.full((1, 1, 3), np.nan)
    with pytest.raises(CheckFailed) as lost:
        checks._ignores_ids(Readings(none, none, none[0], none[0], (), np.zeros((0, 4)), fault))
    assert (lost.value.got, lost.value.where) == ("KeyError: torso at imu_reader.py, line 12", fault.at)


@pytest.mark.quick
def test_what_is_raised_elsewhere_is_told_as_it_can_be_shown_and_cut() -> None:
    fault = Fault("KeyError", "torso\x1b" + "s" * 300, None, None, None)
    none = np.full((1, 1, 3), np.nan)
    with pytest.raises(CheckFailed) as lost:
        checks._ignores_ids(Readings(none, none, none[0], none[0], (), np.zeros((0, 4)), fault))
    assert lost.value.got == f"KeyError: {printable(fault.message, 200)}"


def _read(accel: float, gyro: float, later: float = 0.0) -> Readings:
    """Readings of one IMU in one state, all axes alike, and what a view of the accelerometer has a step later."""
    a, g = np.full((1, 1, 3), accel), np.full((1, 1, 3), gyro)
    return Readings(a, g, a[0] + later, g[0], (), np.zeros((1, 4)), None)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("first", "second", "apart"),
    [
        (_read(1, 2), _read(1, 2), 0.0),
        (_read(1, 2), _read(4, 2), 3.0),
        (_read(4, 2), _read(1, 2), 3.0),
        (_read(np.nan, 2), _read(1, 1), 1.0),
        (_read(np.nan, np.nan), _read(1, 1), np.inf),
    ],
)
def test_readings_are_apart_by_their_largest_difference_in_either_direction(
    first: Readings, second: Readings, apart: float
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert checks._apart(first, second) == apart


@pytest.mark.quick
@pytest.mark.parametrize("later", [1.0, -1.0])
def test_a_view_is_told_by_the_sensor_that_moved(later: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "_torso", lambda *_: _read(5, 2, later))
    with pytest.raises(CheckFailed) as lost:
        checks.check_reading_is_a_copy(Made(get_imu_readings=sound), truth())
    assert (
        lost.value.got
        == f"[{5 + later:.3f} {5 + later:.3f} {5 + later:.3f}] after data.sensordata had changed and the function had been called again"
    )


@pytest.mark.quick
def test_no_more_than_two_oddities_of_a_reading_are_told() -> None:
    odd: Any = SimpleNamespace(oddities=("a list", "of text", "of length 7"))
    assert checks._oddities(odd) == "a list; of text"


@pytest.mark.quick
def test_a_reading_is_of_use_where_one_sensor_has_numbers() -> None:
    for accel, gyro in ((1.0, np.nan), (np.nan, 1.0)):
        checks._is_usable(replace(_read(accel, gyro), oddities=("a list",)))
    with pytest.raises(Unusable):
        checks._is_usable(replace(_read(np.nan, np.nan), oddities=("a list",)))


@pytest.mark.quick
def test_sensors_are_put_before_the_models_own_once() -> None:
    assert checks.with_others_first("<!-- <mujoco> --><mujoco model='a'><mujoco>").count("two_of_a_user") == 1


@pytest.mark.quick
def test_the_place_of_a_robot_with_one_imu_is_told_by_another_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "_elsewhere_too", lambda _truth: [("reading_shuffled", slice(None))])
    found = finding(Case("one", FOLLOWS, lambda: Made(get_imu_readings=lambda _m, d, *_: (_at(d, 20), _at(d, 30)))))
    assert isinstance(found, CheckFailed)
    assert found.mistakes == ("hard-coded-address",)


@pytest.mark.quick
@pytest.mark.parametrize(("imus", "places"), [(1, ["reading_shuffled"]), (2, ["reading_lab", "reading_shuffled"])])
def test_other_imus_of_the_robot_are_read_where_it_has_some(imus: int, places: list[str]) -> None:
    robot: Any = {"reading_lab": {"pairs": np.zeros((imus, 2), int)}}
    assert [name for name, _ in checks._elsewhere_too(robot)] == places


_WAVE = np.sin(np.arange(26.0)).reshape(1, 13, 2).repeat(2, axis=0)
_JUMPS = _WAVE * [[[1.0, 1e3]], [[1.0, 1e3]]]


@pytest.mark.quick
@pytest.mark.parametrize(
    ("first", "again", "alike"),
    [
        (_WAVE, _WAVE, 1.0),
        (_WAVE, 3 * _WAVE + 5, 1.0),
        (_WAVE, -_WAVE, -1.0),
        (_JUMPS, _JUMPS * [1.0, -1.0], 0.0),
        (_WAVE, np.where(np.arange(13)[:, None] < 6, np.nan, _WAVE), 1.0),
        (_WAVE, np.full_like(_WAVE, np.nan), 0.0),
        (np.ones_like(_WAVE), _WAVE, 0.0),
        (_WAVE * [1.0, 0.0], _WAVE, 0.0),
        (_WAVE * [1.0, 0.0], _WAVE * [1.0, 0.0], 1.0),
    ],
    ids=[
        "the same",
        "larger and shifted",
        "negative",
        "half negative",
        "not all known",
        "unknown",
        "constant",
        "constant once",
        "one constant",
    ],
)
def test_two_visits_are_alike_channel_by_channel(first: np.ndarray, again: np.ndarray, alike: float) -> None:
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert checks._likeness(first, again) == pytest.approx(alike, abs=0.03)
