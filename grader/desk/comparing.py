"""Pages on similar code: the list of groups, and the shared lines of two submissions side by side."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from starlette.responses import Response

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.record.submission_archive import source
from grader.course.regrading.groups import similar_group
from grader.course.run.warnings import equal
from grader.desk.classbook import Classbook
from grader.desk.code import Line, coloured
from grader.desk.overviews import framed
from grader.desk.review_queue import address
from grader.desk.web_requests import WebRequest
from grader.engine.fingerprint import lines_with

_AROUND = 2  # context lines above and below shared lines
_MOST_FILES = 20


@dataclass(frozen=True)
class Piece:
    """Lines of one file to show together: shared lines and two lines around them, after `skipped` lines that are left out."""

    skipped: int
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Excerpt:
    """The part of one file that another submission shares, for a page: `count` of the file's `of` lines are shared."""

    path: str
    pieces: tuple[Piece, ...]
    count: int
    of: int


def show_all(book: Classbook, web_request: WebRequest) -> Response:
    return framed(
        book, web_request, "similar.html.j2", similar=book.similar(), together=lambda ids: address(similar_group(ids))
    )


def show(book: Classbook, web_request: WebRequest) -> Response:
    """Return the page with the shared lines of two submissions side by side; RequestError if a submission does not exist."""
    final_grades = book.final_grades()
    two = [final_grades.get(web_request.path[place]) for place in ("first", "second")]
    first, second = two
    if first is None or second is None or first is second:
        raise RequestError("This pair does not exist")
    shared = book.shared(first.id, second.id)
    pair = next((each for each in book.similar().pairs if {each.first, each.second} == {first.id, second.id}), None)
    kept = [book.kept(each).files for each in (first, second)]
    sides = [(each, excerpts(files, shared)) for each, files in zip((first, second), kept, strict=True)]
    same = any(equal((first, second)))
    return framed(book, web_request, "pair.html.j2", sides=sides, pair=pair, same=same)


def excerpts(files: Mapping[str, bytes], shared: Set[int]) -> list[Excerpt]:
    """Return one excerpt for each file with lines whose hash of code is in `shared`, for the 20 files with most such lines."""
    found = []
    for path, content in files.items():
        if path.lower().endswith((".py", ".ipynb")):
            text = source(path, content)
            lines = lines_with(text, shared)
            if lines:
                found.append(_excerpt(path, text, lines))
    return sorted(found, key=lambda each: -each.count)[:_MOST_FILES]


def _excerpt(path: str, text: str, shared: Set[int]) -> Excerpt:
    """Return the lines numbered in `shared` with two lines around each, grouped into pieces."""
    rows = coloured(path, text)
    wanted = sorted(
        {near for line in shared for near in range(line - _AROUND, line + _AROUND + 1) if 1 <= near <= len(rows)}
    )
    pieces: list[Piece] = []
    for number in wanted:
        line = Line(number, rows[number - 1], number in shared)
        last = pieces[-1].lines[-1].number if pieces else 0
        if pieces and last == number - 1:
            pieces[-1] = Piece(pieces[-1].skipped, (*pieces[-1].lines, line))
        else:
            pieces.append(Piece(number - last - 1, (line,)))
    return Excerpt(printable(path), tuple(pieces), len(shared), text.count("\n") + 1)
