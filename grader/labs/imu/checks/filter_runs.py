"""What the checks of the filter ask a `LowPassFilter`: each signal once, and what came out of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grader.engine.conversation import found_once
from grader.engine.findings import Fault, Lost, Skipped, Unusable, raised
from grader.engine.traces import Traces
from grader.labs.imu.answers import FilterRun
from grader.labs.imu.compare import Array
from grader.labs.imu.student import FilterCase, Student

RECURSION = "filtering.follows_recursion"
"""It charges what other checks see as well: a filter that obeys the recursion passes constants, noise and signals as it does."""
FORM = "an array of three numbers from update()"
_DEFAULT_ALPHA = 0.1
_ALPHA = 0.2
SLOW_PERIOD = 200  # samples; the sheet's filter with alpha 0.2 lags by 4 of them


@dataclass(frozen=True)
class Cases:
    """Each case as its signal and the run, or the run alone.

    Attributes
    ----------
    needs_alpha : what it raises where alpha alone is not given
    stumbles : what it raises where another filter was before; each case is of a process of its own then
    """

    plain: list[tuple[float, Array, FilterRun]]
    noise: tuple[Array, FilterRun]
    slow: tuple[Array, FilterRun]
    constant: tuple[Array, FilterRun]
    from_initial: tuple[Array, FilterRun]
    initial: Array
    initial_alpha: float
    alone: FilterRun
    beside: FilterRun
    spoilt_input: FilterRun
    spoilt_output: FilterRun
    again: FilterRun
    nothing_at_first: bool
    needs_alpha: Fault | None
    stumbles: Fault | None

    @property
    def every(self) -> list[FilterRun]:
        pairs = (self.noise, self.slow, self.constant, self.from_initial)
        return [run for *_, run in self.plain] + [run for _, run in pairs] + [self.alone, self.beside]


@found_once
def asked(student: Student, truth: Traces) -> Cases:
    """All cases in one question, each with a filter of its own."""
    scenario = truth["filter"]
    signal, alphas, initial = scenario["input"], [float(a) for a in scenario["alpha"]], scenario["initial"]
    short = signal[:60]
    noise = scenario["acceleration"] - scenario["acceleration_clean"] + signal[0]
    phase = 2 * np.pi * np.arange(400)[:, None] / SLOW_PERIOD + np.array([0.0, 1.0, 2.0])
    slow = np.sin(phase) * np.array([1.0, 2.0, 0.5]) + signal[0]
    constant = np.tile(signal[0], (300, 1))
    cases = [
        *(FilterCase(signal, alpha) for alpha in alphas),
        FilterCase(signal[:100]),
        FilterCase(noise, _ALPHA),
        FilterCase(slow, _ALPHA),
        FilterCase(constant, _ALPHA),
        FilterCase(short, alphas[1], initial),
        *(
            FilterCase(short, 0.3, None, handling)
            for handling in ("plain", "beside", "spoil_input", "spoil_output", "plain")
        ),
    ]
    first, second, *others = student.filter(cases, called="filter")
    stumbles = None if first.fault else second.fault
    runs = [first, *map(student.filter_alone, cases[1:])] if stumbles else [first, second, *others]
    series = [_from_first_vector(case.signal, run) for case, run in zip(cases, runs, strict=True)]
    with_alpha = [(alpha, *pair) for alpha, pair in zip((*alphas, _DEFAULT_ALPHA), series, strict=False)]
    of_noise, of_slow, of_constant, from_initial, alone, beside, spoilt_input, spoilt_output, again = series[
        len(with_alpha) :
    ]
    needs_alpha = None if any(run.fault for *_, run in with_alpha[:-1]) else with_alpha[-1][2].fault
    return Cases(
        with_alpha[:-1] if needs_alpha else with_alpha,
        of_noise,
        of_slow,
        of_constant,
        from_initial,
        initial,
        initial_alpha=alphas[1],
        alone=alone[1],
        beside=beside[1],
        spoilt_input=spoilt_input[1],
        spoilt_output=spoilt_output[1],
        again=again[1],
        nothing_at_first=len(series[0][0]) < len(signal),
        needs_alpha=needs_alpha,
        stumbles=stumbles,
    )


def _from_first_vector(signal: Array, run: FilterRun) -> tuple[Array, FilterRun]:
    """A case without its first sample if update() returned nothing for that alone, which is one fault and judged as that."""
    missing = [] if run.output is None else np.flatnonzero(~np.isfinite(run.output).all(axis=1)).tolist()
    if run.fault or missing != [0] or not run.odd:
        return signal, run
    assert run.output is not None
    return signal[1:], replace(run, output=run.output[1:])


def plain(student: Student, truth: Traces) -> list[tuple[float, Array, FilterRun]]:
    """The runs that the recursion is looked for in: alpha, what went in, and what came out."""
    return asked(student, truth).plain


def output_of_signal(run: FilterRun) -> Array:
    """An output that may stop being finite for this signal alone: follows_recursion charges what does not obey it."""
    if run.fault is None and run.output is not None and not run.odd and not np.isfinite(run.output).all():
        raise Lost(FORM, "NaN or infinity", mistakes=["not-finite"], belongs_to=RECURSION)
    return output(run)


def output(run: FilterRun) -> Array:
    """What came out (n, 3), in a form that can be judged."""
    raised(run.fault, "filtering measurements")
    if run.output is None:
        raise Skipped("an output")
    if not np.isfinite(run.output).all():
        mistake = "wrong-return-type" if run.odd else "not-finite"
        raise Unusable(FORM, run.odd or "NaN or infinity", mistakes=[mistake])
    return run.output
