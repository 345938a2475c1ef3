"""Extension: every IMU that a model has, on the lab model and on one with other places in another order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Size, Skipped, raised
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import Reading, three
from grader.labs.imu.compare import Array, same, vector
from grader.labs.imu.diagnosis import reading as diagnosis
from grader.labs.imu.student import Student
from grader.labs.imu.student_bonuses import ImuReadings, imus

_LAB_PLACES = ("torso", "head", "left_foot", "right_foot")
_STATES = 3
_OF_STATES = ("sensordata", "site_xmat", "qvel", "qacc", "cvel", "cacc")


@check("multiple_imus.finds_every_place")
def check_finds_every_place(student: Student, truth: Traces) -> None:
    """read_all_imus has an entry for every place of the model that has an accelerometer and a gyroscope"""
    lab, other = _worlds(student, truth)
    for world in (lab, other):
        raised(world.got.fault, "reading all IMUs")
        if not world.got.calls or not (world.got.calls[0] or world.got.shape.startswith("a dictionary")):
            wanted = "a dictionary of readings by place, such as 'torso'"
            raise CheckFailed(wanted, world.got.shape, mistakes=["wrong-return-type"])
    missing = [(world, place) for world in (lab, other) for place in world.places if place not in world.got.calls[0]]
    if missing:
        world, place = missing[0]
        got = f"none for '{place}'" + (f" and {len(missing) - 1} more" if len(missing) > 1 else "")
        elsewhere = all(w is other for w, _ in missing)
        where = " of a model with other places" if elsewhere else ""
        raise CheckFailed(
            f"a reading for each place{where}", got, mistakes=["imu-missing"], keeps=0.5 if elsewhere else 0.0
        )


@check("multiple_imus.matches_truth")
def check_matches_truth(student: Student, truth: Traces) -> None:
    """Each place's reading is that of its own accelerometer and gyroscope"""
    worlds = [world for world in _worlds(student, truth) if _known(world)]
    if not worlds:
        raise Skipped("a reading by place")
    wrong = [(world, place) for world in worlds for place in world.read if not world.is_right(place)]
    if wrong:
        world, place = wrong[0]
        state = int(np.argmax(np.abs(world.stacked(place) - world.true(place)).max(axis=1)))
        raise CheckFailed(
            f"{vector(world.true(place)[state])} at '{place}'",
            vector(world.stacked(place)[state]),
            mistakes=_mistakes(worlds),
            keeps=0.5 if all(w.scenario is not _lab(truth) for w, _ in wrong) else 0.0,
            off=Size("readings of other places"),
        )


def _mistakes(worlds: Sequence[_World]) -> list[str]:
    if any(world.all_alike() for world in worlds):
        return ["same-imu-repeated"]
    for world in worlds:
        explained = diagnosis.explain(*world.both(), world.scene())
        if explained and explained.told:
            return list(explained.told)
    return []


@check("multiple_imus.readings_are_copies")
def check_readings_are_copies(student: Student, truth: Traces) -> None:
    """Readings stay what they were when the simulation steps on"""
    world = _worlds(student, truth)[0]
    if not _known(world):
        raise Skipped("a reading by place")
    now = {place: _six(world.got.calls[0][place]) for place in world.read}
    read = [place for place, numbers in now.items() if np.isfinite(numbers).any()]
    if not read:
        raise Skipped("a reading with numbers in it")
    changed = [p for p in read if not np.array_equal(_six(world.got.later.get(p)), now[p], equal_nan=True)]
    if changed:
        got = f"the readings of {len(changed)} of {len(read)} places change with the next step"
        raise CheckFailed("readings that keep their values", got, mistakes=["view-not-copy"])


# --- what the checks share -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _World:
    """The readings in one model, and the truth: ``pairs`` (p, 2) of sensor ids by place."""

    scenario: Scenario
    places: tuple[str, ...]
    got: ImuReadings

    @property
    def read(self) -> list[str]:
        return [place for place in self.places if place in self.got.calls[0]]

    def true(self, place: str) -> Array:
        """(k, 6) acceleration and angular velocity."""
        address = self.scenario["sensor_adr"][self.scenario["pairs"][self.places.index(place)]]
        columns = [first + axis for first in address for axis in range(3)]
        return np.asarray(self.scenario["sensordata"][:_STATES, columns])

    def stacked(self, place: str) -> Array:
        return np.array([_six(call.get(place)) for call in self.got.calls])

    def is_right(self, place: str) -> bool:
        return same(self.stacked(place), self.true(place), diagnosis.ATOL)

    def all_alike(self) -> bool:
        first = self.stacked(self.read[0])
        return len(self.read) > 1 and all(same(self.stacked(place), first, diagnosis.ATOL) for place in self.read[1:])

    def both(self) -> tuple[Array, Array]:
        """(p, k, 3) of each sensor at all places, NaN where one was not read."""
        six = np.array([self.stacked(place) for place in self.places])
        return six[..., :3], six[..., 3:]

    def scene(self) -> diagnosis.Scene:
        few = {key: self.scenario[key][:_STATES] for key in _OF_STATES}
        return diagnosis.Scene.of(replace(self.scenario, arrays={**self.scenario.arrays, **few}))


def _lab(truth: Traces) -> Scenario:
    """The lab's own robot, which has many IMUs, also where another one is graded on."""
    return truth.scenarios.get("reading_sheet", truth["reading_lab"])


def _worlds(student: Student, truth: Traces) -> tuple[_World, _World]:
    lab, other = _lab(truth), truth["reading_many"]
    return _world(student, truth, lab, _LAB_PLACES), _world(student, truth, other, tuple(other.scalars["places"]))


def _world(student: Student, truth: Traces, scenario: Scenario, places: tuple[str, ...]) -> _World:
    qpos, qvel = scenario["qpos"][:_STATES], scenario["qvel"][:_STATES]
    got = imus(student, model=truth.models[scenario.model or ""], qpos=qpos, qvel=qvel)
    return _World(scenario, places, got)


def _known(world: _World) -> bool:
    """Return whether some place was read."""
    raised(world.got.fault, "reading all IMUs")
    return bool(world.got.calls and world.read)


def _six(reading: Reading | None) -> Array:
    """Acceleration and angular velocity (6,), NaN where they are missing."""
    return np.concatenate([three(reading.accel), three(reading.gyro)]) if reading else np.full(6, np.nan)
