"""Which sensors a drawn curve may show, judged as generously as possible: to tell what no curve of a submission can be.

A picture does not tell the scale of a curve, what was taken off it or in which unit its time is: none of it counts here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from grader.engine.figures import Array, Curve
from grader.labs.imu.answers import SENSORS
from grader.labs.imu.diagnosis.handed_in import DURATIONS
from grader.labs.imu.diagnosis.plots import FEWEST_POINTS

_ALIKE = 0.5
"""Correlation. Ink that follows a channel to a pixel has 0.99, noise on a thousand points 0.1."""
_THE_SAME = 0.9999
"""Correlation of a curve that is a channel, in whatever unit: what the other sensor did meanwhile may have been like it."""
_FEWEST, _MOST_POINTS = 4, 1500


def sensors_of(curve: Curve, recordings: Sequence[Mapping[str, Array]]) -> set[int]:
    """Which sensors (0 acceleration, 1 angular velocity) it may show, of any of the recordings; none where it rests."""
    x, y = (values[:: -(-len(values) // _MOST_POINTS) or 1] for values in curve.points)
    like, same = np.zeros(len(SENSORS)), np.zeros(len(SENSORS))
    with np.errstate(all="ignore"):  # a student's numbers may overflow
        for series in recordings:
            for stamps in _abscissae(x, series["time"]):
                within = (stamps >= 0) & (stamps <= series["time"][-1])
                if np.count_nonzero(within) >= _FEWEST:
                    found = [_correlation(y[within], stamps[within], series["time"], series[key]) for key in SENSORS]
                    like = np.fmax(like, found)
                    if np.count_nonzero(within) >= FEWEST_POINTS:
                        same = np.fmax(same, found)
    known = same >= _THE_SAME
    return set(np.flatnonzero(known if known.any() else like >= _ALIKE).tolist())


def _abscissae(x: Array, time: Array) -> Iterator[Array]:
    """The moments that x may stand for: seconds, milliseconds, samples, or parts of a recording of a usual length."""
    if len(x) < _FEWEST or not (span := np.ptp(x)):
        return
    yield x
    yield x / 1000
    yield x + time[0]
    yield np.interp(x, np.arange(len(time)), time, right=np.inf)
    for duration in {*DURATIONS, time[-1] - time[0]}:
        yield time[0] + (x - x.min()) / span * duration


def _correlation(y: Array, stamps: Array, time: Array, channels: Array) -> float:
    """The largest, whatever its sign, with any of the channels (m, 3)."""
    largest = np.abs(y).max()
    if not largest:
        return 0.0
    curve = _normal(y / largest)
    return max(abs(float(curve @ _normal(np.interp(stamps, time, channel)))) for channel in channels.T)


def _normal(values: Array) -> Array:
    """Without its mean, of length 1; next to nothing where it rests."""
    off: Array = values - values.mean()
    length = np.linalg.norm(off)
    rests = length <= 1e-9 * np.abs(values).max() * np.sqrt(len(values))
    return off if rests else off / length
