"""Grading of single submissions, such as repaired copies, by the settings that their class was graded by."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from grader.course.record import class_settings
from grader.course.repairs.making import GradingSettings
from grader.course.run import classroom
from grader.engine.lab import Lab


def settings_on_record(lab: Lab, out: Path, secret: str | None, *, trusted: bool = False) -> GradingSettings:
    """Return the settings to grade repaired copies by: those stored for the class in the folder `out`, else the lab's defaults.

    `secret` makes the class's hidden scenarios; None for public ones. `trusted` allows code to run where nothing isolates it.

    Raises
    ------
    RequestError
        If the class was graded on hidden scenarios and there is no secret, or one that makes other scenarios.
    """
    settings = classroom.on_record(out)
    class_settings.refuse_without_secret(settings, secret)
    rubric = class_settings.rubric_of(lab, settings)
    traces = lab.truth(secret, rubric.settings)
    class_settings.refuse_other_scenarios(settings, traces)
    level = settings.isolation if settings else ""
    return GradingSettings(rubric, traces, partial(classroom.guarded_marker, rubric, traces, None, trusted, level))
