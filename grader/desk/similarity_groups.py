"""Groups of mutually similar submissions, so that twelve copies are one item for a person, not 66 pairs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.report.similarity import Pair


@dataclass(frozen=True)
class SimilarityGroup:
    """Submissions all similar to each other. `share` and `lines` of common code are each (least, most) over all pairs."""

    ids: tuple[str, ...]
    share: tuple[float, float]
    lines: tuple[int, int]


def similarity_groups(pairs: Sequence[Pair]) -> Iterator[SimilarityGroup]:
    """Yield groups of submissions all similar to each other, largest first; each pair in `pairs` is in at least one group."""
    by_ids = {frozenset((pair.first, pair.second)): pair for pair in pairs}
    near: dict[str, set[str]] = {}
    for pair in pairs:
        near.setdefault(pair.first, set()).add(pair.second)
        near.setdefault(pair.second, set()).add(pair.first)
    left = dict.fromkeys(by_ids)
    found = []
    while left:
        ids = _extended(sorted(next(iter(left))), near)
        together = [key for key in _pairs_of(ids) if key in by_ids]
        for key in together:
            left.pop(key, None)
        found.append(_group(ids, [by_ids[key] for key in together]))
    yield from sorted(found, key=lambda group: (-len(group.ids), -group.share[1], group.ids))


def _extended(ids: list[str], near: dict[str, set[str]]) -> list[str]:
    """Extend a pair, one at a time, by submissions similar to all members; `near` holds for each submission those similar to it."""
    candidates = set.intersection(*(near[id_] for id_ in ids))
    while candidates:
        joins = min(candidates, key=lambda id_: (-len(near[id_] & candidates), id_))
        ids = [*ids, joins]
        candidates &= near[joins]
    return sorted(ids)


def _pairs_of(ids: Sequence[str]) -> Iterable[frozenset[str]]:
    return (frozenset((one, other)) for k, one in enumerate(ids) for other in ids[k + 1 :])


def _group(ids: Sequence[str], pairs: Sequence[Pair]) -> SimilarityGroup:
    shares, lines = [pair.share for pair in pairs], [pair.lines for pair in pairs]
    return SimilarityGroup(tuple(ids), (min(shares), max(shares)), (min(lines), max(lines)))
