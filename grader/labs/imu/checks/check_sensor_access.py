"""Sensor access: reads accelerometer and gyroscope, at the place that the ids name, and disturbs nothing."""

from __future__ import annotations

import re

import numpy as np

from grader.base.text import printable
from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Ours, Size, Skipped, Unusable, raised
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import Readings
from grader.labs.imu.checks.fitting import fits_in, if_nothing
from grader.labs.imu.compare import SHEETS_NOISE, Array, Deviation, deviation, told, vector
from grader.labs.imu.diagnosis import reader_faults
from grader.labs.imu.diagnosis import reading as diagnosis
from grader.labs.imu.diagnosis.reading import Explanation, Scene
from grader.labs.imu.student import Student

_VALUES, _PLACE = "sensor_access.matches_truth", "sensor_access.follows_address"
"""These charge what other checks see as well."""
DISTURBED = 1e-12
"""Reading takes numbers out and puts none in: any change is a change. The margin is for a harmless mj_forward."""


@check("sensor_access.returns_two_vectors", lab_step=2)
def check_returns_two_vectors(student: Student, truth: Traces) -> None:
    """get_imu_readings returns acceleration and angular velocity, three numbers each"""
    readings = _torso(student, truth)
    _is_usable(readings)
    got = _oddities(readings)
    if "dictionary" in got or "object" in got or (got and readings.alone):
        raise CheckFailed(_FORM, got, mistakes=["wrong-return-type"], hint=if_nothing(got))
    if got:
        raise CheckFailed(_FORM, got, mistakes=[_of_form(readings)], belongs_to=(_VALUES, _PLACE))
    fits_in("get_imu_readings", readings.departs, keeps=0.0, belongs_to=_PLACE)


_FORM = "a tuple of two arrays of shape (3,)"


def _oddities(readings: Readings) -> str:
    return "; ".join(readings.oddities[:2])


def _of_form(readings: Readings) -> str:
    """The mistake in an odd form: slices of another length, or three numbers of each sensor in another form."""
    return "wrong-return-type" if readings.whole else "wrong-length"


def _is_usable(readings: Readings) -> None:
    """There are numbers in it, in whatever form: otherwise nothing can be judged."""
    if readings.oddities and not _has_numbers(readings):
        got = _oddities(readings)
        raise Unusable(_FORM, got, mistakes=["wrong-return-type"], hint=if_nothing(got))


def _has_numbers(readings: Readings) -> bool:
    return bool(np.isfinite(readings.accel).any() or np.isfinite(readings.gyro).any())


@check("sensor_access.matches_truth", lab_step=2)
def check_matches_truth(student: Student, truth: Traces) -> None:
    """The values are the sensor's own: m/s² and rad/s in the sensor's frame, unaltered"""
    readings, scene = _torso(student, truth), _torso_scene(truth)
    _is_usable(readings)
    explained = diagnosis.explain(readings.accel, readings.gyro, scene)
    if explained is None:
        unaltered = diagnosis.at_fixed_places(readings.accel, readings.gyro, scene) is not None
    else:
        unaltered = not explained.value_mistakes
    if not unaltered:
        meant = explained.place(scene) if explained is not None else (scene.accel, scene.gyro)
        _values_lost(readings, scene, _value_mistakes(student, truth, explained), meant)
    for name, pairs in _elsewhere_too(truth):
        _mostly_unaltered(_readings(student, truth, name, pairs), Scene.of(truth[name], pairs))
    # whether it is the right place is what follows_address asks


def _value_mistakes(student: Student, truth: Traces, explained: Explanation | None) -> tuple[str, ...]:
    """What was done to the values, if one mistake alone predicts all of them."""
    if explained is not None:
        return explained.value_mistakes
    (first, again), scene = _twice(student, truth), _torso_scene(truth)
    if _never_moves(first, again) and first.disturbance[:, 1].max(initial=0.0) > DISTURBED:
        return ("disturbs-simulation",)
    got = np.concatenate([first.accel[0], again.accel[0]]), np.concatenate([first.gyro[0], again.gyro[0]])
    true = np.tile(scene.accel[0], (2, 1)), np.tile(scene.gyro[0], (2, 1))
    name = reader_faults.handled(got, true, np.tile(scene.world_from_site[0], (2, 1, 1)), diagnosis.ATOL)
    return (name,) if name else ()


def _mostly_unaltered(readings: Readings, scene: Scene) -> None:
    """Whether the right sensors were read here, and some of their numbers altered."""
    if readings.fault is None and _mostly_right(readings, scene) and _gap(readings, scene)[0].worst > diagnosis.ATOL:
        _values_lost(readings, scene, (), (scene.accel, scene.gyro))


def _mostly_right(readings: Readings, scene: Scene) -> bool:
    """Whether half of each sensor's numbers are the true ones, and the others come from no other place of sensordata."""
    pairs = ((readings.accel, scene.accel), (readings.gyro, scene.gyro))
    return all(np.mean(np.abs(got - true) <= diagnosis.ATOL) >= _MOST for got, true in pairs) and not any(
        diagnosis.stands_elsewhere(its, there, scene.sensordata)
        for got, true in pairs
        for its, there in zip(got, true, strict=True)
    )


_MOST = 0.5


def _gap(readings: Readings, scene: Scene) -> tuple[Deviation, Array, Array, str, str]:
    """How far the readings are off, of the accelerometer unless that is right: with what came, what is true, unit and name."""
    gaps = [
        (deviation(got.reshape(-1, 3), true.reshape(-1, 3)), got.reshape(-1, 3), true.reshape(-1, 3), unit, name)
        for got, true, unit, name in (
            (readings.accel, scene.accel, "m/s²", "accel"),
            (readings.gyro, scene.gyro, "rad/s", "gyro"),
        )
    ]
    return gaps[1] if gaps[0][0].worst <= diagnosis.ATOL else gaps[0]


def _values_lost(readings: Readings, scene: Scene, mistakes: tuple[str, ...], meant: tuple[Array, Array]) -> None:
    """Charge altered values; half is kept where both sensors are off by less than a real one's noise: rounded, say.

    They are compared with what stands where they are read, which may be the wrong place: that is charged elsewhere.
    """
    near = all(
        deviation(got.reshape(-1, 3), there.reshape(-1, 3)).worst <= little
        for got, there, little in zip((readings.accel, readings.gyro), meant, SHEETS_NOISE, strict=True)
    )
    keeps, finite = 0.5 if near else 0.0, np.isfinite([readings.accel, readings.gyro]).all()
    if readings.oddities and not (finite and readings.whole):  # what is there may be right; the rest is not there
        mistake, off = _of_form(readings), Size("a vector that does not have three numbers")
        if readings.alone and deviation(readings.accel.reshape(-1, 3), meant[0].reshape(-1, 3)).worst <= diagnosis.ATOL:
            keeps = 0.5  # returns_two_vectors charges the other one
        raise CheckFailed("three numbers of each sensor", _oddities(readings), mistakes=[mistake], keeps=keeps, off=off)
    if not finite:
        raise CheckFailed("finite numbers", "NaN or infinity in the reading", mistakes=["not-finite"], keeps=keeps)
    gap, got, true, unit, name = _gap(readings, scene)
    raise CheckFailed(
        f"{name} ≈ {told(true[gap.row], got[gap.row])} {unit}",
        f"{name} = {told(got[gap.row], true[gap.row])}",
        mistakes=mistakes,
        keeps=keeps,
        off=Size(f"{name} is off", gap.worst, unit),
        hint=""
        if mistakes
        else Ours("Return the three numbers of each sensor as data.sensordata holds them in this call (Step 2)."),
    )


@check("sensor_access.follows_address", lab_step=2)
def check_follows_address(student: Student, truth: Traces) -> None:
    """Reads the sensors that the ids name, wherever they lie in sensordata and in whichever model"""
    torso, scene = _torso(student, truth), _torso_scene(truth)
    first = diagnosis.explain(torso.accel, torso.gyro, scene)
    if first is not None and "cached-reading" in first.value_mistakes:
        follows_the_simulation(student, truth)
    if first is not None and first.place_mistake:
        _place_lost(torso, scene, [first.place_mistake])
    fixed = None if first else diagnosis.at_fixed_places(torso.accel, torso.gyro, scene)
    if fixed is not None:
        _place_lost(torso, scene, _elsewhere(student, truth, fixed))
    first = first or diagnosis.treated(torso.accel, torso.gyro, scene)
    if first is None:
        _follows_by_difference(student, truth)
        return
    for name, pairs in _elsewhere_too(truth):
        _follows(student, truth, name, pairs, first)


def _follows_by_difference(student: Student, truth: Traces) -> None:
    """What is done to the numbers is not known: it is done to the same sensors elsewhere, too, and other sensors read otherwise."""
    follows_the_simulation(student, truth)
    (_, torso), scene = _twice(student, truth), _torso_scene(truth)
    moved = _behind_others(student, truth)
    if moved.fault is not None:
        _ignores_ids(moved)
    if _apart(torso, moved) > diagnosis.ATOL + 3 * _apart(*_twice(student, truth)):
        _place_lost(moved, scene, [])
    for name, pairs in _elsewhere_too(truth):
        other = _readings(student, truth, name, pairs)
        if other.fault is not None:
            _ignores_ids(other)
        if not all(_has_numbers(other.of_pair(i)) for i in range(len(other.accel))):
            _place_lost(other, Scene.of(truth[name], pairs), [])
        if name == "reading_lab" and _apart(torso, other.of_pair(0)) <= diagnosis.ATOL:
            _place_lost(other, Scene.of(truth[name], pairs), ["hard-coded-address"])


def _apart(readings: Readings, others: Readings) -> float:
    """How far two sets of readings of one IMU are apart in the same states: infinitely, where they share no number."""
    gaps = np.abs(np.stack([readings.accel - others.accel, readings.gyro - others.gyro]))
    return float(np.nanmax(gaps)) if np.isfinite(gaps).any() else np.inf


def _behind_others(student: Student, truth: Traces) -> Readings:
    """The robot's IMU in the same states, once its sensors stand behind two others of other sizes; of the second visit."""
    scenario = truth["reading_lab"]
    states = len(scenario["qpos"])
    model, pairs = with_others_first(student.robot.xml), scenario["pairs"][:1] + 2
    return _visited(student, model, scenario, pairs, visits=2).between(states, 2 * states)


def with_others_first(xml: str) -> str:
    """A model (MJCF) with two more sensors before its own, which have ids higher by 2 and addresses higher by 3 then."""
    return _ROOT.sub(rf"\g<0>{_OTHERS}", _COMMENT.sub("", xml), count=1)


_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_ROOT = re.compile(r"<mujoco(?:\s[^>]*)?>")
_OTHERS = '<sensor><clock name="seconds_since_start"/><user name="two_of_a_user" dim="2"/></sensor>'


def _elsewhere_too(truth: Traces) -> list[tuple[str, slice]]:
    """Where other IMUs are: on the robot itself, if it has more than one, and in a model with other names."""
    on_robot = [("reading_lab", slice(1, None))] if len(truth["reading_lab"]["pairs"]) > 1 else []
    return [*on_robot, ("reading_shuffled", slice(None))]


def _elsewhere(student: Student, truth: Traces, fixed: Explanation) -> list[str]:
    """Why the IMU's readings come from a place of others: the same one whatever the ids are, or one that goes with them."""
    name, pairs = _elsewhere_too(truth)[0]
    readings, scene = _readings(student, truth, name, pairs), Scene.of(truth[name], pairs)
    if diagnosis.agrees(readings.accel, readings.gyro, fixed, scene):
        return ["hard-coded-address"]
    found = diagnosis.explain(readings.accel, readings.gyro, scene)
    return [found.place_mistake] if found is not None and found.place_mistake else []


def _follows(student: Student, truth: Traces, name: str, pairs: slice, first: Explanation) -> None:
    scene = Scene.of(truth[name], pairs)
    readings = _readings(student, truth, name, pairs)
    if readings.fault is not None:
        _ignores_ids(readings)
    if diagnosis.agrees(readings.accel, readings.gyro, first, scene):
        return
    if _mostly_right(readings, scene):
        return  # the right sensors, some of their numbers altered: matches_truth charges that
    second = diagnosis.explain(readings.accel, readings.gyro, scene)
    if second is not None and second.place_mistake is None and second.value_mistakes == first.value_mistakes:
        return
    _place_lost(readings, scene, _place_mistakes(readings, scene, _torso_scene(truth), second))


def _place_mistakes(readings: Readings, scene: Scene, torso: Scene, found: Explanation | None) -> list[str]:
    if found is not None and found.place_mistake:
        return [found.place_mistake]
    torso_at = (int(torso.address[i]) for i in torso.pairs[0])
    fixed = diagnosis.always_reads(*torso_at)
    return ["hard-coded-address"] if diagnosis.agrees(readings.accel, readings.gyro, fixed, scene) else []


def _ignores_ids(readings: Readings) -> None:
    fault = readings.fault
    assert fault is not None
    place = f" at {fault.where}" if fault.where else ""
    raise CheckFailed(
        "a reading of the sensors whose ids are given, in a model with other sensor names",
        f"{fault.type}: {printable(fault.message, 200)}{place}",
        off=Size("an exception in a model with other sensor names"),
        fault=fault,
        mistakes=["hard-coded-address"] if fault.type in ("KeyError", "ValueError", "IndexError") else [],
    )


def _place_lost(readings: Readings, scene: Scene, mistakes: list[str]) -> None:
    gap, got, true, unit, name = _gap(readings, scene)
    raise CheckFailed(
        f"{name} ≈ {told(true[gap.row], got[gap.row])} {unit}",
        f"{name} = {told(got[gap.row], true[gap.row])}",
        mistakes=mistakes,
        off=Size(f"{name} is off", gap.worst, unit),
        hint="" if mistakes else Ours("Use the ids that are given: start each slice at model.sensor_adr[id] (Step 2)."),
    )


def follows_the_simulation(student: Student, truth: Traces) -> None:
    """Skip the check unless the readings follow the states: a constant, a counter and numbers of chance do not."""
    first, again = _twice(student, truth)
    both = np.concatenate([first.accel, first.gyro])
    if not np.isfinite(both).any():
        raise Skipped("a reading with numbers")
    never_moves = _never_moves(first, again)
    if never_moves and first.disturbance[:, 1].max(initial=0.0) > DISTURBED:
        return  # it follows a simulation that it puts back itself
    if never_moves and _mostly_right(again, _torso_scene(truth)):
        return  # so does the robot's own sensor
    if never_moves:
        raise Skipped("a reading of the simulation: the function returns the same numbers in every state")
    if _is_explained(first, _torso_scene(truth)) or _value_mistakes(student, truth, None):
        return
    likeness = _likeness(both, np.concatenate([again.accel, again.gyro]))
    if likeness < _ALIKE or not _goes_with_states(student, truth, first, again):
        raise Skipped("a reading of the simulation: the function returns other numbers when the same state comes again")


def _is_explained(readings: Readings, scene: Scene) -> bool:
    """Return whether a known reason predicts the readings in every state."""
    known = (diagnosis.explain, diagnosis.at_fixed_places, diagnosis.treated)
    return any(explains(readings.accel, readings.gyro, scene) is not None for explains in known)


def _never_moves(first: Readings, again: Readings) -> bool:
    both = np.nan_to_num(np.concatenate([first.accel, first.gyro, again.accel, again.gyro]))
    return bool(np.ptp(both, axis=1).max() == 0)


def _goes_with_states(student: Student, truth: Traces, first: Readings, again: Readings) -> bool:
    """Return whether a sensor's readings go with the states, and not with the number of the call, as a counter does.

    Another process visits the states in reverse order. What follows them is more like the first visit by state than by call; a
    counter and seeded numbers of chance are the same by call.
    """
    scenario = truth["reading_lab"]
    states = {key: scenario[key][::-1].copy() for key in ("qpos", "qvel")}
    model, pairs = truth.models[scenario.model or "lab"], scenario["pairs"][:1]
    reverse = student.read_in_new_process(model=model, pairs=pairs, **states)
    visits = zip((first.accel, first.gyro), (again.accel, again.gyro), (reverse.accel, reverse.gyro), strict=True)
    return any(
        np.isfinite(one).any()
        and np.isfinite(back).any()
        and _likeness(one, same) >= _ALIKE
        and _likeness(one, back[:, ::-1]) > _likeness(one, back)
        for one, same, back in visits
    )


def _likeness(first: Array, again: Array) -> float:
    """Correlation of two visits (2, k, 3) of the same states, each channel about its own mean and in units of its spread."""
    spread = np.maximum(np.nanstd(first, axis=1, keepdims=True), 1e-12)
    a, b = ((visit - np.nanmean(visit, axis=1, keepdims=True)) / spread for visit in (first, again))
    known = np.isfinite(a) & np.isfinite(b)
    size = float(np.sqrt((a[known] ** 2).sum() * (b[known] ** 2).sum()))
    return float((a[known] * b[known]).sum()) / size if size else 0.0


_ALIKE = 0.5
"""A reader of the sensors has 1, one that smooths over calls nearly that; 78 numbers of chance come so near once in 250,000."""


@check("sensor_access.reading_is_a_copy", lab_step=2, needs=follows_the_simulation)
def check_reading_is_a_copy(student: Student, truth: Traces) -> None:
    """A reading keeps its values while the simulation goes on"""
    readings = _torso(student, truth)
    now = np.concatenate([readings.accel[:, 0], readings.gyro[:, 0]])
    later = np.concatenate([readings.later_accel, readings.later_gyro])
    if np.array_equal(now, later, equal_nan=True):
        return
    moved = np.argmax(np.abs(np.nan_to_num(later - now)).max(axis=1))
    raise CheckFailed(
        f"{vector(now[moved])}, as it was read",
        f"{vector(later[moved])} after data.sensordata had changed and the function had been called again",
        mistakes=["view-not-copy"],
    )


@check("sensor_access.leaves_simulation_alone", lab_step=2, needs=follows_the_simulation)
def check_leaves_simulation_alone(student: Student, truth: Traces) -> None:
    """Reading the sensors changes nothing in the simulation"""
    readings = _torso(student, truth)
    change = readings.disturbance.max(axis=0, initial=0.0)
    names = ("data.time", "data.qpos", "data.qvel", "data.sensordata")
    changed = [
        f"{name} changed by {size:.3g}" for name, size in zip(names, change, strict=True) if not size <= DISTURBED
    ]
    if changed:
        raise CheckFailed(
            "the same simulation state before and after the call", "; ".join(changed), mistakes=["disturbs-simulation"]
        )


def _torso(student: Student, truth: Traces) -> Readings:
    return _twice(student, truth)[0]


def _twice(student: Student, truth: Traces) -> tuple[Readings, Readings]:
    """The robot's IMU in every state, and once more in the same order."""
    readings = _readings(student, truth, "reading_lab", slice(0, 1), visits=2)
    raised(readings.fault, "reading the robot's IMU")
    states = len(truth["reading_lab"]["qpos"])
    return readings.between(0, states), readings.between(states, 2 * states)


def _readings(student: Student, truth: Traces, name: str, pairs: slice, visits: int = 1) -> Readings:
    scenario = truth[name]
    return _visited(student, truth.models[scenario.model or "lab"], scenario, scenario["pairs"][pairs], visits)


def _visited(student: Student, model: str, scenario: Scenario, pairs: np.ndarray, visits: int) -> Readings:
    """Readings of these sensors in all states of a scenario, so many times over."""
    states = {key: np.tile(scenario[key], (visits, 1)) for key in ("qpos", "qvel")}
    return student.read(model=model, pairs=pairs, **states)


def _torso_scene(truth: Traces) -> Scene:
    return Scene.of(truth["reading_lab"], slice(0, 1))
