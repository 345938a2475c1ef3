"""Read an instructor's own robot: its model as one text, the two sensors of its IMU, and why a model cannot be graded.

`python -m reference.robot MODEL --accelerometer NAME --gyroscope NAME` prints the text.
"""

from __future__ import annotations

import argparse
import json
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from .imu_reader import PUSH
from .self_contained import NotOneTextError, self_contained

MOST_BYTES = 700_000
"""Largest text of a model, in bytes. It goes to the sandbox with every question; the largest model that was tried has 110 kB."""
STEADY_S = 2.0
"""Longer than any run that is graded."""
MOST_STEPS = 10_000

_KINDS = {"accelerometer": mujoco.mjtSensor.mjSENS_ACCELEROMETER, "gyroscope": mujoco.mjtSensor.mjSENS_GYRO}
_TROUBLES = ("mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")

Problem = tuple[str, str]
"""The key of the rubric that it is about (`path`, `accelerometer`, `gyroscope`), and a sentence."""


class UnfitError(ValueError):
    """Exception: model not gradable. `problems`: (rubric key at fault, text); "path" (the model), "accelerometer", "gyroscope"."""

    def __init__(self, *problems: Problem) -> None:
        super().__init__("; ".join(text for _, text in problems))
        self.problems = problems


@dataclass(frozen=True)
class Robot:
    """An instructor's robot: the file name of its model, the MJCF text, and its IMU as (accelerometer, gyroscope)."""

    file: str
    xml: str
    imu: tuple[str, str]

    def about(self) -> dict[str, Any]:
        """Return the robot's entry in the traces' JSON: file, IMU; sensor ids and time step as students have them, unvaried."""
        model = mujoco.MjModel.from_xml_string(self.xml)
        ids = [int(model.sensor(name).id) for name in self.imu]
        return {"file": self.file, "imu": list(self.imu), "ids": ids, "timestep": float(model.opt.timestep)}


def read(path: Path, accelerometer: str, gyroscope: str) -> Robot:
    """Return the robot of the model at `path` if it can be graded: with a joint to push, both named sensors, a stable simulation.

    Raises
    ------
    UnfitError
        If the model cannot be loaded or graded.
    """
    xml = _text(path)
    model = mujoco.MjModel.from_xml_string(xml)
    imu = (accelerometer, gyroscope)
    problems = [*_unmoved(model), *_unread(model, dict(zip(_KINDS, imu, strict=True)))]
    if problems:
        raise UnfitError(*problems)
    if not is_steady(model):
        what = f"the simulation of the model becomes unstable within {STEADY_S:g} s of the push"
        raise UnfitError(("path", f"{what}; try a smaller timestep"))
    return Robot(path.name, xml, imu)


def _text(path: Path) -> str:
    try:
        xml = self_contained(path)
    except NotOneTextError as error:
        raise UnfitError(("path", f"the model cannot be sent as one text: {_one_line(error)}")) from None
    except (ValueError, OSError, ET.ParseError) as error:
        raise UnfitError(("path", _not_loaded(path, error))) from None
    if len(xml.encode()) > MOST_BYTES:
        size = f"{len(xml.encode()) / 1000:.0f} kB"
        raise UnfitError(("path", f"the model is {size} as one text, {MOST_BYTES // 1000} kB at most are graded"))
    return xml


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _not_loaded(path: Path, error: Exception) -> str:
    absent = next(_absent_includes(path, path.parent, set()), None)
    if absent is not None:
        return f"the model includes '{absent}', which is not there; paths in it are relative to the model"
    return f"MuJoCo cannot load the model: {_one_line(error)}"


def _absent_includes(path: Path, folder: Path, seen: set[Path]) -> Iterator[str]:
    """Yield the files that a model includes, directly or not, and that are not there, for a message."""
    try:
        root = ET.parse(path).getroot()
    except (OSError, ET.ParseError):
        return
    seen.add(path)
    for include in root.iter("include"):
        name = include.get("file", "")
        found = next((place for place in (folder / name, path.parent / name) if place.is_file()), None)
        if found is None:
            yield name
        elif found not in seen:
            yield from _absent_includes(found, folder, seen)


def _unmoved(model: mujoco.MjModel) -> Iterator[Problem]:
    if model.nv == 0:
        yield (
            "path",
            "the model has no joint, so there is no velocity to push (data.qvel[0]); give its robot a freejoint",
        )


def _unread(model: mujoco.MjModel, imu: dict[str, str]) -> Iterator[Problem]:
    for key, name in imu.items():
        kind = _KINDS[key]
        found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)
        if found < 0:
            yield key, f"the model has no sensor '{name}'; {_sensors_of(model, key)}"
        elif model.sensor_type[found] != kind:
            other = mujoco.mjtSensor(int(model.sensor_type[found])).name.removeprefix("mjSENS_").lower()
            yield key, f"the model's sensor '{name}' is of type {other}; {_sensors_of(model, key)}"


def _sensors_of(model: mujoco.MjModel, key: str) -> str:
    names = sensors(model, _KINDS[key])
    return f"its {key}s are {', '.join(names)}" if names else f"it has no named {key}"


def sensors(model: mujoco.MjModel, kind: mujoco.mjtSensor) -> list[str]:
    """Return the names of the sensors of one kind in the model's order, for messages; sensors without a name are left out."""
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) for i in range(model.nsensor)]
    return [name for name, own in zip(names, model.sensor_type, strict=True) if name and own == kind]


def is_steady(model: mujoco.MjModel) -> bool:
    """Return whether the simulation stays stable for 2 s, at most 10,000 steps, after the push that starts a run of the lab.

    MuJoCo resets an unstable simulation, and what is recorded after that is no motion of the robot.
    """
    data = mujoco.MjData(model)
    data.qvel[0] = PUSH
    for _ in range(min(round(STEADY_S / model.opt.timestep), MOST_STEPS)):
        mujoco.mj_step(model, data)
        if any(data.warning[int(getattr(mujoco.mjtWarning, name))].number for name in _TROUBLES):
            return False
    return True


def all_imus(model: mujoco.MjModel, first: tuple[str, str]) -> tuple[tuple[str, str], ...]:
    """Return the IMU `first`, which is graded, then all other pairs of an accelerometer and a gyroscope at one site."""
    accels, gyros = (sensors(model, kind) for kind in _KINDS.values())
    at = {name: int(model.sensor_objid[model.sensor(name).id]) for name in (*accels, *gyros)}
    pairs = [(accel, gyro) for accel in accels for gyro in gyros if at[accel] == at[gyro]]
    return (first, *(pair for pair in pairs if first[0] not in pair and first[1] not in pair))


UNFIT = 4
"""Exit code where a model cannot be graded: the last line on stderr then says why, as JSON."""


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m reference.robot", description="Print a model as one text.")
    parser.add_argument("model", type=Path)
    parser.add_argument("--accelerometer", metavar="NAME", required=True)
    parser.add_argument("--gyroscope", metavar="NAME", required=True)
    arguments = parser.parse_args(argv)
    try:
        robot = read(arguments.model, arguments.accelerometer, arguments.gyroscope)
    except UnfitError as error:
        print(json.dumps({"unfit": error.problems}), file=sys.stderr)
        return UNFIT
    sys.stdout.buffer.write(robot.xml.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
