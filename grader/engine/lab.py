"""What a lab is to an engine that knows none: its parts, names and files, and the few functions that only a lab can give.

Everything that lists parts, names, files or pictures derives it from one `Lab`; a rubric holds the lab that it is for.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from yaml import Node

    from grader.engine.chart_data import Chart
    from grader.engine.rubric_nodes import Reader
    from grader.engine.submission_session import Conversation
    from grader.engine.traces import Traces
    from grader.sandbox.wire import Frame

_FURNITURE = re.compile(r"\bFURNITURE_([A-Z]+)\b")


@dataclass(frozen=True)
class Part:
    """What is graded as one: a criterion, or a bonus.

    Attributes
    ----------
    id, title
        As the rubric and every page call it.
    names
        What a submission must define for it; a finding points to the first where it has no line of its own.
    home
        The file that the lab expects the names in.
    needed
        Whether other parts build on its names: it is then examined before those that nothing builds on, and sound stand-ins
        take the place of its names once its own checks are over and lost.
    pictures
        The pictures that are handed in for it.
    """

    id: str
    title: str
    names: tuple[str, ...]
    home: str
    needed: bool = True
    pictures: tuple[str, ...] = ()

    def attempted_in(self, files: Mapping[str, bytes]) -> bool:
        """Whether a submission hands in its file, or defines one of its names elsewhere, as far as its text tells; nothing runs."""
        names = "|".join(self.names)
        pattern = rf"\b(?:class|def)[ \t]+(?:{names})\b|%%writefile[ \t]+{self.home}"
        defines = re.compile(pattern.encode())
        return self.home in files or any(
            defines.search(content) for path, content in files.items() if path.endswith((".py", ".ipynb"))
        )


@dataclass(frozen=True)
class Brought:
    """A file that a rubric names in the place of one of the lab's, and the public traces that were recorded of it.

    `keys` lead to the line of the rubric that names it.
    """

    traces: Traces
    keys: tuple[str, ...]
    file: str
    text: str


@dataclass(frozen=True)
class Handout:
    """What students get beside the starter files, by path, and the names that stand there in the place of the sheet's."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)


def _brings_nothing(settings: Mapping[str, Any]) -> None:
    """Of a lab whose rubric names nothing."""


def _nothing_more(own: Brought | None) -> Handout:
    return Handout()


def _any_will_do(settings: Mapping[str, Any], traces: Traces) -> None:
    """Of a lab that is about one thing alone."""


@dataclass(frozen=True, eq=False)
class Lab:
    """One lab, as one value.

    Attributes
    ----------
    module
        The module that holds this value as `LAB`: how another process finds it.
    id, label, title
        ``imu``, ``Lab 04-01``, ``Reading IMU data in MuJoCo``.
    parts, bonuses
        What earns points, in the sheet's order, and what advanced students may add.
    model
        The file that the sheet loads, if it loads one, by the path that it names.
    points_to
        Checks whose findings point to another name than the first of their part.
    calls
        How each name is called, in a line, where `imugrade repro` can write the call down.
    waits_for
        What is waited for while a question takes long, in a word, by the question's operation.
    settings
        The keys of a rubric that are this lab's own, and how each is read: from the file's reader, its node (None where it is left
        out) and the folder that paths in it start from.
    libraries
        What some submissions import and what takes longer to import than the rest of their work: a class shares it.
    recorder
        The program that records ground truth, as ``python -m`` names it; it may be missing where only public truth is used.
    depends_on
        Packages whose versions may change a number: of the recorder's, or of a submission's.
    same_for_all
        Scenarios in which no secret changes a number.
    student, charts, checked
        Makes the proxy that the checks talk to; draws what a report shows of its answers; holds an answer against its question.
    truth
        Gives the traces to grade with, from a secret (None: the public ones) and the settings of a rubric.
    match
        Refuses traces, by a RubricError, that are of something else than the settings name.
    brought
        Finds what the settings name in the place of something of the lab's: a kit has to carry it.
    handout
        Makes what students get of that; None stands for the lab's own.
    """

    module: str
    id: str
    label: str
    title: str
    parts: tuple[Part, ...]
    bonuses: tuple[Part, ...]
    student: Callable[..., Conversation]
    charts: Callable[[Any, Traces], tuple[Chart, ...]]
    checked: Callable[[str, Frame, Mapping[str, Any], Mapping[str, Any]], Frame]
    truth: Callable[[str | None, Mapping[str, Any]], Traces]
    match: Callable[[Mapping[str, Any], Traces], None] = _any_will_do
    brought: Callable[[Mapping[str, Any]], Brought | None] = _brings_nothing
    handout: Callable[[Brought | None], Handout] = _nothing_more
    model: str = ""
    points_to: Mapping[str, str] = field(default_factory=dict)
    calls: Mapping[str, str] = field(default_factory=dict)
    waits_for: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Callable[[Reader, Node | None, Path], Any]] = field(default_factory=dict)
    libraries: tuple[str, ...] = ()
    recorder: str = ""
    depends_on: tuple[str, ...] = ("numpy",)
    same_for_all: frozenset[str] = frozenset()

    def __reduce__(self) -> tuple[Callable[[str], Lab], tuple[str]]:
        """It travels by its name: another process, on another machine perhaps, has it in another folder."""
        return lab_of, (self.module,)

    @cached_property
    def folder(self) -> Path:
        """Where its checks, mistakes, stand-ins and starter files lie."""
        return Path(str(importlib.import_module(self.module).__file__)).parent

    @cached_property
    def homes(self) -> Mapping[str, str]:
        """Every name that the lab asks for, with the file that it is expected in."""
        return {name: part.home for part in (*self.parts, *self.bonuses) for name in part.names}

    @cached_property
    def files(self) -> tuple[str, ...]:
        """The files that are asked for, in the sheet's order."""
        return tuple(dict.fromkeys(part.home for part in self.parts))

    @cached_property
    def pictures(self) -> tuple[str, ...]:
        return tuple(picture for part in self.parts for picture in part.pictures)

    @cached_property
    def examined(self) -> tuple[str, ...]:
        """The parts in the order in which they are examined; bonuses come after them."""
        return tuple(part.id for part in sorted(self.parts, key=lambda part: not part.needed))

    @cached_property
    def titles(self) -> Mapping[str, str]:
        return {part.id: part.title for part in (*self.parts, *self.bonuses)}

    def part(self, id_: str) -> Part | None:
        """The part or bonus with this id, if there is one."""
        return next((part for part in (*self.parts, *self.bonuses) if part.id == id_), None)

    def name_of(self, check_id: str) -> str:
        """The name that the lab asks for and that this check is about."""
        part = self.part(check_id.partition(".")[0])
        return self.points_to.get(check_id) or (part.names[0] if part and part.names else "")

    def call_of(self, check_id: str) -> str:
        """The line that calls what this check is about; empty where there is none."""
        part, name = self.part(check_id.partition(".")[0]), self.name_of(check_id)
        return self.calls.get(name, "") if part and name in part.names else ""

    def standin(self, name: str, lab_configuration: Mapping[str, Any]) -> str:
        """The text of the sound stand-in for a name, where the sandbox is furnished so: ``FURNITURE_IMU`` is its ``imu``."""
        text = (self.folder / "standins" / f"{name}.txt").read_text(encoding="utf-8")
        return _FURNITURE.sub(lambda found: repr(lab_configuration[found[1].lower()]), text)


def lab_of(module: str) -> Lab:
    """The lab that a module holds."""
    lab: Lab = importlib.import_module(module).LAB
    return lab
