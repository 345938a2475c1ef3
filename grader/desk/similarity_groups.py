"""Groups in which everybody's code is alike with everybody else's, in place of their pairs: twelve copies are one line, not 66."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from grader.report.similarity import Pair


@dataclass(frozen=True)
class Clique:
    """`share` and `lines` are the least and the most that two of them have in common."""

    ids: tuple[str, ...]
    share: tuple[float, float]
    lines: tuple[int, int]


def cliques(pairs: Sequence[Pair]) -> Iterator[Clique]:
    """Groups that hold every pair once, the largest first; which of several equally good ones is told by the order of the pairs."""
    by_ids = {frozenset((pair.first, pair.second)): pair for pair in pairs}
    near: dict[str, set[str]] = {}
    for pair in pairs:
        near.setdefault(pair.first, set()).add(pair.second)
        near.setdefault(pair.second, set()).add(pair.first)
    left = dict.fromkeys(by_ids)
    found = []
    while left:
        ids = _grown(sorted(next(iter(left))), near)
        together = [key for key in _pairs_of(ids) if key in by_ids]
        for key in together:
            left.pop(key, None)
        found.append(_clique(ids, [by_ids[key] for key in together]))
    yield from sorted(found, key=lambda clique: (-len(clique.ids), -clique.share[1], clique.ids))


def _grown(ids: list[str], near: dict[str, set[str]]) -> list[str]:
    """Everybody who is alike with all of them, one after the other."""
    candidates = set.intersection(*(near[id_] for id_ in ids))
    while candidates:
        joins = min(candidates, key=lambda id_: (-len(near[id_] & candidates), id_))
        ids = [*ids, joins]
        candidates &= near[joins]
    return sorted(ids)


def _pairs_of(ids: Sequence[str]) -> Iterable[frozenset[str]]:
    return (frozenset((one, other)) for k, one in enumerate(ids) for other in ids[k + 1 :])


def _clique(ids: Sequence[str], pairs: Sequence[Pair]) -> Clique:
    shares, lines = [pair.share for pair in pairs], [pair.lines for pair in pairs]
    return Clique(tuple(ids), (min(shares), max(shares)), (min(lines), max(lines)))
