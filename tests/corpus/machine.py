"""Runs the code cells of a notebook of the example class, so that it draws its pictures."""

from __future__ import annotations

import json
import re
import sys
import types
from collections.abc import Iterator
from pathlib import Path

REAL_MODEL = Path(__file__).resolve().parents[2] / "reference" / "models" / "humanoid-sensors.xml"
SHEET_MODEL = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"


def cells(path: Path) -> Iterator[str]:
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        source = "".join(cell["source"])
        if source.startswith("%%writefile"):
            head, body = source.split("\n", 1)
            (path.parent / head.split()[1]).write_text(body, encoding="utf-8")
            continue
        lines = source.split("\n")
        yield "\n".join("" if re.match(r"\s*([%!?]|\w+\s*=\s*!)|.*\w\?$", line) else line for line in lines)


def run_notebook(path: Path) -> None:
    module = types.ModuleType("notebook")
    sys.modules["notebook"] = module
    for source in cells(path):
        try:
            exec(compile(source, path.name, "exec"), module.__dict__)
        except (Exception, SystemExit) as problem:
            print("cell:", repr(problem), file=sys.stderr)
