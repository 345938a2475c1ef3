"""Candidates for a repair: edits of one place in a file that does not run, made in a process with limits.

Python's parser reads the student's text once for each edit. A text can make it run for minutes, fill the memory or end its process,
so a separate process with limits on time and memory does it. If that process dies, there are no candidates.
"""

from __future__ import annotations

import ast
import difflib
import itertools
import keyword
import math
import re
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context

from grader.engine.processes import starting_processes

_CPU_S = 10
"""CPU seconds for all edits of a place. A file of the sheet's length takes 0.2, one of 100 kB about 5."""
_START_S = 30  # seconds to start the process, on a busy machine
_MEMORY = 1 << 30  # bytes of address space
_LARGEST = 100_000  # bytes of a file that is parsed for each candidate
_MOST_PARSED = 1500
_TOKEN = re.compile(r"\"[^\"\n]*\"?|'[^'\n]*'?|\w+|\s+|[^\w\s]")
_PROMPT = re.compile(r"^(\s*)(?:>>>|\.\.\.|In \[\d+\]:)(?: |$)")
_NAME = re.compile(r"(?<![\w'\"])[^\W\d]\w*")
_CLOSE = 0.7
"""Least `difflib` similarity of a misspelt name and its replacement. It may be low, because the code does not run anyway."""
_INSERTED = (":", ")", "]", "}", ",", "(", "[", "'", '"', " in ", "=")
_TYPOGRAPHIC = str.maketrans("“”„‟″‘’‚‛′–—−，；：（）［］｛｝＝＋　\xa0", "\"\"\"\"\"'''''---,;:()[]{}=+  ")
_NUMPY = ("np.", "numpy.")
_WORDS = ("data", "model", "self", "range", "len", "print", "abs", "int", "float", "None", "True", "False")
_STATEMENTS = ("return", "break", "continue", "pass")
"""Keywords that stand alone in a line, where a misspelt one is a name for Python."""


@dataclass(frozen=True)
class Candidates:
    """Edited copies of a file, each a possible repair that is graded next, and the CPU seconds that it took to make them."""

    files: tuple[bytes, ...] = ()
    cpu_s: float = 0.0


def limited(content: bytes, row: int, name: str, most: int, cpu_s: int = _CPU_S) -> Candidates:
    """Make up to `most` possible repairs in a new process; none if the process exceeds its memory or `cpu_s` seconds of CPU time.

    `content` is the file, `row` the line at which it stops, from 0 (-1 if only the function is known), and `name` the required
    function or class ("" if there is none).
    """
    with starting_processes() as begin:
        executor = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=begin)
        made = executor.submit(_within_limits, content, row, name, most, cpu_s)
    try:
        return made.result(timeout=6 * cpu_s + _START_S)
    except (OSError, RuntimeError, MemoryError, TimeoutError):  # a limit ended the process, or the machine is too busy
        return Candidates(cpu_s=cpu_s)
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def _within_limits(content: bytes, row: int, name: str, most: int, cpu_s: int) -> Candidates:
    """Limit the CPU time and memory of this process, because the file is hostile, and return its candidates."""
    began = time.process_time()
    used = math.ceil(began)  # starting the process took that long
    with suppress(ImportError):  # Windows has no such limits; the time of the call is bounded there, too
        import resource  # noqa: PLC0415

        resource.setrlimit(resource.RLIMIT_CPU, (used + cpu_s, used + cpu_s))
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    return Candidates(tuple(itertools.islice(candidates(content, row, name), most)), time.process_time() - began)


def candidates(content: bytes, row: int, name: str) -> Iterator[bytes]:
    """Yield edited copies of a file as possible repairs, likeliest first; all parse, each to a different syntax tree.

    There is none for a file that is larger than `_LARGEST` or not UTF-8.

    Parameters
    ----------
    row
        The line at which the submission stops, counted from 0; -1 where only the function is known.
    name
        The required function or class that the failed check is about; "" if there is none.
    """
    try:
        text = content.decode()
    except UnicodeDecodeError:
        return
    if len(content) > _LARGEST:
        return
    known = {_syntax_tree(text)}
    lines = text.split("\n")
    edits = _runtime_edits(lines, row, name) if None not in known else _syntax_edits(lines, row)
    for edited in itertools.islice(edits, _MOST_PARSED):
        new = "\n".join(edited)
        meaning = _syntax_tree(new)
        if meaning is not None and meaning not in known:
            known.add(meaning)
            yield new.encode()


def _syntax_tree(text: str) -> str | None:
    """Return the syntax tree of a program as text, to notice edits that change nothing; None if it does not parse."""
    try:
        return ast.dump(ast.parse(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


_Lines = Sequence[str]


def _with(lines: _Lines, row: int, *new: str) -> list[str]:
    return [*lines[:row], *new, *lines[row + 1 :]]


def _syntax_edits(lines: _Lines, row: int) -> Iterator[list[str]]:
    """Yield edits of a file that does not parse: of the whole file, of the line `row` of the error, and of three lines above."""
    if not 0 <= row < len(lines):
        return
    yield from _whole_file_edits(lines)
    rows = [row, *(each for each in range(row - 1, max(-1, row - 4), -1) if lines[each].strip())]
    for each in rows:
        line = lines[each]
        if line.translate(_TYPOGRAPHIC) != line:
            yield _with(lines, each, line.translate(_TYPOGRAPHIC))
        yield from (_with(lines, each, new) for new in (*_foreign_habit_edits(line), *_keyword_edits(line)))
        yield from (_with(lines, each, new) for new in _indentation_edits(lines, each))
    for each in rows:
        yield from (_with(lines, each, new) for new in _token_edits(lines[each]))
    for each in rows:
        if lines[each].rstrip().endswith(":"):
            depth = len(lines[each]) - len(lines[each].lstrip()) + 4
            yield _with(lines, each, lines[each], " " * depth + "pass")


def _whole_file_edits(lines: _Lines) -> Iterator[list[str]]:
    """Yield copies of the file without merge conflict markers, without pasted prompts, and with spaces in place of tabs."""
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
    if any(line.lstrip().startswith((">>>", "In [")) for line in lines):  # `...` alone is also Python
        yield [_PROMPT.sub(r"\1", line) for line in lines]
    if any("\t" in line for line in lines):
        yield from ([line.expandtabs(width) for line in lines] for width in (4, 8))


def _foreign_habit_edits(line: str) -> Iterator[str]:
    """Yield the line without habits from other languages, such as ``print x``, ``else if``, ``i++`` and ``=`` in a condition."""
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


def _keyword_edits(line: str) -> Iterator[str]:
    """Yield the line with a misspelt keyword put right, such as ``retrun``, ``esle`` or ``dfe``."""
    for found in _NAME.finditer(line):
        near = difflib.get_close_matches(found[0], keyword.kwlist, 2, _CLOSE)
        swapped = [each for each in keyword.kwlist if sorted(each) == sorted(found[0])]
        meant = dict.fromkeys([*swapped, *near] if not keyword.iskeyword(found[0]) else [])
        yield from (line[: found.start()] + each + line[found.end() :] for each in meant)


def _indentation_edits(lines: _Lines, row: int) -> Iterator[str]:
    """Yield the line `row` with the indentation of a nearby line, or 4 spaces more than that; the smallest change first."""
    line = lines[row]
    own = len(line) - len(line.lstrip())
    near = [each for each in lines[max(0, row - 30) : row + 5] if each.strip()]
    depths = {len(each) - len(each.lstrip()) for each in near}
    depths |= {depth + 4 for depth in depths}
    yield from (" " * depth + line.lstrip() for depth in sorted(depths - {own}, key=lambda depth: abs(depth - own))[:6])


def _token_edits(line: str) -> Iterator[str]:
    """Yield the line with one token inserted or removed, starting at its end, where a token is usually missing."""
    code = line.split("#", maxsplit=1)[0].rstrip()
    ends = [each.end() for each in _TOKEN.finditer(line) if each.end() <= len(code)]
    for at in sorted({len(code), *ends}, reverse=True):
        yield from (line[:at] + token + line[at:] for token in _INSERTED)
    for token in reversed(list(_TOKEN.finditer(line))):
        if not token[0].strip() or len(token[0]) == 1:
            yield line[: token.start()] + line[token.end() :]


def _runtime_edits(lines: _Lines, row: int, name: str) -> Iterator[list[str]]:
    """Yield edits of a file that parses but stops: of the line `row`, if known, then of the function or class `name`."""
    text = "\n".join(lines)
    if row >= 0:
        line = lines[row]
        for new in _name_edits(line, text, _parameters(lines, row)):
            yield _with(lines, row, new)
        for new in _none_test_edits(line):
            yield _with(lines, row, new)
    yield from _missing_self_edits(lines, name)
    yield from _missing_return_edits(lines, name)


def _name_edits(line: str, text: str, parameters: Sequence[str]) -> Iterator[str]:
    """Yield the line with one name replaced: by a similar name of the file, with ``self.`` or ``np.`` added, or by a parameter."""
    known = {*_NAME.findall(text), *_WORDS, *_STATEMENTS}
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
    """Return the parameters of the function around the line `row`, found by a text search; empty outside of functions."""
    head = next((at for at in range(row, -1, -1) if re.match(r"\s*(?:async )?def ", lines[at])), None)
    if head is None:
        return ()
    signature = "\n".join(lines[head : head + 6]).partition("(")[2].partition("):")[0].partition(") ->")[0]
    return [name for name in _NAME.findall(re.sub(r"=[^,]*|:[^,]*", "", signature)) if name]


def _none_test_edits(line: str) -> Iterator[str]:
    """Yield the line with ``is None`` in place of truth tests and comparisons that fail for arrays."""
    changes = [(r"== *None", "is None"), (r"!= *None", "is not None"), (r"\bnot ([\w.]+)(?= *:)", r"\1 is None")]
    changes += [(r"\bif ([\w.]+) *:", r"if \1 is not None:"), (r"= ([\w.]+) or ", r"= \1 if \1 is not None else ")]
    yield from (new for old, meant in changes if (new := re.sub(old, meant, line)) != line)


def _functions(text: str, name: str) -> list[ast.FunctionDef]:
    """Return the function of this name, or the methods of the class of this name; empty if the text has neither."""
    with suppress(SyntaxError, ValueError, RecursionError, MemoryError):
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and node.name == name:
                return [node]
            if isinstance(node, ast.ClassDef) and node.name == name:
                return [each for each in node.body if isinstance(each, ast.FunctionDef)]
    return []


def _missing_self_edits(lines: _Lines, name: str) -> Iterator[list[str]]:
    for function in _functions("\n".join(lines), name):
        first = function.args.args[0].arg if function.args.args else ""
        if name[:1].isupper() and first != "self" and not function.decorator_list:
            row = function.lineno - 1
            yield _with(lines, row, re.sub(r"\((?=\S)", "(self, " if first else "(self", lines[row], count=1))


def _missing_return_edits(lines: _Lines, name: str) -> Iterator[list[str]]:
    """Yield copies in which the required function or method, if it lacks a final ``return``, returns its last value."""
    for function in _functions("\n".join(lines), name):
        returned = [each for each in ast.walk(function) if isinstance(each, ast.Return) and each.value is not None]
        last = function.body[-1]
        if function.name == "__init__" or (returned and isinstance(last, ast.Return)) or last.end_lineno is None:
            continue
        depth = " " * last.col_offset
        for value in _return_values(function.body):
            yield [*lines[: last.end_lineno], f"{depth}return {value}", *lines[last.end_lineno :]]


def _return_values(body: Sequence[ast.stmt]) -> Iterator[str]:
    """Yield candidates for the value of a missing ``return``: what a function prints, names or assigns last."""
    last = body[-1]
    if isinstance(last, ast.Expr):
        call = last.value
        printed = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "print"
        shown = call.args if printed and isinstance(call, ast.Call) else [call]
        yield ", ".join(ast.unparse(each) for each in shown if not isinstance(each, ast.Constant | ast.JoinedStr))
    names = list(dict.fromkeys(_assigned_names(body)))
    if isinstance(last, ast.Assign | ast.AugAssign | ast.If):
        yield from (f"{names[-1]}.copy()", names[-1]) if names else ()
    if len(names) > 1:
        yield f"{names[-2]}, {names[-1]}"


def _assigned_names(body: Iterable[ast.stmt]) -> Iterator[str]:
    """Yield the names and attributes that statements assign, in order, because the last ones are likely return values."""
    for node in body:
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AugAssign) else []
        )
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (ast.unparse(each) for each in parts if isinstance(each, ast.Name | ast.Attribute))
        if isinstance(node, ast.If):
            yield from _assigned_names([*node.body, *node.orelse])
