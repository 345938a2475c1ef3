"""Points by hand: proved against the record, kept apart from the automatic marks, published at once."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from grader.course.publishing import publish, publish_class
from grader.course.record import Store
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import guess_at
from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.standing import Adjustment, Standing, beneath
from grader.report import words

COLUMNS = ("id", "criterion", "points", "comment")
MAX_COMMENT = 2000


@dataclass(frozen=True)
class Wish:
    """What someone wants: `points` is text as it was written; "" withdraws. `place` is what messages begin with."""

    id: str
    criterion: str
    points: str
    comment: str
    place: str = "adjust"


def read_wishes(path: Path) -> list[Wish]:
    """The adjustments of a CSV with the columns id, criterion, points and comment; blank points withdraw."""
    source = printable(str(path), 500)
    try:
        table = csv.DictReader(io.StringIO(path.read_text(encoding="utf-8-sig"), newline=""))
        if not set(COLUMNS) <= set(table.fieldnames or ()):
            raise RequestError(f"{source}:1: the first line must name the columns {', '.join(COLUMNS)}")
        return [_wish(row, f"{source}:{table.line_num}") for row in table]
    except OSError as error:
        raise RequestError(f"{source}: cannot be read ({error.strerror}); give the path of a CSV file") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise RequestError(f"{source}: is not a CSV file in UTF-8; save it as one") from error


def _wish(row: Mapping[str, str | None], place: str) -> Wish:
    id_, criterion, points, comment = ((row[column] or "").strip() for column in COLUMNS)
    return Wish(id_, criterion, points, comment, place)


def adjust(lab: Lab, out: Path, wishes: Sequence[Wish], author: str) -> list[str]:
    """Record all of them, or none, and write the pages anew; a line on each.

    The same wish again changes nothing, so that a table can be given twice; it confirms one whose marks beneath have changed.

    Raises
    ------
    RequestError
        With a line for each wish that cannot be met.
    """
    with Store.existing(out) as store:
        standings = store.standings()
        said = {(id_, each.criterion) for id_, each in store.history()}
        problems = [problem for wish in wishes if (problem := _problem(wish, standings, said))]
        if problems:
            raise RequestError("\n".join(problems))
        now = datetime.now(timezone.utc).isoformat(timespec="seconds")
        made = [(wish.id, _adjustment(wish, standings[wish.id], author, now)) for wish in wishes]
        fresh = [(id_, each) for id_, each in made if not _stands(each, standings[id_])]
        store.adjust(fresh)
        after = publish_class(out, store, lab)
        for id_ in dict.fromkeys(id_ for id_, _ in fresh):
            publish(out, after[id_], store)
    return [_told(id_, each, after[id_], fresh=(id_, each) in fresh) for id_, each in made]


def listing(out: Path) -> Iterator[str]:
    """Every adjustment ever made, oldest first: who, when, why."""
    with Store.existing(out) as store:
        for id_, each in store.history():
            points = "withdrawn" if each.points is None else words.number(each.points)
            who = f"{each.at} by {printable(each.author, 80)}: {printable(each.comment, MAX_COMMENT)}"
            yield f"{printable(id_, 80)} {each.criterion} {points}  {who}"


def _problem(wish: Wish, standings: Mapping[str, Standing], said: Set[tuple[str, str]]) -> str:
    """Why a wish cannot be met, or ""; `said` holds whose criteria were ever adjusted, withdrawn since or not."""
    if wish.id not in standings:
        return f"{wish.place}: there is no submission {printable(wish.id)}{guess_at(wish.id, standings)}"
    known = {criterion.id: criterion for criterion in standings[wish.id].result.criteria}
    if wish.criterion not in known:
        return f"{wish.place}: there is no criterion {printable(wish.criterion)}{guess_at(wish.criterion, known)}"
    most = known[wish.criterion].max_points
    points = _number(wish.points)
    if wish.points and (points is None or not 0 <= points <= most or round(points, 2) != points):
        return f"{wish.place}: points must be a number from 0 to {words.number(most)}, not {printable(wish.points, 60)}"
    if not wish.points and (wish.id, wish.criterion) not in said:
        return f"{wish.place}: {printable(wish.id)} has no adjustment of {wish.criterion} to withdraw"
    if not wish.comment.strip() or len(wish.comment) > MAX_COMMENT:
        return f"{wish.place}: say why in a comment of at most {MAX_COMMENT} characters"
    return ""


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _adjustment(wish: Wish, standing: Standing, author: str, now: str) -> Adjustment:
    criterion = next(c for c in standing.result.criteria if c.id == wish.criterion)
    comment = wish.comment.strip().encode("utf-8", "replace").decode()
    return Adjustment(wish.criterion, _number(wish.points), comment, author, now, beneath(criterion))


def _stands(wish: Adjustment, standing: Standing) -> bool:
    """Whether it is in force already, on the same marks; or withdrawn already."""
    now = standing.adjustment(wish.criterion)
    if now is None:
        return wish.points is None
    return (now.points, now.comment, now.beneath) == (wish.points, wish.comment, wish.beneath)


def _told(id_: str, wish: Adjustment, standing: Standing, *, fresh: bool) -> str:
    final = "open" if standing.final is None else words.number(standing.final)
    points = "withdrawn" if wish.points is None else words.number(wish.points)
    return f"{printable(id_, 80)} {wish.criterion} {points}{'' if fresh else ' (as before)'}, final {final}"
