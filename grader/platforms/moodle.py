"""Moodle: reading downloads (mod/assign `downloader.php`) and filling in its grading worksheet (`importgradeslib.php`)."""

from __future__ import annotations

import html
import re
from collections import defaultdict
from collections.abc import Mapping

from grader.base.errors import RequestError
from grader.intake.downloads import Download
from grader.intake.names import encodable
from grader.people.final_grade import FinalGrade, HandIn, Person
from grader.people.identity import Match, PersonRow, participant, spellings
from grader.platforms.filled import Filled, TemplateLayout, fill_in
from grader.platforms.found import AMBIGUOUS, Found, Shape, at_least_half
from grader.platforms.platform import Help, Platform, Template
from grader.platforms.sheet import CsvSheet, SheetRow, read_sheet
from grader.report import words
from grader.report.adjusted import explained

# --- the grading worksheet, filled in ---------------------------------------------------------------------------------

_COMMENTS = (
    "Feedback comments",
    "Feedback als Kommentar",
    "Feedback par commentaires",
    "Comentarios de retroalimentación",
)
_MOST = ("Maximum grade", "Bestwertung", "Note maximale", "Calificación máxima")
_OURS = "Marks: "
_NO = ("no", "nein", "non")
_YES_OR_NO = frozenset({*_NO, "yes", "ja", "oui", "sí", "si"})


def fill(template: Template, final_grades: Mapping[str, FinalGrade]) -> Filled:
    """Return Moodle's grading worksheet with grades filled in, each with a comment, to upload again.

    A teacher's comment stays as it is; one from an earlier export is replaced. A file without a comment column gets no comments.
    `final_grades` are by submission id; `template.column` is the title of the grades' column, None for "Grade". Raise RequestError
    if the file has no such column, or the maximum of the assignment differs from the rubric's and `template.scaled` is False.
    """
    sheet, column = read_sheet(template.data, template.source), template.column or "Grade"
    grade = sheet.column(column)
    if grade is None or len(sheet.titles) < 3:
        how = "download the grading worksheet, or name the column"
        raise RequestError(
            f"{template.source}: has no column {column}; {how} with --column",
            option="column",
            why=f"no column {column} in the template; {how}",
        )
    layout = _layout(sheet, grade)
    teams = _matches_of_teams(final_grades)
    matches = {
        number: match or teams.get(layout.rows[number].value(sheet.column("Group")).strip().casefold())
        for number, match in layout.matches(final_grades).items()
    }
    filled = fill_in(layout, template, matches, final_grades)
    _comment_on(layout, matches, final_grades)
    filled.data = sheet.data()
    return filled


def _layout(sheet: CsvSheet, grade: int) -> TemplateLayout:
    """Describe the worksheet for `fill_in`: its columns by title, or, on sites in other languages, by position and contents."""
    rows = {number: row for number, row in enumerate(sheet.rows[1:], 1) if row.value(0).strip()}
    known = sheet.column(*_MOST)
    most = grade + 1 if known is None else known
    changeable = sheet.column("Grade can be changed")
    if changeable is None:
        changeable = next(
            (
                i
                for i in range(grade + 1, len(sheet.titles))
                if rows and all(row.value(i).strip().casefold() in _YES_OR_NO for row in rows.values())
            ),
            None,
        )
    return TemplateLayout(
        sheet,
        grade,
        rows,
        who=lambda row: _who(sheet, row),
        name=lambda row: row.value(sheet.column("Full name")) or row.value(0),
        out_of=lambda row: row.value(most),
        locked=lambda row: row.value(changeable).strip().casefold() in _NO,
    )


def _comment_on(
    layout: TemplateLayout, matches: Mapping[int, Match | None], final_grades: Mapping[str, FinalGrade]
) -> None:
    """Fill in comments on the grades. A comment by a teacher is kept; one from an earlier export is replaced."""
    column = _comment_column(layout)
    for number, match in matches.items():
        row = layout.rows[number]
        if column is None or match is None or layout.locked(row) or final_grades[match.id].final is None:
            continue
        if not row.value(column).strip() or row.value(column).startswith(_OURS):
            layout.sheet.set(row, column, comment(final_grades[match.id]))


def _comment_column(layout: TemplateLayout) -> int | None:
    """Return the index of the column of comments, found by its title, or else the last one if its cells look like comments.

    None if there is no such column: comments are then not filled in.
    """
    known = layout.sheet.column(*_COMMENTS)
    last = len(layout.sheet.titles) - 1
    if known is not None or last <= layout.grade + 2:
        return known
    texts = [row.value(last).strip() for row in layout.rows.values()]
    return last if any(not text or text.startswith(_OURS) for text in texts) and "-" not in texts else None


def comment(final_grade: FinalGrade) -> str:
    """Return the comment on a grade for Moodle: points of each criterion, and how the final grade came about, escaped for HTML."""
    parts = [
        f"{c.title} {words.fraction(final_grade.points(c), c.max_points)}"
        f"{' (overridden)' * (final_grade.adjustment(c.id) is not None)}"
        for c in final_grade.result.criteria
    ]
    parts.append(explained(final_grade))
    return html.escape(_OURS + "; ".join(parts), quote=False)


def _who(sheet: CsvSheet, row: SheetRow) -> PersonRow:
    number = participant(row.value(0))
    mail = row.value(sheet.column("Email address", "Email"))
    ids = tuple(filter(None, (row.value(sheet.column("ID number")), row.value(sheet.column("Username")))))
    return PersonRow("moodle", number, ids, mail, row.value(sheet.column("Full name")))


def _matches_of_teams(final_grades: Mapping[str, FinalGrade]) -> dict[str, Match]:
    """Return the submissions of teams by name. A team hands in under its name, which its members' rows have in column `Group`."""
    return {
        final_grade.name.strip().casefold(): Match(id_, None)
        for id_, final_grade in final_grades.items()
        if spellings(final_grade.name)
    }


# --- a download -------------------------------------------------------------------------------------------------------

TITLE = "Moodle submissions"
_NAME = re.compile(
    r"(?P<who>(?P<name>[^_]*)_(?P<number>\d+))_(?P<plugin>assign(?:submission|feedback)_[a-z]+)(?:_(?P<file>.*))?",
    re.DOTALL,
)
_WITHIN = re.compile(r"_(\d+)_assign(?:submission|feedback)_")
_FILES = "assignsubmission_file"
_NOT_OURS = "not named as Moodle names files, so whose it is cannot be told"
_FEEDBACK = "feedback, not handed in by the student"


def read(download: Download) -> Shape | None:
    """Return the submissions of the students or teams in a Moodle download; None for any other download.

    Each submission is a folder or loose files, named `<full name>_<number>_assignsubmission_file[_]`.
    """
    matches = {name: _NAME.fullmatch(name) for name in download.top}
    if not at_least_half(match is not None for match in matches.values()):
        return None
    left = [(name, _NOT_OURS) for name, match in matches.items() if match is None]
    own: defaultdict[str, list[re.Match[str]]] = defaultdict(list)
    for name, match in matches.items():
        if match is not None and not _means_one_person(name, download.known):
            left.append((name, AMBIGUOUS))
        elif match is not None and match["plugin"].startswith("assignfeedback"):
            left.append((name, _FEEDBACK))
        elif match is not None:
            own[match["number"]].append(match)
    return Shape(TITLE, tuple(_found(download, number, matches) for number, matches in own.items()), tuple(left))


def _means_one_person(name: str, known: Mapping[str, str]) -> bool:
    """Return whether a file name means one person: it has one number, or the first alone is in the roster (`known`)."""
    numbers = _WITHIN.findall(name)
    return len(set(numbers)) == 1 or (numbers[0] in known and not set(numbers[1:]) & known.keys())


def _found(download: Download, number: str, matches: list[re.Match[str]]) -> Found:
    first = next((match for match in matches if match["plugin"] == _FILES), matches[0])
    name = encodable(first["name"]) or number
    sources = tuple((download.place(match[0]), encodable(match["file"] or "")) for match in matches)
    hand_in = HandIn((Person(name, number, "moodle"),), reply=_feedback_prefix(download, first))
    return Found(f"moodle:{number}", f"{name}_{number}", name, download.path, sources, hand_in)


def _feedback_prefix(download: Download, match: re.Match[str]) -> str:
    """Return how the path of a feedback file must begin in Moodle's upload: the folder, or the start of a loose file's name."""
    if download.top[match[0]]:
        return encodable(match[0]) + "/"
    return encodable(match[0][: match.start("file")])


PLATFORM = Platform(
    name="moodle",
    title="Moodle",
    help=Help(
        read=("*Download all submissions*, both modes", "`Full name_number_assignsubmission_file`", "the number"),
        grades="""\
download the grading worksheet, fill it, upload it. Grades and comments are filled in, and every other byte is as it
was; a comment of your own is kept. Where the site speaks another language, name the column of grades with `--column`. The zip of
`--feedback` goes to *Upload multiple feedback files in a zip*. Moodle takes no worksheet where a rubric of its own is in use.""",
    ),
    read=read,
    fill=fill,
    gradebook="moodle.csv",
)
