"""Choose what kits for students contain of this lab: the robot's model, tables of its motions, its names in the starter files."""

from __future__ import annotations

from pathlib import PurePosixPath

from grader.engine.lab import Handout, Lab, LabFile
from grader.labs.imu.bundles import obtain, shipped
from grader.labs.imu.motions import tables
from grader.labs.imu.robot import LAB_IMU, Model, robot_of

_MOTIONS = ("standing", "push", "tumbling")


def brought(lab: Lab, model: Model) -> LabFile | None:
    """Return the robot that a rubric names as `model` in place of the lab's: its MJCF text and public traces, to pack into kits.

    Students get public traces, unlike hidden ones. None for the lab's robot with the lab sheet's sensors, which each kit has.
    """
    if model.is_lab:
        return None
    traces = obtain(lab, None, model=model)
    robot = robot_of(traces)
    return LabFile(traces, ("model", "path"), robot.file, robot.xml)


def handout(lab: Lab, own: LabFile | None) -> Handout:
    """Return what a kit (the folder for students) gets for a robot: its model, tables of its motions, names for the starter files.

    `own` is the instructor's robot, whose path and sensor names replace the lab's in the starter files; None is the lab's robot.
    """
    traces = own.traces if own else shipped()
    robot = robot_of(traces)
    place = (PurePosixPath(lab.model).parent / robot.file).as_posix()
    files = {f"traces/{name}": content for name, content in tables(traces, _MOTIONS).items()}
    names = {lab.model: place} | dict(zip(LAB_IMU, robot.imu, strict=True))
    return Handout({**files, place: robot.xml.encode()}, names)
