"""Operations of this lab's sandbox worker: by name, the function that calls student code and reports back."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

os.environ["MUJOCO_GL"] = "disable"  # read when it is imported

import mujoco
import numpy as np

from . import bonuses, filtering, noise, questions
from .simulation import install, warm_up

__all__ = ["HANDLERS", "install", "sheet_names", "warm_up"]
HANDLERS = {
    "read": questions.read,
    "simulate": questions.simulate,
    "replay": questions.replay,
    "read_along": questions.read_along,
    "noise": noise.noise,
    "noise_twins": noise.noise_twins,
    "default_bias": noise.default_bias,
    "filter": filtering.filter_cases,
    "plot": questions.plot,
    **bonuses.HANDLERS,
}


def sheet_names(lab_configuration: dict[str, Any], standins: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values, by name, that a file on the lab sheet defines, so that ``from imu_reader import *`` finds them all.

    `lab_configuration` names the file of the model (``model_file``) and the two sensors (``imu``). `standins` are the grader's
    versions of that file's functions and classes, in place of broken or missing ones. Objects that the sheet makes with them at top
    level, such as `imu_data`, are made, too.
    """
    import matplotlib.pyplot as plt

    model = mujoco.MjModel.from_xml_path(lab_configuration["model_file"])
    data = mujoco.MjData(model)
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name) for name in lab_configuration["imu"]]
    names = {"np": np, "numpy": np, "mujoco": mujoco, "plt": plt, "model": model, "data": data}
    names |= dict(zip(("accel_id", "gyro_id"), ids, strict=True))
    for name, (made, given) in _MADE_OF.items():
        if made in standins:
            names[name] = standins[made](*given(model, data, ids))
    return names


_MADE_OF: Mapping[str, tuple[str, Callable[..., tuple[Any, ...]]]] = {
    "imu_data": ("simulate_and_collect", lambda model, _data, _ids: (model, mujoco.MjData(model), 3.0)),
    "noisy_imu": ("NoisyIMU", lambda model, data, ids: (model, data, *ids)),
    "accel_filter": ("LowPassFilter", lambda *_: (0.1,)),
    "gyro_filter": ("LowPassFilter", lambda *_: (0.1,)),
}
"""Objects that the sheet makes at top level: by name, the function or class that it is made with, and the arguments."""
