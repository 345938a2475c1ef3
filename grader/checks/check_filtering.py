"""Filtering: the sheet's exponential moving average, which reduces noise and preserves the signal."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..answers import FilterRun
from ..compare import Array, same, vector
from ..diagnosis import filtering as diagnosis
from ..plugin import check
from ..student import FilterCase, Student
from ..traces import Traces
from ..verdicts import Lost, Skipped, raised

_DEFAULT_ALPHA = 0.1
_SLOW_PERIOD = 200  # samples; the sheet's filter with alpha 0.2 lags by 4 of them
_LARGEST_NOISE_GAIN = 0.95
"""Of the variance. The sheet's filter leaves alpha / (2 - alpha) = 0.11 for alpha 0.2, averaging two samples 0.5; no filter 1."""
_LARGEST_SIGNAL_ERROR = 0.5
"""Of the signal's spread. The sheet's filter errs by 0.13 at this period; one that loses the signal by 1."""


@check("filtering.follows_recursion", lab_step=6)
def check_follows_recursion(student: Student, truth: Traces) -> None:
    """The filter computes y[n] = alpha x[n] + (1 - alpha) y[n-1], with alpha 0.1 where none is given"""
    runs = [(alpha, signal, _output(run)) for alpha, signal, run in _plain(student, truth)]
    wrong = [run for run in runs if not diagnosis.obeys(run[1], run[2], run[0], 1 - run[0])]
    if not wrong:
        return
    alpha, x, y = wrong[0]
    wanted = alpha * x[1:] + (1 - alpha) * y[:-1]
    row = int(np.argmax(np.abs(y[1:] - wanted).max(axis=1)))
    only_default = len(wrong) == 1 and wrong[0] is runs[-1]
    mistakes = diagnosis.mistakes(runs)
    if not mistakes and _is_low_pass(student, truth):
        mistakes = ["other-low-pass"]
    raise Lost(
        f"{vector(wanted[row])} from the measurement {vector(x[row + 1])} after {vector(y[row])}, alpha {alpha:g}",
        vector(y[row + 1]),
        off=_off(y[row + 1], wanted[row]),
        mistakes=[] if only_default else mistakes,
        keeps=0.5 if only_default else 0.0,
        hint="The default of alpha is 0.1 in the sheet." if only_default else "",
    )


def _is_low_pass(student: Student, truth: Traces) -> bool:
    cases = _cases(student, truth)
    noise, slow, constant = cases.noise, cases.slow, cases.constant
    return (
        diagnosis.noise_gain(noise[0], _output(noise[1])) < _LARGEST_NOISE_GAIN
        and diagnosis.signal_error(slow[0], _output(slow[1])) < _LARGEST_SIGNAL_ERROR
        and same(_output(constant[1])[-1], constant[0][-1], 1e-3)
    )


@check("filtering.starts_from_first_measurement", lab_step=6)
def check_starts_from_first_measurement(student: Student, truth: Traces) -> None:
    """The first output is the first measurement, or follows from the initial value where one is given"""
    alpha, x, run = _plain(student, truth)[0]
    y = _output(run)
    if _cases(student, truth).nothing_at_first:
        got = f"{run.odd or 'nothing'} from the first update(), vectors from the next ones"
        raise Lost(vector(x[0]), got, mistakes=["wrong-return-type"], off="no vector from the first update()")
    if _named(student, truth) == ["high-pass"]:
        return  # what it lets through of the first measurement is part of that fault
    if not same(y[0], x[0], diagnosis.ATOL) and not _scaled(x, y):
        zero = (
            same(y[0], alpha * x[0], diagnosis.ATOL) or same(y[0], (1 - alpha) * x[0], diagnosis.ATOL) or not y[0].any()
        )
        stuck = not np.ptp(y, axis=0).any()
        mistakes = ["output-stuck"] if stuck else ["zero-initial-state"] if zero or _from_zero(x, y) else []
        raise Lost(vector(x[0]), vector(y[0]), mistakes=mistakes, off=_off(y[0], x[0]))
    _follows_initial_value(student, truth)


def _scaled(x: Array, y: Array) -> bool:
    """Whether the first output is right for a recursion that is wrong, which follows_recursion charges."""
    found = diagnosis.recursion_of(x, y)
    gain = sum(found) if found is not None else 0.0
    return abs(gain) > 1e-6 and abs(gain - 1) > 1e-6 and same(y[0], gain * x[0], diagnosis.ATOL)


def _from_zero(x: Array, y: Array) -> bool:
    found = diagnosis.recursion_of(x, y)
    return found is not None and same(y[0], found[0] * x[0], diagnosis.ATOL)


def _follows_initial_value(student: Student, truth: Traces) -> None:
    cases = _cases(student, truth)
    x, run, alpha, initial = *cases.from_initial, cases.initial_alpha, cases.initial
    y = _output(run)
    found = diagnosis.recursion_of(x, y)
    if found is None or _shares_state(student, truth):
        return  # another filter, or one that starts from its neighbour's state: charged elsewhere
    if abs(found[1]) < diagnosis.ATOL or same(y[0], found[0] * x[0] + found[1] * initial, diagnosis.ATOL):
        return
    wanted = alpha * x[0] + (1 - alpha) * initial
    ignored = same(y[0], x[0], diagnosis.ATOL) or same(y[0], found[0] * x[0], diagnosis.ATOL)
    raise Lost(
        f"{vector(wanted)} from the measurement {vector(x[0])} after the initial value {vector(initial)}, alpha {alpha:g}",
        vector(y[0]),
        off=_off(y[0], wanted),
        mistakes=["initial-value-ignored"] if ignored else [],
        keeps=0.5,
    )


@check("filtering.passes_constant", lab_step=6)
def check_passes_constant(student: Student, truth: Traces) -> None:
    """A constant input comes out as itself"""
    signal, run = _cases(student, truth).constant
    y = _output(run)
    if not same(y[-1], signal[-1], 1e-3):
        raise Lost(
            f"{vector(signal[-1])}, the constant itself",
            f"{vector(y[-1])} after {len(y)} samples",
            off=_off(y[-1], signal[-1]),
            mistakes=_gain_mistakes(student, truth),
        )


def _gain_mistakes(student: Student, truth: Traces) -> list[str]:
    runs = [(alpha, signal, _output(run)) for alpha, signal, run in _plain(student, truth)]
    named = diagnosis.mistakes(runs)
    return named if named else ["gain-not-one"] if all(diagnosis.recursion_of(x, y) for _, x, y in runs) else []


@check("filtering.reduces_noise", lab_step=6)
def check_reduces_noise(student: Student, truth: Traces) -> None:
    """Noise comes out smaller than it went in"""
    x, run = _cases(student, truth).noise
    if not np.ptp(_output(run), axis=0).any():
        raise Skipped("an output that changes with the measurement")
    gain = diagnosis.noise_gain(x, _output(run))
    if not gain < _LARGEST_NOISE_GAIN:
        raise Lost(
            "a noise variance below that of the input",
            f"{gain:.2f} times that of the input (alpha 0.2)",
            mistakes=_named(student, truth),
        )


@check("filtering.preserves_signal", lab_step=6)
def check_preserves_signal(student: Student, truth: Traces) -> None:
    """A slow motion comes through the filter"""
    x, run = _cases(student, truth).slow
    error = diagnosis.signal_error(x, _output(run))
    if not error < _LARGEST_SIGNAL_ERROR:
        raise Lost(
            "an output that follows a slow input",
            f"an output that misses it by {error:.2f} of its spread",
            mistakes=_named(student, truth),
        )


def _named(student: Student, truth: Traces) -> list[str]:
    return diagnosis.mistakes([(alpha, signal, _output(run)) for alpha, signal, run in _plain(student, truth)])


@check("filtering.instances_independent", lab_step=6)
def check_instances_independent(student: Student, truth: Traces) -> None:
    """Each instance keeps a state of its own, which nobody else can change"""
    cases = _cases(student, truth)
    alone = _output(cases.alone)
    if not np.ptp(alone, axis=0).any() and not same(alone[0], cases.plain[0][1][0], diagnosis.ATOL):
        raise Skipped("an output that depends on the measurements")
    if _shares_state(student, truth):
        raise Lost("the same output beside a second filter as alone", "another output", mistakes=["shared-state"])
    if not same(_output(cases.spoilt_output), alone, diagnosis.ATOL):
        got = "one that changes when the caller writes into the array that came out"
        raise Lost("a state of the filter's own", got, mistakes=["aliased-output"], keeps=0.5)
    if any(run.input_changed for run in cases.every):
        raise Lost(
            "the measurement and the initial value as they were handed in",
            "an array that was written into",
            mistakes=["mutates-input"],
            keeps=0.5,
        )
    if any(run.output_changed for run in cases.every):
        got = "one array for all of them, which the next update() writes into"
        raise Lost("an output that stays what it is", got, mistakes=["aliased-output"], keeps=0.5)
    if not same(_output(cases.spoilt_input), alone, diagnosis.ATOL):
        got = "one that changes when the caller writes into the array that went in"
        raise Lost("a state of the filter's own", got, keeps=0.5, mistakes=["aliased-input"])


def _shares_state(student: Student, truth: Traces) -> bool:
    cases = _cases(student, truth)
    return not same(_output(cases.beside), _output(cases.alone), diagnosis.ATOL)


# --- what the checks share -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cases:
    """Each case as its signal and the run, or the run alone."""

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
    nothing_at_first: bool

    @property
    def every(self) -> list[FilterRun]:
        pairs = (self.noise, self.slow, self.constant, self.from_initial)
        return [run for *_, run in self.plain] + [run for _, run in pairs] + [self.alone, self.beside]


def _cases(student: Student, truth: Traces) -> _Cases:
    scenario = truth["filter"]
    signal, alphas, initial = scenario["input"], [float(a) for a in scenario["alpha"]], scenario["initial"]
    short = signal[:60]
    noise = scenario["acceleration"] - scenario["acceleration_clean"] + signal[0]
    phase = 2 * np.pi * np.arange(400)[:, None] / _SLOW_PERIOD + np.array([0.0, 1.0, 2.0])
    slow = np.sin(phase) * np.array([1.0, 2.0, 0.5]) + signal[0]
    constant = np.tile(signal[0], (300, 1))
    cases = [
        *(FilterCase(signal, alpha) for alpha in alphas),
        FilterCase(signal[:100]),
        FilterCase(noise, 0.2),
        FilterCase(slow, 0.2),
        FilterCase(constant, 0.2),
        FilterCase(short, alphas[1], initial),
        *(FilterCase(short, 0.3, None, handling) for handling in ("plain", "beside", "spoil_input", "spoil_output")),
    ]
    runs = student.filter("cases", cases)
    series = [_from_first_vector(case.signal, run) for case, run in zip(cases, runs, strict=True)]
    plain = [(alpha, *pair) for alpha, pair in zip((*alphas, _DEFAULT_ALPHA), series, strict=False)]
    of_noise, of_slow, of_constant, from_initial, alone, beside, spoilt_input, spoilt_output = series[len(plain) :]
    return _Cases(
        plain,
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
        nothing_at_first=len(series[0][0]) < len(signal),
    )


def _from_first_vector(signal: Array, run: FilterRun) -> tuple[Array, FilterRun]:
    """A case without its first sample if update() returned nothing for that alone, which is one fault and judged as that."""
    missing = [] if run.output is None else np.flatnonzero(~np.isfinite(run.output).all(axis=1)).tolist()
    if run.fault or missing != [0] or not run.odd:
        return signal, run
    assert run.output is not None
    return signal[1:], replace(run, output=run.output[1:])


def _plain(student: Student, truth: Traces) -> list[tuple[float, Array, FilterRun]]:
    return _cases(student, truth).plain


def _off(got: Array, wanted: Array) -> str:
    return f"an output that is off by up to {np.max(np.abs(got - wanted)):.3g}"


def _output(run: FilterRun) -> Array:
    raised(run.fault, "filtering measurements")
    if run.output is None:
        raise Skipped("an output")
    if not np.isfinite(run.output).all():
        mistake = "wrong-return-type" if run.odd else "not-finite"
        raise Lost("an array of three numbers from update()", run.odd or "NaN or infinity", mistakes=[mistake])
    return run.output
