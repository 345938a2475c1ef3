"""Checks of the filter: each returns how one measured property deviates from what the sheet asks, None if it is right."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from grader.base.text import printable
from grader.engine.findings import Deviation, Size
from grader.labs.imu.compare import Array, distinct_texts, same, vector
from grader.labs.imu.filtering.explain import CONSTANT_ATOL, JUDGE, LARGEST_NOISE_GAIN, LARGEST_SIGNAL_ERROR
from grader.labs.imu.filtering.measure import ATOL, FORM, Facts, Run


class Output(TypedDict):
    """Values for the message on a wrong output of the filter: the output that was wanted, and the output that came."""

    wanted: str
    came: str


class Step(Output):
    """Values for the message on a wrong output after the first: those of `Output`, measurement `x`, output `before` it, `alpha`."""

    x: str
    before: str
    alpha: float


class Constant(Output):
    """Values for the message on a constant input that comes out changed: those of `Output`, and how many measurements went in."""

    samples: int


Gain = TypedDict("Gain", {"gain": float})
Error = TypedDict("Error", {"error": float})
Disturbed = TypedDict("Disturbed", {"alone": str, "sample": int, "came": str})


@JUDGE.check("filtering.follows_recursion", lab_step=6)
def check_follows_recursion(facts: Facts) -> Deviation[Step] | None:
    """The filter computes y[n] = alpha x[n] + (1 - alpha) y[n-1]; the default of alpha is 0.1"""
    run = next((run for run in facts.runs if not run.obeys), None)
    if run is None:
        return None
    row = int(np.argmax(run.off))
    output, size = _off(run.wanted[row], run.y[row + 1])
    return Deviation(
        {**output, "x": vector(run.x[row + 1]), "before": vector(run.y[row]), "alpha": run.alpha}, size=size
    )


@JUDGE.check("filtering.starts_from_first_measurement", lab_step=6)
def check_starts_from_first_measurement(facts: Facts) -> Deviation[Output] | None:
    """The first output is the first measurement, or follows from the initial value if one is given"""
    if facts.nothing_at_first:
        return Deviation({"wanted": FORM, "came": facts.odd}, size=Size("no vector from the first update()"))
    if not facts.runs[0].starts:
        output, size = _off(facts.runs[0].first_wanted, facts.runs[0].y[0])
        return Deviation(output, size=size)
    run = next((run for run in facts.from_initial if not run.starts), None)
    return None if run is None or run.initial is None else _off_from(run, run.initial)


@JUDGE.check("filtering.passes_constant", lab_step=6)
def check_passes_constant(facts: Facts) -> Deviation[Constant] | None:
    """A constant input comes out unchanged"""
    wanted, came = facts.constant.x[0], facts.constant.y[-1]
    output, size = _off(wanted, came)
    numbers: Constant = {**output, "samples": len(facts.constant.y)}
    return None if same(came, wanted, CONSTANT_ATOL) else Deviation(numbers, size=size)


@JUDGE.check("filtering.reduces_noise", lab_step=6)
def check_reduces_noise(facts: Facts) -> Deviation[Gain] | None:
    """Noise comes out smaller than it went in"""
    gain = facts.noise_gain
    return None if gain < LARGEST_NOISE_GAIN else Deviation({"gain": gain})


@JUDGE.check("filtering.preserves_signal", lab_step=6)
def check_preserves_signal(facts: Facts) -> Deviation[Error] | None:
    """A slow motion comes through the filter"""
    error = facts.signal_error
    return None if error < LARGEST_SIGNAL_ERROR else Deviation({"error": error})


@JUDGE.check("filtering.instances_independent", lab_step=6)
def check_instances_independent(facts: Facts) -> Deviation[Disturbed] | None:
    """Each instance keeps its own state, which no other code can change"""
    own = facts.own
    others = (own.beside, own.spoilt_input, own.spoilt_output)
    other = next((y for y in others if not same(y, own.alone, ATOL)), None)
    if other is None and not (own.stumbles or own.input_changed or own.output_changed):
        return None
    error = own.stumbles
    row = 0 if other is None else int(np.argmax(np.abs(other - own.alone).max(axis=1)))
    alone, came = distinct_texts(own.alone[row], own.alone[row] if other is None else other[row])
    if error:
        came = f"{error.type}: {printable(error.message, 200)}"
    size = Size("no output where another filter was before") if error else None
    return Deviation({"alone": alone, "sample": row + 1, "came": came}, size=size, error=error)


def _off(wanted: Array, came: Array) -> tuple[Output, Size]:
    expected, got = distinct_texts(wanted, came)
    return {"wanted": expected, "came": got}, Size("the output is off", float(np.max(np.abs(came - wanted))))


def _off_from(run: Run, initial: Array) -> Deviation[Output]:
    """Describe a wrong first output of a filter that was given an initial value, which costs half of the check."""
    output, size = _off(run.first_wanted, run.y[0])
    made_of = f"the measurement {vector(run.x[0])} after the initial value {vector(initial)}, with alpha {run.alpha:g}"
    return Deviation({**output, "wanted": f"{output['wanted']} for {made_of}"}, 0.5, size)
