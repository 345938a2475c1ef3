"""Write a model that is spread over several files as one text that needs no other file, so that it can be sent and stored.

MuJoCo itself writes out includes. Textures and skins are left out, and height fields are written as numbers. A mesh that can
collide becomes its convex hull, which is what MuJoCo collides, or the plain shape that was fitted to it. Any other mesh becomes a
tiny sphere without mass or contacts. Bodies keep the inertia that their meshes gave them.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

_SPECK = {"type": "sphere", "size": "0.001", "mass": "0", "contype": "0", "conaffinity": "0"}
"""Replacement of a mesh that touches nothing: it keeps its name and its number among the geoms."""
_OF_MESHES = ("mesh", "fitscale", "density", "fromto", "axisangle", "euler", "xyaxes", "zaxis")
_SHOWN_ONLY = ("texture", "skin")
_CLOSE = 1e-3
"""Relative. MuJoCo writes a model with five or six digits."""


class NotOneTextError(ValueError):
    """Exception: a model loads other files, and could not be written as one text that simulates the same."""


def self_contained(path: Path) -> str:
    """Return the MJCF text of a model, changed so that it needs no other file.

    Parameters
    ----------
    path : Path
        A file that MuJoCo loads. Where it needs no other one, its text is taken as it is.

    Raises
    ------
    ValueError
        If MuJoCo does not load it; the message is MuJoCo's.
    NotOneTextError
        If the model could not be written as one text that simulates the same.
    """
    model = mujoco.MjModel.from_xml_path(str(path))
    if not _needs_files(ET.parse(path).getroot()):
        return path.read_text(encoding="utf-8-sig")
    root = ET.fromstring(_written_out(model))
    _without_pictures(root)
    _with_heights(root, model)
    _without_meshes(root, model)
    text = ET.tostring(root, encoding="unicode") + "\n"
    _prove_same(model, text)
    return text


def _needs_files(root: ET.Element) -> bool:
    names = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
    return any(element.tag == "include" or any(name in element.attrib for name in names) for element in root.iter())


def _written_out(model: mujoco.MjModel) -> str:
    with tempfile.TemporaryDirectory(prefix="imugrade-") as folder:
        path = Path(folder) / "model.xml"
        mujoco.mj_saveLastXML(str(path), model)
        return path.read_text(encoding="utf-8")


def _remove(root: ET.Element, *tags: str) -> None:
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag in tags]:
            parent.remove(child)


def _without_pictures(root: ET.Element) -> None:
    _remove(root, *_SHOWN_ONLY)
    for material in root.iter("material"):
        material.attrib.pop("texture", None)
        for layer in material.findall("layer"):
            material.remove(layer)


def _numbers(values: Any) -> str:
    """Format numbers with all digits of single precision, in which MuJoCo keeps meshes and heights; enough for the rest."""
    return " ".join(f"{value:.9g}" for value in np.ravel(values))


# --- height fields ----------------------------------------------------------------------------------------------------


def _with_heights(root: ET.Element, model: mujoco.MjModel) -> None:
    for index, field in enumerate(root.iter("hfield")):
        rows, columns = int(model.hfield_nrow[index]), int(model.hfield_ncol[index])
        start = int(model.hfield_adr[index])
        heights = model.hfield_data[start : start + rows * columns].reshape(rows, columns)
        for name in ("file", "content_type", "elevation"):
            field.attrib.pop(name, None)
        field.set("nrow", str(rows))
        field.set("ncol", str(columns))
        if np.ptp(heights) > 0:
            field.set("elevation", _numbers(heights[::-1]))  # a text begins with the row that is farthest along y


# --- meshes -----------------------------------------------------------------------------------------------------------


def _without_meshes(root: ET.Element, model: mujoco.MjModel) -> None:
    """Put hulls in place of the meshes that touch, specks in place of the others; write out the inertia of bodies that had one."""
    owners = _owners(root)
    elements = [geom for owner in owners for geom in owner.findall("geom")]
    if len(owners) != model.nbody or len(elements) != model.ngeom:
        raise NotOneTextError("the bodies and geoms that MuJoCo writes are not those that it simulates")
    paired = {pair.get(name) for pair in root.iter("pair") for name in ("geom1", "geom2")}
    hulls: dict[str, str] = {}
    of_meshes: set[int] = set()
    for index, geom in enumerate(elements):
        if "mesh" not in geom.attrib and model.geom_type[index] != mujoco.mjtGeom.mjGEOM_MESH:
            continue
        of_meshes.add(int(model.geom_bodyid[index]))
        touches = model.geom_contype[index] or model.geom_conaffinity[index] or geom.get("name") in paired
        _replace(geom, index, model, hulls, touches=bool(touches))
    _give_inertia(root, owners, model, of_meshes)
    _remove(root, "mesh")
    assets = root.find("asset")
    for name, vertices in hulls.items():
        ET.SubElement(root if assets is None else assets, "mesh", {"name": name, "vertex": vertices})


def _owners(root: ET.Element) -> list[ET.Element]:
    """Return the world and all bodies in the order in which MuJoCo numbers them: each before the bodies attached to it."""
    return [element for world in root.findall("worldbody") for element in (world, *world.iter("body"))]


def _replace(geom: ET.Element, index: int, model: mujoco.MjModel, hulls: dict[str, str], *, touches: bool) -> None:
    """Replace a mesh's geom by a convex hull, by the plain shape that was fitted to it, or by a speck if it never collides."""
    for name in _OF_MESHES:
        geom.attrib.pop(name, None)
    geom.set("pos", _numbers(model.geom_pos[index]))
    geom.set("quat", _numbers(model.geom_quat[index]))
    if not touches:
        geom.attrib.update(_SPECK)
    elif model.geom_type[index] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[index])
        name = f"hull_{mesh}"
        hulls.setdefault(name, _numbers(_hull(model, mesh)))
        geom.attrib.update(type="mesh", mesh=name)
    else:  # a plain shape that was fitted to a mesh
        kind = mujoco.mjtGeom(int(model.geom_type[index])).name.removeprefix("mjGEOM_").lower()
        geom.attrib.update(type=kind, size=_numbers(model.geom_size[index]))


def _hull(model: mujoco.MjModel, mesh: int) -> Any:
    """Return the corners (n, 3) of a mesh's convex hull, in the frame of `geom_pos` and `geom_quat`."""
    start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = model.mesh_vert[start : start + count]
    from scipy.spatial import ConvexHull  # noqa: PLC0415 - takes long to import, and few robots have meshes

    return vertices[ConvexHull(vertices).vertices]


def _give_inertia(root: ET.Element, owners: list[ET.Element], model: mujoco.MjModel, of_meshes: set[int]) -> None:
    """Write the mass and inertia that MuJoCo computed from a mesh into its body, so that they stay without the mesh."""
    always = any(compiler.get("inertiafromgeom") == "true" for compiler in root.findall("compiler"))
    for body in range(1, model.nbody) if always else sorted(of_meshes - {0}):
        if model.body_mass[body] == 0:
            continue
        _remove_own(owners[body], "inertial")
        inertial = {
            "pos": _numbers(model.body_ipos[body]),
            "quat": _numbers(model.body_iquat[body]),
            "mass": _numbers(model.body_mass[body]),
            "diaginertia": _numbers(model.body_inertia[body]),
        }
        owners[body].insert(0, ET.Element("inertial", inertial))
    for compiler in root.findall("compiler"):
        if compiler.get("inertiafromgeom") == "true":
            compiler.set("inertiafromgeom", "auto")


def _remove_own(element: ET.Element, tag: str) -> None:
    for child in element.findall(tag):
        element.remove(child)


# --- proof ------------------------------------------------------------------------------------------------------------


def _prove_same(model: mujoco.MjModel, text: str) -> None:
    """Raise NotOneTextError if MuJoCo compiles the text to a model that differs from the original."""
    try:
        again = mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        raise NotOneTextError(f"without its files MuJoCo does not load it: {error}") from None
    different = [name for name, one, other in _compared(model, again) if not _same(one, other)]
    if different:
        raise NotOneTextError(f"without its files it is another model: {', '.join(different)} differ")


def _compared(model: mujoco.MjModel, again: mujoco.MjModel) -> Iterator[tuple[str, Any, Any]]:
    """Yield name, original and new value of each property that has to be the same."""
    for name in ("nq", "nv", "nu", "na", "nbody", "ngeom", "nsensor", "nsensordata"):
        yield name, getattr(model, name), getattr(again, name)
    for name in ("qpos0", "body_mass", "body_pos", "dof_damping", "sensor_type", "sensor_adr"):
        yield name, getattr(model, name), getattr(again, name)


def _same(one: Any, other: Any) -> bool:
    return np.shape(one) == np.shape(other) and bool(np.allclose(one, other, rtol=_CLOSE, atol=_CLOSE))
