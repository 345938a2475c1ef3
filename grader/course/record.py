"""The durable record of a class: one SQLite file, one committed row a result.

A run that is killed loses at most the submissions that it was working on. `results` keeps every result ever recorded;
`class` says which of them is the present one of each submission, so that grading a part of a class never shrinks it.
What people add stands apart from it: who handed in and when, adjustments with everything that was ever said, pages written.
"""

from __future__ import annotations

import json
import os
import sqlite3
from array import array
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from pathlib import Path
from types import TracebackType

from grader.engine.evidence import Chart, unpacked
from grader.engine.results import Result, from_dict, to_dict
from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.standing import NOTHING_KNOWN, Adjustment, HandIn, Standing, hand_in_from_dict, hand_in_to_dict

FILE_NAME = "results.sqlite"
SCHEMA_VERSION = 2
_APPLICATION_ID = 0x494D5547  # "IMUG": tells our file from any other SQLite file
_TABLES = """
BEGIN IMMEDIATE;
CREATE TABLE IF NOT EXISTS results (
    seq INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    submission_sha256 TEXT NOT NULL,
    rubric_sha256 TEXT NOT NULL,
    traces_sha256 TEXT NOT NULL,
    grader TEXT NOT NULL,
    status TEXT NOT NULL,
    record TEXT NOT NULL,
    charts BLOB NOT NULL,
    fingerprint BLOB NOT NULL,
    UNIQUE (id, submission_sha256, rubric_sha256, traces_sha256, grader)
);
CREATE TABLE IF NOT EXISTS class (id TEXT PRIMARY KEY, seq INTEGER NOT NULL REFERENCES results (seq));
CREATE TABLE IF NOT EXISTS hand_ins (id TEXT PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS adjustments (
    seq INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    criterion TEXT NOT NULL,
    points REAL,
    comment TEXT NOT NULL,
    author TEXT NOT NULL,
    at TEXT NOT NULL,
    beneath TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS pages (id TEXT PRIMARY KEY, digest TEXT NOT NULL);
PRAGMA application_id = {application};
PRAGMA user_version = {version};
COMMIT;
"""
_KEEP = """
INSERT INTO results (id, submission_sha256, rubric_sha256, traces_sha256, grader, status, record, charts, fingerprint)
VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)
ON CONFLICT (id, submission_sha256, rubric_sha256, traces_sha256, grader)
DO UPDATE SET status = excluded.status, record = excluded.record, charts = excluded.charts, fingerprint = excluded.fingerprint
"""
_ADJUSTMENT = "id, criterion, points, comment, author, at, beneath"
_WHERE = "WHERE id = ? AND submission_sha256 = ? AND rubric_sha256 = ? AND traces_sha256 = ? AND grader = ?"


@dataclass(frozen=True)
class Key:
    """What a result depends on. Two runs with equal keys give equal results."""

    id: str
    submission_sha256: str
    rubric_sha256: str
    traces_sha256: str
    grader: str


class Store:
    """The record in `OUT/results.sqlite`; a context manager, used from one thread."""

    def __init__(self, out: Path) -> None:
        self.path = out / FILE_NAME
        with self._told():
            out.mkdir(parents=True, exist_ok=True)
            self._writable = not self.path.exists() or all(os.access(each, os.W_OK) for each in (out, self.path))
            self._db = sqlite3.connect(self._address(), uri=True, timeout=30, isolation_level=None)
            try:
                self._prepare()
            except BaseException:
                self._db.close()
                raise

    def __enter__(self) -> Store:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    @classmethod
    def existing(cls, out: Path) -> Store:
        """The record of a class that has been graded; RequestError if there is none."""
        if not (out / FILE_NAME).is_file():
            raise RequestError(
                f"{printable(str(out), 500)}: no class was graded there; give the OUT of `imugrade grade`"
            )
        return cls(out)

    def close(self) -> None:
        self._db.close()

    def keep(self, key: Key, result: Result) -> None:
        """Commit one result and make it the submission's present one."""
        record = json.dumps(to_dict(result), ensure_ascii=True, allow_nan=False)
        with self._told(), self._transaction():
            evidence = (result.evidence.charts, array("Q", result.evidence.fingerprint).tobytes())
            self._db.execute(_KEEP, (*astuple(key), result.status, record, *evidence))
            self._point_at(key)

    def recall(self, key: Key) -> Result | None:
        """The result already recorded under this key, made present again; None if there is none or it is incomplete."""
        with self._told(), self._transaction():
            query = f"SELECT record FROM results {_WHERE} AND status != 'incomplete'"
            row = self._db.execute(query, astuple(key)).fetchone()
            if row is not None:
                self._point_at(key)
        return None if row is None else from_dict(json.loads(row[0]))

    def present(self) -> dict[str, Result]:
        """The present result of every submission of the class, by id, in the order of the ids."""
        query = "SELECT class.id, record FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._told():
            return {id_: from_dict(json.loads(record)) for id_, record in self._db.execute(query)}

    def charts(self, id_: str) -> tuple[Chart, ...]:
        """The charts of a submission's present result."""
        query = "SELECT charts FROM class JOIN results USING (seq) WHERE class.id = ?"
        with self._told():
            row = self._db.execute(query, (id_,)).fetchone()
        return () if row is None else unpacked(row[0])

    def fingerprints(self) -> dict[str, tuple[int, ...]]:
        """The fingerprint of every submission's code, by id."""
        query = "SELECT class.id, fingerprint FROM class JOIN results USING (seq) ORDER BY class.id"
        with self._told():
            return {id_: tuple(array("Q", record)) for id_, record in self._db.execute(query)}

    def standings(self) -> dict[str, Standing]:
        """The present result of every submission with all that stands beside it, by id, in the order of the ids."""
        present, hand_ins, adjustments = self.present(), self.hand_ins(), self.adjustments()
        return {
            id_: Standing(id_, result, hand_ins.get(id_, NOTHING_KNOWN), adjustments.get(id_, ()))
            for id_, result in present.items()
        }

    def keep_hand_in(self, id_: str, hand_in: HandIn) -> None:
        """Record who handed in and when, in place of what was known before."""
        record = json.dumps(hand_in_to_dict(hand_in), ensure_ascii=True, allow_nan=False)
        with self._told(), self._transaction():
            self._db.execute("INSERT OR REPLACE INTO hand_ins VALUES (?, ?)", (id_, record))

    def adjust(self, adjustments: Iterable[tuple[str, Adjustment]]) -> None:
        """Add adjustments, by id of the submission, all or none; nothing that was ever said is taken away."""
        rows = [
            (id_, a.criterion, a.points, a.comment, a.author, a.at, json.dumps(dict(a.beneath)))
            for id_, a in adjustments
        ]
        with self._told(), self._transaction():
            self._db.executemany(f"INSERT INTO adjustments ({_ADJUSTMENT}) VALUES (?, ?, ?, ?, ?, ?, ?)", rows)

    def history(self) -> list[tuple[str, Adjustment]]:
        """Every adjustment ever made, by id of the submission, oldest first; without points those that withdraw one."""
        with self._told():
            rows = self._db.execute(f"SELECT {_ADJUSTMENT} FROM adjustments ORDER BY seq").fetchall()
        return [
            (id_, Adjustment(criterion, points, comment, author, at, json.loads(record)))
            for id_, criterion, points, comment, author, at, record in rows
        ]

    def page_digest(self, id_: str) -> str:
        """What `keep_page_digest` was last given: of what the pages of a submission were made from."""
        with self._told():
            row = self._db.execute("SELECT digest FROM pages WHERE id = ?", (id_,)).fetchone()
        return "" if row is None else str(row[0])

    def keep_page_digest(self, id_: str, digest: str) -> None:
        with self._told(), self._transaction():
            self._db.execute("INSERT OR REPLACE INTO pages VALUES (?, ?)", (id_, digest))

    def hand_ins(self) -> dict[str, HandIn]:
        """Who handed in and when, as last recorded, by id."""
        with self._told():
            rows = self._db.execute("SELECT id, record FROM hand_ins").fetchall()
        return {id_: hand_in_from_dict(json.loads(record)) for id_, record in rows}

    def adjustments(self) -> dict[str, tuple[Adjustment, ...]]:
        """Those in force, by id of the submission: the last of each criterion, unless it withdraws."""
        last: dict[str, dict[str, Adjustment]] = {}
        for id_, adjustment in self.history():
            last.setdefault(id_, {})[adjustment.criterion] = adjustment
        return {id_: tuple(a for a in each.values() if a.points is not None) for id_, each in last.items()}

    def point_at(self, key: Key) -> None:
        """Make a recorded result the submission's present one."""
        with self._told(), self._transaction():
            self._point_at(key)

    def _point_at(self, key: Key) -> None:
        self._db.execute(
            f"INSERT INTO class (id, seq) SELECT id, seq FROM results {_WHERE} "
            "ON CONFLICT (id) DO UPDATE SET seq = excluded.seq",
            astuple(key),
        )

    def _address(self) -> str:
        """The file as a URI; one that cannot be written, say in an archive, is read as it lies there if nothing is pending."""
        pending = Path(f"{self.path}-wal")
        settled = not pending.exists() or pending.stat().st_size == 0
        mode = "mode=rwc" if self._writable else "immutable=1" if settled else "mode=ro"
        return f"{self.path.absolute().as_uri()}?{mode}"

    def _prepare(self) -> None:
        """Open or lay out the file.

        WAL keeps a reader from blocking the writer; with it, NORMAL is still safe when the process is killed.
        """
        application, version, tables = self._identity()
        if (application, version, tables) == (0, 0, 0):
            self._db.executescript(_TABLES.format(application=_APPLICATION_ID, version=SCHEMA_VERSION))
        elif application != _APPLICATION_ID:
            raise RequestError(f"{self.path}: is not a record of imugrade; choose another folder with -o")
        elif version != SCHEMA_VERSION:
            raise RequestError(
                f"{self.path}: was written by another version of imugrade (layout {version}, this one reads "
                f"{SCHEMA_VERSION}); use that version, or another folder with -o"
            )
        if self._writable:
            self._db.execute("PRAGMA journal_mode = WAL")
        self._db.execute("PRAGMA synchronous = NORMAL")
        self._db.execute("PRAGMA foreign_keys = ON")

    def _identity(self) -> tuple[int, int, int]:
        ask = ("PRAGMA application_id", "PRAGMA user_version", "SELECT count(*) FROM sqlite_master")
        application, version, tables = (int(self._db.execute(query).fetchone()[0]) for query in ask)
        return application, version, tables

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._db.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            if self._db.in_transaction:  # SQLite has already rolled back when the disk is full
                self._db.execute("ROLLBACK")
            raise
        self._db.execute("COMMIT")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Turn what the disk refuses into one line for the person who chose OUT."""
        try:
            yield
        except OSError as problem:
            raise RequestError(
                f"{self.path.parent}: cannot write there: {problem.strerror or problem}; choose another folder with -o"
            ) from problem
        except sqlite3.DatabaseError as problem:
            raise RequestError(
                f"{self.path}: {problem}; free or repair it, or choose another folder with -o "
                "(what was recorded before is kept)"
            ) from problem
