"""Two faults at once: no points come back, nothing is lost elsewhere, and no name belongs to neither.

The pairs are made of the corpus' own faults: two patches of one file of the sheet's solution that do not touch the same lines.
`-m full` tries every `_EVERY`th of them, `-m weekly` all.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

import pytest

from tests.corpus.cases import CRITERIA, patched
from tests.corpus.pieces import read, verbatim
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

Fault = tuple[str, str, str]
"""The name of a row of the corpus, the file that it patches, and the patch."""
_EVERY = 600
ONLY_FOR_THE_OWN = ("record-and-plot", "filter-kept-beside-the-measurement")
"""Plots and scripts that fit one form only, in which the submission's own recorder or filter returns its numbers. They may lose points
of *Visualization* beside a recorder that raises, ends early or returns numbers that cannot be told apart, or beside a faulty filter: no
sound part returns that form, so that nothing is left to try them with. A note asks a person to give the points."""
OTHER_NAMES = {
    "index-out-of-bounds", "raises", "nothing-simulated", "not-gaussian", "bias-not-random", "first-output-missing",
}  # fmt: skip
"""Faults that two others together amount to: two components of three cannot be put in another order, for example."""


def faults(criterion: str) -> Iterator[Fault]:
    """Yield the faults of a criterion that patch one file of the sheet's solution."""
    rows = read(criterion)
    for name, row in {**rows.get("faulty", {}), **rows.get("lookalikes", {})}.items():
        files = [path for path in row if path.endswith(".py")]
        if row.get("base") == "verbatim" and len(files) == 1 and "append" not in row and "files" not in row:
            yield name, files[0], row[files[0]]


def together(*chosen: Fault) -> dict[str, str] | None:
    """Return the solution with these faults; None if one patch takes the lines of another, or if no program comes of both."""
    files = verbatim()
    try:
        for _, path, patch in chosen:
            files[path] = patched(files[path], patch)
        ast.parse(files[path])
    except (SyntaxError, ValueError):
        return None
    return files


def pairs(every: int = 1) -> Iterator[tuple[Fault, Fault]]:
    """Yield the pairs, or one of so many, that make a program in both orders."""
    both = (pair for criterion in CRITERIA for pair in itertools.combinations(faults(criterion), 2))
    for pair in itertools.islice(both, 0, None, every):
        if together(*pair) is not None and together(*pair[::-1]) is not None:
            yield pair


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make all pairs for the weekly run alone: to put them together takes each test worker seconds."""
    every = 1 if metafunc.config.option.markexpr == "weekly" else _EVERY
    marks = [pytest.mark.weekly] if every == 1 else []
    rows = [pytest.param(*pair, marks=marks, id=f"{pair[0][0]} and {pair[1][0]}") for pair in pairs(every)]
    metafunc.parametrize(("first", "second"), rows)


def test_a_second_fault_gives_nothing_back_and_costs_nothing_elsewhere(
    first: Fault, second: Fault, player: Marking
) -> None:
    alone = [marked(player, together(each) or {}) for each in (first, second)]
    both = marked(player, together(first, second) or {})
    lost, costs = lost_by(both), [lost_by(each) for each in alone]
    assert sum(lost.values()) >= max(sum(each.values()) for each in costs) - 0.01
    elsewhere = {id_.partition(".")[0] for id_ in lost} - {id_.partition(".")[0] for each in costs for id_ in each}
    if any(each[0].startswith(ONLY_FOR_THE_OWN) for each in (first, second)):
        assert elsewhere <= {"visualization"}
    else:
        assert elsewhere == set()
        known = {name for each in alone for name in each.misconceptions}
        assert set(both.misconceptions) - OTHER_NAMES <= known
