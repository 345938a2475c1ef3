"""Page to mark a sample on, without a network, and page that compares the marks with our points."""

from __future__ import annotations

from collections.abc import Sequence

from grader.course.calibration.marks import COLUMNS
from grader.course.calibration.sample import Unmarked
from grader.course.calibration.summary import Summary
from grader.engine.results import LabName, Result
from grader.report.pages import rendered


def marking_page(lab: LabName, sample: Sequence[Unmarked], like: Result, rubric: str) -> str:
    """Return the page to mark a sample on. It saves the marks as a CSV file.

    Parameters
    ----------
    like
        Any result of the class: the criteria and checks are its.
    rubric
        The digest of the rubric, as the file keeps it.
    """
    return rendered(
        "marking.html.j2", "marking.js", lab, more_style="marking.css",
        sample=sample, criteria=like.criteria, rubric=rubric, columns=",".join(COLUMNS),
    )  # fmt: skip


def comparison_page(lab: LabName, found: Summary) -> str:
    """Return the page that compares marks with our points."""
    return rendered("calibration.html.j2", None, lab, more_style="marking.css", found=found)
