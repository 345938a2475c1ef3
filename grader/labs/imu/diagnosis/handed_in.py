"""Looking at a picture that no code draws: which of the two sensors' recordings it shows, by what is drawn alone.

Where a panel lies and what its limits are is not known. That all curves of a panel are one map from values to rows is, and that all
panels of a picture are equally wide and equally long in time. Whatever is off the ground is ink: a colour tells nothing, curves
come in greys and dashes too. Words cannot be read from pixels here.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import Array, Mask
from grader.labs.imu.diagnosis.ink_match import Curves, Ink, Place, Weight, places, settled, weighed

DURATIONS = (5.0, 3.0, 10.0, 2.0, 1.2)  # s: the sheet's first
_ALIKE = 0.06  # largest difference, each channel 0 to 1, of colours that are one ground
_INKS = (
    0.14,
    0.07,
)  # difference from the ground of what is drawn: a grid has less than the first, a thin line more than the second
_SHARE, _FILLED = 0.04, 0.5  # of the picture by a region, and of the region by its ground
_MOST_INK = 0.3  # of a region: a window has more, around a figure of another colour
_MOST_GROUNDS, _MOST_REGIONS = 4, 8
_STRONG, _ONE_COLOUR, _MOST_COLOURS, _FEWEST_PIXELS = 0.3, 0.15, 5, 25
_SPANNED, _DENSEST = 0.5, 0.2  # of the columns of a part by a colour that may be a curve's, and the most of its pixels
_LINE = 0.12  # of a region's height: less is no border of a panel
_MARGIN = 0.5 / 11  # of a panel's width, on either side of its curves, unless the code says otherwise
_NARROWEST, _NEAR = 70, 2  # columns of a span, and between two that are one
_MOST_GROUPS, _TRIED = 5, 4
_FOLLOWED = 0.75
"""Of a curve's columns: a legend hides some of it, and dashes leave gaps."""
_EVIDENCE, _OF_EACH, _OF_THREE = 40.0, 5.0, 60.0
"""Nats, of three curves in one panel; of each and of all three in panels of their own.

Of the first 130 other pictures of `python -m tests.benchmarks.handed_in` none has as much; at 25 in one panel a random walk had 31.
"""

_TOGETHER, _ALONE = (0, 1, 2), ((0,), (1,), (2,))
_Key = tuple[int, tuple[int, ...]]
"""A sensor, and which of its channels are on one scale."""
Pixels = NDArray[np.float32]


def sensors_shown(preview: np.ndarray, palette: np.ndarray, series: Mapping[str, Array]) -> set[int]:
    """Which sensors (0 acceleration, 1 angular velocity) a picture shows, each in places of its own.

    Parameters
    ----------
    preview : (h, w) ndarray of indices into `palette` (n, 3), 0 to 255
    series : ``time``, ``acceleration``, ``angular_velocity`` of the first moments of the recording
    """
    colours = np.divide(palette, 255, dtype=np.float32)
    shown: set[int] = set()
    for least in _INKS:
        spans = [(ink, span) for ink, its in _regions(preview, colours, least) for span in its]
        found = [_shown(group) for group in _groups(spans, series)]
        shown = max(found, key=len, default=shown)
        if len(shown) == 2:
            break
    return shown


# --- regions -------------------------------------------------------------------------------------------------------------


def _regions(preview: np.ndarray, palette: Pixels, least: float) -> Iterator[tuple[Ink, list[tuple[int, int]]]]:
    """What is drawn on each ground, and the columns from which to which curves may go there."""
    for rows, columns, ground in itertools.islice(_grounds(preview, palette), _MOST_REGIONS):
        part, off = preview[rows, columns], np.abs(palette - ground).max(axis=1)
        mask = (off > least)[part]
        if mask.mean() <= _MOST_INK:
            yield Ink.of(mask), _spans(mask, list(_colours(part, palette, off)))


def _grounds(preview: np.ndarray, palette: Pixels) -> Iterator[tuple[slice, slice, Pixels]]:
    """Rectangles that one colour fills for the most part: a figure, its panels, a window around it."""
    from scipy import ndimage  # noqa: PLC0415 - slow to import, and few submissions need it

    counts = np.bincount(preview.ravel(), minlength=len(palette))
    known: list[Pixels] = []
    for index in np.argsort(-counts):
        like = np.abs(palette - palette[index]).max(axis=1) < _ALIKE
        if counts[like].sum() < _SHARE * preview.size or len(known) == _MOST_GROUNDS:
            return
        if any(np.abs(palette[index] - colour).max() < _ALIKE for colour in known):
            continue
        known.append(palette[index])
        mask = like[preview]
        whole = ndimage.binary_closing(np.pad(mask, 3), np.ones((5, 5)))[3:-3, 3:-3]  # over grids and frames
        for rows, columns in ndimage.find_objects(ndimage.label(whole)[0]):
            part = mask[rows, columns]
            if part.size >= _SHARE * preview.size and part.mean() >= _FILLED:
                yield rows, columns, palette[index]


def _colours(part: np.ndarray, palette: Pixels, off: Pixels) -> Iterator[Mask]:
    """Where each strong colour stands, those of most pixels first."""
    counts = np.bincount(part.ravel(), minlength=len(palette))
    strong = np.flatnonzero((off >= _STRONG) & (counts >= _FEWEST_PIXELS))
    known: list[Pixels] = []
    for index in strong[np.argsort(-(counts * off)[strong], kind="stable")]:
        if all(np.abs(palette[index] - colour).max() >= _ONE_COLOUR for colour in known):
            known.append(palette[index])
            yield (np.abs(palette - palette[index]).max(axis=1) < _ONE_COLOUR)[part]
        if len(known) == _MOST_COLOURS:
            return


def _spans(mask: Mask, colours: Sequence[Mask]) -> list[tuple[int, int]]:
    """Return candidate column spans of the curves (end exclusive), for one, two or three panels side by side.

    They are how far each colour reaches, and the space between vertical borders, with and without the margin.
    """
    height, width = mask.shape
    borders = np.flatnonzero(_longest(mask) >= _LINE * height)
    found: list[tuple[int, int]] = []
    for abreast in (1, 2, 3):
        edges = [width * number // abreast for number in range(abreast + 1)]
        for left, right in itertools.pairwise(edges):
            for colour in colours:
                its = colour[:, left:right]
                columns = np.flatnonzero(its.any(axis=0))
                if len(columns) >= _SPANNED * (right - left) and its.mean() <= _DENSEST:
                    found.append((left + columns[0], left + columns[-1] + 1))
            between = borders[(borders >= left) & (borders < right)]
            if len(between):
                first, last = between[0], between[-1] + 1
                margin = round((last - first) * _MARGIN)
                found += [(first + margin, last - margin), (first, last)]
    spans: list[tuple[int, int]] = []
    for first, last in found:
        new = all(max(abs(first - other[0]), abs(last - other[1])) > _NEAR for other in spans)
        if new and last - first >= _NARROWEST:
            spans.append((first, last))
    return spans


def _longest(mask: Mask) -> NDArray[np.intp]:
    """The longest unbroken line in each column."""
    line = np.zeros(mask.shape[1], np.intp)
    longest = line
    for row in mask:
        line = (line + 1) * row
        longest = np.maximum(longest, line)
    return longest


# --- panels --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Group:
    """Places in panels that are equally wide and equally long in time, the likeliest first."""

    duration_s: float
    width: float
    places: Mapping[_Key, list[Place]]

    @property
    def promise(self) -> float:
        """Of both sensors, each in one panel or in three."""
        best = {key: its[0].promise for key, its in self.places.items()}
        alone = [sum(best.get((sensor, which), -1.0) for which in _ALONE) / 3 for sensor in (0, 1)]
        return sum(max(best.get((sensor, _TOGETHER), -1.0), alone[sensor]) for sensor in (0, 1))

    def is_like(self, other: _Group) -> bool:
        return self.duration_s == other.duration_s and _as_wide(self.width, other.width)


def _as_wide(width: float, other: float) -> bool:
    return abs(width - other) <= max(2 * _NEAR, 0.03 * other)


def _groups(spans: Sequence[tuple[Ink, tuple[int, int]]], series: Mapping[str, Array]) -> list[_Group]:
    """The groups in which both sensors may be shown, the likeliest few."""
    time = series["time"] - series["time"][0]
    groups: list[_Group] = []
    for duration in DURATIONS:
        found: list[tuple[_Key, Place]] = []
        for sensor, key in enumerate(("acceleration", "angular_velocity")):
            curves = Curves(time, series[key].T, duration)
            for ink, (first, last) in spans:
                found += [((sensor, which), place) for which, place in places(ink, first, last, curves)]
        for width in sorted({place.width for _, place in found}):
            its: dict[_Key, list[Place]] = {}
            for which, place in sorted(found, key=lambda each: -each[1].promise):
                if _as_wide(place.width, width):
                    its.setdefault(which, []).append(place)
            groups.append(_Group(duration, width, its))
    likeliest: list[_Group] = []
    for group in sorted(groups, key=lambda group: -group.promise):
        if not any(map(group.is_like, likeliest)):
            likeliest.append(group)
        if len(likeliest) == _MOST_GROUPS:
            break
    return likeliest


def _shown(group: _Group) -> set[int]:
    """The sensors that have a panel each, or three each."""
    in_one = {sensor for sensor in (0, 1) if _stands(_best(group, (sensor, _TOGETHER)), _EVIDENCE)}
    if len(in_one) == 2:
        return in_one
    in_three = set()
    for sensor in (0, 1):
        three = [_best(group, (sensor, which)) for which in _ALONE]
        if all(_stands(each, _OF_EACH) for each in three) and sum(each.evidence for each in three) >= _OF_THREE:
            in_three.add(sensor)
    return max(in_one, in_three, key=len)


def _best(group: _Group, key: _Key) -> Weight:
    tried = [weighed(settled(place)) for place in group.places.get(key, [])[:_TRIED]]
    followed = [weight for weight in tried if weight.followed >= _FOLLOWED]
    return max(followed, key=lambda weight: weight.evidence, default=Weight(0.0, 0.0))


def _stands(weight: Weight, evidence: float) -> bool:
    return weight.followed >= _FOLLOWED and weight.evidence >= evidence
