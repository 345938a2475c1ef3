"""The handbook's page *fault × checks lost*, made from the corpus: `python -m tests.regenerate` writes it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from grader.engine import rubric
from grader.engine.rubric import Criterion
from grader.handbook import pages
from grader.labs.imu.lab import LAB
from tests.corpus.faulty import FAULTY, LOOKALIKES
from tests.scoreboard import ONE_FAULT

FILE = pages.FOLDER / "faults.txt"
_HEAD = """# Faults, and the checks that they lose

Each submission of the corpus is sound but for one fault. A row tells how many of those with one mistake lose a check: the aim is
one number in each row, as a fault is charged once. A number in brackets: that many could not be asked, for want of an answer
or of the thing itself, as a check's message then says. What a missing file costs in other criteria is not shown.
"""
_MISTAKE = {
    f"{part}/{fault.name}": (fault.criterion, fault.mistake)
    for part, faults in zip(ONE_FAULT, (FAULTY, LOOKALIKES), strict=True)
    for fault in faults
}
Lost = Mapping[str, Mapping[str, float | None]]


def page(lost: Lost) -> str:
    """The whole page, from what each submission loses: the share of its points that a check keeps, None where it was not asked."""
    tables = ("\n".join(_table(criterion, lost)) for criterion in rubric.load(LAB).criteria)
    return "\n".join((_HEAD, *tables))


def _table(criterion: Criterion, lost: Lost) -> Iterator[str]:
    checks = [check.id for check in criterion.checks]
    yield f"## {criterion.title}\n"
    names = [f"`{check.partition('.')[2]}`" for check in checks]
    yield f"| Mistake | {' | '.join(names)} |"
    yield "| --- |" + " --- |" * len(checks)
    mistakes = dict.fromkeys(mistake for part, mistake in _MISTAKE.values() if part == criterion.id)
    for mistake in mistakes:
        own = [case for case, its in _MISTAKE.items() if its == (criterion.id, mistake)]
        times = Counter((check, kept is None) for case in own for check, kept in lost.get(case, {}).items())
        cells = (_cell(times[check, False], times[check, True]) for check in checks)
        yield f"| {mistake or '(no name)'}, {len(own)} | {' | '.join(cells)} |"
    yield ""


def _cell(charged: int, not_asked: int) -> str:
    return " ".join([*([str(charged)] if charged else []), *([f"({not_asked})"] if not_asked else [])])
