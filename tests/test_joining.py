"""Pieces of one look are one curve; single marks and whole curves stay what they are."""

from __future__ import annotations

import numpy as np

from grader.worker.joining import MAX_PIECE, MIN_PIECES, end_to_end, is_chain, joined


def groups(*artists: tuple[str, int]) -> list[list[tuple[str, int]]]:
    return joined(artists, lambda artist: artist[1], lambda artist: artist[0])


def test_many_pieces_of_one_look_are_one_group_in_the_place_of_the_first() -> None:
    red, blue, curve = ("red", 1), ("blue", 2), ("red", 500)
    drawn = [curve, *[red, blue] * MIN_PIECES]
    assert groups(*drawn) == [[curve], [red] * MIN_PIECES, [blue] * MIN_PIECES]


def test_few_marks_and_curves_of_one_look_are_left_apart() -> None:
    mark, curve = ("red", MAX_PIECE), ("red", MAX_PIECE + 1)
    drawn = [*[mark] * (MIN_PIECES - 1), *[curve] * MIN_PIECES]
    assert groups(*drawn) == [[each] for each in drawn]


def test_segments_are_concatenated_without_their_common_points() -> None:
    points = np.array([[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]])
    np.testing.assert_array_equal(end_to_end([points[:2], points[1:]]), points)


def test_only_segments_that_continue_each_other_are_a_chain() -> None:
    points = np.column_stack([np.arange(20.0), np.sin(np.arange(20.0))])
    chain = [points[i : i + 2] for i in range(19)]
    assert is_chain(chain)
    assert not is_chain(chain[: MIN_PIECES - 1])
    assert not is_chain(chain[::2])
