"""Measurement of a `LowPassFilter`: test signals run through it, and properties of what comes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grader.engine.findings import Raised, Skipped, StudentError, Unusable
from grader.engine.traces import Scenario, Traces
from grader.labs.imu.answers import FilterRun
from grader.labs.imu.compare import Array, not_finite_in_words, same
from grader.labs.imu.returned import if_nothing
from grader.labs.imu.student import FilterCase, Student

ATOL = 1e-5
"""m/s². Single precision errs by 1e-6 at 10 m/s² in each of a few operations; the smallest fault shifts by 1e-3."""
FORM = "an array of three numbers from update()"
DEFAULT_ALPHA = 0.1
_ALPHA, _ALPHA_ALONE = 0.2, 0.3
_SLOW_PERIOD = 200
"""Samples; the sheet's filter with alpha 0.2 lags by 4 of them."""
_PAST, _SHIFT = 40, 3.0
"""Samples whose values another past changes, and by how much, in m/s². The sheet's filter then differs by 2.1."""
_BY_CHANCE = 10.0
"""Times what the same past differs by: another past that changes no more than that is no memory."""
_SETTLED = 1e-6
"""Share of the largest difference that may be left after 60 samples. At alpha 0.3 the sheet's filter forgets all but 7e-10."""
_AWAY = 1e4
"""m/s². No measurement of the lab's comes near; beyond it a sum loses the digits that are compared."""
_FEWEST = 6
"""Outputs that tell two coefficients, with more equations than unknowns."""


@dataclass(frozen=True)
class Run:
    """A signal run through a student's filter from `initial` (None: not given): outputs y (n, 3) for inputs x, NaN if missing."""

    alpha: float
    x: Array
    y: Array
    initial: Array | None = None

    def made_of(self, now: float, last: float, before: float) -> Array:
        """Return ``now x[k] + last x[k-1] + before y[k-1]`` for k = 1 … n - 1, shape (n - 1, 3), to compare with ``y[k]``."""
        return np.asarray(now * self.x[1:] + last * self.x[:-1] + before * self.y[:-1])

    @cached_property
    def wanted(self) -> Array:
        """Right outputs (n - 1, 3), from the second on: the lab sheet's recursion from the filter's own output before each."""
        return self.made_of(self.alpha, 0.0, 1 - self.alpha)

    @cached_property
    def off(self) -> Array:
        """Error (n - 1,) of each output from the second on against the right one, in m/s²: the largest of the three axes."""
        return np.asarray(np.abs(self.y[1:] - self.wanted).max(axis=1))

    @property
    def obeys(self) -> bool:
        """Return whether every output follows from the one before as in the lab sheet; False if one is infinite or NaN."""
        return bool(np.all(self.off <= ATOL))

    @cached_property
    def weights(self) -> tuple[float, float] | None:
        """Weights (a, b) with which all outputs obey ``y[n] = a x[n] + b y[n-1]``; None if no weights do.

        If an output exceeds 1e4 m/s², as of a filter that diverges, only those before it count; fewer than six give None.
        """
        away = np.abs(self.y).max(axis=1) > _AWAY
        end = int(away.argmax()) if away.any() else len(self.y)
        x, y = self.x[:end], self.y[:end]
        if len(y) < _FEWEST:
            return None
        columns = np.stack([x[1:].ravel(), y[:-1].ravel()], axis=1)
        (a, b), *_ = np.linalg.lstsq(columns, y[1:].ravel(), rcond=None)
        return (float(a), float(b)) if same(y[1:], a * x[1:] + b * y[:-1], ATOL) else None

    @property
    def first_wanted(self) -> Array:
        """First output (3,) of the lab sheet's filter after the initial value; without such a value, the first measurement."""
        before = self.x[0] if self.initial is None else self.initial
        return np.asarray(self.alpha * self.x[0] + (1 - self.alpha) * before)

    @property
    def starts(self) -> bool:
        return same(self.y[0], self.first_wanted, ATOL)


@dataclass(frozen=True)
class Ownership:
    """Outputs (60, 3) of six filters with alpha 0.3 (`alone` to `another_past`), which show who can change the state of a filter.

    Attributes
    ----------
    alone, again : the same measurements twice, while no other code ran
    beside : the same, while a second filter ran on other data
    spoilt_input, spoilt_output : the same, but the caller overwrote each array that went in, or that came out
    another_past : measurements 2 to 40 are larger by 3 m/s²; the first one and the others are the same
    stumbles : the exception that a filter raises only if another filter existed before it; None if it raises none
    input_changed, output_changed : whether a filter wrote into an array that it was given, or later into one that it had returned
    """

    alone: Array
    again: Array
    beside: Array
    spoilt_input: Array
    spoilt_output: Array
    another_past: Array
    stumbles: StudentError | None = None
    input_changed: bool = False
    output_changed: bool = False

    @property
    def remembers(self) -> bool:
        """Return whether the filter has memory: another past changes outputs far more than a rerun; True if one is inf or NaN."""
        if not np.isfinite([self.alone, self.again, self.another_past]).all():
            return True  # nobody knows
        chance = np.abs(self.again - self.alone)[_PAST:].max()
        return bool(np.abs(self.another_past - self.alone)[_PAST:].max() > ATOL + _BY_CHANCE * chance)

    @property
    def shared(self) -> bool:
        return self.stumbles is not None or not same(self.beside, self.alone, ATOL)

    def settles(self, other: Array) -> bool:
        """Return whether the difference of outputs `other` (60, 3) from those of the filter `alone` has decayed in the last row.

        A difference decays if it comes from the state that another filter left at the start.
        """
        difference = np.abs(other - self.alone)
        return bool(difference[-1].max() <= ATOL + _SETTLED * difference.max())


@dataclass(frozen=True)
class Facts:
    """All that is measured of one filter: `measure` makes it, and checks and diagnosis read nothing else.

    Attributes
    ----------
    runs : runs of a noisy signal: one with each alpha of the scenario; then, if the filter needs no alpha, one with its default
    from_initial : runs of the same signal with an initial value given, and with zeros given as the initial value
    noise, slow, constant : runs of noise, of slow waves and of a constant (alpha 0.2)
    own : outputs that show whether other code can change the filter's state
    odd : in words, what `update` returned in place of a vector; "" if it always returned one
    nothing_at_first : whether `update` returned no vector for the first measurement alone
    needs_alpha : the exception that the filter raises if no alpha is given; None if it raises none
    departs : the sheet's names of parameters that the class has by other names or in other places; "method …" for a renamed method,
        "global …" for a parameter in place of which it reads a global variable; each of these three loses points
    stopped : by name of a check, the exception with which it ends because its property could not be measured
    """

    runs: tuple[Run, ...]
    from_initial: tuple[Run, ...]
    noise: Run
    slow: Run
    constant: Run
    own: Ownership
    odd: str = ""
    nothing_at_first: bool = False
    needs_alpha: StudentError | None = None
    departs: tuple[str, ...] = ()
    stopped: Mapping[str, Exception] = field(default_factory=dict)

    def second_half(self, run: Run) -> tuple[Array, Array]:
        """Return measurements and outputs of the second half of a run, where its start has no effect."""
        half = len(run.x) // 2
        return run.x[half:], run.y[half:]

    @property
    def noise_gain(self) -> float:
        """Variance of the filtered noise over that of the noise, in the second half of the run; 1 if nothing is filtered."""
        x, y = self.second_half(self.noise)
        return float(np.var(y, axis=0).mean() / np.var(x, axis=0).mean())

    @property
    def signal_error(self) -> float:
        """RMS error of filtered slow waves relative to their standard deviation, in the second half; 1 if the waves are lost."""
        x, y = self.second_half(self.slow)
        return float(np.sqrt(np.mean((y - x) ** 2)) / np.sqrt(np.mean(np.var(x, axis=0))))

    @cached_property
    def off(self) -> list[NDArray[np.bool_]]:
        """For each of `runs`, a mask (n - 1,): outputs from the second on that miss the sheet's recursion by over 1e-5 m/s²."""
        return [run.off > ATOL for run in self.runs]

    @property
    def weights(self) -> list[tuple[float, float]]:
        """Weights (a, b) of ``y[n] = a x[n] + b y[n-1]`` for each of `runs`, in order; empty if `Run.weights` is None for one."""
        found = [run.weights for run in self.runs if run.weights is not None]
        return found if len(found) == len(self.runs) else []


def measure(student: Student, truth: Traces) -> Facts:
    """Run the student's filter on the cases that `asked` makes, each with a new filter, and return what each run showed.

    If the second raises and the first did not, its first use may spoil the code: all but the first run again, in new processes.
    """
    cases = asked(truth["filter"])
    runs = student.filter(list(cases.values()), called="filter")
    if runs[0].error or not runs[1].error:
        return facts(cases, runs)
    return facts(cases, [runs[0], *map(student.filter_alone, [*cases.values()][1:])], stumbles=runs[1].error)


def asked(scenario: Scenario) -> dict[str, FilterCase]:
    """Return the cases (signal and arguments) to run the filter on, by name, such as "noise", or "alpha 0.1" for each alpha."""
    signal, initial = scenario["input"], scenario["initial"]
    alphas = [float(alpha) for alpha in scenario["alpha"]]
    short = signal[:60]
    past = short + _SHIFT * (np.arange(60) % _PAST > 0)[:, None] * (np.arange(60) < _PAST)[:, None]
    phase = 2 * np.pi * np.arange(400)[:, None] / _SLOW_PERIOD + np.array([0.0, 1.0, 2.0])
    return {
        **{f"alpha {alpha:g}": FilterCase(signal, alpha) for alpha in alphas},
        "no alpha": FilterCase(signal[:100]),
        "noise": FilterCase(scenario["acceleration"] - scenario["acceleration_clean"] + signal[0], _ALPHA),
        "slow": FilterCase(np.sin(phase) * np.array([1.0, 2.0, 0.5]) + signal[0], _ALPHA),
        "constant": FilterCase(np.tile(signal[0], (300, 1)), _ALPHA),
        "initial": FilterCase(short, alphas[1], initial),
        "zeros": FilterCase(short, alphas[1], np.zeros(3)),
        "alone": FilterCase(short, _ALPHA_ALONE),
        "beside": FilterCase(short, _ALPHA_ALONE, handling="beside"),
        "spoilt_input": FilterCase(short, _ALPHA_ALONE, handling="spoil_input"),
        "spoilt_output": FilterCase(short, _ALPHA_ALONE, handling="spoil_output"),
        "again": FilterCase(short, _ALPHA_ALONE),
        "another_past": FilterCase(past, _ALPHA_ALONE),
    }


def facts(cases: Mapping[str, FilterCase], answers: Sequence[FilterRun], stumbles: StudentError | None = None) -> Facts:
    """Return the facts of a filter from its answers to `cases`, in order; `stumbles`: what a second instance raises, or None."""
    pairs = {n: _from_first_vector(c, run) for (n, c), run in zip(cases.items(), answers, strict=True)}
    said = {name: run for name, (_, run) in pairs.items()}
    runs = {name: Run(c.alpha or DEFAULT_ALPHA, c.signal, _rows(c, run), c.initial) for name, (c, run) in pairs.items()}
    plain = [name for name in runs if "alpha" in name]
    needs_alpha = None if any(said[name].error for name in plain[:-1]) else said[plain[-1]].error
    plain = plain[:-1] if needs_alpha else plain
    own = ("alone", "again", "beside", "spoilt_input", "spoilt_output", "another_past")
    unwatched = ("spoilt_input", "spoilt_output")
    return Facts(
        runs=tuple(runs[name] for name in plain),
        from_initial=(runs["initial"], runs["zeros"]),
        **{name: runs[name] for name in ("noise", "slow", "constant")},
        own=Ownership(
            **{name: runs[name].y for name in own},
            stumbles=stumbles,
            input_changed=any(run.input_changed for name, run in said.items() if name not in unwatched),
            output_changed=any(run.output_changed for name, run in said.items() if name not in unwatched),
        ),
        odd=next((odd for name in plain if (odd := said[name].odd)), ""),
        nothing_at_first=len(runs[plain[0]].x) < len(cases[plain[0]].signal),
        needs_alpha=needs_alpha,
        departs=next((departs for name in plain if (departs := said[name].departs)), ()),
        stopped=_stopped(said, plain, own[:1] if stumbles else own) | _skip_if_constant(runs["alone"]),
    )


def _from_first_vector(case: FilterCase, run: FilterRun) -> tuple[FilterCase, FilterRun]:
    """Return a case and its run without the first sample if update() returned nothing for it alone: one fault, judged as such."""
    missing = [] if run.output is None else np.flatnonzero(~np.isfinite(run.output).all(axis=1)).tolist()
    if run.error or missing != [0] or not run.odd:
        return case, run
    assert run.output is not None
    return replace(case, signal=case.signal[1:]), replace(run, output=run.output[1:])


def _rows(case: FilterCase, run: FilterRun) -> Array:
    """Return an output for each measurement of a case, NaN where the run has none."""
    rows = np.full(case.signal.shape, np.nan)
    if run.output is not None:
        rows[: len(run.output)] = run.output[: len(rows)]
    return rows


def _stopped(said: Mapping[str, FilterRun], plain: Sequence[str], own: Sequence[str]) -> dict[str, Exception]:
    """Return by check why its property could not be measured; infinity or NaN for one signal stops that signal's check alone."""
    whole = next((stop for name in plain if (stop := _stop(said[name]))), None)
    found = {
        "follows_recursion": whole,
        "starts_from_first_measurement": whole or _stop(said["initial"]) or _stop(said["zeros"]),
        "passes_constant": whole or _stop(said["constant"], may_end=True),
        "reduces_noise": whole or _stop(said["noise"]),
        "preserves_signal": whole or _stop(said["slow"], may_end=True),
        "instances_independent": next((stop for name in own if (stop := _stop(said[name]))), None),
    }
    return {name: stop for name, stop in found.items() if stop is not None}


def _skip_if_constant(run: Run) -> dict[str, Exception]:
    """Skip the check of the filter's state if the output is one number that was never measured; else return nothing."""
    same_numbers = np.isfinite(run.y).all() and not np.ptp(run.y, axis=0).any() and not run.starts
    return {"instances_independent": Skipped("an output that depends on the measurements")} if same_numbers else {}


def _stop(run: FilterRun, *, may_end: bool = False) -> Exception | None:
    if run.error:
        return Raised(run.error, "filtering measurements")
    if run.output is None:
        return Skipped("an output")
    if np.isfinite(run.output).all() or (may_end and not run.odd):
        return None
    fault = "wrong-return-type" if run.odd else "not-finite"
    return Unusable(FORM, run.odd or not_finite_in_words(run.output), faults=[fault], hint=if_nothing(run.odd or ""))
