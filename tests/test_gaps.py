"""A slip of the pen costs the part that it stands in or below, and the rest of the file counts: in its text, and in marks."""

from __future__ import annotations

import ast

import pytest

from grader.harness import gaps, stepping
from tests.corpus.pieces import edit, tidy, verbatim
from tests.corpus.sheet import VERBATIM
from tests.corpus.writing import Files, notebook
from tests.recordings import Marking
from tests.scoreboard import Case, handed_in

TEXT = """\
import math

def helper(x):
    return (
x)

def first(a):
    '''What it does.
# not indented
    '''
    return a

print(first(1))

@math.fsum
class Second:
    def one(self):
        return 1

print("done")
"""
WANTED = ("first", "Second")


def split(text: str) -> tuple[list[str], list[tuple[str, int | None]]]:
    """What the statements that were read bind, and for each gap what went with it, with the line."""
    with pytest.raises(SyntaxError) as refused:
        stepping.units_of(ast.parse(text, "lab.py"), "lab.py")
    units = gaps.units_around(text, "lab.py", WANTED, refused.value)
    lost = [unit.node for unit in units if isinstance(unit.node, stepping.Gap)]
    there = [name for unit in units if unit.node not in lost for name in stepping.bound(unit.node)]
    return there, [(" ".join(stepping.bound(gap)), gap.refused.lineno) for gap in lost]


@pytest.mark.parametrize(
    ("old", "new", "there", "lost"),
    [
        ("def first(a):", "def first(a)", ["helper", "Second"], [("first", 7)]),
        ("def one(self):", "def one(self:", ["helper", "first"], [("Second", 17)]),
        ("    return a\n", "  return a\n", ["helper", "Second"], [("first", 11)]),
        ("    return a\n", "return a\n", ["helper", "Second"], [("first", 11)]),
        ("    '''\n    return a", "    return a", ["helper", "Second"], [("first", 8)]),
        ("def helper(x):\n    return (\nx)\n", "def helper(x):\nx = 1\n", ["x", "Second"], [("first", 4)]),
        ("print(first(1))", "print first(1)", ["helper", "Second"], [("first", 13)]),
        ('print("done")', 'print("done"', ["helper", "first"], [("Second", 20)]),
        ("import math", "import math as", ["helper", "Second"], [("first", 1)]),
    ],
)
def test_a_slip_costs_what_it_stands_in_or_below(
    old: str, new: str, there: list[str], lost: list[tuple[str, int]]
) -> None:
    assert TEXT.count(old) == 1
    assert split(TEXT.replace(old, new)) == (there, lost)


def test_slips_beside_the_definitions_cost_one_of_them_together() -> None:
    merge = TEXT.replace("print(first(1))", "<<<<<<< HEAD\nprint(first(1))\n=======\nprint(first(2))\n>>>>>>> other")
    assert split(merge) == (["helper", "Second"], [("first", 13), ("", 15), ("", 17)])


@pytest.mark.parametrize(
    "text", ["Dear player,\nthis is\nmy work\nfor the lab.\nBest regards\nJo Doe\n", "x = (" + "1" * 500_000]
)
def test_what_is_no_program_at_all_is_refused_as_a_whole(text: str) -> None:
    with pytest.raises(SyntaxError):
        split(text)


# --- in marks ---------------------------------------------------------------------------------------------------------

READING = ("    return acceleration, angular_velocity", "    return (acceleration, angular_velocity")
NOISE = ("    def read(self):", "    def read(self)")
SHEET = "\n\n".join(
    "\n".join(line for line in str(text).splitlines() if not line.startswith("from "))
    for text in (VERBATIM[name] for name in ("imu_reader.py", "noisy_imu.py", "filters.py"))
)


def without_last_bracket(files: Files, name: str) -> Files:
    return {**files, name: f"{files[name]}\nprint('done'\n"}


SLIPS: dict[str, tuple[Files, str]] = {
    "the sheet's reader": (edit(verbatim(), "imu_reader.py", READING), "sensor_access"),
    "the sheet's recorder": (edit(verbatim(), "imu_reader.py", ("    for i in range(n_steps):", "    for i in range(n_steps)")), "data_collection"),
    "the sheet's plot": (edit(verbatim(), "imu_reader.py", ("def plot_imu_data(imu_data):", "def plot_imu_data(imu_data)")), "visualization"),
    "the sheet's noise": (edit(verbatim(), "noisy_imu.py", NOISE), "noise_model"),
    "the last line of the sheet's reader": (without_last_bracket(verbatim(), "imu_reader.py"), "visualization"),
    "a sentence above the sheet's reader": ({**verbatim(), "imu_reader.py": f"This is my solution\n{VERBATIM['imu_reader.py']}"}, "sensor_access"),
    "functions alone": ({**tidy(), "noisy_imu.py": str(tidy()["noisy_imu.py"]) + '\nprint "noisy", 3\n'}, "noise_model"),
    "one file": ({"lab.py": SHEET.replace(*NOISE)}, "noise_model"),
    "one cell": ({"lab.ipynb": notebook(SHEET.replace(*NOISE))}, "noise_model"),
    "a class whose name is misspelt, and its demo": (edit(verbatim(), "filters.py", ("class LowPassFilter", "class LowpassFilter")), "filtering"),
    "a class whose name is misspelt, and the next file": (edit(verbatim(), "noisy_imu.py", ("class NoisyIMU", "class NoisyImu")), "noise_model"),
}  # fmt: skip


@pytest.mark.parametrize("name", SLIPS)
def test_one_slip_costs_one_criterion(name: str, player: Marking) -> None:
    files, lost = SLIPS[name]
    result = player.mark(handed_in(Case("slips", name, files)))
    assert [part.id for part in result.criteria if part.points != part.max_points] == [lost]
    first = next(check for part in result.criteria for check in part.checks if check.outcome in ("failed", "partial"))
    assert first.misconceptions == ("name-missing" if "misspelt" in name else "does-not-import",)
    assert "misspelt" in name or ("SyntaxError" in first.message and ", line " in first.message)
