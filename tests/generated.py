"""Generated files that tests compare with: many tests may find one of them stale, and the run reports that as one failure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

STALE = "if the change is meant, run python -m tests.regenerate, read the difference and commit it"
differences: dict[str, list[str]] = {}
"""By path of the generated file: where this process found it stale. `conftest.py` gathers them from all test workers."""


def differs(file: Path, text: str) -> None:
    """Note that a generated file is stale; the run then fails once for this file."""
    differences.setdefault(file.relative_to(Path(__file__).parent).as_posix(), []).append(text)


def failures(found: Mapping[str, list[str]]) -> dict[str, str]:
    """Return what the run reports for each stale file: its differences, and the command that writes it anew."""
    return {file: "\n".join([*sorted(set(texts)), STALE]) for file, texts in sorted(found.items())}
