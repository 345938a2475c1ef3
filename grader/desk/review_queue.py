"""What needs a look, and why: facts of the record that no mark depends on, each with the sentence that says it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from grader.course.groups import Group, alike
from grader.course.record import Appeal, Tick, about, why_empty
from grader.course.remarks import equal, not_understood, timed_out
from grader.desk.similarity_groups import Clique
from grader.engine.findings import A_PERSON_MAY, ANOTHER_VERSION
from grader.engine.results import Result
from grader.ground.text import printable
from grader.people.standing import Standing
from grader.report import words

KINDS = {
    "appeal": "Appeal",
    "not-judged": "Not judged",
    "unreadable": "Unreadable",
    "empty": "Empty",
    "nothing": "Nothing earned",
    "timed-out": "Timed out",
    "not-understood": "Answer not understood",
    "tampering": "Tampering",
    "not-placed": "Not placed",
    "unknown-person": "Not in the roster",
    "lateness": "Unknown lateness",
    "outdated": "Points by hand out of date",
    "same-files": "Same files",
    "alike": "Alike",
    "picture": "Picture without code",
    "other-picture": "Picture of other curves",
    "boundary": "Near a boundary",
}
"""How the reasons are called, the most pressing first."""
_STEP = 10  # boundaries: every tenth of what there is to earn
_NEAR = 1.0


def address(group: Group) -> str:
    return f"/groups/{group.kind}/{quote(group.key, safe='')}"


@dataclass(frozen=True)
class Reason:
    """Why somebody should look at a submission; `about` changes with the fact, so that a tick is for this one alone."""

    kind: str
    sentence: str
    who: tuple[str, ...] = ()

    @property
    def about(self) -> str:
        return about(self.sentence, self.who)

    @property
    def title(self) -> str:
        return KINDS[self.kind]


@dataclass(frozen=True)
class Look:
    """A reason of one submission, of several (`others` are alike), or (without an id) of the class, and who has looked."""

    id: str
    reason: Reason
    tick: Tick | None
    others: tuple[str, ...] = ()

    @property
    def ids(self) -> tuple[str, ...]:
        return (self.id, *self.others)

    @property
    def together(self) -> str:
        """Where one decision stands for all of them; "" where it is about one."""
        return address(alike(self.ids)) if self.others else ""

    @property
    def key(self) -> str:
        """What a form sends: kinds, digests and ids hold no slash."""
        return f"{self.reason.kind}/{self.reason.about}/{self.id}"


def looks(
    standings: Mapping[str, Standing],
    cliques: Sequence[Clique],
    told: Mapping[str, Sequence[str]],
    appeals: Iterable[Appeal],
    ticks: Mapping[tuple[str, str, str], Tick],
) -> list[Look]:
    """Every reason, the most pressing kind first, within a kind in the order of the class."""
    found: list[tuple[tuple[str, ...], Reason]]
    found = [(("",), Reason("not-placed", printable(line, 500))) for line in told.get("leftover", ())]
    found += [((id_,), reason) for id_, each in standings.items() for reason in _own(each)]
    found += _of_several(standings, cliques)
    unknown = Reason("unknown-person", "Not in the roster, or not to be told apart there.")
    found += [((id_,), unknown) for id_ in told.get("unknown", ()) if id_ in standings]
    found += [((each.id,), _appeal(each)) for each in appeals if not each.answered and each.id in standings]
    rank = {kind: place for place, kind in enumerate(KINDS)}
    order = {id_: place for place, id_ in enumerate(standings)}
    found.sort(key=lambda item: (rank[item[1].kind], order.get(item[0][0], -1)))
    return [Look(ids[0], each, ticks.get((ids[0], each.kind, each.about)), tuple(ids[1:])) for ids, each in found]


def _own(standing: Standing) -> Iterator[Reason]:
    result = standing.result
    if standing.final is None:
        open_ = [
            check.title for part in result.criteria for check in part.checks if standing.check_points(check) is None
        ]
        yield Reason("not-judged", f"The grader failed here; the points are open: {_some(open_)}")
    if result.status in ("empty", "unreadable"):
        yield Reason(result.status, why_empty(result))
    if result.status == "graded" and not result.score:
        yield Reason("nothing", "Nothing was earned: look whether another lab was handed in.")
    if timed_out(result):
        yield Reason("timed-out", "Every check timed out: look at what the code does.")
    if not_understood(result):
        yield Reason("not-understood", "An answer could not be understood: look at what the code returns.")
    if "tampering" in result.misconceptions:
        yield Reason(
            "tampering", "The code changes what it runs beside: look at what it does. This cost nothing by itself."
        )
    if standing.late is not None and standing.late.seconds is None:
        yield Reason(
            "lateness",
            "Late, but no time says how late: nothing is taken off. Give a column `submitted` in the roster and grade again, or "
            "decide by hand.",
        )
    for each in standing.outdated():
        points = words.number(each.points or 0.0)
        yield Reason(
            "outdated",
            f"{each.criterion} was set to {points} by hand on {each.at}; the automatic points or their worth have changed since.",
        )
    yield from (Reason("picture", note) for note in words.notes(result) if A_PERSON_MAY in note)
    yield from (Reason("other-picture", note) for note in words.notes(result) if ANOTHER_VERSION in note)
    yield from _near_a_boundary(standing, result)


def _near_a_boundary(standing: Standing, result: Result) -> Iterator[Reason]:
    """Less than a point below the next tenth, where checks that were earned in part leave as much open to judgement."""
    rows = [check for part in result.criteria for check in part.checks if check.outcome == "partial"]
    partly = [check for check in rows if standing.check_points(check) == check.points]
    room = round(sum(check.max_points - (check.points or 0.0) for check in partly), 2)
    if standing.final is None or not partly or not result.max_score:
        return
    step = result.max_score / _STEP
    below = round(-standing.final % step, 2)
    if 0 < below <= min(_NEAR, room):
        boundary = words.number(round(standing.final + below, 2))
        yield Reason(
            "boundary",
            f"{words.number(below)} below {boundary}, and {words.number(room)} points hang on what was earned in part: "
            f"{_some([check.title for check in partly])}",
        )


def _of_several(
    standings: Mapping[str, Standing], cliques: Sequence[Clique]
) -> Iterator[tuple[tuple[str, ...], Reason]]:
    same = [tuple(ids) for ids in equal(standings.values())]
    for ids in same:
        yield ids, Reason("same-files", f"{len(ids)} handed in the same files.", ids)
    for clique in cliques:
        if not any(set(ids) >= set(clique.ids) for ids in same):  # that the same files are alike is no second reason
            share = f"{100 * clique.share[1]:.0f} % of the smaller one's own code"
            yield clique.ids, Reason("alike", f"Code that is alike beyond the sheet, up to {share}.", clique.ids)


def _appeal(appeal: Appeal) -> Reason:
    about = f" about {printable(appeal.about, 80)}" if appeal.about else ""
    return Reason("appeal", f"Appeal {appeal.number}{about}: {printable(' '.join(appeal.text.split()), 160)}")


def _some(names: Sequence[str], most: int = 8) -> str:
    shown = ", ".join(printable(name, 80) for name in names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown
