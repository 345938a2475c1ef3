"""Extension: accelerometer and gyroscope combined to roll and pitch, held against the true orientation of the sensor."""

from __future__ import annotations

import numpy as np

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Size, Skipped, raised
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.compare import Array, vector
from grader.labs.imu.diagnosis import tilting
from grader.labs.imu.student import Student
from grader.labs.imu.student_bonuses import TiltCase, TiltRun, tilt

_LEVEL_ATOL = 0.01
"""rad. A filter that starts at zero or at the accelerometer's tilt is level from the first sample on, to rounding."""
_SETTLED_ATOL = 0.03
"""rad, after 30 s. The sheet's alpha 0.98 forgets a wrong start in 1 s, a slow Mahony filter (gain 0.5) in 2 s."""
_BETTER_THAN_GYRO, _BETTER_THAN_ACCEL = 3.0, 1.4
"""How many times smaller the error must be: exp(mean - 6.7 deviations) of log(factor) over hidden motions, for the weakest
setting that is still sound. Six deviations are 1e-9; the rest allows for a deviation that 20 motions tell to 12 %. Weakest are,
with mean factor and deviation of its logarithm: alpha 0.995 where the gyroscope drifts, 7.8 and 0.034 (limit 6.2); alpha 0.9 where
the accelerometer is shaken, 2.56 and 0.089 (limit 1.41); Madgwick's filter with 0.04 where it is steep, 2.88 and 0.107 (limit
1.41). Alpha 0.98, Mahony with gains 0.5 to 2 and Madgwick with 0.1 lie higher in all. Weights the wrong way round give 1.00, a
time step twice too long 0.7 where it is steep."""


@check("complementary_filter.returns_roll_and_pitch")
def check_returns_roll_and_pitch(student: Student, truth: Traces) -> None:
    """update() returns roll and pitch, both 0 where the sensor is level and at rest"""
    run = _at_rest(student, truth)[0]
    raised(run.fault, "updating the filter")
    if not np.isfinite(run.output).all():
        shape = run.odd if run.odd and not run.odd.startswith(_PAIRS) else ""
        mistake = "wrong-return-type" if shape else "not-finite"
        raise CheckFailed("two numbers from update(), roll and pitch", shape or "NaN or infinity", mistakes=[mistake])
    worst = np.abs(tilting.wrapped(run.output)).max()
    if worst > _LEVEL_ATOL:
        got = f"{vector(run.output[-1])} rad"
        raise CheckFailed("roll and pitch 0 rad at rest and level", got, mistakes=_mistakes(student), off=_rad(worst))


_PAIRS = ("a tuple of 2 (a number, a number)", "a list of 2 (a number, a number)", "an array of shape (2,)")


@check("complementary_filter.settles_at_tilt")
def check_settles_at_tilt(student: Student, truth: Traces) -> None:
    """Held still at a tilt, the filter settles at the true roll and pitch, wherever it started"""
    runs = _at_rest(student, truth)[1:]
    tilts = truth["tilt_start"]["tilt"]
    errors = [np.abs(tilting.wrapped(_output(run)[-1] - wanted)).max() for run, wanted in zip(runs, tilts, strict=True)]
    worst = int(np.argmax(errors))
    if errors[worst] > _SETTLED_ATOL:
        raise CheckFailed(
            f"roll and pitch {vector(tilts[worst])} rad after 30 s at rest",
            f"{vector(_output(runs[worst])[-1])} rad",
            mistakes=_mistakes(student),
            keeps=0.5 if errors[0] <= _SETTLED_ATOL else 0.0,
            off=_rad(errors[worst]),
        )


@check("complementary_filter.beats_gyroscope_alone")
def check_beats_gyroscope_alone(student: Student, truth: Traces) -> None:
    """Where the gyroscope has a bias, the filter does not drift away with it"""
    _beats(student, truth, "tilt_drifting", "gyro_alone_rms", _BETTER_THAN_GYRO)


@check("complementary_filter.beats_accelerometer_alone")
def check_beats_accelerometer_alone(student: Student, truth: Traces) -> None:
    """Where the sensor is shaken, the filter does not take the shaking for a tilt"""
    turned = [run.output for run in tilt(student, [TiltCase(tilting.DT, *s) for s in tilting.probes()[:2]])]
    if tilting.ignores_gyroscope(turned):
        raise CheckFailed(
            "angles that follow a turn at once", "angles that do not depend on the gyroscope", mistakes=["accel-only"]
        )
    _beats(student, truth, "tilt_shaken", "accel_alone_rms", _BETTER_THAN_ACCEL)


@check("complementary_filter.holds_when_steep")
def check_holds_when_steep(student: Student, truth: Traces) -> None:
    """The filter beats both sensors alone in large and fast pitching, at another time step"""
    _beats(student, truth, "tilt_steep", "accel_alone_rms", _BETTER_THAN_ACCEL)
    _beats(student, truth, "tilt_steep", "gyro_alone_rms", _BETTER_THAN_ACCEL)


_SINGLE = {"gyro_alone_rms": "the gyroscope alone", "accel_alone_rms": "the accelerometer alone"}


def _beats(student: Student, truth: Traces, name: str, single: str, factor: float) -> None:
    ride = truth[name]
    case = TiltCase(float(ride.scalars["dt"]), ride["acceleration"], ride["angular_velocity"])
    (run,) = tilt(student, [case])  # each ride by itself: a slow filter has its time for each
    error = _rms(_output(run), ride)
    alone = float(truth[name].scalars[single])
    if not error * factor <= alone:
        raise CheckFailed(
            f"an error of at most {alone / factor:.3f} rad RMS, {factor:g} times smaller than that of {_SINGLE[single]}",
            f"{error:.3f} rad",
            mistakes=_mistakes(student),
            keeps=0.5 if error * np.sqrt(factor) <= alone else 0.0,
        )


def _rms(output: Array, scenario: Scenario) -> float:
    """Error over the second half, when every start is forgotten."""
    half = len(output) // 2
    return float(np.sqrt(np.mean(tilting.wrapped(output[half:] - scenario["tilt"][half:]) ** 2)))


# --- what the checks share -----------------------------------------------------------------------------------------------


def _at_rest(student: Student, truth: Traces) -> list[TiltRun]:
    """Level, then still at two tilts, with a shove that spoils the first readings."""
    start, dt = truth["tilt_start"], float(truth["tilt_start"].scalars["dt"])
    tilted = [tilting.at_rest(wanted, 1500) for wanted in start["tilt"]]
    for forces, shove in zip(tilted, start["shove"], strict=True):
        forces[:5] += shove
    still = [tilting.at_rest(np.zeros(2), 100), *tilted]
    return tilt(student, [TiltCase(dt, forces, np.zeros_like(forces)) for forces in still])


def _output(run: TiltRun) -> Array:
    raised(run.fault, "updating the filter")
    if not np.isfinite(run.output).all():
        raise Skipped("two finite numbers from every update()")
    return run.output


def _mistakes(student: Student) -> list[str]:
    """Name the fault from the filter's response to single changes; asked only where points are lost."""
    cases = [TiltCase(tilting.DT, *signals) for signals in tilting.probes()]
    seen = tilting.response([run.output for run in tilt(student, cases)])
    return tilting.mistakes(seen) if seen else []


def _rad(error: float) -> Size:
    return Size("an angle is off", float(error), "rad")
