"""Measure and show how far arrays of numbers are apart; whether that loses points is for the checks to decide."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SHEETS_NOISE = (0.05, 0.0051)
"""m/s², rad/s: the standard deviations of Step 5; the second with room for the last digit of what was rounded to 0.01 rad/s."""


NO_CHANGE = 1e-12
"""Largest change of the simulation's data by a read, in its own units. Nothing has to change; the margin is for an mj_forward."""
SENSOR_NAMES, BOTH = ("accel", "gyro"), (0, 1)
"""Short names and indices of the accelerometer and the gyroscope."""


@dataclass(frozen=True)
class Deviation:
    """Distance of an array of answers from the expected array.

    Attributes
    ----------
    worst : largest absolute difference; infinite where a difference is not finite
    row : index of the row that has the largest difference
    rms : root mean square of the finite differences; infinite if none is finite
    """

    worst: float
    row: int
    rms: float


def deviation(got: Array, expected: Array) -> Deviation:
    """Measure the distance of returned numbers (n, …) from the true ones in the rows that both have; 0 if they share no row."""
    n = min(len(got), len(expected))
    with np.errstate(over="ignore"):  # numbers near the limit differ by infinity, which says it well
        return _deviation(np.abs(np.asarray(got[:n], float) - np.asarray(expected[:n], float)))


def _deviation(difference: Array) -> Deviation:
    finite = np.isfinite(difference)
    worst_per_row = np.where(finite, difference, np.inf).reshape(len(difference), -1).max(axis=1, initial=0.0)
    row = int(np.argmax(worst_per_row)) if len(worst_per_row) else 0
    rms = float(np.sqrt(np.mean(difference[finite] ** 2))) if finite.any() else float("inf")
    return Deviation(float(worst_per_row[row]) if len(worst_per_row) else 0.0, row, rms)


def same(got: Array, expected: Array, atol: float) -> bool:
    """Return whether two arrays have one shape and agree in every number within `atol`; False if they are empty or hold NaN."""
    if got.shape != expected.shape or got.size == 0:
        return False
    return bool(np.all(np.abs(got - expected) <= atol))


def same_where_known(got: Array, expected: Array, atol: float) -> bool:
    """Return whether every finite number of `got` agrees with `expected` within `atol`; False if no number is finite."""
    known = np.isfinite(got)
    return bool(known.any()) and bool(np.all(np.abs(got[known] - expected[known]) <= atol))


def share_among(values: Array, others: Array, atol: float) -> float:
    """Return the share of `values` that occur anywhere among `others`, within `atol`, to recognise rows in another order."""
    there, sought = np.sort(others, axis=None), values.ravel()
    at = np.clip(np.searchsorted(there, sought), 1, len(there) - 1)
    return float(np.mean(np.minimum(np.abs(there[at] - sought), np.abs(there[at - 1] - sought)) <= atol))


def thinned(n: int, most: int = 200) -> NDArray[np.intp]:
    """Return the indices of at most `most` of n points, with the first and the last, so that a chart of a long run stays small."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(np.intp))


def triple(rows: Array, first: int) -> Array:
    """Return columns ``first:first+3`` of `rows` as (k, 3) for a true or guessed `first`: NaN past the last, only NaN if < 0."""
    out = np.full((len(rows), 3), np.nan)
    part = rows[:, first : first + 3] if first >= 0 else rows[:, :0]
    out[:, : part.shape[1]] = part
    return out


_NEVER_WRITTEN = 0x7FF8_0000_0000_0000 | 0x2A5A5 << 29
"""Bits of the NaN that the worker puts into arrays of `np.empty`: `grader.worker.repeatability.NEVER_WRITTEN`."""


def never_written(values: Array) -> NDArray[np.bool_]:
    """Return a mask of the values that the student's code never wrote: the worker fills arrays of `np.empty` with a special NaN."""
    return np.asarray(np.ascontiguousarray(values, dtype=np.float64).view(np.uint64) == _NEVER_WRITTEN)


def not_finite_in_words(values: Array) -> str:
    """Say for a message what in `values` is not finite: memory never written if `never_written` finds any, else NaN or infinity."""
    return "memory that was never written (np.empty)" if never_written(values).any() else "NaN or infinity"


def vector(values: Array, digits: int = 3) -> str:
    """Format a vector with `digits` decimals: ``[ 0.412 -0.031 -9.702]``; with powers of ten if all are small or one is huge."""
    array = np.asarray(values, float)
    if array.ndim == 1 and (unset := never_written(array)).any():
        parts = ["never written" if is_unset else f"{x:.{digits}f}" for x, is_unset in zip(array, unset, strict=True)]
        return f"[{', '.join(parts)}]"
    # Without powers of ten, at least two digits of the largest number have to be left.
    plain = bool(np.max(np.abs(array), initial=0.0) >= 10.0 ** (1 - digits))
    return np.array2string(array, precision=digits, suppress_small=plain, floatmode="fixed", max_line_width=100)


def distinct_texts(wanted: Array, got: Array) -> tuple[str, str]:
    """Format two vectors for a message with the fewest decimals, at least three, in which they differ; three if they never do."""
    pairs = ((vector(wanted, decimals), vector(got, decimals)) for decimals in range(3, 17))
    return next((pair for pair in pairs if pair[0] != pair[1]), (vector(wanted), vector(got)))


def changed(disturbance: Array) -> NDArray[np.bool_]:
    """Return a mask (4,): which of time, qpos, qvel, sensordata a call changed, from the sizes of the changes (NaN: changed)."""
    return np.asarray(~(disturbance <= NO_CHANGE))


def changes_in_words(disturbance: Array) -> str:
    """Say for a message which of time, qpos, qvel, sensordata a call changed, and by how much (`disturbance`); "" if none."""
    names = ("data.time", "data.qpos", "data.qvel", "data.sensordata")
    every = zip(names, disturbance, changed(disturbance), strict=True)
    return "; ".join(f"{name} changed by {size:.3g}" for name, size, is_changed in every if is_changed)
