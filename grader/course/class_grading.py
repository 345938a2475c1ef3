"""Grading of single submissions by the settings that a class on record was graded by."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from grader.course import class_settings, classroom
from grader.course.pool import OpenMarker
from grader.course.repairs import Grading
from grader.engine.lab import Lab
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces


@dataclass(frozen=True)
class GradingSettings:
    """Rubric and traces of a class, and a picklable function that opens a sandboxed marker with them."""

    rubric: Rubric
    traces: Traces
    open_marker: OpenMarker


def settings_on_record(lab: Lab, out: Path, secret: str | None, *, trusted: bool = False) -> GradingSettings:
    """Return the rubric, traces and marker that graded the class in OUT.

    Raises
    ------
    RequestError
        If the class was graded on hidden scenarios and there is no secret.
    """
    settings = classroom.on_record(out)
    class_settings.refuse_without_secret(settings, secret)
    rubric = class_settings.rubric_of(lab, settings)
    traces = lab.truth(secret, rubric.settings)
    level = settings.isolation if settings else ""
    return GradingSettings(rubric, traces, partial(classroom.guarded_marker, rubric, traces, None, trusted, level))


@contextmanager
def grading(lab: Lab, out: Path, secret: str | None, *, trusted: bool = False) -> Iterator[Grading]:
    """Open a sandboxed marker in this process, with the rubric and traces that graded the class in OUT.

    Raises
    ------
    RequestError
        If the class was graded on hidden scenarios and there is no secret, or if nothing isolates students' code here.
    """
    made = settings_on_record(lab, out, secret, trusted=trusted)
    with made.open_marker() as marker:
        yield Grading(made.rubric, made.traces, marker.mark)
