"""Canvas: its downloads (canvas-lms `lib/content_zipper.rb`), and its own gradebook filled in (`gradebook_importer.rb`)."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping

from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.intake.downloads import Download, Sources
from grader.intake.names import ARCHIVES, has_suffix, original
from grader.people.identity import Row as Who
from grader.people.standing import HandIn, Person, Standing
from grader.platforms.filled import Filled, directory, matched, refuse_other_scale
from grader.platforms.found import MARKED_LATE, Found, Shape, mostly
from grader.platforms.platform import Help, Platform
from grader.platforms.sheet import Row, Sheet, read_sheet
from grader.report import words

# --- the gradebook, filled in -----------------------------------------------------------------------------------------

_ASSIGNMENT = re.compile(r"(.*)\s\((\d+)\)", re.DOTALL)
_OF_ALL = re.compile(r"(Current|Final|Override) (Score|Points|Grade)")
_NUMBERS = ("SIS User ID", "SIS Login ID", "Integration ID")
EXCUSED = "EX"


def fill(template: bytes, source: str, column: str | None, standings: Mapping[str, Standing]) -> Filled:
    """The student columns as they were, and the assignment's with the final points; who is not graded keeps what stands there.

    Parameters
    ----------
    template
        The gradebook as Canvas exports it.
    source
        What messages call it.
    column
        The assignment: its title, its number, or the whole heading. None where there is only one.
    standings
        By id of the submission.

    Raises
    ------
    RequestError
        If it is no gradebook of Canvas, the assignment is not in it or not told, or is out of other points than the rubric.
    """
    sheet = read_sheet(template, source)
    titles = sheet.titles
    section = sheet.column("Section")
    if ("Student" not in titles[0] and titles[0] != "LastName") or len(titles) < 3 or section is None:
        raise RequestError(f"{source}: is no gradebook of Canvas; export it there with Grades > Export")
    grade = _assignment(titles, section, column, source)
    filled = Filled()
    rows = dict(_rows(sheet, grade, source, standings))
    for number, match in matched(((n, _who(sheet, row)) for n, row in rows.items()), directory(standings)).items():
        _set(sheet, rows[number], grade, standings[match.id] if match else None, filled)
    sheet.keep([*range(section + 1), grade])
    filled.data = sheet.data()
    return filled


def _assignment(titles: list[str], section: int, wanted: str | None, source: str) -> int:
    after = range(section + 1, len(titles))
    found = [i for i in after if _ASSIGNMENT.fullmatch(titles[i]) and not _OF_ALL.search(titles[i])]
    told = ", ".join(printable(titles[i], 80) for i in found[:20]) or "none"
    if wanted is not None:
        found = [i for i in found if wanted in (titles[i], *_ASSIGNMENT.findall(titles[i])[0])]
    if len(found) != 1:
        ask = (
            "name the assignment with --column"
            if wanted is None
            else f"--column {printable(wanted)} means none or several"
        )
        raise RequestError(f"{source}: {ask}; there are: {told}")
    return found[0]


def _rows(sheet: Sheet, grade: int, source: str, standings: Mapping[str, Standing]) -> Iterator[tuple[int, Row]]:
    """The rows of students; the one above them says what the assignment is out of."""
    for number, row in enumerate(sheet.rows[1:], 1):
        if "Points Possible" in row.value(0):
            refuse_other_scale(source, row.value(grade), standings)
        elif row.value(0).strip() and len(row.cells) > 1:
            yield number, row


def _who(sheet: Sheet, row: Row) -> Who:
    numbers = tuple(filter(None, (row.value(sheet.column(title)) for title in _NUMBERS)))
    login = row.value(sheet.column("SIS Login ID"))
    return Who("canvas", row.value(sheet.column("ID")), numbers, login if "@" in login else "", _name(sheet, row))


def _name(sheet: Sheet, row: Row) -> str:
    """From the one column of names that Canvas writes by default, or the two that an instructor can ask for."""
    return (
        f"{row.value(sheet.column('FirstName'))} {row.value(0)}".strip()
        if sheet.titles[0] == "LastName"
        else row.value(0)
    )


def _set(sheet: Sheet, row: Row, grade: int, standing: Standing | None, filled: Filled) -> None:
    if standing is None:
        filled.blank.append(row.value(0))
        return
    filled.placed.add(standing.id)
    if row.value(grade).strip().upper() == EXCUSED:
        filled.kept.append(row.value(0))
    elif standing.final is not None:
        sheet.set(row, grade, words.number(standing.final))
        filled.grades += 1


# --- a download -------------------------------------------------------------------------------------------------------

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
    """The students of a Canvas download: `<name>[_LATE]_<user id>_<attachment id>_<file>`, all loose; None if it is none."""
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


PLATFORM = Platform(
    name="canvas",
    title="Canvas",
    help=Help(
        read=("*Download Submissions*", "`name_LATE_user_attachment_file`", "the user id"),
        grades="""\
export the gradebook there, fill it here, import it. The student columns come back as they were, with the one
assignment; who is excused or was not graded keeps what stood there. `--feedback` writes a zip for *Upload Submissions*.""",
    ),
    read=read,
    fill=fill,
    gradebook="canvas.csv",
)
