"""Choose the traces (recorded true sensor data) to grade with, of the lab's robot or an instructor's: shipped, cached or new."""

from __future__ import annotations

import json
from functools import cache
from importlib.metadata import version
from pathlib import Path

from grader.base.errors import GraderError, RequestError
from grader.base.package_data import beside
from grader.base.text import printable
from grader.engine import recording
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import refuse
from grader.engine.traces import Traces, load
from grader.labs.imu.robot import LAB_FILE, LAB_MODEL, Model, Robot, is_of, robot_of

_UNFIT = 4  # the reference's exit code where a model cannot be graded


@cache
def shipped() -> Traces:
    """Return the package's public traces, no secret to students: of the lab's robot or, in a kit, of the robot that is graded."""
    return load(beside(__package__, "public.npz"))


def obtain(lab: Lab, seed: str | None, cache_dir: Path | None = None, model: Model = LAB_MODEL) -> Traces:
    """Return the traces to grade with: the public ones, or hidden ones that are recorded from the instructor's secret.

    Parameters
    ----------
    lab : Lab
        The lab; its reference solution records the traces.
    seed : str or None
        The instructor's secret, any text, for hidden traces; None for the public ones.
    cache_dir : Path, optional
        Where recorded traces are kept; `$IMUGRADE_CACHE` or the platform's cache folder if left out.
    model : Model, optional
        The robot that the rubric names; the lab's if left out.

    Raises
    ------
    RequestError
        If traces have to be recorded where the reference solution is not installed, or the seed is empty.
    RubricError
        If the model cannot be graded; the message has the line of the rubric.
    GraderError
        If recording fails. For public traces of the lab's robot, the shipped ones are returned instead.
    """
    kept = cache_dir or recording.default_cache_dir()
    if seed is None:
        return _public(lab, kept) if model.is_lab else _public_of(lab, model, kept)
    if not seed.strip():
        raise RequestError("the seed is empty; give any text that students cannot guess")
    reference = recording.folder_of(lab)
    if reference is None:
        raise RequestError("hidden traces need the reference, which is not installed here; grade without a seed")
    return recording.recorded(lab, "hidden", seed, kept, None if model.is_lab else _one_text(model, reference))


def _public(lab: Lab, cache_dir: Path) -> Traces:
    """Return the shipped traces if this version of MuJoCo recorded them, else new ones; the shipped ones if recording fails."""
    ours = shipped()
    if _is_as_good_as_any(lab, ours):
        return ours
    try:
        return recording.recorded(lab, "public", str(ours.manifest["seed"]), cache_dir)
    except GraderError:
        return ours  # other digits at worst: comparisons allow for them


def _public_of(lab: Lab, model: Model, cache_dir: Path) -> Traces:
    """Return the shipped traces if a kit brought those of this robot, else new ones; raise where none can be recorded."""
    ours = shipped()
    carried = is_of(model, ours) and robot_of(ours).xml == _content(model)
    if carried and _is_as_good_as_any(lab, ours):
        return ours
    reference = recording.folder_of(lab)
    if reference is None:
        what = "the public traces of another model need the reference, which is not installed here"
        raise RequestError(f"{what}; use the kit that your instructor gave you")
    return recording.recorded(lab, "public", str(ours.manifest["seed"]), cache_dir, _one_text(model, reference))


def _is_as_good_as_any(lab: Lab, ours: Traces) -> bool:
    """Return whether `ours` need not be recorded again: this version of MuJoCo recorded them, or nothing can be recorded here."""
    return ours.versions["mujoco"] == version("mujoco") or recording.folder_of(lab) is None


def _content(model: Model) -> str:
    try:
        return model.path.read_text(encoding="utf-8") if model.path else shipped().models["lab"]
    except (OSError, ValueError):
        return ""


def _one_text(model: Model, reference: Path) -> Robot:
    """Return the model as one MJCF text, with all included files, so that it can be sent and hashed.

    Raises
    ------
    RubricError
        If the model cannot be graded: a line for each reason.
    GraderError
        If reading the model fails in another way.
    """
    path = (model.path or reference / "models" / LAB_FILE).resolve()
    names = ["--accelerometer", model.accelerometer, "--gyroscope", model.gyroscope]
    done = recording.run(["reference.robot", str(path), *names], "reading the model")
    if done.returncode == _UNFIT:
        reasons = json.loads(done.stderr.strip().splitlines()[-1])["unfit"]
        refuse(model.source, [(model.line(key), printable(text, 600)) for key, text in reasons])
    if done.returncode:
        raise GraderError(f"reading the model failed: {recording.last_line(done)}")
    return Robot(model.file, done.stdout, model.imu)
