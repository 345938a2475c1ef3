"""The Allan plot of a submission's own noise model: where its curves, lines and labels stand in the drawing."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grader.results import NoiseCurve

WIDTH, HEIGHT = 640, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 64.0, 16.0, 14.0, 34.0


@dataclass(frozen=True)
class GridLine:
    """A line of the grid with its label."""

    x1: float
    y1: float
    x2: float
    y2: float
    tx: float
    ty: float
    anchor: str
    text: str


@dataclass(frozen=True)
class Curve:
    """A curve, the straight line that white noise of the size asked for would give, and the curve's name beside it."""

    name: str
    points: str
    white: str
    x: float
    y: float


@dataclass(frozen=True)
class NoisePlot:
    """The drawing in its own units."""

    width: int
    height: int
    grid: tuple[GridLine, ...]
    curves: tuple[Curve, ...]
    caption: str


def noise_plot(noise: NoiseCurve | None) -> NoisePlot | None:
    """Both sensors over averaging time, both axes logarithmic; None where there is nothing to draw."""
    if noise is None or len(noise.taus_s) < 2 or min(*noise.acceleration, *noise.angular_velocity, *noise.taus_s) <= 0:
        return None
    series = {"accelerometer, m/s²": noise.acceleration, "gyroscope, rad/s": noise.angular_velocity}
    values = [value for curve in series.values() for value in curve]
    plane = _Plane(_decades(noise.taus_s), _decades(values))
    curves = tuple(
        _curve(plane, noise.taus_s, curve, name, asked)
        for (name, curve), asked in zip(series.items(), noise.asked_for, strict=True)
    )
    return NoisePlot(WIDTH, HEIGHT, tuple(plane.grid()), curves, _caption(noise))


def _caption(noise: NoiseCurve) -> str:
    rate = 1.0 / noise.taus_s[0]
    found = (noise.acceleration[0], noise.angular_velocity[0])
    told = [
        f"{size:.3g} {unit} (asked for: {asked:.3g})"
        for size, unit, asked in zip(found, ("m/s²", "rad/s"), noise.asked_for, strict=True)
    ]
    return (
        f"Allan deviation of your own NoisyIMU at {rate:.0f} Hz, over averaging time in s. White noise of the size asked for is "
        f"the dashed line, of slope −1/2. Found at one sample: {told[0]} and {told[1]}."
    )


@dataclass(frozen=True)
class _Plane:
    """Exponents of ten at the borders."""

    x: tuple[int, int]
    y: tuple[int, int]

    def at(self, tau: float, value: float) -> tuple[float, float]:
        across = (math.log10(tau) - self.x[0]) / (self.x[1] - self.x[0])
        up = (math.log10(value) - self.y[0]) / (self.y[1] - self.y[0])
        left = _LEFT + across * (WIDTH - _LEFT - _RIGHT)
        return round(left, 1), round(HEIGHT - _BOTTOM - up * (HEIGHT - _TOP - _BOTTOM), 1)

    def grid(self) -> list[GridLine]:
        low, high = self.at(10.0 ** self.x[0], 10.0 ** self.y[0]), self.at(10.0 ** self.x[1], 10.0 ** self.y[1])
        lines = []
        for power in range(self.x[0], self.x[1] + 1):
            x = self.at(10.0**power, 10.0 ** self.y[0])[0]
            lines.append(GridLine(x, low[1], x, high[1], x, low[1] + 16, "middle", f"{10.0**power:g} s"))
        for power in range(self.y[0], self.y[1] + 1):
            y = self.at(10.0 ** self.x[0], 10.0**power)[1]
            lines.append(GridLine(low[0], y, high[0], y, low[0] - 6, y + 4, "end", f"{10.0**power:g}"))
        return lines


def _decades(values: tuple[float, ...] | list[float]) -> tuple[int, int]:
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def _curve(plane: _Plane, taus: tuple[float, ...], values: tuple[float, ...], name: str, asked: float) -> Curve:
    points = [plane.at(tau, value) for tau, value in zip(taus, values, strict=True)]
    floor = 10.0 ** plane.y[0]
    ideal = [(tau, asked * math.sqrt(taus[0] / tau)) for tau in taus]
    white = [plane.at(tau, value) for tau, value in ideal if floor <= value <= 10.0 ** plane.y[1]]
    x, y = points[len(points) // 2]
    return Curve(name, _joined(points), _joined(white), x + 10, y - 10)


def _joined(points: list[tuple[float, float]]) -> str:
    return " ".join(f"{x:g},{y:g}" for x, y in points)
