"""Call the student's code for the lab sheet's four extensions and report what it returned."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

from grader.worker import submission
from grader.worker.calling import adapt
from grader.worker.values import Packer, numbers

from . import calls, live
from .questions import Reply, put_in_state, reporting_errors, scene, step_and_shift

_ROLL = re.compile(r"roll|phi", re.IGNORECASE)
_PITCH = re.compile(r"pitch|theta", re.IGNORECASE)


# --- the complementary filter --------------------------------------------------------------------------------------------


def tilt(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Run a new `ComplementaryFilter` of the student's over each case, a series of readings of both sensors.

    Parameters
    ----------
    fields : ``path`` (the student's file) and ``cases``, each with ``dt`` (s), ``accel`` and ``gyro`` (array names, (n, 3))

    Returns
    -------
    ``cases`` : for each case ``output`` (name of an array (n, 2), roll and pitch, with fewer rows if the filter raised and NaN for
        an update without two numbers), ``odd`` (a description of the first such return value, or None) and ``error`` (or None).
    """
    kind = submission.find("ComplementaryFilter", fields["path"])
    packer = Packer()
    return {"cases": [_tilt_case(kind, case, arrays, packer) for case in fields["cases"]]}, packer.arrays


def _tilt_case(kind: Any, case: dict[str, Any], arrays: dict[str, Any], packer: Packer) -> dict[str, Any]:
    answer: dict[str, Any] = {"odd": None, "error": None}
    accel, gyro = arrays[case["accel"]], arrays[case["gyro"]]
    rows: list[tuple[float, float]] = []
    with reporting_errors(answer):
        build, _ = adapt(kind, calls.TILT_FILTER, {"alpha": 0.98})
        update, _ = adapt(build(case["dt"]).update, calls.TILT_UPDATE, {"dt": case["dt"]})
        for force, rate in zip(accel, gyro, strict=True):
            value = update(force.copy(), rate.copy())
            rows.append(_roll_and_pitch(value))
            if answer["odd"] is None and not np.isfinite(rows[-1]).all():
                answer["odd"] = packer.node(value)
    return answer | {"output": packer.keep(np.array(rows).reshape(-1, 2))}


def _roll_and_pitch(value: Any) -> tuple[float, float]:
    """Find two angles in whatever an update returned: a pair, a longer sequence, a dictionary, an object; NaN if missing."""
    try:
        if hasattr(value, "keys"):
            return _named({str(key): value[key] for key in value.keys()})  # noqa: SIM118 - any mapping
        if hasattr(value, "__len__"):
            flat = numbers(value).ravel()
            return (float(flat[0]), float(flat[1])) if len(flat) >= 2 else (np.nan, np.nan)
        return _named(dict(vars(value)))
    except (TypeError, ValueError, KeyError):
        return np.nan, np.nan


def _named(members: dict[str, Any]) -> tuple[float, float]:
    """Return roll and pitch by the names of the members; NaN for a missing angle."""
    roll = next((v for k, v in members.items() if _ROLL.search(k)), np.nan)
    pitch = next((v for k, v in members.items() if _PITCH.search(k)), np.nan)
    return float(numbers(roll).reshape(())), float(numbers(pitch).reshape(()))


# --- the Allan deviation -------------------------------------------------------------------------------------------------


def allan(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call the student's `allan_deviation` with one series; report ``value``, a node (description of its result), or ``error``.

    Parameters
    ----------
    fields : ``path``, ``sample_rate_hz``
    arrays : ``samples`` (n,) or (n, 3)
    """
    function = submission.find("allan_deviation", fields["path"])
    packer = Packer()
    answer: dict[str, Any] = {"value": None}
    with reporting_errors(answer):
        answer["value"] = packer.node(function(arrays["samples"].copy(), float(fields["sample_rate_hz"])))
    return answer, packer.arrays


# --- many IMUs -----------------------------------------------------------------------------------------------------------


def imus(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call the student's `read_all_imus` in every state, and look at the first answer again after a step: it has to be a copy.

    Parameters
    ----------
    fields : ``path``, ``model`` (XML text)
    arrays : ``qpos`` (k, nq), ``qvel`` (k, nv)

    Returns
    -------
    ``calls``, ``later`` : nodes (descriptions of values) of the answers, and of the first after a step; ``error`` : what it raised
    """
    function = submission.find("read_all_imus", fields["path"])
    packer = Packer()
    answer: dict[str, Any] = {"calls": [], "later": None}
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        read, _ = adapt(function, calls.IMUS)
        for index, (qpos, qvel) in enumerate(zip(arrays["qpos"], arrays["qvel"], strict=True)):
            put_in_state(model, data, qpos, qvel)
            readings = read(model, data)
            answer["calls"].append(packer.node(readings))
            if index == 0:
                step_and_shift(model, data)
                answer["later"] = packer.node(readings)
    return answer, packer.arrays


HANDLERS: dict[str, Callable[..., Reply]] = {"tilt": tilt, "allan": allan, "imus": imus, "live": live.live}
