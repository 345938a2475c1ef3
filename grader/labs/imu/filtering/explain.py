"""Why a filter's outputs are not the sheet's: hypotheses over its recursion, its start and its state."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from grader.engine.charging import Part
from grader.engine.findings import Deviation, Size
from grader.engine.hypothesis import Reason
from grader.ground.text import printable
from grader.labs.imu.compare import Array, same
from grader.labs.imu.filtering.measure import ATOL, FORM, Facts, Run, measure
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import departure, reads_global

LARGEST_NOISE_GAIN = 0.95
"""Of the variance. The sheet's filter leaves alpha / (2 - alpha) = 0.11 for alpha 0.2, averaging two samples 0.5; no filter 1."""
LARGEST_SIGNAL_ERROR = 0.5
"""Of the signal's spread. The sheet's filter errs by 0.13 at this period; one that loses the signal by 1."""
CONSTANT_ATOL = 1e-3
"""m/s². After 300 samples at alpha 0.2 the sheet's filter is at the constant to 1e-28; the smallest fault shifts by more."""
_NOTHING_LEFT = 1e-3
"""Of a constant. A high-pass filter leaves nothing of it."""
_WHOLE = 1e-9
_DECIMALS = range(5)
"""Decimals of a rounding that are looked for; a finer one stays below `ATOL`."""
_LONGEST = 100
"""Samples that a window is looked for."""
_NOW_AND_THEN = 0.2
"""Of all outputs: one that is the measurement more often is no recursion that starts again."""
_FEWEST = 6
"""Outputs that have to be the sheet's where the others stay."""


def recursion(alpha: float, x: Array, start: Array) -> Array:
    """The sheet's recursion over x (n, 3), whose first output is `start` (3,)."""
    steps = itertools.accumulate(x[1:], lambda y, sample: alpha * sample + (1 - alpha) * y, initial=start)
    return np.array(list(steps))


def _every(holds: Callable[[float, Array, Array], bool]) -> Callable[[Facts], bool]:
    return lambda facts: all(holds(run.alpha, run.x, run.y) for run in facts.runs)


# ---- what is done to the recursion's outputs


def _rounded(run: Run) -> bool:
    """Whether an output is the sheet's, rounded, cut off to digits, or of half precision; or its state is.

    A rounded output differs from the recursion by one grain at most, and the start that it is judged from by one more; a
    rounded state obeys the recursion from each output to the next within one.
    """
    return bool(np.ptp(run.y, axis=0).any()) and any(
        same(run.y, recursion(run.alpha, run.x, run.y[0]), 2 * grain) or bool(np.all(run.off <= grain + ATOL))
        for grain in _grains(run.y[1:])  # the first may be the measurement itself
    )


def _grains(y: Array) -> list[float]:
    """The steps that all of these numbers are multiples of: decimals, and those of half precision."""
    steps = [10.0**-d for d in _DECIMALS if np.abs(y - y.round(d)).max() < _WHOLE]
    if np.abs(y).max() < 1e4 and np.abs(y - y.astype(np.float16)).max() < _WHOLE:
        steps.append(float(np.spacing(np.float16(np.abs(y).max()))))
    return steps


def _limited(run: Run) -> bool:
    """Whether outputs are the sheet's within two limits, and most of them lie within."""
    whole = recursion(run.alpha, run.x, run.x[0])
    cut = np.clip(whole, run.y.min(), run.y.max())
    return same(run.y, cut, ATOL) and 0.5 < float(np.mean(np.abs(whole - cut) <= ATOL)) < 1


def _one_behind(alpha: float, x: Array, y: Array) -> bool:
    return same(y[2:], alpha * x[1:-1] + (1 - alpha) * y[1:-1], ATOL)


# ---- other recursions


def _obey(facts: Facts, weight: Callable[[float], float]) -> bool:
    """Whether each measurement has this weight, and the output before has the rest."""
    return _every(lambda alpha, x, y: same(y[1:], weight(alpha) * x[1:] + (1 - weight(alpha)) * y[:-1], ATOL))(facts)


def _ignores_alpha(facts: Facts) -> bool:
    weights = [a for a, _ in facts.weights]
    return bool(weights) and max(weights) - min(weights) < 1e-6 and len({run.alpha for run in facts.runs}) > 1


def _high_pass(alpha: float, x: Array, y: Array) -> bool:
    """``y[n] = c (y[n-1] + x[n] - x[n-1])``, which the input without its low-passed part obeys as well."""
    return any(same(y[1:], c * (y[:-1] + x[1:] - x[:-1]), ATOL) for c in (alpha, 1 - alpha))


def _takes_constants_away(facts: Facts) -> bool:
    left = np.abs(facts.constant.y[-1]).max() < _NOTHING_LEFT * np.abs(facts.constant.x[0]).max()
    return bool(left) and not facts.signal_error < LARGEST_SIGNAL_ERROR


def _from_the_first(alpha: float, x: Array, y: Array) -> bool:
    """Whether every output is a mean of the measurement and the first one, whichever has the weight alpha."""
    return any(same(y[1:], w * x[1:] + (1 - w) * x[0], ATOL) for w in (alpha, 1 - alpha))


def _from_one_value(alpha: float, x: Array, y: Array) -> bool:
    """Whether every output is a mean of the measurement and one value that never changes, whichever has the weight alpha."""
    return any(np.ptp(y[1:] - w * x[1:], axis=0).max() <= ATOL for w in (alpha, 1 - alpha))


def _input_history(alpha: float, x: Array, y: Array) -> bool:
    return any(same(y[1:], c * x[1:] + (1 - c) * x[:-1], ATOL) for c in (alpha, 1 - alpha))


def _restarts(facts: Facts) -> bool:
    """Whether the recursion holds, but that now and then the output is the measurement again, as at the start."""
    off = [run.off > ATOL for run in facts.runs]
    again = [np.abs(run.y[1:] - run.x[1:]).max(axis=1) <= ATOL for run in facts.runs]
    seldom = all(o.mean() < _NOW_AND_THEN and a[o].all() for o, a in zip(off, again, strict=True))
    return seldom and any((o[1:] & ~o[:-1]).any() for o in off)  # after it had begun


def _stays_at_times(facts: Facts) -> bool:
    """Whether the recursion holds, but that at times the output stays where it was, whatever the measurement is."""
    off = [run.off > ATOL for run in facts.runs]
    stay = (np.abs(np.diff(run.y, axis=0)[o]).max(initial=0.0) <= ATOL for run, o in zip(facts.runs, off, strict=True))
    return all(np.sum(~o) >= _FEWEST for o in off) and all(stay)


def _begins_late(facts: Facts) -> bool:
    """Whether the recursion holds after the first outputs, a third of all at most."""
    off = [run.off > ATOL for run in facts.runs]
    last = [int(np.flatnonzero(o)[-1]) + 1 if o.any() else 0 for o in off]
    return any(last) and all(end <= len(o) // 3 and o[:end].all() for end, o in zip(last, off, strict=True))


def _window(x: Array, y: Array) -> int:
    """How many samples each output is the mean of, once there are so many; 0 where it is no such mean."""
    sums = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x, axis=0)])
    for size in range(1, min(_LONGEST, len(x) // 2) + 1):
        if same(y[size:], (sums[size + 1 :] - sums[1:-size]) / size, ATOL):
            return size
    return 0


def _averages(facts: Facts) -> bool:
    sizes = [_window(run.x, run.y) for run in facts.runs]
    return min(sizes) >= 1 and max(sizes) >= 2


def _leaves_axes_out(alpha: float, x: Array, y: Array) -> bool:
    """Whether some axes obey the recursion, and the others come out as they are or never move."""
    right = [same(y[1:, i], alpha * x[1:, i] + (1 - alpha) * y[:-1, i], ATOL) for i in range(3)]
    left = (same(y[1:, i], x[1:, i], ATOL) or np.ptp(y[1:, i]) <= ATOL for i in range(3) if not right[i])
    return any(right) and not all(right) and all(left)


def _mixes_axes(_: float, x: Array, y: Array) -> bool:
    """Whether the outputs follow from all axes together, but not from each by itself."""
    columns = np.concatenate([x[1:], y[:-1]], axis=1)
    weights, *_rest = np.linalg.lstsq(columns, y[1:], rcond=None)
    apart = ~np.tile(np.eye(3, dtype=bool), (2, 1))
    return bool(np.abs(weights[apart]).max() > 1e-3) and same(columns @ weights, y[1:], ATOL)


def _low_pass(facts: Facts) -> bool:
    return (
        facts.noise_gain < LARGEST_NOISE_GAIN
        and facts.signal_error < LARGEST_SIGNAL_ERROR
        and same(facts.constant.y[-1], facts.constant.x[0], CONSTANT_ATOL)
    )


def _default_alone(facts: Facts) -> bool:
    *given, default = facts.runs
    return not facts.needs_alpha and all(run.obeys for run in given) and not default.obeys


# ---- the start, and the state


def _from_zero(facts: Facts) -> bool:
    """Whether the first output is what comes of zero before it; a high-pass filter lets that through at first, too."""
    run = facts.runs[0]
    weights = (run.alpha, 1 - run.alpha, 0.0, *(run.weights or ())[:1])
    return not run.starts and any(same(run.y[0], w * run.x[0], ATOL) for w in weights) and not _every(_high_pass)(facts)


def ignores_initial(run: Run) -> bool:
    """Whether the first output is what comes of the first measurement alone, or of zero in the initial value's place."""
    if run.weights is None or run.initial is None or abs(run.weights[1]) <= ATOL:
        return False
    places = (run.x[0], run.weights[0] * run.x[0]) if run.initial.any() else (run.x[0],)
    return any(same(run.y[0], place, ATOL) for place in places)


def _initial_ignored(facts: Facts) -> bool:
    off = [run for run in facts.from_initial if not run.starts]
    return facts.runs[0].starts and any(map(ignores_initial, off)) and not facts.own.shared


OF, START, OWN = "follows_recursion", "starts_from_first_measurement", "instances_independent"
FOLLOWS = frozenset({START, "passes_constant", "reduces_noise", "preserves_signal", OWN})
"""What an output that obeys another recursion may miss, too."""


def _of_recursion(cost: int, told: str, holds: Callable[[Facts], bool]) -> Reason[Facts]:
    return Reason(OF, cost, told, holds, FOLLOWS)


REASONS: tuple[Reason[Facts], ...] = (
    # Nothing is read off the outputs but a step or two limits.
    _of_recursion(0, "alpha-default", _default_alone),
    _of_recursion(1, "output-rounded", lambda f: f.own.remembers and all(map(_rounded, f.runs))),
    _of_recursion(2, "output-limited", lambda f: all(run.obeys or _limited(run) for run in f.runs)),
    # No number is left free, or a constant.
    _of_recursion(3, "alpha-swapped", lambda f: _obey(f, lambda alpha: 1 - alpha)),
    _of_recursion(3, "no-filtering", _every(lambda _, x, y: same(y[1:], x[1:], ATOL))),
    _of_recursion(3, "output-stuck", _every(lambda _a, _x, y: bool(np.ptp(y[1:], axis=0).max() <= ATOL))),
    _of_recursion(3, "state-not-kept", _every(_from_the_first)),
    _of_recursion(3, "filters-input-history", _every(_input_history)),
    _of_recursion(3, "high-pass", _every(_high_pass)),
    Reason(OF, 4, "state-not-kept", _every(_from_one_value), FOLLOWS, FOLLOWS - {OWN}),
    # The measurements before are not seen in what comes out.
    _of_recursion(5, "does-not-filter", lambda f: not f.own.remembers),
    # A length, a gain an axis, two coefficients, or a matrix is read off the outputs.
    _of_recursion(6, "filter-restarts", _restarts),
    _of_recursion(6, "moving-average", _averages),
    _of_recursion(7, "gain-not-one", lambda f: any(abs(a + b - 1) > 1e-6 for a, b in f.weights)),
    _of_recursion(8, "alpha-ignored", _ignores_alpha),
    _of_recursion(9, "axes-mixed", _every(_leaves_axes_out)),
    _of_recursion(10, "axes-mixed", lambda f: not f.weights and _every(_mixes_axes)(f)),
    _of_recursion(11, "updates-twice", lambda f: _obey(f, lambda alpha: 1 - (1 - alpha) ** 2)),
    _of_recursion(12, "another-weight", lambda f: bool(f.weights)),
    _of_recursion(13, "one-behind", _every(_one_behind)),
    _of_recursion(14, "stays-at-times", _stays_at_times),
    _of_recursion(15, "begins-late", _begins_late),
    _of_recursion(16, "high-pass", _takes_constants_away),
    _of_recursion(17, "other-low-pass", _low_pass),
    _of_recursion(99, f"filtering.{OF}", lambda _: True),
    Reason(START, 1, "wrong-return-type", lambda f: f.nothing_at_first),
    Reason(START, 2, "zero-initial-state", _from_zero),
    Reason(START, 3, "initial-value-ignored", _initial_ignored),
    Reason(
        START, 4, "initial-value-mixed", lambda f: f.runs[0].starts and all(run.obeys for run in f.runs) and _is_own(f)
    ),
    Reason(OWN, 1, "shared-state", lambda f: f.own.shared and f.own.repeats, frozenset({START})),
    Reason(OWN, 2, "aliased-output", lambda f: _is_own(f) and not same(f.own.spoilt_output, f.own.alone, ATOL)),
    Reason(OWN, 3, "mutates-input", lambda f: _is_own(f) and f.own.input_changed),
    Reason(OWN, 4, "aliased-output", lambda f: _is_own(f) and f.own.output_changed),
    Reason(OWN, 5, "aliased-input", lambda f: _is_own(f) and not same(f.own.spoilt_input, f.own.alone, ATOL)),
    Reason("form", 1, "wrong-return-type", lambda _: True),
    Reason("default", 1, "needs-alpha", lambda _: True),
    Reason("parameters", 1, "global-for-parameter", lambda f: reads_global(f.departs)),
    Reason("parameters", 2, "other-parameters", lambda _: True),
)


def _is_own(facts: Facts) -> bool:
    return not facts.own.shared


def _form(facts: Facts) -> Deviation | None:
    """Another form that a vector could be made out of; nothing at first alone is the start's."""
    odd = facts.odd and not facts.nothing_at_first
    return Deviation({"form": FORM, "came": facts.odd}) if odd else None


def _default(facts: Facts) -> Deviation | None:
    fault = facts.needs_alpha
    if fault is None:
        return None
    came = f"{fault.type}{f' at {fault.where}' if fault.where else ''}: {printable(fault.message, 200)}"
    return Deviation({"came": came}, size=Size("no filter where no alpha is given"), fault=fault)


PART: Part[Facts] = Part(
    LAB,
    "filtering",
    measure,
    REASONS,
    {"form": _form, "default": _default, "parameters": lambda facts: departure("LowPassFilter", facts.departs)},
)
