"""Lost checks by their cause, and what to do next: a mistake that costs ten checks is told once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from grader.engine.lab import Lab
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.ground.text import printable
from grader.report import words

_LAST = 99  # a check without a step of the sheet comes after those that have one


@dataclass(frozen=True)
class Cause:
    """Checks that were lost for one reason: they show the same mistakes, or were told the same."""

    checks: tuple[CheckResult, ...]

    @property
    def mistakes(self) -> tuple[str, ...]:
        """What `imugrade explain` explains of it."""
        return told_mistakes(self.checks[0])

    @property
    def steps(self) -> tuple[int, ...]:
        """The steps of the sheet to read."""
        return tuple(dict.fromkeys(check.lab_step for check in self.checks if check.lab_step is not None))


def told_mistakes(check: CheckResult) -> tuple[str, ...]:
    return tuple(each for each in check.misconceptions if each not in words.FOR_THE_INSTRUCTOR)


def part_of(check: CheckResult) -> str:
    """The criterion or extension that a check is of."""
    return check.id.partition(".")[0]


def parts_of(result: Result, only: str | None) -> list[CriterionResult | ExtensionResult]:
    """What is shown of a result: its criteria and the extensions that were tried, or the one that was asked for."""
    if result.status in ("empty", "unreadable"):
        return []  # thirty rows would all say so
    attempted = [extension for extension in result.extensions if extension.attempted and extension.checks]
    parts: list[CriterionResult | ExtensionResult] = [*result.criteria, *attempted]
    return parts if only is None else [part for part in parts if part.id == only]


def causes_of(checks: Iterable[CheckResult]) -> list[Cause]:
    """The reasons in the order of the sheet's steps; what was not reached, or not judged, has none of its own."""
    found: dict[tuple[str, ...], list[CheckResult]] = {}
    for check in sorted(checks, key=_step):
        if words.tells(check):
            found.setdefault(told_mistakes(check) or (check.outcome, check.message), []).append(check)
    return [Cause(tuple(together)) for together in found.values()]


def told(cause: Cause) -> list[tuple[CheckResult, list[words.Line]]]:
    """Each check of a cause with what it says that none before it has said; what to try is the same for all."""
    known: set[str] = set()
    return [(check, _news(check, known)) for check in cause.checks]


def _news(check: CheckResult, known: set[str]) -> list[words.Line]:
    """What a check says that is not `known`, which grows by it."""
    said = [line for line in words.row(check, "", LabName()).lines if line.label != "Try"]
    came = {line.text for line in said if line.label != "Expected"}
    if came <= known:
        return []
    news = said if not known or check.outcome in ("failed", "partial") else _where(said)
    known |= came
    return news


def _where(said: Iterable[words.Line]) -> list[words.Line]:
    """Of a call that did not come back, the line that names the place."""
    return [words.Line(line.label, line.text.partition("\n")[0]) for line in said if line.label == "Got"]


def going_on(cause: Cause, lab: LabName) -> list[words.Line]:
    """What to try and to read, for all checks of a cause."""
    hints = dict.fromkeys(
        line.text for check in cause.checks for line in words.row(check, "", lab).lines if line.label == "Try"
    )
    read = "; ".join(
        filter(None, [_sheet(cause, lab), *(f"imugrade explain {printable(each, 80)}" for each in cause.mistakes)])
    )
    return [*(words.Line("Try", hint) for hint in hints), *([words.Line("Read", read)] if read else [])]


def again(cause: Cause) -> words.Line:
    """How to run what it cost again."""
    return words.Line("Again", f"imugrade check --only {part_of(cause.checks[0])}")


def _sheet(cause: Cause, lab: LabName) -> str:
    """``Lab 04-01, Steps 2, 5 and 6``"""
    steps = [str(step) for step in cause.steps]
    plural = "s" if len(steps) > 1 else ""
    many = " and ".join(filter(None, (", ".join(steps[:-1]), *steps[-1:])))
    return f"{lab.label}, Step{plural} {many}" if steps else ""


def _step(check: CheckResult) -> int:
    return _LAST if check.lab_step is None else check.lab_step


def next_step(found: Iterable[Cause], lab: Lab) -> str:
    """``Step 2, get_imu_readings``: where to go on; empty where nothing was lost."""
    first = next((each.checks[0] for each in found), None)
    if first is None:
        return ""
    step = f"Step {first.lab_step}" if first.lab_step is not None else ""
    return ", ".join(filter(None, (step, lab.name_of(first.id))))


def next_part(found: Iterable[Cause]) -> str:
    """The criterion or extension of the next step."""
    return next((part_of(each.checks[0]) for each in found), "")
