"""SQLite file with all stored data of a class: tables, opening, transactions, and errors in one line."""

from __future__ import annotations

import os
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from msgspec import ValidationError  # a ValueError since msgspec 0.23

from grader.base.errors import RequestError
from grader.base.text import printable

T = TypeVar("T")
D = TypeVar("D", bound="Database")

FILE_NAME = "results.sqlite"
SCHEMA_VERSION = 4
_APPLICATION_ID = 0x494D5547  # "IMUG": tells our file from any other SQLite file
_TABLES = """
CREATE TABLE results (
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
CREATE TABLE class (id TEXT PRIMARY KEY, seq INTEGER NOT NULL REFERENCES results (seq));
CREATE TABLE hand_ins (id TEXT PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE files (submission_sha256 TEXT PRIMARY KEY, packed BLOB NOT NULL);
CREATE TABLE pages (id TEXT PRIMARY KEY, digest TEXT NOT NULL);
CREATE TABLE told (kind TEXT NOT NULL, line TEXT NOT NULL);
CREATE TABLE settings (number INTEGER PRIMARY KEY, at TEXT NOT NULL, record TEXT NOT NULL);
CREATE TABLE former (
    number INTEGER NOT NULL,
    id TEXT NOT NULL,
    seq INTEGER NOT NULL,
    hand_in TEXT NOT NULL,
    PRIMARY KEY (number, id)
);
CREATE TABLE adjustments (
    seq INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    criterion TEXT NOT NULL,
    points REAL,
    comment TEXT NOT NULL,
    author TEXT NOT NULL,
    at TEXT NOT NULL,
    beneath TEXT NOT NULL,
    alone INTEGER NOT NULL DEFAULT 0,
    decision INTEGER NOT NULL DEFAULT 0
);
CREATE TABLE decisions (number INTEGER PRIMARY KEY, what TEXT NOT NULL, author TEXT NOT NULL, at TEXT NOT NULL);
CREATE TABLE ticks (
    seq INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    reason TEXT NOT NULL,
    about TEXT NOT NULL,
    done INTEGER NOT NULL,
    author TEXT NOT NULL,
    at TEXT NOT NULL
);
CREATE TABLE appeals (
    number INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    about TEXT NOT NULL,
    text TEXT NOT NULL,
    at TEXT NOT NULL,
    answer TEXT NOT NULL DEFAULT '',
    author TEXT NOT NULL DEFAULT '',
    answered TEXT NOT NULL DEFAULT '',
    UNIQUE (id, about, text)
);
CREATE TABLE repairs (
    number INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    file TEXT NOT NULL,
    file_sha256 TEXT NOT NULL,
    diff BLOB NOT NULL,
    deduction REAL NOT NULL,
    comment TEXT NOT NULL,
    author TEXT NOT NULL,
    at TEXT NOT NULL,
    undone_by TEXT NOT NULL DEFAULT '',
    undone_at TEXT NOT NULL DEFAULT ''
);
CREATE TABLE tried (what TEXT PRIMARY KEY);
"""


class Database:
    """Connection to the SQLite file of a class, base of the classes for its tables; a context manager, used from one thread."""

    def __init__(self, out: Path) -> None:
        self.path = out / FILE_NAME
        with self._errors_in_one_line():
            out.parent.mkdir(parents=True, exist_ok=True)
            out.mkdir(mode=0o700, exist_ok=True)  # names and grades: on a shared machine for its owner alone
            self._writable = not self.path.exists() or all(os.access(each, os.W_OK) for each in (out, self.path))
            self._db = sqlite3.connect(self._address(), uri=True, timeout=30, isolation_level=None)
            try:
                self._prepare()
            except BaseException:
                self._db.close()
                raise

    def __enter__(self: D) -> D:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, tb: TracebackType | None) -> None:
        self.close()

    @classmethod
    def existing(cls: type[D], out: Path) -> D:
        """Open the database in the output folder of a graded class; raise RequestError if nothing was graded there."""
        if not (out / FILE_NAME).is_file():
            raise RequestError(
                f"{printable(str(out), 500)}: no class was graded there; give the output folder of `imugrade grade`"
            )
        return cls(out)

    def close(self) -> None:
        self._db.close()

    def changes(self) -> int:
        """Return a number that changes when a connection other than this writes to the file: then cached results are read anew."""
        return int(self._value("PRAGMA data_version"))

    def _value(self, query: str, *parameters: object) -> Any:
        """Return the first column of a query's first row; None if there is no row. SQLite's errors become a RequestError."""
        with self._errors_in_one_line():
            row = self._db.execute(query, parameters).fetchone()
            return None if row is None else row[0]

    def _read(self, parse: Callable[[Any], T], record: object) -> T:
        """Parse a stored value; raise a one-line RequestError if it holds what imugrade does not write."""
        with self._errors_in_one_line():
            return read(parse, record)

    def _write(self, statement: str, *parameters: object) -> int:
        """Execute one statement in a transaction of its own; return how many rows it changed, 0 if none."""
        with self._errors_in_one_line(), self._transaction():
            return self._db.execute(statement, parameters).rowcount

    def _address(self) -> str:
        """Return the URI by which SQLite opens the file; a read-only file without pending writes as immutable, without locks."""
        pending = Path(f"{self.path}-wal")
        settled = not pending.exists() or pending.stat().st_size == 0
        mode = "mode=rwc" if self._writable else "immutable=1" if settled else "mode=ro"
        return f"{self.path.absolute().as_uri()}?{mode}"

    def _prepare(self) -> None:
        """Create the tables in a new file; raise RequestError for a file of another program or another layout.

        WAL keeps a reader from blocking the writer; with it, NORMAL is still safe when the process is killed.
        """
        application, version, tables = self._identity()
        if (application, version, tables) == (0, 0, 0):
            self._lay_out()
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

    def _lay_out(self) -> None:
        """Create the tables of a new file in one transaction, unless another process has just done so."""
        mark = f"PRAGMA application_id = {_APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION}"
        with self._transaction():
            if self._identity()[1] != SCHEMA_VERSION:
                for statement in (_TABLES + mark).split(";"):
                    self._db.execute(statement)

    def _identity(self) -> tuple[int, int, int]:
        ask = ("PRAGMA application_id", "PRAGMA user_version", "SELECT count(*) FROM sqlite_master")
        application, version, tables = (int(self._value(query)) for query in ask)
        return application, version, tables

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """Commit all that a ``with`` block writes, or roll it back if the block raises, so that nothing is half written."""
        self._db.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            if self._db.in_transaction:  # SQLite has already rolled back when the disk is full
                self._db.execute("ROLLBACK")
            raise
        self._db.execute("COMMIT")

    @contextmanager
    def _errors_in_one_line(self) -> Iterator[None]:
        """Turn errors of disk and SQLite in a ``with`` block into a one-line RequestError with the file and the way out."""
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
        except ForeignError as problem:
            raise RequestError(
                f"{self.path}: has contents that this version of imugrade does not write ({problem}); "
                "choose another folder with -o"
            ) from problem


class ForeignError(Exception):
    """Exception: a row of the database holds data that imugrade does not write; the message says what is wrong with it."""


def read(parse: Callable[[Any], T], record: object) -> T:
    """Return `parse(record)` for a stored value; raise ForeignError if that fails, because any program can write to the file."""
    try:
        return parse(record)
    except (ValueError, ValidationError, TypeError, KeyError, AttributeError, RecursionError, zlib.error) as problem:
        raise ForeignError(printable(f"{type(problem).__name__}: {problem}", 100)) from problem
