"""The extension *Allan variance*: asks `allan_deviation` for curves of five records, and finds out which estimate they show.

References
----------
Riley, W. J. (2008). Handbook of Frequency Stability Analysis. NIST Special Publication 1065, equations (7) and (11).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from grader.engine.charging import Judge
from grader.engine.findings import Raised, Skipped, StudentError
from grader.engine.hypothesis import Reason
from grader.engine.question import Question
from grader.engine.traces import Traces
from grader.labs.imu.compare import Array, thinned
from grader.labs.imu.lab import LAB
from grader.labs.imu.returned import Arrays, Node, numbers, shape_in_words
from grader.labs.imu.statistics import allan_deviation
from grader.labs.imu.student import Student
from grader.sandbox.wire import Frame

KINDS = ("white", "walk", "quantised", "drift")
"""Kinds of noise whose slopes are compared."""
_RECORDS = ("white", "walk", "quantised", "mixed")
"""Records whose curves are compared; a drift has no chance in it."""
_SCATTER = 5.0
"""Standard errors that a sound estimate may differ by at one averaging time: 5 / √(number of clusters)."""
_MEAN_LOG = 0.1
"""Largest mean of log(estimate / truth), weighted by clusters. Sound estimates differ by 0.02;
without the factor one half it is 0.35."""
_EXACT = 1e-6
"""Relative error of a curve that is the overlapping estimate itself. Double precision keeps 1e-9 of a record of 4,000 samples."""
_CLUSTERS = 30
"""Fewest clusters of an averaging time that is compared. With fewer, two sound estimates may be far apart."""
_FEWEST = 3  # averaging times that tell a curve

# ---- the question


@dataclass(frozen=True)
class AllanRun:
    """Answer of a student's `allan_deviation`: times (k,) in s, deviations (k, c) for c columns of samples; None if unreturned."""

    taus: Array | None
    adev: Array | None
    shape: str
    error: StudentError | None

    @cached_property
    def curve(self) -> tuple[Array, Array] | None:
        """Finite times and deviations (k,) of the first column, by time, evenly thinned to 200 at most; None if unreturned."""
        if self.taus is None or self.adev is None:
            return None
        known = np.flatnonzero(np.isfinite(self.taus) & np.isfinite(self.adev[:, 0]))
        chosen = known[np.argsort(self.taus[known], kind="stable")]
        chosen = chosen[thinned(len(chosen))]
        return self.taus[chosen], self.adev[chosen, 0]

    @property
    def stop(self) -> Exception | None:
        """The exception that ends the checks of this curve if the code raised or gave under three averaging times; else None."""
        if self.error:
            return Raised(self.error, "computing the Allan deviation")
        if self.curve is None:
            return Skipped("averaging times and deviations")
        return None if len(self.curve[0]) >= _FEWEST else Skipped("three averaging times or more")


def allan(student: Student, samples: Array, sample_rate_hz: float) -> AllanRun:
    """Ask the student's `allan_deviation` about samples (n,) or, of three axes, (n, 3), and return its answer."""
    becomes = partial(_run, columns=1 if samples.ndim == 1 else samples.shape[1])
    fields = {"sample_rate_hz": sample_rate_hz}
    return student.answer(Question("allan", "allan_deviation", becomes, fields, {"samples": samples}))


def _run(frame: Frame, columns: int) -> AllanRun:
    node = frame.fields["value"]
    taus, adev = _curve(node, frame.arrays, columns)
    return AllanRun(taus, adev, shape_in_words(node, frame.arrays), StudentError.of(frame.fields.get("error")))


def _curve(node: Node | None, arrays: Arrays, columns: int) -> tuple[Array | None, Array | None]:
    taus, adev = _returned_pair(node, arrays)
    if taus is None or adev is None or adev.size != taus.size * columns:
        return None, None
    upright = adev if adev.shape[:1] == (taus.size,) else adev.T
    return taus.ravel(), upright.reshape(taus.size, columns)


def _returned_pair(node: Node | None, arrays: Arrays) -> tuple[Array | None, Array | None]:
    """Return averaging times and deviations as returned: two parts of a pair, or rows of an array; None, None for another form."""
    if node is None or node["kind"] in ("dict", "object"):
        return None, None
    if "key" in node:
        whole = arrays[node["key"]]
        return (whole[0], whole[1]) if whole.ndim == 2 and len(whole) == 2 else (None, None)
    items = node.get("items", ())
    return (numbers(items[0], arrays), numbers(items[1], arrays)) if len(items) >= 2 else (None, None)


# ---- what a curve may be

Estimate = Callable[[Array, int], float]
Sized = Callable[[Array, float], Array]
Record = tuple[Array, Array, Array]
"""Averaging times (k,), curve (k,) and samples (n,)."""


def _clusters(samples: Array, m: int) -> Array:
    """Return the averages of successive clusters of m samples, without samples at the end that fill no cluster."""
    count = len(samples) // m
    return np.asarray(samples[: count * m].reshape(count, m).mean(axis=1))


_CURVES: Mapping[str, Estimate] = {
    "": allan_deviation,
    "returns-variance": lambda samples, m: allan_deviation(samples, m) ** 2,
    "allan-factor-missing": lambda samples, m: 2**0.5 * allan_deviation(samples, m),
    "std-not-allan": lambda samples, m: float(np.std(_clusters(samples, m))),
}
"""Estimates that a curve may show, by the id of the fault; "" is the Allan deviation. The first that fits counts."""


def in_seconds(taus: Array, rate: float) -> Array:
    """Return the cluster sizes, in samples, of averaging times that are given in seconds, at a sampling `rate` in Hz."""
    return np.round(taus * rate)


_SIZES: tuple[tuple[bool, Sized], ...] = (
    (True, in_seconds),
    (True, lambda taus, rate: np.floor(taus * rate + 1e-9)),
    (True, lambda taus, rate: np.ceil(taus * rate - 1e-9)),
    (False, lambda taus, rate: np.round(taus)),
    (False, lambda taus, rate: np.round(taus / rate)),
    (False, lambda taus, rate: np.round(taus * rate**2)),
)
"""Cluster sizes of averaging times, in seconds or wrongly in something else."""


@dataclass(frozen=True)
class Meaning:
    """Explanation of a student's curves: `fault` is the id of the fault that gives them, "" for Allan deviations, None if unknown.

    `seconds` is whether the averaging times are in seconds; `size` converts them to cluster sizes in samples.
    """

    fault: str | None
    seconds: bool = True
    size: Sized = in_seconds


def fits(sizes: Array, curve: Array, samples: Array, estimate: Estimate = allan_deviation) -> bool:
    """Return whether a curve (k,) is `estimate` of `samples` at cluster sizes (k,), or as close as one without overlap comes."""
    usable = (sizes >= 1) & (sizes <= len(samples) // 2)
    wanted = np.array([estimate(samples, int(m)) for m in sizes[usable]])
    if len(wanted) >= _FEWEST and np.allclose(curve[usable], wanted, rtol=_EXACT, atol=0.0):
        return True
    clusters = len(samples) / sizes[usable]
    many = clusters >= _CLUSTERS
    if many.sum() < _FEWEST or not curve[usable][many].min() > 0:
        return False
    clusters, gap = clusters[many], np.log(curve[usable][many] / wanted[many])
    mean = float(np.average(gap, weights=clusters))
    return abs(mean) <= _MEAN_LOG and bool(np.all(np.abs(gap) <= _SCATTER / np.sqrt(clusters)))


def meaning(records: Sequence[Record], rate: float) -> Meaning:
    """Return the fault and the unit of time that explain the curves of all records; `fault` is None if nothing explains them.

    White noise alone is not enough: a missing factor one half looks like averaging times that are twice too long.
    """
    for fault, estimate in _CURVES.items():
        for seconds, size in _SIZES:
            if all(fits(size(taus, rate), curve, samples, estimate) for taus, curve, samples in records):
                return Meaning(fault, seconds, size)
    return Meaning(None)


def slopes(record: Record, size: Sized, rate: float) -> tuple[float, float]:
    """Return the log-log slopes of a record's true Allan deviation and of the student's curve for the record.

    `size` turns averaging times and the sampling `rate` (Hz) into cluster sizes in samples. Only times with 30 clusters or more
    count; NaN with fewer than three such times.
    """
    taus, curve, samples = record
    sizes = np.clip(size(taus, rate), 1, len(samples) // 2).astype(int)
    wanted = np.array([allan_deviation(samples, int(m)) for m in sizes])
    some = sizes <= len(samples) / _CLUSTERS
    return _slope(taus[some], wanted[some]), _slope(taus[some], curve[some])


def _slope(taus: Array, curve: Array) -> float:
    """Return the slope of a curve (k,) on double logarithmic axes; NaN with fewer than three positive times."""
    known = (taus > 0) & (curve > 0)
    if len(np.unique(taus[known])) < _FEWEST:
        return np.nan
    return float(np.polyfit(np.log(taus[known]), np.log(curve[known]), 1)[0])


# ---- the facts, and the faults


@dataclass(frozen=True)
class Allan:
    """All that is measured of an `allan_deviation`: `measure` makes it, and checks and diagnosis read nothing else.

    Attributes
    ----------
    rate : sampling rate in Hz
    white, together : the answer for white noise, and for three axes at once
    alone : the answers for each of these axes by itself
    records : by kind of noise, averaging times (k,), deviations (k,) and the samples (n,); empty if one of them has no curve
    stopped : by check, the exception that is raised in its place because its property could not be measured
    """

    rate: float
    white: AllanRun
    together: AllanRun
    alone: Sequence[AllanRun] = ()
    records: Mapping[str, Record] = field(default_factory=dict)
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    @cached_property
    def odd(self) -> int | None:
        """Number of averaging times and deviations for white noise that are not finite; None unless both were returned."""
        taus, adev = self.white.taus, self.white.adev
        return None if taus is None or adev is None else int((~np.isfinite(taus)).sum() + (~np.isfinite(adev)).sum())

    @cached_property
    def meaning(self) -> Meaning:
        return meaning([self.records[kind] for kind in _RECORDS], self.rate)

    @property
    def is_deviation(self) -> bool:
        """Return whether the curves are Allan deviations and not, say, variances; their averaging times may have a wrong unit."""
        return self.meaning.fault == ""

    @property
    def worst(self) -> Record:
        """First record of white, walk, quantised, mixed whose curve is no Allan deviation over seconds; StopIteration if none."""
        records = (self.records[kind] for kind in _RECORDS)
        return next(each for each in records if not fits(in_seconds(each[0], self.rate), *each[1:]))


def measure(student: Student, truth: Traces) -> Allan:
    """Ask for curves of `truth`'s five noise records, of its (n, 3) record, and of each column of that alone; return the facts."""
    scenario = truth["allan"]
    rate = float(scenario.scalars["sample_rate_hz"])
    runs = {kind: allan(student, scenario[kind], rate) for kind in dict.fromkeys((*_RECORDS, *KINDS))}
    together = allan(student, scenario["axes"], rate)
    alone = [allan(student, scenario["axes"][:, axis], rate) for axis in range(3)]
    stop = next(filter(None, (run.stop for run in runs.values())), None)
    compared = ("averaging_times", "matches_definition", "shows_kinds_of_noise")
    stops: dict[str, Exception | None] = dict.fromkeys(compared, stop)
    stops["returns_times_and_deviations"] = runs["white"].stop if runs["white"].error else None
    one = None if together.adev is None else next(filter(None, (run.stop for run in alone)), None)
    stops["takes_three_axes"] = together.stop if together.error else one
    records = {} if stop else {kind: (*run.curve, scenario[kind]) for kind, run in runs.items() if run.curve}
    stopped = {check: stop for check, stop in stops.items() if stop}
    return Allan(rate, runs["white"], together, alone, records, stopped)


_REASONS: tuple[Reason[Allan], ...] = (
    Reason("returns_times_and_deviations", 1, "wrong-return-type", lambda facts: facts.odd is None),
    Reason("returns_times_and_deviations", 2, "not-finite", lambda _: True),
    Reason("averaging_times", 1, "tau-wrong", lambda facts: facts.is_deviation and not facts.meaning.seconds),
    *(
        Reason(check, 1, fault, lambda facts, its=fault: facts.meaning.fault == its)  # type: ignore[misc]
        for check in ("matches_definition", "shows_kinds_of_noise")
        for fault in filter(None, _CURVES)
    ),
)
ALLAN: Judge[Allan] = Judge(LAB, "allan_variance", measure, _REASONS)
