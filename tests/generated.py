"""Generated files that tests compare with: many tests may find one of them stale, and the run reports that as one failure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

STALE = "if the change is meant, run python -m tests.regenerate, read the difference and commit it"
differences: dict[str, list[str]] = {}
"""By path of the generated file: where this process found it stale. `conftest.py` gathers them from all test workers."""


def differs(file: Path, text: str) -> None:
    """Note that a generated file is stale; the run then fails once for this file."""
    differences.setdefault(file.relative_to(Path(__file__).parent).as_posix(), []).append(text)


def failures(found: Iterable[Mapping[str, list[str]]]) -> dict[str, str]:
    """Return what the run reports for each file that a test worker found stale: its differences, and the command that writes it anew."""
    stale: dict[str, set[str]] = {}
    for file, texts in ((file, texts) for each in found for file, texts in each.items()):
        stale.setdefault(file, set()).update(texts)
    return {file: "\n".join([*sorted(texts), STALE]) for file, texts in sorted(stale.items())}
