"""What a student's function returned, as numbers: what is masked is none, whatever stands in memory in its place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from grader.worker.values import Packer, numbers

MASKED = np.ma.masked_array([1, 2, 3], mask=[False, True, False])


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (np.array([1, 2, 3]), [1.0, 2.0, 3.0]),
        ((np.float32(1), 2), [1.0, 2.0]),
        (MASKED, [1.0, np.nan, 3.0]),
        (np.ma.masked_all(3), [np.nan] * 3),
        (np.ma.masked_array([1.0, 2.0]), [1.0, 2.0]),
    ],
)
def test_numbers(value: Any, wanted: list[float]) -> None:
    found = numbers(value)
    assert type(found) is np.ndarray
    np.testing.assert_array_equal(found, wanted)


def test_a_masked_array_is_an_array_with_gaps() -> None:
    packer = Packer()
    node = packer.node(MASKED)
    assert node["kind"] == "array"
    np.testing.assert_array_equal(packer.arrays[node["key"]], [1.0, np.nan, 3.0])
