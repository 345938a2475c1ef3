"""Writing the kits: for students, for Gradescope, for Classroom 50, for GitHub and for GitLab."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader import __version__
from grader.base import class_versions
from grader.base.errors import RequestError
from grader.base.package_data import beside
from grader.base.text import printable
from grader.engine.lab import Handout, Lab, LabFile
from grader.engine.rubric import load
from grader.engine.rubric import shipped as shipped_rubric
from grader.engine.traces import Traces
from grader.kit import guide, wheel
from grader.platforms.github import CHECKOUT, SETUP_PYTHON
from grader.report import truth

_READABLE = "public scenarios: the job runs in the student's repository"
_FIELDS = {"wheel": wheel.name(), "version": __version__, "checkout": CHECKOUT, "setup_python": SETUP_PYTHON}
_EDITORS = {
    ".devcontainer/devcontainer.json": "devcontainer.json.txt",
    ".vscode/settings.json": "settings.json.txt",
    ".vscode/tasks.json": "tasks.json.txt",
}


@dataclass(frozen=True)
class Kit:
    """A kit that was written: its place, its platform or "students", and the scenarios that it grades with."""

    place: Path
    title: str
    scenarios: str


@dataclass(frozen=True)
class KitRequest:
    """The kits to write, each with its folder, or None if it is not wanted. `hidden` traces go into the Gradescope kit alone."""

    lab: Lab
    student: Path | None = None
    gradescope: Path | None = None
    classroom50: Path | None = None
    github: Path | None = None
    gitlab: Path | None = None
    rubric: Path | None = None
    hidden: Traces | None = None


def kits(request: KitRequest) -> Iterator[Kit]:
    """Write the requested kits one after the other."""
    if request.student is not None:
        yield student(request.lab, request.student, request.rubric)
    if request.gradescope is not None:
        yield gradescope(request.lab, request.gradescope, request.rubric, request.hidden)
    if request.classroom50 is not None:
        yield classroom50(request.lab, request.classroom50, request.rubric)
    if request.github is not None:
        yield github(request.lab, request.github, request.rubric)
    if request.gitlab is not None:
        yield gitlab(request.lab, request.gitlab, request.rubric)


def student(lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Write starter files, what the lab hands out beside them, a README, the guide and the wheel into a new folder.

    Raises
    ------
    RequestError
        If the folder has something in it: a student's work must not be overwritten.
    """
    _refuse_full(out)
    brought = _brought(lab, rubric)
    handout = lab.handout(brought)
    files = {name: _named_after(handout, _starter(lab, name)).encode() for name in (*lab.files, "README.md")}
    files |= {path: _text(f"students/{source}").encode() for path, source in _EDITORS.items()}
    files[class_versions.FILE] = _constraints(lab)
    files[guide.NAME] = guide.build(lab, rubric).encode()
    files |= {**handout.files, wheel.name(): wheel.build(lab, rubric or shipped_rubric(lab), brought)}
    _write(out, files)
    return Kit(out, "students", "public scenarios")


def classroom50(lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Write `autograder.py` and the wheel, for ``CLASSROOM/autograders/ASSIGNMENT``."""
    _refuse_full(out)
    program = _text("platforms/autograder.py.txt").encode()
    files = {"autograder.py": program, class_versions.FILE: _constraints(lab), wheel.name(): _wheel(lab, rubric)}
    _write(out, files)
    return Kit(out, "Classroom 50", _READABLE)


def github(lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Return the kit for GitHub: a workflow and the wheel, for the root of the repository that students start from."""
    workflow = _text("platforms/imugrade.yml.txt").encode()
    _beside_others(out, {".github/workflows/imugrade.yml": workflow, **_installed(".github/imugrade", lab, rubric)})
    return Kit(out, "GitHub Actions", _READABLE)


def gitlab(lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Return the kit for GitLab: a pipeline and the wheel, for the root of the repository that students start from."""
    pipeline = _text("platforms/gitlab.yml.txt").encode()
    _beside_others(out, {".gitlab-ci.yml": pipeline, **_installed(".gitlab/imugrade", lab, rubric)})
    return Kit(out, "GitLab CI", _READABLE)


def gradescope(lab: Lab, out: Path, rubric: Path | None = None, hidden: Traces | None = None) -> Kit:
    """Write `autograder.zip`: `setup.sh` and `run_autograder` at its root, the wheel, and hidden traces if they are given."""
    traces = {} if hidden is None else _bundle(hidden)
    options = ' --traces "$ROOT/source/hidden.npz"' if traces else ""
    files = {
        "setup.sh": _text("platforms/setup.sh.txt").encode(),
        "run_autograder": _text("platforms/run_autograder.txt").replace("{options}", options).encode(),
        class_versions.FILE: _constraints(lab),
        wheel.name(): _wheel(lab, rubric),
        **traces,
    }
    if out.exists():
        raise RequestError(f"{printable(str(out))}: it is there already; remove it or choose another name")
    _write(out.parent, {out.name: wheel.pack(files, ("setup.sh", "run_autograder"))})
    return Kit(out, "Gradescope", "hidden scenarios" if traces else "public scenarios: no seed was given")


def _installed(folder: str, lab: Lab, rubric: Path | None) -> dict[str, bytes]:
    """Return what a platform installs from a folder: the wheel, and the versions of the class."""
    return {f"{folder}/{wheel.name()}": _wheel(lab, rubric), f"{folder}/{class_versions.FILE}": _constraints(lab)}


def _constraints(lab: Lab) -> bytes:
    return class_versions.constraints(lab.packages).encode()


def _wheel(lab: Lab, rubric: Path | None) -> bytes:
    return wheel.build(lab, rubric or shipped_rubric(lab), _brought(lab, rubric))


def _brought(lab: Lab, rubric: Path | None) -> LabFile | None:
    return lab.brought(load(lab, rubric).settings)


def _named_after(handout: Handout, text: str) -> str:
    """Return a starter file with the names of the sheet (robot, sensors) replaced by those of the kit."""
    for sheet, name in handout.names.items():
        text = text.replace(f'"{sheet}"', json.dumps(name, ensure_ascii=False))
    return text


def _starter(lab: Lab, name: str) -> str:
    return _filled(lab.folder / "starter" / f"{name}.txt")


def _text(path: str) -> str:
    return _filled(beside(__package__, path))


def _filled(file: Path) -> str:
    text = file.read_text(encoding="utf-8")
    for field, value in _FIELDS.items():
        text = text.replace(f"{{{field}}}", value)
    return text


def _bundle(hidden: Traces) -> dict[str, bytes]:
    """Return the recorded bundle instead of the seed, because the seed cannot be derived from it."""
    return {f"hidden{suffix}": content for suffix, content in truth.files(hidden).items()}


def _refuse_full(out: Path) -> None:
    """Raise RequestError if the folder is not empty, so that no student's work is overwritten."""
    try:
        taken = out.is_dir() and any(out.iterdir())
    except OSError as problem:
        raise RequestError(
            f"{printable(str(out))}: cannot read it ({problem.strerror}); choose another place"
        ) from None
    if taken:
        raise RequestError(
            f"{printable(str(out))}: the folder is not empty; choose a new one, so nothing is overwritten"
        )


def _beside_others(out: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a folder that may hold others; RequestError, and nothing written, if one of them exists."""
    for path in files:
        if (out / path).exists():
            raise RequestError(f"{printable(str(out / path))}: it is there already; remove it or choose another folder")
    _write(out, files)


def _write(out: Path, files: Mapping[str, bytes]) -> None:
    """Write files below a folder; refuse the request if one cannot be written."""
    for path, content in files.items():
        place = out / path
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        except OSError as problem:
            reason = problem.strerror or problem
            raise RequestError(f"{printable(str(place))}: cannot write it: {reason}; choose another place") from problem
