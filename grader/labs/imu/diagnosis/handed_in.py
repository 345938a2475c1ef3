"""Looking at a picture that no code draws: which of the two sensors' recordings it shows, by curves and colours alone.

Three strokes of different colours, one above or beside the other three, are held against the true channels. Where a panel lies and
what its limits are is not known; that it is one map for all three of its curves is. Words cannot be read from pixels here.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping

import numpy as np

from grader.labs.imu.diagnosis.sight import Array, Mask, Pixels, commonest, share_of_way

_DURATIONS = (5.0, 3.0, 10.0, 2.0, 1.2)  # s: the sheet's first
_STRONG = 0.25  # difference from the ground, each channel 0 to 1
_SAME_COLOUR = 0.993  # cosine of the ways from the ground
_MOST_INKS, _FEWEST_PIXELS = 6, 25
_COVERED = 0.6  # of the columns of a region by a curve
_SPLITS = (0.5, 0.45, 0.55, 0.4, 0.6)
_TOGETHER, _ALONE = 0.95, 0.8
"""Correlation of three curves by one map, and of the liveliest alone; the sheet's own picture at 50 to 200 dpi has 0.98 and 0.9."""
_FEWEST_COLUMNS = 20
_LIVELY = 3.0  # pixels
_TRIMMED = 0.8  # what is kept: a legend lies over some columns


def sensors_shown(preview: np.ndarray, palette: np.ndarray, series: Mapping[str, Array]) -> set[int]:
    """Which sensors (0 acceleration, 1 angular velocity) a picture shows, each in a region of its own.

    Parameters
    ----------
    preview : (h, w) ndarray of indices into `palette` (n, 3), 0 to 255
    series : ``time``, ``acceleration``, ``angular_velocity`` of the first moments of the recording
    """
    picture = np.divide(palette, 255, dtype=np.float32)[preview]
    strokes = _strokes(picture)
    if len(strokes) < 3:
        return set()
    best: set[int] = set()
    for halves in _halves(_content(strokes)):
        tracks = [[track for stroke in strokes if (track := _track(stroke, half)) is not None] for half in halves]
        for first in (0, 1):
            shown = {first} if _shows(tracks[0], first, series) else set()
            shown |= {1 - first} if _shows(tracks[1], 1 - first, series) else set()
            best = max(best, shown, key=len)
        if len(best) == 2:
            break
    return best


def _strokes(picture: Pixels) -> list[Pixels]:
    """How much of each strong colour is in each pixel."""
    ground = commonest(picture)
    colours, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    ways = colours - ground
    lengths = np.abs(ways).max(axis=1)
    inks: list[Array] = []
    for index in np.argsort(-lengths):
        way = ways[index].astype(float)
        alike = any(way @ ink > _SAME_COLOUR * np.linalg.norm(way) * np.linalg.norm(ink) for ink in inks)
        if lengths[index] > _STRONG and counts[index] >= _FEWEST_PIXELS and not alike:
            inks.append(way)
    off = (picture - ground.astype(np.float32)).reshape(-1, 3)
    found = [share_of_way(off, ink).reshape(picture.shape[:2]) for ink in inks[: 2 * _MOST_INKS]]
    return sorted(found, key=lambda stroke: -np.count_nonzero(stroke.max(axis=0) > 0.3))[:_MOST_INKS]


Region = tuple[slice, slice]


def _content(strokes: list[Pixels]) -> Region:
    drawn = np.max(strokes, axis=0) > 0.3
    rows, columns = (np.flatnonzero(drawn.any(axis=axis)) for axis in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _halves(content: Region) -> Iterator[tuple[Region, Region]]:
    """Two panels, one above the other or side by side."""
    rows, columns = content
    for share in _SPLITS:
        cut = rows.start + round(share * (rows.stop - rows.start))
        yield (slice(rows.start, cut), columns), (slice(cut, rows.stop), columns)
    for share in _SPLITS:
        cut = columns.start + round(share * (columns.stop - columns.start))
        yield (rows, slice(columns.start, cut)), (rows, slice(cut, columns.stop))


def _track(stroke: Pixels, region: Region) -> Array | None:
    """The row of a stroke, column by column, from its first column to its last; None where it is no curve."""
    part = np.where(stroke[region] > 0.3, stroke[region], 0)
    weight = part.sum(axis=0)
    columns = np.flatnonzero(weight > 0)
    if not len(columns) or len(columns) < _COVERED * part.shape[1]:
        return None
    with np.errstate(all="ignore"):
        rows = (part * np.arange(len(part))[:, None]).sum(axis=0) / weight
    track: Array = rows[columns[0] : columns[-1] + 1].astype(float)
    return track


def _shows(tracks: list[Array], sensor: int, series: Mapping[str, Array]) -> bool:
    channels, time = series[("acceleration", "angular_velocity")[sensor]], series["time"] - series["time"][0]
    return any(_fit_together([_Held(track, channels, time, duration) for track in tracks]) for duration in _DURATIONS)


class _Held:
    """The columns of a track that fall into the known moments, and what the three channels are there."""

    def __init__(self, track: Array, channels: Array, time: Array, duration: float) -> None:
        stamps = np.linspace(0, duration, len(track))
        within = (stamps <= time[-1]) & np.isfinite(track)
        self.heights = -track[within]
        self.values = [np.interp(stamps[within], time, channel) for channel in channels.T]
        self.alike = [self._follows(values) for values in self.values]

    def _follows(self, values: Array) -> bool:
        """Whether it goes where a channel goes, as far as it goes anywhere."""
        known = len(values) >= _FEWEST_COLUMNS and np.ptp(self.heights) > _LIVELY
        return bool(known and _correlation(self.heights, values) > _ALONE)


def _fit_together(tracks: list[_Held]) -> bool:
    """Whether three tracks follow the three channels by one map from values to heights, one of them by itself."""
    for three in itertools.permutations(tracks, 3):
        if not any(track.alike[axis] for axis, track in enumerate(three)):
            continue
        heights = np.concatenate([track.heights for track in three])
        values = np.concatenate([track.values[axis] for axis, track in enumerate(three)])
        if min(len(track.heights) for track in three) >= _FEWEST_COLUMNS and np.ptp(values) > 0 and np.ptp(heights) > 0:
            kept = _trimmed(heights, values)
            if _correlation(heights[kept], values[kept]) > _TOGETHER:
                return True
    return False


def _trimmed(y: Array, v: Array) -> Mask:
    """The columns that lie nearest to a straight line."""
    off = np.abs(y - np.polyval(np.polyfit(v, y, 1), v))
    kept: Mask = off <= np.quantile(off, _TRIMMED)
    return kept


def _correlation(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b / max(float(np.sqrt((a @ a) * (b @ b))), 1e-300))
