"""Join curves that were drawn piece by piece (a point or segment per call, or per shade), so that each is judged as one curve."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable
from typing import Any, TypeVar

import numpy as np

Artist = TypeVar("Artist")

MAX_PIECE = 3
"""Most points of a piece. A line of four points and more can be read as a curve of its own."""
MIN_PIECES = 8
"""Fewest pieces of one look that are taken as one curve: a plot has fewer marks (means, limits, events) of one look than that."""


def joined(
    artists: Iterable[Artist], size: Callable[[Artist], int], look: Callable[[Artist], Hashable]
) -> list[list[Artist]]:
    """Group artists that are pieces of one curve, such as its points; any other artist is a group of its own. Keep drawing order.

    Parameters
    ----------
    artists : the artists of one panel, in drawing order
    size : returns the number of points of an artist; only one with at most `MAX_PIECE` can be a piece
    look : returns what a reader sees of an artist (colour, style, marker); `MIN_PIECES` pieces of one look, or more, are one curve
    """
    artists = list(artists)
    pieces: dict[Hashable, list[Artist]] = {}
    for artist in artists:
        if size(artist) <= MAX_PIECE:
            pieces.setdefault(look(artist), []).append(artist)
    groups: list[list[Artist]] = []
    begun: set[Hashable] = set()
    for artist in artists:
        group = pieces.get(look(artist), []) if size(artist) <= MAX_PIECE else []
        if len(group) < MIN_PIECES:
            groups.append([artist])
        elif look(artist) not in begun:
            begun.add(look(artist))
            groups.append(group)
    return groups


def end_to_end(parts: Iterable[np.ndarray]) -> np.ndarray:
    """Concatenate the points (k, 2) of a curve's pieces; keep one of equal adjacent points, as where two pieces meet."""
    points = np.concatenate([np.asarray(part, dtype=float) for part in parts])
    repeated = np.zeros(len(points), dtype=bool)
    repeated[1:] = (points[1:] == points[:-1]).all(axis=1)
    return np.asarray(points[~repeated])


def is_chain(segments: list[Any]) -> bool:
    """Return whether eight or more segments (points (k, 2) each) lie end to end: one curve, cut up as for a colour gradient."""
    if len(segments) < MIN_PIECES or any(len(segment) < 2 for segment in segments):
        return False
    return all(np.array_equal(before[-1], after[0]) for before, after in itertools.pairwise(segments))
