"""Distance of two recordings of the push, minimized over shifts and stretches in time."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from reference.imu_reader import PUSH
from reference.scene import LAB_PAIR, roll

FloatArray = NDArray[np.float64]

LEAST = 0.05
RECORDED_S = 1.45  # as much as the latest of the stamps below asks for
STAMPS = np.arange(0.02, 1.0, 0.02)
STRETCHES = np.linspace(0.8, 1.25, 19)
SHIFTS_S = np.linspace(-0.1, 0.1, 21)


def push_of(xml: str) -> FloatArray:
    """The push in a model (n, 7): stamps, acceleration, angular velocity."""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qvel[0] = PUSH
    trace = roll(model, data, round(RECORDED_S / model.opt.timestep), LAB_PAIR)
    return np.column_stack([trace["time"], trace["acceleration"], trace["angular_velocity"]])


def _at(series: FloatArray, stamps: FloatArray) -> FloatArray:
    return np.array([np.interp(stamps, series[:, 0], channel) for channel in series[:, 1:].T])


def distances(pushes: Sequence[FloatArray]) -> FloatArray:
    """Distances (k, k) of the series in the rows from those in the columns; infinity on the diagonal."""
    own = np.array([_at(push, STAMPS) for push in pushes])
    spread = own.std(axis=2, keepdims=True)
    out = np.full((len(pushes), len(pushes)), np.inf)
    for other, push in enumerate(pushes):
        moved = np.array([_at(push, stretch * STAMPS + shift) for stretch in STRETCHES for shift in SHIFTS_S])
        out[:, other] = [_nearest(one, moved, scale) for one, scale in zip(own, spread, strict=True)]
    np.fill_diagonal(out, np.inf)
    return out


def _nearest(one: FloatArray, moved: FloatArray, scale: FloatArray) -> float:
    """By ‖a − b‖² = ‖a‖² − 2 a·b + ‖b‖², which is one product of a matrix and a vector."""
    a, b = (one / scale).ravel(), (moved / scale).reshape(len(moved), -1)
    squares = a @ a - 2.0 * (b @ a) + np.einsum("ij,ij->i", b, b)
    return float(np.sqrt(max(0.0, squares.min()) / a.size))
