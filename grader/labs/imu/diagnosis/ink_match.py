"""Whether ink follows curves: the map from values to rows is looked for, and what it explains is weighed against chance.

What a curve does where it rises and falls counts. Any horizontal line follows a curve where that rests, and a grid, a frame or a
line of text is full of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import Array, Mask

_HEIGHTS = 0.9 ** np.arange(27)  # of the region, by all curves: from all of it to a sixteenth
_COLUMNS = 40  # that are looked at in the search
_STEP = 4  # rows that the search sees as one
_LARGE = 0.1  # to prefer the larger one of two maps that are followed alike
_DENSEST = 0.8
_LIVELY, _FEWEST_COLUMNS = 20, 25  # rows that the liveliest curve goes up and down, columns that it spans
_SHIFTED, _STRETCHED = 5, 9  # columns that a span may be off at its start and at its end
_ASIDE = (-32, -26, -20, -15, -11, -8, 8, 11, 15, 20, 26, 32)  # rows, where chance is measured
_OWN_ROWS = 5  # from a curve, that are not chance
_LEAST_CHANCE = 0.1
_TOGETHER = 4  # pixels along a rise that are one observation: a stroke is as thick

_MOVES = np.array(
    [[1, 0, 0, 0], [0, 1, 0, 0], [1, -1, 0, 0], [1, -2, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 1, 1]], float
)
"""Of a map's top, height, first and last column, which are tried in steps of 4, 2, 1 and 1/2 pixels."""


@dataclass(frozen=True, eq=False)
class Ink:
    """What is drawn in a region.

    Attributes
    ----------
    near : (h, w) ndarray of bool, the pixels that have ink in them or next to them
    rough : (h / 4, w) ndarray of bool, four rows as one
    """

    near: Mask
    rough: Mask

    @classmethod
    def of(cls, mask: Mask) -> Ink:
        height, width = mask.shape
        padded, near = np.pad(mask, 1), np.zeros_like(mask)
        for down in range(3):
            for right in range(3):
                near |= padded[down : down + height, right : right + width]
        rough: Mask = np.any(mask[: height // _STEP * _STEP].reshape(-1, _STEP, width), axis=1)
        return cls(near, rough)

    def at(self, rows: Array, columns: Array) -> Mask:
        """Whether there is ink at these places; none above or below."""
        height, width = self.near.shape
        place = np.clip(np.rint(rows), -1, height).astype(np.intp) + 1
        there: Mask = self._framed.take(place * width + np.rint(columns).astype(np.intp))
        return there

    @cached_property
    def _framed(self) -> Mask:
        """`near` with an empty row above and below, row by row."""
        return np.pad(self.near, ((1, 1), (0, 0))).ravel()


@dataclass(frozen=True, eq=False)
class Curves:
    """Channels of a recording, drawn on one scale.

    Attributes
    ----------
    time : (m,) ndarray, s from the start
    values : (k, m) ndarray
    duration_s : of the whole recording that the picture shows
    """

    time: Array
    values: Array
    duration_s: float

    def within(self, first: float, last: float, width: int) -> tuple[Array, Array]:
        """The columns (n,) where the values are known, and the values (k, n) there."""
        columns = np.arange(max(0, math.ceil(first)), min(width, math.floor(last)), dtype=float)
        stamps = (columns - first) * (self.duration_s / (last - first))
        known = stamps <= self.time[-1]
        return columns[known], np.array([np.interp(stamps[known], self.time, channel) for channel in self.values])

    @cached_property
    def depths(self) -> Curves:
        """The same curves from 0 at the highest value to 1 at the lowest."""
        highest, lowest = self.values.max(), self.values.min()
        return replace(self, values=(highest - self.values) / (highest - lowest))


@lru_cache(maxsize=32)
def _depths(curves: Curves, first: float, last: float, width: int) -> tuple[Array, Array]:
    """Most places that are tried in turn differ in their rows alone."""
    return curves.depths.within(first, last, width)


@dataclass(frozen=True, eq=False)
class Place:
    """Where curves may stand: from the row of the highest value down, and from the first column to the last.

    `promise` says how well the search liked it.
    """

    curves: Curves
    ink: Ink
    top: float
    height: float
    first: float
    last: float
    promise: float

    @property
    def width(self) -> float:
        return self.last - self.first

    def rows(self) -> tuple[Array, Array]:
        """The columns (n,), and each curve's rows (k, n) in them."""
        columns, depths = _depths(self.curves, self.first, self.last, self.ink.near.shape[1])
        return columns, self.top + depths * self.height

    def moved(self, by: Array) -> Place:
        top, height, first, last = by.tolist()
        return replace(
            self, top=self.top + top, height=self.height + height, first=self.first + first, last=self.last + last
        )


# --- searching -----------------------------------------------------------------------------------------------------------


def places(ink: Ink, first: int, last: int, curves: Curves) -> Iterator[tuple[tuple[int, ...], Place]]:
    """The likeliest place of three channels on one scale, and that of each channel alone."""
    columns, values = curves.within(first, last, ink.near.shape[1])
    if len(columns) < _FEWEST_COLUMNS or not np.ptp(values, axis=1).all():
        return
    few = _telling(values)
    values, seen = values[:, few], ink.rough[:, columns[few].astype(np.intp)]
    one_scale = (values.max() - values) / np.ptp(values)
    own_scales = (values.max(axis=1, keepdims=True) - values) / np.ptp(values, axis=1, keepdims=True)
    beyond_chance = _beyond_chance(seen, np.vstack([one_scale, own_scales]))
    together, alone = beyond_chance[:, :, :3], beyond_chance[:, :, 3:]
    scores: dict[tuple[int, ...], Array] = {(0, 1, 2): (together.sum(axis=2) + together.min(axis=2)) / 4}
    scores |= {(channel,): alone[:, :, channel] for channel in range(3)}
    for which, score in scores.items():
        share = float(np.ptp(one_scale, axis=1).max()) if len(which) == 3 else 1.0
        lively = _HEIGHTS * len(seen) * _STEP * share >= _LIVELY
        if lively.any():
            size = _HEIGHTS * len(columns) / ink.near.shape[1]
            liked = np.where(lively, score + _LARGE * np.log(size), -np.inf)
            start, number = np.unravel_index(int(liked.argmax()), liked.shape)
            top, height = start * _STEP + _STEP / 2, _HEIGHTS[number] * len(seen) * _STEP
            shown = replace(curves, values=curves.values[list(which)])
            yield which, Place(shown, ink, top, height, first, last, liked[start, number])


def _telling(values: Array) -> NDArray[np.intp]:
    """The columns that the search looks at: half of them evenly over the time, half of them over the rises and falls."""
    n = values.shape[1]
    risen = np.cumsum(np.abs(np.diff(values, prepend=values[:, :1])).sum(axis=0))
    way = risen / risen[-1] + np.arange(n) / n
    few: NDArray[np.intp] = np.rint(np.interp(np.linspace(0, way[-1], min(_COLUMNS, n)), way, np.arange(n))).astype(
        np.intp
    )
    return few


def _beyond_chance(seen: Mask, units: Array) -> Array:
    """How far curves (k, n), 0 at the top to 1, are followed beyond chance, for each start and height: (starts, heights, k)."""
    rows, columns = seen.shape
    below = np.zeros((2 * rows + 2, columns), np.uint8)
    below[:rows] = seen
    sizes, starts = _HEIGHTS * rows, np.arange(rows)[:, None]
    from_each_row = np.lib.stride_tricks.sliding_window_view(np.ascontiguousarray(below.T), rows, axis=1)
    steps = np.rint(units * sizes[:, None, None]).astype(np.intp)
    found = from_each_row[np.arange(columns), steps].sum(axis=2, dtype=np.uint8)  # (heights, k, starts), of few columns
    share = np.moveaxis(found, 2, 0) / columns
    sums = np.concatenate([[0.0], np.cumsum(below.mean(axis=1))])
    ends = np.minimum(starts + np.ceil(sizes).astype(np.intp) + 1, len(below))
    chance = np.minimum((sums[ends] - sums[starts]) / (ends - starts), _DENSEST)[..., None]
    beyond: Array = (share - chance) / (1 - chance)
    return beyond


def settled(place: Place) -> Place:
    """The best place nearby."""
    start, best = place, _followed(place)
    for step in (4.0, 2.0, 1.0, 0.5):
        for _ in range(5):
            near = [place.moved(step * move) for move in (*_MOVES, *-_MOVES)]
            near = [each for each in near if _is_near(each, start)]
            scores = list(map(_followed, near))
            if not scores or max(scores) <= best + 1e-9:
                break
            best = max(scores)
            place = near[scores.index(best)]
    return place


def _is_near(place: Place, start: Place) -> bool:
    off = abs(place.first - start.first), abs(place.last - start.last)
    return place.height >= _LIVELY / 2 and off[0] <= _SHIFTED and off[1] <= _STRETCHED


def _followed(place: Place) -> float:
    columns, rows = place.rows()
    if len(columns) < _FEWEST_COLUMNS:
        return -1.0
    followed: list[int] = np.count_nonzero(place.ink.at(rows, columns), axis=1).tolist()
    return (sum(followed) + min(followed)) / len(columns)


# --- weighing ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Weight:
    """What speaks for curves at a place.

    Attributes
    ----------
    followed : share of the columns in which the curve that is followed least has ink
    evidence : of all rises and falls, against ink that lies there by chance, in nats
    """

    followed: float
    evidence: float


def weighed(place: Place) -> Weight:
    columns, rows = place.rows()
    if len(columns) < _FEWEST_COLUMNS or float(np.ptp(rows, axis=1).max()) < _LIVELY:
        return Weight(0.0, 0.0)
    down, across = _rises(columns, rows)
    there = place.ink.at(down, across)
    every = np.array([np.interp(across, columns, curve) for curve in rows])
    chances = []
    for aside in _ASIDE:
        clear = np.all(np.abs(every - (down + aside)) > _OWN_ROWS, axis=0)
        if np.count_nonzero(clear) > _OWN_ROWS:
            chances.append(place.ink.at(down[clear] + aside, across[clear]).mean())
    chance = float(np.mean(chances)) if chances else 0.0
    evidence = len(down) / _TOGETHER * _surprise(float(there.mean()), max(_LEAST_CHANCE, chance))
    return Weight(float(place.ink.at(rows, columns).mean(axis=1).min()), evidence)


def _rises(columns: Array, rows: Array) -> tuple[Array, Array]:
    """A point for each row that each curve passes on its way up and down: rows and columns."""
    down, across = [], []
    for curve in rows:
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(curve)))])
        points = np.arange(0.0, way[-1])
        down.append(np.interp(points, way, curve))
        across.append(np.interp(points, way, columns))
    return np.concatenate(down), np.concatenate(across)


def _surprise(share: float, chance: float) -> float:
    """Of one observation among such a share that fit, where so many would by chance: Kullback and Leibler's divergence."""
    share = min(share, 0.999)
    if share <= chance:
        return 0.0
    return share * math.log(share / chance) + (1 - share) * math.log((1 - share) / (1 - chance))
