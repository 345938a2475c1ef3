"""Catalogue of a lab's checks (ids, titles, lab steps), parsed from their source without importing it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from grader.engine.lab import Lab


@dataclass(frozen=True)
class Check:
    """Identity of a check: its id, its title (the sentence that a student reads) and its step in the lab sheet."""

    id: str
    title: str
    lab_step: int | None

    @property
    def criterion(self) -> str:
        return self.id.split(".")[0]


def title_of(docstring: str) -> str:
    """Return the title of a check: the first paragraph of its docstring, on one line, without the final full stop."""
    return " ".join(docstring.strip().split("\n\n")[0].split()).rstrip(".")


def checks_of(lab: Lab) -> Mapping[str, Check]:
    """Return the checks of a lab by id, read from the source of the check files, which are not imported."""
    return {check.id: check for path in check_files(lab) for check in _checks_in(path.read_text(encoding="utf-8"))}


def check_files(lab: Lab) -> list[Path]:
    """Return the files with the checks of a lab: one in the folder of each criterion."""
    return sorted(lab.folder.glob("*/checks.py"))


@cache
def _checks_in(source: str) -> tuple[Check, ...]:
    return tuple(_found(source))


def _found(source: str) -> Iterator[Check]:
    for function in (node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)):
        for call in function.decorator_list:
            if isinstance(call, ast.Call) and ast.unparse(call.func).rpartition(".")[2] == "check":
                steps = [word.value for word in call.keywords if word.arg == "lab_step"]
                step = ast.literal_eval(steps[0]) if steps else None
                yield Check(ast.literal_eval(call.args[0]), title_of(ast.get_docstring(function) or ""), step)
