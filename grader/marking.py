"""One submission: a conversation with the box and a pytest session make a `Result`."""

from __future__ import annotations

import platform
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from types import TracebackType
from typing import Any

from . import __version__, exhibits
from .conversation import SEED
from .evidence import Evidence, packed
from .fingerprint import fingerprint
from .intake import Submission
from .lab_box import open_box
from .plugin import Check, Examination, Judgement, known_checks, session
from .results import CheckResult, CriterionResult, ExtensionResult, Result, Status
from .rubric import CheckWeight, Criterion, Extension, Rubric, match_checks
from .sandbox.box import Box
from .student import Student
from .student_extensions import EXTENSIONS, attempts
from .text import printable
from .traces import Traces


class Marker:
    """A warm marker: one zygote, the rubric and the truth. One per process.

    Parameters
    ----------
    rubric, traces : what is asked, and what is true
    rung : of the box; the best that this machine allows if None
    box : one that was opened before, and is closed with the marker

    Raises
    ------
    RubricError
        Where rubric and checks do not match.
    GraderError
        Where no box can be opened.
    """

    def __init__(self, rubric: Rubric, traces: Traces, *, rung: str | None = None, box: Box | None = None) -> None:
        self._rubric, self._traces = rubric, traces
        self._box = box or open_box(rung)  # it warms up while the checks are collected
        try:
            self._checks: Mapping[str, Check] = known_checks()
            match_checks(rubric, {check_id: check.title for check_id, check in self._checks.items()})
        except BaseException:
            self._box.close()
            raise

    @property
    def isolation(self) -> str:
        return self._box.rung

    def __enter__(self) -> Marker:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        self._box.close()

    def mark(self, submission: Submission, *, only: str | None = None) -> Result:
        """Grade one submission; never raises for what a student did."""
        started = time.perf_counter()
        if submission.status != "ready":
            return self._result(submission, submission.status, {}, [], started, only)
        student = Student(
            self._box,
            submission.files,
            above=submission.above,
            lab_model=self._traces.models["lab"],
            call_cpu_s=self._rubric.limits.call_cpu_s,
            submission_cpu_s=self._rubric.limits.submission_cpu_s,
        )
        examination = Examination(student, self._traces, only)
        try:
            session().run(examination)
        finally:
            student.close()
        result = self._result(submission, "graded", examination.judgements, student.notes, started, only)
        return replace(result, evidence=self._evidence(student))

    def _evidence(self, student: Student) -> Evidence:
        """It decides nothing: where it cannot be gathered, the marks stand without it."""
        try:
            return Evidence(packed(exhibits.charts(student, self._traces)), fingerprint(student.files))
        except Exception:  # numbers of a student's that nobody has thought of
            return Evidence()

    def _result(
        self, submission: Submission, status: Status, judgements: Mapping[str, Judgement], notes: list[str], started: float,
        only: str | None,
    ) -> Result:  # fmt: skip
        criteria = tuple(self._criterion(c, judgements, status) for c in self._rubric.criteria if only in (None, c.id))
        extensions = tuple(
            self._extension(e, submission, judgements, status) for e in self._rubric.extensions if only in (None, e.id)
        )
        parts: tuple[CriterionResult | ExtensionResult, ...] = (*criteria, *extensions)
        unjudged = any(check.outcome == "not_judged" for part in parts for check in part.checks)
        return Result(
            submission=submission.name,
            status="incomplete" if unjudged else status,
            criteria=criteria,
            extensions=extensions,
            extra_credit_cap=self._rubric.extra_credit_cap,
            notes=(*submission.notes, *notes),
            provenance=self._provenance(submission),
            duration_s=round(time.perf_counter() - started, 4),
        )

    def _criterion(self, criterion: Criterion, judgements: Mapping[str, Judgement], status: Status) -> CriterionResult:
        rows = tuple(self._row(weight, judgements.get(weight.id), status) for weight in criterion.checks)
        return CriterionResult(criterion.id, criterion.title, criterion.points, rows)

    def _extension(
        self, extension: Extension, submission: Submission, judgements: Mapping[str, Judgement], status: Status
    ) -> ExtensionResult:
        """An extension that was not attempted has no rows: nothing was asked about it."""
        attempted = status not in _NOTHING and attempts(submission.files, EXTENSIONS[extension.id])
        weights = extension.checks if attempted else ()
        rows = tuple(self._row(weight, judgements.get(weight.id), status) for weight in weights)
        return ExtensionResult(extension.id, attempted, extension.points, rows)

    def _row(self, weight: CheckWeight, judgement: Judgement | None, status: Status) -> CheckResult:
        check = self._checks[weight.id]
        head: dict[str, Any] = {
            "id": weight.id,
            "title": check.title,
            "max_points": weight.max_points,
            "lab_step": check.lab_step,
        }
        if judgement is None and status in ("empty", "unreadable"):
            return CheckResult(outcome="skipped", points=0.0, message=_NOTHING[status], **head)
        if judgement is None or judgement.told is None:
            trouble = judgement.trouble if judgement else "the check did not run"
            message = f"Not judged, through a fault of the grader: {printable(trouble, 300)}"
            return CheckResult(outcome="not_judged", points=None, message=message, **head)
        told = judgement.told
        return CheckResult(
            outcome=told.outcome,
            points=round(weight.max_points * told.keeps, 2),
            message=told.message,
            hint=told.hint,
            misconceptions=told.mistakes,
            duration_s=round(judgement.duration_s, 4),
            **head,
        )

    def _provenance(self, submission: Submission) -> dict[str, Any]:
        return {
            "grader": __version__,
            "rubric_sha256": self._rubric.sha256,
            "traces_sha256": self._traces.sha256,
            "submission_sha256": submission.sha256,
            "python": platform.python_version(),
            "mujoco": _version("mujoco"),
            "numpy": _version("numpy"),
            "isolation": self._box.rung,
            "seed": SEED,
        }


@cache
def _version(package: str) -> str:
    """Of what the workers import; this process does without mujoco, which is slow to import."""
    return version(package)


_NOTHING = {
    "empty": "Nothing recognisable was handed in: no Python file and no notebook was found.",
    "unreadable": "The archive could not be read.",
}
