"""Checks of `get_imu_readings` (the reader): each compares one measured property with a limit."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from grader.base.text import printable
from grader.engine.findings import Came, Deviation, Form, Size
from grader.labs.imu.collection import SENSOR_UNITS, SENSORS
from grader.labs.imu.compare import SENSOR_NAMES, Array, changes_in_words, deviation, distinct_texts, vector
from grader.labs.imu.sensor_access.explain import JUDGE, Explained
from grader.labs.imu.sensor_access.measure import FORM, Visit


class Reading(TypedDict):
    """Texts for a message: the reading that was wanted, and the reading that the student's code returned."""

    wanted: str
    got: str


class Values(Reading, Form):
    """Values for the message on wrong numbers in a reading: reading wanted and returned, form wanted and returned, and `grain`.

    `grain` is the smallest gap between the numbers returned (infinite if all are equal); a large one shows that the code rounds.
    """

    grain: float


Kept = TypedDict("Kept", {"now": str, "later": str})


@JUDGE.check("sensor_access.returns_two_vectors", lab_step=2)
def check_returns_two_vectors(found: Explained) -> Deviation[Form] | None:
    """get_imu_readings returns acceleration and angular velocity, three numbers each"""
    return Deviation({"form": FORM, "came": found.facts.odd}) if found.facts.odd else None


@JUDGE.check("sensor_access.matches_truth", lab_step=2)
def check_matches_truth(found: Explained) -> Deviation[Values] | None:
    """The values are the sensor's own: m/s² and rad/s in the sensor's frame, unaltered"""
    if (wrong := found.altered()) is None:
        return None
    visit, sensor = wrong
    reading, size = _furthest_reading(visit, sensor, found.meant(visit, sensor), whole=found.facts.whole)
    steps = np.diff(np.unique(visit.got[sensor][np.isfinite(visit.got[sensor])]))
    numbers: Values = {**reading, "form": FORM, "came": found.facts.odd, "grain": float(steps.min(initial=np.inf))}
    affected = found.share_altered * (0.5 if found.near(visit) else 1.0)
    return Deviation(numbers, 1.0 if found.facts.whole else 0.5, size, affected=affected)


@JUDGE.check("sensor_access.follows_address", lab_step=2)
def check_follows_address(found: Explained) -> Deviation[Reading] | None:
    """Reads the sensors that the ids name, at any address and in any model"""
    if (wrong := found.misplaced()) is not None:
        visit, sensor = wrong
        reading, size = _furthest_reading(visit, sensor, visit.scene.true(sensor), whole=found.facts.whole)
        return Deviation(reading, size=size, affected=found.share_misplaced)
    if (error := next((visit.error for visit in found.facts.others if visit.error), None)) is None:
        return None
    came = f"{error.type}: {printable(error.message, 200)}{f' at {error.where}' if error.where else ''}"
    wanted = "a reading of the sensors whose ids are given, in a model with other sensor names"
    return Deviation(
        {"wanted": wanted, "got": came}, size=Size("an exception in a model with other sensor names"), error=error
    )


@JUDGE.check("sensor_access.reading_is_a_copy", lab_step=2)
def check_reading_is_a_copy(found: Explained) -> Deviation[Kept] | None:
    """A reading keeps its values while the simulation goes on"""
    now, later = np.array([each[0] for each in found.facts.torso.got]), found.facts.later
    if np.array_equal(now, later, equal_nan=True):
        return None
    moved = int(np.argmax(np.abs(np.nan_to_num(later - now)).max(axis=1)))
    return Deviation({"now": vector(now[moved]), "later": vector(later[moved])})


@JUDGE.check("sensor_access.leaves_simulation_alone", lab_step=2)
def check_leaves_simulation_alone(found: Explained) -> Deviation[Came] | None:
    """Reading the sensors changes nothing in the simulation"""
    told = changes_in_words(found.facts.disturbance)
    return Deviation({"came": told}) if told else None


def _furthest_reading(visit: Visit, sensor: int, true: Array, *, whole: bool) -> tuple[Reading, Size]:
    """Describe the reading that is furthest from `true`, for a message; `whole` is whether each vector has three numbers."""
    got, name, unit = visit.got[sensor], SENSOR_NAMES[sensor], SENSOR_UNITS[sensor]
    gap = deviation(got, true)
    wanted, came = distinct_texts(true[gap.row], got[gap.row])
    there = np.isfinite(got[gap.row])
    if not whole and there.any():  # NaN stands for a number that did not come
        came = vector(got[gap.row][there])
    size = Size(f"the {SENSORS[sensor].replace('_', ' ')} is off", gap.worst, unit)
    return {"wanted": f"{name} ≈ {wanted} {unit}", "got": f"{name} = {came}"}, size
