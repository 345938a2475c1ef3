"""Code similarity between submissions, beyond the code that the lab hands out. A reason to review, not a verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from grader.engine.fingerprint import WINDOW

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FEWEST = 20
"""Fewest shared hashes of a similar pair: about 15 lines, as one hash stands for about seven tokens."""
_SHARE = 0.5
"""Least share of the smaller submission's own hashes that a similar pair has in common."""
_COMMON = 0.5
"""A hash in more than this share of the class is taken for handed-out code."""
_CLASS = 6
"""In a small class, a hash must be in more than this many submissions for that."""
_MOST = 50
_TOKENS_A_LINE = 9
_BLOCK = 256
"""Submissions compared with the class at a time, so that memory grows with the class and not with its square."""


@dataclass(frozen=True)
class Pair:
    """Two submissions with similar code: how many hashes both have, and their share of the smaller submission's own hashes.

    A hash stands for a run of tokens (see `fingerprint`); own hashes are those that most of the class does not have.
    """

    first: str
    second: str
    common: int
    share: float

    @property
    def lines(self) -> int:
        """Return the estimated number of shared lines of code: a hash every 6.5 tokens, nine tokens per line."""
        return round(self.common * (WINDOW + 1) / 2 / _TOKENS_A_LINE)


def pairs(
    fingerprints: Mapping[str, tuple[int, ...]], given: frozenset[int] = frozenset(), most: int = _MOST
) -> list[Pair]:
    """Return the pairs that share at least 20 hashes and half of the smaller submission's own hashes, largest share first.

    Parameters
    ----------
    fingerprints : id of the submission -> hashes of its code
    given : hashes of the lab's code, which is not a submission's own (see `own_hashes`)
    most : how many pairs to return at most
    """
    own = own_hashes(fingerprints, given)
    ids = sorted(id_ for id_, hashes in own.items() if len(hashes) >= FEWEST)
    if len(ids) < 2:
        return []
    holds, sizes = _holds(ids, own), np.array([len(own[id_]) for id_ in ids])
    found: list[Pair] = []
    for start in range(0, len(ids), _BLOCK):
        common = np.asarray((holds[start : start + _BLOCK] @ holds.T).toarray())
        share = common / np.minimum.outer(sizes[start : start + _BLOCK], sizes)
        rows, columns = np.nonzero(np.triu((common >= FEWEST) & (share >= _SHARE), start + 1))
        best = np.lexsort((columns, rows, -common[rows, columns], -share[rows, columns]))[:most]
        found += [
            Pair(ids[start + i], ids[j], int(common[i, j]), float(share[i, j]))
            for i, j in zip(rows[best], columns[best], strict=True)
        ]
        found = sorted(found, key=lambda pair: (-pair.share, -pair.common, pair.first, pair.second))[:most]
    return found


def own_hashes(fingerprints: Mapping[str, tuple[int, ...]], given: frozenset[int]) -> dict[str, frozenset[int]]:
    """Return each submission's hashes, by id, except those `given` by the lab or in over half of the class (and in at least 7)."""
    own = {id_: frozenset(hashes) - given for id_, hashes in fingerprints.items()}
    counts = Counter(value for hashes in own.values() for value in hashes)
    most = max(_CLASS, _COMMON * len(own))  # handed-out code that the grader does not know
    common = {value for value, count in counts.items() if count > most}
    return {id_: hashes - common for id_, hashes in own.items()}


def _holds(ids: list[str], own: Mapping[str, frozenset[int]]) -> csr_array:
    """Return which submission contains which hash as a sparse matrix, by which all pairs are counted at once."""
    from scipy.sparse import csr_array  # noqa: PLC0415 - slow to import, and pages of one submission do not need it

    place = {value: k for k, value in enumerate(sorted(frozenset().union(*(own[id_] for id_ in ids))))}
    columns = np.array([place[value] for id_ in ids for value in own[id_]])
    borders = np.cumsum([0, *(len(own[id_]) for id_ in ids)])
    return csr_array((np.ones(len(columns), dtype=np.int32), columns, borders), shape=(len(ids), len(place)))
