"""Extension: the Allan deviation, which tells kinds of sensor noise apart."""

from __future__ import annotations

import numpy as np

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Skipped, raised
from grader.engine.traces import Traces
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import allan as diagnosis
from grader.labs.imu.student import Student
from grader.labs.imu.student_bonuses import AllanRun, allan

_KINDS = {
    "white": ("white noise", -0.5),
    "walk": ("a random walk", 0.5),
    "quantised": ("quantisation", -1.0),
    "drift": ("a steady drift", 1.0),
}
_SLOPE_ATOL = 0.15
"""Between the slope of a sound estimate and that of the overlapping one on the same record, measured in `tests/test_extensions.py`.
Neighbouring kinds differ by 0.5."""


@check("allan_variance.returns_times_and_deviations")
def check_returns_times_and_deviations(student: Student, truth: Traces) -> None:
    """allan_deviation returns averaging times and as many deviations"""
    run = _run(student, truth, "white")
    raised(run.fault, "computing the Allan deviation")
    if run.taus is None or run.adev is None:
        raise CheckFailed("two arrays of one length, (taus_s, adev)", run.shape, mistakes=["wrong-return-type"])
    odd = (~np.isfinite(run.adev)).sum() + (~np.isfinite(run.taus)).sum()
    if odd:
        raise CheckFailed("finite numbers", f"{odd} with NaN or infinity", mistakes=["not-finite"], keeps=0.5)


@check("allan_variance.averaging_times")
def check_averaging_times(student: Student, truth: Traces) -> None:
    """The averaging times are in seconds, from about a sample to a good part of the record"""
    taus, _ = _curve(_run(student, truth, "white"))
    samples, rate = truth["allan"]["white"], _rate(truth)
    meant = diagnosis.unit_of_times(_records(student, truth), rate)
    if meant and not meant[0]:
        raise CheckFailed(
            "averaging times in seconds", f"times from {taus.min():.3g} to {taus.max():.3g}", mistakes=["tau-wrong"]
        )
    low, high, longest = taus.min() * rate, taus.max() * rate, len(samples) / 2
    if low < 0.5 or high > longest * 1.01 + 1:
        got = f"times from {low:.3g} to {high:.3g} samples, at {rate:g} Hz"
        raise CheckFailed(f"averaging times of 1 to {longest:.0f} samples", got, keeps=0.5)
    if len(np.unique(taus)) < 5 or high < 10 * low:
        got = f"{len(np.unique(taus))} times from {taus.min():.3g} to {taus.max():.3g} s"
        raise CheckFailed("five averaging times or more, over a decade or more", got, keeps=0.5)


@check("allan_variance.matches_definition")
def check_matches_definition(student: Student, truth: Traces) -> None:
    """The deviation is the root of half the mean square difference of neighbouring averages"""
    records, rate = _records(student, truth), _rate(truth)
    if diagnosis.unit_of_times(records, rate):
        return  # whatever the unit of its averaging times: another check charges that
    taus, curve, samples = next(r for r in records if not diagnosis.fits(diagnosis.in_seconds(r[0], rate), *r[1:]))
    size = int(np.clip(diagnosis.in_seconds(taus, rate)[0], 1, len(samples) // 2))
    ratio = curve[0] / diagnosis.overlapping(samples, size)
    roots = [(t, np.sqrt(np.abs(c)), x) for t, c, x in records]
    raise CheckFailed(
        "the Allan deviation at each of its averaging times",
        f"{ratio:.3g} times that at the shortest one, {taus[0]:.3g} s, and another curve at others",
        mistakes=diagnosis.mistakes(records, rate),
        hint="This is the Allan variance. Return its square root, the deviation."
        if diagnosis.unit_of_times(roots, rate)
        else "",
    )


@check("allan_variance.shows_kinds_of_noise")
def check_shows_kinds_of_noise(student: Student, truth: Traces) -> None:
    """Its slope is −1/2 for white noise, +1/2 for a random walk, −1 for quantisation and +1 for drift"""
    wrong = []
    meant = diagnosis.unit_of_times(_records(student, truth), _rate(truth))
    size = meant[1] if meant else diagnosis.in_seconds
    for kind, (words, nominal) in _KINDS.items():
        taus, curve = _curve(_run(student, truth, kind))
        samples = truth["allan"][kind]
        sizes = np.clip(size(taus, _rate(truth)), 1, len(samples) // 2).astype(int)
        clusters = len(samples) / sizes
        wanted = diagnosis.slope(taus, np.array([diagnosis.overlapping(samples, int(m)) for m in sizes]), clusters)
        got = diagnosis.slope(taus, curve, clusters)
        if got is None or wanted is None:
            raise Skipped("three averaging times at which the record has thirty clusters or more")
        if abs(got - wanted) > _SLOPE_ATOL:
            wrong.append((words, nominal, got))
    if wrong:
        words, nominal, got = wrong[0]
        records = _records(student, truth)
        raise CheckFailed(
            f"a slope of {nominal:+.1f} for {words}", f"{got:+.2f}", mistakes=diagnosis.mistakes(records, _rate(truth))
        )


@check("allan_variance.takes_three_axes")
def check_takes_three_axes(student: Student, truth: Traces) -> None:
    """Samples of three axes, (n, 3), give a curve for each axis"""
    samples = truth["allan"]["axes"]
    run = allan(student, samples, _rate(truth))
    raised(run.fault, "computing the Allan deviation of samples (n, 3)")
    if run.taus is None or run.adev is None:
        raise CheckFailed("deviations of shape (k, 3) for samples of shape (n, 3)", run.shape)
    known = run.adev[np.isfinite(run.adev).all(axis=1)]
    alone = [allan(student, samples[:, axis], _rate(truth)) for axis in range(3)]
    for axis, single in enumerate(alone):
        taus, curve = _curve(single)
        same = diagnosis.thinned(np.arange(float(len(known))), known[:, axis])[1]
        if len(taus) != len(same) or not np.allclose(same, curve, rtol=1e-9, atol=0.0):
            raise CheckFailed(
                "the same curve for an axis as when it is the only one", f"another curve for axis {'xyz'[axis]}"
            )


# --- what the checks share -----------------------------------------------------------------------------------------------


def _rate(truth: Traces) -> float:
    return float(truth["allan"].scalars["sample_rate_hz"])


def _run(student: Student, truth: Traces, kind: str) -> AllanRun:
    return allan(student, truth["allan"][kind], _rate(truth))


def _records(student: Student, truth: Traces) -> list[diagnosis.Record]:
    kinds = ("white", "walk", "quantised", "mixed")
    return [(*_curve(_run(student, truth, kind)), truth["allan"][kind]) for kind in kinds]


def _curve(run: AllanRun) -> tuple[Array, Array]:
    """Averaging times and deviations (k,), finite ones alone, by increasing time."""
    raised(run.fault, "computing the Allan deviation")
    if run.taus is None or run.adev is None:
        raise Skipped("averaging times and deviations")
    known = np.isfinite(run.taus) & np.isfinite(run.adev[:, 0])
    if known.sum() < 3:
        raise Skipped("three averaging times or more")
    order = np.argsort(run.taus[known], kind="stable")
    return diagnosis.thinned(run.taus[known][order], run.adev[known, 0][order])
