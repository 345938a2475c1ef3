"""The robot that is used for grading: the lab's, or the instructor's own, named in the rubric."""

from __future__ import annotations

import os.path
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from grader.base.text import printable
from grader.engine.rubric_nodes import NodeReader, quote, refuse

if TYPE_CHECKING:  # a rubric is read before anything slow is imported
    from grader.engine.traces import Traces

LAB_FILE = "humanoid-sensors.xml"
LAB_IMU = ("torso_accelerometer", "torso_gyroscope")


@dataclass(frozen=True)
class Model:
    """The rubric's choice of a robot: the path of its model (None: the lab's) and the names of the two sensors of its IMU.

    `source` is the rubric's file name, for messages. `lines` holds the rubric's line number of each key, such as `path`.
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
        """Return whether this is the lab's robot with the sensors of the lab sheet."""
        return self.path is None and self.imu == LAB_IMU

    @property
    def file(self) -> str:
        """The file name of the model, without its folder, for messages and for the kits that students get."""
        return self.path.name if self.path else LAB_FILE

    def line(self, key: str) -> int:
        """Return the rubric's line number of `key`, for messages; for a key left out, that of `path`, else of `model`, else 1."""
        return self.lines.get(key, self.lines.get("path", self.lines.get("model", 1)))


@dataclass(frozen=True)
class Robot:
    """A robot with its model read: the model's file name, its MJCF text, and the names `imu` of accelerometer and gyroscope."""

    file: str
    xml: str = field(repr=False)
    imu: tuple[str, str]

    @property
    def identity(self) -> Sequence[str]:
        """Everything that the traces of this robot depend on, as a key of the trace cache."""
        return (self.file, self.xml, *self.imu)

    def options(self, folder: Path) -> list[str]:
        """Write the model into `folder`; return the options that name it and its sensors to the program that records traces."""
        path = folder / self.file
        path.write_text(self.xml, encoding="utf-8", newline="")
        return ["--model", str(path), "--accelerometer", self.imu[0], "--gyroscope", self.imu[1]]


LAB_MODEL = Model()


def read_model(reader: NodeReader, node: yaml.Node | None, folder: Path) -> Model:
    """Return the robot that `node`, the entry `model` of a rubric, names; the lab's for None. A path in it starts at `folder`.

    Problems, such as a missing file, are added to those of `reader`, whose caller reports them together.
    """
    keys = reader.fields(node, "model", (), ("path", "sensors"))
    sensors = reader.fields(keys.get("sensors"), "sensors", (), ("accelerometer", "gyroscope"))
    names = {key: reader.text(value, f"the {key}'s name") for key, value in sensors.items()}
    path = reader.text(keys.get("path"), "the model's path")
    if path and not os.path.isfile(folder / path):
        reader.say(keys["path"], f"there is no model {quote(keys['path'])}; the path is relative to this file")
    found = {key: node.start_mark.line + 1 for key, node in {"model": node, **keys, **sensors}.items() if node}
    given = {key: name for key, name in names.items() if name}
    return Model(folder / path if path else None, **given, source=reader.source, lines=found)


def robot_of(traces: Traces) -> Robot:
    """Return the robot for which traces were recorded; the lab's if their manifest names none."""
    about = traces.manifest.get("robot", {"file": LAB_FILE, "imu": LAB_IMU})
    return Robot(about["file"], traces.models.get("lab", ""), tuple(about["imu"]))


def is_of(model: Model, traces: Traces) -> bool:
    """Return whether traces are of the robot that a rubric names: whether model file name and sensor names are the same."""
    robot = robot_of(traces)
    return (robot.file, robot.imu) == (model.file, model.imu)


def match_robot(model: Model, traces: Traces) -> None:
    """Refuse traces of another robot than the one that the rubric names, because they would grade a sound submission as wrong.

    Raises
    ------
    RubricError
        Names the line of the rubric that names the robot.
    """
    if not is_of(model, traces):
        has, wants = robot_of(traces), f"{model.file} ({', '.join(model.imu)})"
        said = f"the traces are of {has.file} ({', '.join(has.imu)}), not of {wants}; record them with this rubric"
        refuse(model.source, [(model.line("path"), printable(said, 600))])


def torso_ids(truth: Traces) -> tuple[int, int]:
    """Return the ids (accelerometer, gyroscope) with which student code is called: those of the torso's IMU in the graded model."""
    accel, gyro = (int(i) for i in truth["reading_lab"]["pairs"][0])
    return accel, gyro
