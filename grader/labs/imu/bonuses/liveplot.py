"""Facts about the curves of a live plot: growth against simulated time, and the channels that they follow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grader.labs.imu.compare import Array

_EXACT = 1e-3
"""m/s², rad/s. Simulations on two machines differ by 1e-6 here; neighbouring channels by far more."""
_NOISY = np.array([0.9, 0.1])
"""m/s², rad/s. What the sheet's noise and bias add at most, once in a billion readings: 6 × 0.05 + 6 × 0.1 and a tenth of it."""
_LONGEST_STRIDE = 60
_FEWEST = 8  # readings in a row that are no coincidence
_LATEST = 1e6  # s; beyond, nothing is a time of this simulation
_OWN_ROWS = 0.25
"""Least share of rows among a curve's points: 1 for a curve of all readings, 1/3 where each is drawn three times. Where seconds are
taken for milliseconds it is 1/1000, and 1/16 of every sixtieth reading: those rows are all of a robot at rest, and any
line is near them."""
_SCALES = (1.0, float(np.degrees(1.0)))


def updates(events: Array) -> int:
    """Return at how many moments of the simulation the curves had changed.

    Parameters
    ----------
    events : (k, 3) ndarray, each change of the curves: seconds simulated, points drawn, changes so far
    """
    return len(np.unique(events[events[:, 0] > 0, 0]))


def changes_after(events: Array) -> int:
    """Return how often the curves changed after the simulation had ended."""
    return int(np.count_nonzero(events[:, 0] == events[:, 0].max())) if len(events) else 0


def span(events: Array) -> float:
    """Simulated time (s) between the first and the last change of the curves."""
    return float(np.ptp(events[:, 0])) if len(events) else 0.0


def shows(x: Array, y: Array, channels: Array, dt: float) -> bool:
    """Return whether a curve (n,) follows a true channel (m, c): three of an accelerometer and three of a gyroscope in turn.

    Angular velocity may be drawn in degrees per second; noise and bias as on the sheet may be on the first IMU's readings.
    """
    finite = np.isfinite(x) & np.isfinite(y)
    x, y = x[finite], y[finite]
    if any(_noisy(y[inside], channels[row]) for inside, row in _rows(x, len(channels), dt)):
        return True
    return any(_by_time(x, y / scale, channels, dt) or _by_order(y / scale, channels) for scale in _SCALES)


def _rows(x: Array, count: int, dt: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Match points (mask) to rows, where x is time in s or ms, stamped before or after the step."""
    for unit in (1.0, 1e-3):
        for shift in (-1, 0):
            row = np.round(np.clip(x * unit, -_LATEST, _LATEST) / dt).astype(np.int64) + shift
            inside = (row >= 0) & (row < count)
            many = inside.sum() >= max(3, 0.9 * len(x))
            if many and len(np.unique(row[inside])) > _OWN_ROWS * inside.sum():
                yield inside, row[inside]


def _by_time(x: Array, y: Array, channels: Array, dt: float) -> bool:
    return any(
        bool(np.any(np.abs(channels[row] - y[inside, None]).max(axis=0) <= _EXACT))
        for inside, row in _rows(x, len(channels), dt)
    )


def _noisy(y: Array, truth: Array) -> bool:
    """Return whether y (n,) is one of the first six columns of truth (n, c), but for noise; a flat line shows none."""
    own, limits = truth[:, :6], np.repeat(_NOISY, 3)
    close = np.abs(own - y[:, None]).max(axis=0) <= limits
    moving = own.std(axis=0) > limits / 3
    return bool(np.any(close & np.where(moving, _correlation(y, own) > 0.8, np.std(y) > 10 * _EXACT)))


def _correlation(y: Array, truth: Array) -> Array:
    a, b = y - y.mean(), truth - truth.mean(axis=0)
    power = np.sqrt((a**2).sum() * (b**2).sum(axis=0))
    return np.asarray((a @ b) / np.where(power > 0, power, np.inf))


def _by_order(y: Array, channels: Array) -> bool:
    """Return whether y (n,) ends in every s-th reading of a channel in order, for some s, whatever its x values are.

    Points before the channel's first reading do not count: the code filled them in.
    """
    if len(y) < _FEWEST or np.ptp(y[-_FEWEST:]) <= 10 * _EXACT:
        return False  # a flat line is like any channel that rests
    return any(_in_order(y, column) for column in channels.T)


def _in_order(y: Array, column: Array) -> bool:
    ends = np.flatnonzero(np.abs(column - y[-1]) <= _EXACT)[:, None]
    strides = np.arange(1, _LONGEST_STRIDE + 1)
    fits = ends - (_FEWEST - 1) * strides >= 0
    for back in range(1, _FEWEST):
        place = np.where(fits, ends - back * strides, 0)
        fits &= np.abs(column[place] - y[-1 - back]) <= _EXACT
    return any(_all_in_order(y, column, int(ends[row, 0]), int(strides[which])) for row, which in np.argwhere(fits))


def _all_in_order(y: Array, column: Array, end: int, stride: int) -> bool:
    steps = min(len(y), end // stride + 1)
    return bool(np.abs(y[::-1][:steps] - column[end - stride * np.arange(steps)]).max() <= _EXACT)
