"""Tests that advice costs nothing: the right lines of a fault, put into the sheet's own solution, are graded with all points."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterator, Sequence

import pytest

from grader.engine.faults import FaultRow, rows
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import edit, verbatim
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

SHEET = edit(
    verbatim(),
    "noisy_imu.py",
    (
        "        accel_noisy = accel + np.random.normal(0, self.accel_noise_std, 3) + self.accel_bias\n",
        "        noise = np.random.normal(0, self.accel_noise_std, 3)\n        accel_noisy = accel + noise + self.accel_bias\n",
    ),
)
"""The sheet's solution, with the noise under the name that the fault table gives it."""
HOMES = {
    "sensor_access": ("imu_reader.py", "get_imu_readings"), "data_collection": ("imu_reader.py", "simulate_and_collect"),
    "visualization": ("imu_reader.py", "plot_imu_data"), "comparison": ("filters.py", ""),
    "noise_model": ("noisy_imu.py", "NoisyIMU"), "filtering": ("filters.py", "LowPassFilter"),
}  # fmt: skip
"""The file and the function that the lines of a group belong to."""
OTHER_STYLE = {
    "aliased-rows",
    "fixed-rate",
    "keeps-old-rows",
    "filters-input-history",
    "index-out-of-bounds",
    "mutates-sensordata",
}
"""Faults of another style than the sheet's: lists in place of arrays, other names. Their lines stand in no place of its solution."""
ROWS = [
    row
    for row in rows(LAB).values()
    if row.right and row.group not in ("extensions", "any", "checks") and row.id not in OTHER_STYLE
]


def key(statement: ast.stmt) -> str:
    """Return what a statement is about: the name that it sets, the method that it calls, the kind of any other."""
    if isinstance(statement, ast.Assign):
        return ast.unparse(statement.targets[0])
    if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call):
        called = statement.value
        return " ".join(
            map(ast.unparse, [called.func, *[value.value for value in called.keywords if value.arg == "label"]])
        )
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return statement.name
    return type(statement).__name__


def blocks(tree: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield every list of statements, the outer ones first."""
    for node in ast.walk(tree):
        yield from (block for name in ("body", "orelse") if isinstance(block := getattr(node, name, None), list))


def advised(row: FaultRow) -> dict[str, str]:
    """Return the sheet's solution in which each right line takes the place of the one about the same."""
    home, function = HOMES["comparison" if row.id.startswith("comparison") else row.group]
    whole = ast.parse(SHEET[home])
    inside = next((node for node in whole.body if key(node) == function), whole)
    put(ast.parse(row.right).body, inside)
    return {**SHEET, home: ast.unparse(whole)}


def put(lines: Sequence[ast.stmt], into: ast.AST) -> None:
    """Put lines in; those that the solution has nothing like go before the next one that it has, or to the end of it all."""
    new: list[ast.stmt] = []
    for line in lines:
        if isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant):
            continue  # the dots of what is left out
        if key(line) == getattr(into, "name", ""):
            put(line.body, into)  # type: ignore[attr-defined]
            continue
        found = [(block, n) for block in blocks(into) for n, each in enumerate(block) if key(each) == key(line)]
        if not found:
            if not _in_place_of_curves(line, into) and not _in_constructor(line, into):
                new.append(line)
            continue
        block, index = max(found, key=lambda place: _likeness(line, place[0][place[1]]))
        if isinstance(line, ast.For | ast.If | ast.FunctionDef):
            put(line.body, block[index])
            block[index:index] = new
        else:
            block[index : index + 1] = [*new, line]
        new = []
    if new:
        body = into.body  # type: ignore[attr-defined]
        at = next((index for index, each in enumerate(body) if key(each) in ("plt.tight_layout", "Return")), 1)
        body[at:at] = new


def _likeness(one: ast.stmt, other: ast.stmt) -> float:
    return difflib.SequenceMatcher(None, ast.unparse(one), ast.unparse(other)).ratio()


def _in_place_of_curves(line: ast.stmt, into: ast.AST) -> bool:
    """Put a line that draws in the place of the sheet's curves on the same axes; return whether there are any."""
    axes = [name for name in ("axes[0].plot", "axes[1].plot", "panel.plot") if name in ast.unparse(line)]
    sheets = ("axes[0].plot", "axes[1].plot") if axes == ["panel.plot"] else tuple(axes)
    for block in blocks(into):
        drawn = [each for each in block if sheets and key(each).startswith(sheets)]
        if drawn:
            block[block.index(drawn[0])] = line
            block[:] = [each for each in block if each not in drawn]
            return True
    return False


def _in_constructor(line: ast.stmt, into: ast.AST) -> bool:
    """Put a line that sets a new attribute before all others of the constructor; return whether it is one."""
    made = next(
        (node for node in ast.walk(into) if isinstance(node, ast.FunctionDef) and node.name == "__init__"), None
    )
    if made is None or not key(line).startswith("self."):
        return False
    made.body.insert(0, line)
    return True


@pytest.mark.parametrize(
    "row", [pytest.param(row, marks=[pytest.mark.weekly] if n % 3 else [], id=row.id) for n, row in enumerate(ROWS)]
)
def test_who_follows_the_advice_gets_all_points(row: FaultRow, player: Marking) -> None:
    assert lost_by(marked(player, advised(row))) == {}
