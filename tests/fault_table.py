"""The handbook's page *fault × checks lost*, made from the corpus: `python -m tests.scoreboard --table` writes it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from grader.engine import rubric
from grader.engine.rubric import Criterion
from grader.handbook import pages
from grader.labs.imu.lab import LAB
from tests.corpus.faulty import FAULTY, LOOKALIKES
from tests.scoreboard import ONE_FAULT, Verdict

FILE = pages.FOLDER / "faults.txt"
_HEAD = """# Faults, and the checks that they lose

Each submission of the corpus is sound but for one fault. A row tells how many of those with one mistake lose a check: the aim is
one number in each row, as a fault is charged once. A number in brackets: that many could not be asked, for want of an answer
or of the thing itself, as a check's message then says. What a missing file costs in other criteria is not shown.
"""
_MISTAKE = {fault.name: (fault.criterion, fault.mistake) for fault in (*FAULTY, *LOOKALIKES)}


def page(verdicts: Sequence[Verdict]) -> str:
    """The whole page, from the verdicts on every submission with a single fault."""
    single = [verdict for verdict in verdicts if verdict.case.part in ONE_FAULT]
    tables = ("\n".join(_table(criterion, single)) for criterion in rubric.load(LAB).criteria)
    return "\n".join((_HEAD, *tables))


def _table(criterion: Criterion, verdicts: Sequence[Verdict]) -> Iterator[str]:
    checks = [check.id for check in criterion.checks]
    yield f"## {criterion.title}\n"
    names = [f"`{check.partition('.')[2]}`" for check in checks]
    yield f"| Mistake | {' | '.join(names)} |"
    yield "| --- |" + " --- |" * len(checks)
    mistakes = dict.fromkeys(mistake for part, mistake in _MISTAKE.values() if part == criterion.id)
    for mistake in mistakes:
        own = [verdict for verdict in verdicts if _MISTAKE[verdict.case.name] == (criterion.id, mistake)]
        lost = Counter((check.id, check.outcome == "skipped") for verdict in own for check in verdict.lost)
        cells = (_cell(lost[check, False], lost[check, True]) for check in checks)
        yield f"| {mistake}, {len(own)} | {' | '.join(cells)} |"
    yield ""


def _cell(charged: int, not_asked: int) -> str:
    return " ".join([*([str(charged)] if charged else []), *([f"({not_asked})"] if not_asked else [])])
