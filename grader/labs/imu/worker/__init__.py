"""The lab's questions: the functions that run in the sandbox beside a student's code, by operation."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from . import bonuses, filtering, noise, questions

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


def sheet_names(lab_configuration: dict[str, Any]) -> dict[str, Any]:
    """Return the names that ``from imu_reader import *`` imports in the sheet's own code."""
    import matplotlib.pyplot as plt

    model = mujoco.MjModel.from_xml_path(lab_configuration["model_file"])
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name) for name in lab_configuration["imu"]]
    names = {"np": np, "numpy": np, "mujoco": mujoco, "plt": plt, "model": model, "data": mujoco.MjData(model)}
    return names | dict(zip(("accel_id", "gyro_id"), ids, strict=True))
