"""Git clones in one folder, one clone per student.

Settings and hooks of a clone are never read, because they can name programs that git would start.
"""

from __future__ import annotations

from collections.abc import Mapping

from grader.base.stamps import stamp
from grader.intake.downloads import Download
from grader.intake.names import encodable, is_code
from grader.people.final_grade import HandIn, Person
from grader.platforms.found import Found, Shape, at_least_half
from grader.platforms.platform import Help, Platform

TITLE = "git clones"
_NOT_OURS = "not a folder, so whose it is cannot be told"


def read(download: Download) -> Shape | None:
    """Return the submissions of a folder of git clones, one for each student; None for any other download.

    At least half of the folders must be clones. If there are code files beside them, the download is one submission: None.
    """
    folders = [name for name, is_folder in download.top.items() if is_folder]
    programs = any(is_code(name) for name, is_folder in download.top.items() if not is_folder)
    if programs or not at_least_half(download.holds(name, ".git") for name in folders):
        return None  # with programs beside the folders it is one submission
    return Shape(TITLE, tuple(clone(download, name, {}) for name in folders), unassigned(download))


def unassigned(download: Download, *known: str) -> tuple[tuple[str, str], ...]:
    """Return the files beside the clones, whose owner is unknown, each with the reason; files named in `known` are left out."""
    return tuple((name, _NOT_OURS) for name, is_folder in download.top.items() if not is_folder and name not in known)


def clone(download: Download, folder: str, row: Mapping[str, str]) -> Found:
    """Return the submission in a clone; `row` of Classroom 50's `scores.csv` names the student, or the folder if `row` is {}."""
    user = row.get("username") or folder
    name = " ".join(filter(None, (row.get("first_name"), row.get("last_name")))) or user
    person = Person(
        encodable(name), encodable(user), "git", email=row.get("email") or "", section=row.get("section") or ""
    )
    submitted = stamp(row.get("datetime"))
    place = ((download.place(folder), ""),)
    hand_in = HandIn((person,), submitted, marked_late=row.get("late") == "true")
    return Found(f"git:{folder}", encodable(folder), encodable(folder), download.path, place, hand_in)


PLATFORM = Platform(
    name="git",
    title="git clones",
    help=Help(read=("", "`.git` in the folders", "the name of the folder")),
    read=read,
)
