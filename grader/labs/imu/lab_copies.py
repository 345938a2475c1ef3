"""Copies of the lab model in a submission: code that loads one means the robot that is graded with."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from grader.engine.traces import Traces
from grader.labs.imu.bundles import shipped

STUDENTS_IDS = (2, 4)
STUDENTS_TIMESTEP = 0.002
"""Ids of the torso's accelerometer and gyroscope, and the time step (s), in the lab model that students have."""


def learnt_ids(truth: Traces) -> tuple[int, int]:
    """Return the ids of the accelerometer and gyroscope in the model that students have, which code may hold as constants."""
    first, second = truth.manifest.get("robot", {}).get("ids", STUDENTS_IDS)
    return int(first), int(second)


def learnt_timestep(truth: Traces) -> float:
    """Return the time step (s) of the model that students have, which code may hold as a constant."""
    return float(truth.manifest.get("robot", {}).get("timestep", STUDENTS_TIMESTEP))


def with_graded_robot(files: Mapping[str, bytes], robot: str, copy: str | None = None) -> dict[str, bytes]:
    """Return the files of a submission with every copy of the students' model replaced by `robot` (MJCF).

    That is the lab model, or the text of the instructor's own (`copy`).

    Sensor ids that are looked up in a handed-in copy are used on the model that is graded with: under a secret that one is a
    variant, with its sensors in another order. A model that differs from ours in more than white space is the student's own.
    """
    ours = (_lab_model() if copy is None else copy).encode().split()
    return {path: robot.encode() if _is_copy(path, content, ours) else content for path, content in files.items()}


@cache
def _lab_model() -> str:
    return shipped().models["lab"]


def _is_copy(path: str, content: bytes, ours: list[bytes]) -> bool:
    return path.lower().endswith(".xml") and content.removeprefix(b"\xef\xbb\xbf").split() == ours
