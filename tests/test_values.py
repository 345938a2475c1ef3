"""What a student's function returned, as numbers: what is masked is none, whatever stands in memory in its place."""

from __future__ import annotations

import numpy as np

from grader.worker.values import Packer, numbers


def test_numbers_of_a_masked_array_have_gaps() -> None:
    masked = np.ma.masked_array([1, 2, 3], mask=[False, True, False])
    packer = Packer()
    node = packer.node(masked)
    assert node["kind"] == "array"
    for found, wanted in [
        (packer.arrays[node["key"]], [1.0, np.nan, 3.0]),
        (numbers(masked), [1.0, np.nan, 3.0]),
        (numbers(np.ma.masked_all(3)), [np.nan] * 3),
        (numbers((np.float32(1), 2)), [1.0, 2.0]),
    ]:
        assert type(found) is np.ndarray
        np.testing.assert_array_equal(found, wanted)
