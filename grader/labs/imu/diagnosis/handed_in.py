"""Looking at a picture that no code draws: which of the two sensors' recordings it shows, by curves and colours alone.

Where a panel lies and what its limits are is not known; that it is one map from values to rows for all three of its curves is.
The liveliest channel is looked for in every colour, whatever its map; under the map that is found the other two must stand in
colours of their own. Words cannot be read from pixels here.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grader.engine.figures import Array, Mask
from grader.labs.imu.diagnosis.sight import Pixels, commonest

_DURATIONS = (5.0, 3.0, 10.0, 2.0, 1.2)  # s: the sheet's first
_STRONG, _WEAK = (
    0.35,
    0.12,
)  # difference from the ground, each channel 0 to 1, of an ink and of what is left of it in a thin line
_SAME, _ALIKE = 0.2, 0.35
"""Largest difference of two hues, of one ink and of one that is mixed with others."""
_MOST_INKS, _FEWEST_PIXELS = 8, 25
_SPANNED, _DENSEST = 0.5, 0.2  # of the columns of a region by a curve, and the most of its rows
_FEWEST_COLUMNS, _MOST_SPANS = 40, 4
_HEIGHTS = 0.93 ** np.arange(42)  # of a region, by the liveliest channel: from all of it to a twentieth
_NEAR = 2  # rows
_LIVELY = 20  # rows that the liveliest channel goes up and down
_FOLLOWED, _OWN = 0.75, 0.15
"""Of the columns: where a channel, or one that lies over it, stands in its place; where its own colour does.

The sheet's figure at 40 to 300 dpi, in eight styles, as JPEG, in three window frames and over 3, 5 and 10 s shows both sensors; in
greys, in the style `classic` and dark in a light window it is not recognised. Of twelve figures of the same form with sines,
walks and noise none shows both.
"""


def sensors_shown(preview: np.ndarray, palette: np.ndarray, series: Mapping[str, Array]) -> set[int]:
    """Which sensors (0 acceleration, 1 angular velocity) a picture shows, each in a place of its own.

    Parameters
    ----------
    preview : (h, w) ndarray of indices into `palette` (n, 3), 0 to 255
    series : ``time``, ``acceleration``, ``angular_velocity`` of the first moments of the recording
    """
    strokes = _strokes(np.divide(palette, 255, dtype=np.float32)[preview])
    width, time = preview.shape[1], series["time"] - series["time"][0]
    sensors = [series[key] for key in ("acceleration", "angular_velocity")]
    shown: set[int] = set()
    for columns in (slice(0, width), slice(0, width // 2), slice(width // 2, width)):
        curves = [stroke[:, columns] for stroke in strokes]
        for duration, (first, last) in itertools.product(_DURATIONS, _spans(curves)):
            at = np.arange(first, last)
            stamps = (at - first) * (duration / (last - first))
            at, stamps = at[stamps <= time[-1]], stamps[stamps <= time[-1]]
            if len(at) < _FEWEST_COLUMNS:
                continue
            parts = [curve[:, at] for curve in curves]
            for sensor in {0, 1} - shown:
                if _shows(parts, np.array([np.interp(stamps, time, channel) for channel in sensors[sensor].T])):
                    shown.add(sensor)
            if len(shown) == 2:
                return shown
    return shown


# --- colours -------------------------------------------------------------------------------------------------------------


def _strokes(picture: Pixels) -> list[Mask]:
    """Where each strong colour stands; each pixel has that one which it is nearest to."""
    off = picture - commonest(picture).astype(np.float32)
    strength, hues = np.abs(off).max(axis=2), _hues(off)
    inks = list(itertools.islice(_inks(off), 2 * _MOST_INKS))
    if not inks:
        return []
    unlike = np.stack([np.abs(hues - ink).max(axis=2) for ink in inks])
    nearest = np.where((strength > _WEAK) & (unlike.min(axis=0) < _ALIKE), unlike.argmin(axis=0), -1)
    found = [nearest == number for number in range(len(inks))]
    return sorted(found, key=lambda stroke: -int(stroke.any(axis=0).sum()))[:_MOST_INKS]


def _inks(off: Pixels) -> Iterator[Pixels]:
    """The hues of the strong colours, those of most pixels first."""
    colours, counts = np.unique(off.reshape(-1, 3), axis=0, return_counts=True)
    lengths, hues = np.abs(colours).max(axis=1), _hues(colours)
    known: list[Pixels] = []
    for index in np.argsort(-counts * lengths):
        hue = hues[index]
        strong = lengths[index] > _STRONG and counts[index] >= _FEWEST_PIXELS
        if strong and all(np.abs(hue - ink).max() > _SAME for ink in known):
            known.append(hue)
            yield hue


def _hues(off: Pixels) -> Pixels:
    """The ways from the ground, each by its largest part."""
    hues: Pixels = off / np.maximum(np.abs(off).max(axis=-1, keepdims=True), 1e-6)
    return hues


def _spans(strokes: Sequence[Mask]) -> list[tuple[int, int]]:
    """First and last column of what may be curves, those that differ."""
    spans: list[tuple[int, int]] = []
    for stroke in strokes:
        columns = np.flatnonzero(stroke.any(axis=0))
        if len(columns) < _SPANNED * stroke.shape[1] or stroke.mean() > _DENSEST:
            continue
        span = int(columns[0]), int(columns[-1]) + 1
        if all(max(abs(span[0] - first), abs(span[1] - last)) > _NEAR for first, last in spans):
            spans.append(span)
    return spans[:_MOST_SPANS]


# --- curves --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Map:
    """From values to rows: `row = start + slope * value`; the slope is negative, rows count downwards."""

    start: float
    slope: float

    def rows(self, values: Array) -> Array:
        return self.start + self.slope * values


def _shows(strokes: Sequence[Mask], channels: Array) -> bool:
    """Whether three strokes follow the three channels (3, n) by one map; the strokes are masks (h, n)."""
    liveliest = int(np.std(channels, axis=1).argmax())
    thin = [stroke for stroke in strokes if 0 < stroke.mean() < _DENSEST]
    widened = [_near(stroke) for stroke in thin]
    for stroke in thin:
        found = _map_of(stroke, channels[liveliest])
        if found is not None and _all_follow(widened, found, channels, liveliest):
            return True
    return False


def _near(stroke: Mask) -> Mask:
    """A stroke and the rows next to it."""
    near: Mask = stroke.copy()
    for step in range(1, _NEAR + 1):
        near[step:] |= stroke[:-step]
        near[:-step] |= stroke[step:]
    return near


def _map_of(stroke: Mask, values: Array) -> _Map | None:
    """The map under which most columns of a stroke follow a channel; None where few do."""
    rows, columns = np.nonzero(stroke)
    height, spread = len(stroke), float(np.ptp(values))
    if spread <= 0 or np.count_nonzero(stroke.any(axis=0)) < _FOLLOWED * stroke.shape[1]:
        return None
    best, found = 0, None
    for share in _HEIGHTS:
        slope = -share * height / spread
        starts = ((rows - slope * (values[columns] - values.max())) / _NEAR).astype(np.intp)
        fits = (starts >= 0) & (starts < height)
        there = np.zeros((height, stroke.shape[1]), bool)
        there[starts[fits], columns[fits]] = True
        votes = np.count_nonzero(there[:-1] | there[1:], axis=1)
        if votes.max() > best:
            best = int(votes.max())
            found = _Map((int(votes.argmax()) + 1) * _NEAR - slope * float(values.max()), slope)
    if found is None or best < _FOLLOWED / 2 * stroke.shape[1]:
        return None
    return _refined(found, rows.astype(float), values[columns])


def _refined(found: _Map, rows: Array, values: Array) -> _Map | None:
    """The straight line through the pixels that a map goes near, a few times over."""
    for reach in (3 * _NEAR, 2 * _NEAR, _NEAR):
        near = np.abs(rows - found.rows(values)) <= reach
        if np.count_nonzero(near) < _FEWEST_COLUMNS or np.ptp(values[near]) <= 0:
            return None
        slope, start = np.polyfit(values[near], rows[near], 1)
        found = _Map(float(start), float(slope))
    return found if found.slope < 0 else None


def _all_follow(strokes: Sequence[Mask], found: _Map, channels: Array, liveliest: int) -> bool:
    """Whether each channel stands where the map has it, in a stroke of its own or under another channel's."""
    rows = found.rows(channels)
    if np.ptp(rows[liveliest]) < _LIVELY:
        return False
    at, columns = np.rint(rows).astype(np.intp), np.arange(rows.shape[1])
    within = (at >= 0) & (at < len(strokes[0]))
    stands = np.array([stroke[np.clip(at, 0, len(stroke) - 1), columns] & within for stroke in strokes])
    likely = stands.mean(axis=2) > _OWN
    for three in itertools.product(*(np.flatnonzero(likely[:, channel]) for channel in range(3))):
        if len(set(three)) < 3:
            continue
        own = np.array([stands[stroke, channel] for channel, stroke in enumerate(three)])
        covered = np.array([
            np.any([own[other] & (np.abs(at[other] - at[k]) <= _NEAR) for other in range(3) if other != k], axis=0)
            for k in range(3)
        ])  # fmt: skip
        followed = (own | covered).mean(axis=1)
        if followed.min() > _FOLLOWED and own[liveliest].mean() > _FOLLOWED:
            return True
    return False
