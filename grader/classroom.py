"""A class from what was handed in to the folder of results: resume, mark, record, publish."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Protocol

from grader import __version__, cluster, intake
from grader.batch import OpenMarker, Unmarked, mark_all
from grader.errors import RequestError
from grader.intake import Submission
from grader.marking import Marker
from grader.plugin import known_checks
from grader.publishing import publish, publish_class
from grader.results import CheckResult, CriterionResult, ExtensionResult, Result
from grader.rubric import Criterion, Rubric
from grader.standing import Standing
from grader.store import Key, Store
from grader.text import printable
from grader.traces import Traces


@dataclass(frozen=True)
class Order:
    """What is to be graded, where to, and how. `only` empty means all; `jobs` None one a core; `cluster` None here."""

    paths: tuple[Path, ...]
    out: Path
    rubric: Rubric
    traces: Traces
    jobs: int | None = None
    only: tuple[str, ...] = ()
    force: bool = False
    trusted: bool = False
    rung: str | None = None
    cluster: str | None = None


class Audience(Protocol):
    """Who is told how the run goes on."""

    def begins(self, total: int) -> None: ...

    def done(self, id_: str, result: Result, *, resumed: bool) -> None: ...


@dataclass
class Outcome:
    """What a run did: its results by id, how many of them were on record, and what could not be placed."""

    results: dict[str, Result] = field(default_factory=dict)
    resumed: int = 0
    leftovers: tuple[str, ...] = ()

    @property
    def incomplete(self) -> list[str]:
        return [id_ for id_, result in self.results.items() if result.status == "incomplete"]

    def below(self, points: float) -> list[str]:
        """Ids of the submissions that were judged and have fewer points."""
        judged = {id_: result for id_, result in self.results.items() if result.status != "incomplete"}
        return [id_ for id_, result in judged.items() if result.score < points]


def grade_class(order: Order, audience: Audience) -> Outcome:
    """Grade every submission that is not recorded yet and write `order.out`.

    Each result is committed and its files are written as it arrives; the gradebook and the index are written at the
    end, also when the run is interrupted.

    Raises
    ------
    RequestError
        If there is nothing to grade, an id is unknown, OUT cannot be written or nothing here isolates students' code.
    GraderError
        If no marker can be opened.
    """
    found = intake.read_class(order.paths)
    entries = _chosen(found.entries, order.only)
    if not entries:
        raise RequestError(
            f"{_told(order.paths)}: no submission found there; give a folder of submissions or an archive"
        )
    outcome = Outcome(leftovers=found.leftovers)
    with Store(order.out) as store:
        run = _Run(order, store, audience, outcome)
        audience.begins(len(entries))
        try:
            run.grade(entries)
        finally:
            publish_class(order.out, store)
    return outcome


class _Run:
    """One pass over the class."""

    def __init__(self, order: Order, store: Store, audience: Audience, outcome: Outcome) -> None:
        self._order = order
        self._store = store
        self._audience = audience
        self._outcome = outcome

    def grade(self, entries: list[intake.Entry]) -> None:
        order = self._order
        for submission, marked in self._marked(entries):
            result = unjudged(submission, order, marked.reason) if isinstance(marked, Unmarked) else marked
            self._store.keep(self._key(submission), result)
            self._tell(submission.id, result, resumed=False)

    def _marked(self, entries: list[intake.Entry]) -> Iterator[tuple[Submission, Result | Unmarked]]:
        order, submissions = self._order, self._unrecorded(entries)
        if order.cluster is not None:
            return cluster.mark_all(submissions, opener(order), order.cluster)
        return mark_all(submissions, opener(order), min(order.jobs or os.cpu_count() or 1, len(entries)))

    def _unrecorded(self, entries: list[intake.Entry]) -> Iterator[Submission]:
        """Submissions that are still to be marked; those on record are told on the way."""
        for entry in entries:
            submission = entry.read()
            known = None if self._order.force else self._store.recall(self._key(submission))
            if known is None:
                yield submission
            else:
                self._outcome.resumed += 1
                self._tell(submission.id, known, resumed=True)

    def _key(self, submission: Submission) -> Key:
        rubric, traces = self._order.rubric.sha256, self._order.traces.sha256
        return Key(submission.id, submission.sha256, rubric, traces, __version__)

    def _tell(self, id_: str, result: Result, *, resumed: bool) -> None:
        publish(self._order.out, Standing(id_, result), self._store)
        self._outcome.results[id_] = result
        self._audience.done(id_, result, resumed=resumed)


def opener(order: Order) -> OpenMarker:
    """What each worker process makes its marker with."""
    return partial(guarded_marker, order.rubric, order.traces, order.rung, order.trusted)


@contextmanager
def guarded_marker(rubric: Rubric, traces: Traces, rung: str | None, trusted: bool) -> Iterator[Marker]:
    """A marker for other people's code: refused where nothing isolates it."""
    with Marker(rubric, traces, rung=rung) as marker:
        if marker.isolation == "none" and not trusted:
            raise RequestError(
                "this machine cannot isolate students' code (`imugrade doctor` tells why); "
                "grade on Linux, or add --trust-submissions if you trust every one of them"
            )
        yield marker


def unjudged(submission: Submission, order: Order, reason: str) -> Result:
    """The result of a submission that the grader failed on: every point open, none lost."""
    note = f"The grader failed on this submission ({printable(reason, 300)}); grade it again"
    titles = {id_: check.title for id_, check in known_checks().items()}
    return Result(
        submission.name,
        "incomplete",
        criteria=tuple(_open(criterion, titles) for criterion in order.rubric.criteria),
        extensions=tuple(ExtensionResult(each.id, False, each.points) for each in order.rubric.extensions),
        notes=(*submission.notes, note),
        provenance={
            "grader": __version__,
            "rubric_sha256": order.rubric.sha256,
            "traces_sha256": order.traces.sha256,
            "submission_sha256": submission.sha256,
        },
    )


def _open(criterion: Criterion, titles: Mapping[str, str]) -> CriterionResult:
    rows = (CheckResult(c.id, titles.get(c.id, c.id), "not_judged", None, c.max_points) for c in criterion.checks)
    return CriterionResult(criterion.id, criterion.title, criterion.points, tuple(rows))


def _chosen(entries: tuple[intake.Entry, ...], only: tuple[str, ...]) -> list[intake.Entry]:
    ids = [entry.id for entry in entries]
    for wanted in only:
        if wanted not in ids:
            near = difflib.get_close_matches(wanted, ids, 1)
            guess = f"; did you mean {near[0]}?" if near else ""
            raise RequestError(f"--only {printable(wanted)}: there is no submission with that id{guess}")
    return [entry for entry in entries if not only or entry.id in only]


def _told(paths: tuple[Path, ...]) -> str:
    return ", ".join(printable(str(path)) for path in paths[:3]) + (", …" if len(paths) > 3 else "")
