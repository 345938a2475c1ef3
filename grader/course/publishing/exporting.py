"""Export of a graded class for upload to a platform such as Canvas: the file of grades, and a zip of the students' reports."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.files import read_file, write_whole
from grader.base.text import printable, some
from grader.course.publishing.contradictions import Contradiction, contradictions
from grader.course.publishing.out_files import outdated_pages
from grader.course.record import class_settings
from grader.course.record.store import Store
from grader.intake.names import distinct_ids
from grader.people.final_grade import FinalGrade, Person
from grader.people.identity import Directory
from grader.platforms.filled import directory, reply_to
from grader.platforms.platform import Platform, Template
from grader.report import words

BLANK_OR_ZERO = ("blank", "0")
"""Grades that can be chosen for people without a submission, and for empty and unreadable submissions."""
MAX_TEMPLATE = 64_000_000
_STAMP = (2020, 1, 1, 0, 0, 0)  # the same results make the same bytes


@dataclass(frozen=True)
class Export:
    """Request of an export, as the command line or the review desk makes it: class, platform, files and options.

    `out` is the class's output folder. `target` is the file to write; None: the platform's default name in `out`. `template` is a
    file that the platform exported, to be filled in; None: a new file. `column` is its column of grades; None: the platform's code
    finds it. `feedback` is the zip to write the reports to; None: no reports. `scaled` converts points to the maximum of the
    platform's assignment. `unreadable` is the grade of empty and unreadable submissions, `missing` that of people without a
    submission: "blank" or "0".
    """

    out: Path
    platform: Platform
    target: Path | None = None
    template: Path | None = None
    column: str | None = None
    feedback: Path | None = None
    scaled: bool = False
    unreadable: str = "blank"
    missing: str = "blank"


@dataclass(frozen=True)
class Draft:
    """A file of grades that is not written yet, and what it changes for whom, so that a person can look before the upload.

    Attributes
    ----------
    data, graded
        The file's bytes, and the number of grades filled in, without those of `missing`.
    blank
        People who get no grade, each with the reason: not judged, empty or unreadable, or no submission.
    replaced, locked
        Rows of the platform's file whose other grade is replaced, and rows whose grade the platform has locked: it is kept.
    unmatched
        Rows that match nobody of the class, or not clearly; they are left as they are.
    missing
        People without a submission who get 0, not a blank.
    without_row
        Graded submissions that reach no row of the file, with a sentence on each.
    """

    data: bytes
    graded: int
    blank: tuple[str, ...]
    missing: tuple[str, ...] = ()
    without_row: Mapping[str, str] = field(default_factory=dict)
    replaced: tuple[str, ...] = ()
    locked: tuple[str, ...] = ()
    unmatched: tuple[str, ...] = ()

    def lines(self) -> Iterator[str]:
        """Yield lines: the number of grades, then size and names of each list that is not empty, such as `blank` or `replaced`."""
        yield f"graded: {self.graded}"
        named = {
            "blank": self.blank,
            "0, as there is no submission": self.missing,
            "replaced": self.replaced,
            "not to be changed in the file": self.locked,
            "unmatched, left as they are": self.unmatched,
        }
        for kind, names in named.items():
            if names:
                yield f"{kind}: {len(names)} ({'; '.join(printable(name, 200) for name in names)})"


@dataclass(frozen=True)
class ExportPlan:
    """A prepared export with all that it would do, which a person reads before anything is written.

    `other_settings` names submissions graded by other settings than the class, for a warning.
    """

    order: Export
    draft: Draft
    final_grades: Mapping[str, FinalGrade]
    contradictions: tuple[Contradiction, ...] = ()
    other_settings: tuple[str, ...] = ()

    @property
    def stops(self) -> bool:
        """Return whether a contradiction, such as two grades for a person, stops the export unless a person allows it."""
        return any(each.stops_export for each in self.contradictions)

    def lines(self) -> Iterator[str]:
        """Yield lines to read before the export: whom it affects, contradictions, and grades by other settings than the class's."""
        yield from self.draft.lines()
        yield from (printable(each.text, 2000) for each in self.contradictions)
        if self.other_settings:
            yield f"graded by other settings than the class: {', '.join(self.other_settings)} (grade them again)"

    def write(self) -> tuple[list[str], list[str]]:
        """Write grades and requested reports, even if `stops`; return lines on files, and on reports the platform may not place."""
        order = self.order
        target = order.target or order.out / order.platform.gradebook
        write_whole(target, self.draft.data)
        counts = [words.counted(self.draft.graded, "grade")]
        counts += [f"{len(self.draft.missing)} without a submission: 0"] if self.draft.missing else []
        counts += [f"{len(self.draft.blank)} blank"] if self.draft.blank else []
        lines = [f"{target}  {', '.join(counts)}"]
        if order.feedback is None:
            return lines, []
        reports, written, notes = _feedback(order.out, self.final_grades)
        write_whole(order.feedback, reports)
        lines.append(f"{order.feedback}  {words.counted(written, 'report')}")
        return lines, notes


def plan(order: Export) -> ExportPlan:
    """Prepare the export that `order` asks for without writing a file, so that a person sees the effects first.

    Raises
    ------
    RequestError
        If nothing was graded in the output folder, the platform takes no grades, the template is missing, superfluous or of another
        platform, or reports that are asked for do not match the class database.
    """
    _refuse_unfit(order)
    with Store.existing(order.out) as store:
        final_grades = store.final_grades()
        settings = store.settings()
        sent = list(final_grades.values()) if order.feedback else []
        outdated = outdated_pages(order.out, sent, store)
    if outdated:
        raise RequestError(
            f"{order.out}: {len(outdated)} of {len(sent)} reports do not match the record ({some(outdated, 5)}); "
            "give the `imugrade grade` command again: it writes them again"
        )
    absent = class_settings.absent(settings, {id_: each.hand_in for id_, each in final_grades.items()})
    if order.unreadable != "blank":  # a reviewed submission has a grade, an empty or unreadable one is blank until then
        final_grades = {id_: replace(each, reviewed=True) for id_, each in final_grades.items()}
    others = () if settings is None else class_settings.others(settings, final_grades)
    draft = _draft(order, final_grades, absent)
    found = contradictions(final_grades, settings, draft.without_row)
    return ExportPlan(order, draft, final_grades, tuple(found), tuple(printable(id_, 80) for id_ in others))


def _draft(order: Export, final_grades: Mapping[str, FinalGrade], absent: Sequence[Person]) -> Draft:
    """Build the file of grades before it is written: the platform's own file filled in if it is the template, else a new one."""
    missing = "" if order.missing == "blank" else order.missing
    blank = tuple(_blank_grades(final_grades, () if missing else absent))
    if order.template is not None:
        return _fill_template(order, final_grades, absent, missing, blank)
    assert order.platform.write is not None
    count = sum(len(each.people) for each in final_grades.values() if each.final is not None)
    names = tuple(words.absentees(absent, (each.hand_in for each in final_grades.values()))) if missing else ()
    return Draft(order.platform.write(final_grades, absent, missing), count, blank, names)


def _refuse_unfit(order: Export) -> None:
    """Raise RequestError if the platform takes no grades, or its template is missing, or one is given that it does not take."""
    fill, write, template = order.platform.fill, order.platform.write, order.template
    if fill is None and write is None:
        raise RequestError(f"--format {order.platform.name}: {order.platform.title} cannot import grades")
    if (write if template is None else fill) is not None:
        return
    needs = "needs --template with the file that it exports" if template is None else "takes no --template"
    why = "needs the file that it exports" if template is None else "takes no template"
    raise RequestError(
        f"--format {order.platform.name} {needs}", option="template", why=f"{order.platform.title} {why}"
    )


def _blank_grades(final_grades: Mapping[str, FinalGrade], absent: Sequence[Person]) -> Iterator[str]:
    """Yield each person who gets a blank grade, with the reason, so that no blank surprises; `absent` are without a submission."""
    for final_grade in final_grades.values():
        if final_grade.final is None:
            empty = "empty or unreadable; give points in the review desk, or --unreadable 0"
            why = empty if final_grade.unseen else "not judged, because the grader failed"
            yield f"{words.distinct(final_grade)}: {why}"
    for name in words.absentees(absent, (each.hand_in for each in final_grades.values())):
        yield f"{name}: {words.NO_SUBMISSION}"


def _fill_template(
    order: Export,
    final_grades: Mapping[str, FinalGrade],
    absent: Sequence[Person],
    missing: str,
    blank: tuple[str, ...],
) -> Draft:
    """Return the platform's own file with the grades filled in, and the people and rows that a person should review."""
    assert order.template is not None
    assert order.platform.fill is not None
    data = read_file(order.template, MAX_TEMPLATE, "give the file that the platform exports")
    template = Template(data, printable(str(order.template), 500), order.column, order.scaled, missing)
    filled = order.platform.fill(template, final_grades)
    known = directory(final_grades)
    without = Directory({f"{number}": (person,) for number, person in enumerate(absent)})
    strangers = [(name, known.why_not(who)) for who, name in filled.unmatched if without.find(who) is None]
    not_there = {
        final_grade.id: [_member_name(final_grade, person) for person in filled.without_row(final_grade)]
        for final_grade in final_grades.values()
        if final_grade.final is not None
    }
    return Draft(
        filled.data,
        filled.grades,
        blank,
        tuple(filled.missing),
        {id_: f"{'; '.join(names)}: graded, and not in the file" for id_, names in not_there.items() if names},
        tuple(filled.replaced),
        tuple(filled.kept),
        tuple(f"{name}: {why}" if why else name for name, why in strangers),
    )


def _member_name(final_grade: FinalGrade, person: Person) -> str:
    """Return a group member's name for the list of missing rows; with the submission's id if two of the class share the name."""
    name = person.name or final_grade.id
    return f"{name} ({final_grade.id})" if final_grade.namesake and name != final_grade.id else name


_BY_HAND = "send-yourself"
"""Folder of the zip with the reports that the platform cannot place."""
_WORDS = re.compile(r"[^\W_]+")  # platforms split names at "_"


def _feedback(out: Path, final_grades: Mapping[str, FinalGrade]) -> tuple[bytes, int, list[str]]:
    """Return a zip of all reports, named so that the platform finds each person, their number, and lines on any it cannot place."""
    buffer = io.BytesIO()
    people = [(each, person) for each in final_grades.values() for person in each.people]
    folders = distinct_ids(
        "-".join(_WORDS.findall(f"{person.name} {person.number or each.id}")) for each, person in people
    )
    by_hand, partners = [], []
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for (final_grade, person), folder in zip(people, folders, strict=True):
            name = printable(person.name or final_grade.id, 80)
            prefix = reply_to(final_grade, person)
            if not prefix:
                prefix = f"{_BY_HAND}/{folder}/"
                by_hand.append(name)
            elif person.platform != "moodle" and person != final_grade.people[0]:
                partners.append(name)
            entry = zipfile.ZipInfo(f"{prefix}report.html", _STAMP)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, (out / "submissions" / final_grade.id / "report.html").read_bytes())
    lines = (
        [f"the platform cannot place these reports; send them from {_BY_HAND} in the zip: {some(by_hand, 20)}"]
        if by_hand
        else []
    )
    if partners:
        lines.append(f"Canvas takes a partner's report only in an assignment of groups: {some(partners, 20)}")
    return buffer.getvalue(), len(people), lines
