"""Git clones, one a student. Classroom 50 (`gh teacher download`) puts a `scores.csv` beside them, with names and times.

No git is run: a repository can name programs that git would start.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping

from grader.intake.downloads import Download
from grader.intake.found import MARKED_LATE, Found, Shape, mostly
from grader.intake.names import is_code, original
from grader.people.standing import HandIn, Person
from grader.stamps import stamp

CLASSROOM50 = "Classroom 50 clones"
GIT = "git clones"
SCORES = "scores.csv"
MAX_SCORES = 16_000_000
_NOT_OURS = "not a folder, so whose it is cannot be told"
_COLUMNS = {"username", "first_name", "last_name", "submission_tag"}


def read_classroom50(download: Download) -> Shape | None:
    """The clones beside a `scores.csv` of Classroom 50; None if there is none."""
    data = download.read(SCORES, MAX_SCORES) if SCORES in download.top else None
    table = csv.DictReader(io.StringIO("" if data is None else data.decode("utf-8-sig", "replace"), newline=""))
    try:
        if _COLUMNS - set(table.fieldnames or ()):
            return None
        rows = {row["username"].casefold(): row for row in table if row["username"]}
    except csv.Error:
        return None
    folders = [name for name, is_folder in download.top.items() if is_folder]
    found = (_found(download, name, _row(name, rows)) for name in folders)
    return Shape(CLASSROOM50, tuple(found), _loose(download, SCORES))


def read_git(download: Download) -> Shape | None:
    """Folders most of which are clones; None if they are not."""
    folders = [name for name, is_folder in download.top.items() if is_folder]
    programs = any(is_code(name) for name, is_folder in download.top.items() if not is_folder)
    if programs or not mostly(download.holds(name, ".git") for name in folders):  # programs: it is one submission
        return None
    return Shape(GIT, tuple(_found(download, name, {}) for name in folders), _loose(download))


def _loose(download: Download, *known: str) -> tuple[tuple[str, str], ...]:
    return tuple((name, _NOT_OURS) for name, is_folder in download.top.items() if not is_folder and name not in known)


def _row(folder: str, rows: Mapping[str, dict[str, str]]) -> dict[str, str]:
    """A clone is called `<classroom>-<assignment>-<username>`; of two users that fit, the longer name is meant."""
    fits = [user for user in rows if folder.casefold() == user or folder.casefold().endswith(f"-{user}")]
    return rows[max(fits, key=len)] if fits else {}


def _found(download: Download, folder: str, row: Mapping[str, str]) -> Found:
    user = row.get("username") or folder
    name = " ".join(filter(None, (row.get("first_name"), row.get("last_name")))) or user
    person = Person(
        original(name), original(user), "git", email=row.get("email") or "", section=row.get("section") or ""
    )
    submitted = stamp(row.get("datetime"))
    late = MARKED_LATE if row.get("late") == "true" else None
    place = ((download.place(folder), ""),)
    hand_in = HandIn((person,), submitted, late)
    return Found(f"git:{folder}", original(folder), original(folder), download.path, place, hand_in)
