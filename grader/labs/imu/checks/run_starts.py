"""Faults of the start of a run and of its model, from a claim that a simulation of the grader has confirmed."""

from __future__ import annotations

import numpy as np

from grader.engine.findings import CheckFailed, Size
from grader.labs.imu.answers import Collection
from grader.labs.imu.compare import Array, vector
from grader.labs.imu.diagnosis.collection import Claim, Story, Worlds

PUSH = "data.qvel[0] = 0.5 after the reset"
_SAME = 1e-9
"""A claim is told in full precision and has been borne out: whatever differs by more was set to another number."""
_GRAVITY_ATOL = 1e-3
"""m/s². Whoever writes the model's own gravity again with three decimals has not changed it."""


def _claim_of(story: Story | None, worlds: Worlds) -> Claim | None:
    """The claim that a run is known to bear out."""
    return worlds.claim if story is not None and story.of_claim else None


def _differ(a: Array, b: Array) -> bool:
    return bool(np.abs(a - b).max() > _SAME)


def in_another_pose(story: Story | None, worlds: Worlds, start: Array) -> bool:
    """Return whether a run is known to begin in another pose than the model's own (nq,)."""
    claim = _claim_of(story, worlds)
    if claim is None:
        return story is not None and story.world == "no_reset"
    return _differ(claim.qpos, start)


def with_other_velocities(story: Story | None, worlds: Worlds, push: Collection) -> bool:
    """Return whether a run begins with velocities that an earlier run left."""
    claim = _claim_of(story, worlds)
    return claim is not None and bool(push.first_step) and _differ(claim.qvel, push.first_step["qvel"])


def are_pushed_apart(first: Collection, second: Collection) -> bool:
    """Return whether two runs of one kind, both from a fresh state, start with other velocities."""
    told = bool(first.first_step and second.first_step)
    return told and _differ(first.first_step["qvel"], second.first_step["qvel"])


def in_another_model(story: Story, worlds: Worlds, series: Collection, gravity: Array) -> None:
    """Charge a model that was changed for the run and put back: what is left changed is charged by starts_from_reset."""
    claim = _claim_of(story, worlds)
    if claim is None or series.changed:
        return
    if abs(claim.timestep - worlds.timestep) > _SAME:
        got = f"rows of a simulation with a time step of {claim.timestep:g} s"
        raise CheckFailed(
            f"a simulation with the model's time step of {worlds.timestep:g} s", got, mistakes=["modifies-model"]
        )
    if np.abs(claim.gravity - gravity).max() > _GRAVITY_ATOL:
        raise CheckFailed(
            "a simulation with the model's gravity",
            f"rows of one with {vector(claim.gravity)} m/s²",
            mistakes=["modifies-model"],
        )


def with_another_push(claim: Claim) -> None:
    """Charge what is not the sheet's push, once and at the start, or is none."""
    pushed = np.flatnonzero(np.abs(claim.qvel) > _SAME)
    if claim.force.any():
        got = f"a recording with a force of up to {np.abs(claim.force).max():.3g} N or Nm"
        raise CheckFailed(f"{PUSH}, and no force", got, mistakes=["wrong-perturbation"])
    if not len(pushed) and len(claim.set_at):
        got = f"a velocity that is set before step {claim.set_at[0] + 1:.0f}, and not at the start"
        _wrongly_pushed(got, Size("a velocity that is set later, and not at the start"))
    if not len(pushed):
        raise CheckFailed(PUSH, "a recording without a push", mistakes=["no-perturbation"])
    if len(pushed) != 1 or pushed[0] != 0 or abs(claim.qvel[0] - 0.5) > _SAME:
        _wrongly_pushed(
            f"a recording that starts with {_in_words(claim.qvel)}", Size("a recording that starts with another push")
        )
    if len(claim.set_at):
        times = "once" if len(claim.set_at) == 1 else f"{len(claim.set_at)} times"
        got = (
            f"qpos, qvel or a force set {times} while the simulation runs, first before step {claim.set_at[0] + 1:.0f}"
        )
        _wrongly_pushed(got, Size("qpos, qvel or a force set again while the simulation runs"))


def _wrongly_pushed(got: str, off: Size) -> None:
    raise CheckFailed("data.qvel[0] = 0.5 once, right after the reset", got, mistakes=["wrong-perturbation"], off=off)


def velocities(series: Collection) -> str:
    """Return the velocities at the start of a run in words."""
    return _in_words(series.first_step["qvel"]) or "no velocity"


def _in_words(qvel: Array) -> str:
    pushed = np.flatnonzero(np.abs(qvel) > _SAME)
    return ", ".join(f"qvel[{i}] = {qvel[i]:.3g}" for i in pushed[:3]) + (" …" if len(pushed) > 3 else "")
