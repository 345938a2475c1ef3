"""What the package imports is what its metadata asks for."""

from __future__ import annotations

import ast
import importlib.metadata
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OURS = {"grader", "reference"}
#: What runs in a sandbox imports what a student handed in, and the sandbox's modules under a name of their own.
OF_A_SUBMISSION = {"imu_reader", "noisy_imu", "filters"}


def imported() -> Iterator[str]:
    """Top names of all absolute imports."""
    for folder in OURS:
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    yield from (alias.name.partition(".")[0] for alias in node.names)
                elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                    yield node.module.partition(".")[0]


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_package_that_is_imported_is_asked_for_by_name() -> None:
    """By what an install brings, or its extras."""
    needs = importlib.metadata.requires("imugrade") or []
    asked = [each for each in needs if "extra ==" not in each or each.endswith(("'cluster'", "'desk'"))]
    declared = {_normal(re.split(r"[^\w.-]", need)[0]) for need in asked}
    brought_by = importlib.metadata.packages_distributions()
    others = set(imported()) - set(sys.stdlib_module_names) - OURS - OF_A_SUBMISSION
    assert others >= {"numpy", "mujoco", "PIL"}
    assert {name for name in others if not declared & {_normal(by) for by in brought_by.get(name, [name])}} == set()
