"""Definition of a lab for the lab-independent engine: its criteria, required names and files, and the lab's own functions.

Code that lists criteria, names, files or pictures takes them from one `Lab`. A `Rubric` holds its lab.
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
    """A part of a lab that is graded: a criterion or an extension (bonus).

    Attributes
    ----------
    id, title : id and title in the rubric and on all pages
    names : the functions or classes that a submission must define for it; feedback that names no line points to the first name
    home : the file in which the lab expects the names
    needed : whether other parts use its names. Such a part is graded before the others, and if it lost points, correct code
        (stand-ins) replaces its names for the parts that follow
    pictures : the pictures that are handed in for it
    """

    id: str
    title: str
    names: tuple[str, ...]
    home: str
    needed: bool = True
    pictures: tuple[str, ...] = ()

    def attempted_in(self, files: Mapping[str, bytes]) -> bool:
        """Return whether a submission holds the part's file or defines one of its names. Only text is searched, no code is run."""
        return self.home in files or self.named_in(files)

    def named_in(self, files: Mapping[str, bytes]) -> bool:
        """Return whether program text defines one of the part's names, or a cell writes its file. A file alone is not enough."""
        names = "|".join(self.names)
        pattern = rf"(?:\b|\\n)(?:class|def)[ \t]+(?:{names})\b|%%writefile[ \t]+{self.home}"
        defines = re.compile(pattern.encode())
        return any(defines.search(content) for path, content in files.items() if path.endswith((".py", ".ipynb")))


@dataclass(frozen=True)
class LabFile:
    """A file of the instructor's, such as a robot model, that a rubric names in place of the lab's.

    `file` is its name, `text` its content, `traces` the public ground truth (`Traces`) recorded with it. `keys` is the path of
    rubric keys to the line that names it, such as ``("model", "path")``.
    """

    traces: Traces
    keys: tuple[str, ...]
    file: str
    text: str


@dataclass(frozen=True)
class Handout:
    """Files and names that `imugrade kit` gives students beside the starter files.

    `files` are the extra files by path. `names` maps strings in the starter files, such as the lab sheet's sensor names, to
    their replacements, such as the sensor names of the class's robot.
    """

    files: Mapping[str, bytes] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Lab:
    """Definition of one lab: what it asks for, and the functions with which the engine and the commands grade it.

    Attributes
    ----------
    module : the module that holds this value as `LAB`; another process imports it from there
    id, label, title : ``imu``, ``Lab 04-01``, ``Reading IMU data in MuJoCo``
    parts, bonuses : the criteria in the lab sheet's order, and the extensions for advanced students
    model : the path of the model file that the sheet's code loads; "" if it loads none
    points_to : by check id, the required name that feedback points to; for a check that is not listed, the first name of its part
    calls : by required name, the source line that calls it, which reports show beside `imugrade repro`; a name may have none
    waits_for : by operation of the sandbox, such as ``read``, the function of the student's named in "Waiting for ..." messages
    settings : the rubric keys of this lab, each with a function that returns its value; the function gets the file's reader, the
        key's node (None if the key is left out) and the folder that relative paths start from
    plot : draws traces, and a submission's recordings over them, into a folder for `imugrade traces plot`; returns the files
    recordings : returns a submission's recordings by scenario, to plot; calls its last argument with why a recording is missing
    repeating : name of the module that records a submission's calls and writes the programs of `imugrade repro`; "" without one
    packages : packages that students may import, and whose versions the students' kit pins
    suffixes : suffixes of those files of a submission, code and data, that are copied into the sandbox
    libraries : slow modules of `packages` that only some submissions import; the sandbox imports each once for a whole class
    recorder : module that ``python -m`` runs to record ground truth; "" if the lab ships public ground truth alone
    depends_on : packages whose versions may change computed numbers; results name the versions, and ground truth is cached by them
    same_for_all : scenarios that do not count as hidden, because the numbers in them are the same for every secret (see `truth`)
    student : makes the sandbox session of a submission, through which checks call the student's code
    charts : makes the charts of a report from that session and the traces
    checked : returns a reply of the sandbox if it is valid for the request that was sent; else raises Malformed
    truth : returns the traces to grade with, from a rubric's settings and the instructor's secret: hidden traces, whose scenarios
        the secret seeds; the public traces if it is None
    match : raises RubricError for traces that do not belong to the settings of a rubric
    brought : returns the instructor's file that a rubric's settings name in place of one of the lab's, None if they name none
    blind_spot : returns what grading with given traces cannot test, in a sentence; "" for nothing
    handout : makes the extra files for students from the file that `brought` returned; None stands for the lab's own file
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
    match: Callable[[Mapping[str, Any], Traces], None] = lambda settings, traces: None
    brought: Callable[[Mapping[str, Any]], LabFile | None] = lambda settings: None
    handout: Callable[[LabFile | None], Handout] = lambda own: Handout()
    blind_spot: Callable[[Traces], str] = lambda traces: ""
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
        ".py", ".ipynb", ".csv", ".txt", ".json", ".yaml", ".yml", ".toml", ".ini", ".cfg", ".npy", ".npz",
    )  # fmt: skip
    libraries: tuple[str, ...] = ()
    recorder: str = ""
    depends_on: tuple[str, ...] = ("numpy",)
    same_for_all: frozenset[str] = frozenset()

    def __reduce__(self) -> tuple[Callable[[str], Lab], tuple[str]]:
        """Pickle the lab by its module's name: in another process or on another machine its folder may differ."""
        return lab_of, (self.module,)

    @cached_property
    def folder(self) -> Path:
        """The folder with the lab's checks, fault table, stand-ins and starter files."""
        return Path(str(importlib.import_module(self.module).__file__)).parent

    @property
    def slug(self) -> str:
        """The label as a folder's name, ``lab-04-01``, in which a submission's files lie in the sandbox."""
        return self.label.lower().replace(" ", "-")

    @cached_property
    def homes(self) -> Mapping[str, str]:
        """The names that a submission must define, those of extensions included, each with the file in which it is expected."""
        return {name: part.home for part in (*self.parts, *self.bonuses) for name in part.names}

    @cached_property
    def files(self) -> tuple[str, ...]:
        """The programs that the lab asks for, in the sheet's order; those of extensions are not included."""
        return tuple(dict.fromkeys(part.home for part in self.parts))

    @cached_property
    def pictures(self) -> tuple[str, ...]:
        return tuple(picture for part in self.parts for picture in part.pictures)

    @cached_property
    def examined(self) -> tuple[str, ...]:
        """The ids of the criteria, without the extensions, in the order of grading."""
        return tuple(part.id for part in sorted(self.parts, key=lambda part: not part.needed))

    @cached_property
    def titles(self) -> Mapping[str, str]:
        return {part.id: part.title for part in (*self.parts, *self.bonuses)}

    def part(self, id_: str) -> Part | None:
        """Return the criterion or extension with this id; None if there is none."""
        return next((part for part in (*self.parts, *self.bonuses) if part.id == id_), None)

    def name_of(self, check_id: str) -> str:
        """Return the required name that a check is about, to point to its line; "" if its criterion or extension requires none."""
        part = self.part(check_id.partition(".")[0])
        return self.points_to.get(check_id) or (part.names[0] if part and part.names else "")

    def call_of(self, check_id: str) -> str:
        """Return the source line that calls the name that a check is about, for `imugrade repro`; "" if the lab has none for it."""
        part, name = self.part(check_id.partition(".")[0]), self.name_of(check_id)
        return self.calls.get(name, "") if part and name in part.names else ""

    def standin(self, name: str, lab_configuration: Mapping[str, Any]) -> str:
        """Return the source of a name's stand-in: correct code that replaces a broken definition; FileNotFoundError if it has none.

        Each ``CONFIGURATION_KEY`` in it becomes the value of ``key`` in `lab_configuration`, the settings that the worker gets:
        ``CONFIGURATION_IMU`` becomes the class's sensor names, as Python code. A key that is not set raises KeyError.
        """
        text = (self.folder / "standins" / f"{name}.txt").read_text(encoding="utf-8")
        return _CONFIGURATION.sub(lambda found: repr(lab_configuration[found[1].lower()]), text)

    def sheets_own(self, name: str) -> str:
        """Return source to replace a student's `name`: the sheet's ``import`` (not ``from``) lines and its definition, if any."""
        tree = ast.parse((self.folder / "sheet.txt").read_text(encoding="utf-8"))
        imports = [node for node in tree.body if isinstance(node, ast.Import)]
        own = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name]
        return "\n".join(map(ast.unparse, [*imports, *own]))


def lab_of(module: str) -> Lab:
    """Import a module and return its `LAB`, so that another process gets the same lab."""
    lab: Lab = importlib.import_module(module).LAB
    return lab
