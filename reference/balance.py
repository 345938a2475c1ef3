"""Solve for the pose and the springs in which the lab model rests, and write them into its file.

Run it after a change of a mass, a length or a stiffness: `python -m reference.balance`. It moves the pelvis until the
sole pads carry the weight, the pads and the battery until the centre of mass is above the middle of the pads, and
sets every `springref` such that the springs hold the links against gravity.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

MODEL = Path(__file__).with_name("models") / "humanoid-sensors.xml"
BATTERY = 1.5  # kg, as in the model
ROUNDS = 20


def missing_forces(model: mujoco.MjModel) -> NDArray[np.float64]:
    """Generalised forces (nv,) that would have to be added for the initial pose to rest; zero in balance.

    Inverse dynamics at zero velocity and zero acceleration. The soft contacts' forces follow from how deep the pads are
    in the floor alone, so this is exact.
    """
    data = mujoco.MjData(model)
    mujoco.mj_inverse(model, data)
    return np.array(data.qfrc_inverse)


def balanced(text: str) -> str:
    """One round: the model's text with height, pads, battery and springs moved against the missing forces."""
    text = _shift(text, r'<body name="pelvis" pos="', 2, _sinking(mujoco.MjModel.from_xml_string(text)))
    model = mujoco.MjModel.from_xml_string(text)
    force = missing_forces(model)
    weight = float(model.body_subtreemass[1] * -model.opt.gravity[2])
    text = _shift(text, r'name="(?:left|right)_(?:toe|heel)_\w+" class="pad" pos="', 0, -force[4] / weight)
    text = _shift(text, r'name="battery" type="box" pos="', 1, -force[3] / (BATTERY * -model.opt.gravity[2]))
    return _set_springs(text, model, force)


def _sinking(model: mujoco.MjModel) -> float:
    """How far the pelvis has to go up (m) for the vertical force to balance, by bisection on the initial height."""
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


def _shift(text: str, before: str, axis: int, by: float) -> str:
    """Add `by` to one coordinate of every `pos` that follows the pattern `before`."""

    def moved(match: re.Match[str]) -> str:
        numbers = match.group(2).split()
        numbers[axis] = f"{float(numbers[axis]) + by:.9g}"
        return match.group(1) + " ".join(numbers)

    return re.sub(f'({before})([^"]*)', moved, text)


def _set_springs(text: str, model: mujoco.MjModel, force: NDArray[np.float64]) -> str:
    """A spring pulls with stiffness × (springref − q): the reference moves by missing force / stiffness."""
    for joint in range(1, model.njnt):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
        dof, place = model.jnt_dofadr[joint], model.jnt_qposadr[joint]
        reference = model.qpos_spring[place] + force[dof] / model.jnt_stiffness[joint]
        head = re.escape(f'<joint name="{name}"')
        text = re.sub(f'({head}[^/]*?)(?: springref="[^"]*")?/>', rf'\g<1> springref="{reference:.9f}"/>', text)
    return text


def main() -> int:
    text = MODEL.read_text(encoding="utf-8")
    for _ in range(ROUNDS):
        text = balanced(text)
    MODEL.write_text(text, encoding="utf-8")
    left = np.abs(missing_forces(mujoco.MjModel.from_xml_string(text))).max()
    print(f"{MODEL}: largest missing force {left:.2g} N or N m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
