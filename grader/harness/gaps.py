"""A file that Python refuses for a slip of the pen: the statements that can be read, and gaps in place of the lines that cannot.

Python runs nothing of such a file, and whoever mends the slip has all of it. So a slip costs one of the names that are asked for:
the one whose definition it stands in, else the one defined above it, to which it mostly belongs, else the next below. Several
slips beside the definitions cost one of them together: an unfinished merge leaves three. All else that the file defines is there.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Collection, Iterator, Sequence
from typing import TypeAlias

from . import stepping

_Definition: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
_MOST = 4  # slips; a merge that was not finished leaves three lines
_LONGEST = 400_000  # characters of a file that is read again and again
_BEGINS = re.compile(r"(?!(?:else|elif|except|finally)\b)[^\s#)\]}]")
_DEFINES = re.compile(r"^(?:async[ \t]+)?(?:def|class)[ \t]+(\w+)", re.MULTILINE)


def units_around(
    text: str, name: str, wanted: Collection[str], refused: SyntaxError, *, flags: int = 0
) -> list[stepping.Unit]:
    """The statements of a file that Python has refused, with a gap for each slip.

    Raises
    ------
    SyntaxError
        What Python said of the whole, where it is more than a few slips, or more than a slip in what has to run as a whole.
    """
    tree, slips = _around_slips(text, name, refused, flags)
    lines = text.split("\n")
    lost = [_wanted_in("\n".join(lines[rows.start : rows.stop]), wanted) for rows, _ in slips]
    beside = next((n for n, names in enumerate(lost) if not names), None)
    for n, (rows, error) in enumerate(slips):
        _leave_a_gap(tree, rows, error, lost[n], wanted if n == beside else ())
    return stepping.units_of(tree, name, flags=flags)


def names_in(text: str) -> list[str]:
    """What a text that Python refuses would define at its top level, by the beginnings of its lines."""
    return _DEFINES.findall(text)


def belongs_to(tree: ast.Module, line: int, wanted: Collection[str]) -> str:
    """The definition that a slip in this line is told of: where it stands in none, the one above, else below; empty if none is."""
    nearest = _nearest([node for node in tree.body if isinstance(node, stepping.DEFINITIONS)], line, wanted)
    return nearest.name if nearest else ""


def _nearest(definitions: Sequence[_Definition], line: int, wanted: Collection[str]) -> _Definition | None:
    """The last one that begins before a line, else the first."""
    known = [node for node in definitions if node.name in wanted]
    return max(
        (node for node in known if node.lineno <= line), key=lambda node: node.lineno, default=next(iter(known), None)
    )


def _around_slips(
    text: str, name: str, refused: SyntaxError, flags: int = 0
) -> tuple[ast.Module, list[tuple[range, SyntaxError]]]:
    """The file without the lines (as counted from 0) that Python refuses, and what it says of each such place."""
    slips: list[tuple[range, SyntaxError]] = []
    lines, problem = text.split("\n"), refused
    while len(text) <= _LONGEST and len(slips) < _MOST:
        for rows in _suspects(lines, problem):
            rest = [*lines[: rows.start], *("" for _ in rows), *lines[rows.stop :]]
            tree, left = _read("\n".join(rest), name, flags)
            if left is None or (left.lineno or 0) - 1 not in range(rows.start, rows.stop + 1):
                break
        else:
            break
        slips.append((rows, problem))
        if left is None:
            return tree, slips
        lines, problem = rest, left
    raise refused


def _suspects(lines: Sequence[str], problem: SyntaxError) -> Iterator[range]:
    """What may have to go so that the rest can be read: the statement that Python names, or the one before, if it lacks a part."""
    starts = [0, *(n for n, line in enumerate(lines) if n and _BEGINS.match(line) and not lines[n - 1].startswith("@"))]
    statements = [range(*each) for each in itertools.pairwise([*starts, len(lines)])]
    at = next((n for n, rows in enumerate(statements) if (problem.lineno or 0) - 1 in rows), len(statements) - 1)
    before = statements[max(0, at - 1)]
    lacks_its_block = isinstance(problem, IndentationError) and "expected an indented block" in str(problem.msg)
    yield from (before, statements[at]) if lacks_its_block else (statements[at], before)


def _read(text: str, name: str, flags: int) -> tuple[ast.Module, SyntaxError | None]:
    try:
        tree = ast.parse(text, name)
        stepping.units_of(tree, name, flags=flags)
    except SyntaxError as refused:
        return ast.Module([], []), refused
    return tree, None


def _wanted_in(lines: str, wanted: Collection[str]) -> list[str]:
    return [name for name in names_in(lines) if name in wanted]


def _leave_a_gap(tree: ast.Module, rows: range, error: SyntaxError, lost: Sequence[str], cost: Collection[str]) -> None:
    """Put a gap where the lines stood; or, where they cost one of these definitions, in its place."""
    line = rows.start + 1
    nearest = _nearest([node for node in tree.body if isinstance(node, stepping.DEFINITIONS)], line, cost)
    if nearest:
        lost, line = [nearest.name], nearest.lineno
        tree.body.remove(nearest)
    at = next((n for n, node in enumerate(tree.body) if node.lineno > line), len(tree.body))
    tree.body.insert(at, stepping.Gap.of(lost, error))
