"""Canvas: `<name>[_LATE]_<user id>_<attachment id>_<file>`, all loose (canvas-lms `lib/content_zipper.rb`)."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable

from grader.intake.downloads import Download, Sources
from grader.intake.found import MARKED_LATE, Found, Shape, mostly
from grader.intake.names import ARCHIVES, has_suffix, original
from grader.people.standing import HandIn, Person

TITLE = "Canvas submissions"
_WHO = r"(?:(?P<name>.*?)_)??(?P<late>LATE_)?(?P<user>\d+)"
_FILE = re.compile(_WHO + r"_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL)
_ENTRY = re.compile(_WHO + r"(?P<attachment>)_(?P<file>text\.html|link\.html)", re.DOTALL)
_ANONYMOUS = re.compile(
    r"(?P<late>LATE_)?(?P<name>anon_(?P<user>[A-Za-z0-9]+))_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL
)
_AGAIN = re.compile(r"(.+)-\d+(\.[A-Za-z0-9]+(?:\.gz)?)")
_NOT_OURS = "not named as Canvas names files, so whose it is cannot be told"
_OLDER = "an older file of the same name and student; the newer one is graded"


def read(download: Download) -> Shape | None:
    """The students of a Canvas download; None if it is none."""
    told = {name: _parsed(name) for name, is_folder in download.top.items() if not is_folder}
    if not mostly(name in told and told[name] is not None for name in download.top):
        return None
    files: defaultdict[str, list[tuple[str, re.Match[str]]]] = defaultdict(list)
    left = [(name, _NOT_OURS) for name in download.top if told.get(name) is None]
    for name, match in told.items():
        if match is not None:
            files[match["user"]].append((name, match))
    found = []
    for user, own in files.items():
        sources, older = _newest(download, own)
        left += [(name, _OLDER) for name in older]
        found.append(_found(download, user, own, sources))
    return Shape(TITLE, tuple(found), tuple(left))


def _parsed(name: str) -> re.Match[str] | None:
    """Anonymous ones first: their id may be all digits. Files before text entries: a file may be called text.html."""
    return _ANONYMOUS.fullmatch(name) or _FILE.fullmatch(name) or _ENTRY.fullmatch(name)


def _found(download: Download, user: str, own: list[tuple[str, re.Match[str]]], sources: Sources) -> Found:
    first, match = max(own, key=lambda each: _number(each[1]))
    name = original(match["name"] or user)
    late = MARKED_LATE if any(m["late"] for _, m in own) else None
    reply = first[: match.start("file")] if match["attachment"] else ""  # Canvas wants both numbers in a file's name
    person = Person(name, "" if name.startswith("anon_") else user, "canvas")
    wish = name if name.endswith(user) else f"{name}_{user}"
    return Found(
        f"canvas:{user}",
        wish,
        name,
        download.path,
        sources,
        HandIn((person,), late=late, reply=original(reply)),
        ("", _number(match), ""),
    )


def _number(match: re.Match[str]) -> int:
    return int(match["attachment"][:18] or 0)


def _newest(download: Download, own: list[tuple[str, re.Match[str]]]) -> tuple[Sources, list[str]]:
    """Files under the names that the student gave them; of two with one name the one that came last, and the others."""
    names = [match["file"] for _, match in own]
    given = {*names, *_numbered_archives(names)}
    sources: dict[str, str] = {}
    older: list[str] = []
    for name, match in sorted(own, key=lambda each: _number(each[1])):
        inner = _first_name(match["file"], given)
        if inner in sources:
            older.append(sources[inner])
        sources[inner] = name
    return tuple((download.place(name), original(inner)) for inner, name in sources.items()), older


def _first_name(name: str, given: set[str]) -> str:
    """Without the `-1` that Canvas adds when a file is handed in again.

    It is Canvas's on a program, as no module can be called so, and where the name is `given` without it.
    """
    again = _AGAIN.fullmatch(name)
    if again is None:
        return name
    plain = again[1] + again[2]
    return plain if plain in given or (again[2] == ".py" and again[1].isidentifier()) else name


def _numbered_archives(names: Iterable[str]) -> set[str]:
    """What archives that differ in the number alone are called without it: they were handed in one after the other."""
    numbered = (_AGAIN.fullmatch(name) for name in names if has_suffix(name, ARCHIVES))
    plain = Counter(again[1] + again[2] for again in numbered if again is not None)
    return {name for name, times in plain.items() if times > 1}
