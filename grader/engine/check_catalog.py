"""Catalogue of a lab's checks (ids, titles, lab steps), parsed from their source, because importing them takes long."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.engine.lab import Lab


@dataclass(frozen=True)
class Check:
    """Identity of a check: id (``filtering.passes_constant``), title for students, and step of the lab sheet, None for no step."""

    id: str
    title: str
    lab_step: int | None

    @property
    def criterion(self) -> str:
        return self.id.split(".")[0]


def title_of(docstring: str) -> str:
    """Return the title of a check for students: the first paragraph of its function's docstring, on one line, without full stop."""
    return " ".join(docstring.strip().split("\n\n")[0].split()).rstrip(".")


def checks_of(lab: Lab) -> Mapping[str, Check]:
    """Return the checks of a lab by id, parsed from the source of the check files; an instructor's own checks are not included."""
    return {check.id: check for path in check_files(lab) for check in _checks_in(path.read_text(encoding="utf-8"))}


def check_files(lab: Lab) -> list[Path]:
    """Return the files that define a lab's checks, sorted: each ``checks.py`` one folder below the lab's folder."""
    return sorted(lab.folder.glob("*/checks.py"))


@cache
def _checks_in(source: str) -> tuple[Check, ...]:
    return tuple(_parsed_checks(source))


def _parsed_checks(source: str) -> Iterator[Check]:
    for function in (node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)):
        for call in function.decorator_list:
            if isinstance(call, ast.Call) and ast.unparse(call.func).rpartition(".")[2] == "check":
                steps = [word.value for word in call.keywords if word.arg == "lab_step"]
                step = ast.literal_eval(steps[0]) if steps else None
                yield Check(ast.literal_eval(call.args[0]), title_of(ast.get_docstring(function) or ""), step)
