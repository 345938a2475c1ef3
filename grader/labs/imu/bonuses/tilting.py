"""Diagnose a tilt filter from its response to single changes of each sensor.

Any filter that blends the two shows the same things, whatever is inside: a turn within one sample comes out as that turn, a
tilt that lasts comes out as that tilt in the end, and at first as a small part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from grader.labs.imu.compare import Array

G = 9.81
DT = 0.01
BEFORE, AFTER = 200, 3000  # samples, before and after the change
TILT = np.array([0.25, -0.12])  # rad: so small that every form of the tilt's equations agrees within a hundredth
TURN = 0.2  # rad, within one sample

Signals = tuple[Array, Array]


def wrapped(angle: Array) -> Array:
    """Return the same directions in [−π, π)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def at_rest(tilt: Array, n: int) -> Array:
    """Specific force (n, 3) of a sensor, forward-right-down, that rests at roll and pitch (2,)."""
    roll, pitch = tilt
    up = [np.sin(pitch), -np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch)]
    return np.tile(G * np.array(up), (n, 1))


def probes() -> list[Signals]:
    """Accelerometer and gyroscope of three experiments: a turn about x, one about y, and a tilt that the gyroscope missed."""
    level = at_rest(np.zeros(2), BEFORE + 50)
    turns = []
    for axis in (0, 1):
        gyro = np.zeros((len(level), 3))
        gyro[BEFORE, axis] = TURN / DT
        turns.append((level, gyro))
    tilted = np.concatenate([at_rest(np.zeros(2), BEFORE), at_rest(TILT, AFTER)])
    return [*turns, (tilted, np.zeros_like(tilted))]


@dataclass(frozen=True)
class Response:
    """The filter's responses to the probes.

    Attributes
    ----------
    turn : (2, 2) ndarray, roll and pitch (columns) per unit of a turn about x and about y (rows)
    first : (2,) ndarray, the share of the tilt that comes out at once
    settled : (2,) ndarray, what comes out in the end, in rad
    moved : whether the tilt changed anything
    """

    turn: Array
    first: Array
    settled: Array
    moved: bool


def response(outputs: list[Array]) -> Response | None:
    """The response from the outputs (n, 2) of the three probes; None where they are not whole."""
    if any(len(out) < BEFORE + 50 or not np.isfinite(out).all() for out in outputs):
        return None
    tilted = outputs[2]
    before, after = tilted[BEFORE - 1], tilted[-1]
    moved = bool(np.abs(wrapped(after - before)).max() > 1e-3)
    return Response(turns(outputs[:2]), (tilted[BEFORE] - before) / TILT, after, moved)


def turns(outputs: list[Array]) -> Array:
    """Roll and pitch (columns) per unit of a turn about x and about y (rows), whether it counts at once or a sample later."""
    steps = np.array([wrapped(out[BEFORE : BEFORE + 2] - out[BEFORE - 1]) for out in outputs]) / TURN
    later = np.abs(steps[:, 1]).max(axis=1) > np.abs(steps[:, 0]).max(axis=1)
    return np.asarray(np.where(later[:, None], steps[:, 1], steps[:, 0]))


def ignores_gyroscope(seen: Response) -> bool:
    """Return whether neither of the two turns shows in the outputs."""
    return bool(np.abs(seen.turn).max() < 1e-3)


def _degrees(seen: Response) -> bool:
    own = np.diag(seen.turn)
    scale = np.degrees(1.0)
    tilt = bool(np.all(np.abs(seen.settled / TILT / scale - 1.0) < 0.05))
    turned = any(np.all(np.abs(own / factor - 1.0) < 0.1) for factor in (scale, 1.0 / scale))
    return tilt or (turned and not _heavy(seen))


def _heavy(seen: Response) -> bool:
    """Return whether nearly all of a tilt comes out at once."""
    return bool(np.all(np.abs(seen.first - 0.98) < 0.015))


def _swapped(seen: Response) -> bool:
    return _heavy(seen) and bool(np.all(np.abs(np.diag(seen.turn)) < 0.05))


def _sign(seen: Response) -> bool:
    """Return whether the tilt settles at another sign, half a turn away or on the other axis, or the turn shows up so."""
    if _near(seen.settled, TILT):
        unit = np.round(seen.turn)
        return (
            not np.array_equal(unit, np.eye(2))
            and bool(np.all(np.abs(unit).sum(axis=1) == 1))
            and _near(seen.turn, unit, 0.1)
        )
    axes = (TILT, TILT[::-1])
    signs = [np.array([a, b]) for a in (1.0, -1.0) for b in (1.0, -1.0)]
    halves = [np.array([a, b]) * np.pi for a in (0.0, 1.0) for b in (0.0, 1.0)]
    return any(
        _near(wrapped(seen.settled - tilt * sign - half), np.zeros(2))
        for tilt in axes
        for sign in signs
        for half in halves
    )


def _near(got: Array, wanted: Array, atol: float = 0.02) -> bool:
    return bool(np.all(np.abs(got - wanted) <= atol))


FAULTS: Mapping[str, Callable[[Response], bool]] = {
    "gyro-only": lambda seen: not ignores_gyroscope(seen) and not seen.moved,
    "accel-only": lambda seen: seen.moved and ignores_gyroscope(seen),
    "weights-swapped": lambda seen: seen.moved and _swapped(seen),
    "degrees-not-radians": lambda seen: seen.moved and _degrees(seen),
    "tilt-sign-wrong": lambda seen: seen.moved and _sign(seen),
}
"""For each fault, whether it predicts the response; the most plausible first."""
