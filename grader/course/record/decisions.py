"""Decisions of people about a class, stored with author and time: overrides, comments, reviews, answers to regrade requests."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Sequence, Set
from dataclasses import astuple, dataclass

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.record.database import Database, read
from grader.engine.results import Result
from grader.people.final_grade import Adjustment
from grader.report import words

_ADJUSTMENT = "id, criterion, points, comment, author, at, beneath, alone, decision"


def about(sentence: str, who: Sequence[str] = ()) -> str:
    """Return a digest of a review queue item's `sentence` and submission ids; if it changes, the item needs another review."""
    return hashlib.sha256("\n".join((sentence, *who)).encode("utf-8", "replace")).hexdigest()[:16]


def why_empty(result: Result) -> str:
    """Return why there is nothing to grade in a submission, for the review queue: its notes, or else its status in words."""
    return " ".join(words.notes(result)) or words.STATUS[result.status]


def is_reviewed(id_: str, result: Result, reviews: Collection[tuple[str, str, str]]) -> bool:
    """Return whether a submission is empty or unreadable and reviewed: then it counts 0. `reviews` is from `Decisions.reviews`."""
    return result.status in ("empty", "unreadable") and (id_, result.status, about(why_empty(result))) in reviews


class OvertakenError(RequestError):
    """Exception: another person changed the same submission after the page was loaded, so the form is refused."""


@dataclass(frozen=True)
class Review:
    """A person's entry that an item of the review queue is done, or (`done` False) open again.

    `reason` is the kind of the item, and `about` a digest of its sentence: the review counts while that stays the same.
    """

    id: str
    reason: str
    about: str
    done: bool
    author: str
    at: str


@dataclass(frozen=True)
class RegradeRequest:
    """A student's request to regrade; `about` is a check or a criterion, "" if none is named. The text is untrusted.

    `at` is when it was stored; `answer`, `author` and `answered` (when) are the reply, each "" while the request is open.
    """

    id: str
    about: str
    text: str
    at: str
    answer: str = ""
    author: str = ""
    answered: str = ""
    number: int = 0


class Decisions(Database):
    """Tables of the class database for what people decide: overrides, comments, reviews and answers to regrade requests."""

    def adjust(self, adjustments: Iterable[tuple[str, Adjustment]], seen: int | None = None, what: str = "") -> int:
        """Store adjustments (overrides, bonuses, comments) by submission id, all or none. Earlier ones stay in the history.

        Parameters
        ----------
        seen
            The number of the last adjustment that the author has seen; None skips the comparison.
        what
            The subject of one decision on several submissions; the decision gets a number, which is returned. "" returns 0.

        Raises
        ------
        OvertakenError
            If these submissions have an adjustment later than `seen`.
        """
        made = list(adjustments)
        with self._errors_in_one_line(), self._transaction():
            if seen is not None:
                self._refuse_overtaken({id_ for id_, _ in made}, seen)
            number = self._decision(what, made[0][1]) if what and made else 0
            rows = [
                (id_, a.criterion, a.points, a.comment, a.author, a.at, _automatic_points_text(a), a.alone, number)
                for id_, a in made
            ]
            self._db.executemany(f"INSERT INTO adjustments ({_ADJUSTMENT}) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", rows)
        return number

    def _decision(self, what: str, first: Adjustment) -> int:
        made = self._db.execute(
            "INSERT INTO decisions (what, author, at) VALUES (?, ?, ?)", (what, first.author, first.at)
        )
        return int(made.lastrowid or 0)

    def _refuse_overtaken(self, ids: Set[str], seen: int) -> None:
        query = "SELECT id, author FROM adjustments WHERE seq > ? ORDER BY seq DESC"
        for id_, author in self._db.execute(query, (seen,)):
            if id_ in ids:
                raise OvertakenError(
                    f"{printable(id_, 80)}: {printable(author, 80)} changed something after you opened the page"
                )

    def history(self) -> list[tuple[str, Adjustment]]:
        """Return every override, bonus and comment ever stored, with its submission's id, oldest first; also withdrawn ones."""
        with self._errors_in_one_line():
            rows = self._db.execute(f"SELECT {_ADJUSTMENT}, seq FROM adjustments ORDER BY seq").fetchall()
            return [
                (
                    id_,
                    Adjustment(
                        criterion,
                        points,
                        comment,
                        author,
                        at,
                        *read(_automatic_points, record),
                        bool(alone),
                        decision,
                        seq,
                    ),
                )
                for id_, criterion, points, comment, author, at, record, alone, decision, seq in rows
            ]

    def last_adjustment(self) -> int:
        """Return the number of the last stored override or comment, which a page keeps to notice later ones; 0 if there is none."""
        return int(self._value("SELECT coalesce(max(seq), 0) FROM adjustments"))

    def adjustments(self) -> dict[str, tuple[Adjustment, ...]]:
        """Return the adjustments in force by submission id: the last override and the last comment of each target.

        A withdrawn one is left out, and no earlier one replaces it. A target is a criterion, a check, the total or the bonus.
        """
        last: dict[str, dict[tuple[str, bool], Adjustment]] = {}
        for id_, adjustment in self.history():
            last.setdefault(id_, {})[adjustment.criterion, adjustment.alone] = adjustment
        return {id_: tuple(a for a in each.values() if not a.withdraws) for id_, each in last.items()}

    def decisions(self) -> dict[int, str]:
        """Return what each decision on several submissions was about, by its number, under which it can be undone."""
        with self._errors_in_one_line():
            return dict(self._db.execute("SELECT number, what FROM decisions ORDER BY number"))

    def keep_reviews(self, reviews: Iterable[Review]) -> None:
        """Store that items of the review queue were reviewed, or opened again; earlier entries stay in the history."""
        with self._errors_in_one_line(), self._transaction():
            query = "INSERT INTO ticks (id, reason, about, done, author, at) VALUES (?, ?, ?, ?, ?, ?)"
            self._db.executemany(query, [astuple(each) for each in reviews])

    def reviews(self) -> dict[tuple[str, str, str], Review]:
        """Return the last review of each queue item, by (submission id, kind of item, digest from `about`), unless opened again."""
        with self._errors_in_one_line():
            rows = self._db.execute("SELECT id, reason, about, done, author, at FROM ticks ORDER BY seq").fetchall()
        last = {
            (id_, reason, about): Review(id_, reason, about, bool(done), *who)
            for id_, reason, about, done, *who in rows
        }
        return {key: review for key, review in last.items() if review.done}

    def keep_regrade_requests(self, requests: Iterable[RegradeRequest]) -> int:
        """Store regrade requests, except those with the submission, subject and text of a stored one; return how many are new."""
        query = "INSERT OR IGNORE INTO appeals (id, about, text, at) VALUES (?, ?, ?, ?)"
        with self._errors_in_one_line(), self._transaction():
            return sum(self._db.execute(query, (a.id, a.about, a.text, a.at)).rowcount for a in requests)

    def regrade_requests(self) -> list[RegradeRequest]:
        """Return all regrade requests, open and answered, in the order in which they were stored."""
        with self._errors_in_one_line():
            rows = self._db.execute(
                "SELECT id, about, text, at, answer, author, answered, number FROM appeals ORDER BY number"
            )
            return [RegradeRequest(*row) for row in rows.fetchall()]

    def answer(self, number: int, answer: str, author: str, at: str) -> None:
        query = "UPDATE appeals SET answer = ?, author = ?, answered = ? WHERE number = ?"
        self._write(query, answer, author, at, number)


def _automatic_points_text(adjustment: Adjustment) -> str:
    """Format the automatic points that an override replaces as JSON, ``{check: [points, maximum]}``, to notice later changes."""
    out_of = adjustment.out_of
    return json.dumps({id_: [points, out_of.get(id_)] for id_, points in adjustment.automatic.items()})


def _automatic_points(text: str) -> tuple[dict[str, float | None], dict[str, float]]:
    """Parse the JSON of `_automatic_points_text`: points by check, and maximum by check, without those that are unknown."""
    rows = json.loads(text)
    return {id_: row[0] for id_, row in rows.items()}, {id_: row[1] for id_, row in rows.items() if row[1] is not None}
