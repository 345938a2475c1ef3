"""Sensor access: reads accelerometer and gyroscope, at the place that the ids name, and disturbs nothing."""

from __future__ import annotations

import numpy as np

from ..answers import Readings
from ..compare import deviation, vector
from ..diagnosis import reading as diagnosis
from ..diagnosis.reading import Explanation, Scene
from ..plugin import check
from ..student import Student
from ..text import printable
from ..traces import Traces
from ..verdicts import Lost, Skipped, raised

DISTURBED = 1e-12
"""Reading takes numbers out and puts none in: any change is a change. The margin is for a harmless mj_forward."""


@check("sensor_access.returns_two_vectors", lab_step=2)
def check_returns_two_vectors(student: Student, truth: Traces) -> None:
    """get_imu_readings returns acceleration and angular velocity, three numbers each"""
    readings = _torso(student, truth)
    if not readings.oddities:
        return
    got = "; ".join(readings.oddities[:2])
    nothing = not np.isfinite(readings.accel).any() and not np.isfinite(readings.gyro).any()
    mistake = "wrong-return-type" if nothing or "dictionary" in got or "object" in got else "wrong-length"
    raise Lost("a tuple of two arrays of shape (3,)", got, mistakes=[mistake])


@check("sensor_access.matches_truth", lab_step=2)
def check_matches_truth(student: Student, truth: Traces) -> None:
    """The values are the sensor's own: m/s² and rad/s in the sensor's frame, unaltered"""
    readings, scene = _torso(student, truth), _torso_scene(truth)
    explained = diagnosis.explain(readings.accel, readings.gyro, scene)
    if explained is None:
        unaltered = diagnosis.at_fixed_places(readings.accel, readings.gyro, scene) is not None
    else:
        unaltered = not explained.value_mistakes
    if unaltered:
        return  # whether it is the right place is what follows_address asks
    _values_lost(readings, scene, explained)


def _values_lost(readings: Readings, scene: Scene, explained: Explanation | None) -> None:
    if not np.isfinite(readings.accel).all() and not readings.oddities:
        raise Lost("finite numbers", "NaN or infinity in the reading", mistakes=["not-finite"])
    right = [
        deviation(got.reshape(-1, 3), true.reshape(-1, 3)).worst <= diagnosis.ATOL
        for got, true in ((readings.accel, scene.accel), (readings.gyro, scene.gyro))
    ]
    wrong_gyro = right[0] and not right[1]
    got, true, unit = (readings.gyro, scene.gyro, "rad/s") if wrong_gyro else (readings.accel, scene.accel, "m/s²")
    gap = deviation(got[0], true[0])
    row = gap.row
    name = "gyro" if wrong_gyro else "accel"
    raise Lost(
        f"{name} ≈ {vector(true[0, row])} {unit}",
        f"{name} = {vector(got[0, row])}",
        mistakes=explained.value_mistakes if explained else (),
        keeps=0.5 if any(right) else 0.0,
        off=f"{name} off by up to {gap.worst:.3g} {unit}",
    )


@check("sensor_access.follows_address", lab_step=2)
def check_follows_address(student: Student, truth: Traces) -> None:
    """Reads the sensors that the ids name, wherever they lie in sensordata and in whichever model"""
    torso, scene = _torso(student, truth), _torso_scene(truth)
    first = diagnosis.explain(torso.accel, torso.gyro, scene)
    if first is not None and first.place_mistake:
        _place_lost(torso, scene, [first.place_mistake])
    fixed = None if first else diagnosis.at_fixed_places(torso.accel, torso.gyro, scene)
    if fixed is not None:
        _place_lost(torso, scene, _elsewhere(student, truth, fixed))
    first = first or diagnosis.treated(torso.accel, torso.gyro, scene)
    for name, pairs in (("reading_lab", slice(1, None)), ("reading_shuffled", slice(None))):
        _follows(student, truth, name, pairs, first)


def _elsewhere(student: Student, truth: Traces, fixed: Explanation) -> list[str]:
    """Why the torso's readings come from a place of others: the same one whatever the ids are, or one that goes with them."""
    pairs = slice(1, None)
    readings, scene = _readings(student, truth, "reading_lab", pairs), Scene.of(truth["reading_lab"], pairs)
    if diagnosis.agrees(readings.accel, readings.gyro, fixed, scene):
        return ["hard-coded-address"]
    found = diagnosis.explain(readings.accel, readings.gyro, scene)
    return [found.place_mistake] if found is not None and found.place_mistake else []


def _follows(student: Student, truth: Traces, name: str, pairs: slice, first: Explanation | None) -> None:
    scene = Scene.of(truth[name], pairs)
    readings = _readings(student, truth, name, pairs)
    if readings.fault is not None:
        _ignores_ids(readings)
    if first is not None and diagnosis.agrees(readings.accel, readings.gyro, first, scene):
        return
    second = diagnosis.explain(readings.accel, readings.gyro, scene)
    if (
        second is not None
        and second.place_mistake is None
        and (first is None or second.value_mistakes == first.value_mistakes)
    ):
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
    raise Lost(
        "a reading of the sensors whose ids are given, in a model with other sensor names",
        f"{fault.type}: {printable(fault.message, 200)}{place}",
        off="an exception, as the sensors have other names there",
        mistakes=["hard-coded-address"] if fault.type in ("KeyError", "ValueError", "IndexError") else [],
    )


def _place_lost(readings: Readings, scene: Scene, mistakes: list[str]) -> None:
    gaps = [
        deviation(got.reshape(-1, 3), true.reshape(-1, 3))
        for got, true in ((readings.accel, scene.accel), (readings.gyro, scene.gyro))
    ]
    wrong_gyro = gaps[0].worst <= diagnosis.ATOL
    got, true, unit = (readings.gyro, scene.gyro, "rad/s") if wrong_gyro else (readings.accel, scene.accel, "m/s²")
    gap, name = (gaps[1], "gyro") if wrong_gyro else (gaps[0], "accel")
    row = gap.row
    raise Lost(
        f"{name} ≈ {vector(true.reshape(-1, 3)[row])} {unit}",
        f"{name} = {vector(got.reshape(-1, 3)[row])}",
        mistakes=mistakes,
        off=f"{name} off by up to {gap.worst:.3g} {unit}",
        hint="The ids are arguments: use model.sensor_adr[id] of each, whatever the model.",
    )


@check("sensor_access.reading_is_a_copy", lab_step=2)
def check_reading_is_a_copy(student: Student, truth: Traces) -> None:
    """A reading keeps its values while the simulation goes on"""
    readings = _torso(student, truth)
    _reads_something(readings, truth)
    now = np.concatenate([readings.accel[:, 0], readings.gyro[:, 0]])
    later = np.concatenate([readings.later_accel, readings.later_gyro])
    if np.array_equal(now, later, equal_nan=True):
        return
    moved = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(later - now)), axis=1)))
    raise Lost(
        f"{vector(now[moved])}, as it was read", f"{vector(later[moved])} one step later", mistakes=["view-not-copy"]
    )


@check("sensor_access.leaves_simulation_alone", lab_step=2)
def check_leaves_simulation_alone(student: Student, truth: Traces) -> None:
    """Reading the sensors changes nothing in the simulation"""
    readings = _torso(student, truth)
    _reads_something(readings, truth)
    change = readings.disturbance.max(axis=0, initial=0.0)
    names = ("data.time", "data.qpos", "data.qvel", "data.sensordata")
    changed = [
        f"{name} changed by {size:.3g}" for name, size in zip(names, change, strict=True) if not size <= DISTURBED
    ]
    if changed:
        raise Lost("the same state before and after the call", "; ".join(changed), mistakes=["disturbs-simulation"])


def _reads_something(readings: Readings, truth: Traces) -> None:
    """Constants are no reading: nothing can be said about how they were read."""
    both = np.concatenate([readings.accel, readings.gyro])
    if not np.isfinite(both).any():
        raise Skipped("a reading with numbers in it")
    never_moves = bool(np.isfinite(both).all() and np.ptp(both, axis=1).max() == 0)
    if never_moves and diagnosis.explain(readings.accel, readings.gyro, _torso_scene(truth)) is None:
        raise Skipped("a reading that follows the simulation: the same numbers came in every state")


def _torso(student: Student, truth: Traces) -> Readings:
    readings = _readings(student, truth, "reading_lab", slice(0, 1))
    raised(readings.fault, "reading the torso's sensors")
    return readings


def _readings(student: Student, truth: Traces, name: str, pairs: slice) -> Readings:
    scenario = truth[name]
    return student.read(
        f"{name}[{pairs.start}:]",
        model=truth.models[scenario.model or "lab"],
        qpos=scenario["qpos"],
        qvel=scenario["qvel"],
        pairs=np.asarray(scenario["pairs"], np.int64)[pairs],
    )


def _torso_scene(truth: Traces) -> Scene:
    return Scene.of(truth["reading_lab"], slice(0, 1))
