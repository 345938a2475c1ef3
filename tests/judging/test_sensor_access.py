"""What readings follow, by facts that are built by hand: four sensors in one array, an IMU of two and another of two."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.sensor_access import explain
from grader.labs.imu.sensor_access.measure import Facts, Scene, Visit

pytestmark = pytest.mark.quick
_RNG = np.random.default_rng(3)
_DATA, _STATES = _RNG.normal(0, 4, (13, 14)), _RNG.normal(0, 4, (13, 9))
_ADDRESS = np.array([0, 1, 4, 7, 8, 11])
_TURN = np.linalg.qr(_RNG.normal(size=(13, 3, 3)))[0]


def _scene(*pair: int) -> Scene:
    return Scene(_DATA, _ADDRESS, (pair[0], pair[1]), _TURN, _STATES, _STATES + 1, _STATES[:, :6], _STATES[:, 3:])


def _facts(read: Callable[[Scene, int], Array]) -> Facts:
    torso, other = (Visit(scene, (read(scene, 0), read(scene, 1))) for scene in (_scene(1, 2), _scene(5, 4)))
    now = np.array([torso.got[0][0], torso.got[1][0]])
    return Facts(torso, torso, (other,), now, np.zeros(4))


@pytest.mark.parametrize(("reverse", "follows"), [(1, True), (-1, False)])
def test_readings_follow_the_states_and_not_the_number_of_the_call(reverse: int, follows: bool) -> None:
    facts = _facts(lambda s, i: np.sin(s.true(i)))
    back = facts.torso.got[0][::reverse], facts.torso.got[1][::reverse]
    assert (explain._by_chance(replace(facts, reverse=back)) == "") is follows
