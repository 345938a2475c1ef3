"""Diagnosis of a filter: the known faults of its recursion, its start and its state, and what each makes of the outputs."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping

import numpy as np

from grader.base.text import printable
from grader.engine.charging import Judge, Measure
from grader.engine.findings import Came, Deviation, Form, NoNumbers, Size
from grader.engine.hypothesis import Reason
from grader.labs.imu.compare import Array, same
from grader.labs.imu.filtering.measure import ATOL, FORM, Facts, Ownership, Run, measure
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import CALL_REASONS, departures

LARGEST_NOISE_GAIN = 0.95
"""Largest noise gain (variance ratio) of a filter. The sheet's has alpha / (2 - alpha) = 0.11 at alpha 0.2, a mean of two 0.5."""
LARGEST_SIGNAL_ERROR = 0.5
"""Largest error as a share of the signal's spread. The sheet's filter errs by 0.13; one that loses the signal by 1."""
CONSTANT_ATOL = 1e-3
"""m/s². After 300 samples at alpha 0.2 the sheet's filter is at the constant to 1e-28; the smallest fault shifts by more."""
_NOTHING_LEFT = 1e-3
"""Largest share of a constant input that a high-pass filter leaves in its output."""
_LITTLE_MOTION = 0.1
"""Smallest share of a slow motion's spread that a filter lets through. The sheet's has 0.97; a fixed weight of 0.01 has 0.3."""
_LITTLE_BESIDE = 0.025
"""Smallest share of the output's spread that is no multiple of the measurement, in noise. It is the last output's weight: with less
than that, more than `LARGEST_NOISE_GAIN` of the noise is left. The sheet's filter has 0.8 at alpha 0.2."""
_WHOLE = 1e-9
"""Largest distance of a number from its rounded value for numbers that are rounded."""
_UNUSABLE = ("a string", "a number", "a value of type")
"""Forms of an output that nobody can compute three components with."""
_DECIMALS = range(5)
"""Numbers of decimals to which a filter may round; a finer rounding stays below `ATOL`."""
_LONGEST = 100
"""Longest window of a moving average, in samples."""
_NOW_AND_THEN = 0.2
"""Largest share of outputs equal to the measurement for a recursion that starts again now and then."""
_FEWEST = 6
"""Smallest number of outputs that obey the recursion for a filter that keeps its last value at times."""


def recursion(alpha: float, x: Array, start: Array) -> Array:
    """Return the outputs (n, 3) of the lab sheet's filter for measurements x (n, 3), if its first output is `start` (3,)."""
    steps = itertools.accumulate(x[1:], lambda y, sample: alpha * sample + (1 - alpha) * y, initial=start)
    return np.array(list(steps))


def _every(holds: Callable[[Run], bool]) -> Callable[[Facts], bool]:
    """Return a test of all facts from a test of one run of the filter: whether every run passes it."""
    return lambda facts: all(map(holds, facts.runs))


# ---- what is done to the recursion's outputs


def _is_rounded(run: Run) -> bool:
    """Return whether a filter computes the sheet's recursion and rounds, truncates or halves the precision of output or state.

    A rounded output differs from the recursion by one step at most, and its start by one more. A rounded state obeys the recursion
    from each output to the next within one step. False if the outputs never change.
    """
    return bool(np.ptp(run.y, axis=0).any()) and any(
        same(run.y, recursion(run.alpha, run.x, run.y[0]), 2 * grain) or bool(np.all(run.off <= grain + ATOL))
        for grain in _grains(run.y[1:])  # the first may be the measurement itself
    )


def _grains(y: Array) -> list[float]:
    """Return the steps to which all these numbers may be rounded: powers of ten, and the step of half precision; perhaps none."""
    steps = [10.0**-d for d in _DECIMALS if np.abs(y - y.round(d)).max() < _WHOLE]
    if np.abs(y).max() < 1e4 and np.abs(y - y.astype(np.float16)).max() < _WHOLE:
        steps.append(float(np.spacing(np.float16(np.abs(y).max()))))
    return steps


def _is_clipped(run: Run) -> bool:
    """Return whether the output is the sheet's, clipped to two limits, with more than half of the outputs between them."""
    whole = recursion(run.alpha, run.x, run.x[0])
    cut = np.clip(whole, run.y.min(), run.y.max())
    return same(run.y, cut, ATOL) and 0.5 < float(np.mean(np.abs(whole - cut) <= ATOL)) < 1


# ---- other recursions


WEIGHTS: tuple[tuple[int, str, Callable[[float], tuple[float, float, float]]], ...] = (
    (3, "alpha-swapped", lambda alpha: (1 - alpha, 0, alpha)),
    (3, "no-filtering", lambda _: (1, 0, 0)),
    (3, "filters-input-history", lambda alpha: (alpha, 1 - alpha, 0)),
    (3, "filters-input-history", lambda alpha: (1 - alpha, alpha, 0)),
    (3, "high-pass", lambda alpha: (alpha, -alpha, alpha)),
    (3, "high-pass", lambda alpha: (1 - alpha, alpha - 1, 1 - alpha)),  # the measurement without its low-passed part
    (11, "updates-twice", lambda alpha: (1 - (1 - alpha) ** 2, 0, (1 - alpha) ** 2)),
    (13, "one-behind", lambda alpha: (0, alpha, 1 - alpha)),
)
"""Weights of the measurement, the last measurement and the last output. The second output is not tested: a delay changes it."""


def _made_of(weights: Callable[[float], tuple[float, float, float]]) -> Callable[[Facts], bool]:
    """Return a test of the facts: whether each output is a sum of two measurements and the last output with these weights."""
    return lambda facts: all(same(run.y[2:], run.made_of(*weights(run.alpha))[1:], ATOL) for run in facts.runs)


def _ignores_alpha(facts: Facts) -> bool:
    """Return whether runs with different alpha have the same weights, so that the filter does not use its alpha."""
    weights = [a for a, _ in facts.weights]
    return bool(weights) and max(weights) - min(weights) < 1e-6 and len({run.alpha for run in facts.runs}) > 1


def _takes_constants_away(facts: Facts) -> bool:
    """Return whether a constant input vanishes in the output and the signal is lost, as by a high-pass filter."""
    left = np.abs(facts.constant.y[-1]).max() < _NOTHING_LEFT * np.abs(facts.constant.x[0]).max()
    return bool(left) and not facts.signal_error < LARGEST_SIGNAL_ERROR


def _hardly_moves(facts: Facts) -> bool:
    """Return whether a slow motion has almost no effect on the output, as by one fixed tiny weight."""
    x, y = facts.second_half(facts.slow)
    return bool(np.linalg.norm(y.std(axis=0)) < _LITTLE_MOTION * np.linalg.norm(x.std(axis=0)))


def _hardly_remembers(facts: Facts) -> bool:
    """Return whether the output is the noise that went in, times a factor, with a mere trace of earlier outputs."""
    x, y = (each - each.mean(axis=0) for each in facts.second_half(facts.noise))
    beside = y - x * (np.sum(x * y, axis=0) / np.sum(x * x, axis=0))
    return bool(0 < np.linalg.norm(beside) < _LITTLE_BESIDE * np.linalg.norm(y))


def _from_the_first(run: Run) -> bool:
    """Return whether the state is never updated: each output mixes its measurement with the first one, with alpha or 1 - alpha."""
    return any(same(run.y[1:], w * run.x[1:] + (1 - w) * run.x[0], ATOL) for w in (run.alpha, 1 - run.alpha))


def _from_one_value(run: Run) -> bool:
    """Return whether each output after the first mixes its measurement with one constant vector, whatever that is."""
    return any(np.ptp(run.y[1:] - w * run.x[1:], axis=0).max() <= ATOL for w in (run.alpha, 1 - run.alpha))


def _restarts(facts: Facts) -> bool:
    """Return whether the filter starts again at times: its output is then the measurement, and the recursion goes on from it."""
    again = [np.abs(run.y[1:] - run.x[1:]).max(axis=1) <= ATOL for run in facts.runs]
    seldom = all(o.mean() < _NOW_AND_THEN and a[o].all() for o, a in zip(facts.off, again, strict=True))
    return seldom and any((o[1:] & ~o[:-1]).any() for o in facts.off)  # after it had begun


def _stays_at_times(facts: Facts) -> bool:
    """Return whether the output at times keeps its last value whatever the measurement is, and else obeys the recursion."""
    stays = [np.abs(np.diff(run.y, axis=0)).max(axis=1) <= ATOL for run in facts.runs]
    return all(np.sum(~o) >= _FEWEST and s[o].all() for o, s in zip(facts.off, stays, strict=True))


def _begins_late(facts: Facts) -> bool:
    """Return whether the recursion holds after the first outputs, at most a third of them; False if it holds from the start."""
    first = [int(np.argmin(o)) for o in facts.off]
    return any(first) and all(end <= len(o) // 3 and not o[end:].any() for end, o in zip(first, facts.off, strict=True))


def _is_moving_average(run: Run) -> bool:
    """Return whether each output is a moving average: the mean of a fixed number of samples."""
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(run.x, axis=0)])
    sizes = range(1, min(_LONGEST, len(run.x) // 2) + 1)
    return any(same(run.y[size:], (sums[size + 1 :] - sums[1:-size]) / size, ATOL) for size in sizes)


def _is_mean_of_all(run: Run) -> bool:
    """Return whether each output is the mean of all samples so far."""
    return same(run.y, np.cumsum(run.x, axis=0) / np.arange(1, len(run.x) + 1)[:, None], ATOL)


def _has_whole_numbers(run: Run) -> bool:
    """Return whether the state is of whole numbers: each output is the recursion from the one before, rounded or cut off.

    A state of real numbers whose output alone is cut off goes on from numbers that are not shown. False if the outputs never
    change.
    """
    y = run.y[1:]
    return bool(np.ptp(y, axis=0).any()) and any(
        np.all(np.abs(whole(run.wanted) - y) <= _WHOLE) for whole in (np.trunc, np.floor, np.rint)
    )


def _leaves_axes_out(run: Run) -> bool:
    """Return whether some axes obey the recursion, and the others come out unfiltered or never change."""
    y = run.y[1:]
    right, as_they_are = ((np.abs(y - other) <= ATOL).all(axis=0) for other in (run.wanted, run.x[1:]))
    left = as_they_are | (np.ptp(y, axis=0) <= ATOL)
    return bool(right.any() and not right.all() and (right | left).all())


def _mixes_axes(run: Run) -> bool:
    """Return whether each output depends on other axes than its own, by fixed weights."""
    columns = np.concatenate([run.x[1:], run.y[:-1]], axis=1)
    weights, *_ = np.linalg.lstsq(columns, run.y[1:], rcond=None)
    apart = ~np.tile(np.eye(3, dtype=bool), (2, 1))
    return bool(np.abs(weights[apart]).max() > 1e-3) and same(columns @ weights, run.y[1:], ATOL)


def _low_pass(facts: Facts) -> bool:
    """Return whether the filter is a low-pass of another kind: it reduces noise, keeps the signal and passes a constant."""
    return (
        facts.noise_gain < LARGEST_NOISE_GAIN
        and facts.signal_error < LARGEST_SIGNAL_ERROR
        and same(facts.constant.y[-1], facts.constant.x[0], CONSTANT_ATOL)
    )


def _default_alone(facts: Facts) -> bool:
    """Return whether only the run without alpha is wrong, as with another default than the sheet's 0.1."""
    *given, default = facts.runs
    return not facts.needs_alpha and all(run.obeys for run in given) and not default.obeys


# ---- the start, and the state


def _from_zero(facts: Facts) -> bool:
    """Return whether the first output follows from a state of zero; False for a high-pass filter, which has the same output."""
    run = facts.runs[0]
    weights = (run.alpha, 1 - run.alpha, 0.0, *(run.weights or ())[:1])
    high_pass = any(_made_of(weights)(facts) for _, fault, weights in WEIGHTS if fault == "high-pass")
    return not run.starts and not high_pass and any(same(run.y[0], w * run.x[0], ATOL) for w in weights)


def ignores_initial(run: Run) -> bool:
    """Return whether the first output shows that the initial value was ignored: the first measurement as it is, or times alpha.

    False if the run was given no initial value, or if its outputs do not depend on the output before.
    """
    if run.weights is None or run.initial is None or abs(run.weights[1]) <= ATOL:
        return False
    places = (run.x[0], run.weights[0] * run.x[0]) if run.initial.any() else (run.x[0],)
    return any(same(run.y[0], place, ATOL) for place in places)


def _initial_ignored(facts: Facts) -> bool:
    """Return whether a given initial value is ignored, while the start without one is right and no state is shared."""
    off = [run for run in facts.from_initial if not run.starts]
    return facts.runs[0].starts and any(map(ignores_initial, off)) and not facts.own.shared


def _if_own(holds: Callable[[Ownership], bool]) -> Callable[[Facts], bool]:
    """Return a test of all facts from a test of who can change a filter's state; False if filters share it anyway."""
    return lambda facts: not facts.own.shared and holds(facts.own)


OF, START, OWN = "follows_recursion", "starts_from_first_measurement", "instances_independent"
REASONS: tuple[Reason[Facts], ...] = (
    *(Reason(OF, cost, fault, _made_of(weights)) for cost, fault, weights in WEIGHTS),
    Reason(OF, 0, "alpha-default", _default_alone),
    Reason(OF, 0, "integer-state", lambda f: f.own.remembers and _every(_has_whole_numbers)(f)),
    Reason(OF, 1, "output-rounded", lambda f: f.own.remembers and all(map(_is_rounded, f.runs))),
    Reason(OF, 2, "output-limited", _every(lambda run: run.obeys or _is_clipped(run))),
    Reason(OF, 3, "output-stuck", _every(lambda run: bool(np.ptp(run.y[1:], axis=0).max() <= ATOL))),
    Reason(OF, 3, "state-not-kept", _every(_from_the_first)),
    Reason(OF, 4, "does-not-filter", _every(_from_one_value)),
    Reason(OF, 5, "does-not-filter", lambda f: not f.own.remembers or _hardly_remembers(f)),
    # A length, a gain an axis, two coefficients, or a matrix is read off the outputs.
    Reason(OF, 6, "filter-restarts", _restarts),
    Reason(OF, 6, "moving-average", _every(_is_moving_average)),
    Reason(OF, 6, "mean-of-all-samples", _every(_is_mean_of_all)),
    Reason(OF, 7, "output-stuck", _hardly_moves),
    Reason(OF, 8, "gain-not-one", lambda f: any(abs(a + b - 1) > 1e-6 for a, b in f.weights)),
    Reason(OF, 9, "alpha-ignored", _ignores_alpha),
    Reason(OF, 10, "axes-mixed", _every(_leaves_axes_out)),
    Reason(OF, 11, "axes-mixed", lambda f: not f.weights and _every(_mixes_axes)(f)),
    Reason(OF, 12, "another-weight", lambda f: bool(f.weights)),
    Reason(OF, 14, "stays-at-times", _stays_at_times),
    Reason(OF, 15, "begins-late", _begins_late),
    Reason(OF, 16, "high-pass", _takes_constants_away),
    Reason(OF, 17, "other-low-pass", _low_pass),
    Reason(OF, 18, f"filtering.{OF}", lambda f: f.needs_alpha is not None),  # which explains no wrong output
    Reason(START, 1, "first-output-missing", lambda f: f.nothing_at_first),
    Reason(START, 2, "zero-initial-state", _from_zero),
    Reason(START, 3, "initial-value-ignored", _initial_ignored),
    Reason(
        START,
        4,
        "initial-value-mixed",
        lambda f: f.runs[0].starts and _every(lambda run: run.obeys)(f) and not f.own.shared,
    ),
    Reason(OWN, 1, "shared-state", lambda f: f.own.shared and f.own.settles(f.own.again)),
    Reason(OWN, 2, "aliased-output", _if_own(lambda own: not same(own.spoilt_output, own.alone, ATOL)), beside=True),
    Reason(OWN, 3, "mutates-input", _if_own(lambda own: own.input_changed), beside=True),
    Reason(OWN, 4, "aliased-output", _if_own(lambda own: own.output_changed), beside=True),
    Reason(OWN, 5, "aliased-input", _if_own(lambda own: not same(own.spoilt_input, own.alone, ATOL)), beside=True),
    Reason("handed_out", 1, "aliased-output", lambda _: True),
    Reason("form", 1, "output-unusable", lambda f: f.odd.startswith(_UNUSABLE)),
    Reason("form", 2, "wrong-return-type", lambda _: True),
    Reason("default", 1, "needs-alpha", lambda _: True),
    *CALL_REASONS,
)


def _handed_out(facts: Facts) -> Deviation[NoNumbers] | None:
    """Return a deviation if filters share a state and return that array itself, which a caller may then change; else None."""
    own = facts.own
    both = own.shared and not own.stumbles and own.settles(own.again) and not own.settles(own.spoilt_output)
    return Deviation({}) if both else None


def _form(facts: Facts) -> Deviation[Form] | None:
    """Return a deviation if outputs are in another form than an array of three; None if only the first is, a fault of the start."""
    odd = facts.odd and not facts.nothing_at_first
    return Deviation({"form": FORM, "came": facts.odd}) if odd else None


def _default(facts: Facts) -> Deviation[Came] | None:
    error = facts.needs_alpha
    if error is None:
        return None
    came = f"{error.type}{f' at {error.where}' if error.where else ''}: {printable(error.message, 200)}"
    return Deviation({"came": came}, size=Size("no filter where no alpha is given"), error=error)


OTHERS: Mapping[str, Measure[Facts]] = {
    "handed_out": _handed_out, "form": _form, "default": _default,
    **departures("LowPassFilter", lambda facts: facts.departs),
}  # fmt: skip
JUDGE: Judge[Facts] = Judge(LAB, "filtering", measure, REASONS, OTHERS)
