"""Submitted files as escaped, syntax-coloured lines for pages, within bounds on lines, characters and picture size."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape
from pygments.lexers.python import PythonLexer
from pygments.token import STANDARD_TYPES, Token, _TokenType

from grader.base.text import printable
from grader.course.record.submission_archive import PNG, Kept, source, unshowable
from grader.engine.results import CheckResult

MOST_LINES = 1500
LONGEST_LINE = 500
_COLOURED = 100_000
"""Longest file, in characters, that is syntax-coloured; a longer one is shown plain."""
_SHOWN = 300_000
_TEXTS = (".py", ".ipynb", ".txt", ".md", ".csv", ".json", ".yaml", ".yml", ".toml", ".cfg", ".ini", ".xml")


@dataclass(frozen=True)
class Line:
    """One line of submitted code on a page; `named` lines stand out, as feedback names them or another submission shares them."""

    number: int
    text: Markup
    named: bool = False


@dataclass(frozen=True)
class Listing:
    """One submitted file on a page: its lines, `anchor` for links, `size` in bytes, and how many `more` lines are not shown."""

    path: str
    anchor: str
    lines: tuple[Line, ...]
    more: int = 0
    size: int = 0


@dataclass(frozen=True)
class Picture:
    """A submitted picture on a page; `place` is its index among the files, `why` the reason if it is not shown, else ""."""

    path: str
    place: int
    why: str = ""


@dataclass(frozen=True)
class SubmittedFiles:
    """Submitted files: texts, PNGs, name and size of `others` (of other kinds or not stored), and how many `more` are unlisted."""

    listings: tuple[Listing, ...]
    pictures: tuple[Picture, ...]
    others: tuple[tuple[str, str], ...]
    more: int

    def anchor(self, path: str) -> str:
        return next((each.anchor for each in self.listings if each.path == path), "")


def submitted_files(kept: Kept, named: Mapping[str, set[int]]) -> SubmittedFiles:
    """Prepare the stored files of a submission to show on its page; `named` holds the lines that checks name, by file."""
    paths = list(kept.files)
    texts = [path for path in paths if path.lower().endswith(_TEXTS)]
    pictures = [path for path in paths if kept.files[path].startswith(PNG)]
    rest = {path: len(kept.files[path]) for path in paths if path not in texts and path not in pictures}
    return SubmittedFiles(
        tuple(_listing(f"file-{paths.index(path)}", path, kept.files[path], named.get(path, set())) for path in texts),
        tuple(Picture(printable(path), paths.index(path), unshowable(kept.files[path])) for path in pictures),
        tuple((printable(path), f"{size:,} bytes") for path, size in {**rest, **kept.others}.items()),
        kept.more,
    )


def named_lines(checks: Iterable[CheckResult], paths: Iterable[str]) -> dict[str, set[int]]:
    """Return the lines that the feedback of checks names, by file, to mark them; an empty set for a file without such a line."""
    named = [check.where for check in checks if check.where is not None]
    return {path: {each.line for each in named if each.file == path and each.line is not None} for path in paths}


def defined(kept: Kept, names: Sequence[str]) -> Iterator[tuple[str, int]]:
    """Yield file and line, from 1, of each function or class in the stored files `kept` that has one of `names`, to link to it."""
    if not names:
        return
    wanted = re.compile(rf"^[ \t]*(?:async )?(?:def|class)[ \t]+(?:{'|'.join(map(re.escape, names))})\b", re.MULTILINE)
    for path, content in kept.files.items():
        if path.lower().endswith((".py", ".ipynb")):
            text = source(path, content)
            yield from ((path, text.count("\n", 0, found.start()) + 1) for found in wanted.finditer(text))


def _listing(anchor: str, path: str, content: bytes, named: set[int]) -> Listing:
    whole = source(path, content)
    lines = coloured(path, whole)
    shown = tuple(Line(number, text, number in named) for number, text in enumerate(lines[:MOST_LINES], 1))
    return Listing(path, anchor, shown, max(0, whole.count("\n") + 1 - len(shown)), len(content))


def coloured(path: str, text: str) -> list[Markup]:
    """Return the first `MOST_LINES` + 1 lines of `text`, the file `path`, as escaped HTML; a `Listing` shows one line fewer.

    Only the first `_SHOWN` characters are read, and lines are cut to `LONGEST_LINE`. Python and notebooks get syntax colours,
    unless what is left is longer than `_COLOURED` characters; other files are plain.
    """
    text = "\n".join(
        printable(line, LONGEST_LINE, newlines=True) for line in text[:_SHOWN].split("\n")[: MOST_LINES + 1]
    )
    if not path.lower().endswith((".py", ".ipynb")) or len(text) > _COLOURED:
        return [escape(line) for line in text.split("\n")]
    lines = [Markup()]
    for kind, value in PythonLexer(stripnl=False, ensurenl=False).get_tokens(text):
        first, *others = value.split("\n")
        lines[-1] += _span(kind, first)
        lines += [_span(kind, other) for other in others]
    return lines


def _span(kind: _TokenType, text: str) -> Markup:
    """Return a token of code as escaped HTML, in a span with Pygments' class if its kind has a colour."""
    while kind not in STANDARD_TYPES:
        kind = kind.parent or Token
    name = STANDARD_TYPES[kind]
    return Markup('<span class="{}">{}</span>').format(name, text) if name and text.strip() else escape(text)
