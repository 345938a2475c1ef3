"""Visibility of each curve in the small picture of a figure.

Axis limits, data and colours are what the student's process reports. They say where each curve must be in the picture. A point
counts as seen if the pixels near it differ from their surroundings towards the curve's colour. So a curve is not seen if it was
never drawn, lies under something else, or has the colour of the background.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import PARTS, Array, Axes, Curve, Figure, Mask, VisibleParts

Pixels = NDArray[np.float32]

_TOWARDS = 0.3
"""Share of the way to the curve's colour, of what its width and opacity promise: half a pixel's coverage is lost to smoothing."""
_FAINTEST = 0.03
"""Smallest difference of two colours, each channel 0 to 1, that a reader sees."""
_ASIDE = 0.05
"""Largest difference of two renderings of one colour, blended or not."""
_AROUND = 8
"""Half the side, in pixels, of the square that is compared with a point."""
_SPARSE = 31
"""Every so many pixels tell the background's colour; all of them take thirty times as long."""
_SMALLEST = 0.03
"""Smallest width and height of a panel, as a share of the figure's."""
_FEW = 6
"""Most colours of other curves that a curve is looked for under."""
_NO_STROKE = ("None", "none", "", " ")


class Patience:
    """Budget of pixels that are examined for one answer, so that a hostile figure costs bounded time; the rest counts as not seen.

    Most honest figures need half a million pixels, the largest of the test submissions 2.3 million.
    """

    def __init__(self, pixels: int = 30_000_000) -> None:
        self._left = pixels

    def lasts_for(self, pixels: int) -> bool:
        self._left -= pixels
        return self._left >= 0


def looked_at(figure: Figure, patience: Patience) -> Figure:
    """Return a figure, its curves' `visible_parts` set by what its pixels show.

    `patience` bounds the work of the search; what has not been found when it is used up counts as not visible.
    """
    places = [[_place(curve, panel, figure) for curve in panel.curves] for panel in figure.axes]
    free = ~_taken(itertools.chain(*places), figure.pixels.shape[:2])
    axes = []
    for panel, its in zip(figure.axes, places, strict=True):
        window = _window(panel, figure, free)
        seen = []
        for curve, place in zip(panel.curves, its, strict=True):
            beneath = (ink[:3] for other in panel.curves if other is not curve for ink in _inks(other))
            others = list(itertools.islice(beneath, _FEW))
            seen.append(replace(curve, visible_parts=_visible_parts(curve, place, window, others, patience)))
        axes.append(replace(panel, curves=tuple(seen)))
    return replace(figure, axes=tuple(axes))


# --- where a curve must stand --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Place:
    """Row and column in the picture of each point of a curve, and whether the point lies within the axis limits.

    Row and column are `known` only on linear scales; on others, any trace in the panel counts as the curve.
    """

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    inside: Mask
    known: bool

    def fits(self, shape: tuple[int, ...], at: tuple[int, int] = (0, 0)) -> tuple[Mask, tuple[Any, Any]]:
        """Return which points lie within an array of this `shape` that begins at the pixel `at`, and their indices in it."""
        rows, columns = self.rows - at[0], self.columns - at[1]
        fits = self.inside & (rows >= 0) & (columns >= 0) & (rows < shape[0]) & (columns < shape[1])
        return fits, (rows[fits], columns[fits])


def _place(curve: Curve, panel: Axes, figure: Figure) -> _Place:
    across, along = _shares(curve.x, panel.x_limits), _shares(curve.y, panel.y_limits)
    left, low, right, high = panel.position
    width, height = figure.extent
    inside = (across >= 0) & (across <= 1) & (along >= 0) & (along <= 1)
    columns = np.where(inside, (left + across * (right - left)) * width, 0)
    rows = np.where(inside, height - (low + along * (high - low)) * height, 0)
    return _Place(
        np.clip(rows, -1, height).astype(np.intp),
        np.clip(columns, -1, width).astype(np.intp),
        inside,
        tuple(panel.scales) == ("linear", "linear"),
    )


def _shares(values: Array, limits: Sequence[float]) -> Array:
    """Return where along an axis each value lies, 0 to 1 within the limits; -1 for a value that is not finite."""
    ends = np.array(limits, dtype=float)
    with np.errstate(all="ignore"):
        share = (values - ends[0]) / (ends[1] - ends[0])
    return np.where(np.isfinite(share), share, -1.0)


def _taken(places: Iterable[_Place], shape: tuple[int, ...]) -> Mask:
    """Return the pixels where some curve is said to be, and two pixels around it: what is there tells nothing of the background."""
    taken = np.zeros(shape, bool)
    for place in places:
        taken[place.fits(shape)[1]] = True
    return _widened(taken, 2)


# --- what stands there ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Window:
    """The part of a picture that one panel covers, prepared for the search for its curves.

    Attributes
    ----------
    free : (h, w) ndarray of bool, where no curve is said to be
    ground : (3,) ndarray, the colour behind the curves, each channel 0 to 1
    marked : (k,) ndarray, the flat indices of the pixels that differ from that colour
    off : (3, k) ndarray, by how much each of them differs, in red, green and blue
    room : (k,) ndarray, how many free pixels are in the square around each of them
    at : row and column of the window's first pixel in the picture
    dots : pixels to a point (1/72 inch)
    """

    free: Mask
    ground: Array
    marked: NDArray[np.intp]
    off: Pixels
    room: Array
    at: tuple[int, int]
    dots: float

    def standing_out(self, strength: Pixels, least: float) -> Mask:
        """Return the pixels with a curve's colour: its `strength` there is by `least` more than in the free pixels around."""
        free = self.free.ravel()[self.marked]
        quiet = np.zeros(self.free.size)
        quiet[self.marked[free]] = strength[free]
        around = _around(quiet.reshape(self.free.shape), self.marked) / np.maximum(self.room, 1)
        found = np.zeros(self.free.shape, bool)
        found.ravel()[self.marked[strength - around >= least]] = True
        return found


def _window(panel: Axes, figure: Figure, free: Mask) -> _Window | None:
    """Return the pixels of a panel; None if the panel is switched off or too small to show a curve."""
    left, low, right, high = panel.position
    height, width = free.shape
    rows = slice(*sorted(int(np.clip(share * height, 0, height)) for share in (1 - high, 1 - low)))
    columns = slice(*sorted(int(np.clip(share * width, 0, width)) for share in (left, right)))
    small = min(abs(right - left), abs(high - low)) < _SMALLEST
    if not panel.visible or small or rows.start == rows.stop or columns.start == columns.stop:
        return None
    its, pixels = free[rows, columns], figure.pixels[rows, columns].reshape(-1, 3)
    some, some_free = pixels[::_SPARSE], its.ravel()[::_SPARSE]
    ground = np.median(some[some_free] if some_free.any() else some, axis=0).astype(np.float32)
    other = np.flatnonzero(np.logical_or.reduce([pixels[:, channel] != ground[channel] for channel in range(3)]))
    off = (pixels[other].T - ground[:, None]) / np.float32(255)
    strong = np.abs(off).max(axis=0) > _FAINTEST / 4
    room = _around(its, other[strong])
    return _Window(
        its, ground / 255, other[strong], off[:, strong], room, (rows.start, columns.start), figure.dots / 72
    )


def _visible_parts(
    curve: Curve, place: _Place, window: _Window | None, others: Sequence[Array], patience: Patience
) -> VisibleParts:
    known = np.isfinite(curve.x) & np.isfinite(curve.y)
    if not known.any():
        return VisibleParts(np.zeros(PARTS, bool), np.zeros(PARTS, bool))
    shown = np.zeros(len(known), bool) if window is None else _shown_points(curve, place, window, others, patience)
    inside = place.inside & known if place.known else known
    return _by_parts(curve.x[known], inside[known], shown[known])


def _by_parts(x: Array, inside: Mask, seen: Mask) -> VisibleParts:
    """Return for each hundredth of a curve along x whether it is inside the limits, and seen: by a point in it or at its middle."""
    middles = x.min() + (np.arange(PARTS) + 0.5) / PARTS * np.ptp(x)
    order = np.argsort(x, kind="stable")
    next_to = order[np.clip(np.searchsorted(x[order], middles), 0, len(x) - 1)]
    part = np.clip(((x - x.min()) / max(float(np.ptp(x)), 1e-300) * PARTS).astype(np.intp), 0, PARTS - 1)
    within, shown = (
        (np.bincount(part[which], minlength=PARTS) > 0) | which[next_to] for which in (inside, inside & seen)
    )
    return VisibleParts(within, within & shown)


def _shown_points(curve: Curve, place: _Place, window: _Window, others: Sequence[Array], patience: Patience) -> Mask:
    """Return which points of a curve differ visibly from their surroundings, in any of the curve's colours.

    Where less than half is found, its colour is also looked for mixed with those of other curves. The search ends with `patience`.
    """
    shown = np.zeros(len(place.rows), bool)
    inks: Sequence[Array | None] = _inks(curve) or [None]
    for ink, mixed in itertools.product(inks, ([], others)):
        if shown.sum() > place.inside.sum() / 2 or not patience.lasts_for(window.free.size * (1 + 2 * len(mixed))):
            break
        strength, least = _strength(window, ink, curve, mixed)
        stands_out = window.standing_out(strength, least)
        if place.known:
            fits, at = place.fits(stands_out.shape, window.at)
            shown[fits] |= _widened(stands_out, _reach(curve, window.dots))[at]
        else:  # whatever stands out in the panel is the curve
            shown |= stands_out.any()
    return shown


def _reach(curve: Curve, dots: float) -> int:
    """Return how many pixels from its point a curve may leave its colour: a hollow marker leaves it at its rim."""
    plain = curve.kind == "line" and curve.marker in _NO_STROKE
    return 1 if plain else 2 + int(min(dots * curve.width, 6.0) / 2)


def _strength(window: _Window, ink: Array | None, curve: Curve, others: Sequence[Array]) -> tuple[Pixels, float]:
    """Return how much of the curve's colour is in each marked pixel, 0 to 1, and the least that a drawn curve leaves there.

    With `ink` None the colour is unknown, and any difference from the background counts.
    """
    if ink is None:
        return np.abs(window.off).max(axis=0), 2 * _FAINTEST
    opacity = ink[3] if ink[3] < 1 else curve.alpha
    way = ink[:3] - window.ground
    contrast = float(np.abs(way).max())
    if contrast * opacity < _FAINTEST:
        return np.zeros(window.off.shape[1], np.float32), 1.0
    wide = window.dots * curve.width
    dotted = curve.kind == "points" or curve.style in _NO_STROKE
    promised = opacity * min(1.0, wide * wide / 4 if dotted else wide)
    strengths = [
        share_of_way(window.off, way),
        *(_share_mixed(window.off, way, ink[:3] - window.ground) for ink in others),
    ]
    return np.max(strengths, axis=0), max(_TOWARDS * promised, _FAINTEST / contrast)


def share_of_way(off: Pixels, way: Array) -> Pixels:
    """Return how far k pixels go from the background's colour (0) to a curve's colour (1); 0 for a mixture with a third colour.

    `off` (3, k) is each pixel's colour, and `way` (3,) the curve's colour, both minus the background's.
    """
    share = (way / (way @ way)).astype(np.float32) @ off
    beside = np.abs(off - np.outer(way.astype(np.float32), share)).max(axis=0)
    share = np.clip(share, 0, 1)
    return np.where(beside <= _ASIDE + 0.1 * share, share, 0).astype(np.float32)


def _share_mixed(off: Pixels, way: Array, other: Array) -> Pixels:
    """Return how far pixels have gone to a curve's colour beside another one's; 0 where that other colour explains them alone."""
    basis = np.stack([way, other], axis=1).astype(np.float32)
    if abs(np.linalg.det(basis.T @ basis)) < 1e-3:
        return np.zeros(off.shape[1], np.float32)
    shares = np.linalg.pinv(basis) @ off
    beside = np.abs(off - basis @ shares).max(axis=0)
    mixed = (
        (shares.min(axis=0) > -0.05) & (shares.sum(axis=0) < 1.1) & (beside <= _ASIDE) & (share_of_way(off, other) == 0)
    )
    return np.where(mixed, np.clip(shares[0], 0, 1), 0).astype(np.float32)


def _around(values: NDArray[Any], at: NDArray[np.intp]) -> Array:
    """Return for each pixel `at` (a flat index) the sum of `values` over the square around it."""
    sums = np.pad(values.astype(float), (_AROUND + 1, _AROUND)).cumsum(axis=1)
    for row in range(1, len(sums)):  # faster than `cumsum` along this axis
        sums[row] += sums[row - 1]
    side = 2 * _AROUND + 1
    bands = sums[side:] - sums[:-side]
    around: Array = (bands[:, side:] - bands[:, :-side]).ravel()[at]
    return around


def _widened(mask: Mask, reach: int) -> Mask:
    """Return the mask with each True spread by `reach` pixels along both axes, as points may be drawn a pixel off."""
    for _ in range(2):
        mask = np.ascontiguousarray(mask)
        wide = mask.copy()
        for off in range(1, reach + 1):
            wide[off:] |= mask[:-off]
            wide[:-off] |= mask[off:]
        mask = wide.T
    return mask


def _inks(curve: Curve) -> list[Array]:
    return [ink for ink in map(_rgba, curve.inks) if ink is not None]


def _rgba(text: str) -> Array | None:
    """Return red, green, blue and opacity, 0 to 1, of `#rrggbb` or `#rrggbbaa`; None for any other text, as a worker may send."""
    try:
        values = bytes.fromhex(text.removeprefix("#"))
    except ValueError:
        return None
    return np.array([*values, 255][:4]) / 255 if len(values) in (3, 4) else None
