"""Facts about the extensions: what each returned for the inputs that tell right from wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.findings import Raised, Skipped
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import Reading, three
from grader.labs.imu.bonuses import allan, questions, tilting
from grader.labs.imu.bonuses.questions import AllanRun, ImuReadings, LiveRun, TiltCase, TiltRun
from grader.labs.imu.compare import Array, same
from grader.labs.imu.robot import torso_ids
from grader.labs.imu.student import Student

ATOL = 1e-5
"""m/s² and rad/s, between a reading and the truth: single precision errs by 1e-6 at 10 m/s²."""
PLACES = ("torso", "head", "left_foot", "right_foot")
_STATES = 3
RIDES = {
    "beats_gyroscope_alone": "tilt_drifting",
    "beats_accelerometer_alone": "tilt_shaken",
    "holds_when_steep": "tilt_steep",
}
KINDS = ("white", "walk", "quantised", "drift")
"""Kinds of noise whose slopes are compared."""
_RECORDS = ("white", "walk", "quantised", "mixed")

# ---- the complementary filter ----


@dataclass(frozen=True)
class Tilt:
    """Facts about a complementary filter.

    Attributes
    ----------
    level : (n, 2) roll and pitch at rest and level, NaN where no two numbers came; `odd` is what came then
    settled, tilts : (2, 2) roll and pitch after 30 s at rest at two tilts, and these tilts, in rad
    errors, alone : by check, the RMS error in its ride, and those of each sensor alone, in rad
    response : to single changes of each sensor; None where it was not whole
    """

    level: Array
    odd: str = ""
    settled: Array = field(default_factory=lambda: np.zeros((2, 2)))
    tilts: Array = field(default_factory=lambda: np.zeros((2, 2)))
    errors: Mapping[str, float] = field(default_factory=dict)
    alone: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    response: tilting.Response | None = None
    stopped: Mapping[str, Exception] = field(default_factory=dict)


def measure_tilt(student: Student, truth: Traces) -> Tilt:
    """Run the filter at rest, in three rides and over single changes; each ride by itself, so that each has its own time."""
    level, *still = questions.tilt(student, _at_rest(truth["tilt_start"]))
    stopped: dict[str, Exception] = {}
    if level.fault:
        stopped["returns_roll_and_pitch"] = Raised(level.fault, _UPDATING)
    stopped |= _stopped_by("settles_at_tilt", still)
    errors: dict[str, float] = {}
    for check, name in RIDES.items():
        ride = truth[name]
        try:
            (run,) = questions.tilt(student, [_case(ride)])
        except NoAnswer as nothing:
            stopped[check] = nothing
            continue
        stopped |= _stopped_by(check, [run])
        errors[check] = np.nan if check in stopped else _rms(run.output, ride)
    probes = questions.tilt(student, [TiltCase(tilting.DT, *signals) for signals in tilting.probes()])
    return Tilt(
        level.output,
        level.odd or "",
        np.array([run.output[-1] for run in still]) if "settles_at_tilt" not in stopped else np.zeros((2, 2)),
        truth["tilt_start"]["tilt"],
        errors,
        {check: {k: float(truth[name].scalars.get(k, 0.0)) for k in _SINGLE} for check, name in RIDES.items()},
        tilting.response([run.output for run in probes]),
        stopped,
    )


_UPDATING = "updating the filter"
_SINGLE = ("gyro_alone_rms", "accel_alone_rms")


def _at_rest(start: Scenario) -> list[TiltCase]:
    """Return rest while level, then at two tilts, with a shove that spoils the first readings."""
    tilted = [tilting.at_rest(wanted, 1500) for wanted in start["tilt"]]
    for forces, shove in zip(tilted, start["shove"], strict=True):
        forces[:5] += shove
    still = [tilting.at_rest(np.zeros(2), 100), *tilted]
    return [TiltCase(float(start.scalars["dt"]), forces, np.zeros_like(forces)) for forces in still]


def _case(ride: Scenario) -> TiltCase:
    return TiltCase(float(ride.scalars["dt"]), ride["acceleration"], ride["angular_velocity"])


def _stopped_by(check: str, runs: Sequence[TiltRun]) -> dict[str, Exception]:
    for run in runs:
        if run.fault:
            return {check: Raised(run.fault, _UPDATING)}
        if not np.isfinite(run.output).all():
            return {check: Skipped("two finite numbers from every update()")}
    return {}


def _rms(output: Array, ride: Scenario) -> float:
    """Return the error over the second half, when every start is forgotten."""
    half = len(output) // 2
    return float(np.sqrt(np.mean(tilting.wrapped(output[half:] - ride["tilt"][half:]) ** 2)))


# ---- the Allan deviation ----


@dataclass(frozen=True)
class Allan:
    """Facts about an `allan_deviation`.

    Attributes
    ----------
    rate : of the samples, in Hz; shape : of what it returned, in words
    odd : how many averaging times and deviations of white noise are not finite; None where they could not be made out
    curves : by kind of noise, averaging times (k,), deviations (k,) and the samples (n,)
    axes, alone : the curve (k, 3) of three axes, None where it could not be made out, and those of each axis alone
    """

    rate: float
    shape: str = ""
    odd: int | None = 0
    curves: Mapping[str, allan.Record] = field(default_factory=dict)
    axes: Array | None = None
    axes_shape: str = ""
    alone: Sequence[Array] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @cached_property
    def records(self) -> list[allan.Record]:
        return [self.curves[kind] for kind in _RECORDS]

    @cached_property
    def meant(self) -> tuple[bool, allan.Sized] | None:
        """Conversion of averaging times to samples under which every curve is an Allan deviation, and whether they are seconds."""
        return allan.unit_of_times(self.records, self.rate)


def measure_allan(student: Student, truth: Traces) -> Allan:
    """Ask for the deviation of five records, of three axes at once, and of each of these alone."""
    scenario = truth["allan"]
    rate = float(scenario.scalars["sample_rate_hz"])
    kinds = dict.fromkeys((*_RECORDS, *KINDS))
    runs = {kind: questions.allan(student, scenario[kind], rate) for kind in kinds}
    together = questions.allan(student, scenario["axes"], rate)
    alone = [questions.allan(student, scenario["axes"][:, axis], rate) for axis in range(3)]
    stop = next((stop for run in runs.values() if (stop := _no_curve(run))), None)
    stopped = (
        {} if stop is None else dict.fromkeys(("averaging_times", "matches_definition", "shows_kinds_of_noise"), stop)
    )
    if runs["white"].fault:
        stopped["returns_times_and_deviations"] = Raised(runs["white"].fault, _COMPUTING)
    if together.fault:
        stopped["takes_three_axes"] = Raised(together.fault, f"{_COMPUTING} of samples (n, 3)")
    elif together.adev is not None and (single := next(filter(None, map(_no_curve, alone)), None)):
        stopped["takes_three_axes"] = single
    white = runs["white"]
    return Allan(
        rate,
        white.shape,
        None
        if white.taus is None or white.adev is None
        else int(sum((~np.isfinite(x)).sum() for x in (white.taus, white.adev))),
        {} if stop else {kind: (*_curve(run), scenario[kind]) for kind, run in runs.items()},
        together.adev,
        together.shape,
        [] if "takes_three_axes" in stopped or together.adev is None else [_curve(run)[1] for run in alone],
        stopped,
    )


_COMPUTING = "computing the Allan deviation"


def _no_curve(run: AllanRun) -> Exception | None:
    if run.fault:
        return Raised(run.fault, _COMPUTING)
    if run.taus is None or run.adev is None:
        return Skipped("averaging times and deviations")
    return None if _known(run).sum() >= 3 else Skipped("three averaging times or more")


def _known(run: AllanRun) -> np.ndarray:
    return np.asarray(np.isfinite(run.taus) & np.isfinite(run.adev[:, 0]))  # type: ignore[arg-type,index] # it has a curve


def _curve(run: AllanRun) -> tuple[Array, Array]:
    """Return averaging times and deviations (k,), finite ones alone, by increasing time."""
    known = _known(run)
    taus, adev = run.taus[known], run.adev[known, 0]  # type: ignore[index] # it has a curve
    order = np.argsort(taus, kind="stable")
    return allan.thinned(taus[order], adev[order])


# ---- all IMUs ----


@dataclass(frozen=True)
class World:
    """The readings in one model, and the truth there: (k, 6) acceleration and angular velocity in k states, by place."""

    got: ImuReadings
    true: Mapping[str, Array]

    @cached_property
    def read(self) -> Mapping[str, Array]:
        """The readings like the truth, of the places that the first call returned; NaN where a number is missing."""
        first = self.got.calls[0] if self.got.calls else {}
        return {
            place: np.array([_six(call.get(place)) for call in self.got.calls]) for place in self.true if place in first
        }

    @property
    def wrong(self) -> list[str]:
        return [place for place, rows in self.read.items() if not same(rows, self.true[place], ATOL)]

    @property
    def changed(self) -> list[str]:
        """The places with numbers whose first readings changed with the next step."""
        now = {place: rows[0] for place, rows in self.read.items() if np.isfinite(rows[0]).any()}
        return [p for p, row in now.items() if not np.array_equal(_six(self.got.later.get(p)), row, equal_nan=True)]


@dataclass(frozen=True)
class Imus:
    """Facts about a `read_all_imus`: its readings in the lab's model and in one with other places."""

    lab: World
    other: World
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @property
    def worlds(self) -> tuple[World, World]:
        return self.lab, self.other


def measure_imus(student: Student, truth: Traces) -> Imus:
    """Read all IMUs of the lab's own robot, also where another one is graded on, and of a model with other places."""
    sheet = truth.scenarios.get("reading_sheet", truth["reading_lab"])
    many = truth["reading_many"]
    facts = Imus(_world(student, truth, sheet, PLACES), _world(student, truth, many, tuple(many.scalars["places"])))
    faults = [world.got.fault for world in facts.worlds]
    stopped: dict[str, Exception] = {}
    for check, which in (("finds_every_place", faults), ("matches_truth", faults), ("readings_are_copies", faults[:1])):
        if fault := next(filter(None, which), None):
            stopped[check] = Raised(fault, "reading all IMUs")
    if not any(world.read for world in facts.worlds):
        stopped.setdefault("matches_truth", Skipped("a reading by place"))
    if not any(np.isfinite(rows[0]).any() for rows in facts.lab.read.values()):
        stopped.setdefault("readings_are_copies", Skipped("a reading by place, with numbers in it"))
    return Imus(facts.lab, facts.other, stopped)


def _world(student: Student, truth: Traces, scenario: Scenario, places: Sequence[str]) -> World:
    qpos, qvel = scenario["qpos"][:_STATES], scenario["qvel"][:_STATES]
    got = questions.imus(student, model=truth.models[scenario.model or ""], qpos=qpos, qvel=qvel)
    addresses = scenario["sensor_adr"][scenario["pairs"]]
    columns = [[first + axis for first in address for axis in range(3)] for address in addresses]
    true = {place: scenario["sensordata"][:_STATES, its] for place, its in zip(places, columns, strict=False)}
    return World(got, true)


def _six(reading: Reading | None) -> Array:
    """Return acceleration and angular velocity (6,), NaN where they are missing."""
    return np.concatenate([three(reading.accel), three(reading.gyro)]) if reading else np.full(6, np.nan)


# ---- a plot that grows ----


@dataclass(frozen=True)
class Live:
    """Facts about a `live_plot`: what was seen while it ran, the time that it was asked for, and the truth.

    Attributes
    ----------
    channels : (m, c) of a robot that was pushed, and of one that was reset and rests
    timestep : between their rows, in s
    """

    run: LiveRun
    duration_s: float
    timestep: float
    channels: Sequence[Array] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)


def measure_live(student: Student, truth: Traces) -> Live:
    """Watch one run of the live plot."""
    watched = truth["watched"]
    duration, timestep = (float(watched.scalars[name]) for name in ("duration_s", "timestep"))
    run = questions.live(
        student,
        model=truth.models["lab"],
        ids=torso_ids(truth),
        duration_s=duration,
        timestep=timestep,
        push=float(watched.scalars["push_mps"]),
    )
    stopped: dict[str, Exception] = {}
    if not len(run.events):
        stopped["shows_true_data"] = Skipped("a curve on a figure that is shown")
    if run.fault:
        stopped = dict.fromkeys(
            ("returns", "grows_while_stepping", "shows_true_data"), Raised(run.fault, "plotting live")
        )
    return Live(run, duration, timestep, (watched["pushed"], watched["still"]), stopped)
