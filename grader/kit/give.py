"""Write the kits of `imugrade kit`: for students, Gradescope, Classroom 50, GitHub and GitLab."""

from __future__ import annotations

import json
from collections.abc import Mapping
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
from grader.report import truth, words

_FIELDS = {"wheel": wheel.name(), "version": __version__, "checkout": CHECKOUT, "setup_python": SETUP_PYTHON}
_EDITORS = {
    ".devcontainer/devcontainer.json": "devcontainer.json.txt",
    ".vscode/settings.json": "settings.json.txt",
    ".vscode/tasks.json": "tasks.json.txt",
}


@dataclass(frozen=True)
class Kit:
    """Report on a kit that `imugrade kit` wrote, for students or for a platform that grades; the command prints it.

    `place` is the path of the kit's folder or archive, `title` the platform or "students". `scenarios` says whether grading with
    the kit uses public scenarios, whose ground truth students can read, or hidden ones.
    """

    place: Path
    title: str
    scenarios: str


_JOBS = {
    "classroom50": ("Classroom 50", "autograder.py", "platforms/autograder.py.txt", ""),
    "github": ("GitHub Actions", ".github/workflows/imugrade.yml", "platforms/imugrade.yml.txt", ".github/imugrade/"),
    "gitlab": ("GitLab CI", ".gitlab-ci.yml", "platforms/gitlab.yml.txt", ".gitlab/imugrade/"),
}
"""Platforms whose job runs in the student's repository: title, file of the job, its template, folder of the wheel."""


def job(platform: str, lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Write a platform's CI job, the grader's wheel and a pip constraints file into the folder `out`; return the report.

    `platform` is classroom50, github or gitlab; `rubric` goes into the wheel, None: the shipped one. Other files stay.
    The constraints pin the lab's packages to the versions installed here, so that the job installs the same.

    Raises
    ------
    RequestError
        If one of the files exists (nothing is written then) or cannot be written.
    """
    title, path, template, folder = _JOBS[platform]
    files = {path: _text(template).encode(), f"{folder}{wheel.name()}": _wheel(lab, rubric)}
    files[f"{folder}{class_versions.FILE}"] = _constraints(lab)
    for each in files:
        if (out / each).exists():
            raise RequestError(f"{printable(str(out / each))}: it is there already; remove it or choose another folder")
    _write(out, files)
    return Kit(out, title, "public scenarios: the job runs in the student's repository")


def student(lab: Lab, out: Path, rubric: Path | None = None) -> Kit:
    """Write starters, the lab's extra files, editor settings, guide and wheel into the new folder `out`; return the report.

    `rubric` goes into guide and wheel; None takes the shipped one.

    Raises
    ------
    RequestError
        If the folder has something in it, as a student's work must not be overwritten, or if a file cannot be written.
    """
    _refuse_full(out)
    brought = _brought(lab, rubric)
    handout = lab.handout(brought)
    starters = {name: _filled(lab.folder / "starter" / f"{name}.txt") for name in (*lab.files, "README.md")}
    files = {name: _named_after(handout, text).encode() for name, text in starters.items()}
    files |= {path: _text(f"students/{source}").encode() for path, source in _EDITORS.items()}
    files[class_versions.FILE] = _constraints(lab)
    files[words.GUIDE] = guide.build(lab, rubric).encode()
    files |= {**handout.files, wheel.name(): wheel.build(lab, rubric or shipped_rubric(lab), brought)}
    _write(out, files)
    return Kit(out, "students", "public scenarios")


def gradescope(lab: Lab, out: Path, rubric: Path | None = None, hidden: Traces | None = None) -> Kit:
    """Write Gradescope's archive `out` (two scripts, the grader's wheel, pip constraints as in `job`); return the report on it.

    `rubric` replaces the lab's own in the wheel. `hidden` is ground truth that students do not have: it goes into the archive, and
    grades come from it; None: from the public scenarios.

    Raises
    ------
    RequestError
        If the file exists or cannot be written.
    """
    traces = {} if hidden is None else truth.files(hidden)  # and not the seed, which cannot be derived from them
    options = ' --traces "$ROOT/source/hidden.npz"' if traces else ""
    files = {
        "setup.sh": _text("platforms/setup.sh.txt").encode(),
        "run_autograder": _text("platforms/run_autograder.txt").replace("{options}", options).encode(),
        class_versions.FILE: _constraints(lab),
        wheel.name(): _wheel(lab, rubric),
        **{f"hidden{suffix}": content for suffix, content in traces.items()},
    }
    if out.exists():
        raise RequestError(f"{printable(str(out))}: it is there already; remove it or choose another name")
    _write(out.parent, {out.name: wheel.pack(files, ("setup.sh", "run_autograder"))})
    return Kit(out, "Gradescope", "hidden scenarios" if traces else "public scenarios: no seed was given")


def _constraints(lab: Lab) -> bytes:
    return class_versions.constraints(lab.packages).encode()


def _wheel(lab: Lab, rubric: Path | None) -> bytes:
    return wheel.build(lab, rubric or shipped_rubric(lab), _brought(lab, rubric))


def _brought(lab: Lab, rubric: Path | None) -> LabFile | None:
    return lab.brought(load(lab, rubric).settings)


def _named_after(handout: Handout, text: str) -> str:
    """Return a starter file with the names on the lab sheet (robot, sensors) replaced by those of the class's robot."""
    for sheet, name in handout.names.items():
        text = text.replace(f'"{sheet}"', json.dumps(name, ensure_ascii=False))
    return text


def _text(path: str) -> str:
    return _filled(beside(__package__, path))


def _filled(file: Path) -> str:
    text = file.read_text(encoding="utf-8")
    for field, value in _FIELDS.items():
        text = text.replace(f"{{{field}}}", value)
    return text


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


def _write(out: Path, files: Mapping[str, bytes]) -> None:
    """Write files below a folder; raise RequestError if one cannot be written."""
    for path, content in files.items():
        place = out / path
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        except OSError as problem:
            reason = problem.strerror or problem
            raise RequestError(f"{printable(str(place))}: cannot write it: {reason}; choose another place") from problem
