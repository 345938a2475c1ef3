"""Search of a figure for raw and filtered data: for curves of which one is a smoother version of another."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np

from grader.engine.figures import Axes, Curve, Figure
from grader.labs.imu.returned import Array
from grader.labs.imu.visualization.curves import FEWEST_POINTS, is_reference, name_of
from grader.labs.imu.visualization.labels import says_raw, says_smooth, unit_of

Drawn = tuple[Axes, Curve]
_SMOOTHER = 0.8  # of the raw series' differences from value to value
_MOST_POINTS = 5000
"""Points of a curve that are compared, its last: twice what the lab records."""
_MOST_PAIRS = 1000
"""Pairs of curves of a figure that are compared: six channels with five filtered versions of each."""
_TURNS = 0.25
"""Share of neighbouring second differences that change sign, of a series with noise in it. White noise has 0.73, the lab's own
noise on the lab's signals 0.55 and more, however thinned; clean signals 0.01 to 0.12, and 0.23 where every fifth value is drawn."""
_LIKENESS = 0.75
"""Least correlation of a filtered series with the running mean of the raw one.

An exponential average has 0.85 and more, whatever alpha; two different channels of a standing robot stay below 0.5.
"""
_WINDOWS = (3, 9, 27, 81)
"""Lengths of the running means, in samples."""
_ROUNDING = 1e-5
"""Share of the largest value below which second differences come from digits that were cut off."""


@dataclass(frozen=True)
class Compared:
    """A raw and a filtered curve of one figure: their names by legend or text ("" for none), and whether the raw curve is noisy."""

    raw: str
    smooth: str
    noisy: bool

    @property
    def exchanged(self) -> bool:
        return says_smooth(self.raw) and says_raw(self.smooth)

    @property
    def in_order(self) -> bool:
        return says_raw(self.raw) or says_smooth(self.smooth)


def comparisons(figure: Figure) -> list[Compared]:
    """Return each visible pair of a curve and a smoother version of it; curves on axes with different units make no pair.

    Nor do curves of two panels without noise and without names such as *raw*: a rotation is smoother than the acceleration that
    comes with it.
    """
    drawn = _seen_curves(figure)
    pairs = (
        (one, other) for one in drawn for other in drawn if one is not other and _may_be_in_one_unit(one[0], other[0])
    )
    smoothed = (pair for pair in islice(pairs, _MOST_PAIRS) if _is_smoothed(pair[0][1], pair[1][1]))
    return [
        found
        for raw, smooth in smoothed
        if (found := _compared(raw, smooth)).noisy or raw[0] is smooth[0] or found.in_order or found.exchanged
    ]


def _compared(raw: Drawn, smooth: Drawn) -> Compared:
    return Compared(_name_on(*raw), _name_on(*smooth), _has_noise(_last_points(raw[1])[1]))


def _may_be_in_one_unit(one: Axes, other: Axes) -> bool:
    """Return whether two axes may have one unit, so that their curves may be compared; a label without a unit agrees with any."""
    units = {unit for axes in (one, other) if (unit := unit_of(axes.ylabel)) is not None}
    return one is other or len(units) < 2


def _last_points(curve: Curve) -> tuple[Array, Array]:
    x, y = curve.points
    return x[-_MOST_POINTS:], y[-_MOST_POINTS:]


def named_comparisons(figure: Figure) -> list[Compared]:
    """Return each visible pair of a curve named raw and one named filtered, smoother or not, as the filter may be broken."""
    drawn = _seen_curves(figure)
    raw, smooth = ([each for each in drawn if says(_name_on(*each))] for says in (says_raw, says_smooth))
    return [_compared(one, other) for one in raw for other in smooth]


def in_words(figure: Figure) -> tuple[int, str]:
    """Return the number of curves in a figure without a comparison, and in words what it shows instead, for the message."""
    series = [curve.points[1] for axes in figure.visible_axes for curve in _curves(axes)]
    said = f"{len(series)} curves, none of which is a smoother version of another over {FEWEST_POINTS} samples or more"
    if len(series) < 2:
        said = f"a plot with {'only one curve' if series else 'no curve that changes'}"
    elif all(np.array_equal(one, series[0]) for one in series):
        said = "a plot that shows the same numbers in every curve"
    elif len(_seen_curves(figure)) < sum(len(_long_curves(axes)) for axes in figure.axes):
        said = "a plot on which a curve cannot be seen"
    return len(series), said


def _name_on(axes: Axes, curve: Curve) -> str:
    return name_of(curve, axes.legend, axes.texts) or ""


def _seen_curves(figure: Figure) -> list[Drawn]:
    drawn = ((axes, curve) for axes in figure.visible_axes for curve in _long_curves(axes))
    return [(axes, curve) for axes, curve in drawn if curve.visible and curve.visible_parts.seen.any()]


def _curves(axes: Axes) -> list[Curve]:
    return [curve for curve in axes.curves if curve.kind != "nothing" and not is_reference(curve)]


def _long_curves(axes: Axes) -> list[Curve]:
    return [curve for curve in _curves(axes) if len(curve.points[1]) >= FEWEST_POINTS]


def _at_the_same_points(one: Curve, other: Curve) -> tuple[Array, Array, int]:
    """Return the values of two curves at the same x values, and how many of these there are to a point of the shorter curve."""
    (x, y), (its_x, its_y) = _last_points(one), _last_points(other)
    if len(x) == len(its_x):
        return y, its_y, 1
    fewer, more = sorted((x, its_x), key=len)
    at = more[(more >= fewer.min()) & (more <= fewer.max())]
    return np.interp(at, x, y), np.interp(at, its_x, its_y), len(more) // len(fewer)


def _is_smoothed(raw: Curve, smooth: Curve) -> bool:
    """Return whether `smooth` is a filtered form of `raw`: it changes less from value to value, and follows its running mean.

    With noise in the raw data it is enough if the second half changes less, as a filter may climb from zero. Without noise it is
    not: each clean channel is smoother than some other one while a robot comes to rest. Of a thinned curve the drawn values count:
    those between them lie on straight lines, and are no smoother for it. False if fewer than 50 values can be compared.
    """
    values, its_values, step = _at_the_same_points(raw, smooth)
    if len(values) < FEWEST_POINTS:
        return False
    steps, its_steps = np.diff(values[::step]), np.diff(its_values[::step])
    begins = (0, len(steps) // 2) if _has_noise(values[::step]) else (0,)
    if not any(np.std(its_steps[n:]) <= _SMOOTHER * np.std(steps[n:]) for n in begins):
        return False
    return any(_follows(values, its_values, window) for window in _WINDOWS if 4 * window < len(values))


def _has_noise(raw: Array) -> bool:
    """Return whether a series has noise in it: it goes up and down from value to value, by however little."""
    bends = np.diff(raw, 2)
    bends = bends[np.abs(bends) > _ROUNDING * np.abs(raw).max()]
    return len(bends) > 1 and float(np.mean(bends[1:] * bends[:-1] < 0)) > _TURNS


def _follows(raw: Array, smooth: Array, window: int) -> bool:
    """Return whether the second half of `smooth` goes where the running mean of `raw` goes, with a lag of at most two windows."""
    mean = np.convolve(raw, np.full(window, 1 / window), mode="same")[: len(raw) - window // 2]
    half = len(raw) // 2
    lags = range(0, min(2 * window, len(raw) // 4) + 1, max(1, window // 8))
    return any(_alike(mean[half - lag : len(smooth) - lag], smooth[half : len(mean) + lag]) for lag in lags)


def _alike(wanted: Array, got: Array) -> bool:
    """Return whether two series agree in shape, level and size, as a filtered series and the running mean of the raw one do."""
    width, its_width = (float(np.std(each)) for each in (wanted, got))
    level, its_level = (float(np.mean(each)) for each in (wanted, got))
    likeness = float(np.mean((wanted - level) * (got - its_level)))
    near = abs(level - its_level) <= 3 * width + 1e-12
    return near and likeness > _LIKENESS * width * its_width and 0.25 * width < its_width < 4 * width
