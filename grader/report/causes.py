"""Group the failed checks of a result by fault, and say what to do next: a fault that fails ten checks is reported once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from grader.base.text import enumerated, printable
from grader.engine.lab import Lab
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.report import words

_LAST = 99
"""Sort key of a check without a lab step: it comes after those that have one."""


@dataclass(frozen=True)
class Cause:
    """One fault with the checks that lost points by it; without a known fault, the checks that failed with the same message.

    `waiting` are the skipped checks of the same criteria; of several causes in a criterion, only the first has them. A check with
    two faults is in two causes, each with its share of the lost points.
    """

    checks: tuple[CheckResult, ...]
    waiting: tuple[CheckResult, ...] = ()

    @property
    def lost(self) -> float:
        """Return the points lost on the cause's failed checks and on the skipped checks that wait for them."""
        return words.points_lost((*self.checks, *self.waiting))

    @property
    def does_not_run(self) -> bool:
        """Return whether a file cannot be imported, or a required function raises, hangs or ends its process."""
        return any(map(_does_not_run, self.checks))

    @property
    def faults(self) -> tuple[str, ...]:
        """Return the ids of the known faults behind this cause, for `imugrade explain`; () if no fault was recognised."""
        return faults_of(self.checks[0])

    @property
    def steps(self) -> tuple[int, ...]:
        """Return the steps of the lab sheet that the failed checks are about, for the student to read again."""
        return tuple(dict.fromkeys(check.lab_step for check in self.checks if check.lab_step is not None))


@dataclass(frozen=True)
class Stop:
    """A place where a submission does not run, and what that costs, for reports and for suggesting a repair.

    Attributes
    ----------
    file, line
        File and line at which it stops; "" and None if unknown.
    error
        Python's own message, or that the call had no answer.
    lost
        Points lost because of this place, including those of checks of other code that needs the failing code.
    """

    file: str
    line: int | None
    error: str
    lost: float

    @property
    def sentence(self) -> str:
        """Return place (if known), error and loss: ``filters.py, line 19: SyntaxError: expected ':'. Costs 20 points.``"""
        where = f"{self.file}, line {self.line}" if self.line else self.file
        error = self.error.removesuffix(f" at {where}")
        return f"{where}{': ' if where else ''}{error.rstrip('.')}. Costs {words.counted_points(self.lost)}."


def stops(result: Result, lab: Lab) -> list[Stop]:
    """Return where code that the criteria need does not run: it does not parse or import, it raises, hangs or ends its process."""
    if result.status in ("empty", "unreadable"):
        return []
    checks = [check for part in result.criteria for check in part.checks]
    causes = [cause for cause in causes_of(checks) if cause.does_not_run and cause.lost]
    found = [_stop(cause, lab) for cause in causes]
    known = {check.id for cause in causes for check in (*cause.checks, *cause.waiting)}
    for check in (check for check in checks if check.id not in known):
        for place in _needed(check, causes, found, lab)[:1]:
            found[place] = replace(found[place], lost=found[place].lost + words.points_lost([check]))
    return found


def _needed(check: CheckResult, causes: Sequence[Cause], found: Sequence[Stop], lab: Lab) -> list[int]:
    """Return the places in `found` that made a check fail: its code does not run there, or it raised and there is one place."""
    name = lab.name_of(check.id)
    names = [{lab.name_of(each.id) for each in cause.checks if _does_not_import(each)} for cause in causes]
    here = [at for at, each in enumerate(found) if name in names[at] or (check.where and check.where.file == each.file)]
    return here or [0] * (check.where is not None and len(found) == 1)


def _does_not_import(check: CheckResult) -> bool:
    return "does-not-import" in check.misconceptions


def _stop(cause: Cause, lab: Lab) -> Stop:
    check = next((check for check in cause.checks if check.where), cause.checks[0])
    file, line = (check.where.file, check.where.line) if check.where else ("", None)
    name = lab.name_of(check.id)
    error = (check.got or check.said or words.row(check, "", LabName()).outcome.word).partition("\n")[0]
    said = error if check.where else f"{name}: {error.removeprefix('none: ')}"
    return Stop(printable(file or lab.homes.get(name, ""), 200), line, printable(said, 500), cause.lost)


def faults_of(check: CheckResult) -> tuple[str, ...]:
    """Return the ids of a check's faults that a student may see; others, such as tampering, are for the instructor."""
    return tuple(each for each in check.misconceptions if each not in words.FOR_THE_INSTRUCTOR)


def part_of(check: CheckResult) -> str:
    """Return the id of the criterion or extension that a check belongs to, such as for `imugrade check --only`."""
    return check.id.partition(".")[0]


def parts_of(result: Result, only: str | None) -> list[CriterionResult | ExtensionResult]:
    """Return the criteria and attempted extensions to show (with `only`, that one); [] for an empty or unreadable submission."""
    if result.status in ("empty", "unreadable"):
        return []  # all rows would say the same
    attempted = [extension for extension in result.extensions if extension.attempted and extension.checks]
    parts: list[CriterionResult | ExtensionResult] = [*result.criteria, *attempted]
    return parts if only is None else [part for part in parts if part.id == only]


def causes_of(checks: Iterable[CheckResult]) -> list[Cause]:
    """Group failed checks by fault (their cause): first code that does not run, then the rest, both in the order of lab steps.

    A skipped check is in `Cause.waiting` if a check of its criterion failed. Checks that the grader could not judge are left out.
    """
    found: dict[tuple[str, ...], list[CheckResult]] = {}
    skipped: dict[str, list[CheckResult]] = {}
    for check in sorted(checks, key=lambda check: (not _does_not_run(check), _step(check))):
        if words.tells(check):
            for key, its_part in _by_fault(check):
                found.setdefault(key, []).append(its_part)
        elif check.outcome == "skipped":
            skipped.setdefault(part_of(check), []).append(check)
    causes = []
    for together in found.values():
        together.sort(key=lambda check: not (check.expected or check.said))  # checks that tell about the fault first
        parts = dict.fromkeys(map(part_of, together))
        causes.append(Cause(tuple(together), tuple(check for part in parts for check in skipped.pop(part, ()))))
    return causes


def _by_fault(check: CheckResult) -> Iterator[tuple[tuple[str, ...], CheckResult]]:
    """Yield for each fault of a check a key that groups it with other checks, and the check as if that fault were its only one."""
    if not check.deducted:
        yield faults_of(check) or (check.outcome, check.message), check
    shares = sum(each.share for each in check.deducted)
    for each in check.deducted:
        lost = words.points_lost([check]) * each.share / shares
        yield (
            (each.fault,),
            replace(
                check, points=check.max_points - lost, said=each.said, expected=each.expected, got=each.got, hint=each.hint,
                misconceptions=(each.fault,) if each.fault in check.misconceptions else (),
            ),
        )  # fmt: skip


def _does_not_run(check: CheckResult) -> bool:
    if "not-written" in check.misconceptions:  # a step of the starter files that is still to be done
        return False
    return check.outcome in ("error", "timeout", "crashed") or _does_not_import(check)


def points_of(check: CheckResult) -> str:
    """Return a check's points, ``0 / 6``; with several faults, what the one it is listed under took, ``−1.5``; "" if worth 0."""
    return (
        words.minus(words.points_lost([check])) if len(check.deducted) > 1 else words.row(check, "", LabName()).points
    )


def cost_now(cause: Cause) -> list[words.LabelledLine]:
    """Return the line *Costs* for code that does not run: points lost, and how many checks could not run; [] for other faults."""
    if not cause.does_not_run or not cause.lost:
        return []
    points = f"{words.counted_points(cause.lost)} now"
    many = len(cause.waiting)
    waiting = f", because {many} more check{'s' * (many > 1)} could not run" if many else ""
    return [words.LabelledLine("Costs", f"{points}{waiting}. Everything else was graded without it.")]


def lines_by_check(cause: Cause) -> list[tuple[CheckResult, list[words.LabelledLine]]]:
    """Return the failed checks of a cause, with feedback but no hints; [] for a check if earlier ones of the cause say the same."""
    known: set[str] = set()
    return [(check, _news(check, known)) for check in cause.checks]


def _news(check: CheckResult, known: set[str]) -> list[words.LabelledLine]:
    """Return the lines of a check's feedback unless all are in `known`, the texts shown before; add them to `known`."""
    said = [line for line in words.row(check, "", LabName()).lines if line.label != "Try"]
    came = {line.text for line in said if line.label != "Expected"}
    if came <= known:
        return []
    news = said if not known or check.outcome in ("failed", "partial") else _where(said)
    known |= came
    return news


def _where(said: Iterable[words.LabelledLine]) -> list[words.LabelledLine]:
    """Return the first line of each `Got`, the place of a failed call: enough where an earlier check shows the whole error."""
    return [words.LabelledLine(line.label, line.text.partition("\n")[0]) for line in said if line.label == "Got"]


def next_lines(cause: Cause, lab: LabName) -> list[words.LabelledLine]:
    """Return the last lines on a fault: *Costs* if code does not run (`cost_now`), then *Try* (hints) and *Read* (what to read)."""
    hints = dict.fromkeys(
        line.text for check in cause.checks for line in words.row(check, "", lab).lines if line.label == "Try"
    )
    read = "; ".join(
        filter(None, [_sheet(cause, lab), *(f"imugrade explain {printable(each, 80)}" for each in cause.faults)])
    )
    lines = [
        *(words.LabelledLine("Try", hint) for hint in hints),
        *([words.LabelledLine("Read", read)] if read else []),
    ]
    return [*cost_now(cause), *lines]


def again(cause: Cause) -> words.LabelledLine:
    """Return the line *Rerun* of a report: the command that grades the criterion of the cause's first check again."""
    return words.LabelledLine("Rerun", f"imugrade check --only {part_of(cause.checks[0])}")


def _sheet(cause: Cause, lab: LabName) -> str:
    """Return the lab steps that a fault is about as ``Lab 04-01, Steps 2, 5 and 6``; "" without steps."""
    steps = [str(step) for step in cause.steps]
    plural = "s" if len(steps) > 1 else ""
    return f"{lab.label}, Step{plural} {enumerated(steps)}" if steps else ""


def _step(check: CheckResult) -> int:
    return _LAST if check.lab_step is None else check.lab_step


def next_step(found: Iterable[Cause], lab: Lab) -> str:
    """Return where a student continues, ``Step 2, get_imu_readings``: step and function of the first cause, if known; else ""."""
    first = next((each.checks[0] for each in found), None)
    if first is None:
        return ""
    step = f"Step {first.lab_step}" if first.lab_step is not None else ""
    return ", ".join(filter(None, (step, lab.name_of(first.id))))


def next_part(found: Iterable[Cause]) -> str:
    """Return the id of the criterion or extension of the first cause, to grade it again after an edit; "" if nothing failed."""
    return next((part_of(each.checks[0]) for each in found), "")
