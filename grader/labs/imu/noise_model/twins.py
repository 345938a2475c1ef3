"""Difference of two noise models from the same seed with one parameter changed: everything else cancels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grader.labs.imu.compare import Array, same
from grader.labs.imu.noise_model.reads import EXACT, TRUTH_ATOL


@dataclass(frozen=True)
class Twins:
    """Reads (reads, 3) of one sensor, each series from the same seed.

    Attributes
    ----------
    base, again : twice with the same arguments; other : with a bias that is larger by `change` (3,); scaled : with a standard
        deviation that is `factor` times as large
    """

    base: Array
    again: Array
    other: Array
    scaled: Array
    change: Array
    factor: float

    @cached_property
    def seeded(self) -> bool:
        """Return whether the same seed gives the same reads; where it does not, differences tell nothing."""
        return same(self.base, self.again, EXACT)

    @cached_property
    def response(self) -> Array:
        """(reads, 3) what the change of the bias did."""
        return np.asarray(self.other - self.base)

    def adds_bias(self, grain: float = 0.0) -> bool:
        """Return whether every read is larger by just what the bias is larger by, to the precision that the reads have."""
        return self.seeded and same(self.response, np.tile(self.change, (len(self.base), 1)), TRUTH_ATOL + grain)

    def begins_with_bias(self) -> bool:
        """Return whether the first read is, to a twentieth: all that can be asked of a bias that does not stay."""
        return self.seeded and same(self.response[0], self.change, 0.05 * float(np.abs(self.change).max()))

    def ignores_bias(self) -> bool:
        return self.seeded and not np.abs(self.response).max() > TRUTH_ATOL

    def noise_size(self) -> float:
        """The standard deviation that was asked for first, told by what a larger one adds from read to read; 0 where it is not.

        Whatever else moves is the same in both. 117 differences tell it to a tenth.
        """
        if not self.seeded:
            return 0.0
        added = np.diff(self.scaled - self.base, axis=0) / (self.factor - 1)
        return float(np.sqrt(np.mean(added**2) / 2))

    def scales(self) -> bool:
        """Return whether most of what reads differ by from one to the next is `factor` times as large."""
        if not self.seeded:
            return False
        wanted, came = self.factor * np.diff(self.base, axis=0), np.diff(self.scaled, axis=0)
        differ, off = (float(np.median(np.abs(each).max(axis=1))) for each in (wanted, came - wanted))
        return off <= TRUTH_ATOL < differ


_NOTHING = np.full((1, 3), np.nan)
UNSEEDED = Twins(_NOTHING, _NOTHING, _NOTHING, _NOTHING, _NOTHING[0], 1.0)
"""Twins of which nothing is known."""
