"""Grading of single files' repairs by the settings that a class on record was graded by."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from grader.course import class_settings, classroom
from grader.course.repairs import Grading
from grader.engine.lab import Lab


@contextmanager
def grading(lab: Lab, out: Path, secret: str | None, *, trusted: bool = False) -> Iterator[Grading]:
    """Open what grades a submission as the class in OUT was graded.

    Raises
    ------
    RequestError
        If the class was graded on hidden scenarios and there is no secret, or nothing isolates students' code here.
    """
    settings = classroom.on_record(out)
    class_settings.refuse_without_secret(settings, secret)
    rubric = class_settings.rubric_of(lab, settings)
    traces = lab.truth(secret, rubric.settings)
    level = settings.isolation if settings else ""
    with classroom.guarded_marker(rubric, traces, None, trusted, level) as marker:
        yield Grading(rubric, traces, marker.mark)
