"""Suggested repairs: edits of one place in code that does not run, each validated by grading the edited copy in the sandbox.

Candidates are read from the text of the failing line alone: a name that is nearly another one of the file, a missing ``self.`` or
``np.``, one token too many or too few, an indentation, a missing ``return``. No exception's wording is read. An edit is suggested
only where every edit that makes the file run leads to the same grade.
"""

from __future__ import annotations

import ast
import difflib
import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from grader.course.patches import diff_of
from grader.engine.lab import Lab
from grader.engine.results import CheckResult, Result
from grader.intake import Submission

Mark = Callable[[Submission], Result]
MOST = 30
"""Candidates of a submission that are graded; the sheet's code takes a third of a second."""
SECONDS = 20.0
"""Grading time of all candidates together."""
_LARGEST = 100_000  # bytes of a file that is parsed for each candidate
_MOST_PARSED = 1500
_STOPPED = frozenset(("error", "timeout", "crashed"))
_DOES_NOT_PARSE = "does-not-import"
_TOKEN = re.compile(r"\"[^\"\n]*\"?|'[^'\n]*'?|\w+|\s+|[^\w\s]")
_NAME = re.compile(r"(?<![\w'\"])[^\W\d]\w*")
_CLOSE = 0.7
"""Letters in common of a name and the one that is meant, as difflib counts: it does not run already."""
_INSERTED = (":", ")", "]", "}", ",", "(", "[", "'", '"', " in ", "=")
_TYPOGRAPHIC = str.maketrans("“”„‟″‘’‚‛′–—−，；：（）［］｛｝＝＋　\xa0", "\"\"\"\"\"'''''---,;:()[]{}=+  ")
_NUMPY = ("np.", "numpy.")
_WORDS = ("data", "model", "self", "range", "len", "print", "abs", "int", "float", "None", "True", "False")


@dataclass(frozen=True)
class Suggestion:
    """An edited file with its diff, the result of the submission with it, and how many other edits led to the same grade."""

    file: str
    content: bytes
    diff: str
    result: Result
    alike: int


@dataclass(frozen=True)
class _Place:
    """A line of a file, counted from 0, at which the submission stops; -1 where only the function is known."""

    file: str
    row: int
    name: str


def suggest(handed_in: Submission, graded: Result, lab: Lab, mark: Mark) -> Suggestion | None:
    """Return the repair of the most expensive place at which a submission stops; None where there is none, or several differ.

    Parameters
    ----------
    graded
        The result of the submission as it was handed in.
    mark
        Grades a submission in the sandbox.
    """
    for place in _places(graded, handed_in, lab):
        found = list(_validated(handed_in, graded, place, mark))
        if found and len({each.score for _, each in found}) == 1:
            content, result = found[0]
            diff = diff_of(place.file, handed_in.files[place.file], content)
            return Suggestion(place.file, content, diff, result, len(found) - 1)
    return None


def _validated(handed_in: Submission, graded: Result, place: _Place, mark: Mark) -> Iterator[tuple[bytes, Result]]:
    """Grade the candidates; yield those that earn more and with which nothing stops in the file any more."""
    spent = 0.0
    stopped = {(check.where.file, check.id) for check in _stopping(graded) if check.where}
    for content in itertools.islice(_candidates(handed_in.files[place.file], place), MOST):
        if spent >= SECONDS:
            return
        result = mark(replace(handed_in, files={**handed_in.files, place.file: content}))
        spent += result.duration_s
        still = {(check.where.file, check.id) for check in _stopping(result) if check.where}
        if result.score > graded.score and not any(file == place.file for file, _ in still) and still <= stopped:
            yield content, result


def _stopping(result: Result) -> list[CheckResult]:
    """The checks that failed because code does not run."""
    checks = (check for part in result.criteria for check in part.checks)
    return [check for check in checks if check.outcome in _STOPPED or _DOES_NOT_PARSE in check.misconceptions]


def _places(result: Result, handed_in: Submission, lab: Lab) -> list[_Place]:
    """Where the submission stops, the most expensive place first."""
    cost: dict[_Place, float] = {}
    for part in result.criteria:
        stopping = [check for check in part.checks if check in _stopping(result) or _returns_nothing(check)]
        for check in stopping[:1]:
            name = lab.name_of(check.id)
            where = check.where or _definition(name, handed_in)
            if where is not None and where.file in handed_in.files:
                place = _Place(where.file, (where.line or 0) - 1, name)
                cost[place] = cost.get(place, 0.0) + part.max_points - part.points
    return sorted(cost, key=lambda place: -cost[place])


def _returns_nothing(check: CheckResult) -> bool:
    return check.outcome == "failed" and "wrong-return-type" in check.misconceptions


@dataclass(frozen=True)
class _Defined:
    file: str
    line: int | None = None


def _definition(name: str, handed_in: Submission) -> _Defined | None:
    """The file that defines a name, where no line of it is known."""
    defines = re.compile(rf"^(?:class|def)[ \t]+{re.escape(name)}\b".encode(), re.MULTILINE)
    files = (path for path, content in handed_in.files.items() if path.endswith(".py") and defines.search(content))
    return next((_Defined(path) for path in files), None)


# --- candidates ----------------------------------------------------------------------------------------------------------


def _candidates(content: bytes, place: _Place) -> Iterator[bytes]:
    """Edited copies of a file that parse, the likeliest first, each with another meaning."""
    try:
        text = content.decode()
    except UnicodeDecodeError:
        return
    if len(content) > _LARGEST:
        return
    known = {_meaning(text)}
    lines = text.split("\n")
    edits = _of_a_line(lines, place) if None not in known else _of_syntax(lines, place.row)
    for edited in itertools.islice(edits, _MOST_PARSED):
        new = "\n".join(edited)
        meaning = _meaning(new)
        if meaning is not None and meaning not in known:
            known.add(meaning)
            yield new.encode()


def _meaning(text: str) -> str | None:
    """The program as Python reads it; None where it does not parse."""
    try:
        return ast.dump(ast.parse(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


_Lines = Sequence[str]


def _with(lines: _Lines, row: int, *new: str) -> list[str]:
    return [*lines[:row], *new, *lines[row + 1 :]]


def _of_syntax(lines: _Lines, row: int) -> Iterator[list[str]]:
    """One edit at the line that Python names, or one just above it."""
    if not 0 <= row < len(lines):
        return
    yield from _whole(lines)
    rows = [row, *(each for each in range(row - 1, max(-1, row - 4), -1) if lines[each].strip())]
    for each in rows:
        line = lines[each]
        if line.translate(_TYPOGRAPHIC) != line:
            yield _with(lines, each, line.translate(_TYPOGRAPHIC))
        yield from (_with(lines, each, new) for new in _other_languages(line))
        yield from (_with(lines, each, new) for new in _depths(lines, each))
    for each in rows:
        yield from (_with(lines, each, new) for new in _one_token(lines[each]))
    for each in rows:
        if lines[each].rstrip().endswith(":"):
            depth = len(lines[each]) - len(lines[each].lstrip()) + 4
            yield _with(lines, each, lines[each], " " * depth + "pass")


def _whole(lines: _Lines) -> Iterator[list[str]]:
    """Marks that a merge left, and tabulators."""
    if any(line.startswith(("<<<<<<<", ">>>>>>>")) for line in lines):
        ours, keep = [], True
        for line in lines:
            if line.startswith(("=======", "|||||||")):
                keep = False
            elif line.startswith((">>>>>>>", "<<<<<<<")):
                keep = True
            elif keep:
                ours.append(line)
        yield ours
        yield [line for line in lines if not line.startswith(("<<<<<<<", ">>>>>>>", "=======", "|||||||"))]
    if any("\t" in line for line in lines):
        yield from ([line.expandtabs(width) for line in lines] for width in (4, 8))


def _other_languages(line: str) -> Iterator[str]:
    yield from (
        new
        for new in (
            re.sub(r"\bprint +(?!\()(.*?)\s*$", r"print(\1)", line),
            re.sub(r"\belse +if\b", "elif", line),
            re.sub(r"(\w)(\+|-)\2\s*$", r"\1 \2= 1", line),
            re.sub(r"(?<![=<>!])=(?!=)(?=.*:\s*$)", "==", line),
            re.sub(r"(?<![=<>!])=\s*None\b", "is None", line),
        )
        if new != line
    )


def _depths(lines: _Lines, row: int) -> Iterator[str]:
    """The line as far in as another one near it, the nearest depth first."""
    line = lines[row]
    own = len(line) - len(line.lstrip())
    near = [each for each in lines[max(0, row - 30) : row + 5] if each.strip()]
    depths = {len(each) - len(each.lstrip()) for each in near}
    depths |= {depth + 4 for depth in depths}
    yield from (" " * depth + line.lstrip() for depth in sorted(depths - {own}, key=lambda depth: abs(depth - own))[:6])


def _one_token(line: str) -> Iterator[str]:
    """The line with one token more or less: at its end first, where it is mostly missing."""
    code = line.split("#", maxsplit=1)[0].rstrip()
    ends = [each.end() for each in _TOKEN.finditer(line) if each.end() <= len(code)]
    for at in sorted({len(code), *ends}, reverse=True):
        yield from (line[:at] + token + line[at:] for token in _INSERTED)
    for token in reversed(list(_TOKEN.finditer(line))):
        if not token[0].strip() or len(token[0]) == 1:
            yield line[: token.start()] + line[token.end() :]


def _of_a_line(lines: _Lines, place: _Place) -> Iterator[list[str]]:
    """One edit of the line at which a function stops; where no line is known, of the function itself."""
    text = "\n".join(lines)
    if place.row >= 0:
        line = lines[place.row]
        for new in _other_names(line, text, _parameters(lines, place.row)):
            yield _with(lines, place.row, new)
        for new in _asked_for_none(line):
            yield _with(lines, place.row, new)
    yield from _without_self(lines, place.name)
    yield from _with_return(lines, place.name)


def _other_names(line: str, text: str, parameters: Sequence[str]) -> Iterator[str]:
    """The line with a name of it exchanged: one of the file that is nearly that, one with ``self.`` or ``np.``, or a parameter."""
    known = {*_NAME.findall(text), *_WORDS}
    seldom = {name for name in known if len(re.findall(rf"\b{name}\b", text)) == 1}
    names = sorted(_NAME.finditer(line), key=lambda found: found[0] not in seldom)
    for found in names:
        near = difflib.get_close_matches(found[0], known - {found[0]}, 3, _CLOSE)
        yield from (line[: found.start()] + other + line[found.end() :] for other in near)
    for found in names:
        if line[: found.start()].endswith("."):
            continue
        if f"self.{found[0]}" in text:
            yield f"{line[: found.start()]}self.{line[found.start() :]}"
        yield from (f"{line[: found.start()]}{np}{line[found.start() :]}" for np in _NUMPY if np in text)
    for found in names:
        if found[0] in parameters:
            others = (each for each in parameters if each not in (found[0], "self"))
            yield from (line[: found.start()] + other + line[found.end() :] for other in others)


def _parameters(lines: _Lines, row: int) -> Sequence[str]:
    """The parameters of the function that a line stands in, as far as its text tells."""
    head = next((at for at in range(row, -1, -1) if re.match(r"\s*(?:async )?def ", lines[at])), None)
    if head is None:
        return ()
    signature = "\n".join(lines[head : head + 6]).partition("(")[2].partition("):")[0].partition(") ->")[0]
    return [name for name in _NAME.findall(re.sub(r"=[^,]*|:[^,]*", "", signature)) if name]


def _asked_for_none(line: str) -> Iterator[str]:
    """``is None`` in the place of other ways to ask an array whether it is there."""
    changes = [(r"== *None", "is None"), (r"!= *None", "is not None"), (r"\bnot ([\w.]+)(?= *:)", r"\1 is None")]
    changes += [(r"\bif ([\w.]+) *:", r"if \1 is not None:"), (r"= ([\w.]+) or ", r"= \1 if \1 is not None else ")]
    yield from (new for old, meant in changes if (new := re.sub(old, meant, line)) != line)


def _functions(text: str, name: str) -> list[ast.FunctionDef]:
    """The function of this name, or the methods of the class of this name."""
    with suppress(SyntaxError, ValueError, RecursionError, MemoryError):
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and node.name == name:
                return [node]
            if isinstance(node, ast.ClassDef) and node.name == name:
                return [each for each in node.body if isinstance(each, ast.FunctionDef)]
    return []


def _without_self(lines: _Lines, name: str) -> Iterator[list[str]]:
    for function in _functions("\n".join(lines), name):
        first = function.args.args[0].arg if function.args.args else ""
        if name[:1].isupper() and first != "self" and not function.decorator_list:
            row = function.lineno - 1
            yield _with(lines, row, re.sub(r"\((?=\S)", "(self, " if first else "(self", lines[row], count=1))


def _with_return(lines: _Lines, name: str) -> Iterator[list[str]]:
    """A function that returns nothing with a ``return`` of what stands last in it."""
    for function in _functions("\n".join(lines), name):
        returned = [each for each in ast.walk(function) if isinstance(each, ast.Return) and each.value is not None]
        last = function.body[-1]
        if function.name == "__init__" or (returned and isinstance(last, ast.Return)) or last.end_lineno is None:
            continue
        depth = " " * last.col_offset
        for value in _values(function.body):
            yield [*lines[: last.end_lineno], f"{depth}return {value}", *lines[last.end_lineno :]]


def _values(body: Sequence[ast.stmt]) -> Iterator[str]:
    """Return candidates for a missing `return`: what the function prints or names at its end, or assigned last."""
    last = body[-1]
    if isinstance(last, ast.Expr):
        call = last.value
        printed = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "print"
        told = call.args if printed and isinstance(call, ast.Call) else [call]
        yield ", ".join(ast.unparse(each) for each in told if not isinstance(each, ast.Constant | ast.JoinedStr))
    names = list(dict.fromkeys(_set_in(body)))
    if isinstance(last, ast.Assign | ast.AugAssign | ast.If):
        yield from (f"{names[-1]}.copy()", names[-1]) if names else ()
    if len(names) > 1:
        yield f"{names[-2]}, {names[-1]}"


def _set_in(body: Iterable[ast.stmt]) -> Iterator[str]:
    """The names and attributes that statements set, in their order."""
    for node in body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AugAssign) else []
        )
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (ast.unparse(each) for each in parts if isinstance(each, ast.Name | ast.Attribute))
        if isinstance(node, ast.If):
            yield from _set_in([*node.body, *node.orelse])
