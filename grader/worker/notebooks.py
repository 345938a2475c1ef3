"""Read notebooks: their code cells as plain Python, with magics and shell lines removed, so that they run without IPython."""

from __future__ import annotations

import ast
import json
import re
from typing import Any

_MOST_MAGICS = 300  # most magics that are replaced in a cell; the cell is parsed again after each
_TRANSPARENT = ("%%time", "%%timeit", "%%capture", "%%prun")
_TIMED = re.compile(r"%(?:time|timeit)\b(?:\s+-[a-z]+(?:\s*\d+)?)*\s*")  # and its options, up to what is timed
_SHELL_ASSIGNMENT = re.compile(r"^(\s*[\w, ]+=\s*)([!%]).*$")
_WRITES = re.compile(  # /content is where a notebook is at home in Colab; no part of a path may lead out of the folder
    r"""%%(?:writefile|file)\s+(-a\s+|--append\s+)?(["']?)(?:\./|/content/)?((?:\w[\w-]{0,60}/){0,3}\w[\w-]{0,60}\.py)\2\s*"""
)


def code_cells(content: bytes) -> list[str]:
    """Return the code cells of a notebook as plain Python (see `plain_python`); raise ValueError if it is no notebook."""
    return [plain_python(source) for source in raw_cells(content)]


def raw_cells(content: bytes) -> list[str]:
    """Return the code cells of a notebook (format 3 or 4) with their magics; raise ValueError if it is no notebook."""
    book = json.loads(content.decode("utf-8-sig"))
    if not isinstance(book, dict):
        raise ValueError("a notebook is a JSON object")
    worksheets = book.get("worksheets")
    sheets = worksheets if isinstance(worksheets, list) else [book]
    cells = [c for s in sheets if isinstance(s, dict) and isinstance(s.get("cells"), list) for c in s["cells"]]
    code = [c for c in cells if isinstance(c, dict) and c.get("cell_type") == "code"]
    return [_source(cell) for cell in code]


def _source(cell: dict[str, Any]) -> str:
    source = cell.get("source", cell.get("input", ""))
    return "".join(map(str, source)) if isinstance(source, list) else str(source)


def files_written(content: bytes) -> dict[str, str]:
    """Return the text of the Python files that ``%%writefile`` cells write, by path; raise ValueError if it is no notebook."""
    files: dict[str, str] = {}
    for source in raw_cells(content):
        head, _, body = source.lstrip().partition("\n")
        if written := _WRITES.fullmatch(head):
            appended, _, path = written.groups()
            files[path] = f"{files.get(path, '') if appended else ''}{body}\n"
    return files


def plain_python(cell: str) -> str:
    """Return a cell as plain Python of as many lines, without magics, shell lines and ``?``; "" for a cell in another language.

    A line is replaced only if the parser rejects it, because a valid line may begin with ``%`` inside brackets.
    """
    first = cell.lstrip().split("\n", 1)[0].strip()
    if first.startswith("%%") and not first.startswith(_TRANSPARENT):
        return ""
    lines = cell.split("\n")
    for _ in range(_MOST_MAGICS):
        at = _rejected_line(lines)
        if at is None or not _replace_magic(lines, at):
            break
    return "\n".join(lines)


def _rejected_line(lines: list[str]) -> int | None:
    """Return the index of the line that the parser rejects, or of the line that it continues; None if the parser names no line."""
    try:
        ast.parse("\n".join(lines))
    except SyntaxError as error:
        at = min(error.lineno or 1, len(lines)) - 1
        while at > 0 and _continues(lines[at - 1]):
            at -= 1
        return at
    except (ValueError, RecursionError, MemoryError):
        return None
    return None


def _continues(line: str) -> bool:
    return line.rstrip().endswith("\\")


def _replace_magic(lines: list[str], at: int) -> bool:
    """Replace the magic at line `at`, with its continuation lines, by plain Python in `lines`; return False if it is no magic."""
    plain = _plain_line(lines[at])
    if plain == lines[at]:
        return False
    end = at + 1
    while end < len(lines) and _continues(lines[end - 1]):
        end += 1
    lines[at:end] = [plain] + [""] * (end - at - 1)
    return True


def _plain_line(line: str) -> str:
    """Return plain Python in place of a magic or shell line; any other line comes back unchanged."""
    start = line.lstrip()
    indent = line[: len(line) - len(start)]
    if timed := _TIMED.match(start):
        return indent + (start[timed.end() :] or "pass")
    if start.startswith("%run "):
        return f"{indent}get_ipython().run_line_magic('run', {start.removeprefix('%run ')!r})"
    if start.startswith("%pylab"):
        return f"{indent}from pylab import *"
    if start.startswith(("%", "!")) or start.rstrip().endswith("?") or start.startswith("?"):
        return f"{indent}pass"
    assigned = _SHELL_ASSIGNMENT.match(line)
    if assigned is None:
        return line
    return assigned.group(1) + ("[]" if assigned.group(2) == "!" else "None")  # a command's lines: it says nothing here
