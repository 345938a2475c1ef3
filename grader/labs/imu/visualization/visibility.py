"""Visibility of each curve in the small picture of a figure.

Limits, data and colours are a claim; from them follows where each curve stands in the picture that was drawn. What does not stand
there was not shown, whatever lies over it, hides it, or was never drawn. A point is seen where the picture, near the place of the
point, goes from what is around it towards the curve's colour.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import PARTS, Array, Axes, Curve, Figure, Mask, Sight

Pixels = NDArray[np.float32]
Codes = NDArray[np.int32]

_TOWARDS = 0.3
"""Share of the way to the curve's colour, of what its width and opacity promise: half a pixel's coverage is lost to smoothing."""
_FAINTEST = 0.03  # difference of two colours, each channel 0 to 1, that nobody sees
_ASIDE = 0.05  # that two renderings of one colour differ by, blended or not
_AROUND = 8  # pixels: how far what is around a point reaches
_SPARSE = 31
"""Every so many pixels tell which colour may be that of most of them: all of them take thirty times as long to sort."""
_SMALLEST = 0.03  # of the figure's width or height: less than that is no panel
_NO_STROKE = ("None", "none", "", " ")
_FEW = 6  # colours of other curves that one is seen through
_SOME = 3  # pixels


class Patience:
    """Budget of pixels that are looked at for one answer; one that asks for more is not believed.

    Most honest ones need half a million, the largest of the corpus 2.3 million.
    """

    def __init__(self, pixels: int = 30_000_000) -> None:
        self._left = pixels

    def lasts_for(self, pixels: int) -> bool:
        self._left -= pixels
        return self._left >= 0


def looked_at(figure: Figure, patience: Patience) -> Figure:
    """Return the figure with `sight` set: which parts of each curve can be seen."""
    if not figure.axes:
        return figure
    axes = (
        replace(panel, curves=tuple(replace(c, sight=s) for c, s in zip(panel.curves, its, strict=True)))
        for panel, its in zip(figure.axes, _sights(figure, patience), strict=True)
    )
    return replace(figure, axes=tuple(axes))


def _sights(figure: Figure, patience: Patience) -> list[list[Sight]]:
    """Return the visible parts of each curve of each panel."""
    codes = _codes(figure.pixels)
    places = [[_places(panel, curve, figure) for curve in panel.curves] for panel in figure.axes]
    free = ~_taken([place for panel in places for place in panel], codes.shape)
    found = []
    for panel, its in zip(figure.axes, places, strict=True):
        window = _window(panel, codes, free)
        inks = [_inks(curve) for curve in panel.curves]
        found.append(
            [
                _sight(curve, place, window, _others(inks, number), figure.dots / 72, patience)
                for number, (curve, place) in enumerate(zip(panel.curves, its, strict=True))
            ]
        )
    return found


# --- where a curve must stand --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Places:
    """Row and column of each point in the picture, and whether it lies within the panel's limits."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    inside: Mask
    known: bool


def _places(panel: Axes, curve: Curve, figure: Figure) -> _Places:
    (across, across_known), (along, along_known) = (
        _shares(*each) for each in zip((curve.x, curve.y), (panel.x_limits, panel.y_limits), panel.scales, strict=True)
    )
    left, low, right, high = panel.position
    width, height = figure.extent
    inside = (across >= 0) & (across <= 1) & (along >= 0) & (along <= 1)
    columns = np.where(inside, (left + across * (right - left)) * width, 0)
    rows = np.where(inside, height - (low + along * (high - low)) * height, 0)
    return _Places(
        np.clip(rows, -1, height).astype(np.intp), np.clip(columns, -1, width).astype(np.intp), inside,
        across_known and along_known,
    )  # fmt: skip


def _shares(values: Array, limits: Sequence[float], scale: str) -> tuple[Array, bool]:
    """Return how far along an axis each value lies, and whether that is known."""
    ends = np.array(limits, dtype=float)
    with np.errstate(all="ignore"):
        share = (values - ends[0]) / (ends[1] - ends[0])
    return np.where(np.isfinite(share), share, -1.0), scale == "linear"


def _taken(places: Sequence[_Places], shape: tuple[int, ...]) -> Mask:
    """Return where some curve is said to stand, two pixels around it included."""
    taken = np.zeros(shape, bool)
    for place in places:
        fits = place.inside & _are_in(shape, place.rows, place.columns)
        taken[place.rows[fits], place.columns[fits]] = True
    return _widened(taken, 2)


def _are_in(shape: tuple[int, ...], rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Mask:
    fits: Mask = (rows >= 0) & (columns >= 0) & (rows < shape[0]) & (columns < shape[1])
    return fits


# --- what stands there ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Window:
    """A panel's part of the picture.

    Attributes
    ----------
    free : (h, w) ndarray of bool, where no curve is said to stand
    ground : (3,) ndarray, the colour behind the curves
    marked : (k,) ndarray, the flat indices of the pixels that are not of that colour
    off : (k, 3) ndarray, how far they are from it
    squares : (4, k) ndarray, the corners of the square around each; see `_squares`
    room : (k,) ndarray, how many free pixels are around each
    at : its first row and column
    """

    free: Mask
    ground: Array
    marked: NDArray[np.intp]
    off: Pixels
    squares: NDArray[np.intp]
    room: Array
    at: tuple[int, int]

    def around(self, strength: Pixels) -> Pixels:
        """Return the mean strength around each marked pixel where no curve is said to stand; near curves, that of the panel."""
        shape, free = self.free.shape, self.free.ravel()[self.marked]
        spread = np.zeros(self.free.size, np.float32)
        spread[self.marked[free]] = strength[free]
        if not spread.any():
            return np.zeros_like(strength)
        total, count = _boxed(spread.reshape(shape), self.squares), self.room
        whole = float(spread.sum() / max(1, np.count_nonzero(self.free)))
        return np.where(count >= 4, total / np.maximum(count, 1), whole).astype(np.float32)


def _window(panel: Axes, codes: Codes, free: Mask) -> _Window | None:
    """Return the pixels of a panel; None if it is invisible or no larger than a stroke."""
    left, low, right, high = panel.position
    height, width = codes.shape
    rows = slice(*sorted(int(np.clip(share * height, 0, height)) for share in (1 - high, 1 - low)))
    columns = slice(*sorted(int(np.clip(share * width, 0, width)) for share in (left, right)))
    small = min(abs(right - left), abs(high - low)) < _SMALLEST
    if not panel.visible or small or rows.start == rows.stop or columns.start == columns.stop:
        return None
    part, its = codes[rows, columns], free[rows, columns]
    behind = commonest(part[its] if its.any() else part.ravel())
    other = np.flatnonzero(part.ravel() != behind)
    ground = np.array([behind >> 16, behind >> 8 & 255, behind & 255]) / 255
    off = _colours(part.ravel()[other]) - ground.astype(np.float32)
    marked = _largest(off) > _FAINTEST / 4
    squares = _squares(its.shape, other[marked])
    return _Window(its, ground, other[marked], off[marked], squares, _boxed(its, squares), (rows.start, columns.start))


def _codes(colours: NDArray[np.uint8]) -> Codes:
    """One number for each colour (…, 3)."""
    red, green, blue = np.moveaxis(colours.astype(np.int32), -1, 0)
    codes: Codes = red << 16 | green << 8 | blue
    return codes


def _colours(codes: Codes) -> Pixels:
    """The colours (k, 3) again, each channel 0 to 1."""
    shares: Pixels = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=-1).astype(np.float32) / np.float32(
        255
    )
    return shares


def _inks(curve: Curve) -> list[Array]:
    return [ink for ink in map(_rgba, curve.inks) if ink is not None]


def _others(inks: Sequence[Sequence[Array]], number: int) -> list[Array]:
    """The colours of the other curves, a few of them."""
    return [ink[:3] for other, its in enumerate(inks) if other != number for ink in its][:_FEW]


def _sight(
    curve: Curve, place: _Places, window: _Window | None, others: Sequence[Array], scale: float, patience: Patience
) -> Sight:
    x = curve.x
    known = np.isfinite(x) & np.isfinite(curve.y)
    if not known.any():
        nothing = np.zeros(PARTS, bool)
        return Sight(nothing, nothing)
    shown = np.zeros(len(x), bool)
    if window is not None:
        shown = _shown_points(curve, place, window, others, scale * curve.width, patience)
    inside = place.inside & known if place.known else known
    return _by_parts(x[known], inside[known], shown[known])


def _by_parts(x: Array, inside: Mask, seen: Mask) -> Sight:
    """A part is inside, or seen, where the point next to its middle is, or any point within it."""
    middles = x.min() + (np.arange(PARTS) + 0.5) / PARTS * np.ptp(x)
    order = np.argsort(x, kind="stable")
    next_to = order[np.clip(np.searchsorted(x[order], middles), 0, len(x) - 1)]
    part = np.clip(((x - x.min()) / max(float(np.ptp(x)), 1e-300) * PARTS).astype(np.intp), 0, PARTS - 1)
    within, shown = (
        (np.bincount(part[which], minlength=PARTS) > 0) | which[next_to] for which in (inside, inside & seen)
    )
    return Sight(within, within & shown)


def _shown_points(
    curve: Curve, place: _Places, window: _Window, others: Sequence[Array], wide: float, patience: Patience
) -> Mask:
    """Return a mask of the points of a curve that differ visibly from their surroundings."""
    shown = np.zeros(len(place.rows), bool)
    inks: Sequence[Array | None] = _inks(curve) or [None]
    for ink, mixed in itertools.product(inks, ([], others)):
        # What is mixed with another curve's colour is looked for where much is missing.
        if shown.sum() > place.inside.sum() / 2 or not patience.lasts_for(window.free.size * (1 + 2 * len(mixed))):
            break
        strength, least = _strength(window, ink, mixed, curve, wide)
        stands_out = np.zeros(window.free.shape, bool)
        stands_out.ravel()[window.marked[strength - window.around(strength) >= least]] = True
        shown |= _near(stands_out, place, window, _reach(curve, wide))
    return shown


def _reach(curve: Curve, wide: float) -> int:
    """Return how far from its point a curve may leave its colour: a hollow marker does at its rim."""
    plain = curve.kind == "line" and curve.marker in _NO_STROKE
    return 1 if plain else 2 + int(min(wide, 6.0) / 2)


def _near(stands_out: Mask, place: _Places, window: _Window, reach: int) -> Mask:
    if not place.known:  # on scales that are not foreseen, whatever stands out in the panel is the curve
        return np.full(len(place.rows), np.count_nonzero(stands_out) >= _SOME)
    near = _widened(stands_out, reach)
    rows, columns = place.rows - window.at[0], place.columns - window.at[1]
    fits = place.inside & _are_in(near.shape, rows, columns)
    found = np.zeros(len(rows), bool)
    found[fits] = near[rows[fits], columns[fits]]
    return found


def _strength(
    window: _Window, ink: Array | None, others: Sequence[Array], curve: Curve, wide: float
) -> tuple[Pixels, float]:
    """Return how much of the curve's colour is in each marked pixel, 0 to 1, and how much of it the curve has to leave."""
    if ink is None:
        return _largest(window.off), 2 * _FAINTEST
    opacity = ink[3] if ink[3] < 1 else min(max(curve.alpha, 0.0), 1.0)
    way = ink[:3] - window.ground
    contrast = float(np.abs(way).max())
    if contrast * opacity < _FAINTEST:
        return np.zeros(len(window.off), np.float32), 1.0
    strength = share_of_way(window.off, way)
    for other in others:
        strength = np.maximum(strength, _share_beside(window.off, way, other - window.ground))
    dotted = curve.kind == "points" or curve.style in _NO_STROKE
    promised = opacity * min(1.0, wide * wide / 4 if dotted else wide)
    return strength, max(_TOWARDS * promised, _FAINTEST / contrast)


def share_of_way(off: Pixels, way: Array) -> Pixels:
    """Return how far pixels (k, 3), as they are off the ground, are on the way to a colour; 0 where they are beside it."""
    share = off @ (way / (way @ way)).astype(np.float32)
    beside = _largest(off - share[:, None] * way.astype(np.float32))
    share = np.clip(share, 0, 1)
    return np.where(beside <= _ASIDE + 0.1 * share, share, 0).astype(np.float32)


def _share_beside(off: Pixels, way: Array, other: Array) -> Pixels:
    """Return that share where another curve's colour is mixed in, as far as that colour alone does not explain the pixel."""
    basis = np.stack([way, other])
    if abs(np.linalg.det(basis @ basis.T)) < 1e-3:
        return np.zeros(len(off), np.float32)
    shares = off @ np.linalg.pinv(basis).astype(np.float32)
    beside = _largest(off - shares @ basis.astype(np.float32))
    mixed = (shares.min(axis=1) > -0.05) & (shares.sum(axis=1) < 1.1) & (beside <= _ASIDE)
    alone = off @ (other / (other @ other)).astype(np.float32)
    missed = _largest(off - alone[:, None] * other.astype(np.float32))
    return np.where(mixed & (missed > _ASIDE), np.clip(shares[:, 0], 0, 1), 0).astype(np.float32)


def _largest(off: Pixels) -> Pixels:
    """The largest of three differences, row by row; column by column it takes a third of the time of `max`."""
    red, green, blue = np.abs(off).T
    largest: Pixels = np.maximum(np.maximum(red, green), blue)
    return largest


def _squares(shape: tuple[int, int], at: NDArray[np.intp]) -> NDArray[np.intp]:
    """The corners of the square around each pixel, as flat indices of sums with a row and a column of zeros before them."""
    height, width = shape
    rows, columns = np.divmod(at, width)
    top, bottom = np.maximum(rows - _AROUND, 0), np.minimum(rows + _AROUND + 1, height)
    left, right = np.maximum(columns - _AROUND, 0), np.minimum(columns + _AROUND + 1, width)
    return np.array([y * (width + 1) + x for y in (top, bottom) for x in (left, right)])


def _boxed(values: NDArray[Any], squares: NDArray[np.intp]) -> Array:
    """Sums over squares."""
    height, width = values.shape
    sums = np.zeros((height + 1, width + 1))
    sums[1:, 1:] = values
    for row, above in zip(sums[2:], sums[1:], strict=False):  # sooner than `cumsum` along this axis
        np.add(above, row, out=row)
    np.cumsum(sums, axis=1, out=sums)
    top_left, top_right, bottom_left, bottom_right = sums.ravel().take(squares)
    boxed: Array = bottom_right - top_right - bottom_left + top_left
    return boxed


def _widened(mask: Mask, reach: int) -> Mask:
    """Return the mask dilated by `reach` pixels along both axes."""
    for _ in range(2):
        mask = np.ascontiguousarray(mask)
        wide = mask.copy()
        for off in range(1, reach + 1):
            wide[off:] |= mask[:-off]
            wide[:-off] |= mask[off:]
        mask = wide.T
    return mask


def commonest(codes: Codes) -> int:
    """The colour that most of these pixels have; of none it is white."""
    if not codes.size:
        return 0xFFFFFF
    code = _mode(codes[::_SPARSE])
    return code if 2 * np.count_nonzero(codes == code) > codes.size else _mode(codes)


def _mode(codes: Codes) -> int:
    values, counts = np.unique(codes, return_counts=True)
    return int(values[counts.argmax()])


def _rgba(text: str) -> Array | None:
    """Red, green, blue and opacity, 0 to 1, of `#rrggbb` or `#rrggbbaa`."""
    try:
        values = [int(text[i : i + 2], 16) / 255 for i in range(1, len(text), 2)]
    except ValueError:
        return None
    return np.array([*values, 1.0][:4]) if text[:1] == "#" and len(values) in (3, 4) else None
