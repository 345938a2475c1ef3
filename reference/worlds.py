"""The MJCF texts of the models in which scenarios take place: the lab's humanoid, and small worlds made for single scenarios."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

LAB_MODEL = Path(__file__).resolve().parent / "models" / "humanoid-sensors.xml"

#: Sensor pairs of the lab model, accelerometer and gyroscope, in the order in which `pairs` arrays list them.
LAB_PLACES = ("torso", "head", "left_foot", "right_foot")
LAB_IMUS = tuple((f"{place}_accelerometer", f"{place}_gyroscope") for place in LAB_PLACES)

#: Where the lab model that students have keeps its IMUs. A reader that has learnt these by heart must not be right elsewhere.
LAB_ADDRESSES = frozenset({5, 11, 16, 20, 23, 29, 35, 39})

FREE_FALL = """\
<mujoco model="free_fall">
  <option timestep="0.002" gravity="0 0 -9.81" integrator="Euler"/>
  <worldbody>
    <body name="box" pos="0 0 10">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <site name="imu" pos="0.05 0.02 -0.03"/>
    </body>
  </worldbody>
  <sensor>
    <accelerometer name="accelerometer" site="imu"/>
    <gyro name="gyroscope" site="imu"/>
  </sensor>
</mujoco>
"""

_SPIN = """\
<mujoco model="constant_spin">
  <option timestep="0.002" gravity="0 0 -9.81" integrator="Euler"/>
  <worldbody>
    <body name="turntable" pos="0 0 1">
      <joint name="spin" type="hinge" axis="0 0 1"/>
      <geom type="cylinder" size="0.5 0.02" mass="2"/>
      <site name="imu" pos="{radius} 0 0.03"/>
    </body>
  </worldbody>
  <sensor>
    <jointpos name="turntable_angle" joint="spin"/>
    <accelerometer name="accelerometer" site="imu"/>
    <gyro name="gyroscope" site="imu"/>
  </sensor>
</mujoco>
"""

#: An IMU on a carriage that slides in three directions and turns about three axes, all of it prescribed. The site is mounted
#: forward-right-down, as in the torso.
GIMBAL = """\
<mujoco model="gimbal">
  <compiler angle="radian"/>
  <option timestep="0.01" gravity="0 0 -9.81" magnetic="0.2 0 -0.43" integrator="Euler"/>
  <worldbody>
    <body name="carriage">
      <joint name="surge" type="slide" axis="1 0 0"/>
      <joint name="sway" type="slide" axis="0 1 0"/>
      <joint name="heave" type="slide" axis="0 0 1"/>
      <joint name="yaw" type="hinge" axis="0 0 1"/>
      <joint name="pitch" type="hinge" axis="0 1 0"/>
      <joint name="roll" type="hinge" axis="1 0 0"/>
      <geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <site name="imu" quat="0 1 0 0"/>
    </body>
  </worldbody>
  <sensor>
    <accelerometer name="accelerometer" site="imu"/>
    <gyro name="gyroscope" site="imu"/>
    <magnetometer name="magnetometer" site="imu"/>
  </sensor>
</mujoco>
"""


def lab() -> str:
    """Return the lab model's MJCF text."""
    return LAB_MODEL.read_text(encoding="utf-8")


def imu_addresses(model: mujoco.MjModel) -> frozenset[int]:
    """Return where the IMU sensors of the lab model or a variant begin in `sensordata`, so that generated models put none there."""
    names = (f"{place}_{kind}" for place in LAB_PLACES for kind in ("accelerometer", "gyroscope"))
    return frozenset(int(model.sensor(name).adr[0]) for name in names)


def constant_spin(radius: float) -> str:
    """Return the MJCF of a turntable about the vertical, its IMU `radius` metres from the axis: x outward, y tangential, z up."""
    return _SPIN.format(radius=radius)


@dataclass(frozen=True)
class Sensor:
    """A sensor of a generated model: its name, its number of values, and its line of MJCF."""

    name: str
    dim: int
    xml: str


@dataclass(frozen=True)
class Shuffled:
    """A generated model with sensors in random order: its MJCF text, and the names of its IMUs as (accelerometer, gyroscope)."""

    xml: str
    imus: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Many:
    """A generated model with many IMUs: its MJCF text, places with an IMU (as in "tail_gyroscope"), places with a magnetometer."""

    xml: str
    places: tuple[str, ...]
    compasses: tuple[str, ...]


def shuffled(rng: np.random.Generator, learnt: frozenset[int] = LAB_ADDRESSES) -> Shuffled:
    """Return a model of free bodies in space with IMUs mounted at random, their sensors renamed and in random order.

    Code that uses a wrong address in sensordata never gets right numbers by luck: no address of an IMU sensor is its id, three
    times its id or in `learnt` (addresses of the lab model), and no gyroscope is next to its accelerometer. These wrong addresses
    lie within sensordata, because a slice beyond its end would be cut short without an error.
    """
    bodies = int(rng.integers(3, 5))
    imus = _imu_names(rng, bodies)
    sensors = _sensors(imus)
    while True:
        order = [sensors[i] for i in rng.permutation(len(sensors))]
        if _no_mistake_is_right(order, imus, learnt):
            break
    body_text = "\n".join(_body(rng, i) for i in range(bodies))
    sensor_text = "\n".join(f"    {sensor.xml}" for sensor in order)
    return Shuffled(_SHUFFLED.format(bodies=body_text, sensors=sensor_text), imus)


_SHUFFLED = """\
<mujoco model="shuffled">
  <compiler angle="radian"/>
  <option timestep="0.002" gravity="0 0 -9.81" magnetic="0.17 0.05 -0.44" integrator="Euler"/>
  <default>
    <geom contype="0" conaffinity="0"/>
  </default>
  <worldbody>
{bodies}
  </worldbody>
  <sensor>
{sensors}
  </sensor>
</mujoco>
"""

BODIES = ("torso", "head", "left_foot", "right_foot", "pelvis", "left_hand")
"""Bodies of the generated models, named as in the lab model. A reader that looks at the torso itself finds one here, too: what it
computes is then compared with the sensors, and is not an exception about a missing name."""

_BODY = """\
    <body name="{name}" pos="{i} 0 5">
      <freejoint name="{free}"/>
      <geom type="box" size="{size}" mass="{mass}"/>
      <site name="{name}_imu" pos="{pos}" quat="{quat}"/>
      <site name="pad{i}" size="0.05"/>
      <body name="arm{i}" pos="{arm}">
        <joint name="hinge{i}" type="hinge" axis="{axis}" stiffness="3" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0.2 0.05 -0.1" size="0.03" mass="0.4"/>
      </body>
    </body>"""


def _numbers(values: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _unit(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """Return a random direction in n dimensions; for n = 4, a random rotation's quaternion."""
    vector = rng.normal(size=n)
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float64)


def _body(rng: np.random.Generator, i: int) -> str:
    return _BODY.format(
        i=i,
        name=BODIES[i],
        free="root" if i == 0 else f"free{i}",
        size=_numbers(rng.uniform(0.05, 0.2, 3)),
        mass=f"{rng.uniform(0.8, 3.0):.3f}",
        pos=_numbers(rng.uniform(0.08, 0.25, 3) * rng.choice([-1, 1], 3)),
        quat=_numbers(_unit(rng, 4)),
        arm=_numbers(rng.uniform(-0.15, 0.15, 3)),
        axis=_numbers(_unit(rng, 3)),
    )


_STYLES = (("imu{}_acc", "imu{}_gyr"), ("accel_{}", "gyro_{}"), ("{}_accelerometer", "{}_gyroscope"), ("a{}", "w{}"))
_MORE_PLACES = (
    "left_wing",
    "right_wing",
    "tail",
    "nose",
    "upper_mast",
    "keel",
    "rear_left_hoof",
    "saddle",
    "crown",
    "boom",
)
_PLACES = ("tail", "wing", "mast", "hull", "boom", "wrist", "shank", "crown")


def _imu_names(rng: np.random.Generator, n: int) -> tuple[tuple[str, str], ...]:
    accel, gyro = _STYLES[int(rng.integers(len(_STYLES)))]
    places = [_PLACES[i] for i in rng.permutation(len(_PLACES))[:n]]
    return tuple((accel.format(place), gyro.format(place)) for place in places)


def _sensors(imus: tuple[tuple[str, str], ...]) -> list[Sensor]:
    """Return both sensors of every IMU, and enough others of one, three and four numbers to set ids and addresses apart."""
    sensors = [Sensor("clock", 1, '<clock name="clock"/>')]
    for i, ((accel, gyro), body) in enumerate(zip(imus, BODIES, strict=False)):
        sensors += [
            Sensor(accel, 3, f'<accelerometer name="{accel}" site="{body}_imu"/>'),
            Sensor(gyro, 3, f'<gyro name="{gyro}" site="{body}_imu"/>'),
            Sensor(f"angle{i}", 1, f'<jointpos name="angle{i}" joint="hinge{i}"/>'),
            Sensor(f"pose{i}", 4, f'<framequat name="pose{i}" objtype="xbody" objname="{body}"/>'),
            Sensor(f"touch{i}", 1, f'<touch name="touch{i}" site="pad{i}"/>'),
            Sensor(f"place{i}", 3, f'<framepos name="place{i}" objtype="xbody" objname="arm{i}"/>'),
        ]
    return [*sensors, Sensor("compass", 3, f'<magnetometer name="compass" site="{BODIES[0]}_imu"/>')]


def many_imus(rng: np.random.Generator, learnt: frozenset[int] = LAB_ADDRESSES) -> Many:
    """Return a model of free bodies with an IMU each, whose sensors are named as in the lab model but lie elsewhere in sensordata.

    Some places have a magnetometer too; one has an accelerometer alone, which is no IMU. No IMU sensor begins at an index in
    `learnt` (those of the lab model), so that code with fixed indices fails.
    """
    bodies = int(rng.integers(4, 7))
    chosen = [_MORE_PLACES[i] for i in rng.permutation(len(_MORE_PLACES))[: bodies + 1]]
    places, alone = tuple(chosen[:bodies]), chosen[bodies]
    imus = tuple((f"{place}_accelerometer", f"{place}_gyroscope") for place in places)
    compasses = tuple(place for i, place in enumerate(places) if i % 2 == 0)
    sensors = [
        *(sensor for sensor in _sensors(imus) if sensor.name != "compass"),
        Sensor(f"{alone}_accelerometer", 3, f'<accelerometer name="{alone}_accelerometer" site="pad0"/>'),
        *(_compass(place, places.index(place)) for place in compasses),
    ]
    while True:
        order = [sensors[i] for i in rng.permutation(len(sensors))]
        if _no_mistake_is_right(order, imus, learnt):
            break
    text = _SHUFFLED.format(
        bodies="\n".join(_body(rng, i) for i in range(bodies)), sensors="\n".join(f"    {s.xml}" for s in order)
    )
    return Many(text.replace('model="shuffled"', 'model="many_imus"'), places, compasses)


def _compass(place: str, body: int) -> Sensor:
    return Sensor(f"{place}_magnetometer", 3, f'<magnetometer name="{place}_magnetometer" site="{BODIES[body]}_imu"/>')


def _no_mistake_is_right(order: list[Sensor], imus: tuple[tuple[str, str], ...], learnt: frozenset[int]) -> bool:
    ends = np.cumsum([sensor.dim for sensor in order])
    place = {sensor.name: (i, int(ends[i]) - sensor.dim) for i, sensor in enumerate(order)}
    return all(_is_hard(place[accel], place[gyro], int(ends[-1]), learnt) for accel, gyro in imus)


def _is_hard(accel: tuple[int, int], gyro: tuple[int, int], size: int, learnt: frozenset[int]) -> bool:
    apart = all(
        address not in (sensor, 3 * sensor) and 1 <= address <= size - 4 and 3 * sensor <= size - 3
        for sensor, address in (accel, gyro)
    )
    elsewhere = learnt.isdisjoint({accel[1], gyro[1]})
    return apart and elsewhere and abs(gyro[1] - accel[1]) != 3 and size >= max(learnt) + 3
