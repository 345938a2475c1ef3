"""A break point that was left in is told by its name, its file and its line."""

from __future__ import annotations

import pytest

from grader.engine.breakpoints import breakpoints
from tests.corpus.pieces import tidy
from tests.recordings import Marking
from tests.single_faults import changed, marked


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("x = 1\nbreakpoint()\n", [("breakpoint", 2)]),
        ("import pdb; pdb.set_trace()\n", [("pdb.set_trace", 1)]),
        ("from ipdb import set_trace\nset_trace ( )\n", [("set_trace", 2)]),
        ("# breakpoint()\n'''\nbreakpoint()\n'''\nprint(\"breakpoint()\")\n", []),
        ("my_breakpoint()\nself.breakpoints()\n", []),
        ("s = 'never closed\nbreakpoint()\n", [("breakpoint", 2)]),
        ("\udcff".encode("utf-8", "surrogateescape").decode("latin-1") + "\nbreakpoint()", [("breakpoint", 2)]),
    ],
)
def test_calls_are_found_where_they_stand_and_not_in_comments_or_strings(
    source: str, found: list[tuple[str, int]]
) -> None:
    assert list(breakpoints(source.encode())) == found


def test_a_flood_is_looked_at_in_no_time() -> None:
    assert list(breakpoints(b"'" * 1_000_000)) == []
    assert list(breakpoints(b"a." * 200_000)) == []


def test_a_check_that_passes_over_one_says_so_and_takes_nothing_for_it(player: Marking) -> None:
    head = "def update(self, measurement):"
    files = changed({"filters.py": tidy()["filters.py"]}, "filters.py", {head: f"{head}\n        breakpoint()"})
    result = marked(player, files, "filtering")
    line = str(files["filters.py"]).splitlines().index("        breakpoint()") + 1
    assert result.score == 20.0
    assert result.notes[-1] == (
        f"filters.py, line {line}: breakpoint() was skipped: nobody can type during grading. A program from `imugrade repro` stops there"
    )
