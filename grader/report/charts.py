"""Lay out the charts of a report as SVG: scales, ticks, lines and bars, and a sentence for screen readers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, compress, repeat

from grader.engine.chart_data import Chart, Curve, Panel

WIDTH, HEIGHT = 480, 220
_TOP, _BOTTOM, _RIGHT = 8, 26, 10
_DIGIT = 7.6  # width of a digit in the tick font, in SVG units
_INTERVALS = 5  # approximate number of tick intervals
_WIDE = ("true-x", "true-y", "true-z", "wanted")
_SPOKEN = {"bars": "bars", "model": "dashed line", "not-seen": "not visible in the picture"} | dict.fromkeys(
    _WIDE, "wide line"
)


@dataclass(frozen=True)
class Tick:
    """A tick of a chart's axis: its position (SVG units), where a grid line is drawn, and its text."""

    at: float
    text: str


@dataclass(frozen=True)
class Stroke:
    """A curve of a chart as SVG: the points of a polyline, or the outline path of bars."""

    role: str
    name: str
    colour: str
    points: str


@dataclass(frozen=True)
class PanelView:
    """One panel of a chart, laid out in SVG units for the template; `alt_text` describes it for screen readers."""

    title: str
    x_label: str
    y_label: str
    left: float
    right: float
    top: float
    bottom: float
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    strokes: tuple[Stroke, ...]
    legend: tuple[Stroke, ...]
    alt_text: str
    as_drawn: bool


def views(chart: Chart) -> tuple[PanelView, ...]:
    """Lay out the panels of a chart for an SVG; a panel is left out if none of its curves has two points."""
    return tuple(_view(panel) for panel in chart.panels if any(len(curve.x) > 1 for curve in panel.curves))


def _view(panel: Panel) -> PanelView:
    curves = [curve for curve in panel.curves if len(curve.x) > 1]
    x = _Scale.over(chain.from_iterable(curve.x for curve in curves), log=panel.log)
    y = _Scale.over(_heights(curves), log=panel.log, spread=panel.spread, margin=0.05)
    y_texts = _texts(y.ticks, log=panel.log)
    left = 14 + _DIGIT * max(map(len, y_texts), default=1)
    across, up = x.onto(left, WIDTH - _RIGHT), y.onto(HEIGHT - _BOTTOM, _TOP)
    strokes = tuple(_stroke(curve, across, up, y) for curve in curves)
    return PanelView(
        title=panel.title,
        x_label=panel.x_label,
        y_label=panel.y_label,
        left=round(left, 1),
        right=WIDTH - _RIGHT,
        top=_TOP,
        bottom=HEIGHT - _BOTTOM,
        x_ticks=_ticks(across(x.ticks), _texts(x.ticks, log=panel.log)),
        y_ticks=_ticks(up(y.ticks), y_texts),
        strokes=strokes,
        legend=_legend(strokes),
        alt_text=_alt_text(panel, curves, x, y),
        as_drawn=any(curve.role in ("drawn", "not-seen") for curve in curves),
    )


def _ticks(places: Sequence[float], texts: Sequence[str]) -> tuple[Tick, ...]:
    return tuple(Tick(round(at, 1), text) for at, text in zip(places, texts, strict=True))


def _heights(curves: Iterable[Curve]) -> Iterable[float]:
    return chain.from_iterable((*curve.y, 0.0) if curve.role == "bars" else curve.y for curve in curves)


Onto = Callable[[Iterable[float]], list[float]]
"""Maps values to SVG coordinates, a whole curve at once: a chart has thousands of values."""


@dataclass(frozen=True)
class _Scale:
    """An axis of a panel from `low` to `high` with its tick values."""

    low: float
    high: float
    log: bool
    ticks: tuple[float, ...]

    @classmethod
    def over(cls, values: Iterable[float], *, log: bool, spread: float = 0.0, margin: float = 0.0) -> _Scale:
        known = ([v for v in values if v > 0] if log else list(values)) or [0.1, 1.0]
        low, high = min(known), max(known)
        if log:
            low, high = (low / 1.2, high * 1.2) if margin or low == high else (low, high)
            return cls(low, high, log, tuple(_log_ticks(low, high)))
        room = max(high - low, spread, 1e-9 * max(abs(low), abs(high)), 1e-300) * (1 + 2 * margin) - (high - low)
        low, high = low - room / 2, high + room / 2
        return cls(low, high, log, tuple(_even_ticks(low, high)))

    def onto(self, start: float, end: float) -> Onto:
        low, high = (math.log10(self.low), math.log10(self.high)) if self.log else (self.low, self.high)
        slope = (end - start) / (high - low)
        if self.log:
            return lambda values: [start + slope * (math.log10(value) - low) for value in values]
        return lambda values: [start + slope * (value - low) for value in values]


def _even_ticks(low: float, high: float) -> list[float]:
    """Return readable tick values of a linear axis: multiples of 1, 2 or 5 times a power of ten, about five of them."""
    rough = (high - low) / _INTERVALS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1, 2, 5, 10) if power * m >= 0.8 * rough)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _log_ticks(low: float, high: float) -> list[float]:
    """Return readable tick values of a logarithmic axis: powers of ten, with 2 and 5 between them if these are under three."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps in ((1,), (1, 2, 5)):
        ticks = [m * 10.0**power for power in powers for m in steps if low <= m * 10.0**power <= high]
        if len(ticks) > 2:
            break
    return ticks


def _texts(ticks: tuple[float, ...], *, log: bool) -> list[str]:
    """Format tick values to be read: with a minus sign and, on a linear axis, the same number of decimals."""
    if log or len(ticks) < 2:
        return [f"{tick:.3g}" for tick in ticks]
    step, largest = ticks[1] - ticks[0], max(map(abs, ticks))
    if largest >= 1e5 or largest < 1e-4:
        return [f"{0 if abs(tick) < step / 2 else tick:.3g}".replace("-", "−") for tick in ticks]
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return [f"{0 if abs(tick) < step / 2 else tick:.{decimals}f}".replace("-", "−") for tick in ticks]


def _stroke(curve: Curve, across: Onto, up: Onto, y: _Scale) -> Stroke:
    if curve.role == "bars":
        return Stroke(curve.role, curve.name, "", _bars(curve, across, up))
    shown = [b > 0 for b in curve.y] if y.log else repeat(True)
    places = zip(across(compress(curve.x, shown)), up(compress(curve.y, shown)), strict=True)
    flat = tuple(chain.from_iterable(places))
    points = ("%.1f,%.1f " * (len(flat) // 2)) % flat  # one format call takes two thirds of the time of many
    return Stroke(curve.role, curve.name, curve.colour, points.rstrip())


def _bars(curve: Curve, across: Onto, up: Onto) -> str:
    half, (floor,) = (curve.x[1] - curve.x[0]) / 2, up([0.0])
    lefts, rights = across(x - half for x in curve.x), across(x + half for x in curve.x)
    return "".join(
        f"M{left:.1f},{floor:.1f}V{top:.1f}H{right:.1f}V{floor:.1f}z"
        for left, right, top, y in zip(lefts, rights, up(curve.y), curve.y, strict=True)
        if y
    )


def _legend(strokes: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Return one legend entry for each curve name; the three ground-truth curves share the entry "true"."""
    truth = {"true": Stroke("wanted", "true", "", "")} if any(s.role.startswith("true-") for s in strokes) else {}
    named = {s.name: Stroke(s.role, s.name, s.colour, "") for s in strokes if s.name and not s.role.startswith("true-")}
    return tuple((truth | named).values())


def _alt_text(panel: Panel, curves: list[Curve], x: _Scale, y: _Scale) -> str:
    kinds = [f"{curve.name} ({_SPOKEN[curve.role]})" if curve.role in _SPOKEN else curve.name for curve in curves]
    names = ", ".join(kind for kind in kinds if kind)
    of = f" of {names}" if names else f" of {len(curves)} curves"
    across = f"{panel.x_label or 'x'} from {x.low:.3g} to {x.high:.3g}"
    lows = f"{panel.y_label or 'y'} from {min(min(c.y) for c in curves):.3g} to {max(max(c.y) for c in curves):.3g}"
    return f"Chart{of}: {lows}, over {across}."
