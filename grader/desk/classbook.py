"""The class behind the desk's pages: its database, cached until it changes, and a writer of the files in the output folder."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from grader.base.errors import RequestError
from grader.base.stamps import now
from grader.course.publishing.out_files import publish_all, publish_class
from grader.course.record import class_settings
from grader.course.record.decisions import Review
from grader.course.record.store import Store
from grader.course.record.submission_archive import Kept, unpack
from grader.course.regrading.adjusting import OverrideRequest, RecordedOverride, decide
from grader.course.regrading.no_submission import admit, blank_grades
from grader.course.regrading.regrade import remark
from grader.course.run import class_grading
from grader.desk.repair_jobs import RepairJobs
from grader.desk.similarity_groups import SimilarityGroup, similarity_groups
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.rubric import Rubric
from grader.people.final_grade import Adjustment, FinalGrade
from grader.report.similarity import Pair, own_hashes, pairs

T = TypeVar("T")
_MOST_PAIRS = 20_000
"""Most similar pairs that are listed: 200 copies of one file are that many pairs."""


@dataclass(frozen=True)
class Similar:
    """Submissions with similar code: groups, the pairs that they consist of, and whether there are `more` pairs than listed."""

    groups: tuple[SimilarityGroup, ...] = ()
    pairs: tuple[Pair, ...] = ()
    more: bool = False


class Classbook:
    """The graded class that all pages of the desk read and change; only `thread` may use `store`, its database. Results are cached.

    Parameters
    ----------
    out
        The folder that `imugrade grade` wrote.
    rubric
        File of a rubric to try on the what-if page, see `Classbook.rubric`; None is the one that the class was graded by.
    secret
        Makes the hidden scenarios on which submissions repaired at the desk are graded. None is for a class graded on public ones,
        which students can run, too; without the secret of hidden ones, repairs are refused.
    trusted
        Whether repaired submissions may run where nothing isolates them.
    """

    def __init__(
        self, lab: Lab, out: Path, rubric: Path | None = None, secret: str | None = None, *, trusted: bool = False
    ) -> None:
        self.lab, self.out, self._secret = lab, out, secret
        self.unplaced_requests: list[tuple[str, str, str]] = []
        """Text and check of each regrade request, and why it has no student or check."""
        self.jobs = RepairJobs(partial(class_grading.settings_on_record, lab, out, secret, trusted=trusted))
        self.thread = ThreadPoolExecutor(1, thread_name_prefix="desk")
        self._rubric = None if rubric is None else class_settings.rubric_of(lab, None, rubric)
        self._made: dict[str, tuple[object, Any]] = {}
        self.store = self.on_thread(lambda: Store.existing(out))
        try:
            self.on_thread(lambda: self.rubric)
        except RequestError:
            self.on_thread(self.store.close)
            self.thread.shutdown()
            raise
        self._seen = self._last = -1
        self._marked: dict[str, FinalGrade] = {}
        self._similar: Similar | None = None
        self._publisher = _Publisher(lab, out, self._keep_digest)

    def _keep_digest(self, id_: str, digests: str) -> None:
        self.on_thread(lambda: self.store.keep_page_digest(id_, digests))

    def on_thread(self, do: Callable[[], T]) -> T:
        return self.thread.submit(do).result()

    def close(self) -> None:
        """End the desk: wait for the running job, write pending pages and close the class database."""
        self.jobs.close()
        self._publisher.close()
        self.on_thread(self.store.close)
        self.thread.shutdown()

    def final_grades(self) -> dict[str, FinalGrade]:
        """Return all final grades by id, cached. After an override or comment at the desk, only these are read again.

        Results, too, are read again after a write by another connection, a review, a regrade, or points without a submission.
        """
        seen = self.store.changes()
        if seen != self._seen:
            self._marked, self._seen, self._similar = self.store.final_grades(), seen, None
            self._last = self.store.last_adjustment()
        elif self._last != (last := self.store.last_adjustment()):
            adjustments, self._last = self.store.adjustments(), last
            self._marked = {id_: replace(s, adjustments=adjustments.get(id_, ())) for id_, s in self._marked.items()}
        return self._marked

    @property
    def rubric(self) -> Rubric:
        """Return the rubric that pages use: the file given to the desk at its start, until a regrade there; else the class's."""
        if self._rubric is not None:
            return self._rubric
        settings = self.store.settings()
        return self.once("rubric", settings, lambda: class_settings.rubric_of(self.lab, settings))

    def absent(self) -> dict[str, FinalGrade]:
        """Return a blank final grade by id for each person of the roster without a submission, so that pages list them."""
        facts = (self.store.settings(), self.final_grades())
        return self.once("absent", facts, lambda: blank_grades(*facts))

    def once(self, name: str, facts: object, make: Callable[[], T]) -> T:
        """Return what `make` returns, cached under `name` until `facts`, the values that the result depends on, change."""
        known = self._made.get(name)
        if known is None or known[0] != facts:
            known = self._made[name] = (facts, make())
        made: T = known[1]
        return made

    def similar(self) -> Similar:
        self.final_grades()
        if self._similar is None:
            prints = {id_: hashes for id_, hashes in self.store.fingerprints().items() if id_ in self._marked}
            found = pairs(prints, of_the_sheet(self.lab), _MOST_PAIRS)
            self._similar = Similar(tuple(similarity_groups(found)), tuple(found), len(found) == _MOST_PAIRS)
        return self._similar

    def shared(self, first: str, second: str) -> frozenset[int]:
        """Return hashes of code that two submissions, by id, share, without code of the lab or of half the class; may be empty."""
        own = own_hashes(self.store.fingerprints(), of_the_sheet(self.lab))
        return own.get(first, frozenset()) & own.get(second, frozenset())

    def kept(self, final_grade: FinalGrade) -> Kept:
        return unpack(self.store.files(str(final_grade.result.provenance.get("submission_sha256", ""))))

    def history(self, id_: str) -> list[Adjustment]:
        return [each for who, each in self.store.history() if who == id_]

    def decide(
        self, overrides: Sequence[OverrideRequest], author: str, seen: int | None, what: str = ""
    ) -> list[RecordedOverride]:
        """Store and return overrides, all or none, and write the pages of these submissions in the background.

        RequestError if one is not valid; OvertakenError if these submissions have an override later than number `seen`, the last
        that the author saw (None skips this test). `what` names the group that the overrides decide on together, such as similar
        code; "" if there is none.
        """
        known = {**self.final_grades(), **admit(self.store, {each.id for each in overrides})}
        made = decide(self.store, known, overrides, author, seen=seen, what=what)
        if any(
            known[each.id].has_no_submission for each in made
        ):  # the first points admit, the last withdrawal removes
            self._seen = -1
        self._publisher.changed(each.id for each in made if each.fresh)
        return made

    def mark_reviewed(self, keys: Sequence[tuple[str, str, str]], author: str, *, done: bool) -> None:
        """Store that items of the queue, each as (id, kind, digest of its reason), are reviewed, or are open again if not `done`.

        An empty or unreadable submission counts 0 once reviewed, and is blank before.
        """
        self.store.keep_reviews([Review(*key, done, author, now()) for key in keys])
        self._seen = -1
        self._publisher.changed(id_ for id_, reason, _ in keys if reason in ("empty", "unreadable"))

    def mark_by(self, rubric: Rubric) -> None:
        """Make `rubric` the class's: regrade stored results by it, run no code, and rewrite submission pages in the background."""
        marked = remark(self.out, self.store, rubric)
        self._rubric, self._seen = None, -1
        self._publisher.changed(marked)

    def settled(self) -> None:
        """Wait until the pages that are written in the background match the class database, as an export needs them."""
        self._publisher.settled()

    @property
    def no_repairs(self) -> str:
        """Return why repairs cannot be previewed or saved (the secret of the hidden scenarios is missing); "" if they can."""
        try:
            class_settings.refuse_without_secret(self.store.settings(), self._secret)
        except RequestError as problem:
            return str(problem)
        return ""

    def changed(self, ids: Iterable[str]) -> None:
        """Write the pages of these submissions anew in the background, after a change that the desk's jobs made."""
        self._publisher.changed(ids)

    @property
    def trouble(self) -> str:
        """Return why pages could not be written in the background, which every page of the desk shows; "" if all were."""
        return self._publisher.trouble


class _ReadingStore(Store):
    """Connection of the thread that writes pages. It stores digests by the desk's connection, whose cache so stays valid."""

    def __init__(self, out: Path, keep: Callable[[str, str], None]) -> None:
        super().__init__(out)
        self._keep = keep

    def keep_page_digest(self, id_: str, digests: str) -> None:
        self._keep(id_, digests)


class _Publisher:
    """Thread that writes pages and the class page in the background, so that no decision waits for 2000 submissions."""

    def __init__(self, lab: Lab, out: Path, keep: Callable[[str, str], None]) -> None:
        self._lab, self._out, self._keep = lab, out, keep
        self._ids: set[str] = set()
        self._lock = threading.Condition()
        self._busy = self._closed = False
        self.trouble = ""
        self._thread = threading.Thread(target=self._run, name="publisher")
        self._thread.start()

    def changed(self, ids: Iterable[str]) -> None:
        with self._lock:
            self._ids.update(ids)
            self._lock.notify_all()

    def settled(self) -> None:
        with self._lock:
            self._lock.wait_for(lambda: not self._ids and not self._busy)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            self._lock.notify_all()
        self._thread.join()

    def _run(self) -> None:
        """Write the files of changed submissions until the desk closes; keep a failure as `trouble`."""
        while True:
            with self._lock:
                self._busy = False
                self._lock.notify_all()
                self._lock.wait_for(lambda: self._ids or self._closed)
                if not self._ids:
                    return
                ids, self._ids, self._busy = self._ids, set(), True
            try:
                self._publish(ids)
                self.trouble = ""
            except Exception as problem:  # the decisions are on record; every page shows the problem
                self.trouble = f"The files of {self._out} could not be written: {problem}"

    def _publish(self, ids: set[str]) -> None:
        with _ReadingStore(self._out, self._keep) as store:
            final_grades = publish_class(self._out, store, self._lab)
            if ids - final_grades.keys():  # points without a submission that were withdrawn
                final_grades |= blank_grades(store.settings(), final_grades)
            publish_all(self._out, (final_grades[id_] for id_ in sorted(ids)), store, self._lab)
