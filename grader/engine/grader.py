"""Grade one submission: run the checks on what its code answers in the sandbox, and make a `Result`."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, cached_property, partial
from importlib.metadata import version
from typing import Any

from grader import __version__
from grader.base.text import printable
from grader.engine.chart_data import Evidence, packed
from grader.engine.check_catalog import Check
from grader.engine.check_runner import CheckRun, Judgement, known_checks, session
from grader.engine.feedback import NOT_UNDERSTOOD
from grader.engine.findings import GraderText
from grader.engine.fingerprint import fingerprint
from grader.engine.lab_sandbox import libraries_of, open_sandbox
from grader.engine.marks import marked
from grader.engine.public_session import PublicSession
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result, Status
from grader.engine.rubric import CheckWeight, Criterion, Extension, Rubric, match_checks
from grader.engine.session import SEED, Listener
from grader.engine.submission_session import SubmissionSession
from grader.engine.traces import Traces
from grader.intake import Submission
from grader.sandbox.isolation_levels import IsolationLevel
from grader.sandbox.sandbox import Sandbox


class Stopped(KeyboardInterrupt):
    """Exception for an interrupt (Ctrl-C) during grading. Its `result` is the result so far; checks not reached have no points."""

    def __init__(self, result: Result) -> None:
        super().__init__()
        self.result = result


class Marker:
    """Grades submissions one after the other, with a rubric, the ground truth and a sandbox that stays open, to save time.

    Parameters
    ----------
    rubric, traces : the rubric, and the ground truth to grade with
    isolation_level : isolation level of the sandbox; the best that this machine allows if None
    sandbox : a sandbox that is already open; it is closed with the marker

    Raises
    ------
    RubricError
        If rubric and checks do not match, or the traces do not belong to the rubric's settings.
    GraderError
        If no sandbox can be opened.
    """

    def __init__(
        self, rubric: Rubric, traces: Traces, *, isolation_level: str | None = None, sandbox: Sandbox | None = None
    ) -> None:
        self._lab, self._rubric, self._traces = rubric.lab, rubric, traces
        rubric.lab.match(rubric.settings, traces)
        # A new sandbox warms up while the checks are collected.
        self._sandbox = sandbox or open_sandbox(rubric.lab, isolation_level)
        try:
            self._checks: Mapping[str, Check] = known_checks(rubric.lab, rubric.own_checks)
            match_checks(rubric, {check_id: check.title for check_id, check in self._checks.items()})
        except BaseException:
            self._sandbox.close()
            raise

    @property
    def isolation(self) -> IsolationLevel:
        return self._sandbox.isolation_level

    def __enter__(self) -> Marker:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def close(self) -> None:
        self._sandbox.close()

    def mark(
        self,
        submission: Submission,
        cpu_s: float | None = None,
        *,
        only: str | None = None,
        waiting: Callable[[str], None] | None = None,
        listen: Listener | None = None,
    ) -> Result:
        """Grade one submission and return its result, whose status says if nothing could be run. No student code makes it raise.

        Parameters
        ----------
        cpu_s : upper limit of the CPU seconds of the student's code, if less than the rubric's
        only : id of the only criterion or extension to examine; None examines all
        waiting : called with a message if an answer of student code takes long
        listen : receives what the student's code prints; public scenarios only, because code could print hidden data

        Raises
        ------
        Stopped
            On an interrupt; it holds the result so far.
        """
        started, began_cpu = time.perf_counter(), time.process_time()
        if submission.status != "ready":
            return self._result(submission, submission.status, {}, [], started, only)
        student = self._student(submission.files, submission.above, waiting, cpu_s)
        student.listen = listen if self._traces.name == "public" else None
        look = PublicSession(lambda: self._public_student(submission)) if self._secret else None
        check_run = CheckRun(self._lab, student, self._traces, only, look)
        try:
            self._run(check_run)
            judgements = self._fail_if_odd(check_run.judgements, student)
            notes = [*(look.notes(self._lab.homes) if look and student.withheld_note else ()), *student.notes]
        except KeyboardInterrupt:
            session.cache_clear()  # pytest cannot continue an interrupted session: the next one is collected anew
            so_far = self._result(submission, "graded", check_run.judgements, student.notes, started, only)
            raise Stopped(_reword_interrupted(so_far)) from None
        finally:
            if look:
                look.close()
        result = self._result(submission, "graded", judgements, notes, started, only)
        if only is None and self._has_nothing_to_grade(submission, result):
            result = replace(result, status="empty", notes=(_NO_NAME, *result.notes))
        used = time.process_time() - began_cpu + student.used_cpu_s
        return replace(result, evidence=self._evidence(student), cpu_s=used)

    def _has_nothing_to_grade(self, submission: Submission, result: Result) -> bool:
        """Return whether no file defines a name that the lab asks for, and no point was earned: another lab's files, or empty ones.

        Such a submission has no points until a person decides, like one without any program.
        """
        earned = any(check.keeps != 0.0 for part in result.parts for check in part.checks)
        parts = (*self._lab.parts, *self._lab.bonuses)
        return not earned and not any(part.named_in(submission.files) for part in parts)

    @property
    def _secret(self) -> bool:
        """True if hidden scenarios are graded: no text that student code can choose may then reach a student."""
        return self._traces.name != "public"

    def _public_student(self, submission: Submission) -> SubmissionSession:
        """Open a session about a submission that holds public data only, for messages on why its files do not load.

        Each criterion has the CPU time of one call.
        """
        return self._lab.student(
            self._sandbox,
            self._lab,
            submission.files,
            truth=self._lab.truth(None, self._rubric.settings),
            above=submission.above,
            call_cpu_s=self._rubric.limits.call_cpu_s,
            submission_cpu_s=self._rubric.limits.call_cpu_s * (len(self._lab.parts) + 1),
        )

    def _student(
        self,
        files: Mapping[str, bytes],
        above: Mapping[str, int],
        waiting: Callable[[str], None] | None = None,
        cpu_s: float | None = None,
    ) -> SubmissionSession:
        """Open the sandbox session about a submission's files, with the rubric's limits of CPU time, or `cpu_s` if that is less.

        `above` and `waiting` are as in `SandboxSession`.
        """
        limits = self._rubric.limits
        most = limits.submission_cpu_s if cpu_s is None else cpu_s
        self._sandbox.warm(libraries_of(self._lab, files))
        student = self._lab.student(
            self._sandbox,
            self._lab,
            files,
            truth=self._traces,
            above=above,
            call_cpu_s=min(limits.call_cpu_s, most),
            submission_cpu_s=min(limits.submission_cpu_s, most),
            waiting=waiting,
        )
        student.secret = self._secret
        return student

    def _run(self, check_run: CheckRun) -> None:
        try:
            session(self._lab, self._rubric.own_checks).run(check_run)
        finally:
            check_run.student.close()

    def _fail_if_odd(self, judgements: Mapping[str, Judgement], student: SubmissionSession) -> Mapping[str, Judgement]:
        """Fail the checks that raised an unexpected exception on this submission, although they can judge the lab sheet's own code.

        The cause is then an odd answer, and a note asks for a review. A check that raises on the sheet's code, too, stays unjudged.
        The sheet's code has no extensions: their checks are failed.
        """
        odd = {id_: each for id_, each in judgements.items() if each.feedback is None and not each.ours}
        bonuses = {bonus.id for bonus in self._lab.bonuses}
        lost = {}
        for id_, each in odd.items():
            control = self._outcomes_of_the_sheet.get(id_)
            if each.check.criterion in bonuses or (control is not None and control.feedback is not None):
                student.note(GraderText(f"{id_}: the grader could not read what the code returned; please review it"))
                lost[id_] = replace(each, feedback=NOT_UNDERSTOOD)
        return {**judgements, **lost}

    @cached_property
    def _outcomes_of_the_sheet(self) -> Mapping[str, Judgement]:
        """How the checks end on the lab sheet's own code; it shows whether an unexpected exception is the grader's fault."""
        sheet = {self._lab.files[0]: (self._lab.folder / "sheet.txt").read_bytes()}
        check_run = CheckRun(self._lab, self._student(sheet, {}), self._traces, None)
        self._run(check_run)
        return check_run.judgements

    def _evidence(self, student: SubmissionSession) -> Evidence:
        """Return the charts and the code fingerprint; empty ones if they cannot be made, as they do not affect the grade."""
        try:
            return Evidence(packed(self._lab.charts(student, self._traces)), fingerprint(student.files))
        except Exception:  # a student's numbers may break a chart in any way
            return Evidence()

    def _result(
        self, submission: Submission, status: Status, judgements: Mapping[str, Judgement], notes: list[str], started: float,
        only: str | None,
    ) -> Result:  # fmt: skip
        """Make the result with its points; its status is ``incomplete`` if a check could not be judged."""
        criteria = tuple(self._criterion(c, judgements, status) for c in self._rubric.criteria if only in (None, c.id))
        extensions = tuple(
            self._extension(e, submission, judgements, status) for e in self._rubric.extensions if only in (None, e.id)
        )
        found = Result(
            submission=submission.name,
            status=status,
            criteria=criteria,
            extensions=extensions,
            lab=LabName(self._lab.label, self._lab.title),
            notes=(*submission.notes, *notes),
            provenance=self._provenance(submission),
            # rounded to seconds for hidden data: code could encode what it has seen in its run time
            duration_s=round(time.perf_counter() - started, 0 if self._secret else 4),
        )
        unjudged = any(check.outcome == "not_judged" for part in found.parts for check in part.checks)
        return marked(replace(found, status="incomplete") if unjudged else found, self._rubric)

    def _criterion(self, criterion: Criterion, judgements: Mapping[str, Judgement], status: Status) -> CriterionResult:
        rows = tuple(self._row(weight, judgements.get(weight.id), status) for weight in criterion.checks)
        return CriterionResult(criterion.id, criterion.title, criterion.points, rows)

    def _extension(
        self, extension: Extension, submission: Submission, judgements: Mapping[str, Judgement], status: Status
    ) -> ExtensionResult:
        """Make the result of an extension. One that was not attempted lists no checks, because they did not run."""
        bonus = self._lab.part(extension.id)
        attempted = status not in _NOTHING and bonus is not None and bonus.attempted_in(submission.files)
        weights = extension.checks if attempted else ()
        rows = tuple(self._row(weight, judgements.get(weight.id), status) for weight in weights)
        return ExtensionResult(extension.id, attempted, extension.points, rows)

    def _row(self, weight: CheckWeight, judgement: Judgement | None, status: Status) -> CheckResult:
        """Make the result of one check, without its points, which `marks` computes.

        `judgement` is None for a check that did not run, for example because nothing was handed in.
        """
        check = self._checks[weight.id]
        found = partial(
            CheckResult, id=weight.id, title=check.title, lab_step=check.lab_step, points=None, max_points=0.0
        )
        if judgement is None and status in ("empty", "unreadable"):
            return found(outcome="skipped", said=_NOTHING[status], keeps=0.0)
        if judgement is None or judgement.feedback is None:
            trouble = judgement.trouble if judgement else "the check did not run"
            said = "Not judged, because the grader failed" + (f": {printable(trouble, 300)}" if trouble else "")
            return found(outcome="not_judged", said=said, fault=judgement.fault if judgement else "")
        feedback = judgement.feedback
        return found(
            outcome=feedback.outcome,
            said=feedback.said,
            expected=feedback.expected,
            got=feedback.got,
            where=feedback.where,
            hint=feedback.hint,
            misconceptions=feedback.faults,
            duration_s=0.0 if self._secret else round(judgement.duration_s, 4),
            keeps=feedback.keeps,
            not_understood=feedback.not_understood,
            deducted=feedback.deducted,
            fault=judgement.fault,
        )

    def _provenance(self, submission: Submission) -> dict[str, Any]:
        """Return what the result depends on: versions, digests of the inputs, isolation level and seed."""
        return {
            "grader": __version__,
            "rubric_sha256": self._rubric.sha256,
            "traces_sha256": self._traces.sha256,
            "submission_sha256": submission.sha256,
            "python": platform.python_version(),
            **{package: _version(package) for package in (*self._lab.depends_on, *self._lab.packages)},
            "isolation": self._sandbox.isolation_level.name,
            "seed": SEED,
            **({"hidden": True} if self._secret else {}),
        }


def _reword_interrupted(result: Result) -> Result:
    """Return an interrupted run's result, whose unjudged checks say that they were stopped, not that the grader failed."""

    def reached(check: CheckResult) -> CheckResult:
        return check.with_message("the check was stopped before them") if check.outcome == "not_judged" else check

    criteria = tuple(replace(part, checks=tuple(map(reached, part.checks))) for part in result.criteria)
    extensions = tuple(replace(part, checks=tuple(map(reached, part.checks))) for part in result.extensions)
    return replace(result, status="graded", criteria=criteria, extensions=extensions)


_version = cache(version)
_NO_NAME = "No program here defines a function or class that the lab asks for."
_NOTHING = {
    "empty": "Nothing recognisable was handed in: no Python file and no notebook was found.",
    "unreadable": "The archive could not be read.",
}
