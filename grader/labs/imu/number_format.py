"""Format two vectors for students with enough decimals to differ."""

from __future__ import annotations

from grader.labs.imu.compare import Array, vector

_FEWEST, _MOST = 3, 16


def distinct_texts(wanted: Array, got: Array) -> tuple[str, str]:
    """Format both numbers with the fewest decimals, at least three, in which they differ."""
    pairs = ((vector(wanted, decimals), vector(got, decimals)) for decimals in range(_FEWEST, _MOST + 1))
    return next((pair for pair in pairs if pair[0] != pair[1]), (vector(wanted), vector(got)))
