"""Parts of a report on a grade beside the automatic points: overrides, comments, repairs, lateness, final points."""

from __future__ import annotations

from dataclasses import dataclass

from grader.base.text import printable
from grader.engine.results import Repair
from grader.people.final_grade import BONUS, TOTAL, FinalGrade
from grader.report import words


@dataclass(frozen=True)
class Override:
    """An override or a comment as a page shows it: what is overridden, points, automatic points, reason and author."""

    title: str
    points: str
    automatic: str
    comment: str
    author: str


@dataclass(frozen=True)
class RepairedFile:
    """An instructor's repair of a file as a page shows it; `lines` are those of the diff: kind (same, added, removed) and text."""

    file: str
    points: str
    comment: str
    author: str
    lines: tuple[tuple[str, str], ...]


def is_changed(final_grade: FinalGrade) -> bool:
    """Return whether the final points differ from the automatic ones, so that a page shows both; False without a final grade."""
    return final_grade.final is not None and round(final_grade.final, 2) != round(final_grade.result.total, 2)


def total(final_grade: FinalGrade) -> tuple[str, str]:
    """Return the final points and the maximum as text; the points are a dash as long as there is no final grade."""
    points, most = words.total_points(final_grade.result).split(" / ")
    if final_grade.unseen:
        return "–", most
    if final_grade.final is not None and (points == "–" or is_changed(final_grade)):
        return words.number(final_grade.final), most
    return points, most


def explained(final_grade: FinalGrade) -> str:
    """Return how the final grade came about: ``final 66 = score 78 (with overrides) + bonus 2 − repair 4 − late 10``.

    The text is "" as long as there is no final grade. Moodle comments always show it, pages only if `is_composed`.
    """
    if final_grade.final is None:
        return ""
    first, *others = final_grade.terms
    sums = [
        f"final {words.number(final_grade.final)} = {first.name} {words.number(first.points)}{_origin(final_grade)}"
    ]
    sums += [f"{'−' if each.points < 0 else '+'} {each.name} {words.number(abs(each.points))}" for each in others]
    return "; ".join(filter(None, (" ".join(sums), _not_deducted(final_grade), _above(final_grade))))


def is_composed(final_grade: FinalGrade) -> bool:
    """Return whether a grade has extra points, deductions or (even while `final` is None) overrides, so that pages explain it."""
    return len(final_grade.terms) > 1 or any(not each.alone for each in final_grade.adjustments)


def _origin(final_grade: FinalGrade) -> str:
    """Return in brackets how the first term of a grade was changed: set by a person, overridden in parts or repaired; "" if not."""
    total = final_grade.adjustment(TOTAL)
    if total is not None:
        return f" (set by {printable(total.author, 80)})"
    notes = ["with overrides"] if any(not a.alone and a.criterion != BONUS for a in final_grade.adjustments) else []
    notes += ["repaired"] if final_grade.result.repairs else []
    return f" ({', '.join(notes)})" if notes else ""


def _not_deducted(final_grade: FinalGrade) -> str:
    """Return what a person's override of the total leaves out (lateness, repairs, extra credit); "" if there is nothing."""
    late = final_grade.late
    deducts = final_grade.result.repair_deduction or (late is not None and (late.deduction or late.refused))
    credit = final_grade.result.extra_credit
    if not final_grade.total_is_set or not (deducts or credit):
        return ""
    kinds = ["lateness and repairs are not deducted"] if deducts else []
    kinds += ["extra credit is not added"] if credit else []
    return f"a total is final: {', '.join(kinds)}"


def _above(final_grade: FinalGrade) -> str:
    above = final_grade.final is not None and final_grade.final > final_grade.maximum
    return f"above the maximum of {words.number(final_grade.maximum)}" if above else ""


def late(final_grade: FinalGrade) -> tuple[str, str] | None:
    """Return two texts: the late deduction ("0" if none); how late, due and hand-in times, days, if known. None if not late."""
    late = final_grade.late
    if late is None:
        return None
    facts = [
        words.late(final_grade),
        f"due {words.instant(late.due)}" if late.due else "",
        f"handed in {words.instant(final_grade.hand_in.submitted)}" if final_grade.hand_in.submitted else "",
        f"counted as {words.counted(late.days, 'day')} late" if late.days and not late.refused else "",
    ]
    return words.minus(final_grade.deduction) if final_grade.deduction else "0", "; ".join(filter(None, facts))


def overrides(final_grade: FinalGrade) -> list[Override]:
    """Return the overrides and comments of a grade as a page shows them, in the order in which they were made."""
    titles = {
        criterion.id: (criterion.title, criterion.max_points, criterion.points)
        for criterion in final_grade.result.criteria
    }
    checks = [check for criterion in final_grade.result.criteria for check in criterion.checks]
    titles |= {check.id: (check.title, check.max_points, check.points or 0.0) for check in checks}
    found = []
    for given in final_grade.adjustments:
        title, most, automatic = titles.get(given.criterion, (given.criterion.capitalize(), 0.0, 0.0))
        points = "" if given.points is None else words.number(given.points)
        found.append(
            Override(
                printable(title, 300),
                f"{points} / {words.number(most)}" if points and most else points,
                words.number(automatic) if points and most and not final_grade.has_no_submission else "",
                printable(given.comment, words.TEXT_LIMIT, newlines=True),
                printable(given.author, 80),
            )
        )
    return found


def repaired_file(repair: Repair) -> RepairedFile:
    """Return a repair as a page shows it: file, deduction, comment, author and the lines of the diff."""
    return RepairedFile(
        printable(repair.file, 200),
        words.minus(repair.deduction) if repair.deduction else "0",
        printable(repair.comment, words.TEXT_LIMIT, newlines=True),
        printable(repair.author, 80),
        diff_lines(repair.diff),
    )


def diff_lines(diff: str) -> tuple[tuple[str, str], ...]:
    """Return the lines of a diff for a page, without file names, as kind and text: "added", "removed", "same" (also for `@@`)."""
    kinds = {"+": "added", "-": "removed"}
    shown = [printable(line, words.TEXT_LIMIT) for line in diff.split("\n")[2:]]
    return tuple((kinds.get(line[:1], "same"), line) for line in shown if line)
