"""Draw another robot of the same kind: masses, springs, friction, IMUs, sensors and time step of any model's text.

A hidden motion must not be one that students can record beforehand. So for hidden traces, whose seed comes from the instructor's
secret, the model itself is another one. Nothing here knows a particular model: what is there is found in the compiled model and
written back, as explicit values, into the elements of the text.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MASSES = (0.8, 1.25)
"""Factor for each body's mass; its inertia goes with it."""
SPRINGS = (0.75, 1.3)
DAMPERS = (0.7, 1.4)
"""Factors for stiffness and damping: one for the whole model, and a share of the same range for each joint."""
FRICTION = (0.75, 1.3)
SHIFT_M = 0.02
"""Largest move of an IMU along each axis."""
YAW_RAD = 0.2
TILT_RAD = 0.005
"""Largest turns of an IMU: about its own z, and about an axis across that. This tilt moves gravity by 0.05 m/s²."""
TIMESTEPS = (0.5, 0.625, 1.0)
"""Factors for the time step. None is larger than one: a simulation that is stable stays so."""
EXTRA_SENSORS = (4, 7)
"""How many sensors are added: from, to but not including."""

_GENERATED = ("frame", "replicate", "attach", "composite", "flexcomp", "include")
_ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis", "fromto")
_IMU = ("accelerometer", "gyro")
_SWAPS = 1000


def vary(xml: str, rng: np.random.Generator) -> str:
    """Return a model with random changes of masses, springs, friction, IMUs, sensors and time step, for hidden traces.

    Parameters
    ----------
    xml : str
        MJCF of a model that needs no other file.
    rng : Generator
        A generator in the same state gives the same variant.

    Returns
    -------
    str
        MJCF with the same bodies, joints and geoms, and with every sensor of `xml` under its own name, among additional sensors.
    """
    robot = Robot.of(xml)
    _vary_bodies(robot, rng)
    _vary_joints(robot, rng)
    _vary_friction(robot, rng)
    _vary_imus(robot, rng)
    _vary_sensors(robot, rng)
    _vary_timestep(robot, rng)
    return robot.text()


@dataclass(frozen=True)
class Robot:
    """A model as XML tree, which `vary` changes, and as MuJoCo compiles it, with bodies, joints and geoms in the same order."""

    root: ET.Element
    model: mujoco.MjModel

    @classmethod
    def of(cls, xml: str) -> Robot:
        """Read a model from its text; elements that generate others, such as `replicate`, are written out first."""
        model, root = mujoco.MjModel.from_xml_string(xml), ET.fromstring(xml)
        if any(root.find(f".//{tag}") is not None for tag in _GENERATED):
            root = ET.fromstring(_written_out(model))
        return cls(root, model)

    def text(self) -> str:
        return ET.tostring(self.root, encoding="unicode") + "\n"

    def bodies(self) -> Iterator[ET.Element]:
        """Yield each body before those attached to it, as MuJoCo numbers them; the world itself is not among them."""
        for world in self.root.findall("worldbody"):
            yield from world.iter("body")

    def parts(self, *tags: str) -> Iterator[ET.Element]:
        """Yield the elements with these tags that belong directly to the world or a body: the world's, then body by body."""
        for owner in (*self.root.findall("worldbody"), *self.bodies()):
            yield from (part for part in _hanging_on(owner) if part.tag in tags)

    def sensors(self) -> list[ET.Element]:
        return [sensor for section in self.root.findall("sensor") for sensor in section]


def _hanging_on(owner: ET.Element) -> Iterator[ET.Element]:
    for part in owner:
        if part.tag == "frame":
            yield from _hanging_on(part)
        elif part.tag != "body":
            yield part


def _written_out(model: mujoco.MjModel) -> str:
    with tempfile.TemporaryDirectory(prefix="imugrade-") as folder:
        path = Path(folder) / "model.xml"
        mujoco.mj_saveLastXML(str(path), model)
        return path.read_text(encoding="utf-8")


def numbers(values: FloatArray) -> str:
    """Format a vector for MJCF without rounding, because MuJoCo rejects an inertia that rounding made impossible."""
    return " ".join(repr(float(value)) for value in np.atleast_1d(values))


def _set_section(root: ET.Element, tag: str, name: str, value: str) -> None:
    """Set an attribute once, in the last section `tag`, which is made if there is none; MuJoCo reads it from all such sections."""
    for section in root.findall(tag):
        section.attrib.pop(name, None)
    last = [*root.findall(tag)][-1:] or [ET.SubElement(root, tag)]
    last[0].set(name, value)


# --- what moves -----------------------------------------------------------------------------------------------------


def _vary_bodies(robot: Robot, rng: np.random.Generator) -> None:
    """Redraw the mass of every body, as an explicit inertia, whether it came from geoms or not."""
    model = robot.model
    for body, element in enumerate(robot.bodies(), start=1):
        factor = rng.uniform(*MASSES)
        if model.body_mass[body] == 0:
            continue
        for old in element.findall("inertial"):
            element.remove(old)
        inertial = {
            "pos": numbers(model.body_ipos[body]),
            "quat": numbers(model.body_iquat[body]),
            "mass": numbers(factor * model.body_mass[body]),
            "diaginertia": numbers(factor * model.body_inertia[body]),
        }
        element.insert(0, ET.Element("inertial", inertial))
    for compiler in robot.root.findall("compiler"):
        compiler.attrib.pop("settotalmass", None)
    _set_section(robot.root, "compiler", "inertiafromgeom", "auto")


def _shared(rng: np.random.Generator, bounds: tuple[float, float]) -> Iterator[float]:
    """Yield random factors with a common part, so that the whole model is stiffer or softer, and a smaller part of their own."""
    low, high = np.log(bounds)
    common = rng.uniform(low, high)
    while True:
        yield float(np.exp(common + 0.5 * rng.uniform(low, high)))


def _vary_joints(robot: Robot, rng: np.random.Generator) -> None:
    model = robot.model
    springs, dampers = _shared(rng, SPRINGS), _shared(rng, DAMPERS)
    for joint, element in enumerate(robot.parts("joint", "freejoint")):
        stiffness = next(springs) * model.jnt_stiffness[joint]
        damping = next(dampers) * model.dof_damping[model.jnt_dofadr[joint]]
        if element.tag == "freejoint":
            continue
        element.attrib.pop("springdamper", None)
        if stiffness > 0:
            element.set("stiffness", numbers(stiffness))
        if damping > 0:
            element.set("damping", numbers(damping))


def _vary_friction(robot: Robot, rng: np.random.Generator) -> None:
    model = robot.model
    factors = _shared(rng, FRICTION)
    for geom, element in enumerate(robot.parts("geom")):
        factor = next(factors)
        if model.geom_contype[geom] or model.geom_conaffinity[geom]:
            element.set("friction", numbers(factor * model.geom_friction[geom]))


# --- what measures --------------------------------------------------------------------------------------------------


def _vary_imus(robot: Robot, rng: np.random.Generator) -> None:
    """Move and turn each site that carries an accelerometer or a gyroscope, by little, so that their readings change."""
    sites = {sensor.get("site") for sensor in robot.sensors() if sensor.tag in _IMU}
    for element in [site for site in robot.parts("site") if site.get("name") in sites]:
        site = robot.model.site(element.get("name"))
        _out_of_frames(robot.root, element)
        for name in _ORIENTATIONS:
            element.attrib.pop(name, None)
        element.set("pos", numbers(site.pos + rng.uniform(-SHIFT_M, SHIFT_M, 3)))
        element.set("quat", numbers(_turned(site.quat, rng)))
        element.set("size", numbers(site.size))


def _out_of_frames(root: ET.Element, element: ET.Element) -> None:
    """Move an element out of `frame` elements to its body, because the compiled model's positions refer to the body."""
    owners = {part: owner for owner in root.iter() for part in owner}
    owner = owners[element]
    if owner.tag == "frame":
        owner.remove(element)
        while owner.tag == "frame":
            owner = owners[owner]
        owner.append(element)


def _turned(quat: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the mounting of an IMU, a quaternion (4,), turned about its own axes: freely about z, hardly about the others."""
    across, yaw = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-YAW_RAD, YAW_RAD)
    tilt = rng.uniform(0.0, TILT_RAD)
    turned = np.array(quat, dtype=np.float64)
    for axis, angle in (([np.cos(across), np.sin(across), 0.0], tilt), ([0.0, 0.0, 1.0], yaw)):
        turn, before = np.zeros(4), turned.copy()
        mujoco.mju_axisAngle2Quat(turn, np.array(axis), angle)
        mujoco.mju_mulQuat(turned, before, turn)
    return turned


def _vary_sensors(robot: Robot, rng: np.random.Generator) -> None:
    """Put the sensors into another order, with others of one, three and four numbers among them, so that addresses change."""
    old = robot.sensors()
    dims = dict(zip(old, (int(dim) for dim in robot.model.sensor_dim), strict=True))
    for element in _extra_sensors(robot, rng):
        dims[element] = {"clock": 1, "framequat": 4}.get(element.tag, 3)
    order = _order(list(dims), list(dims.values()), robot.model, rng)
    for section in robot.root.findall("sensor"):
        robot.root.remove(section)
    ET.SubElement(robot.root, "sensor").extend(order)


def _extra_sensors(robot: Robot, rng: np.random.Generator) -> Iterator[ET.Element]:
    """Yield further sensors that change the addresses of others: clocks, and others at sites that have an IMU."""
    taken = {sensor.get("name") for sensor in robot.sensors()}
    sites = sorted({str(sensor.get("site")) for sensor in robot.sensors() if sensor.tag in _IMU})
    for number in range(int(rng.integers(*EXTRA_SENSORS))):
        tag = str(rng.choice(["clock", "clock", "framequat", "framepos", "velocimeter"])) if sites else "clock"
        name = next(name for name in (f"{tag}_{number}", f"more_{tag}_{number}") if name not in taken)
        site = {} if tag == "clock" else {"site": str(rng.choice(sites))}
        if tag.startswith("frame"):
            site = {"objtype": "site", "objname": site["site"]}
        yield ET.Element(tag, {"name": name, **site})


def _order(
    sensors: list[ET.Element], dims: list[int], model: mujoco.MjModel, rng: np.random.Generator
) -> list[ET.Element]:
    """Return the sensors in a random order in which, if possible, no IMU's address can be guessed from the public model."""
    old = {int(adr) for adr, sensor in zip(model.sensor_adr, sensors, strict=False) if sensor.tag in _IMU}
    limit = int(model.nsensordata)  # an address that is learnt from the variant is in range in other models, too

    def guesses(order: NDArray[np.int64]) -> int:
        return _guesses([sensors[i] for i in order], [dims[i] for i in order], old, limit)

    order = rng.permutation(len(sensors))
    left = guesses(order)
    for _ in range(_SWAPS):
        if not left:
            break
        other = order.copy()
        pair = rng.choice(len(order), 2, replace=False)
        other[pair] = other[pair[::-1]]
        if (guessed := guesses(other)) <= left:
            order, left = other, guessed
    return [sensors[i] for i in order]


def _guesses(order: list[ET.Element], dims: list[int], old: set[int], limit: int) -> int:
    """Count the IMU sensors that wrong code finds by luck: at their id, three times it, after their partner, at the old place."""
    starts = np.concatenate([[0], np.cumsum(dims)]).astype(int)
    place = {
        (sensor.get("site"), sensor.tag): (i, int(starts[i])) for i, sensor in enumerate(order) if sensor.tag in _IMU
    }
    behind = {site: start + 3 for (site, tag), (_, start) in place.items() if tag == "accelerometer"}
    return sum(
        at in (i, 3 * i) or at in old or max(at, 3 * i) + 3 > limit or (tag == "gyro" and at == behind.get(site))
        for (site, tag), (i, at) in place.items()
    )


def _vary_timestep(robot: Robot, rng: np.random.Generator) -> None:
    _set_section(robot.root, "option", "timestep", numbers(rng.choice(TIMESTEPS) * robot.model.opt.timestep))
