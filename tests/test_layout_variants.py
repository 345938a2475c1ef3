"""Tests that a submission gets the same points at module level, as on the sheet, and in the cells of a notebook."""

from __future__ import annotations

import ast

import pytest

from tests.corpus.cases import Case, every
from tests.corpus.writing import Files, notebook
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

CASES = (
    "noise_in_blocks", "split_by_dimensions", "state-of-the-class", "method-under-another-name", "first-reading-kept", "bias-drawn-in-read",
    "reset-forgotten", "ids-looked-up-again", "own-timestep", "labels-of-panels-exchanged", "plot-raises", "drawn-in-the-constructor",
    "noise-into-the-simulator", "z-axis-only", "head-not-off-by-some", "half-of-the-steps", "zero-start-not-wrong-alpha",
)  # fmt: skip


def statements(code: object) -> list[ast.stmt]:
    """The statements of a file, without imports from the others; in place of a main guard, what it does, and what the functions do that it calls."""
    tree = ast.parse(str(code))
    guards = [part for part in tree.body if isinstance(part, ast.If) and "__name__" in ast.unparse(part.test)]
    called = {ast.unparse(each) for guard in guards for each in guard.body}
    functions = {f"{part.name}()": part for part in tree.body if isinstance(part, ast.FunctionDef)}
    bodies = {call: [*defaults(function), *function.body] for call, function in functions.items() if call in called}
    flat: list[ast.stmt] = []
    for part in tree.body:
        if part in guards:
            for each in part.body:  # type: ignore[attr-defined]
                flat += bodies.get(ast.unparse(each), [each])
        elif f"{getattr(part, 'name', '')}()" not in bodies:
            flat.append(part)
    return flat


def defaults(function: ast.FunctionDef) -> list[ast.stmt]:
    pairs = zip(function.args.args, function.args.defaults, strict=True)
    return ast.parse("\n".join(f"{name.arg} = {ast.unparse(value)}" for name, value in pairs)).body


def at_module_level(files: Files) -> Files:
    return {name: "\n\n".join(map(ast.unparse, statements(code))) + "\n" for name, code in files.items()}


def as_notebook(files: Files) -> Files:
    parts = [part for name in ("imu_reader.py", "noisy_imu.py", "filters.py") for part in statements(files[name])]
    own = ("imu_reader", "noisy_imu", "filters")
    cells = [part for part in parts if not (isinstance(part, ast.ImportFrom) and part.module in own)]
    return {"lab.ipynb": notebook(*map(ast.unparse, cells))}


@pytest.mark.parametrize("layout", [at_module_level, as_notebook])
@pytest.mark.parametrize("case", [case for case in every() if case.name in CASES], ids=lambda case: case.name)
def test_what_a_submission_defines_has_the_same_marks_in_every_layout(case: Case, layout, player: Marking) -> None:  # type: ignore[no-untyped-def]
    assert lost_by(marked(player, layout(case.files))) == lost_by(marked(player, case.files))
