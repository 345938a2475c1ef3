"""Solve for the pose and the springs in which the lab model rests, and write them into its file.

Run it after a change of a mass, a length or a stiffness: `python -m reference.balance`. It moves the pelvis until the
sole pads carry the weight, the pads until the centre of mass is above their middle, and sets every `springref` such
that the springs hold the links against gravity.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

MODEL = Path(__file__).with_name("models") / "humanoid-sensors.xml"
ROUNDS = 20


def missing_forces(model: mujoco.MjModel) -> NDArray[np.float64]:
    """Return the generalised forces (nv,) that would have to be added for the initial pose to rest; zero in balance.

    Inverse dynamics at zero velocity and zero acceleration. The forces of soft contacts then depend only on how deep the
    pads are in the floor, so the result is exact.
    """
    data = mujoco.MjData(model)
    mujoco.mj_inverse(model, data)
    return np.array(data.qfrc_inverse)


def pads(model: mujoco.MjModel) -> list[int]:
    """Return the ids of the geoms that the robot stands on, its toe and heel pads, found by their names."""
    return [geom for geom in range(model.ngeom) if re.search("_(toe|heel)_", model.geom(geom).name or "")]


def settle(model: mujoco.MjModel) -> None:
    """Change in place the height, sole pads and springs' rest positions of a compiled model so that its initial pose rests."""
    soles, weight = pads(model), float(model.body_subtreemass[1] * -model.opt.gravity[2])
    for _ in range(ROUNDS):
        model.qpos0[2] += _sinking(model)
        force = missing_forces(model)
        model.geom_pos[soles, :2] += np.array([-force[4], force[3]]) / weight
        for joint in range(1, model.njnt):  # a spring pulls with stiffness × (springref − q)
            dof, place = model.jnt_dofadr[joint], model.jnt_qposadr[joint]
            model.qpos_spring[place] += force[dof] / model.jnt_stiffness[joint]


def balanced(text: str) -> str:
    """Return the MJCF `text` with height, sole pads and springs changed so that the robot's initial pose rests; keep the rest."""
    model = mujoco.MjModel.from_xml_string(text)
    settle(model)
    text = _set_pos(text, r'<body name="pelvis" pos="', model.qpos0[:3])
    for pad in pads(model):
        text = _set_pos(text, rf'name="{model.geom(pad).name}" class="pad" pos="', model.geom_pos[pad])
    return _set_springs(text, model)


def _sinking(model: mujoco.MjModel) -> float:
    """Return how far the pelvis has to rise (m) for the vertical force to balance, by bisection on the initial height."""
    data = mujoco.MjData(model)
    start = model.qpos0[2]
    low, high = -0.02, 0.02
    for _ in range(60):
        middle = (low + high) / 2
        data.qpos[:] = model.qpos0
        data.qpos[2] = start + middle
        mujoco.mj_inverse(model, data)
        low, high = (middle, high) if data.qfrc_inverse[2] < 0 else (low, middle)
    return (low + high) / 2


def _set_pos(text: str, before: str, pos: NDArray[np.float64]) -> str:
    """Replace the numbers in an attribute `pos` of the model's text; the pattern `before` ends where they begin."""
    return re.sub(f'({before})[^"]*', rf"\g<1>{' '.join(f'{number:.9g}' for number in pos)}", text)


def _set_springs(text: str, model: mujoco.MjModel) -> str:
    for joint in range(1, model.njnt):
        reference = model.qpos_spring[model.jnt_qposadr[joint]]
        head = re.escape(f'<joint name="{model.joint(joint).name}"')
        text = re.sub(f'({head}[^/]*?)(?: springref="[^"]*")?/>', rf'\g<1> springref="{reference:.9f}"/>', text)
    return text


def main() -> int:
    text = balanced(MODEL.read_text(encoding="utf-8"))
    MODEL.write_text(text, encoding="utf-8")
    left = np.abs(missing_forces(mujoco.MjModel.from_xml_string(text))).max()
    print(f"{MODEL}: largest missing force {left:.2g} N or N m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
