"""Moodle: the grading worksheet that the teacher downloaded, with grades and comments filled in (`importgradeslib.php`)."""

from __future__ import annotations

import html
from collections.abc import Mapping

from grader import words
from grader.errors import RequestError
from grader.formats.filled import Filled, directory, matched, refuse_other_scale
from grader.formats.sheet import Row, Sheet, read_sheet
from grader.people.identity import Match, participant, spellings
from grader.people.identity import Row as Who
from grader.people.standing import Standing

COMMENT = "Feedback comments"
_OURS = "Marks: "
_NO = ("no", "nein", "non")


def fill(template: bytes, source: str, column: str | None, standings: Mapping[str, Standing]) -> Filled:
    """Grades, and comments where there is no other; every other byte as it was.

    Parameters
    ----------
    template
        The worksheet as Moodle gives it.
    source
        What messages call it.
    column
        What the column of the grades is called in the site's language; None: Grade.
    standings
        By id of the submission.

    Raises
    ------
    RequestError
        If it is no grading worksheet, or the assignment is out of other points than the rubric.
    """
    sheet = read_sheet(template, source)
    grade = sheet.column(column or "Grade")
    if grade is None or len(sheet.titles) < 3:
        raise RequestError(
            f"{source}: has no column {column or 'Grade'}; download the grading worksheet, or name the column with --column"
        )
    filled = Filled()
    rows = {number: row for number, row in enumerate(sheet.rows[1:], 1) if row.value(0).strip()}
    most = sheet.column("Maximum grade")
    found = matched(((n, _who(sheet, row)) for n, row in rows.items()), directory(standings))
    teams = _teams(standings)
    for number, row in rows.items():
        refuse_other_scale(source, row.value(most), standings)
        match = found[number] or teams.get(row.value(sheet.column("Group")).strip().casefold())
        _set(sheet, row, grade, standings[match.id] if match else None, filled)
    filled.data = sheet.data()
    return filled


def comment(standing: Standing) -> str:
    """One line: the points of each criterion, and what was taken off. Moodle reads it as HTML."""
    parts = [
        f"{c.title} {words.fraction(standing.points(c), c.max_points)}{' (by hand)' * (standing.adjustment(c.id) is not None)}"
        for c in standing.result.criteria
    ]
    credit = words.extra_credit(standing.result)
    parts += [f"extra credit {credit}"] if credit else []
    parts += [f"late −{words.number(standing.deduction)}"] if standing.deduction else []
    return html.escape(_OURS + "; ".join(parts), quote=False)


def _who(sheet: Sheet, row: Row) -> Who:
    number = participant(row.value(0))
    mail = row.value(sheet.column("Email address", "Email"))
    ids = tuple(filter(None, (row.value(sheet.column("ID number")), row.value(sheet.column("Username")))))
    return Who("moodle", number, ids, mail, row.value(sheet.column("Full name")))


def _teams(standings: Mapping[str, Standing]) -> dict[str, Match]:
    """A team hands in under its own name and number; the worksheet has its people, each with the team in `Group`."""
    return {
        standing.name.strip().casefold(): Match(id_, None)
        for id_, standing in standings.items()
        if len(standing.people) == 1 and spellings(standing.name)
    }


def _set(sheet: Sheet, row: Row, grade: int, standing: Standing | None, filled: Filled) -> None:
    name = row.value(sheet.column("Full name")) or row.value(0)
    if standing is None:
        filled.blank.append(name)
        return
    filled.placed.add(standing.id)
    if row.value(sheet.column("Grade can be changed")).strip().casefold() in _NO:
        filled.kept.append(name)
    elif standing.final is not None:
        sheet.set(row, grade, words.number(standing.final))
        filled.grades += 1
        column = sheet.column(COMMENT)
        if column is not None and (not row.value(column).strip() or row.value(column).startswith(_OURS)):
            sheet.set(row, column, comment(standing))
