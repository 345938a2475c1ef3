"""From arrays to the points of a curve: few, finite and short."""

from __future__ import annotations

import numpy as np

from ..compare import Array
from ..evidence import Curve, Role

MOST = 200
_LARGEST = 1e12
_DIGITS = 4  # of a curve's range: finer than a pixel


def curve(name: str, role: Role, x: Array, y: Array, colour: str = "") -> Curve:
    """A curve without the points that cannot be drawn."""
    fine = (np.abs(x) < _LARGEST) & (np.abs(y) < _LARGEST)  # False for NaN
    return Curve(name, role, _short(x[fine]), _short(y[fine]), colour)


def thinned(n: int, most: int = MOST) -> np.ndarray:
    """Indices of at most `most` of n points, first and last among them."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int))


def worst_of_each(error: Array, most: int = MOST) -> np.ndarray:
    """Indices of at most `most` of the errors (n,): the largest of each stretch, so that thinning hides none."""
    n = len(error)
    width = -(-n // most)
    filled = np.full(width * -(-n // width), -1.0)
    filled[:n] = np.nan_to_num(np.abs(error), nan=np.inf)
    stretches = filled.reshape(-1, width)
    return np.asarray(stretches.argmax(axis=1) + width * np.arange(len(stretches)))


def _short(values: Array) -> tuple[float, ...]:
    if not len(values):
        return ()
    reach = max(float(np.ptp(values)), 1e-6 * float(np.abs(values).max())) or 1.0
    return tuple(np.round(values, _DIGITS - int(np.floor(np.log10(reach)))).tolist())
