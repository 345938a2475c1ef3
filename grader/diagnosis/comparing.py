"""Raw and filtered: whether a figure shows a series together with a smoother version of it."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..answers import Array, Arrays
from .labels import plain, unit_of
from .plots import FEWEST_POINTS, Facts, is_reference, name_of, points_of


@dataclass(frozen=True)
class Compared:
    """A curve and a smoother version of it, with the names that they carry."""

    raw: str
    smooth: str

    @property
    def exchanged(self) -> bool:
        return _says_smooth(self.raw) and _says_raw(self.smooth)

    @property
    def in_order(self) -> bool:
        return _says_raw(self.raw) or _says_smooth(self.smooth)


def comparisons(figure: Facts, arrays: Arrays) -> list[Compared]:
    """The raw series with smoother versions of them in a figure, on the same axes or on axes in the same unit."""
    drawn = [(axes, curve) for axes in figure["axes"] if axes["visible"] for curve in _long_curves(axes, arrays)]
    return [
        Compared(_name_on(above, raw), _name_on(below, smooth))
        for above, raw in drawn
        for below, smooth in drawn
        if raw is not smooth
        and (above is below or unit_of(above["ylabel"]) == unit_of(below["ylabel"]))
        and _is_smoothed(*_at_the_same_points(points_of(raw, arrays), points_of(smooth, arrays)))
    ]


def named_comparisons(figure: Facts, arrays: Arrays) -> list[Compared]:
    """Curves under the names of raw and filtered data in a figure, whatever the filter has made of them."""
    names = [
        _name_on(axes, curve) for axes in figure["axes"] if axes["visible"] for curve in _long_curves(axes, arrays)
    ]
    return [Compared(raw, smooth) for raw in names for smooth in names if _says_raw(raw) and _says_smooth(smooth)]


def series_drawn(figure: Facts, arrays: Arrays) -> list[Array]:
    """The values of every curve of data in a figure."""
    return [points_of(c, arrays)[1] for axes in figure["axes"] if axes["visible"] for c in _long_curves(axes, arrays)]


def _name_on(axes: Facts, curve: Facts) -> str:
    return name_of(curve, axes["legend"] or (), axes["texts"]) or ""


_RAW_WORDS = re.compile(
    r"raw|(?<!de)(?<!de-)nois[ey]|unfilter|before|input|avant|antes|vordem|滤波前|measured|roh|ungefiltert|verrauscht|brut|crud|sinfiltrar|ruido|原始|噪|сыр"
)
_SMOOTH_WORDS = re.compile(r"filt|smooth|de-?nois|lowpass|low-pass|lpf|geglätt|liss|suaviz|滤|平滑|сглаж")


def _says_raw(name: str) -> bool:
    return bool(_RAW_WORDS.search(plain(name)))


def _says_smooth(name: str) -> bool:
    return bool(_SMOOTH_WORDS.search(plain(name))) and not _says_raw(name)


def _long_curves(axes: Facts, arrays: Arrays) -> list[Facts]:
    drawn = [c for c in axes["curves"] if c["visible"] and c["kind"] != "nothing"]
    long = [c for c in drawn if not is_reference(arrays[c["x"]], arrays[c["y"]])]
    return [c for c in long if len(points_of(c, arrays)[1]) >= FEWEST_POINTS]


def _at_the_same_points(raw: tuple[Array, Array], smooth: tuple[Array, Array]) -> tuple[Array, Array, int]:
    """The values of both curves row by row, where both are drawn, and how many rows there are to a point of the shorter one."""
    if len(raw[0]) == len(smooth[0]):
        return raw[1], smooth[1], 1
    shorter, longer = sorted((raw[0], smooth[0]), key=len)
    x = longer[(longer >= shorter.min()) & (longer <= shorter.max())]
    return np.interp(x, *raw), np.interp(x, *smooth), len(longer) // len(shorter)


def _is_smoothed(raw: Array, smooth: Array, step: int) -> bool:
    """Whether one series is smoother than the other and goes where its running mean goes, at some lag.

    An exponential average follows a running mean with a correlation of 0.85 and more, whatever alpha; two different channels of a
    standing robot stay below 0.5. The second half is looked at: a filter may start from zero. Of a thinned curve every `step`-th
    value counts as drawn; the values between them lie on straight lines, and are no smoother for it.
    """
    if len(raw) < FEWEST_POINTS or np.std(np.diff(smooth[::step])) > 0.8 * np.std(np.diff(raw[::step])):
        return False
    return any(_follows(raw, smooth, window) for window in (3, 9, 27, 81) if 4 * window < len(raw))


def _follows(raw: Array, smooth: Array, window: int) -> bool:
    mean = np.convolve(raw, np.full(window, 1 / window), mode="valid")
    lags = range(0, min(2 * window, len(mean) // 4) + 1)
    return any(_alike(mean, smooth[window // 2 + lag :]) for lag in lags)


def _alike(wanted: Array, got: Array) -> bool:
    n = min(len(wanted), len(got))
    a, b = wanted[n // 2 : n] - wanted[n // 2 : n].mean(), got[n // 2 : n] - got[n // 2 : n].mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    near = abs(float(wanted[n // 2 : n].mean() - got[n // 2 : n].mean())) <= 3 * float(np.std(a)) + 1e-12
    as_large = 0.25 < float(np.std(b)) / max(float(np.std(a)), 1e-300) < 4
    return power > 0 and float(a @ b) / power > 0.75 and near and as_large
