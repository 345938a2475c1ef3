"""What was done to a filter's output after the recursion, or to its state: rounded, limited, averaged, handed out too late.

Each is recognised from the output alone, against the sheet's recursion over the same measurements, so that what it changes
elsewhere is known and charged once.
"""

from __future__ import annotations

import itertools

import numpy as np

from grader.labs.imu.compare import Array, same

ATOL = 1e-5
"""m/s². Single precision errs by 1e-6 at 10 m/s² in each of a few operations; the smallest mistake shifts by 1e-3."""

_WHOLE = 1e-9
_DECIMALS = range(5)
"""More are as good as `ATOL`."""
_SETTLED = 1e-6
"""Of the largest difference, after 60 samples: at alpha 0.3 the sheet's filter forgets all but 7e-10 of its state by then."""
_LONGEST = 100
"""Samples that a window is looked for."""


def recursion(alpha: float, x: Array, start: Array) -> Array:
    """The sheet's recursion over x (n, 3), whose first output is `start` (3,)."""
    steps = itertools.accumulate(x[1:], lambda y, sample: alpha * sample + (1 - alpha) * y, initial=start)
    return np.array(list(steps))


def grain(alpha: float, x: Array, y: Array) -> float:
    """What the recursion's output or its state was rounded to, cut off to, or stored with; 0 where it was not.

    A rounded output differs from the recursion by one grain at most, and the start that it is judged from by one more; a
    rounded state obeys the recursion from each output to the next within one.
    """
    if not np.ptp(y, axis=0).any():
        return 0.0
    for size in _grains(y[1:]):  # the first may be the measurement itself
        output = same(y, recursion(alpha, x, y[0]), 2 * size)
        if output or same(y[1:], alpha * x[1:] + (1 - alpha) * y[:-1], size + ATOL):
            return size
    return 0.0


def _grains(y: Array) -> list[float]:
    """The steps that all of these numbers are multiples of: decimals, and those of half precision."""
    steps = [10.0**-d for d in _DECIMALS if np.abs(y - y.round(d)).max() < _WHOLE]
    if np.abs(y).max() < 1e4 and np.abs(y - y.astype(np.float16)).max() < _WHOLE:
        steps.append(float(np.spacing(np.float16(np.abs(y).max()))))
    return steps


def limits(alpha: float, x: Array, y: Array) -> tuple[float, float] | None:
    """Between what the recursion's output was cut off, if it was, nothing else is wrong, and most of it is left."""
    low, high = float(y.min()), float(y.max())
    whole = recursion(alpha, x, x[0])
    cut = np.clip(whole, low, high)
    left = float(np.mean(np.abs(whole - cut) <= ATOL))
    return (low, high) if same(y, cut, ATOL) and 0.5 < left < 1 else None


def window(x: Array, y: Array) -> int:
    """How many samples each output is the mean of, once there are so many; 0 where it is no such mean."""
    sums = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x, axis=0)])
    for size in range(1, min(_LONGEST, len(x) // 2) + 1):
        if same(y[size:], (sums[size + 1 :] - sums[1:-size]) / size, ATOL):
            return size
    return 0


def one_behind(alpha: float, x: Array, y: Array) -> bool:
    """Whether each output is the one that belongs to the measurement before."""
    return same(y[2:], alpha * x[1:-1] + (1 - alpha) * y[1:-1], ATOL)


def settles(difference: Array) -> bool:
    """Whether two outputs (n, 3) for the same measurements grow alike, as those do that only start from different states."""
    return bool(np.abs(difference[-1]).max() <= ATOL + _SETTLED * np.abs(difference).max())
