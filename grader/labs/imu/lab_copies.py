"""Replace copies of the robot's model in a submission: code that loads such a copy has to run on the robot that is graded."""

from __future__ import annotations

from collections.abc import Mapping

from grader.engine.traces import Traces
from grader.labs.imu.bundles import shipped

STUDENTS_IDS = (2, 4)
STUDENTS_TIMESTEP = 0.002
"""Ids of the torso's accelerometer and gyroscope, and the time step (s), in the lab model that students have."""


def learnt_ids(truth: Traces) -> tuple[int, int]:
    """Return the ids (accelerometer, gyroscope) of the IMU in the students' model, to recognise code that has them as constants."""
    first, second = truth.manifest.get("robot", {}).get("ids", STUDENTS_IDS)
    return int(first), int(second)


def learnt_timestep(truth: Traces) -> float:
    """Return the time step (s) of the students' model, to recognise code that holds it as a constant."""
    return float(truth.manifest.get("robot", {}).get("timestep", STUDENTS_TIMESTEP))


def with_graded_robot(files: Mapping[str, bytes], robot: str, copy: str | None = None) -> dict[str, bytes]:
    """Return a submission's files with the graded model (`robot`, MJCF text) in place of each copy of the model that students have.

    The graded model may have its sensors in another order, so that sensor ids looked up in a handed-in copy would be wrong. `copy`
    is the text that students have; None stands for the lab's model. A file that differs in more than white space is kept.
    """
    ours = (shipped().models["lab"] if copy is None else copy).encode().split()
    return {path: robot.encode() if _is_copy(path, content, ours) else content for path, content in files.items()}


def _is_copy(path: str, content: bytes, ours: list[bytes]) -> bool:
    return path.lower().endswith(".xml") and content.removeprefix(b"\xef\xbb\xbf").split() == ours
