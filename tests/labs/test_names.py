"""The engine, the sandbox and what speaks of results name no lab: no word of one, no name, file or picture that one asks for."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.labs.imu.lab import LAB

GRADER = Path(__file__).parent.parent.parent / "grader"
FOLDERS = (
    "engine",
    "sandbox",
    "intake",
    "worker",
    "report",
    "platforms",
    "people",
    "course",
    "kit",
    "base",
    "desk",
    "commands",
)
WORDS = {
    "humanoid", "torso", "robot", "mujoco", "sensor", "sensors", "accelerometer", "accel", "gyroscope", "gyro", "imu", "imus",
    "acceleration", "angular", "gravity", "allan",
}  # fmt: skip
ASKED = {*LAB.homes, *LAB.homes.values(), *LAB.pictures, *LAB.titles, *LAB.titles.values()}

#: What is left, and why.
LEFT = {
    ("commands/repeating.py", "robot"): "the file that lies beside a program which repeats calls of the shipped lab",
    ("commands/opening.py", "robot"): "what students are told of the hidden scenarios of the shipped lab",
    ("commands/opening.py", "sensors"): "what students are told of the hidden scenarios of the shipped lab",
    ("commands/adjust.py", "visualization"): "an example in the help",
    ("engine/lab_registry.py", "imu"): "the shipped lab, which a command takes where none is named",
    ("course/publishing/differences.py", "mujoco"): "how a package of a result's provenance is called",
    ("report/overview.py", "mujoco"): "how a package of a result's provenance is called",
    ("report/pages.py", "mujoco"): "how a package of a result's provenance is called",
}


def named(source: str) -> Iterator[str]:
    """Every identifier and every string of a program; docstrings may give examples."""
    tree = ast.parse(source)
    told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            yield node.value
        for field in ("id", "attr", "arg", "name", "asname", "module"):
            if isinstance(name := getattr(node, field, None), str):
                yield name


def of_a_lab(text: str) -> set[str]:
    """The words in it that are a lab's."""
    words = {word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", text)}
    return words & WORDS | {
        each for each in ASKED if each in text and re.search(rf"(?<!\w){re.escape(each)}(?!\w)", text)
    }


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("class NoisyArm: pass", set()),
        ("class NoisyIMU: pass", {"imu", "NoisyIMU"}),
        ("from x import torso_accelerometer", {"torso", "accelerometer"}),
        ("def f(gyro): return gyro.id", {"gyro"}),
        ("message = f'{x} is not in imu_reader.py'", {"imu", "imu_reader.py"}),
        ("'IMUGRADE_CACHE of imugrade'; x = 'simulate'", set()),
        ("def f():\n    'Reads the torso.'\n", set()),
    ],
)
def test_a_word_of_a_lab_is_seen_wherever_it_stands_in_a_program(source: str, words: set[str]) -> None:
    assert {word for text in named(source) for word in of_a_lab(text)} == words


def test_nothing_but_what_is_listed_names_a_lab() -> None:
    paths = sorted(path for folder in FOLDERS for path in (GRADER / folder).rglob("*.py"))
    found = {
        (path.relative_to(GRADER).as_posix(), word)
        for path in paths
        for text in named(path.read_text(encoding="utf-8"))
        for word in of_a_lab(text)
    }
    assert found == set(LEFT)
