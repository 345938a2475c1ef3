"""Log of repairs in the class database: who patched which submitted file; and files with these patches applied."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grader.base import stamps
from grader.base.text import printable
from grader.course.record.database import Database, read
from grader.course.record.patches import apply_patch
from grader.engine.results import Repair
from grader.intake import Submission

MAX_COMMENT = 2000
_FIELDS = "number, id, file, file_sha256, diff, deduction, comment, author, at, undone_by, undone_at"


@dataclass(frozen=True)
class LoggedRepair:
    """A stored repair: a person's or the grader's diff on a submitted file, with the points that it deducts.

    `file_sha256` is the digest of the file as it was handed in; the repair counts while the student's file is the same. `undone_at`
    is "" while nobody took the repair back.
    """

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
    """Table of the class database for repairs, which are patches on submitted files."""

    def repairs(self) -> list[LoggedRepair]:
        """Return every repair ever made, also those taken back, oldest first."""
        with self._errors_in_one_line():
            return [_logged(row) for row in self._db.execute(f"SELECT {_FIELDS} FROM repairs ORDER BY number")]

    def repairs_in_force(self, id_: str = "") -> list[LoggedRepair]:
        """Return the repairs that nobody took back, oldest first, of submission `id_`; of all if `id_` is ""."""
        return [each for each in self.repairs() if not each.undone_at and id_ in ("", each.id)]

    def keep_repair(self, made: LoggedRepair) -> None:
        """Store a repair under the next free number, whatever the number in `made`."""
        diff = made.diff.encode("utf-8", "surrogateescape")
        self._write(
            "INSERT INTO repairs (id, file, file_sha256, diff, deduction, comment, author, at) "
            "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            *(made.id, made.file, made.file_sha256, diff, made.deduction, made.comment, made.author, made.at),
        )

    def undo_repair(self, number: int, author: str) -> None:
        """Store that `author` took back the repair with this number, which stays in the log; an unknown number changes nothing."""
        query = "UPDATE repairs SET undone_by = ?, undone_at = ? WHERE number = ?"
        self._write(query, author, stamps.now(), number)


def _logged(row: Sequence[object]) -> LoggedRepair:
    fields = list(row)
    fields[4] = read(lambda blob: blob.decode("utf-8", "surrogateescape"), fields[4])
    return LoggedRepair(*fields)  # type: ignore[arg-type] # columns of the table


def repaired_sha256(handed_in: Submission, repairs: Iterable[LoggedRepair]) -> str:
    """Return a digest of a submission and its repairs, by which the database finds the stored result of the repaired copy.

    It differs from the digest of the repaired files, so that a student who hands in exactly these files gets no deduction. Without
    repairs, use `handed_in.sha256`.
    """
    facts = [handed_in.sha256, *((each.file, each.diff) for each in repairs)]
    return f"repaired-{sha256_of(json.dumps(facts).encode())}"


def sha256_of(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def apply_repairs(files: Mapping[str, bytes], repairs: Iterable[LoggedRepair | Repair]) -> dict[str, bytes]:
    """Return submitted files with these repairs applied in order, to grade or show them; RequestError if one does not fit."""
    now = dict(files)
    for each in repairs:
        now[each.file] = apply_patch(now[each.file], each.diff, f"repair of {printable(each.file, 80)}")
    return now


def of_these_files(repairs: Iterable[LoggedRepair], handed_in: Submission) -> list[LoggedRepair]:
    """Return the repairs made for files exactly as they are in this submission; the other repairs do not count."""
    present = {(path, sha256_of(content)) for path, content in handed_in.files.items()}
    return [each for each in repairs if each.is_for in present]
