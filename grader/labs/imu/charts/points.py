"""Conversion of arrays into the few finite points of a chart's curve."""

from __future__ import annotations

import numpy as np

from grader.engine.chart_data import Curve, Role
from grader.labs.imu.compare import Array

MOST = 200
_LARGEST = 1e12


def curve(name: str, role: Role, x: Array, y: Array, colour: str = "") -> Curve:
    """Return a curve for a chart, without points that are not finite or too large.

    `role` is the drawing style. `colour` (``#rrggbb``) is the one that a student drew the curve in; "" if no student drew it.
    """
    fine = (np.abs(x) < _LARGEST) & (np.abs(y) < _LARGEST)  # False for NaN
    across, along = (tuple(each[fine].astype(np.float32).tolist()) for each in (x, y))  # finer than a pixel
    return Curve(name, role, across, along, colour)


def worst_of_each(error: Array, most: int = MOST) -> np.ndarray:
    """Return indices of at most `most` errors (n,), the largest of each stretch, so that a thinned chart hides no peak."""
    n = len(error)
    width = -(-n // most)
    filled = np.full(width * -(-n // width), -1.0)
    filled[:n] = np.nan_to_num(np.abs(error), nan=np.inf)
    stretches = filled.reshape(-1, width)
    return np.asarray(stretches.argmax(axis=1) + width * np.arange(len(stretches)))
