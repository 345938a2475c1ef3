"""Warn an instructor of what grading on an own robot cannot test."""

from __future__ import annotations

import numpy as np

from grader.engine.traces import Traces
from grader.labs.imu.robot import robot_of

_UNMOVED = 1e-3  # m/s², rad/s: less than what rows are told apart by


def blind_spot(truth: Traces) -> str:
    """Return a warning that the graded robot does not move when it is pushed, so that some checks prove nothing; "" if it moves."""
    push = truth["push"]
    for key in ("acceleration", "angular_velocity"):
        still = push[f"alt_no_push_{key}"]
        if np.abs(push[key][: len(still)] - still).max() > _UNMOVED:
            return ""
    what = "the push does not change what its IMU reads"
    return f"{robot_of(truth).file}: {what}, so the grader can hardly distinguish a run without a push from a right one"
