"""Where a reader reads whatever it is told, from its numbers and what stands in sensordata."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu import bundles
from grader.labs.imu.diagnosis import reading

pytestmark = pytest.mark.quick
REST = 40  # where three numbers that never move stand


@pytest.fixture(scope="module")
def scene() -> reading.Scene:
    """The lab robot's IMU, and some sensors that feel nothing."""
    known = reading.Scene.of(bundles.shipped()["reading_lab"], slice(0, 1))
    return replace(known, sensordata=np.insert(known.sensordata, REST, np.zeros((3, 1)), axis=1))


def at(scene: reading.Scene, first: int) -> np.ndarray:
    return scene.sensordata[None, :, first : first + 3]


def test_two_other_places_are_found(scene: reading.Scene) -> None:
    assert reading.at_fixed_places(at(scene, 20), at(scene, 30), scene) is not None


def test_beside_a_place_that_is_wrong_numbers_that_never_move_stand_where_such_numbers_do(scene: reading.Scene) -> None:
    assert reading.at_fixed_places(at(scene, 20), at(scene, REST), scene) is not None


def test_beside_the_right_place_they_are_no_reading(scene: reading.Scene) -> None:
    right = int(scene.address[scene.pairs[0, 0]])
    assert reading.at_fixed_places(at(scene, right), at(scene, REST), scene) is None
    assert reading.at_fixed_places(at(scene, REST), at(scene, REST), scene) is None


def test_numbers_that_stand_nowhere_have_no_place(scene: reading.Scene) -> None:
    assert reading.at_fixed_places(at(scene, 20) + 1.0, at(scene, 30), scene) is None
    assert reading.at_fixed_places(at(scene, 20) * np.nan, at(scene, 30), scene) is None
