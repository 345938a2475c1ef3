"""Canvas: the gradebook that the instructor exported, with the one assignment filled in (canvas-lms `gradebook_importer.rb`)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from grader import words
from grader.errors import RequestError
from grader.formats.filled import Filled, directory, matched, refuse_other_scale
from grader.formats.sheet import Row, Sheet, read_sheet
from grader.people.identity import Row as Who
from grader.people.standing import Standing
from grader.text import printable

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
