"""Noise of the right size and what stands beside it."""

from __future__ import annotations

import numpy as np
import pytest

from grader.labs.imu.noise_model import explain
from tests.judging.test_noise import _STILL, _WHITE, _of

pytestmark = pytest.mark.quick
_FAR = np.copy(_STILL)
_FAR[:, ::60] = 30.0


@pytest.mark.parametrize(("size", "right"), [(1, True), (2, False), (0.5, False)])
def test_beside_a_few_values_that_are_far_off_the_size_of_the_others_counts(size: float, right: bool) -> None:
    assert explain._right_but_for_strays(_of(size * _WHITE + _FAR)) is right


def test_without_strays_nothing_is_right_but_for_them() -> None:
    assert not explain._right_but_for_strays(_of(_WHITE))
