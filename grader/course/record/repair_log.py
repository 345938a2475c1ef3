"""The record of repairs: who patched which submitted file; files with these patches."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grader.base import stamps
from grader.base.text import printable
from grader.course.record.database import Database, read
from grader.course.record.patches import applied
from grader.engine.results import Repair
from grader.intake import Submission

MAX_COMMENT = 2000
_FIELDS = "number, id, file, file_sha256, diff, deduction, comment, author, at, undone_by, undone_at"


@dataclass(frozen=True)
class LoggedRepair:
    """A repair as the record keeps it; `file_sha256` is the digest of the file that it was made for, as it was handed in."""

    number: int
    id: str
    file: str
    file_sha256: str
    diff: str
    deduction: float
    comment: str
    author: str
    at: str
    undone_by: str = ""
    undone_at: str = ""

    @property
    def is_for(self) -> tuple[str, str]:
        return self.file, self.file_sha256


class RepairLog(Database):
    """The repairs of a class, one of the tables of its record."""

    def repairs(self) -> list[LoggedRepair]:
        """Return every repair ever made, oldest first."""
        with self._errors_in_one_line():
            return [_logged(row) for row in self._db.execute(f"SELECT {_FIELDS} FROM repairs ORDER BY number")]

    def repairs_in_force(self, id_: str = "") -> list[LoggedRepair]:
        """Return the repairs that nobody took back, oldest first, of one submission; of all if `id_` is ""."""
        return [each for each in self.repairs() if not each.undone_at and id_ in ("", each.id)]

    def keep_repair(self, made: LoggedRepair) -> None:
        """Record a repair under the next free number; the number in `made` is ignored."""
        diff = made.diff.encode("utf-8", "surrogateescape")
        self._write(
            "INSERT INTO repairs (id, file, file_sha256, diff, deduction, comment, author, at) "
            "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            *(made.id, made.file, made.file_sha256, diff, made.deduction, made.comment, made.author, made.at),
        )

    def undo_repair(self, number: int, author: str) -> None:
        """Record that somebody took a repair back."""
        query = "UPDATE repairs SET undone_by = ?, undone_at = ? WHERE number = ?"
        self._write(query, author, stamps.now(), number)


def _logged(row: Sequence[object]) -> LoggedRepair:
    fields = list(row)
    fields[4] = read(lambda blob: blob.decode("utf-8", "surrogateescape"), fields[4])
    return LoggedRepair(*fields)  # type: ignore[arg-type] # columns of the table


def repaired_sha256(handed_in: Submission, repairs: Iterable[LoggedRepair]) -> str:
    """Return the value that stands in the record for the digest of a repaired copy of a submission.

    It is no digest of files: a student who hands in exactly these files has repaired them without help.
    """
    facts = [handed_in.sha256, *((each.file, each.diff) for each in repairs)]
    return f"repaired-{sha256_of(json.dumps(facts).encode())}"


def sha256_of(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def patched(files: Mapping[str, bytes], repairs: Iterable[LoggedRepair | Repair]) -> dict[str, bytes]:
    """Return submitted files with these repairs applied in order."""
    now = dict(files)
    for each in repairs:
        now[each.file] = applied(now[each.file], each.diff, f"repair of {printable(each.file, 80)}")
    return now


def of_these_files(repairs: Iterable[LoggedRepair], handed_in: Submission) -> list[LoggedRepair]:
    """Return the repairs that were made for the files as they were handed in."""
    present = {(path, sha256_of(content)) for path, content in handed_in.files.items()}
    return [each for each in repairs if each.is_for in present]
