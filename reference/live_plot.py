"""Extension: the readings of the torso IMU, drawn while the robot moves.

`python -m reference.live_plot` opens a window and keeps pace with the clock on the wall; where there is no display it writes the
same animation into a file.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MODEL_PATH = Path(__file__).resolve().parent / "models" / "humanoid-sensors.xml"
FRAMES_PER_SECOND = 25
LONGEST_WAIT = 0.5  # s between two pictures, however slow the drawing
PUSH = 0.5  # m/s forward, as in Step 3
PANELS = (
    ("torso_accelerometer", "Acceleration (m/s²)", ("X", "Y", "Z")),
    ("torso_gyroscope", "Angular velocity (rad/s)", ("Roll rate", "Pitch rate", "Yaw rate")),
)


@dataclass
class Trace:
    """One panel of the live plot: its growing lines, and the samples that they show so far."""

    sensor: int
    axes: Any
    lines: list[Any]
    samples: list[FloatArray] = field(default_factory=list)

    def show(self, times: list[float]) -> None:
        for line, column in zip(self.lines, np.array(self.samples).T, strict=True):
            line.set_data(times, column)
        self.axes.relim()
        self.axes.autoscale_view(scalex=False)


def live_plot(model: mujoco.MjModel, data: mujoco.MjData, duration_seconds: float = 5.0) -> None:
    """Simulate on from the state in `data` and draw the torso IMU's six channels as they come in, 25 times a second.

    In a window it runs in real time: where drawing is slow, pictures are left out, for half a second at most.
    Without a window it runs as fast as it can, and nothing is seen.
    """
    figure, traces = canvas(model, duration_seconds, start=data.time)
    window = getattr(figure.canvas, "required_interactive_framework", None) is not None
    if window:
        figure.show()
    began = drawn = time.monotonic()
    start = data.time
    for _ in frames(model, data, traces, duration_seconds):
        late = (time.monotonic() - began) - (data.time - start)
        if window and late > 0 and time.monotonic() - drawn < LONGEST_WAIT:
            continue
        figure.canvas.draw_idle()
        figure.canvas.flush_events()
        drawn = time.monotonic()
        if window and late < 0:
            time.sleep(-late)
    plt.close(figure)


def write_animation(model: mujoco.MjModel, data: mujoco.MjData, duration_seconds: float, path: Path) -> None:
    """Write the animation of `live_plot` into a GIF that plays at the speed of the simulation."""
    from matplotlib.animation import PillowWriter  # noqa: PLC0415 - only without a window

    figure, traces = canvas(model, duration_seconds, start=data.time)
    writer = PillowWriter(fps=FRAMES_PER_SECOND)
    with writer.saving(figure, str(path), dpi=70):
        for _ in frames(model, data, traces, duration_seconds):
            writer.grab_frame()
    plt.close(figure)


def frames(model: mujoco.MjModel, data: mujoco.MjData, traces: list[Trace], duration_seconds: float) -> Iterator[None]:
    """Step through the simulation and yield wherever a picture is due: the lines of `traces` then show everything so far."""
    n_steps = round(duration_seconds / model.opt.timestep)
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * model.opt.timestep)))
    times: list[float] = []
    for step in range(1, n_steps + 1):
        mujoco.mj_step(model, data)
        times.append(data.time)
        for trace in traces:
            start = model.sensor_adr[trace.sensor]
            trace.samples.append(np.array(data.sensordata[start : start + 3]))
        if step % every == 0 or step == n_steps:
            for trace in traces:
                trace.show(times)
            yield


def canvas(model: mujoco.MjModel, duration_seconds: float, *, start: float) -> tuple[Any, list[Trace]]:
    """Return a figure with a panel for each sensor, and the panels, empty so far; time runs from `start` (s) to the plot's end."""
    figure, panels = plt.subplots(2, 1, figsize=(9, 6), sharex=True)
    traces = []
    for axes, (name, label, legend) in zip(panels, PANELS, strict=True):
        sensor = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)
        traces.append(Trace(sensor, axes, [axes.plot([], [], label=entry)[0] for entry in legend]))
        axes.set(ylabel=label, xlim=(start, start + duration_seconds))
        axes.legend(loc="upper right")
        axes.grid(True, alpha=0.4)
    panels[0].set_title("Torso IMU, live")
    panels[1].set_xlabel("Time (s)")
    return figure, traces


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m reference.live_plot", description="Watch the torso IMU live.")
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated time (default 5)")
    parser.add_argument("--out", type=Path, help="write a GIF instead of opening a window")
    arguments = parser.parse_args(argv)
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    data.qvel[0] = PUSH
    headless = plt.get_backend().lower() == "agg"  # what matplotlib falls back to where there is no display
    if headless or arguments.out:
        path = arguments.out or Path("live_plot.gif")
        write_animation(model, data, arguments.seconds, path)
        print(path)
    else:
        live_plot(model, data, arguments.seconds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
