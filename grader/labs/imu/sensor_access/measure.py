"""Facts about `get_imu_readings`: its values for each IMU of the robot and of a generated model, and the simulator's data then."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from grader.engine.findings import Raised, StudentError, Unusable
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import Readings
from grader.labs.imu.compare import Array, triple
from grader.labs.imu.returned import if_nothing
from grader.labs.imu.student import Student

ATOL = 1e-5
"""m/s², rad/s. A reader copies numbers: single precision keeps 1e-6 of 10 m/s², rounding to four decimals breaks 5e-5."""
FORM = "a tuple of two arrays of shape (3,)"
CHECKS = ("returns_two_vectors", "matches_truth", "follows_address", "reading_is_a_copy", "leaves_simulation_alone")


@dataclass(frozen=True)
class Scene:
    """Data of the simulator in the k states in which `get_imu_readings` is called with the ids of one IMU.

    Attributes
    ----------
    sensordata : (k, n); address : (sensors,) first index of each sensor; pair : ids of the accelerometer and gyroscope
    world_from_site, world_from_body : (k, 3, 3) rotation matrices of the sensor's site and of its body; qvel, qacc : (k, nv)
    cvel, cacc : (k, 6) velocity and acceleration of the sensor's body as MuJoCo keeps them: rotation, then translation
    first : scene of the model's first IMU, the torso's, which faulty code may read whatever ids it gets; None if this is it
    """

    sensordata: Array
    address: np.ndarray
    pair: tuple[int, int]
    world_from_site: Array
    world_from_body: Array
    qvel: Array
    qacc: Array
    cvel: Array
    cacc: Array
    first: Scene | None = None

    @classmethod
    def of(cls, scenario: Scenario, number: int = 0) -> Scene:
        """Return the data of the IMU with this number in the states of a scenario of the traces; 0 is the torso's IMU."""
        accel, gyro = (int(sensor) for sensor in scenario["pairs"][number])
        site, body, cvel, cacc = (scenario[key][:, number] for key in ("site_xmat", "body_xmat", "cvel", "cacc"))
        of_robot = scenario["qvel"], scenario["qacc"]
        first = cls.of(scenario) if number else None
        return cls(
            scenario["sensordata"], scenario["sensor_adr"], (accel, gyro), site, body, *of_robot, cvel, cacc, first
        )

    @property
    def torso(self) -> Scene:
        """Return the torso's scene, `first` or else this one: faulty code may read the torso by its name whatever ids it gets."""
        return self.first or self

    def at(self, first: int) -> Array:
        """Return ``sensordata[first:first+3]`` (k, 3), NaN beyond its ends: a robot may have few sensors."""
        return triple(self.sensordata, first)

    def own(self, sensor: int) -> int:
        """Return the index in sensordata at which the IMU's accelerometer (0) or gyroscope (1) begins."""
        return int(self.address[self.pair[sensor]])

    def true(self, sensor: int) -> Array:
        return self.at(self.own(sensor))


@dataclass(frozen=True)
class Visit:
    """Readings of an IMU in k states (`scene`): `got`, two arrays (k, 3), NaN for no number; `error`, the exception, or None."""

    scene: Scene
    got: tuple[Array, Array]
    error: StudentError | None = None


@dataclass(frozen=True)
class Facts:
    """Facts measured of one student's `get_imu_readings`, before anything is judged.

    Attributes
    ----------
    torso, again : readings of the robot's IMU in every state, and once more in the same order
    others : readings of the other IMUs of the robot, and of those of a model with other names and another order
    later : (2, 3) the two arrays of the first reading, looked at again after the simulation moved on; unchanged if they are copies
    disturbance : largest changes of time, qpos, qvel and sensordata while reading
    odd : in words, how the returned form differs from the sheet's; "" if it does not
    whole : whether each returned vector has three numbers
    departs : the sheet's names of parameters that the function has by other names or in other places, as in `Readings`
    reverse : accelerations and angular velocities from another process that visits the states in reverse; None if not asked for
    stopped : by name of a check, the exception that kept its property from being measured
    """

    torso: Visit
    again: Visit
    others: tuple[Visit, ...]
    later: Array
    disturbance: Array
    odd: str = ""
    whole: bool = True
    departs: tuple[str, ...] = ()
    reverse: tuple[Array, Array] | None = None
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def visits(self) -> list[Visit]:
        """The readings without `error`, the torso's first; an exception at one IMU leaves out all that were asked for with it."""
        return [visit for visit in (self.torso, *self.others) if visit.error is None]


def measure(student: Student, truth: Traces) -> Facts:
    """Return the facts about `get_imu_readings`, asked for the robot's IMU in every state twice, and for all other IMUs once."""
    lab = truth["reading_lab"]
    readings, k = _read(student, truth, lab, slice(0, 1), visits=2), len(lab["qpos"])
    torso, again = (_visit(lab, 0, readings, 0, slice(start, start + k)) for start in (0, k))
    return Facts(
        torso,
        again,
        () if readings.error else tuple(_others(student, truth)),
        later=np.concatenate([readings.later_accel, readings.later_gyro]),
        disturbance=readings.disturbance.max(axis=0, initial=0.0),
        odd="; ".join(readings.oddities[:2]),
        whole=readings.whole,
        departs=readings.departs,
        stopped=_stopped(readings),
    )


def in_reverse(student: Student, truth: Traces) -> tuple[Array, Array]:
    """Return both sensors' readings (k, 3), row i for state i, of a new process that visits the states in reverse.

    Readings that depend on the number of calls then differ from those of the first process.
    """
    lab = truth["reading_lab"]
    states = {key: lab[key][::-1].copy() for key in ("qpos", "qvel")}
    readings = student.read_in_new_process(model=truth.models[lab.model or "lab"], pairs=lab["pairs"][:1], **states)
    return readings.accel[0, ::-1], readings.gyro[0, ::-1]


def _others(student: Student, truth: Traces) -> Iterator[Visit]:
    for name, first in (("reading_lab", 1), ("reading_shuffled", 0)):
        scenario = truth[name]
        if count := len(scenario["pairs"][first:]):
            readings = _read(student, truth, scenario, slice(first, None))
            yield from (_visit(scenario, first + i, readings, i, slice(None)) for i in range(count))


def _read(student: Student, truth: Traces, scenario: Scenario, pairs: slice, visits: int = 1) -> Readings:
    states = {key: np.tile(scenario[key], (visits, 1)) for key in ("qpos", "qvel")}
    return student.read(model=truth.models[scenario.model or "lab"], pairs=scenario["pairs"][pairs], **states)


def _visit(scenario: Scenario, number: int, readings: Readings, row: int, states: slice) -> Visit:
    got = readings.accel[row, states], readings.gyro[row, states]
    return Visit(Scene.of(scenario, number), got, readings.error)


def _stopped(readings: Readings) -> dict[str, Exception]:
    if readings.error is not None:
        return dict.fromkeys(CHECKS, Raised(readings.error, "reading the robot's IMU"))
    if not readings.oddities or np.isfinite([readings.accel, readings.gyro]).any():
        return {}
    odd = "; ".join(readings.oddities[:2])
    return dict.fromkeys(CHECKS, Unusable(FORM, odd, faults=["wrong-return-type"], hint=if_nothing(odd)))


def with_stops(facts: Facts, stop: Exception, *names: str) -> Facts:
    """Return the facts with the exception `stop` added to `stopped` for the checks `names`, which then end with it."""
    return replace(facts, stopped={**facts.stopped, **dict.fromkeys(names, stop)})
