"""The extension *Complementary filter*: outputs at rest, in three motions and after single changes, and the faults they show.

Any filter that blends both sensors responds alike, whatever is inside: a turn within one sample comes out as that turn, and a tilt
that lasts comes out as that tilt in the end, and at first as a small part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.charging import Judge
from grader.engine.findings import Raised, Skipped, StudentError
from grader.engine.hypothesis import Reason
from grader.engine.question import Question
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.compare import Array
from grader.labs.imu.lab import LAB
from grader.labs.imu.returned import shape_in_words
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame

LEVEL, SETTLES = "returns_roll_and_pitch", "settles_at_tilt"
RIDES = {
    "beats_gyroscope_alone": "tilt_drifting",
    "beats_accelerometer_alone": "tilt_shaken",
    "holds_when_steep": "tilt_steep",
}
_SINGLE = ("gyro_alone_rms", "accel_alone_rms")
G = 9.81
DT = 0.01
BEFORE, AFTER = 200, 3000  # samples, before and after a change
TILTED = np.array([0.25, -0.12])  # rad: so small that every form of the tilt's equations agrees within a hundredth
TURN = 0.2  # rad, within one sample


def wrapped(angle: Array) -> Array:
    """Return angles in rad, wrapped to [−π, π), so that full turns make no error."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


# ---- the question


@dataclass(frozen=True)
class TiltCase:
    """Input of a complementary filter: specific force and angular velocity (n, 3), sampled every `dt` seconds."""

    dt: float
    acceleration: Array
    angular_velocity: Array


@dataclass(frozen=True)
class TiltRun:
    """Output of a complementary filter for one `TiltCase`.

    Attributes
    ----------
    output : (n, 2) ndarray, roll and pitch in rad; fewer rows if the filter raised, NaN where no two numbers came
    odd : the first value that is no pair of numbers, in words; "" if there is none
    """

    output: Array
    odd: str
    error: StudentError | None

    @property
    def raised(self) -> Exception | None:
        return Raised(self.error, "updating the filter") if self.error else None

    @property
    def stop(self) -> Exception | None:
        """The exception that ends a check of this output: what the filter raised, or a missing angle. None if it can be judged."""
        whole = np.isfinite(self.output).all()
        return self.raised or (None if whole else Skipped("two finite numbers from every update()"))


def tilt(student: Student, cases: Sequence[TiltCase]) -> list[TiltRun]:
    """Run the student's `ComplementaryFilter` over each case, a new instance for each, and return the outputs."""
    arrays = {f"a{i}": case.acceleration for i, case in enumerate(cases)}
    arrays |= {f"g{i}": case.angular_velocity for i, case in enumerate(cases)}
    rows = [{"dt": case.dt, "accel": f"a{i}", "gyro": f"g{i}"} for i, case in enumerate(cases)]
    return student.answer(Question("tilt", "ComplementaryFilter", _runs, {"cases": rows}, arrays))


def _runs(frame: Frame) -> list[TiltRun]:
    return [_run(answer, frame.arrays) for answer in frame.fields["cases"]]


def _run(answer: Mapping[str, Any], arrays: Mapping[str, Array]) -> TiltRun:
    odd = shape_in_words(answer["odd"], arrays) if answer["odd"] else ""
    output = np.zeros((0, 2)) if answer["output"] is None else arrays[answer["output"]]  # it raised before the first
    return TiltRun(output, odd, StudentError.of(answer["error"]))


# ---- the facts


@dataclass(frozen=True)
class Response:
    """Response of a filter to a turn about x, a turn about y, and a tilt without a turn, by which faults are told apart.

    Attributes
    ----------
    turn : (2, 2) ndarray, roll and pitch (columns) per unit of a turn about x and about y (rows)
    first : (2,) ndarray, the share of the tilt that the first output after it shows
    settled : (2,) ndarray, the last output after the tilt, as returned (in rad if right)
    moved : whether the tilt changed the outputs
    """

    turn: Array
    first: Array
    settled: Array
    moved: bool

    @property
    def ignores_gyroscope(self) -> bool:
        """Return whether neither of the two turns shows in the outputs, as if only the accelerometer counted."""
        return bool(np.abs(self.turn).max() < 1e-3)

    @property
    def follows_at_once(self) -> bool:
        """Return whether the first output has nearly all of the tilt, as if the accelerometer had the gyroscope's weight, 0.98."""
        return bool(np.all(np.abs(self.first - 0.98) < 0.015))


@dataclass(frozen=True)
class Tilt:
    """All that is measured of a complementary filter: `measure` makes it, and checks and diagnosis read nothing else.

    Attributes
    ----------
    level : (n, 2) roll and pitch at rest and level, NaN where no two numbers came; odd : in words, what first came instead, or ""
    settled, tilts : (2, 2) roll and pitch after 30 s at rest at two tilts, and these tilts, in rad
    errors, alone : by check, the filter's RMS error in that check's motion, and the error of each sensor by itself, in rad
    response : outputs after a turn about x, a turn about y, and a tilt; None if some are missing
    stopped : by check, the exception that is raised in its place because its property could not be measured
    """

    level: Array
    odd: str = ""
    settled: Array = field(default_factory=lambda: np.zeros((2, 2)))
    tilts: Array = field(default_factory=lambda: np.zeros((2, 2)))
    errors: Mapping[str, float] = field(default_factory=dict)
    alone: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    response: Response | None = None
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def has_angles(self) -> bool:
        return bool(np.isfinite(self.level).all())


def measure(student: Student, truth: Traces) -> Tilt:
    """Run the filter at rest, in `truth`'s three motions (no answer to one fails only its check), two turns and a tilt."""
    level, *still = tilt(student, _inputs_at_rest(truth["tilt_start"]))
    stops: dict[str, Exception | None] = {
        LEVEL: level.raised,
        SETTLES: next((run.stop for run in still if run.stop), None),
    }
    errors: dict[str, float] = {}
    for check, name in RIDES.items():
        ride = truth[name]
        try:
            case = TiltCase(float(ride.scalars["dt"]), ride["acceleration"], ride["angular_velocity"])
            (run,) = tilt(student, [case])
        except NoAnswer as nothing:
            stops[check] = nothing
        else:
            stops[check] = run.stop
            errors |= {} if run.stop else {check: _rms(run.output, ride)}
    probed = tilt(student, [TiltCase(DT, *signals) for signals in _probes()])
    return Tilt(
        level.output,
        level.odd,
        np.zeros((2, 2)) if stops[SETTLES] else np.array([run.output[-1] for run in still]),
        truth["tilt_start"]["tilt"],
        errors,
        {check: {k: float(truth[name].scalars.get(k, 0.0)) for k in _SINGLE} for check, name in RIDES.items()},
        response([run.output for run in probed]),
        {check: stop for check, stop in stops.items() if stop},
    )


def at_rest(angles: Array, n: int) -> Array:
    """Return the specific force (n, 3) of a forward-right-down sensor at rest at `angles` (2,), roll and pitch in rad."""
    roll, pitch = angles
    up = [np.sin(pitch), -np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch)]
    return np.tile(G * np.array(up), (n, 1))


def _inputs_at_rest(start: Scenario) -> list[TiltCase]:
    """Return three inputs of a sensor at rest: level, then at two tilts.

    The first five accelerometer readings at a tilt are wrong, so that a filter that only keeps its first estimate fails.
    """
    tilted = [at_rest(wanted, 1500) for wanted in start["tilt"]]
    for forces, shove in zip(tilted, start["shove"], strict=True):
        forces[:5] += shove
    still = [at_rest(np.zeros(2), 100), *tilted]
    return [TiltCase(float(start.scalars["dt"]), forces, np.zeros_like(forces)) for forces in still]


def _rms(output: Array, ride: Scenario) -> float:
    """Return the RMS error (rad) over the second half of a motion, where the initial state of the filter has decayed."""
    half = len(output) // 2
    return float(np.sqrt(np.mean(wrapped(output[half:] - ride["tilt"][half:]) ** 2)))


def _probes() -> list[tuple[Array, Array]]:
    """Return the inputs (specific force, angular velocity) of three experiments: turns about x and y, a tilt without a turn."""
    level = at_rest(np.zeros(2), BEFORE + 50)
    turned = np.zeros((2, *level.shape))
    turned[[0, 1], BEFORE, [0, 1]] = TURN / DT
    tilted = np.concatenate([at_rest(np.zeros(2), BEFORE), at_rest(TILTED, AFTER)])
    return [(level, turned[0]), (level, turned[1]), (tilted, np.zeros_like(tilted))]


def response(outputs: list[Array]) -> Response | None:
    """Return the `Response` of a filter; None if an output ends within 50 samples of the turn or tilt, or is not finite.

    `outputs` are three arrays (n, 2) of roll and pitch: for a turn about x, a turn about y, and a tilt.
    """
    if any(len(out) < BEFORE + 50 or not np.isfinite(out).all() for out in outputs):
        return None
    tilted = outputs[2]
    before, after = tilted[BEFORE - 1], tilted[-1]
    moved = bool(np.abs(wrapped(after - before)).max() > 1e-3)
    return Response(turns(outputs[:2]), (tilted[BEFORE] - before) / TILTED, after, moved)


def turns(outputs: list[Array]) -> Array:
    """Return what part of a turn about x or y (rows) a student's filter adds to roll and pitch (columns); the identity is right.

    `outputs` are the angles (k, 2) that it returned for a turn about x, and for one about y. The angles of the sample in which the
    robot turns count, or those of the next sample if they change more.
    """
    steps = np.array([wrapped(out[BEFORE : BEFORE + 2] - out[BEFORE - 1]) for out in outputs]) / TURN
    later = np.abs(steps[:, 1]).max(axis=1) > np.abs(steps[:, 0]).max(axis=1)
    return np.asarray(np.where(later[:, None], steps[:, 1], steps[:, 0]))


# ---- the faults


def _is_in_degrees(seen: Response) -> bool:
    own, scale = np.diag(seen.turn), np.degrees(1.0)
    tilted = bool(np.all(np.abs(seen.settled / TILTED / scale - 1.0) < 0.05))
    turned = any(np.all(np.abs(own / factor - 1.0) < 0.1) for factor in (scale, 1.0 / scale))
    return tilted or (turned and not seen.follows_at_once)


def _has_wrong_sign(seen: Response) -> bool:
    """Return whether the tilt settles with another sign, half a turn away or on the other axis, or the turn shows up so."""
    if _near(seen.settled, TILTED):
        unit = np.round(seen.turn)
        one_each = bool(np.all(np.abs(unit).sum(axis=1) == 1)) and _near(seen.turn, unit, 0.1)
        return one_each and not np.array_equal(unit, np.eye(2))
    size = np.abs(wrapped(seen.settled))
    size = np.minimum(size, np.pi - size)
    return any(_near(size, np.abs(tilted)) for tilted in (TILTED, TILTED[::-1]))


def _near(got: Array, wanted: Array, atol: float = 0.02) -> bool:
    return bool(np.all(np.abs(got - wanted) <= atol))


FAULTS: Mapping[str, Callable[[Response], bool]] = {
    "gyro-only": lambda seen: not seen.ignores_gyroscope and not seen.moved,
    "accel-only": lambda seen: seen.moved and seen.ignores_gyroscope,
    "weights-swapped": lambda seen: (
        seen.moved and seen.follows_at_once and _near(np.diag(seen.turn), np.zeros(2), 0.05)
    ),
    "degrees-not-radians": lambda seen: seen.moved and _is_in_degrees(seen),
    "tilt-sign-wrong": lambda seen: seen.moved and _has_wrong_sign(seen),
}
"""For each fault, whether it predicts the response; the most plausible first."""


def _is_pair(facts: Tilt) -> bool:
    """Return whether the level filter returned two numbers, finite or not, to tell NaN from another form."""
    pairs = ("a tuple of 2 (a number, a number)", "a list of 2 (a number, a number)", "an array of shape (2,)")
    return not facts.odd or facts.odd.startswith(pairs)


def _responds(holds: Callable[[Response], bool]) -> Callable[[Tilt], bool]:
    """Return a test of all facts from a test of the response; False if there is no response or no finite angle."""
    return lambda facts: facts.response is not None and facts.has_angles and holds(facts.response)


_REASONS: tuple[Reason[Tilt], ...] = (
    Reason(LEVEL, 1, "not-finite", lambda facts: not facts.has_angles and _is_pair(facts)),
    Reason(LEVEL, 2, "wrong-return-type", lambda facts: not facts.has_angles),
    *(
        Reason(check, 3 + cost, name, _responds(holds))
        for check in (LEVEL, SETTLES, *RIDES)
        for cost, (name, holds) in enumerate(FAULTS.items())
    ),
)
TILT: Judge[Tilt] = Judge(LAB, "complementary_filter", measure, _REASONS)
