"""Raw and filtered: whether a figure shows a series together with a smoother version of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import Axes, Curve, Figure
from grader.labs.imu.answers import Array
from grader.labs.imu.visualization.curves import FEWEST_POINTS, is_reference, name_of
from grader.labs.imu.visualization.labels import says_raw, says_smooth, unit_of

Index = NDArray[np.intp]

_SEEN = 0.05
"""Least share of a curve that is seen; a comparison may be a detail."""
_SMOOTHER = 0.8  # of the raw series' differences from value to value
_MOST_POINTS = 20_000
"""Points of a curve that are compared, its last: eight times what the lab records."""
_MOST_PAIRS = 1000
"""Pairs of curves of a figure that are compared: six channels with five filtered versions of each."""
_TURNS = 0.25
"""Share of neighbouring second differences that change sign, of a series with noise in it. White noise has 0.73, the lab's own
noise on the lab's signals 0.55 and more, however thinned; clean signals 0.01 to 0.12, and 0.23 where every fifth value is drawn."""
_LIKENESS = 0.75
"""Correlation of a series with its smoother version."""
_ROUNDING = 1e-5
"""Share of the largest value below which second differences come from digits that were cut off."""


@dataclass(frozen=True)
class Compared:
    """A curve and a smoother version of it, with the names that they carry, and whether there is noise in the curve."""

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
    """The raw series with smoother versions of them in a figure, on the same axes or on axes that may be in the same unit."""
    drawn = _seen_curves(figure)
    pairs = (
        (above, raw, below, smooth)
        for above, raw in drawn
        for below, smooth in drawn
        if raw is not smooth and _may_be_in_one_unit(above, below)
    )
    named = (
        (Compared(_name_on(above, raw), _name_on(below, smooth), _has_noise(_last_points(raw)[1])), raw, smooth)
        for above, raw, below, smooth in islice(pairs, _MOST_PAIRS)
    )
    return [
        compared
        for compared, raw, smooth in named
        if _is_smoothed(*_at_the_same_points(_last_points(raw), _last_points(smooth)))
    ]


def _may_be_in_one_unit(one: Axes, other: Axes) -> bool:
    """Axes without a unit on their label may be in any."""
    units = {unit for axes in (one, other) if (unit := unit_of(axes.ylabel)) is not None}
    return one is other or len(units) < 2


def _last_points(curve: Curve) -> tuple[Array, Array]:
    x, y = curve.points
    return x[-_MOST_POINTS:], y[-_MOST_POINTS:]


def named_comparisons(figure: Figure) -> list[Compared]:
    """Curves under the names of raw and filtered data in a figure, whatever the filter has made of them."""
    named = [(_name_on(axes, curve), curve) for axes, curve in _seen_curves(figure)]
    return [
        Compared(raw, smooth, _has_noise(_last_points(curve)[1]))
        for raw, curve in named if says_raw(raw)
        for smooth, _ in named if says_smooth(smooth)
    ]  # fmt: skip


def _is_smoother(raw: Array, smooth: Array) -> bool:
    """Return whether its differences from value to value are smaller; with noise, of the second half as well: a filter may climb.

    Of clean channels each is smoother than some other one while a robot comes to rest.
    """
    steps, its_steps = np.diff(raw), np.diff(smooth)
    begins = (0, len(steps) // 2) if _has_noise(raw) else (0,)
    return any(np.std(its_steps[n:]) <= _SMOOTHER * np.std(steps[n:]) for n in begins)


def in_words(figure: Figure) -> tuple[int, str]:
    """Return the number of curves of a figure that compares nothing, and what they are in words."""
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


def _seen_curves(figure: Figure) -> list[tuple[Axes, Curve]]:
    return [(axes, curve) for axes in figure.visible_axes for curve in _long_curves(axes) if _is_seen(curve)]


def _is_seen(curve: Curve) -> bool:
    return curve.visible and float(curve.visible_parts.seen.mean()) >= _SEEN


def _curves(axes: Axes) -> list[Curve]:
    return [curve for curve in axes.curves if curve.kind != "nothing" and not is_reference(curve)]


def _long_curves(axes: Axes) -> list[Curve]:
    return [curve for curve in _curves(axes) if len(curve.points[1]) >= FEWEST_POINTS]


def _at_the_same_points(raw: tuple[Array, Array], smooth: tuple[Array, Array]) -> tuple[Array, Array, int]:
    """The values of both curves row by row, where both are drawn, and how many rows there are to a point of the shorter one."""
    if len(raw[0]) == len(smooth[0]):
        return raw[1], smooth[1], 1
    shorter, longer = sorted((raw[0], smooth[0]), key=len)
    x = longer[(longer >= shorter.min()) & (longer <= shorter.max())]
    return np.interp(x, *raw), np.interp(x, *smooth), len(longer) // len(shorter)


def _is_smoothed(raw: Array, smooth: Array, step: int) -> bool:
    """Return whether one series is smoother than the other and goes where its running mean goes, at some lag.

    An exponential average follows a running mean with a correlation of 0.85 and more, whatever alpha; two different channels of a
    standing robot stay below 0.5. The second half is looked at: a filter may start from zero. Of a thinned curve every `step`-th
    value counts as drawn; the values between them lie on straight lines, and are no smoother for it.
    """
    if len(raw) < FEWEST_POINTS or not _is_smoother(raw[::step], smooth[::step]):
        return False
    windows = [window for window in (3, 9, 27, 81) if 4 * window < len(raw)]
    return any(_follows(raw, smooth, window) for window in windows)


def _has_noise(raw: Array) -> bool:
    """Return whether a series goes up and down from value to value, by however little."""
    bends = np.diff(raw, 2)
    bends = bends[np.abs(bends) > _ROUNDING * np.abs(raw).max()]
    return len(bends) > 1 and float(np.mean(bends[1:] * bends[:-1] < 0)) > _TURNS


def _follows(raw: Array, smooth: Array, window: int) -> bool:
    """Return whether a series goes where the running mean of another goes at one of the lags; the second half of each is looked at.

    Both are as long, and longer than four windows: a lag leaves two thirds of the rows.
    """
    mean = np.convolve(raw, np.full(window, 1 / window), mode="valid")
    lags = np.arange(min(2 * window, len(mean) // 4) + 1)
    ends = np.minimum(len(mean), len(smooth) - window // 2 - lags)
    cut = int(ends.min()) // 2
    wanted, got = mean[cut:], smooth[window // 2 + cut :]
    level = float(wanted.mean())  # what both are measured from: sums of squares then lose no digits
    return _alike(wanted - level, got - level, (ends // 2 - cut, ends - cut), lags)


def _alike(wanted: Array, got: Array, rows: tuple[Index, Index], lags: Index) -> bool:
    """Return whether rows `begins` to `ends` of both agree in shape, level and size at one of the lags; all lags at once."""
    begins, ends = rows
    means, widths = _moments(wanted, begins, ends)
    its_means, its_widths = _moments(got, begins + lags, ends + lags)
    each = zip(begins, ends, lags, strict=True)
    products = np.array([wanted[first:end] @ got[first + lag : end + lag] for first, end, lag in each])
    alike = products / (ends - begins) - means * its_means > _LIKENESS * widths * its_widths
    near = np.abs(means - its_means) <= 3 * widths + 1e-12
    as_large = (its_widths > 0.25 * widths) & (its_widths < 4 * widths)
    return bool(np.any(alike & near & as_large))


def _moments(values: Array, begins: Index, ends: Index) -> tuple[Array, Array]:
    """Mean and standard deviation of many runs of rows, by running sums."""
    sums, squares = (np.concatenate(([0.0], np.cumsum(power))) for power in (values, values**2))
    count = ends - begins
    means = (sums[ends] - sums[begins]) / count
    variances = (squares[ends] - squares[begins]) / count - means**2
    rounding = 1e-13 * float(np.max(values**2, initial=0.0))
    return means, np.sqrt(np.where(variances > rounding, variances, 0.0))
