"""Canvas: reading downloads (canvas-lms `lib/content_zipper.rb`) and filling in its gradebook (`gradebook_importer.rb`)."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.downloads import Download, Sources
from grader.intake.names import ARCHIVES, CODE, FOREIGN_ARCHIVES, encodable, has_suffix
from grader.people.final_grade import FinalGrade, HandIn, Person
from grader.people.identity import PersonRow, spellings
from grader.platforms.filled import Filled, TemplateLayout, fill_in
from grader.platforms.found import AMBIGUOUS, Found, Shape, at_least_half
from grader.platforms.platform import Help, Platform, Template
from grader.platforms.sheet import CsvSheet, SheetRow, read_sheet

# --- the gradebook, filled in -----------------------------------------------------------------------------------------

_ASSIGNMENT = re.compile(r"(.*)\s\((\d+)\)", re.DOTALL)
_OF_ALL = re.compile(r"(Current|Final|Override) (Score|Points|Grade)")
_NUMBERS = ("SIS User ID", "SIS Login ID", "Integration ID")
EXCUSED = "EX"
TEST_STUDENT = ("Student, Test", "Test Student")
"""Name of the test student, which Canvas adds to a course and lists among the students."""


def fill(template: Template, final_grades: Mapping[str, FinalGrade]) -> Filled:
    """Return a gradebook that Canvas exported, with final grades in the column of the assignment, and without other assignments.

    `final_grades` are by submission id; `template.column` is the title, the number or the whole heading of the assignment, None if
    there is just one. Cells of excused students and people without a grade are kept, but `template.missing` fills blank cells of
    students who handed in nothing. Raise RequestError if the file is no Canvas gradebook, the assignment is missing or ambiguous,
    or its maximum differs from the rubric's and `template.scaled` is False; True scales the points to the file's maximum.
    """
    sheet = read_sheet(template.data, template.source)
    titles, section = sheet.titles, sheet.column("Section")
    if ("Student" not in titles[0] and titles[0] != "LastName") or len(titles) < 3 or section is None:
        raise RequestError(f"{template.source}: is not a Canvas gradebook; export one in Canvas with Grades > Export")
    grade = _assignment(titles, section, template.column, template.source)
    form = _layout(sheet, grade)
    filled = fill_in(form, template, form.matches(final_grades), final_grades)
    sheet.keep([*range(section + 1), grade])
    filled.data = sheet.data()
    return filled


def _assignment(titles: list[str], section: int, wanted: str | None, source: str) -> int:
    after = range(section + 1, len(titles))
    found = [i for i in after if _ASSIGNMENT.fullmatch(titles[i]) and not _OF_ALL.search(titles[i])]
    columns = ", ".join(printable(titles[i], 80) for i in found[:20]) or "none"
    unread = [i for i in after if _ASSIGNMENT.fullmatch(titles[i]) and _OF_ALL.search(titles[i])]
    if wanted is not None:
        unread = [i for i in unread if wanted in (titles[i], *_ASSIGNMENT.findall(titles[i])[0])]
        found = [i for i in found if wanted in (titles[i], *_ASSIGNMENT.findall(titles[i])[0])]
    if not found and unread:
        why = f"Canvas imports no column with a title such as {printable(titles[unread[0]], 80)}; rename the assignment in Canvas"
        raise RequestError(f"{source}: {why}", option="column", why=why)
    if len(found) != 1:
        ask = "name the assignment" if wanted is None else f"{printable(wanted)} means none or several"
        how = "name the assignment with --column" if wanted is None else f"--column {ask}"
        raise RequestError(
            f"{source}: {how}; columns found: {columns}", option="column", why=f"{ask}; columns found: {columns}"
        )
    return found[0]


def _layout(sheet: CsvSheet, grade: int) -> TemplateLayout:
    """Describe the gradebook for `fill_in`: its rows of students, and the row above them with the assignment's maximum points."""
    points = next((row.value(grade) for row in sheet.rows[1:] if "Points Possible" in row.value(0)), "")
    students = {
        number: row
        for number, row in enumerate(sheet.rows[1:], 1)
        if row.value(0).strip() and len(row.cells) > 1 and "Points Possible" not in row.value(0)
    }
    return TemplateLayout(
        sheet,
        grade,
        students,
        who=lambda row: _who(sheet, row),
        name=lambda row: row.value(0),
        out_of=lambda _: points,
        locked=lambda row: row.value(grade).strip().upper() == EXCUSED,
        is_student=lambda row: row.value(0).strip() not in TEST_STUDENT,
    )


def _who(sheet: CsvSheet, row: SheetRow) -> PersonRow:
    numbers = tuple(filter(None, (row.value(sheet.column(title)) for title in _NUMBERS)))
    login = row.value(sheet.column("SIS Login ID"))
    return PersonRow("canvas", row.value(sheet.column("ID")), numbers, login if "@" in login else "", _name(sheet, row))


def _name(sheet: CsvSheet, row: SheetRow) -> str:
    """Return the student's name from Canvas's one default column, or from the two that an instructor can choose."""
    return (
        f"{row.value(sheet.column('FirstName'))} {row.value(0)}".strip()
        if sheet.titles[0] == "LastName"
        else row.value(0)
    )


# --- a download -------------------------------------------------------------------------------------------------------

TITLE = "Canvas submissions"
_WHO = r"(?:(?P<name>.*)_)??(?P<late>LATE_)?(?P<user>\d+)"
_FILE = re.compile(_WHO + r"_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL)
_ENTRY = re.compile(_WHO + r"(?P<attachment>)_(?P<file>text\.html|link\.html)", re.DOTALL)
_ANONYMOUS = re.compile(
    r"(?P<late>LATE_)?(?P<name>anon_(?P<user>[A-Za-z0-9]+))_(?P<attachment>\d+)_(?P<file>.+)", re.DOTALL
)
_AGAIN = re.compile(r"(.+)-\d+(\.[A-Za-z0-9]+(?:\.gz)?)")
_NO_LETTER = re.compile(r"[^a-z0-9]+")
_NOT_OURS = "not named as Canvas names files, so whose it is cannot be told"
_OLDER = "an older file of the same name and student; the newer one is graded"


@dataclass(frozen=True)
class _Reading:
    """One way to read the name of a file in a Canvas download: `file` is the student's own name for it, `user` the student's id.

    `attachment` numbers the uploads, later ones higher; "" for a text that was typed into Canvas.
    """

    name: str
    late: bool
    user: str
    attachment: str
    file: str

    @property
    def number(self) -> int:
        return int(self.attachment[:18] or 0)


def read(download: Download) -> Shape | None:
    """Return the submissions of a Canvas download, by the user ids in its file names; None for any other download."""
    readings_of = {name: _readings(name) for name, is_folder in download.top.items() if not is_folder}
    if not at_least_half(bool(readings_of.get(name)) for name in download.top):
        return None
    sure = frozenset((each[0].name, each[0].user) for each in readings_of.values() if len(each) == 1)
    files: defaultdict[str, list[tuple[str, _Reading]]] = defaultdict(list)
    left = [(name, _NOT_OURS) for name in download.top if not readings_of.get(name)]
    for name, readings in readings_of.items():
        meant = _confirmed(readings, sure, download.known)
        if meant is not None:
            files[meant.user].append((name, meant))
        elif readings:
            left.append((name, AMBIGUOUS))
    found = []
    for user, own in files.items():
        sources, older = _newest_files(download, own)
        left += [(name, _OLDER) for name in older]
        found.append(_found(download, user, own, sources))
    return Shape(TITLE, tuple(found), tuple(left))


def _readings(name: str) -> list[_Reading]:
    """Return all ways to read a file name, because names of people and files may contain numbers between underscores; [] for none.

    Anonymous names come first, because their id may be all digits. Files come before text entries, because a file may be called
    text.html. Canvas starts with the person's name, so digits at the start belong to a name.
    """
    anonymous = _ANONYMOUS.fullmatch(name)
    if anonymous is not None:
        return [_reading(anonymous)]
    for form in (_FILE, _ENTRY):
        ends = [at for at, sign in enumerate(name) if sign == "_"]
        begun = (form.fullmatch(name, end + 1) for end in ends)
        named = [
            replace(_reading(match), name=name[: match.start() - 1]) for match in begun if match and not match["name"]
        ]
        readings = [each for each in named if not each.name.endswith("_LATE") and each.name != "LATE"]
        nameless = form.fullmatch(name)
        if readings or nameless:
            return readings or [_reading(nameless)]  # type: ignore[arg-type] # one of the two is there
    return []


def _reading(match: re.Match[str]) -> _Reading:
    return _Reading(match["name"] or "", bool(match["late"]), match["user"], match["attachment"], match["file"])


def _confirmed(readings: Sequence[_Reading], sure: Set[tuple[str, str]], known: Mapping[str, str]) -> _Reading | None:
    """Return the reading that is the only one, or that the roster (`known`) or a clear file name of the same person confirms.

    None if none or several are confirmed: the file is then left over, because nobody can tell whose it is.
    """
    if len(readings) == 1:
        return readings[0]
    if known:
        listed = [each for each in readings if each.user in known and _names_agree(each.name, known[each.user])]
        return listed[0] if len(listed) == 1 else None
    proved = [each for each in readings if (each.name, each.user) in sure]
    return proved[0] if len(proved) == 1 else None


def _names_agree(written: str, name: str) -> bool:
    """Return whether two names agree as Canvas writes them: without punctuation, on some sites without non-ASCII letters."""
    return _NO_LETTER.sub("", written.casefold()) in {_NO_LETTER.sub("", each) for each in spellings(name)}


def _found(download: Download, user: str, own: list[tuple[str, _Reading]], sources: Sources) -> Found:
    first, last = max(own, key=lambda each: each[1].number)
    name = encodable(last.name or user)
    late = any(each.late for _, each in own)
    # Canvas wants both numbers in a file's name.
    reply = first[: len(first) - len(last.file)] if last.attachment else ""
    person = Person(name, "" if name.startswith("anon_") else user, "canvas")
    id_source = name if name.endswith(user) else f"{name}_{user}"
    return Found(
        f"canvas:{user}",
        id_source,
        name,
        download.path,
        sources,
        HandIn((person,), marked_late=late, reply=encodable(reply)),
        ("", last.number, ""),
    )


def _newest_files(download: Download, own: list[tuple[str, _Reading]]) -> tuple[Sources, list[str]]:
    """Return a student's files under the student's own names, the latest of each name, and the older files, which are left over.

    A picture or data file has no reason to be called ``plot-1.png``, but may be: it is there under both names.
    """
    names = [reading.file for _, reading in own]
    given = {*names, *_numbered_archives(names)}
    sources: dict[str, str] = {}
    older: list[str] = []
    for name, reading in sorted(own, key=lambda each: each[1].number):
        inner = _without_attempt_number(reading.file, given)
        if inner in sources:
            older.append(sources[inner])
        sources[inner] = name
    for name, reading in sorted(own, key=lambda each: -each[1].number):
        plain = _AGAIN.fullmatch(reading.file)
        if plain is not None and not has_suffix(reading.file, (*CODE, *ARCHIVES, *FOREIGN_ARCHIVES)):
            sources.setdefault(plain[1] + plain[2], name)
    return tuple((download.place(name), encodable(inner)) for inner, name in sources.items()), older


def _without_attempt_number(name: str, given: set[str]) -> str:
    """Return a file name without the `-1` that Canvas appends to a resubmitted file.

    The suffix is Canvas's if the file is a program, because no module has such a name, or if `given` has the name without it.
    """
    again = _AGAIN.fullmatch(name)
    if again is None:
        return name
    plain = again[1] + again[2]
    return plain if plain in given or (again[2].casefold() == ".py" and again[1].isidentifier()) else name


def _numbered_archives(names: Iterable[str]) -> set[str]:
    """Return the names, without the number, of archives that differ only in a number: Canvas numbers a student's attempts so."""
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
