"""The durable record of a class: one SQLite file, and one committed row for each result.

A run that is killed loses at most the submissions that it was marking. The table `results` keeps every result ever recorded.
The table `class` points to the present result of each submission, so grading a part of a class keeps the rest. Other tables
hold the hand-ins, the complete history of adjustments, and digests of the written pages.
"""

from __future__ import annotations

import hashlib
import json
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from pathlib import Path
from typing import TypeVar

import msgspec

from grader.base import stamps
from grader.course.record import class_settings
from grader.course.record.class_settings import ClassSettings
from grader.course.record.database import read
from grader.course.record.decisions import Decisions, is_reviewed
from grader.course.record.drafts import Drafts
from grader.course.record.repair_log import RepairLog
from grader.engine.chart_data import Chart, unpacked
from grader.engine.marks import fits, marked
from grader.engine.results import Result, from_dict, to_record
from grader.engine.rubric import Rubric
from grader.people.final_grade import (
    NOTHING_KNOWN,
    FinalGrade,
    HandIn,
)

T = TypeVar("T")

_KEEP = """
INSERT INTO results (id, submission_sha256, rubric_sha256, traces_sha256, grader, status, record, charts, fingerprint)
VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)
ON CONFLICT (id, submission_sha256, rubric_sha256, traces_sha256, grader)
DO UPDATE SET status = excluded.status, record = excluded.record, charts = excluded.charts, fingerprint = excluded.fingerprint
"""
_REMARK = """
INSERT INTO results (id, submission_sha256, rubric_sha256, traces_sha256, grader, status, record, charts, fingerprint)
SELECT id, submission_sha256, ?, traces_sha256, grader, status, ?, charts, fingerprint FROM results WHERE seq = ?
ON CONFLICT (id, submission_sha256, rubric_sha256, traces_sha256, grader) DO UPDATE SET record = excluded.record
"""
_FORMER = """
INSERT OR REPLACE INTO former
SELECT ?, class.id, class.seq, coalesce(hand_ins.record, '') FROM class LEFT JOIN hand_ins ON hand_ins.id = class.id
"""
_HAND_IN = "INSERT OR REPLACE INTO hand_ins VALUES (?, ?)"
_WHERE = "WHERE id = ? AND submission_sha256 = ? AND rubric_sha256 = ? AND traces_sha256 = ? AND grader = ?"


@dataclass(frozen=True)
class Key:
    """Everything that a result depends on. Two runs with equal keys give equal results."""

    id: str
    submission_sha256: str
    rubric_sha256: str
    traces_sha256: str
    grader: str


class Store(Decisions, RepairLog, Drafts):
    """The record of a class in `OUT/results.sqlite`: results, hand-ins, decisions and settings."""

    def __init__(self, out: Path) -> None:
        self._known: dict[str, tuple[str, Result]] = {}
        super().__init__(out)

    def keep(self, key: Key, result: Result) -> None:
        """Commit one result and make it the present one, by which the submission counts."""
        with self._errors_in_one_line(), self._transaction():
            evidence = (result.evidence.charts, array("Q", result.evidence.fingerprint).tobytes())
            self._db.execute(_KEEP, (*astuple(key), result.status, _text(result), *evidence))
            self._make_current(key)

    def recall(self, key: Key) -> Result | None:
        """Return the result recorded under this key and make it the present one; None if it is missing or incomplete."""
        present = "(SELECT class.seq FROM class WHERE class.id = results.id) IS seq"
        query = f"SELECT record, {present} FROM results {_WHERE} AND status != 'incomplete'"
        with self._errors_in_one_line():
            row = self._db.execute(query, astuple(key)).fetchone()
            if row is None:
                return None
            record, is_present = row
            if not is_present:
                self.make_current(key)
            return self._parsed(key.id, record)

    def result(self, key: Key) -> Result | None:
        """Return the result recorded under this key without making it the present one; None if there is none."""
        record = self._value(f"SELECT record FROM results {_WHERE}", *astuple(key))
        return None if record is None else self._read(_result, record)

    def is_first_search(self, key: Key) -> bool:
        """Record that a repair of these files was searched for, and return whether that was the first time, so none is repeated."""
        return self._write("INSERT OR IGNORE INTO tried VALUES (?)", json.dumps(astuple(key))) > 0

    def remark(self, key: Key, rubric: Rubric) -> Result | None:
        """Regrade a submission by another rubric from its record, and store the result; None if that needs another run."""
        with self._errors_in_one_line(), self._transaction():
            if (found := self._fitting(key, rubric)) is None:
                return None
            seq, before = found
            result = marked(before, rubric)
            text = _text(result)
            self._db.execute(_REMARK, (rubric.sha256, text, seq))
            self._make_current(replace(key, rubric_sha256=rubric.sha256))
            self._known[key.id] = text, result
            return result

    def _fitting(self, key: Key, rubric: Rubric) -> tuple[int, Result] | None:
        """Return the latest complete result of the same files and scenarios that holds all facts that `rubric` asks for."""
        query = (
            "SELECT seq, record FROM results WHERE id = ? AND submission_sha256 = ? AND traces_sha256 = ? AND grader = ? "
            "AND status != 'incomplete' ORDER BY seq DESC"
        )
        same = (key.id, key.submission_sha256, key.traces_sha256, key.grader)
        results = ((seq, _result(record)) for seq, record in self._db.execute(query, same))
        return next(((seq, result) for seq, result in results if fits(result, rubric)), None)

    def settings(self) -> ClassSettings | None:
        """Return the settings that the class is graded by; None if the record has none."""
        record = self._value("SELECT record FROM settings ORDER BY number DESC LIMIT 1")
        return None if record is None else self._read(class_settings.from_json, record)

    def keep_settings(self, settings: ClassSettings, *, keep_before: bool = False) -> None:
        """Record the settings of the class.

        With `keep_before` the present results stay on record as the previous version. Without it the new settings replace the last
        ones, which is right if they change no score.
        """
        if settings == self.settings():
            return
        with self._errors_in_one_line(), self._transaction():
            self._keep_settings(settings, keep_before)

    def _keep_settings(self, settings: ClassSettings, keep_before: bool) -> None:
        """Write the settings with the next number if the former results are kept, else in place of the last ones."""
        number = self._value("SELECT coalesce(max(number), 0) FROM settings")
        if keep_before:
            self._db.execute(_FORMER, (number,))
        if keep_before or not number:
            number += 1
        row = (number, stamps.now(), class_settings.to_json(settings))
        self._db.execute("INSERT OR REPLACE INTO settings VALUES (?, ?, ?)", row)

    def former(self) -> dict[str, FinalGrade]:
        """Return the final grades of the previous version with the present overrides; empty if there is no such version."""
        query = (
            "SELECT former.id, record, hand_in FROM former JOIN results USING (seq) "
            "WHERE number = (SELECT max(number) FROM former) ORDER BY former.id"
        )
        with self._errors_in_one_line():
            return self._final_grades(
                (id_, _result(record), read(_hand_in, hand_in) if hand_in else NOTHING_KNOWN)
                for id_, record, hand_in in self._db.execute(query).fetchall()
            )

    def _final_grades(self, rows: Iterable[tuple[str, Result, HandIn]]) -> dict[str, FinalGrade]:
        adjustments, reviews = self.adjustments(), self.reviews()
        return {
            id_: FinalGrade(id_, result, hand_in, adjustments.get(id_, ()), is_reviewed(id_, result, reviews))
            for id_, result, hand_in in rows
        }

    def has(self, key: Key, rubric: Rubric) -> bool:
        """Return whether the submission need not run again.

        On record is either a result under `key` that is not ``incomplete``, or one of the same files and scenarios that can be
        marked by `rubric` without running code.
        """
        if self._value(f"SELECT 1 FROM results {_WHERE} AND status != 'incomplete'", *astuple(key)):
            return True
        with self._errors_in_one_line():
            return self._fitting(key, rubric) is not None

    def remark_class(
        self, mark: Callable[[dict[str, FinalGrade]], dict[str, FinalGrade]], rubric: Rubric
    ) -> dict[str, FinalGrade]:
        """Record the final grades that `mark` computes by another rubric, for the whole class or not at all, and return them.

        One transaction covers reading and writing, so no other process can change a result in between.
        """
        query = "SELECT class.id, submission_sha256, traces_sha256, grader, seq FROM class JOIN results USING (seq)"
        with self._errors_in_one_line(), self._transaction():
            after = mark(self.final_grades())
            settings = self.settings()
            if settings is not None:
                self._keep_settings(settings.with_rubric(rubric), keep_before=True)
            for id_, submission, traces, grader, seq in self._db.execute(query).fetchall():
                self._db.execute(_REMARK, (rubric.sha256, _text(after[id_].result), seq))
                self._make_current(Key(id_, submission, rubric.sha256, traces, grader))
                self._db.execute(_HAND_IN, (id_, _hand_in_text(after[id_].hand_in)))
        return after

    def present(self) -> dict[str, Result]:
        """Return the present result of every submission, by id, in the order of the ids."""
        query = "SELECT class.id, record FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._errors_in_one_line():
            return {id_: self._parsed(id_, record) for id_, record in self._db.execute(query)}

    def _parsed(self, id_: str, record: str) -> Result:
        """Parse a present result, with a cache: a run reads each result twice, and parsing takes most of the time."""
        text, result = self._known.get(id_, ("", None))
        if result is None or text != record:
            result = _result(record)
            self._known[id_] = record, result
        return result

    def digest(self, id_: str) -> str:
        """Return a digest of the present result as it is recorded; "" if there is none."""
        record = self._value("SELECT record FROM class JOIN results USING (seq) WHERE class.id = ?", id_)
        return "" if record is None else hashlib.sha256(self._read(str.encode, record)).hexdigest()

    def charts(self, id_: str) -> tuple[Chart, ...]:
        """Return the charts of a submission's present result, for its report; empty if there are none."""
        return self._read(unpacked, self.packed_charts(id_))

    def packed_charts(self, id_: str) -> bytes:
        """Return the charts of a submission's present result as recorded bytes; empty if there are none."""
        record = self._value("SELECT charts FROM class JOIN results USING (seq) WHERE class.id = ?", id_)
        return b"" if record is None else self._read(_blob, record)

    def fingerprints(self) -> dict[str, tuple[int, ...]]:
        """Return the fingerprint of every submission's code, hashes that show similar code, by id."""
        query = "SELECT class.id, fingerprint FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._errors_in_one_line():
            return {id_: read(_hashes, record) for id_, record in self._db.execute(query)}

    def final_grades(self) -> dict[str, FinalGrade]:
        """Return the final grade of every submission from result, hand-in and adjustments, by id, in the order of the ids."""
        hand_ins = self.hand_ins()
        found = self._final_grades(
            (id_, result, hand_ins.get(id_, NOTHING_KNOWN)) for id_, result in self.present().items()
        )
        found = {id_: each for id_, each in found.items() if each.adjustments or not each.has_no_submission}
        names = Counter(each.name.casefold() for each in found.values())
        return {
            id_: replace(each, namesake=True) if names[each.name.casefold()] > 1 else each
            for id_, each in found.items()
        }

    def keep_hand_in(self, id_: str, hand_in: HandIn) -> None:
        """Record who handed in a submission and when, in place of the earlier record."""
        row = (id_, _hand_in_text(hand_in))
        if self._value("SELECT 1 FROM hand_ins WHERE id = ? AND record = ?", *row) is None:
            self._write(_HAND_IN, *row)

    def page_digest(self, id_: str) -> str:
        """Return the digests of a submission's pages that `keep_page_digest` last recorded; "" if there are none."""
        return str(self._value("SELECT digest FROM pages WHERE id = ?", id_) or "")

    def keep_page_digest(self, id_: str, digests: str) -> None:
        self._write("INSERT OR REPLACE INTO pages VALUES (?, ?)", id_, digests)

    def hand_ins(self) -> dict[str, HandIn]:
        """Return the last recorded hand-in of each submission, by id."""
        with self._errors_in_one_line():
            rows = self._db.execute("SELECT id, record FROM hand_ins").fetchall()
            return {id_: read(_hand_in, record) for id_, record in rows}

    def keep_files(self, submission_sha256: str, pack: Callable[[], bytes]) -> None:
        """Record submitted files unless they are already on record; `pack` is called only if they are not."""
        if self._value("SELECT 1 FROM files WHERE submission_sha256 = ?", submission_sha256) is None:
            self._write("INSERT OR IGNORE INTO files VALUES (?, ?)", submission_sha256, pack())

    def files(self, submission_sha256: str) -> bytes:
        """Return the files that `keep_files` recorded, packed; empty if there are none."""
        return bytes(self._value("SELECT packed FROM files WHERE submission_sha256 = ?", submission_sha256) or b"")

    def keep_notices(self, notices: Mapping[str, Sequence[str]]) -> None:
        """Record the messages of a run about the class, by kind, in place of those of the previous run."""
        with self._errors_in_one_line(), self._transaction():
            self._db.execute("DELETE FROM told")
            self._db.executemany(
                "INSERT INTO told VALUES (?, ?)", [(kind, line) for kind in notices for line in notices[kind]]
            )

    def notices(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        with self._errors_in_one_line():
            for kind, line in self._db.execute("SELECT kind, line FROM told ORDER BY rowid"):
                found.setdefault(kind, []).append(line)
        return found

    def make_current(self, key: Key) -> None:
        """Make the result recorded under this key the one by which its submission counts."""
        with self._errors_in_one_line(), self._transaction():
            self._make_current(key)

    def _make_current(self, key: Key) -> None:
        """Make the result with this key the current one of its submission."""
        self._db.execute(
            f"INSERT INTO class (id, seq) SELECT id, seq FROM results {_WHERE} "
            "ON CONFLICT (id) DO UPDATE SET seq = excluded.seq",
            astuple(key),
        )


def _text(result: Result) -> str:
    return json.dumps(to_record(result), ensure_ascii=True, allow_nan=False)


def _result(record: object) -> Result:
    return read(lambda text: from_dict(json.loads(text)), record)


def _hand_in_text(hand_in: HandIn) -> str:
    return json.dumps(asdict(hand_in), ensure_ascii=True, allow_nan=False)


def _hand_in(text: str) -> HandIn:
    return msgspec.convert(json.loads(text), HandIn)


def _blob(record: object) -> bytes:
    if not isinstance(record, bytes):
        raise TypeError("text in place of bytes")
    return record


def _hashes(record: bytes) -> tuple[int, ...]:
    return tuple(array("Q", record))
