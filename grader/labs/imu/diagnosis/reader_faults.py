"""What a reader may do to the right numbers over several calls or with the robot's pose: told from a sequence of readings.

Each hypothesis predicts every reading of the sequence that it speaks of, to within the tolerance of a copied number; its few
unknowns (a limit, a weight, the way that the body is turned against the sensor) are read off the same sequence, which has many
more numbers.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grader.engine.hypothesis import Named, explain
from grader.labs.imu.compare import Array, same

Fits = Callable[[Array, Array, float], bool]
"""Of readings (n, 3), the true ones, and a tolerance: whether a hypothesis predicts every reading."""

_LONGEST_MEMORY = 10
_ORTHOGONAL = 1e-3
_ABSURD = 1e9


def handled(got: tuple[Array, Array], true: tuple[Array, Array], world_from_site: Array, atol: float) -> str | None:
    """The mistake that predicts the readings of an accelerometer and a gyroscope, each (n, 3); None where none or several do.

    One of the two sensors may be right. The calls came one after the other, but for one call between the first two.

    Parameters
    ----------
    world_from_site : (n, 3, 3) ndarray, the sensors' own axes in the world
    """
    if not all(np.abs(g).max() < _ABSURD for g in got):
        return None
    wrong = [(g, t, atol) for g, t in zip(got, true, strict=True) if not same(g, t, atol)]
    if any(np.ptp(g, axis=0).max() <= atol for g, *_ in wrong):
        return None  # of a constant nothing can be told
    found = explain(
        (
            _of_each("reading-clipped", clipped),
            _of_each("cached-reading", kept),
            _of_each("reading-smoothed", smoothed),
            _of_each("turned-by-body", lambda g, t, a: turned(g, t, world_from_site, a)),
        ),
        wrong,
    )
    return found.told if found else None


def _of_each(name: str, fits: Fits) -> Named[list[tuple[Array, Array, float]]]:
    """That it is the one mistake of every sensor that is wrong."""
    return Named(1, name, lambda wrong: bool(wrong) and all(fits(*sensor) for sensor in wrong))


def clipped(got: Array, true: Array, atol: float) -> bool:
    """Whether (n, 3) readings are the true ones within limits: one for all axes, or one for each, at which two stand or more.

    An axis that is wrong and never moves is a constant, of which no limit makes anything.
    """
    return any(_within_limits(got, true, axis, atol) for axis in (None, 0))


def _within_limits(got: Array, true: Array, axis: int | None, atol: float) -> bool:
    low, high = got.min(axis=axis), got.max(axis=axis)
    beyond = [np.count_nonzero(true < low - atol), np.count_nonzero(true > high + atol)]
    moves = np.all((low < high) | (np.abs(got - true).max(axis=axis) <= atol))
    return bool(moves and max(beyond) > 1) and same(got, np.clip(true, low, high), atol)


def kept(got: Array, true: Array, atol: float) -> bool:
    """Whether each reading is either its own or the one that was given before, and some of both."""
    own = np.abs(got - true).max(axis=1) <= atol
    again = np.abs(np.diff(got[1:], axis=0)).max(axis=1) <= atol
    return bool((own[2:] | again).all() and own.sum() > 2 and (~own).sum() > 2)


def smoothed(got: Array, true: Array, atol: float) -> bool:
    """Whether each reading is a weighted mean of the latest true ones, or of the new one and the one that was given before.

    The weights are the same on all axes and add up to one; no row is asked for that goes back beyond the second call.
    """
    for memory in range(2, _LONGEST_MEMORY + 1):
        rows = range(memory, len(got))
        if _weighs(got[memory:], [np.concatenate([true[n - lag] for n in rows]) for lag in range(memory)], atol):
            return True
    return _weighs(got[2:], [true[2:].ravel(), got[1:-1].ravel()], atol)


def _weighs(got: Array, parts: list[Array], atol: float) -> bool:
    """Whether these readings are a mean of the parts with weights that add up to one, and not the first part alone."""
    wanted, columns = got.ravel(), np.column_stack(parts)
    if len(wanted) < 2 * columns.shape[1]:
        return False
    weights = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    mean = abs(weights.sum() - 1) < _ORTHOGONAL and weights.min() > -_ORTHOGONAL and weights[0] < 1 - _ORTHOGONAL
    return bool(mean and np.abs(columns @ weights - wanted).max() <= atol)


def turned(got: Array, true: Array, world_from_site: Array, atol: float) -> bool:
    """Whether the readings are the true ones, turned by a frame that is fixed to the sensor's at an angle, or turned back by it.

    With S the sensor's axes in the world and C the fixed turn, the body's axes are S Cᵀ: readings are S Cᵀ a, or its inverse
    C Sᵀ a. Without an angle it is the sensor's own frame, and the mistake another one.
    """
    into_world = np.einsum("nji,nj->ni", world_from_site, got)
    out_of_world = np.einsum("nji,nj->ni", world_from_site, true)
    return _turns(into_world, true, atol) or _turns(got, out_of_world, atol)


def _turns(got: Array, true: Array, atol: float) -> bool:
    """Whether one rotation, not that by nothing, makes these (n, 3) of the true ones."""
    turn = np.linalg.lstsq(true, got, rcond=None)[0]
    rigid = np.abs(turn @ turn.T - np.eye(3)).max() < _ORTHOGONAL and np.abs(turn - np.eye(3)).max() > _ORTHOGONAL
    return bool(rigid and np.linalg.det(turn) > 0 and np.abs(true @ turn - got).max() <= atol)
