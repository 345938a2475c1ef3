"""Two vectors as a student reads them, with as many decimals as it takes to see that they differ."""

from __future__ import annotations

import numpy as np

from grader.labs.imu.compare import Array

_FEWEST, _MOST = 3, 16


def told_apart(wanted: Array, got: Array) -> tuple[str, str]:
    """Both in the fewest decimals, three at least, in which they are not the same."""
    pairs = ((_written(wanted, decimals), _written(got, decimals)) for decimals in range(_FEWEST, _MOST + 1))
    return next((pair for pair in pairs if pair[0] != pair[1]), (_written(wanted, _FEWEST), _written(got, _FEWEST)))


def _written(values: Array, decimals: int) -> str:
    return np.array2string(
        np.asarray(values, float), precision=decimals, suppress_small=False, floatmode="fixed", max_line_width=200
    )
