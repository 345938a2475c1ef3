"""How a run began, by claims that are made by hand: how near is the same, and what is nobody's claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.findings import CheckFailed
from grader.labs.imu.answers import Array, Collection
from grader.labs.imu.checks import run_starts
from grader.labs.imu.diagnosis.collection import CLAIMED_WORLD, OWN_WORLD, Claim, Story, Worlds

pytestmark = pytest.mark.quick
_GRAVITY = np.array([0.0, 0.0, -9.81])
_CLAIM = Claim(
    qpos=np.zeros(3), qvel=np.array([0.5, 0.0, 0.0, 0.0]), gravity=_GRAVITY, timestep=0.002, force=np.zeros(2), set_at=np.zeros(0),
    set_qvel=np.zeros((0, 4)),
)  # fmt: skip
_CLAIMED = Story(CLAIMED_WORLD)
_SERIES = Collection(None, None, None)


def _worlds(claim: Claim | None = _CLAIM) -> Worlds:
    return Worlds({}, 0.002, 1.0, 500, claim)


def _started(velocities: Array) -> Collection:
    told: Mapping[str, Array] = {"qvel": velocities}
    return replace(_SERIES, first_step=told)


def _differs_by(size: float) -> Array:
    return np.array([0.0, 0.0, size, 0.0])


@pytest.mark.parametrize(("by", "other"), [(0.0, False), (1e-9, False), (1.5e-9, True), (-0.1, True)])
def test_what_is_nearer_than_numbers_round_is_the_same_start(by: float, other: bool) -> None:
    still = _worlds(replace(_CLAIM, qvel=np.zeros(4), qpos=np.zeros(4)))
    assert run_starts.in_another_pose(_CLAIMED, still, _differs_by(by)) is other
    assert run_starts.with_other_velocities(_CLAIMED, still, _started(_differs_by(by))) is other
    assert run_starts.are_pushed_apart(_started(np.zeros(4)), _started(_differs_by(by))) is other


def test_the_claim_is_that_of_a_run_which_bears_it_out() -> None:
    elsewhere = np.ones(3)
    assert run_starts.in_another_pose(Story(OWN_WORLD), _worlds(), elsewhere)
    for story in (None, Story(), Story("push_weak")):
        assert not run_starts.in_another_pose(story, _worlds(), elsewhere)
        assert not run_starts.with_other_velocities(story, _worlds(), _started(np.ones(4)))


def test_without_a_claim_the_story_of_no_reset_alone_begins_in_another_pose() -> None:
    assert run_starts.in_another_pose(Story("no_reset"), _worlds(None), np.ones(3))
    assert not run_starts.in_another_pose(Story("no_push"), _worlds(None), np.ones(3))
    assert not run_starts.in_another_pose(None, _worlds(None), np.ones(3))


def test_runs_of_which_one_says_nothing_are_not_told_apart() -> None:
    assert not run_starts.are_pushed_apart(_SERIES, _started(np.ones(4)))
    assert not run_starts.are_pushed_apart(_started(np.ones(4)), _SERIES)
    assert not run_starts.with_other_velocities(_CLAIMED, _worlds(), _SERIES)


@pytest.mark.parametrize(
    "claim",
    [
        replace(_CLAIM, timestep=0.002 + 1.5e-9),
        replace(_CLAIM, gravity=np.array([0, 0.0015, -9.81])),
        replace(_CLAIM, gravity=np.array([0, -0.0015, -9.81])),
    ],
)
def test_another_model_is_charged_where_it_was_put_back(claim: Claim) -> None:
    with pytest.raises(CheckFailed):
        run_starts.in_another_model(_CLAIMED, _worlds(claim), _SERIES, _GRAVITY)
    run_starts.in_another_model(_CLAIMED, _worlds(claim), replace(_SERIES, changed=("opt.timestep",)), _GRAVITY)
    run_starts.in_another_model(Story(), _worlds(claim), _SERIES, _GRAVITY)
    run_starts.in_another_model(_CLAIMED, _worlds(None), _SERIES, _GRAVITY)


@pytest.mark.parametrize(
    "claim", [_CLAIM, replace(_CLAIM, timestep=0.002 + 5e-10), replace(_CLAIM, gravity=np.array([0, 9e-4, -9.81]))]
)
def test_a_model_that_is_as_good_as_the_same_is_not_charged(claim: Claim) -> None:
    run_starts.in_another_model(_CLAIMED, _worlds(claim), _SERIES, _GRAVITY)


@pytest.mark.parametrize(
    ("velocities", "words"),
    [
        ([0.0] * 5, "no velocity"),
        ([1e-9, 0, 0, 0, 0], "no velocity"),
        ([1.5e-9, 0, 0, 0, 0], "qvel[0] = 1.5e-09"),
        ([0, -0.25, 0, 0, 0], "qvel[1] = -0.25"),
        ([0, 1, 2, 3, 0], "qvel[1] = 1, qvel[2] = 2, qvel[3] = 3"),
        ([0, 1, 2, 3, 4], "qvel[1] = 1, qvel[2] = 2, qvel[3] = 3 …"),
    ],
)
def test_a_start_is_told_by_three_velocities_at_most(velocities: list[float], words: str) -> None:
    assert run_starts.velocities(_started(np.array(velocities, float))) == words


def _lost(claim: Claim) -> CheckFailed:
    with pytest.raises(CheckFailed) as lost:
        run_starts.with_another_push(claim)
    return lost.value


@pytest.mark.parametrize(
    "qvel", [[0.5, 1.5e-9, 0, 0], [0.5 + 1.5e-9, 0, 0, 0], [0.5 - 1.5e-9, 0, 0, 0], [0, 0.5, 0, 0], [-0.5, 0, 0, 0]]
)
def test_another_velocity_is_another_push(qvel: list[float]) -> None:
    lost = _lost(replace(_CLAIM, qvel=np.array(qvel, float)))
    assert lost.mistakes == ("wrong-perturbation",)
    assert lost.got.startswith("a recording that starts with qvel[")


@pytest.mark.parametrize("qvel", [[0.5, 1e-9, 0, 0], [0.5 + 5e-10, 0, 0, 0], [0.5, -5e-10, 0, 0]])
def test_the_push_of_the_sheet_is_not_charged(qvel: list[float]) -> None:
    run_starts.with_another_push(replace(_CLAIM, qvel=np.array(qvel, float)))


def test_a_force_is_charged_first_and_by_its_largest_part() -> None:
    lost = _lost(replace(_CLAIM, qvel=np.zeros(4), force=np.array([2.0, -3.0]), set_at=np.array([4.0])))
    assert (lost.got, lost.mistakes) == ("a recording with a force of up to 3 N or Nm", ("wrong-perturbation",))
    assert lost.expected == "data.qvel[0] = 0.5 after the reset, and no force"


def test_a_push_that_comes_later_is_told_by_the_first_step_before_which_it_comes() -> None:
    lost = _lost(replace(_CLAIM, qvel=np.zeros(4), set_at=np.array([40.0, 80.0])))
    assert lost.got == "a velocity that is set before step 41, and not at the start"
