"""The class database: one SQLite file, in which each result is one row, committed as soon as it is known.

A run that is killed loses at most the submissions that it was grading. The table `results` keeps every result ever made. The table
`class` points to the current result of each submission, so grading a part of a class keeps the rest. Other tables hold who handed
in, the complete history of adjustments, and digests of the written pages.
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
    """Key of a stored result: all that it depends on (id, files, rubric, scenarios, grader), so that nothing is graded twice."""

    id: str
    submission_sha256: str
    rubric_sha256: str
    traces_sha256: str
    grader: str


class Store(Decisions, RepairLog, Drafts):
    """The class database, `results.sqlite` in the output folder: results, who handed in, decisions, repairs and settings."""

    def __init__(self, out: Path) -> None:
        self._known: dict[str, tuple[str, Result]] = {}
        super().__init__(out)

    def keep(self, key: Key, result: Result) -> None:
        """Store one result immediately, and make it the current one, by which the submission counts."""
        with self._errors_in_one_line(), self._transaction():
            evidence = (result.evidence.charts, array("Q", result.evidence.fingerprint).tobytes())
            self._db.execute(_KEEP, (*astuple(key), result.status, _text(result), *evidence))
            self._make_current(key)

    def recall(self, key: Key) -> Result | None:
        """Return this key's stored result, made current, to resume a run; None if it is missing or the grader failed on a check."""
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
        """Return the stored result of this key, current or not, such as that before a repair; None if there is none."""
        record = self._value(f"SELECT record FROM results {_WHERE}", *astuple(key))
        return None if record is None else self._read(_result, record)

    def is_first_search(self, key: Key) -> bool:
        """Record a search for a repair with this key; return whether it is the first one, so that a long search runs once."""
        return self._write("INSERT OR IGNORE INTO tried VALUES (?)", json.dumps(astuple(key))) > 0

    def remark(self, key: Key, rubric: Rubric) -> Result | None:
        """Regrade `key`'s last result, of any rubric, that measured all that `rubric` needs; make it current. None without one."""
        with self._errors_in_one_line(), self._transaction():
            if (found := self._find_regradable(key, rubric)) is None:
                return None
            seq, before = found
            result = marked(before, rubric)
            text = _text(result)
            self._db.execute(_REMARK, (rubric.sha256, text, seq))
            self._make_current(replace(key, rubric_sha256=rubric.sha256))
            self._known[key.id] = text, result
            return result

    def _find_regradable(self, key: Key, rubric: Rubric) -> tuple[int, Result] | None:
        """Find the latest complete result of the same files and scenarios with all facts for `rubric`: row and result, or None."""
        query = (
            "SELECT seq, record FROM results WHERE id = ? AND submission_sha256 = ? AND traces_sha256 = ? AND grader = ? "
            "AND status != 'incomplete' ORDER BY seq DESC"
        )
        same = (key.id, key.submission_sha256, key.traces_sha256, key.grader)
        results = ((seq, _result(record)) for seq, record in self._db.execute(query, same))
        return next(((seq, result) for seq, result in results if fits(result, rubric)), None)

    def settings(self) -> ClassSettings | None:
        """Return the settings that the class is graded by; None if none are stored."""
        record = self._value("SELECT record FROM settings ORDER BY number DESC LIMIT 1")
        return None if record is None else self._read(class_settings.from_json, record)

    def keep_settings(self, settings: ClassSettings, *, keep_before: bool = False) -> None:
        """Store the settings of the class, unless they are equal to the last ones.

        With `keep_before` the current results are kept as the previous version, to compare with. Without it the new settings
        replace the last ones, which is right if they change no score.
        """
        if settings == self.settings():
            return
        with self._errors_in_one_line(), self._transaction():
            self._keep_settings(settings, keep_before)

    def _keep_settings(self, settings: ClassSettings, keep_before: bool) -> None:
        """Write the settings under the next number if the current results are kept as the previous version, else in place."""
        number = self._value("SELECT coalesce(max(number), 0) FROM settings")
        if keep_before:
            self._db.execute(_FORMER, (number,))
        if keep_before or not number:
            number += 1
        row = (number, stamps.now(), class_settings.to_json(settings))
        self._db.execute("INSERT OR REPLACE INTO settings VALUES (?, ?, ?)", row)

    def former(self) -> dict[str, FinalGrade]:
        """Return the final grades before the last change of settings, with the present overrides; empty if there was no change."""
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
        """Return whether a run can reuse a result: that of `key`, if every check was judged, or another, regraded by `rubric`."""
        if self._value(f"SELECT 1 FROM results {_WHERE} AND status != 'incomplete'", *astuple(key)):
            return True
        with self._errors_in_one_line():
            return self._find_regradable(key, rubric) is not None

    def remark_class(
        self, mark: Callable[[dict[str, FinalGrade]], dict[str, FinalGrade]], rubric: Rubric
    ) -> dict[str, FinalGrade]:
        """Regrade a class: give `mark` the present final grades by id; store and return the ones by `rubric` that it returns.

        The new results name `rubric`. If class settings are stored, they get `rubric`, and the results before are kept to compare.
        One transaction covers all: no other process can change a result in between, and nothing is stored if `mark` raises.
        """
        query = "SELECT class.id, submission_sha256, traces_sha256, grader, seq FROM class JOIN results USING (seq)"
        with self._errors_in_one_line(), self._transaction():
            after = mark(self.final_grades())
            settings = self.settings()
            if settings is not None:
                self._keep_settings(settings.with_rubric(rubric), keep_before=True)
            for id_, submission, traces, grader, seq in self._db.execute(query).fetchall():
                if id_ not in after:
                    continue  # a person without a submission whose points were withdrawn
                self._db.execute(_REMARK, (rubric.sha256, _text(after[id_].result), seq))
                self._make_current(Key(id_, submission, rubric.sha256, traces, grader))
                self._db.execute(_HAND_IN, (id_, _hand_in_text(after[id_].hand_in)))
        return after

    def present(self) -> dict[str, Result]:
        """Return the current result of every submission, the one that counts, by submission id in the order of the ids."""
        query = "SELECT class.id, record FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._errors_in_one_line():
            return {id_: self._parsed(id_, record) for id_, record in self._db.execute(query)}

    def _parsed(self, id_: str, record: str) -> Result:
        """Parse a current result, with a cache: a run reads each result twice, and parsing takes most of the time."""
        text, result = self._known.get(id_, ("", None))
        if result is None or text != record:
            result = _result(record)
            self._known[id_] = record, result
        return result

    def digest(self, id_: str) -> str:
        """Return a digest of a submission's current result, to notice that its pages are outdated; "" if there is none."""
        record = self._value("SELECT record FROM class JOIN results USING (seq) WHERE class.id = ?", id_)
        return "" if record is None else hashlib.sha256(self._read(str.encode, record)).hexdigest()

    def charts(self, id_: str) -> tuple[Chart, ...]:
        """Return the charts of a submission's current result, for its report; empty if there are none."""
        return self._read(unpacked, self.packed_charts(id_))

    def packed_charts(self, id_: str) -> bytes:
        """Return the charts of a submission's current result as stored bytes, to notice outdated pages; empty without charts."""
        record = self._value("SELECT charts FROM class JOIN results USING (seq) WHERE class.id = ?", id_)
        return b"" if record is None else self._read(_blob, record)

    def fingerprints(self) -> dict[str, tuple[int, ...]]:
        """Return hashes of pieces of code by submission id; submissions that share many hashes are similar."""
        query = "SELECT class.id, fingerprint FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._errors_in_one_line():
            return {id_: read(_hashes, record) for id_, record in self._db.execute(query)}

    def final_grades(self) -> dict[str, FinalGrade]:
        """Return the final grade of every submission by id: current result, who handed in and when, and overrides in force.

        A person without a submission is included only while an override or comment for them is in force.
        """
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
        """Store who handed in a submission and when, in place of the earlier entry; nothing is written if both are equal."""
        row = (id_, _hand_in_text(hand_in))
        if self._value("SELECT 1 FROM hand_ins WHERE id = ? AND record = ?", *row) is None:
            self._write(_HAND_IN, *row)

    def page_digest(self, id_: str) -> str:
        """Return the digest that `keep_page_digest` stored for a submission's pages, to see if they are current; "" if none."""
        return str(self._value("SELECT digest FROM pages WHERE id = ?", id_) or "")

    def keep_page_digest(self, id_: str, digests: str) -> None:
        self._write("INSERT OR REPLACE INTO pages VALUES (?, ?)", id_, digests)

    def hand_ins(self) -> dict[str, HandIn]:
        """Return who handed in each submission and when, as last stored, by id."""
        with self._errors_in_one_line():
            rows = self._db.execute("SELECT id, record FROM hand_ins").fetchall()
            return {id_: read(_hand_in, record) for id_, record in rows}

    def keep_files(self, submission_sha256: str, pack: Callable[[], bytes]) -> None:
        """Store submitted files for review under their digest; if not stored already, `pack` is called to return the bytes."""
        if self._value("SELECT 1 FROM files WHERE submission_sha256 = ?", submission_sha256) is None:
            self._write("INSERT OR IGNORE INTO files VALUES (?, ?)", submission_sha256, pack())

    def files(self, submission_sha256: str) -> bytes:
        """Return the packed files that `keep_files` stored for this digest, to pass to `unpack`; empty if there are none."""
        return bytes(self._value("SELECT packed FROM files WHERE submission_sha256 = ?", submission_sha256) or b"")

    def keep_notices(self, notices: Mapping[str, Sequence[str]]) -> None:
        """Store a run's messages by kind, for the review queue and to recognise them in the next run; earlier ones are deleted."""
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
        """Make the stored result of this key the one by which its submission counts, as for the best of several attempts."""
        with self._errors_in_one_line(), self._transaction():
            self._make_current(key)

    def _make_current(self, key: Key) -> None:
        """Do what `make_current` does, within a transaction that the caller has begun."""
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
