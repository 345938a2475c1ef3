"""Review queue: which submissions a person should look at, and why. A review changes a grade only if the item `gives_zero`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from grader.base.text import printable, some
from grader.course.publishing.contradictions import Contradiction
from grader.course.record.decisions import RegradeRequest, Review, about, why_empty
from grader.course.record.repair_log import LoggedRepair
from grader.course.regrading.groups import Group, similar_group
from grader.course.repairs import making
from grader.course.run import missing_packages
from grader.course.run.warnings import equal, not_understood
from grader.desk.similarity_groups import SimilarityGroup
from grader.engine.findings import NEEDS_REVIEW
from grader.engine.lab import Lab
from grader.engine.results import AUTOMATIC, Result
from grader.engine.rubric_records import LatePolicy
from grader.people.final_grade import FinalGrade
from grader.people.late_policy import in_zone
from grader.report import words
from grader.report.causes import stops

KINDS = {
    "above": "Above the maximum",
    "two-grades": "Two grades",
    "does-not-run": "Does not run",
    "missing-package": "Package not installed",
    "repaired": "Repaired automatically",
    "repair-lapsed": "Repair no longer counts",
    "request": "Regrade request",
    "not-judged": "Grader failed",
    "unreadable": "Unreadable",
    "empty": "Empty",
    "nothing": "No points",
    "not-understood": "Unclear answer",
    "tampering": "Tampering",
    "not-placed": "Not assigned",
    "unknown-person": "Not in the roster",
    "lateness": "Unknown lateness",
    "outdated": "Outdated override",
    "same-files": "Same files",
    "alike": "Similar code",
    "picture": "Plot that could not be judged",
    "boundary": "Near a grade boundary",
}
"""Titles of the reasons, in the order of the queue."""
_OF = {"above maximum": "above", "two grades": "two-grades"}
"""Reasons that contradictions of a submission give."""
_NAMED = 8  # checks
_STEP = 10
"""Number of grade steps: a boundary is at every tenth of the maximum."""
_NEAR = 1.0
"""Largest distance below a boundary, in points, that is worth a review."""


def address(group: Group) -> str:
    return f"/groups/{group.kind}/{quote(group.key, safe='')}"


@dataclass(frozen=True)
class Reason:
    """Reason, of a kind in `KINDS`, to look at a submission, or at several (ids in `who`); `file` is the submitted file, if any.

    A review is stored under `about`, a digest of `sentence` and `who`: if one of these changes, the item is open again.
    """

    kind: str
    sentence: str
    who: tuple[str, ...] = ()
    file: str = ""

    @property
    def about(self) -> str:
        return about(self.sentence, self.who)

    @property
    def title(self) -> str:
        return KINDS[self.kind]


@dataclass(frozen=True)
class Item:
    """One item of the review queue: a reason to review a submission, several (also `others`), or the class (`id` is "").

    `review` is None while the item is open. `gives_zero`: the grade is blank until a person has reviewed the item, and then 0.
    """

    id: str
    reason: Reason
    review: Review | None
    others: tuple[str, ...] = ()
    gives_zero: bool = False

    @property
    def ids(self) -> tuple[str, ...]:
        return (self.id, *self.others)

    @property
    def together(self) -> str:
        """Return the address of the page to override or comment on all submissions of the item at once; "" without `others`."""
        return address(similar_group(self.ids)) if self.others else ""

    @property
    def key(self) -> str:
        """Return ``kind/digest/id`` (digest of the reason), by which a form names this item. None of the three contains a slash."""
        return f"{self.reason.kind}/{self.reason.about}/{self.id}"


def items(
    final_grades: Mapping[str, FinalGrade],
    groups: Sequence[SimilarityGroup],
    notices: Mapping[str, Sequence[str]],
    requests: Iterable[RegradeRequest],
    reviews: Mapping[tuple[str, str, str], Review],
    contradictions: Iterable[Contradiction],
    lapsed: Iterable[LoggedRepair],
    lab: Lab,
    policy: LatePolicy | None,
) -> list[Item]:
    """Return the items of the queue, open and reviewed, by kind as in `KINDS`, then by submission as in `final_grades`.

    They come from `final_grades`, `groups` of similar submissions, a run's `notices` (messages or ids by kind), open `requests`,
    `contradictions` (grades that cannot be right), and `lapsed` repairs, which no longer count. `reviews` says which items were
    reviewed, by submission, kind of the item and digest of its reason. `lab` names files whose code does not run. Times are in
    the zone of the late `policy`.
    """
    found: list[tuple[tuple[str, ...], Reason]]
    found = [(("",), Reason("not-placed", printable(line, 500))) for line in notices.get("leftover", ())]
    found += [((id_,), reason) for id_, each in final_grades.items() for reason in _reasons_for_one(each, lab, policy)]
    found += _reasons_for_several(final_grades, groups)
    found += [((each.id,), Reason(_OF[each.kind], each.text)) for each in contradictions if each.kind in _OF]
    if not any(each.hand_in.marked_late for each in final_grades.values()):  # else each of them has a reason of its own
        found += [(("",), Reason("lateness", each.text)) for each in contradictions if each.kind == "unknown lateness"]
    found += [((each.id,), _lapsed(each)) for each in lapsed if each.id in final_grades]
    unknown = Reason("unknown-person", "Not in the roster, or the roster has several people who match.")
    found += [((id_,), unknown) for id_ in notices.get("unknown", ()) if id_ in final_grades]
    found += [((each.id,), _request(each)) for each in requests if not each.answered and each.id in final_grades]
    rank = {kind: place for place, kind in enumerate(KINDS)}
    order = {id_: place for place, id_ in enumerate(final_grades)}
    found.sort(key=lambda item: (rank[item[1].kind], order.get(item[0][0], -1)))
    return [
        Item(
            ids[0],
            each,
            reviews.get((ids[0], each.kind, each.about)),
            tuple(ids[1:]),
            each.kind in ("empty", "unreadable") and all(a.alone for a in final_grades[ids[0]].adjustments),
        )
        for ids, each in found
    ]


def _reasons_for_one(final_grade: FinalGrade, lab: Lab, policy: LatePolicy | None) -> Iterator[Reason]:
    """Yield the reasons why a person should look at this submission by itself, such as code that does not run; may be none."""
    result = final_grade.result
    yield from (Reason("does-not-run", each.sentence, file=each.file) for each in stops(result, lab))
    for repair in result.repairs:
        if repair.author == AUTOMATIC:
            what = f"{printable(repair.file, 200)}, {words.minus(repair.deduction)} points. Check the change."
            yield Reason("repaired", what)
    if final_grade.final is None and not final_grade.unseen:
        open_ = [
            check.title for part in result.criteria for check in part.checks if final_grade.check_points(check) is None
        ]
        yield Reason(
            "not-judged", f"The grader failed on these checks, so their points are open: {some(open_, _NAMED)}"
        )
    if result.status in ("empty", "unreadable") and not final_grade.has_no_submission:
        yield Reason(result.status, why_empty(result))
    if result.status == "graded" and not result.score:
        yield Reason("nothing", "The submission has no points. Check whether it belongs to another lab.")
    if not_understood(result):
        yield Reason("not-understood", "The grader could not interpret an answer. Check what the code returns.")
    if "tampering" in result.misconceptions:
        yield Reason(
            "tampering", "The code changes its environment. Check what it does. This deducts nothing by itself."
        )
    if final_grade.late is not None and final_grade.late.seconds is None and not final_grade.total_is_set:
        yield Reason(
            "lateness",
            "Marked late without a time, so nothing is deducted. Add a column `submitted` to the roster and grade again: the late "
            "policy then deducts. Or override the total with the lateness in it: a total is final, and nothing is deducted again.",
        )
    above = final_grade.above_maximum()
    for each in (each for each in final_grade.outdated() if each not in above):
        points, at = words.number(each.points or 0.0), words.instant(in_zone(each.at, policy))
        yield Reason(
            "outdated",
            f"{each.criterion} was set to {points} on {at}; the automatic points or their maximum have changed since.",
        )
    yield from (Reason("picture", note) for note in words.notes(result) if NEEDS_REVIEW in note)
    yield from _near_a_boundary(final_grade, result)


def _near_a_boundary(final_grade: FinalGrade, result: Result) -> Iterator[Reason]:
    """Yield a reason if partly passed checks could lift the grade over a boundary less than a point above it."""
    rows = [check for part in result.criteria for check in part.checks if check.outcome == "partial"]
    partial = [check for check in rows if final_grade.check_points(check) == check.points]
    room = round(sum(check.max_points - (check.points or 0.0) for check in partial), 2)
    if final_grade.final is None or not partial or not result.max_score:
        return
    step = result.max_score / _STEP
    below = round(-final_grade.final % step, 2)
    if 0 < below <= min(_NEAR, room):
        boundary = words.number(round(final_grade.final + below, 2))
        yield Reason(
            "boundary",
            f"{words.number(below)} below {boundary}, and {words.number(room)} points were lost on partial checks: "
            f"{some([check.title for check in partial], _NAMED)}",
        )


def _reasons_for_several(
    final_grades: Mapping[str, FinalGrade], groups: Sequence[SimilarityGroup]
) -> Iterator[tuple[tuple[str, ...], Reason]]:
    """Yield each reason that concerns several submissions, with their ids: missing package, same files, similar code."""
    failed = {id_: missing_packages.failed(each.result) for id_, each in final_grades.items()}
    if said := missing_packages.lines(failed):
        ids = tuple(id_ for id_, names in failed.items() if names)
        yield ids, Reason("missing-package", f"{'. '.join(said)}.", ids)
    same = [tuple(ids) for ids in equal(final_grades.values())]
    for ids in same:
        yield ids, Reason("same-files", f"{len(ids)} submissions contain the same files.", ids)
    for group in groups:
        if not any(set(ids) >= set(group.ids) for ids in same):  # identical files are listed as such only
            share = f"{100 * group.share[1]:.0f} % of the smaller submission"
            yield group.ids, Reason("alike", f"Similar code beyond the lab sheet: up to {share}.", group.ids)


def _lapsed(repair: LoggedRepair) -> Reason:
    file, author = printable(repair.file, 200), printable(repair.author, 80)
    what = f"The repair of {file} by {author} ({words.minus(repair.deduction)} points) no longer counts"
    return Reason("repair-lapsed", f"{what}: {making.WHY_LAPSED}.", file=repair.file)


def _request(request: RegradeRequest) -> Reason:
    about = f" about {printable(request.about, 80)}" if request.about else ""
    return Reason("request", f"Request {request.number}{about}: {printable(' '.join(request.text.split()), 160)}")
