"""The floor: one warm process that runs exactly the student functions that the checks call, and nothing else.

python -m tests.benchmarks.floor COUNTS.json FOLDER...: no isolation, no comparison, no report.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import scipy.signal  # noqa: F401 - imported by the zygote, too

from grader.labs.imu.bundles import shipped

FILES = ("imu_reader", "noisy_imu", "filters")


def run(counts: dict[str, Any], model: Any) -> None:
    """What one submission's own code does while it is graded; the working folder is the submission's."""
    reader, noisy, filters = (importlib.import_module(name) for name in FILES)
    data = mujoco.MjData(model)
    ids = [model.sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]
    mujoco.mj_forward(model, data)
    for _ in range(counts["reads"]):
        reader.get_imu_readings(model, data, *ids)
    for duration_s, timestep in counts["simulations"]:
        model.opt.timestep = timestep
        series = reader.simulate_and_collect(model, data, duration_s)
    for reads in counts["noise"]:
        sensor = noisy.NoisyIMU(model, data, *ids)
        for _ in range(reads):
            sensor.read()
    for updates in counts["filters"]:
        low_pass = filters.LowPassFilter(0.1)
        for row in np.ones((updates, 3)):
            low_pass.update(row)
    reader.plot_imu_data(series)
    if hasattr(filters, "compare"):  # in the sheet's own layout the file itself compares
        filters.compare()
    plt.close("all")


def main(counts: dict[str, Any], folders: list[str]) -> None:
    model = mujoco.MjModel.from_xml_string(shipped().models["lab"])
    timestep = model.opt.timestep
    mujoco.MjModel.from_xml_path = staticmethod(lambda _: model)
    for folder in folders:
        os.chdir(folder)
        sys.path.insert(0, folder)
        run(counts, model)
        model.opt.timestep = timestep
        sys.path.remove(folder)
        for name in FILES:
            del sys.modules[name]


if __name__ == "__main__":
    main(json.loads(Path(sys.argv[1]).read_text()), sys.argv[2:])
