"""Extension: attitude from an accelerometer and a gyroscope, each trusted where it is good.

The gyroscope's integral follows fast motion but drifts; the accelerometer's tilt never drifts but takes every shove for a tilt. The
filter takes fast changes from the gyroscope and slow ones from the accelerometer.

References
----------
Higgins, W. T. (1975). A comparison of complementary and Kalman filtering. IEEE Transactions on Aerospace and Electronic
    Systems AES-11(3), 321-325: a low-pass on one measurement, its complement on the other, no signal lost.
Mahony, R., Hamel, T., Pflimlin, J.-M. (2008). Nonlinear complementary filters on the special orthogonal group. IEEE
    Transactions on Automatic Control 53(5), 1203-1218: the same idea on rotations, which this one-angle-at-a-time form
    approximates.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

STEEPEST = (
    0.02  # of cos(pitch): nearer to the vertical, roll and heading are the same turn and their rates grow without bound
)


class ComplementaryFilter:
    """Estimate roll and pitch of a sensor whose axes point forward, right and down, from both of its readings.

    The first update starts at the accelerometer's tilt. From then on the gyroscope's step has the weight `alpha` and the
    accelerometer's tilt the rest, so that a wrong angle dies away with the time constant alpha dt / (1 − alpha).

    Parameters
    ----------
    dt : float
        Time between two updates, in s.
    alpha : float
        Weight of the gyroscope's angle, in (0, 1).

    Attributes
    ----------
    roll, pitch : float
        The present estimate, in rad; both are 0 upright and at rest.
    heading : float or None
        Angle from magnetic north, clockwise from above, in rad; None as long as no magnetometer was given.
    """

    def __init__(self, dt: float, alpha: float = 0.98) -> None:
        self.dt, self.alpha = dt, alpha
        self.roll, self.pitch = 0.0, 0.0
        self.heading: float | None = None
        self._started = False

    def start(self, roll: float, pitch: float) -> None:
        """Start from known angles (rad) in place of the accelerometer's first tilt."""
        self.roll, self.pitch, self._started = roll, pitch, True

    def update(self, accel: ArrayLike, gyro: ArrayLike, mag: ArrayLike | None = None) -> tuple[float, float]:
        """Take in one reading of each sensor.

        Parameters
        ----------
        accel : (3,) array_like
            Specific force in m/s².
        gyro : (3,) array_like
            Angular velocity in rad/s.
        mag : (3,) array_like, optional
            Magnetic field, in any unit. The first one sets `heading`, later ones correct it; between them the gyroscope turns it.

        Returns
        -------
        roll, pitch : float
            In rad, in [−π, π). A motion over the vertical takes pitch past ±π/2; the accelerometer's tilt then pulls it back.
        """
        tilt = tilt_of(accel)
        if not self._started:
            self.start(*tilt)
        rates = euler_rates(self.roll, self.pitch, gyro)
        self.roll = self._blend(self.roll + rates[0] * self.dt, tilt[0])
        self.pitch = self._blend(self.pitch + rates[1] * self.dt, tilt[1])
        self._turn(rates[2], mag)
        return self.roll, self.pitch

    def _blend(self, integrated: float, measured: float) -> float:
        """Return the weighted mean of the gyroscope's and the other sensor's angle, the short way round the circle."""
        return wrapped(integrated + (1.0 - self.alpha) * wrapped(measured - integrated))

    def _turn(self, rate: float, mag: ArrayLike | None) -> None:
        measured = None if mag is None else heading_of(mag, self.roll, self.pitch)
        if self.heading is None:
            self.heading = measured
        elif measured is None:
            self.heading = wrapped(self.heading + rate * self.dt)
        else:
            self.heading = self._blend(self.heading + rate * self.dt, measured)


def tilt_of(accel: ArrayLike) -> tuple[float, float]:
    """Return roll and pitch (rad) at which a resting sensor reads this specific force (3,), axes forward-right-down.

    At rest the sensor reads g (sin θ, −sin φ cos θ, −cos φ cos θ) with roll φ and pitch θ.
    """
    x, y, z = (float(value) for value in np.asarray(accel, dtype=np.float64))
    return math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))


def euler_rates(roll: float, pitch: float, gyro: ArrayLike) -> tuple[float, float, float]:
    """Return the rates (rad/s) of roll, pitch and heading from the angular velocity (3,) in the sensor's own frame.

    The kinematics of the z-y-x angles; Diebel, J. (2006), Representing attitude, Stanford University, section 5.6. Within 1.1° of
    pitch ±90°, where roll and heading cannot be told apart, |cos(pitch)| counts as 0.02, so that the rates stay finite.
    """
    p, q, r = (float(value) for value in np.asarray(gyro, dtype=np.float64))
    across = q * math.sin(roll) + r * math.cos(roll)
    level = math.copysign(max(abs(math.cos(pitch)), STEEPEST), math.cos(pitch))
    return p + across * math.sin(pitch) / level, q * math.cos(roll) - r * math.sin(roll), across / level


def heading_of(mag: ArrayLike, roll: float, pitch: float) -> float:
    """Return the heading (rad clockwise from magnetic north) of a sensor that reads `mag` (3,) at `roll` and `pitch` in rad."""
    x, y, z = (float(value) for value in np.asarray(mag, dtype=np.float64))
    forward = x * math.cos(pitch) + (y * math.sin(roll) + z * math.cos(roll)) * math.sin(pitch)
    right = y * math.cos(roll) - z * math.sin(roll)
    return math.atan2(-right, forward)


def wrapped(angle: float) -> float:
    """Return the angle wrapped to [−π, π), so that a difference of angles is the short way round."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def main() -> None:
    import mujoco  # noqa: PLC0415 - the filter itself needs no simulator
    from imu_reader import MODEL_PATH, get_imu_readings, sensor_id  # type: ignore[import-not-found]  # noqa: PLC0415

    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    ids = sensor_id(model, "torso_accelerometer"), sensor_id(model, "torso_gyroscope")
    attitude = ComplementaryFilter(model.opt.timestep)
    data.qvel[0] = 0.5
    for step in range(1500):
        mujoco.mj_step(model, data)
        roll, pitch = attitude.update(*get_imu_readings(model, data, *ids))
        if step % 250 == 249:
            print(f"{data.time:.1f} s: roll {math.degrees(roll):6.2f}°, pitch {math.degrees(pitch):6.2f}°")


if __name__ == "__main__":
    main()
