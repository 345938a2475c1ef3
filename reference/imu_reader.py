"""Lab 04-01, Steps 1 to 4: read a simulated IMU, record it, plot it.

Run as a script it lists the model's sensors, records three seconds after a push and saves `imu_data.png`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MODEL_PATH = Path(__file__).resolve().parent / "models" / "humanoid-sensors.xml"
PUSH = 0.5  # m/s forward, on the first degree of freedom of the free joint
GRAVITY_READING = -9.81  # m/s² on a z axis that points down, standing still


def sensor_id(model: mujoco.MjModel, name: str) -> int:
    """Return the id of a sensor by its name.

    Raises
    ------
    ValueError
        If the model has no sensor of that name; MuJoCo itself would answer −1, which then reads another sensor.
    """
    found = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name))
    if found < 0:
        raise ValueError(f"the model has no sensor named {name!r}")
    return found


def list_sensors(model: mujoco.MjModel) -> list[str]:
    """Return one line for each sensor: its name, type, dimension and the index of its first number in `sensordata`."""
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i) for i in range(model.nsensor)]
    columns = zip(names, model.sensor_type, model.sensor_dim, model.sensor_adr, strict=True)
    return [f"{name}: type={kind}, dim={dim}, address={address}" for name, kind, dim, address in columns]


def get_imu_readings(
    model: mujoco.MjModel, data: mujoco.MjData, accel_sensor_id: int, gyro_sensor_id: int
) -> tuple[FloatArray, FloatArray]:
    """Read one accelerometer and one gyroscope.

    Returns
    -------
    acceleration : (3,) ndarray of float64
        Specific force in m/s², in the sensor site's frame. A copy: it stays when the simulation steps on.
    angular_velocity : (3,) ndarray of float64
        Angular velocity in rad/s, in the sensor site's frame. A copy.
    """
    return _reading(model, data, accel_sensor_id), _reading(model, data, gyro_sensor_id)


def _reading(model: mujoco.MjModel, data: mujoco.MjData, sensor: int) -> FloatArray:
    start = model.sensor_adr[sensor]
    return np.array(data.sensordata[start : start + model.sensor_dim[sensor]])


def simulate_and_collect(
    model: mujoco.MjModel, data: mujoco.MjData, duration_seconds: float = 5.0
) -> dict[str, FloatArray]:
    """Reset, push the robot forward with 0.5 m/s, and record its torso IMU.

    Each row is what the sensors read right after a step; its time is the simulation's time after that step.

    Returns
    -------
    dict
        `time` (n,) in s, `acceleration` (n, 3) in m/s² and `angular_velocity` (n, 3) in rad/s.
    """
    accel_id, gyro_id = sensor_id(model, "torso_accelerometer"), sensor_id(model, "torso_gyroscope")
    n_steps = round(duration_seconds / model.opt.timestep)  # int() would lose the last step of 0.3 / 0.1
    time, acceleration, angular_velocity = np.zeros(n_steps), np.zeros((n_steps, 3)), np.zeros((n_steps, 3))

    mujoco.mj_resetData(model, data)
    data.qvel[0] = PUSH
    for i in range(n_steps):
        mujoco.mj_step(model, data)
        time[i] = data.time
        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)
    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}


def plot_imu_data(imu_data: dict[str, FloatArray]) -> None:
    """Draw both sensors against time, one above the other, and save `imu_data.png`, as Step 4 asks.

    `imu_data` has the arrays `time` (n,) in s, `acceleration` (n, 3) in m/s² and `angular_velocity` (n, 3) in rad/s.
    """
    import matplotlib.pyplot as plt  # noqa: PLC0415 - whoever only reads sensors need not wait for it

    fig, (upper, lower) = plt.subplots(2, 1, figsize=(10, 6.5), sharex=True)
    _plot_axes(upper, imu_data["time"], imu_data["acceleration"], ("X", "Y", "Z"))
    upper.axhline(GRAVITY_READING, color="k", linestyle="--", alpha=0.3, label="Gravity")
    upper.set(title="Accelerometer readings", xlabel="Time (s)", ylabel="Acceleration (m/s²)")
    _plot_axes(lower, imu_data["time"], imu_data["angular_velocity"], ("Roll rate", "Pitch rate", "Yaw rate"))
    lower.set(title="Gyroscope readings", xlabel="Time (s)", ylabel="Angular velocity (rad/s)")
    for axes in (upper, lower):
        axes.legend(loc="upper right")
        axes.grid(True, alpha=0.4)
    fig.tight_layout()
    fig.savefig("imu_data.png", dpi=100)
    plt.close(fig)


def _plot_axes(axes: Any, time: FloatArray, samples: FloatArray, labels: tuple[str, str, str]) -> None:
    for column, label in zip(samples.T, labels, strict=True):
        axes.plot(time, column, label=label, linewidth=1.2)


def main() -> None:
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    print("Available sensors:", *list_sensors(model), sep="\n  ")
    imu_data = simulate_and_collect(model, data, duration_seconds=3.0)
    plot_imu_data(imu_data)
    print("Mean acceleration (m/s²):", imu_data["acceleration"].mean(axis=0).round(3))


if __name__ == "__main__":
    main()
