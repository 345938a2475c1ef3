"""A slip of the pen for which Python refuses a file, where it says what it expected: that is put there, and told as one fault.

A colon, a bracket or a quote that is missing, one that is too many, `=` where a comparison stands, a line that is not as far in as
the one before, quotes and dashes that a word processor has set. What is put there is kept only if Python reads the whole file then.
"""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

_MOST = 4  # slips of a file
_READ = 3_000_000  # characters in all, of a file that is read again and again: some seconds
_CLOSES = {"(": ")", "[": "]", "{": "}"}
_SET = str.maketrans("“”„‟″‘’‚‛′–—−，；：（）［］｛｝＝＋　\xa0", "\"\"\"\"\"'''''---,;:()[]{}=+  ")
"""Characters that look like those of a program, from books and other keyboards."""
_EQUALS = re.compile(r"(?<![=<>!:+\-*/%@&|^~])=(?!=)")
_NEXT_LINES = 30  # in which a bracket may be closed
_STEP, _DEPTHS = 4, 6  # columns that a block is further in; how many places a line is tried at
_Change: TypeAlias = tuple[int, str]
"""A line, as counted from 0, and how it may read."""


def completed(text: str, refused: SyntaxError, read: Callable[[str], None]) -> tuple[str, list[SyntaxError]] | None:
    """The text with what Python expected, and what it said of each place; None where that does not make it Python.

    Parameters
    ----------
    read : raises SyntaxError for what is no Python
    """
    said: list[SyntaxError] = []
    left_to_read = _READ
    while len(said) < _MOST:
        said.append(refused)
        further = None
        for tried in _tries(text, refused):
            left_to_read -= len(tried)
            if left_to_read < 0:
                return None
            left = _refused(tried, read)
            if left is None:
                return tried, said
            if further is None and left.lineno != refused.lineno:
                further = tried, left
        if further is None:
            return None
        text, refused = further
    return None


def _refused(text: str, read: Callable[[str], None]) -> SyntaxError | None:
    try:
        read(text)
    except SyntaxError as refused:
        return refused
    return None


@dataclass(frozen=True)
class _Place:
    """Where Python refuses a text, as counted from 0, what it marks there, and what it says."""

    said: str
    lines: Sequence[str]
    row: int
    column: int
    end: int

    @classmethod
    def of(cls, text: str, refused: SyntaxError) -> _Place:
        lines = text.split("\n")
        row = min(max((refused.lineno or 1) - 1, 0), len(lines) - 1)
        ends_there = refused.end_lineno == refused.lineno and (refused.end_offset or 0) > 0
        end = (refused.end_offset or 0) - 1 if ends_there else len(lines[row])
        return cls(str(refused.msg), lines, row, max((refused.offset or 1) - 1, 0), end)

    @property
    def line(self) -> str:
        return self.lines[self.row]


def _tries(text: str, refused: SyntaxError) -> Iterator[str]:
    """The text with one thing put right, the likeliest first."""
    if _CONFLICT.search(text):
        yield _one_side(text)
    place = _Place.of(text, refused)
    for expected, changes in _EXPECTED:
        if expected.search(place.said):
            for row, line in changes(place):
                yield "\n".join([*place.lines[:row], line, *place.lines[row + 1 :]])
    if isinstance(refused, TabError):
        yield from (text.expandtabs(4), text.expandtabs(8))


_CONFLICT = re.compile(r"^(?:<{7}|>{7})(?: |$)", re.MULTILINE)


def _one_side(text: str) -> str:
    """What a merge left on its first side, of each place where it was not finished; blank lines where the other one stood."""
    lines, side = [], "both"
    for line in text.split("\n"):
        mark = line[:7]
        side = {"<<<<<<<": "one", ">>>>>>>": "after"}.get(mark, side)
        if mark in ("=======", "|||||||") and side == "one":
            side = "other"
        lines.append(line if side == "both" or (side == "one" and mark != "<<<<<<<") else "")
        side = "both" if side == "after" else side
    return "\n".join(lines)


def _as_typed(place: _Place) -> Iterator[_Change]:
    if place.line.translate(_SET) != place.line:
        yield place.row, place.line.translate(_SET)


def _colon(place: _Place) -> Iterator[_Change]:
    yield from ((place.row, _put(place.line, at, ":")) for at in (place.column, _end_of_code(place.line)))


def _comparison(place: _Place) -> Iterator[_Change]:
    for each in _EQUALS.finditer(place.line, place.column):
        before, after = place.line[: each.start()], place.line[each.end() :]
        yield place.row, before + ("is" if after.lstrip().startswith("None") else "==") + after


def _quote(place: _Place) -> Iterator[_Change]:
    """Where the string may end: before what closes what was opened, or with the line."""
    first, last = len(place.line.rstrip(" )]}:,;")), len(place.line.rstrip())
    ends = [at for at in range(first, last + 1) if at > place.column]
    yield from ((place.row, _put(place.line, at, place.line[place.column])) for at in ends)


def _another_bracket(place: _Place) -> Iterator[_Change]:
    before, after = place.line[: place.column], place.line[place.column + 1 :]
    yield from ((place.row, before + other + after) for other in ("", *_CLOSES.values()))


def _comma_within(place: _Place) -> Iterator[_Change]:
    gaps = [each.start() for each in re.finditer(r"(?<=[^\s,]) +", place.line[: place.end])]
    yield from ((place.row, _put(place.line, at, ",")) for at in gaps if at > place.column)


def _comma_before(place: _Place) -> Iterator[_Change]:
    yield place.row, _put(place.line, len(place.line[: place.column].rstrip()), ",")
    if place.row:
        before = place.lines[place.row - 1]
        yield place.row - 1, _put(before, _end_of_code(before), ",")


def _call_of_print(place: _Place) -> Iterator[_Change]:
    yield place.row, re.sub(r"\bprint +(.*?) *$", r"print(\1)", place.line)


def _words_of_other_languages(place: _Place) -> Iterator[_Change]:
    for written, meant in ((r"\belse +if\b", "elif"), (r"(\w)(\+|-)\2\s*$", r"\1 \2= 1")):
        if re.search(written, place.line):
            yield place.row, re.sub(written, meant, place.line)


def _depth(place: _Place) -> Iterator[_Change]:
    """As far in as a line above is, or a step more than that; the least change first."""
    own = len(place.line) - len(place.line.lstrip())
    above = {len(line) - len(line.lstrip()) for line in place.lines[: place.row] if line.strip()}
    depths = above.union(depth + _STEP for depth in above) - {own}
    nearest = sorted(depths, key=lambda depth: (abs(depth - own), -depth))[:_DEPTHS]
    yield from ((place.row, " " * depth + place.line.lstrip()) for depth in nearest)


def _block(place: _Place) -> Iterator[_Change]:
    """Nothing to do, where nothing stands below a colon."""
    for row in (int(number) - 1 for number in re.findall(r"on line (\d+)$", place.said)):
        yield row, _put(place.lines[row], _end_of_code(place.lines[row]), " pass")


def _closing(place: _Place) -> Iterator[_Change]:
    """A bracket at the end of its line or of one of the next, or before the colon there."""
    for at, bracket in _never_closed("\n".join(place.lines)):
        for row in range(at, min(at + _NEXT_LINES, len(place.lines))):
            line = place.lines[row]
            yield row, _put(line, _end_of_code(line), _CLOSES[bracket])
            if line.rstrip().endswith(":"):
                yield row, _put(line, len(line.rstrip()) - 1, _CLOSES[bracket])


_EXPECTED: Sequence[tuple[re.Pattern[str], Callable[[_Place], Iterator[_Change]]]] = [
    (re.compile(pattern), changes)
    for pattern, changes in (
        ("", _as_typed),
        ("expected ':'", _colon),
        ("instead of '='", _comparison),
        ("^unterminated string literal", _quote),
        ("^unmatched|^closing parenthesis", _another_bracket),
        ("forgot a comma", _comma_within),
        ("^Missing parentheses in call to 'print'", _call_of_print),
        ("", _words_of_other_languages),
        ("^invalid syntax$", _comma_before),
        ("^unindent|^unexpected indent|outside function", _depth),
        ("^expected an indented block", _block),
        ("", _closing),
    )
]
"""What Python says, and what it may miss then."""


def _put(line: str, at: int, what: str) -> str:
    return line[:at] + what + line[at:]


def _end_of_code(line: str) -> int:
    """Where a comment begins, or the line ends."""
    code = line
    with suppress(tokenize.TokenError, SyntaxError):
        for token in tokenize.generate_tokens(io.StringIO(line.strip() + "\n").readline):
            if token.type == tokenize.COMMENT:
                code = line[: len(line) - len(line.lstrip()) + token.start[1]]
    return len(code.rstrip())


def _never_closed(text: str) -> list[tuple[int, str]]:
    """The brackets that have no end, the innermost first: row and bracket."""
    opened: list[tuple[int, str]] = []
    with suppress(tokenize.TokenError, SyntaxError):
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.OP and token.string in _CLOSES:
                opened.append((token.start[0] - 1, token.string))
            elif token.type == tokenize.OP and token.string in _CLOSES.values() and opened:
                opened.pop()
    return opened[::-1][:2]
