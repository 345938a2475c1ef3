"""Moodle: `<full name>_<number>_assignsubmission_file[_]`, a folder each or loose files (mod/assign `downloader.php`)."""

from __future__ import annotations

import re
from collections import defaultdict

from grader.intake.downloads import Download
from grader.intake.found import Found, Shape, mostly
from grader.intake.names import original
from grader.people.standing import HandIn, Person

TITLE = "Moodle submissions"
_NAME = re.compile(
    r"(?P<who>(?P<name>[^_]*)_(?P<number>\d+))_(?P<plugin>assign(?:submission|feedback)_[a-z]+)(?:_(?P<file>.*))?",
    re.DOTALL,
)
_FILES = "assignsubmission_file"
_NOT_OURS = "not named as Moodle names files, so whose it is cannot be told"
_FEEDBACK = "feedback, not handed in by the student"


def read(download: Download) -> Shape | None:
    """The students, or teams, of a Moodle download; None if it is none."""
    told = {name: _NAME.fullmatch(name) for name in download.top}
    if not mostly(match is not None for match in told.values()):
        return None
    left = [(name, _NOT_OURS) for name, match in told.items() if match is None]
    own: defaultdict[str, list[re.Match[str]]] = defaultdict(list)
    for name, match in told.items():
        if match is not None and match["plugin"].startswith("assignfeedback"):
            left.append((name, _FEEDBACK))
        elif match is not None:
            own[match["number"]].append(match)
    return Shape(TITLE, tuple(_found(download, number, matches) for number, matches in own.items()), tuple(left))


def _found(download: Download, number: str, matches: list[re.Match[str]]) -> Found:
    first = next((match for match in matches if match["plugin"] == _FILES), matches[0])
    name = original(first["name"]) or number
    sources = tuple((download.place(match[0]), original(match["file"] or "")) for match in matches)
    hand_in = HandIn((Person(name, number, "moodle"),), reply=_reply(download, first))
    return Found(f"moodle:{number}", f"{name}_{number}", name, download.path, sources, hand_in)


def _reply(download: Download, match: re.Match[str]) -> str:
    """Feedback goes back under the very name that came: a folder's, or what a loose file's begins with."""
    if download.top[match[0]]:
        return original(match[0]) + "/"
    return original(match[0][: match.start("file")])
