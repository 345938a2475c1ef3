"""The extension *Multiple IMUs*: readings of `read_all_imus` in the lab's model and in one with other IMUs, beside the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from grader.engine.charging import Judge
from grader.engine.findings import Raised, Skipped, StudentError
from grader.engine.hypothesis import Reason
from grader.engine.question import Question
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import Reading, as_reading, three
from grader.labs.imu.compare import Array, same
from grader.labs.imu.lab import LAB
from grader.labs.imu.returned import Arrays, Node, shape_in_words
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame

ATOL = 1e-5
"""m/s² and rad/s, between a reading and the truth: single precision errs by 1e-6 at 10 m/s²."""
PLACES = ("torso", "head", "left_foot", "right_foot")
_STATES = 3
_FINDS, _MATCHES, _COPIES = "finds_every_place", "matches_truth", "readings_are_copies"

# ---- the question


@dataclass(frozen=True)
class ImuReadings:
    """Answers of a student's `read_all_imus`, for several states of one model.

    Attributes
    ----------
    calls : for each state before an exception: a `Reading` (two vectors) by name of the IMU, in lower case, without a final "_imu"
    later : the first result, looked at again after the next step: a copy has not changed
    shape : the first result in words, such as "a dictionary with 'torso'", for messages; "nothing" if there is none
    """

    calls: tuple[Mapping[str, Reading], ...]
    later: Mapping[str, Reading]
    shape: str
    error: StudentError | None


def imus(student: Student, *, model: str, qpos: Array, qvel: Array) -> ImuReadings:
    """Ask the student's `read_all_imus` in k states, qpos (k, nq) and qvel (k, nv), of a model (MJCF text); return its answers."""
    states = {"qpos": qpos, "qvel": qvel}
    return student.answer(Question("imus", "read_all_imus", _readings, {"model": model}, states))


def _readings(frame: Frame) -> ImuReadings:
    nodes = frame.fields["calls"]
    shape = shape_in_words(nodes[0], frame.arrays) if nodes else "nothing"
    calls = tuple(_by_place(node, frame.arrays) for node in nodes)
    return ImuReadings(
        calls, _by_place(frame.fields["later"], frame.arrays), shape, StudentError.of(frame.fields.get("error"))
    )


def _by_place(node: Node | None, arrays: Arrays) -> dict[str, Reading]:
    """Return readings by the student's name for the IMU, in lower case and without a final ``_imu``; none if no dictionary came."""
    if node is None or node["kind"] not in ("dict", "object"):
        return {}
    return {name.lower().removesuffix("_imu"): as_reading(item, arrays) for name, item in node["items"]}


# ---- the facts


@dataclass(frozen=True)
class World:
    """Answers `got` for one model, and `true` readings by name of the IMU: (k, 6) acceleration and angular velocity in k states."""

    got: ImuReadings
    true: Mapping[str, Array]

    @cached_property
    def read(self) -> Mapping[str, Array]:
        """Returned readings (k, 6) in all states by name, for the IMUs returned in the first state; NaN for missing numbers."""
        first = self.got.calls[0] if self.got.calls else {}
        calls = {place: [_six(call.get(place)) for call in self.got.calls] for place in self.true if place in first}
        return {place: np.array(rows) for place, rows in calls.items()}

    @property
    def wrong(self) -> list[str]:
        """The names of the IMUs whose returned readings differ from the truth; an IMU missing in the first state does not count."""
        return [place for place, rows in self.read.items() if not same(rows, self.true[place], ATOL)]

    @property
    def with_numbers(self) -> Mapping[str, Array]:
        """The first state's row (6,) of `read`, by name, to test for copies: only IMUs that have a finite number in it."""
        return {place: rows[0] for place, rows in self.read.items() if np.isfinite(rows[0]).any()}

    @property
    def changed(self) -> list[str]:
        """The IMUs whose first reading changed during the next step, and so is a view into MuJoCo's memory and no copy."""
        later = self.got.later
        return [
            p for p, row in self.with_numbers.items() if not np.array_equal(_six(later.get(p)), row, equal_nan=True)
        ]

    @property
    def repeats_one(self) -> bool:
        """Return whether every IMU has the first one's readings, as if the code ignored the IMU's name; False for a single IMU."""
        rows = list(self.read.values())
        return len(rows) > 1 and all(same(each, rows[0], 1e-9) for each in rows[1:])

    @property
    def has_no_dictionary(self) -> bool:
        return not self.got.calls or not (self.got.calls[0] or self.got.shape.startswith("a dictionary"))


def _six(reading: Reading | None) -> Array:
    """Return acceleration and angular velocity as (6,), NaN where they are missing."""
    return np.concatenate([three(reading.accel), three(reading.gyro)]) if reading else np.full(6, np.nan)


@dataclass(frozen=True)
class Imus:
    """All that is measured of a `read_all_imus`, in the lab's model and in one with other IMUs; checks read nothing else."""

    lab: World
    other: World
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def worlds(self) -> tuple[World, World]:
        return self.lab, self.other

    @property
    def has_no_dictionary(self) -> bool:
        return any(world.has_no_dictionary for world in self.worlds)


def measure(student: Student, truth: Traces) -> Imus:
    """Return answers of `read_all_imus` for the lab's robot and a generated one; not an instructor's, which may have one IMU."""
    sheet = truth.scenarios.get("reading_sheet", truth["reading_lab"])
    many = truth["reading_many"]
    lab, other = _world(student, truth, sheet, PLACES), _world(student, truth, many, tuple(many.scalars["places"]))
    stops: dict[str, Exception] = {}
    if not (lab.read or other.read):
        stops[_MATCHES] = Skipped("a reading by place")
    if not lab.with_numbers:
        stops[_COPIES] = Skipped("a reading by place, with numbers in it")
    for checks, error in (((_FINDS, _MATCHES), lab.got.error or other.got.error), ((_COPIES,), lab.got.error)):
        if error:
            stops |= dict.fromkeys(checks, Raised(error, "reading all IMUs"))
    return Imus(lab, other, stops)


def _world(student: Student, truth: Traces, scenario: Scenario, places: Sequence[str]) -> World:
    qpos, qvel = scenario["qpos"][:_STATES], scenario["qvel"][:_STATES]
    got = imus(student, model=truth.models[scenario.model or ""], qpos=qpos, qvel=qvel)
    columns = (scenario["sensor_adr"][scenario["pairs"]][:, :, None] + np.arange(3)).reshape(-1, 6)
    true = {place: scenario["sensordata"][:_STATES, its] for place, its in zip(places, columns, strict=False)}
    return World(got, true)


_REASONS: tuple[Reason[Imus], ...] = (
    Reason(_FINDS, 1, "wrong-return-type", lambda facts: facts.has_no_dictionary),
    Reason(_FINDS, 2, "imu-missing", lambda _: True),
    Reason(_MATCHES, 1, "same-imu-repeated", lambda facts: any(world.repeats_one for world in facts.worlds)),
)
IMUS: Judge[Imus] = Judge(LAB, "multiple_imus", measure, _REASONS)
