"""What a filter does, told from its outputs: the recursion that they obey, whatever they started from.

An output is held against its own previous value: ``y[n] - (a x[n] + b y[n-1])`` says whether the recursion is right even where the
start is not, so that each of the two faults is seen for itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from grader.engine.hypothesis import Named, mistakes_of
from grader.labs.imu.compare import Array, same
from grader.labs.imu.diagnosis.filter_outputs import ATOL, window

_AWAY = 1e4
"""m/s², rad/s. No measurement of the lab's comes near; beyond it a sum loses the digits that are compared."""
_FEWEST = 6
"""Outputs that tell two coefficients, with more equations than unknowns."""
_COUNTS = 0.01
"""Of a weight: less than a tenth of the smallest that is asked for is as good as nothing."""
_NOW_AND_THEN = 0.2
"""Of all outputs: one that is the measurement more often is no recursion that starts again."""


def obeys(x: Array, y: Array, a: float, b: float) -> bool:
    """Whether ``y[n] = a x[n] + b y[n-1]`` holds from the second sample on; x, y (n, 3)."""
    return same(y[1:], a * x[1:] + b * y[:-1], ATOL)


def runs_away(x: Array, y: Array) -> bool:
    """Whether a recursion into which measurements go grows by itself, so that these are soon not seen in what comes out."""
    found = recursion_of(x, y)
    return found is not None and abs(found[0]) > _COUNTS and abs(found[1]) > 1 + _COUNTS


def recursion_of(x: Array, y: Array) -> tuple[float, float] | None:
    """The coefficients (a, b) of ``y[n] = a x[n] + b y[n-1]`` that all axes obey, or None; until the output has run away."""
    away = np.abs(y).max(axis=1) > _AWAY
    end = int(away.argmax()) if away.any() else len(y)
    x, y = x[:end], y[:end]
    if len(y) < _FEWEST:
        return None
    columns = np.stack([x[1:].ravel(), y[:-1].ravel()], axis=1)
    (a, b), *_ = np.linalg.lstsq(columns, y[1:].ravel(), rcond=None)
    return (float(a), float(b)) if obeys(x, y, a, b) else None


def has_no_memory(x: Array, y: Array) -> bool:
    """Whether every output follows from its own measurement alone: ``y[n] = a x[n] + c``, one a and c an axis; x, y (n, 3).

    A recursion with a weight of 1e-3 for what was before differs from that by far more than `ATOL`.
    """
    centred_x, centred_y = x[1:] - x[1:].mean(axis=0), y[1:] - y[1:].mean(axis=0)
    gains = (centred_x * centred_y).sum(axis=0) / np.maximum((centred_x**2).sum(axis=0), 1e-300)
    return bool(np.ptp(y[1:], axis=0).any()) and same(centred_y, gains * centred_x, ATOL)


def keeps_the_first(alpha: float, x: Array, y: Array) -> bool:
    """Whether every output is the sheet's from the first measurement, whichever of the two has the weight alpha; x, y (n, 3)."""
    return any(same(y, weight * x + (1 - weight) * x[0], ATOL) for weight in (alpha, 1 - alpha))


Run = tuple[float, Array, Array]
"""alpha, input (n, 3), output (n, 3)"""


Runs = Sequence[Run]


def mistakes(runs: Runs) -> list[str]:
    """The one mistake that predicts every run, or nothing."""
    return mistakes_of(_HYPOTHESES, runs)


def _off(run: Run) -> NDArray[np.bool_]:
    """(n - 1,) ndarray, which outputs from the second on are not the sheet's from the one before."""
    alpha, x, y = run
    return np.asarray(np.abs(y[1:] - alpha * x[1:] - (1 - alpha) * y[:-1]).max(axis=1) > ATOL, bool)


def stays_at_times(runs: Runs) -> bool:
    """Whether the recursion holds, but that at times the output stays where it was, whatever the measurement is."""
    off = [_off(run) for run in runs]
    stay = (np.abs(np.diff(y, axis=0)[o]).max(initial=0.0) <= ATOL for (*_, y), o in zip(runs, off, strict=True))
    return any(map(np.any, off)) and all(np.sum(~o) >= _FEWEST for o in off) and all(stay)


def begins_late(runs: Runs) -> bool:
    """Whether the recursion holds after the first outputs, a third of all at most."""
    last = [int(np.flatnonzero(off)[-1]) + 1 if off.any() else 0 for off in map(_off, runs)]
    seldom = all(end <= len(y) // 3 for end, (*_, y) in zip(last, runs, strict=True))
    whole = all(_off(run)[:end].all() for end, run in zip(last, runs, strict=True))
    return any(last) and seldom and whole


def _linear(runs: Runs) -> list[tuple[float, float]]:
    """The coefficients of each run, where every run is a recursion; else nothing."""
    fitted = [f for _, x, y in runs if (f := recursion_of(x, y)) is not None]
    return fitted if len(fitted) == len(runs) else []


def _gain_not_one(runs: Runs) -> bool:
    return any(abs(a + b - 1) > 1e-6 for a, b in _linear(runs))


def _alpha_ignored(runs: Runs) -> bool:
    weights = [a for a, _ in _linear(runs)]
    return bool(weights) and max(weights) - min(weights) < 1e-6 and len({alpha for alpha, *_ in runs}) > 1


def _stuck(alpha: float, x: Array, y: Array) -> bool:
    del alpha, x
    return bool(np.ptp(y[1:], axis=0).max() <= ATOL)


def _high_pass(alpha: float, x: Array, y: Array) -> bool:
    """``y[n] = c (y[n-1] + x[n] - x[n-1])``, which the input without its low-passed part obeys as well."""
    return any(same(y[1:], c * (y[:-1] + x[1:] - x[:-1]), ATOL) for c in (alpha, 1 - alpha))


def _from_one_value(weight: float, x: Array, y: Array) -> bool:
    """``y[n] = weight x[n] + c``: what came before never changes, so the recursion always starts from the same value."""
    rest = y[1:] - weight * x[1:]
    return bool(np.ptp(rest, axis=0).max() <= ATOL)


def _restarts(runs: Runs) -> bool:
    """Whether the recursion holds, but that now and then the output is the measurement again, as at the start."""
    off = [_off(run) for run in runs]
    again = [np.abs(y[1:] - x[1:]).max(axis=1) <= ATOL for _, x, y in runs]
    seldom = all(o.mean() < _NOW_AND_THEN and a[o].all() for o, a in zip(off, again, strict=True))
    return seldom and any((o[1:] & ~o[:-1]).any() for o in off)  # after it had begun


def _averages(runs: Sequence[Run]) -> bool:
    sizes = [window(x, y) for _, x, y in runs]
    return min(sizes) >= 1 and max(sizes) >= 2


def _leaves_axes_out(alpha: float, x: Array, y: Array) -> bool:
    """Whether some axes obey the recursion, and the others come out as they are or never move."""
    right = [obeys(x[:, [i]], y[:, [i]], alpha, 1 - alpha) for i in range(3)]
    others = [i for i in range(3) if not right[i]]
    left = (same(y[1:, i], x[1:, i], ATOL) or np.ptp(y[1:, i]) <= ATOL for i in others)
    return any(right) and bool(others) and all(left)


def _mixes_axes(x: Array, y: Array) -> bool:
    """Whether the outputs follow from all axes together, but not from each by itself."""
    n = x.shape[1]
    columns = np.concatenate([x[1:], y[:-1]], axis=1)
    weights, *_ = np.linalg.lstsq(columns, y[1:], rcond=None)
    apart = ~np.tile(np.eye(n, dtype=bool), (2, 1))
    crossed = np.abs(weights[apart]).max() > 1e-3
    return bool(crossed) and same(columns @ weights, y[1:], ATOL)


def _every(predicts: Callable[[float, Array, Array], bool]) -> Callable[[Runs], bool]:
    return lambda runs: all(predicts(*run) for run in runs)


_HYPOTHESES: list[Named[Runs]] = [
    # No number is left free, or a constant.
    Named(1, "alpha-swapped", _every(lambda alpha, x, y: obeys(x, y, 1 - alpha, alpha))),
    Named(1, "no-filtering", _every(lambda _, x, y: same(y[1:], x[1:], ATOL))),
    Named(1, "output-stuck", _every(_stuck)),
    Named(1, "state-not-kept", _every(_from_one_value)),
    Named(1, "state-not-kept", _every(lambda alpha, x, y: _from_one_value(1 - alpha, x, y))),
    Named(1, "filters-input-history", _every(lambda c, x, y: same(y[1:], c * x[1:] + (1 - c) * x[:-1], ATOL))),
    Named(1, "filters-input-history", _every(lambda c, x, y: same(y[1:], (1 - c) * x[1:] + c * x[:-1], ATOL))),
    Named(1, "high-pass", _every(_high_pass)),
    # A length, a gain an axis, two coefficients, or a matrix is read off the outputs.
    Named(2, "filter-restarts", _restarts),
    Named(2, "moving-average", _averages),
    Named(3, "does-not-filter", _every(lambda _, x, y: has_no_memory(x, y))),
    Named(4, "gain-not-one", _gain_not_one),
    Named(5, "alpha-ignored", _alpha_ignored),
    Named(6, "axes-mixed", _every(_leaves_axes_out)),
    Named(7, "axes-mixed", lambda runs: not _linear(runs) and all(_mixes_axes(x, y) for _, x, y in runs)),
]


def noise_gain(x: Array, y: Array) -> float:
    """Variance of the output's sample-to-sample part over that of the input, second half of the series."""
    half = len(x) // 2
    return float(np.var(y[half:], axis=0).mean() / np.var(x[half:], axis=0).mean())


def signal_error(x: Array, y: Array) -> float:
    """RMS of output minus a slow input, in units of the input's own spread, second half of the series."""
    half = len(x) // 2
    return float(np.sqrt(np.mean((y[half:] - x[half:]) ** 2)) / np.sqrt(np.mean(np.var(x[half:], axis=0))))


def share_of_signal(y: Array, period: int) -> float:
    """The share of the output's deviation from a straight line that swings with a period, at whatever size and lag.

    Second half of the series; of the axis that has most of it, and 0 where the output stays the same.
    """
    late = y[len(y) // 2 :]
    phase = 2 * np.pi * np.arange(len(late)) / period
    line, waves = np.stack([np.ones_like(phase), phase], axis=1), np.stack([np.sin(phase), np.cos(phase)], axis=1)
    whole, rest = _rest(late, line), _rest(late, np.concatenate([line, waves], axis=1))
    return float(np.max(1 - rest[whole > ATOL] / whole[whole > ATOL], initial=0.0))


def _rest(y: Array, columns: Array) -> Array:
    """The standard deviation of each axis that no sum of the columns explains."""
    weights, *_ = np.linalg.lstsq(columns, y, rcond=None)
    return np.asarray(np.std(y - columns @ weights, axis=0))
