"""Which robot is graded on: the lab's, or the instructor's own, which the rubric names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

LAB_FILE = "humanoid-sensors.xml"
LAB_IMU = ("torso_accelerometer", "torso_gyroscope")


@dataclass(frozen=True)
class Model:
    """The model that is simulated (`path` None: the lab model) and the names of its IMU's two sensors.

    `source` is what messages call the rubric that names it, and `lines` where: by `path`, `accelerometer`, `gyroscope`.
    """

    path: Path | None = None
    accelerometer: str = LAB_IMU[0]
    gyroscope: str = LAB_IMU[1]
    source: str = field(default="rubric.yaml", compare=False)
    lines: Mapping[str, int] = field(default_factory=dict, compare=False, hash=False)

    @property
    def imu(self) -> tuple[str, str]:
        return (self.accelerometer, self.gyroscope)

    @property
    def is_lab(self) -> bool:
        """Whether it is the lab's robot with the sensors of the sheet."""
        return self.path is None and self.imu == LAB_IMU

    @property
    def file(self) -> str:
        """The name of the model's file."""
        return self.path.name if self.path else LAB_FILE

    def line(self, key: str) -> int:
        """The line of a key; where it is left out, that of the model."""
        return self.lines.get(key, self.lines.get("path", self.lines.get("model", 1)))


@dataclass(frozen=True)
class Robot:
    """What is simulated: the name of a model's file, its text, and its IMU as (accelerometer, gyroscope)."""

    file: str
    xml: str = field(repr=False)
    imu: tuple[str, str]


LAB_MODEL = Model()
