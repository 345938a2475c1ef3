"""Definition of a lab for the lab-independent engine: its parts, required names and files, and the lab's own functions.

Any code that lists parts, names, files or pictures derives the list from one `Lab`. A rubric holds its lab.
"""

from __future__ import annotations

import ast
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
    from grader.engine.rubric_nodes import NodeReader
    from grader.engine.submission_session import SubmissionSession
    from grader.engine.traces import Traces
    from grader.sandbox.wire import Frame

_CONFIGURATION = re.compile(r"\bCONFIGURATION_([A-Z]+)\b")


@dataclass(frozen=True)
class Part:
    """A graded part of a lab: a criterion, or a bonus.

    Attributes
    ----------
    id, title
        Its id and title in the rubric and on all pages.
    names
        The names that a submission must define for it; a finding without a line of its own points to the first.
    home
        The file in which the lab expects the names.
    needed
        Whether other parts build on its names. Such a part is examined before the others, and if it lost points, sound
        stand-ins replace its names for the parts that follow.
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
        """Return whether the submission holds the part's file or defines one of its names; only text is searched, no code runs."""
        return self.home in files or self.named_in(files)

    def named_in(self, files: Mapping[str, bytes]) -> bool:
        """Return whether a program or notebook defines one of the part's names; only text is searched, no code runs."""
        names = "|".join(self.names)
        pattern = rf"(?:\b|\\n)(?:class|def)[ \t]+(?:{names})\b|%%writefile[ \t]+{self.home}"
        defines = re.compile(pattern.encode())
        return any(defines.search(content) for path, content in files.items() if path.endswith((".py", ".ipynb")))


@dataclass(frozen=True)
class LabFile:
    """A file that a rubric names in place of one of the lab's, with the public traces recorded from it.

    `keys` is the path of rubric keys to the line that names it.
    """

    traces: Traces
    keys: tuple[str, ...]
    file: str
    text: str


@dataclass(frozen=True)
class Handout:
    """Extra files for students beside the starter files, by path, and the names in them that replace the sheet's names."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)


def _no_file(settings: Mapping[str, Any]) -> None:
    """Supply no files: the default of `Lab.brought`."""


def _no_blind_spot(traces: Traces) -> str:
    """Return no warning: the default of `Lab.blind_spot`."""
    return ""


def _no_handout(own: LabFile | None) -> Handout:
    return Handout()


def _accept_all(settings: Mapping[str, Any], traces: Traces) -> None:
    """Accept any traces: the default of `Lab.match`."""


@dataclass(frozen=True, eq=False)
class Lab:
    """Definition of one lab.

    Attributes
    ----------
    module
        The module that holds this value as `LAB`; another process imports it from there.
    id, label, title
        ``imu``, ``Lab 04-01``, ``Reading IMU data in MuJoCo``.
    parts, bonuses
        The criteria in the sheet's order, and the extensions for advanced students.
    model
        The path of the file that the sheet loads; empty if it loads none.
    points_to
        Checks whose findings point to another name than the first of their part, with that name.
    calls
        The source line that calls each name, if `imugrade repro` can write the call.
    waits_for
        Description of a question that takes long, by the question's operation.
    settings
        The rubric keys of this lab, each with the function that reads it from the file's reader, the key's node (None if the key
        is left out) and the folder that relative paths start from.
    plot
        Draws the traces, or a submission's recordings over them, into a folder for `imugrade traces plot`; returns the files.
    recordings
        Asks a submission for its recordings, by scenario; tells why one is missing.
    repeating
        The module with the `Recorder`, `Watched` and `program` of `imugrade repro`.
    packages
        Packages that students may use, and whose versions a class shares.
    suffixes
        The files that a submission is run with, by suffix: code and data.
    libraries
        Modules of these packages that only some submissions import and that take long to import: a class imports each once.
    recorder
        The program that records ground truth, as ``python -m`` names it; not needed for public ground truth.
    depends_on
        Packages whose versions may change a number of the recorder or of a submission.
    same_for_all
        Scenarios in which no secret changes a number.
    student, charts, checked
        Make the session that the checks ask; make the charts of a report; check a reply against its question.
    truth
        Returns the traces to grade with, from a secret (None: the public traces) and the settings of a rubric.
    match
        Raises RubricError for traces that do not belong to the settings.
    brought
        Returns the file that the settings name in place of one of the lab's, which a kit must include; None if there is none.
    blind_spot
        Returns what grading with these traces cannot test, in a sentence; "" for nothing.
    handout
        Makes the extra files for students from that file; None stands for the lab's own.
    """

    module: str
    id: str
    label: str
    title: str
    parts: tuple[Part, ...]
    bonuses: tuple[Part, ...]
    student: Callable[..., SubmissionSession]
    charts: Callable[[Any, Traces], tuple[Chart, ...]]
    checked: Callable[[str, Frame, Mapping[str, Any], Mapping[str, Any]], Frame]
    truth: Callable[[str | None, Mapping[str, Any]], Traces]
    match: Callable[[Mapping[str, Any], Traces], None] = _accept_all
    brought: Callable[[Mapping[str, Any]], LabFile | None] = _no_file
    handout: Callable[[LabFile | None], Handout] = _no_handout
    blind_spot: Callable[[Traces], str] = _no_blind_spot
    model: str = ""
    points_to: Mapping[str, str] = field(default_factory=dict)
    calls: Mapping[str, str] = field(default_factory=dict)
    waits_for: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, Callable[[NodeReader, Node | None, Path], Any]] = field(default_factory=dict)
    plot: Callable[[Traces, Path, Mapping[str, Any] | None], list[Path]] | None = None
    recordings: Callable[[Any, Traces, Callable[[str], None]], Mapping[str, Any]] | None = None
    repeating: str = ""
    packages: tuple[str, ...] = ("numpy", "matplotlib")
    suffixes: tuple[str, ...] = (
        ".py",
        ".ipynb",
        ".csv",
        ".txt",
        ".json",
        ".yaml",
        ".yml",
        ".toml",
        ".ini",
        ".cfg",
        ".npy",
        ".npz",
    )
    libraries: tuple[str, ...] = ()
    recorder: str = ""
    depends_on: tuple[str, ...] = ("numpy",)
    same_for_all: frozenset[str] = frozenset()

    def __reduce__(self) -> tuple[Callable[[str], Lab], tuple[str]]:
        """Pickle the lab by its module's name: in another process or on another machine its folder may differ."""
        return lab_of, (self.module,)

    @cached_property
    def folder(self) -> Path:
        """The folder with its checks, fault table, stand-ins and starter files."""
        return Path(str(importlib.import_module(self.module).__file__)).parent

    @property
    def slug(self) -> str:
        """The label as a name of a folder: ``lab-04-01``."""
        return self.label.lower().replace(" ", "-")

    @cached_property
    def homes(self) -> Mapping[str, str]:
        """The names that a submission must define, each with the file in which it is expected."""
        return {name: part.home for part in (*self.parts, *self.bonuses) for name in part.names}

    @cached_property
    def files(self) -> tuple[str, ...]:
        """The files that the lab asks for, in the sheet's order."""
        return tuple(dict.fromkeys(part.home for part in self.parts))

    @cached_property
    def pictures(self) -> tuple[str, ...]:
        return tuple(picture for part in self.parts for picture in part.pictures)

    @cached_property
    def examined(self) -> tuple[str, ...]:
        """The ids of the parts in the order of grading; bonuses come after them."""
        return tuple(part.id for part in sorted(self.parts, key=lambda part: not part.needed))

    @cached_property
    def titles(self) -> Mapping[str, str]:
        return {part.id: part.title for part in (*self.parts, *self.bonuses)}

    def part(self, id_: str) -> Part | None:
        """Return the part or bonus with this id; None if there is none."""
        return next((part for part in (*self.parts, *self.bonuses) if part.id == id_), None)

    def name_of(self, check_id: str) -> str:
        """Return the required name that a check is about; "" if its part has none."""
        part = self.part(check_id.partition(".")[0])
        return self.points_to.get(check_id) or (part.names[0] if part and part.names else "")

    def call_of(self, check_id: str) -> str:
        """Return the source line that calls the name that a check is about; "" if there is none."""
        part, name = self.part(check_id.partition(".")[0]), self.name_of(check_id)
        return self.calls.get(name, "") if part and name in part.names else ""

    def standin(self, name: str, lab_configuration: Mapping[str, Any]) -> str:
        """Return the source of a name's stand-in (correct code); ``CONFIGURATION_IMU`` there becomes the ``imu`` configuration."""
        text = (self.folder / "standins" / f"{name}.txt").read_text(encoding="utf-8")
        return _CONFIGURATION.sub(lambda found: repr(lab_configuration[found[1].lower()]), text)

    def sheets_own(self, name: str) -> str:
        """Return the sheet's imports and its definition of a name, which, unlike a stand-in, takes only the sheet's arguments."""
        tree = ast.parse((self.folder / "sheet.txt").read_text(encoding="utf-8"))
        imports = [node for node in tree.body if isinstance(node, ast.Import)]
        own = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name]
        return "\n".join(map(ast.unparse, [*imports, *own]))


def lab_of(module: str) -> Lab:
    """Import a module and return its value `LAB`, so that another process gets the same lab."""
    lab: Lab = importlib.import_module(module).LAB
    return lab
