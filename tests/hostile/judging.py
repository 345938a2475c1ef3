"""Running one attack on one isolation level and telling whether it was held."""

from __future__ import annotations

import os
import re
import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.engine.rubric import Limits
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files, Link, write
from tests.hostile import outputs
from tests.hostile.decoys import Decoys, below
from tests.hostile.program import Program

LIMITS = Limits(call_cpu_s=2.0, submission_cpu_s=12.0)
"""Small, so that loops are cheap; sound code needs 0.3 s for its longest call."""
WALL_LIMIT_S = 150.0
"""A call that sleeps is cut after 22 s, and a submission after a few of those; the rest is for a busy machine."""
_SECRET_SEED = "a secret that must not leave 4711"  # that of the other tests, which is recorded once


@dataclass
class Verdict:
    """How one attack ended; it was held if there are no troubles."""

    program: Program
    seconds: float = 0.0
    score: float = 0.0
    twin: float | None = None
    troubles: list[str] = field(default_factory=list)


class AttackJudge(ExitStack):
    """One isolation level with its markers and decoys; a context manager."""

    def __init__(self, isolation_level: str | None) -> None:
        super().__init__()
        self.isolation_level = isolation_level
        self._scores: dict[tuple[object, ...], float] = {}
        self._markers: dict[bool, Marker] = {}

    def __enter__(self) -> AttackJudge:
        super().__enter__()
        self._bait = self.enter_context(Decoys())
        self._neighbour_scores = self._neighbour()
        return self

    def _marker(self, hidden: bool) -> Marker:
        if hidden not in self._markers:
            traces = bundles.obtain(LAB, _SECRET_SEED) if hidden else bundles.shipped()
            limited = replace(rubric.load(LAB), limits=LIMITS)
            opened = self.enter_context(Marker(limited, traces, isolation_level=self.isolation_level))
            self._markers[hidden] = opened
            self.isolation_level = opened.isolation.name
            self._expected = frozenset(below(os.getpid()))
        return self._markers[hidden]

    def _mark(self, files: Files, program: Program) -> Result:
        with tempfile.TemporaryDirectory() as scratch:
            path = write(self._bait.fill(files), Path(scratch) / program.folder, program.as_)
            return self._marker(program.hidden).mark(read_submission(path, LAB.files), only=program.only)

    def _neighbour(self) -> Mapping[str, float | None]:
        """What a sound submission scores after all that went before; one criterion stands for all of them."""
        with tempfile.TemporaryDirectory() as scratch:
            submission = read_submission(write(tidy(), Path(scratch) / "neighbour"), LAB.files)
            (criterion,) = self._marker(hidden=False).mark(submission, only="filtering").criteria
        return {check.id: check.points for check in criterion.checks}

    def try_(self, program: Program) -> Verdict:
        """Run an attack; never raises for what it does."""
        verdict = Verdict(program)
        started = time.monotonic()
        try:
            result = self._mark(program.files, program)
        except Exception as problem:
            verdict.troubles.append(f"the grader failed: {type(problem).__name__}: {problem}")
            return verdict
        verdict.seconds, verdict.score = time.monotonic() - started, result.score
        verdict.troubles += self._of_result(result, program, verdict)
        if verdict.seconds > WALL_LIMIT_S:
            verdict.troubles.append(f"it took {verdict.seconds:.0f} s")
        if self._neighbour() != self._neighbour_scores:
            verdict.troubles.append("a neighbour's marks changed")
        verdict.troubles += self._bait.troubles(self._expected)
        return verdict

    def _of_result(self, result: Result, program: Program, verdict: Verdict) -> list[str]:
        found = outputs.troubles(result)
        if result.provenance.get("isolation") != self.isolation_level:
            found.append(f"the result names the isolation level {result.provenance.get('isolation')}")
        unjudged = [check.id for criterion in result.criteria for check in criterion.checks if check.points is None]
        if unjudged or result.status == "incomplete":
            said = next(c.message for criterion in result.criteria for c in criterion.checks if c.points is None)
            found.append(f"{len(unjudged)} checks are not judged: {said[:200]}")
        for criterion in result.criteria:
            if criterion.id in program.keeps and criterion.points != criterion.max_points:
                rows = [f"{c.id}: {c.message[:120]!r}" for c in criterion.checks if c.points != c.max_points]
                found.append(f"{criterion.id} lost points that the attack is not about: {'; '.join(rows)}")
        if program.hidden:
            found += [f"hidden data shows: {text[:120]!r}" for text in _carried_out(result)]
        if program.twin is not None:
            verdict.twin = self._twin(program)
            if result.score > verdict.twin:
                found.append(f"{result.score:g} points, without the attack {verdict.twin:g}")
        return found

    def _twin(self, program: Program) -> float:
        assert program.twin is not None
        key = (program.only, program.hidden, *sorted((n, c.target if isinstance(c, Link) else c) for n, c in program.twin.items()))
        if key not in self._scores:
            self._scores[key] = self._mark(program.twin, program).score
        return self._scores[key]


def _carried_out(result: Result) -> list[str]:
    """Texts in which a hidden state, or a number that stands for one, has got out; see `poisoning.CARRIES`."""
    checks = [check for part in (*result.criteria, *result.extensions) for check in part.checks]
    texts = [*result.notes, *(check.message for check in checks), *(check.hint for check in checks)]
    return [text for text in texts if re.search(r"HIDDEN|\b(39|40)\d\d\.\d|\bline \d{3,}", text)]
