"""Repeat the calls of one check of a submission as a program with an array file, for `imugrade repro`."""

from __future__ import annotations

import importlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grader.base.errors import RequestError
from grader.base.files import seen_from, write_whole
from grader.base.text import printable
from grader.engine.check_runner import Judgement, session
from grader.engine.lab import Lab
from grader.engine.lab_sandbox import open_sandbox_for
from grader.engine.rubric import Rubric
from grader.intake import Submission, read_submission
from grader.intake.names import HOME_VERSIONS

FOLDER = HOME_VERSIONS[0]
"""The folder in a submission that `repro` writes to. git and the grader ignore it, but for the versions that `check` writes."""


def folder_in(path: Path) -> Path:
    """Make and return `.imugrade`, the folder in a submission for files of `imugrade repro` and `check`, with a `.gitignore`.

    RequestError if `path` is no folder, or something else has this name.
    """
    place = path / FOLDER
    if place.is_symlink() or (place.exists() and not place.is_dir()) or not path.is_dir():
        raise RequestError(f"{printable(str(place), 500)} is not a folder of imugrade; choose another folder with -o")
    place.mkdir(exist_ok=True)
    write_whole(place / ".gitignore", f"*\n!{HOME_VERSIONS[1]}\n")
    return place


def write(rubric: Rubric, check_id: str, path: Path, out: Path, isolation_level: str | None = None) -> Path:
    """Run checks on the submission in folder `path`; write a program into `out` that repeats one check's calls of student code.

    `isolation_level` None takes the best level of the sandbox that works here.

    Returns
    -------
    The path of the program; the arrays that it reads lie beside it.

    Raises
    ------
    RequestError
        If there is no such check, `path` is no folder, or the check called no Python file of the submission.
    """
    if check_id not in (weight.id for weight in rubric.checks):
        raise RequestError(f"{printable(check_id)}: no check has this id; imugrade explain lists them")
    if not path.is_dir():
        raise RequestError(
            f"{printable(str(path), 500)} is not a folder; unpack the archive, so that Python can import the files"
        )
    submission = read_submission(path, rubric.lab.files)
    student, judgements = recorded_calls(rubric, submission, isolation_level, check_id.partition(".")[0])
    questions = [each for each in student.questions(check_id) if str(each.fields["path"]).endswith(".py")]
    if not questions:
        raise RequestError(f"{check_id} called no .py file here, so there is nothing to reproduce")
    feedback = judgements[check_id].feedback
    said = feedback.message if feedback and feedback.message else "All of it is earned."
    folder = seen_from(out, path / submission.folder)
    return write_program(
        out,
        _repeating(rubric.lab).program(check_id, said, questions, folder),
        questions,
        {rubric.lab.model: student.robot.xml},
    )


def write_program(out: Path, text: str, questions: Sequence[Any], beside: Mapping[str, str]) -> Path:
    """Write the program `text` into `out` as `repro.py`, and beside it the files that it needs; return the program's path.

    `questions` are recorded calls of student code, which the program repeats: their arrays go into `repro.npz`. `beside` maps paths
    below `out` to texts of other files, such as the robot model that student code loads. RequestError if a folder below `out` is a
    link: a submission could lead the files elsewhere.
    """
    for folder in {parent for name in beside for parent in Path(name).parents}:
        if folder.parts and (out / folder).is_symlink():
            place = printable(str(out / folder), 500)
            raise RequestError(f"{place} is a link; remove it, or choose another folder with -o")
    write_whole(out / "repro.npz", _archive(questions))
    for name, content in {**beside, "repro.py": text}.items():
        write_whole(out / name, content)
    return out / "repro.py"


def recorded_calls(
    rubric: Rubric, submission: Submission, isolation_level: str | None = None, until: str | None = None
) -> tuple[Any, Mapping[str, Judgement]]:
    """Run checks on the public scenarios and record their calls of student code; return the recorder, and judgements by check id.

    The recorder is the lab's `Recorder`, a sandbox session, closed on return; its `questions(check_id)` returns a check's calls.
    `until` is the last criterion to run; None runs all. `isolation_level` None takes the best level of the sandbox that works here.
    """
    limits = {"call_cpu_s": rubric.limits.call_cpu_s, "submission_cpu_s": rubric.limits.submission_cpu_s}
    lab = rubric.lab
    truth = lab.truth(None, rubric.settings)
    with open_sandbox_for(lab, submission.files, isolation_level) as sandbox:
        student = _repeating(lab).Recorder(
            sandbox, lab, submission.files, truth=truth, above=submission.above, **limits
        )
        check_run = _repeating(lab).Watched(lab, student, truth, until)
        try:
            session(lab, rubric.own_checks).run(check_run)
        finally:
            student.close()
    return student, check_run.judgements


def _repeating(lab: Lab) -> Any:
    """Return the lab's module that records calls and writes them as a program; raise RequestError if the lab has none."""
    if not lab.repeating:
        raise RequestError(f"{lab.label} has no programs that repeat its calls")
    return importlib.import_module(lab.repeating)


def _archive(questions: Sequence[Any]) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **{name: array for each in questions for name, array in each.kept.items()})
    return stream.getvalue()
