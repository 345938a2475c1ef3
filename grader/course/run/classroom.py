"""Grading of a class, from submissions to the output folder: reuse stored results, grade the rest, store, publish."""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Protocol

from grader import __version__
from grader.base.errors import GraderError, RequestError
from grader.course.markers import cluster
from grader.course.markers.pool import Bounds, Ended, MarkerAnswer, Marking, OpenMarker, Unmarked, mark_all
from grader.course.publishing.contradictions import contradictions
from grader.course.publishing.out_files import publish, publish_class
from grader.course.record import class_settings
from grader.course.record.class_settings import Change, ClassSettings
from grader.course.record.database import FILE_NAME
from grader.course.record.decisions import is_reviewed
from grader.course.record.store import Key, Store
from grader.course.record.submission_archive import pack
from grader.course.repairs import making, renewing
from grader.course.run import missing_packages
from grader.course.run.grade_request import GradeRequest
from grader.course.run.submissions import Class
from grader.course.run.unmarked import stopped, unjudged
from grader.course.run.warnings import gone, named_lines, of_policy, outdated, remarks, replaced
from grader.engine.chart_data import Evidence
from grader.engine.grader import Marker
from grader.engine.lab import Lab
from grader.engine.lab_registry import chosen_lab
from grader.engine.reading import ReadingProcess
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.intake import Submission
from grader.people.final_grade import FinalGrade, HandIn, graded
from grader.platforms.classes import ClassEntry
from grader.sandbox.isolation_levels import LEVELS

_WALL_PER_CPU = 5
"""Wall seconds of a marker for each CPU second that the rubric allows a submission. They exceed all time limits of a session
together."""


class ProgressListener(Protocol):
    """Protocol of a progress display: `started` gets the number of submissions, `done` each result (`resumed` if stored before)."""

    def started(self, total: int) -> None: ...

    def done(self, id_: str, result: Result, *, resumed: bool) -> None: ...


@dataclass
class RunOutcome:
    """Outcome of a run, for the lines that `imugrade grade` prints at its end: results by id, counts, and warnings.

    `grades` holds the final grades. `resumed` counts results taken from the class database, `remarked` those that were regraded
    because the rubric had changed. `leftovers` are files that belong to no submission. `remarks` are the warnings to print; `known`
    counts those that are left out because the last run had them, too. `contradictions` are lines on grades that cannot be right,
    such as one above its maximum; all are printed after every run.
    """

    results: dict[str, Result] = field(default_factory=dict)
    grades: list[float] = field(default_factory=list)
    resumed: int = 0
    remarked: int = 0
    leftovers: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    contradictions: tuple[str, ...] = ()
    known: int = 0

    @property
    def incomplete(self) -> list[str]:
        return [id_ for id_, result in self.results.items() if result.status == "incomplete"]

    def below(self, points: float) -> list[str]:
        """Return the ids of complete results (every check was judged) that score below `points`, for ``grade --min-score``."""
        judged = {id_: result for id_, result in self.results.items() if result.status != "incomplete"}
        return [id_ for id_, result in judged.items() if result.score < points]


def on_record(out: Path) -> ClassSettings | None:
    """Return the settings that the class in the output folder was graded by; None where none are stored."""
    if not (out / FILE_NAME).is_file():
        return None
    with Store.existing(out) as store:
        return store.settings()


def lab_on_record(out: Path) -> Lab:
    """Return the lab of the class in the output folder; if none is stored, that of the variable `IMUGRADE_LAB`, or the shipped one.

    RequestError if the lab is not installed, or if the variable names another lab than the class has.
    """
    settings = on_record(out)
    return chosen_lab(settings.lab if settings else "")


def change(request: GradeRequest, found: Class) -> Change | None:
    """Compute what a run's settings do to the stored scores of `found`, for a person to allow or refuse.

    None if no settings are stored, or none that scores depend on differs.

    Raises
    ------
    RequestError
        If a class graded on hidden scenarios would get public ones, or scores may change and `request.only` limits the run.
    """
    if not (request.out / FILE_NAME).is_file():
        return None
    new = request.settings
    with Store.existing(request.out) as store:
        old = store.settings()
        if old is None or not class_settings.causes(old, new):
            return None
        final_grades = store.final_grades()
    if old.hidden and not new.hidden:
        class_settings.refuse_without_secret(old, None)
    several = Counter(entry.id for entry in found.entries)
    hand_ins = {entry.id: entry.hand_in if several[entry.id] == 1 else None for entry in found.entries}
    changed = class_settings.change(old, new, request.rubric, final_grades, hand_ins)
    if changed is not None and changed.moves_scores and request.only:
        raise RequestError(f"--only cannot change the settings of the whole class; leave it out ({changed.in_words()})")
    return changed


def forecast(request: GradeRequest, found: Class) -> list[str]:
    """Return lines for `grade --dry-run`: how many submissions would be graded, and which have other files than on record."""
    kept: list[bool] = []
    given: dict[str, set[str]] = {}
    present: dict[str, Result] = {}
    with ReadingProcess() as reader:
        if (request.out / FILE_NAME).is_file():
            with Store.existing(request.out) as store:
                again, present = installed_since(store, request.rubric.lab), store.present()
                for _, each in reader.each(found.entries):
                    given.setdefault(each.id, set()).add(each.sha256)
                    kept.append(_is_on_record(store, _key(each, request), request, again))
    others = [id_ for id_ in given if id_ in present and present[id_].provenance["submission_sha256"] not in given[id_]]
    return [
        f"{len(found.entries) - sum(kept)} would be graded · {sum(kept)} on record",
        *named_lines("other files than on record would count", others),
    ]


def installed_since(store: Store, lab: Lab) -> set[str]:
    """Return the ids of stored submissions to grade again, as a package that they failed to import can be imported now."""
    failed = {id_: missing_packages.failed(each.result) for id_, each in store.final_grades().items()}
    there = missing_packages.available(lab) if any(failed.values()) else set()
    return {id_ for id_, names in failed.items() if names.keys() & there}


def _is_on_record(store: Store, key: Key, request: GradeRequest, again: Collection[str]) -> bool:
    """Return whether a stored result serves, so that a run need not grade; `again` holds ids that it grades in any case."""
    return not request.force and key.id not in again and store.has(key, request.rubric)


def _key(submission: Submission, request: GradeRequest) -> Key:
    return Key(submission.id, submission.sha256, request.rubric.sha256, request.traces.sha256, __version__)


def grade_class(request: GradeRequest, found: Class, progress: ProgressListener) -> RunOutcome:
    """Grade every submission whose stored result cannot be reused, and write the output folder.

    One is reused if files, scenarios and version of imugrade are the same, it has all that the rubric needs and no unjudged check,
    no package that it lacked is installed now, and `request.force` is False. Each result is stored and its files are written as it
    arrives; the gradebook and the index at the end, also when the run is interrupted.

    Raises
    ------
    RequestError
        If `change` raises it, `request.out` is not writable, isolation is too weak, or scores may change without `request.change`.
    GraderError
        If no sandbox can be opened.
    """
    changed = change(request, found)
    moves = changed is not None and changed.moves_scores
    if changed is not None and moves and not request.change:
        raise RequestError(
            f"{changed.in_words()}; add --change to allow it, or choose another folder with -o. Nothing was changed"
        )
    outcome = RunOutcome(leftovers=found.leftovers)
    with Store(request.out) as store:
        was, before = store.settings(), store.final_grades()
        store.keep_settings(replace(request.settings, isolation=was.isolation if was else ""), keep_before=moves)
        mismatches = {"leftover": found.leftovers, "absent": found.absent, "unknown": found.unknown}
        remarked = store.notices().get("remark", [])
        store.keep_notices({**mismatches, "remark": remarked})
        progress.started(len(found.entries))
        run = _Run(request, store, progress, outcome)
        try:
            run.grade(found.entries)
            run.renew_repairs()
            run.keep_people(found.others)
        finally:
            final_grades = publish_class(request.out, store, request.rubric.lab)
            _keep_isolation(store, final_grades)
        settings = store.settings()
        now = (
            *remarks(final_grades, found.absent, found.unknown),
            *found.doubtful,
            *of_policy(final_grades, request.rubric.late),
            *(() if request.only else gone(final_grades, {entry.id for entry in found.entries})),
            *run.lost_repairs,
        )
        store.keep_notices({**mismatches, "remark": now})
    new = [line for line in now if line not in remarked]
    outcome.grades = graded(final_grades[id_] for id_ in outcome.results)
    outcome.remarks = (*replaced(before, final_grades), *outdated(final_grades), *new)
    outcome.known = len(now) - len(new)
    judged = (each for each in contradictions(final_grades, settings) if each.kind != "not judged")
    outcome.contradictions = tuple(each.text for each in judged)
    return outcome


def _keep_isolation(store: Store, final_grades: Mapping[str, FinalGrade]) -> None:
    """Store the weakest isolation level used in the class, so that later gradings are not isolated less; nothing if unknown."""
    levels = [isolation_level.name for isolation_level in LEVELS]
    used = [name for each in final_grades.values() if (name := each.result.provenance.get("isolation")) in levels]
    settings = store.settings()
    if settings is not None and used:
        store.keep_settings(replace(settings, isolation=max(used, key=levels.index)))


class _Run:
    """One run over a class while it goes on: attempts found so far, stored results to reuse, repairs that no longer count."""

    def __init__(self, request: GradeRequest, store: Store, progress: ProgressListener, outcome: RunOutcome) -> None:
        self._request = request
        self._store = store
        self._progress = progress
        self._outcome = outcome
        self._adjustments, self._reviews = store.adjustments(), store.reviews()
        self._attempts: dict[Key, _Attempt] = {}
        self._on_record: deque[Key] = deque()
        self._installed_since = installed_since(store, request.rubric.lab)
        self.lost_repairs: list[str] = []

    def renew_repairs(self) -> None:
        """Apply stored repairs again to this run's submissions with unchanged files, then suggested ones if the rubric says so."""
        request = self._request
        with making.GradingSettings(request.rubric, request.traces, opener(request)).opened() as grading:
            for id_, found in renewing.renew(self._store, list(self._outcome.results), grading):
                if isinstance(found, str):
                    self.lost_repairs.append(found)
                else:
                    self._repaired(id_)
            if request.rubric.repairs.suggested:
                for id_, _ in renewing.apply_suggested(self._store, list(self._outcome.results), grading):
                    self._repaired(id_)

    def _repaired(self, id_: str) -> None:
        final_grade = self._store.final_grades()[id_]
        self._count(final_grade)
        self._publish(final_grade)

    def keep_people(self, named: Mapping[str, HandIn]) -> None:
        """Store whom the roster names for earlier submissions that are not in this download, and write their pages anew."""
        for id_, hand_in in named.items():
            self._store.keep_hand_in(id_, hand_in)
        if named:
            final_grades = self._store.final_grades()
            for id_ in named:
                self._publish(final_grades[id_])

    def grade(self, entries: Sequence[ClassEntry]) -> None:
        """Grade all submissions; store, publish and report each result as it arrives, so that a killed run loses little."""
        with ReadingProcess() as reader:
            for submission, marked in self._marked(entries, reader):
                self._resume()
                result, key = _result(submission, self._request, marked), _key(submission, self._request)
                self._store.keep_files(submission.sha256, partial(pack, submission.files))
                self._store.keep(key, result)
                slim = replace(result, evidence=Evidence())  # charts of a large class would fill the memory
                self._keep_and_report(key, slim, resumed=False)
        self._resume()
        self._choose_best_attempt()

    def _resume(self) -> None:
        """Reuse the stored results found so far, regraded if the rubric has changed: make them count, publish and report them."""
        while self._on_record:
            key = self._on_record.popleft()
            known = self._store.recall(key)
            if known is None:
                known = self._store.remark(key, self._request.rubric)
                self._outcome.remarked += 1
            if known is None:
                raise GraderError(f"{key.id}: its result is not on record any more; give the same command again")
            self._outcome.resumed += 1
            self._keep_and_report(key, known, resumed=True)

    def _choose_best_attempt(self) -> None:
        """Let the best of several attempts count, after late deductions, the first of equal ones.

        An attempt on which the grader failed counts before all, so that the grade stays open.
        """
        own: dict[str, list[tuple[Key, FinalGrade]]] = {}
        for key, attempt in self._attempts.items():
            own.setdefault(key.id, []).append((key, self._final_grade(key, attempt)))
        for attempts in (each for each in own.values() if len(each) > 1):
            still_open = [each for each in attempts if each[1].final is None and not each[1].unseen]
            key, final_grade = (still_open or sorted(attempts, key=lambda each: -(each[1].final or 0.0)))[0]
            self._store.make_current(key)
            self._count(final_grade)
            self._publish(final_grade)

    def _marked(
        self, entries: Sequence[ClassEntry], reader: ReadingProcess
    ) -> Iterator[tuple[Submission, MarkerAnswer]]:
        request, submissions = self._request, self._submissions_to_mark(entries, reader)
        bounds = Bounds(wall_s=_WALL_PER_CPU * request.rubric.limits.submission_cpu_s)
        if request.cluster is not None:
            return cluster.mark_all(submissions, opener(request), request.cluster, bounds)
        jobs = min(_jobs(request), len(entries))
        return mark_all(submissions, opener(request), jobs, bounds)

    def _submissions_to_mark(self, entries: Sequence[ClassEntry], reader: ReadingProcess) -> Iterator[Submission]:
        """Yield the submissions to grade, and list those with a stored result. It writes nothing: the pool decides when it runs."""
        for entry, submission in reader.each(entries):
            key = _key(submission, self._request)
            if key in self._attempts:  # the same files were handed in twice: the first hand-in counts
                continue
            self._attempts[key] = _Attempt(entry.hand_in)
            if _is_on_record(self._store, key, self._request, self._installed_since):
                self._on_record.append(key)
            else:
                yield submission

    def _keep_and_report(self, key: Key, result: Result, *, resumed: bool) -> None:
        """Note the result of an attempt (one submission of the same people), store who handed in, write pages, report progress."""
        attempt = self._attempts[key]
        attempt.result = result
        final_grade = self._final_grade(key, attempt)
        self._count(final_grade)
        self._publish(final_grade)
        self._progress.done(key.id, result, resumed=resumed)

    def _publish(self, final_grade: FinalGrade) -> None:
        publish(self._request.out, final_grade, self._store, self._request.rubric.lab)

    def _final_grade(self, key: Key, attempt: _Attempt) -> FinalGrade:
        if attempt.result is None:
            raise GraderError(f"{key.id}: one of its attempts has no result")
        reviewed = is_reviewed(key.id, attempt.result, self._reviews)
        return FinalGrade(key.id, attempt.result, attempt.hand_in, self._adjustments.get(key.id, ()), reviewed)

    def _count(self, final_grade: FinalGrade) -> None:
        self._store.keep_hand_in(final_grade.id, final_grade.hand_in)
        self._outcome.results[final_grade.id] = final_grade.result


@dataclass
class _Attempt:
    """One of the submissions that the same people handed in; its result is None until it is known."""

    hand_in: HandIn
    result: Result | None = None


def _jobs(request: GradeRequest) -> int:
    return request.jobs or os.cpu_count() or 1


def opener(request: GradeRequest) -> OpenMarker:
    """Return the function that opens a marker, which grades submissions; it is picklable, because worker processes get it."""
    return partial(
        guarded_marker, request.rubric, request.traces, request.isolation_level, request.trusted, request.at_least
    )


@contextmanager
def guarded_marker(
    rubric: Rubric, traces: Traces, isolation_level: str | None, trusted: bool, at_least: str = ""
) -> Iterator[Marking]:
    """Keep a marker, which grades student code, open in this context.

    `isolation_level` and `at_least` are names such as "landlock"; None takes the best that works here. RequestError if the level is
    weaker than `at_least` ("" allows any), or isolates nothing and students' code is not `trusted`.
    """
    with Marker(rubric, traces, isolation_level=isolation_level) as marker:
        if not marker.isolation.isolates and not trusted:
            raise RequestError(
                "this machine cannot isolate students' code (`imugrade doctor` says why); "
                "grade on Linux, or add --trust-submissions if you trust every submission"
            )
        levels = [each.name for each in LEVELS]
        if at_least in levels and levels.index(marker.isolation.name) > levels.index(at_least):
            raise RequestError(
                f"the class was graded at the isolation level {at_least}, and this machine offers {marker.isolation.name} "
                "(`imugrade doctor` says why); add --change to grade the rest at that level"
            )
        yield marker


def _result(submission: Submission, request: GradeRequest, marked: MarkerAnswer) -> Result:
    if isinstance(marked, Unmarked):
        return unjudged(submission, request, marked.reason)
    return stopped(submission, request, marked.reason) if isinstance(marked, Ended) else marked
