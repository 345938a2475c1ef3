"""Filtering: the sheet's exponential moving average, which reduces noise and preserves the signal."""

from __future__ import annotations

import numpy as np

from grader.engine.conversation import found_once
from grader.engine.examination import check
from grader.engine.findings import Lost, Ours, Size, Skipped
from grader.engine.traces import Traces
from grader.ground.text import printable
from grader.labs.imu.checks.filter_runs import (
    FORM,
    RECURSION,
    SLOW_PERIOD,
    Cases,
    asked,
    output,
    output_of_signal,
    plain,
)
from grader.labs.imu.checks.fitting import fits_in
from grader.labs.imu.compare import Array, same, vector
from grader.labs.imu.diagnosis import filter_outputs as outputs
from grader.labs.imu.diagnosis import filtering as diagnosis
from grader.labs.imu.digits import told_apart
from grader.labs.imu.student import Student

_OWN_STATE = "filtering.instances_independent"
"""It charges what other checks see as well, as RECURSION does."""
_LARGEST_NOISE_GAIN = 0.95
"""Of the variance. The sheet's filter leaves alpha / (2 - alpha) = 0.11 for alpha 0.2, averaging two samples 0.5; no filter 1."""
_LEAST_SHARE = 0.5
"""Of the output's deviation that swings as a slow input does: a linear filter of any kind has 1, numbers of chance have 0."""
_NOTHING_LEFT = 1e-3
_LARGEST_SIGNAL_ERROR = 0.5
"""Of the signal's spread. The sheet's filter errs by 0.13 at this period; one that loses the signal by 1."""

_DEFAULT = Ours("The default of alpha is 0.1 in the sheet.")
_WEIGHT = Ours(
    "Only the weights differ from the sheet's: give the measurement alpha itself and the output before 1 - alpha, once in each "
    "update() (Step 6)."
)
_TWICE = Ours(
    "Each update() moves the output by alpha of the way twice: look for a second call of update, a loop, or a decorator that calls "
    "it again (Step 6)."
)
_BEHIND = Ours(
    "Return the output that this measurement has just made; what comes out belongs to the measurement before (Step 6)."
)
_STAYS = Ours(
    "On some measurements your output stays where it was, and on the others it is the sheet's: let every measurement move it, by "
    "alpha of the way (Step 6)."
)
_FROM_THE_SECOND = Ours(
    "Your later outputs follow the sheet's recursion, and the first ones do not: use it from the second measurement on, whose "
    "output before is the first measurement (Step 6)."
)
_LIMITED = Ours(
    "Return what the recursion gives, however large: a limit cuts off motion along with the noise (Step 6)."
)
_BY_HAND = Ours(
    "Work one update by hand: alpha times the measurement plus (1 - alpha) times the output that came before, on each axis by "
    "itself, and that is the next output and the state (Step 6)."
)
_FIRST = Ours(
    "Where no initial value is given, let the first measurement be the first output and the state, as it is (Step 6)."
)
_INITIAL = Ours(
    "Take the initial value for the output before the first measurement, and update from it as from any other (Step 6)."
)
_COPY_INITIAL = Ours(
    "Keep a copy of the initial value, np.array(initial_value), and compute with that: it belongs to the caller, and *=, += and "
    "[:] = write into it (Step 6)."
)
_OWN = Ours(
    "Let the output follow from this instance's own measurements alone: the same ones did not give the same output again. Look at "
    "what is kept outside self, and at random numbers (Step 6)."
)
_SUM = Ours(
    "A constant has to come out as itself: look at the sum of the weights, alpha and 1 - alpha in the sheet, and at what is "
    "added or cut off on the way (Step 6)."
)
_SMALL = Ours(
    "Noise has to come out smaller: look at how much of the measurement goes straight into the output. In the sheet that is "
    "alpha, and the rest is the output before (Step 6)."
)
_SLOW = Ours(
    "A slow motion has to come through: look at what keeps the output from following it. In the sheet every measurement moves the "
    "output by alpha of the way (Step 6)."
)


@check("filtering.follows_recursion", lab_step=6)
def check_follows_recursion(student: Student, truth: Traces) -> None:
    """The filter computes y[n] = alpha x[n] + (1 - alpha) y[n-1], with alpha 0.1 where none is given"""
    runs = [(alpha, signal, output(run)) for alpha, signal, run in plain(student, truth)]
    wrong = [run for run in runs if not diagnosis.obeys(run[1], run[2], run[0], 1 - run[0])]
    if not wrong:
        _in_sound_form(student, truth)
        _needs_no_alpha(student, truth)
        departs = next((run.departs for *_, run in plain(student, truth) if run.departs), ())
        fits_in(student, "LowPassFilter", departs)
        return
    alpha, x, y = wrong[0]
    wanted = alpha * x[1:] + (1 - alpha) * y[:-1]
    row = np.argmax(np.abs(y[1:] - wanted).max(axis=1))
    expected, got = told_apart(wanted[row], y[row + 1])
    has_default = asked(student, truth).needs_alpha is None
    only_default = has_default and len(wrong) == 1 and wrong[0] is runs[-1]
    mistakes, hint = ([], _DEFAULT) if only_default else _why_not_the_recursion(student, truth, runs)
    raise Lost(
        f"{expected} from the measurement {vector(x[row + 1])} after {vector(y[row])}, alpha {alpha:g}",
        got,
        off=_off(y[row + 1], wanted[row]),
        mistakes=mistakes,
        keeps=0.5 if only_default else 0.0,
        hint=hint,
    )


def _in_sound_form(student: Student, truth: Traces) -> None:
    """Charge another form that a vector could be made out of; nothing at first alone is another check's."""
    odd = next((run.odd for *_, run in plain(student, truth) if run.odd), "")
    if odd and not asked(student, truth).nothing_at_first:
        raise Lost(FORM, odd, mistakes=["wrong-return-type"], keeps=0.5)


def _needs_no_alpha(student: Student, truth: Traces) -> None:
    fault = asked(student, truth).needs_alpha
    if fault is not None:
        got = f"{fault.type}{f' at {fault.where}' if fault.where else ''}: {printable(fault.message, 200)}"
        off = Size("no filter where no alpha is given")
        raise Lost("a filter with alpha 0.1 where none is given", got, keeps=0.5, hint=_DEFAULT, fault=fault, off=off)


def _why_not_the_recursion(
    student: Student, truth: Traces, runs: list[tuple[float, Array, Array]]
) -> tuple[list[str], str]:
    """The mistake's name, or the kind of difference in words: a true hint in either case."""
    if _is_rounded(student, truth):
        return ["output-rounded"], ""
    if _is_limited(runs):
        return [], _LIMITED
    if mistakes := diagnosis.mistakes([(alpha, x, y) for alpha, x, y in runs]):
        return mistakes, ""
    if all(diagnosis.obeys(x, y, 1 - (1 - alpha) ** 2, (1 - alpha) ** 2) for alpha, x, y in runs):
        return [], _TWICE
    if all(diagnosis.recursion_of(x, y) for _, x, y in runs):
        return [], _WEIGHT
    if all(outputs.one_behind(alpha, x, y) for alpha, x, y in runs):
        return [], _BEHIND
    if diagnosis.stays_at_times(runs):
        return [], _STAYS
    if diagnosis.begins_late(runs):
        return [], _FROM_THE_SECOND
    return (["other-low-pass"], "") if _is_low_pass(student, truth) else ([], _BY_HAND)


def _is_low_pass(student: Student, truth: Traces) -> bool:
    cases = asked(student, truth)
    noise, slow, constant = cases.noise, cases.slow, cases.constant
    return (
        diagnosis.noise_gain(noise[0], output(noise[1])) < _LARGEST_NOISE_GAIN
        and diagnosis.signal_error(slow[0], output(slow[1])) < _LARGEST_SIGNAL_ERROR
        and same(output(constant[1])[-1], constant[0][0], 1e-3)
    )


def filters(student: Student, truth: Traces) -> None:
    """What comes out depends on the measurements, and on more than the present one."""
    runs = [(signal, output(run)) for _, signal, run in plain(student, truth)]
    if all(diagnosis.has_no_memory(x, y) for x, y in runs) and not _keeps_the_first(student, truth):
        raise Skipped(
            "a filter that keeps something of the measurements before: each output comes from one measurement alone"
        )
    if not any(np.ptp(y[1:], axis=0).any() for _, y in runs):
        raise Skipped("a filter whose output follows the measurements: it stays the same, whatever goes in")
    if all(diagnosis.runs_away(x, y) for x, y in runs):
        return
    _, run = asked(student, truth).slow
    if diagnosis.share_of_signal(output_of_signal(run), SLOW_PERIOD) < _LEAST_SHARE and not _is_rounded(student, truth):
        raise Skipped("a filter whose output follows the measurements: a slow motion is not seen in what comes out")


def _keeps_the_first(student: Student, truth: Traces) -> bool:
    """Whether what is returned is never kept: it is smoothed, and never gets away from the first measurement."""
    return all(diagnosis.keeps_the_first(alpha, signal, output(run)) for alpha, signal, run in plain(student, truth))


def lets_constants_through(student: Student, truth: Traces) -> None:
    """Of a constant something comes out: a high-pass filter keeps what a low-pass filter takes away.

    Where the recursion holds elsewhere the filter is no high-pass: what it makes of a constant is a fault of its own.
    """
    filters(student, truth)
    if all(diagnosis.obeys(x, output(run), alpha, 1 - alpha) for alpha, x, run in plain(student, truth)):
        return
    signal, run = asked(student, truth).constant
    if np.abs(output_of_signal(run)[-1]).max() < _NOTHING_LEFT * np.abs(signal[0]).max():
        raise Skipped("a filter that lets the signal through: of a constant nothing comes out")


@check("filtering.starts_from_first_measurement", lab_step=6, needs=filters)
def check_starts_from_first_measurement(student: Student, truth: Traces) -> None:
    """The first output is the first measurement, or follows from the initial value where one is given"""
    alpha, x, run = plain(student, truth)[0]
    y = output(run)
    if asked(student, truth).nothing_at_first:
        got = f"{run.odd} from the first update(), vectors from the next ones"
        raise Lost(vector(x[0]), got, mistakes=["wrong-return-type"], off=Size("no vector from the first update()"))
    if not same(y[0], x[0], outputs.ATOL):
        zero = same(y[0], alpha * x[0], outputs.ATOL) or same(y[0], (1 - alpha) * x[0], outputs.ATOL) or not y[0].any()
        high_pass = _named(student, truth) == ["high-pass"]  # what it lets through at first is part of that fault
        mistakes = ["zero-initial-state"] if (zero or _from_zero(x, y)) and not high_pass else []
        expected, got = told_apart(x[0], y[0])
        raise Lost(
            expected,
            got,
            mistakes=mistakes,
            off=_off(y[0], x[0]),
            hint="" if mistakes else _FIRST,
            belongs_to="" if mistakes else _OWN_STATE if _shares_state(student, truth) else RECURSION,
        )
    _follows_initial_value(student, truth)


def _starts_at(y: Array, *places: Array) -> bool:
    return any(same(y[0], place, outputs.ATOL) for place in places)


def _from_zero(x: Array, y: Array) -> bool:
    found = diagnosis.recursion_of(x, y)
    return found is not None and same(y[0], found[0] * x[0], outputs.ATOL)


def _follows_initial_value(student: Student, truth: Traces) -> None:
    cases = asked(student, truth)
    x, run, alpha, initial = *cases.from_initial, cases.initial_alpha, cases.initial
    y = output(run)
    wanted = alpha * x[0] + (1 - alpha) * initial
    if same(y[0], wanted, outputs.ATOL):
        return
    found = diagnosis.recursion_of(x, y)
    ignored = found is not None and abs(found[1]) > outputs.ATOL and _starts_at(y, x[0], found[0] * x[0])
    expected, got = told_apart(wanted, y[0])
    raise Lost(
        f"{expected} from the measurement {vector(x[0])} after the initial value {vector(initial)}, alpha {alpha:g}",
        got,
        off=_off(y[0], wanted),
        mistakes=["initial-value-ignored"] if ignored else [],
        keeps=0.5,
        hint="" if ignored else _INITIAL,
        belongs_to=_OWN_STATE if _shares_state(student, truth) else "" if ignored else RECURSION,
    )


@check("filtering.passes_constant", lab_step=6, needs=lets_constants_through)
def check_passes_constant(student: Student, truth: Traces) -> None:
    """A constant input comes out as itself"""
    signal, run = asked(student, truth).constant
    y, wanted = output(run), signal[0]
    if not same(y[-1], wanted, 1e-3):
        expected, got = told_apart(wanted, y[-1])
        mistakes = _named(student, truth)
        raise Lost(
            f"{expected}, the constant itself",
            f"{got} after {len(y)} samples",
            off=_off(y[-1], wanted),
            mistakes=mistakes,
            hint="" if mistakes else _SUM,
            belongs_to=RECURSION,
        )


@check("filtering.reduces_noise", lab_step=6, needs=filters)
def check_reduces_noise(student: Student, truth: Traces) -> None:
    """Noise comes out smaller than it went in"""
    x, run = asked(student, truth).noise
    gain = diagnosis.noise_gain(x, output(run))
    if not gain < _LARGEST_NOISE_GAIN:
        mistakes = _named(student, truth)
        raise Lost(
            "a noise variance below that of the input",
            f"{gain:.3g} times that of the input (alpha 0.2)",
            mistakes=mistakes,
            hint="" if mistakes else _SMALL,
            belongs_to=RECURSION,
        )


@check("filtering.preserves_signal", lab_step=6, needs=lets_constants_through)
def check_preserves_signal(student: Student, truth: Traces) -> None:
    """A slow motion comes through the filter"""
    x, run = asked(student, truth).slow
    error = diagnosis.signal_error(x, output(run))
    if not error < _LARGEST_SIGNAL_ERROR:
        mistakes = _named(student, truth)
        raise Lost(
            "an output that follows a slow input",
            f"an output that misses it by {error:.3g} of its spread",
            mistakes=mistakes,
            hint="" if mistakes else _SLOW,
            belongs_to=RECURSION,
        )


def _named(student: Student, truth: Traces) -> list[str]:
    return diagnosis.mistakes([(alpha, signal, output(run)) for alpha, signal, run in plain(student, truth)])


@check("filtering.instances_independent", lab_step=6)
def check_instances_independent(student: Student, truth: Traces) -> None:
    """Each instance keeps a state of its own, which nobody else can change"""
    cases = asked(student, truth)
    alone = output(cases.alone)
    if not np.ptp(alone, axis=0).any() and not same(alone[0], cases.plain[0][1][0], outputs.ATOL):
        raise Skipped("an output that depends on the measurements")
    if fault := cases.stumbles:
        got = f"{fault.type}{f' at {fault.where}' if fault.where else ''}: {printable(fault.message, 200)}"
        off = Size("no output where another filter was before")
        raise Lost(
            "the same output after a first filter as alone", got, mistakes=["shared-state"], fault=fault, off=off
        )
    if _shares_state(student, truth):
        settled = outputs.settles(output(cases.again) - alone)
        aliased = [] if outputs.settles(output(cases.spoilt_output) - alone) else ["aliased-output"]
        raise Lost(
            "the same output beside a second filter as alone",
            "another output",
            mistakes=["shared-state", *aliased] if settled else [],
            hint="" if settled else _OWN,
            belongs_to="" if settled else RECURSION,
        )
    if not same(output(cases.spoilt_output), alone, outputs.ATOL):
        got = "one that changes when the caller writes into the array that came out"
        raise Lost("a state of the filter's own", got, mistakes=["aliased-output"], keeps=0.5)
    _leaves_input_alone(cases)
    if any(run.output_changed for run in cases.every):
        got = "one array for all of them, which the next update() writes into"
        raise Lost("an output that stays what it is", got, mistakes=["aliased-output"], keeps=0.5)
    if not same(output(cases.spoilt_input), alone, outputs.ATOL):
        got = "one that changes when the caller writes into the array that went in"
        raise Lost("a state of the filter's own", got, keeps=0.5, mistakes=["aliased-input"])


def _leaves_input_alone(cases: Cases) -> None:
    """The initial value is what was written into where only the filter that was given one wrote into anything."""
    changed = [run for run in cases.every if run.input_changed]
    if not changed:
        return
    initial = all(run is cases.from_initial[1] for run in changed)
    raise Lost(
        "the initial value as it was handed in"
        if initial
        else "the measurement and the initial value as they were handed in",
        "an array that was written into",
        mistakes=["mutates-input"],
        keeps=0.5,
        hint=_COPY_INITIAL if initial else "",
    )


@found_once
def _is_rounded(student: Student, truth: Traces) -> bool:
    """Whether all outputs are rounded, which follows_recursion charges."""
    return all(outputs.grain(alpha, signal, output(run)) for alpha, signal, run in plain(student, truth))


def _is_limited(runs: list[tuple[float, Array, Array]]) -> bool:
    """Whether the recursion holds where outputs are not cut off, of runs in which it does not hold everywhere."""
    return all(outputs.limits(*run) is not None or diagnosis.obeys(run[1], run[2], run[0], 1 - run[0]) for run in runs)


def _shares_state(student: Student, truth: Traces) -> bool:
    cases = asked(student, truth)
    return cases.stumbles is not None or not same(output(cases.beside), output(cases.alone), outputs.ATOL)


def _off(got: Array, wanted: Array) -> Size:
    return Size("the output is off", float(np.max(np.abs(got - wanted))))
