"""The page of the architecture: the picture of the flow, the floors, and the first sentence of each module."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from grader.ground.package_data import beside


def page() -> str:
    """The text, then the table of the modules."""
    rows = "\n".join(f"| `{name}` | {sentence} |" for name, sentence in _sentences())
    text = beside(__package__, "architecture.txt").read_text(encoding="utf-8")
    return f"{text}\n| Module | Is for |\n| --- | --- |\n{rows}\n"


def _sentences() -> Iterator[tuple[str, str]]:
    """Each module that says what it is for, packages by their folder."""
    package = beside("grader", "")
    for path in sorted(package.rglob("*.py")):
        inside = path.relative_to(package)
        if any(part.startswith((".", "__pycache__")) for part in inside.parts):
            continue
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
        if text:
            name = inside.parent if inside.name == "__init__.py" else inside
            yield f"grader/{name.as_posix()}".removesuffix("/."), _first(text)


def _first(text: str) -> str:
    paragraph = " ".join(text.strip().split("\n\n")[0].split())
    return paragraph.replace("|", "\\|")
