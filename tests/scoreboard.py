"""Scoreboard of false deductions and missed faults: `python -m tests.scoreboard [--only NAME]`."""

from __future__ import annotations

import argparse
import math
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

from grader.engine import rubric
from grader.engine.faults import rows
from grader.engine.grader import Marker
from grader.engine.results import CheckResult, Result
from grader.intake import Submission, read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.report.words import tells
from tests.corpus.cases import CRITERIA, Case, of
from tests.corpus.pieces import LAYOUTS
from tests.corpus.writing import write
from tests.recordings import Marking


@dataclass
class Verdict:
    """What the scoreboard says of one case: its troubles, each with its kind."""

    case: Case
    troubles: list[tuple[str, str]] = field(default_factory=list)
    result: Result | None = None

    @property
    def lost(self) -> tuple[CheckResult, ...]:
        return () if self.result is None else tuple(lost(self.result))

    def trouble(self, kind: str, text: str) -> None:
        self.troubles.append((kind, text))


def as_written() -> Iterator[Case]:
    """The corpus in the layout that it is written in."""
    for part in ("sound", "faulty", "lookalikes", "pairs", "broken", "nothing"):
        yield from of(part)
    for layout, put in LAYOUTS.items():
        for edit in of("module level"):
            yield replace(edit, name=f"{edit.name} in {layout}", files=put(edit.files))  # type: ignore[arg-type]
    yield from (case for case in of("extensions") if case.fault != "never-returns")


# ---------------------------------------------------------------- judging a result


def lost(result: Result) -> list[CheckResult]:
    """Checks with fewer points than they could have, or that could not be judged."""
    checks = [check for criterion in result.criteria for check in criterion.checks]
    return [check for check in checks if check.points is None or check.points < check.max_points]


def criterion_of(check: CheckResult) -> str:
    return check.id.split(".")[0]


def words(checks: Iterable[CheckResult]) -> str:
    """Checks in one line: id, outcome, points, and the start of what the grader said."""
    return "; ".join(
        f"{c.id} {c.outcome} {c.points}/{c.max_points} {list(c.misconceptions) or ''} {c.message[:160]!r}"
        for c in checks
    )


def look_at_points(verdict: Verdict, result: Result, may: Mapping[str, float], must: Iterable[str]) -> None:
    """A criterion loses no more points than it `may`, none where nothing is said, and something where it `must`."""
    for criterion in result.criteria:
        taken = sum(check.max_points - (check.points or 0.0) for check in criterion.checks)
        if taken > may.get(criterion.id, 0.0) + 1e-6:
            verdict.trouble("too much", words(c for c in lost(result) if criterion_of(c) == criterion.id))
        if criterion.id in must and not taken:
            verdict.trouble("missed", f"costs nothing in {criterion.id}")


def look_at_sound(verdict: Verdict, result: Result, sound: Case) -> None:
    if result.status != "graded":
        verdict.trouble("status", result.status)
    look_at_points(verdict, result, {}, ())
    if result.misconceptions:
        verdict.trouble("named wrong", ", ".join(result.misconceptions))


def look_at_fault(verdict: Verdict, result: Result, case: Case) -> None:
    """A fault, or each of two, costs something in its criterion and nothing elsewhere, and has a name."""
    faults = case.faults or {case.fault: case.criterion}
    look_at_points(verdict, result, dict.fromkeys((*faults.values(), *case.elsewhere), math.inf), faults.values())
    inside = [check for check in lost(result) if criterion_of(check) == case.criterion]
    broken = {*case.loses, *breaks(case.fault)}
    if case.loses and (more := [check for check in inside if check.id not in broken]):
        verdict.trouble("too much", f"only {', '.join(broken)} should be lost, but also {words(more)}")
    names = named(result, without=case.elsewhere)  # a missing file may be named again where it is missed
    _look_at_names(verdict, result, names, set(faults), {*faults, *case.also}, case.never)


def breaks(fault: str) -> list[str]:
    """Return the checks that a fault costs points at, as the fault table says."""
    row = rows(LAB).get(fault)
    return (
        [name if "." in name else f"{row.group}.{name}" for name, share in row.deducts.items() if share] if row else []
    )


_VECTOR = re.compile(r"\[[^\]]*\.[^\]]*\]")


def look_at_words(verdict: Verdict) -> None:
    """Whoever loses points is told how to go on, and never reads the same digits as expected and as what came."""
    for check in filter(tells, verdict.lost):
        expected, _, got = check.message.removeprefix("Expected").partition("\nGot")
        vectors = [_VECTOR.findall(text)[:1] for text in (expected, got)]
        if not check.hint:
            verdict.trouble("no hint", words([check]))
        if expected.strip() == got.strip() or (vectors[0] and vectors[0] == vectors[1]):
            verdict.trouble("same digits", words([check]))


def look_at_nothing(verdict: Verdict, result: Result, nothing: Case) -> None:
    look_at_points(verdict, result, {nothing.criterion: math.inf}, ())
    for criterion in result.criteria:
        if criterion.id == nothing.criterion and criterion.points > nothing.earns:
            verdict.trouble("earns too much", f"{criterion.points} for {criterion.title}; lost: {words(lost(result))}")


def named(result: Result, without: Sequence[str] = ()) -> set[str]:
    """The faults that the checks name, other than those of some criteria."""
    checks = [check for criterion in result.criteria if criterion.id not in without for check in criterion.checks]
    return {fault for check in checks for fault in check.misconceptions}


def _look_at_names(
    verdict: Verdict, result: Result, names: set[str], wanted: set[str], right: set[str], never: Sequence[str]
) -> None:
    """One right name is enough where several describe the same fault; of two faults, each is counted."""
    wanted -= {"tampering", ""}  # shown to the instructor, as a note, and costs nothing; or without a name
    found = names & right
    count = min(len(wanted), len(found))
    if count < len(wanted):
        verdict.trouble("not named", f"{', '.join(sorted(wanted - names))}; lost: {words(lost(result))}")
    if wrong := names - right:
        looks = " (the lookalike!)" if wrong & set(never) else ""
        verdict.trouble("named wrong", f"{', '.join(sorted(wrong))}{looks} in place of {', '.join(sorted(right))}")


def look_at_broken(verdict: Verdict, result: Result, broken: Case) -> None:
    if result.status not in broken.status:
        verdict.trouble("status", f"{result.status}, not {' or '.join(broken.status)}")
    may_lose = [criterion for criterion in CRITERIA if criterion not in broken.keeps]
    look_at_points(verdict, result, dict.fromkeys(may_lose, math.inf), (broken.costs,))
    if any(check.points is None for criterion in result.criteria for check in criterion.checks):
        verdict.trouble("not judged", words(c for c in lost(result) if c.points is None))
    if broken.names:
        names = named(result, without=[criterion for criterion in CRITERIA if criterion != broken.costs])
        _look_at_names(verdict, result, names, {broken.names[0]}, set(broken.names), ())


def look_at_extension(verdict: Verdict, result: Result, case: Case) -> None:
    """A sound one passes every check; a faulty one loses what it gets wrong and no more, but for filters of tilt."""
    (extension,) = result.extensions
    gone = {check.id for check in extension.checks if check.outcome != "passed"}
    wanted = set(case.loses)
    if not extension.attempted or gone < wanted:
        verdict.trouble("missed", f"{', '.join(sorted(wanted - gone)) or 'not attempted'} kept")
    if gone - wanted and not (wanted and case.criterion == "complementary_filter"):
        verdict.trouble("too much", words(c for c in extension.checks if c.id in gone - wanted))
    named = (case.fault,) if case.fault else ()
    if result.misconceptions != named:
        verdict.trouble(
            "named wrong", f"{', '.join(result.misconceptions) or 'none'} in place of {', '.join(named) or 'none'}"
        )


def look_at_edit(verdict: Verdict, result: Result, edit: Case) -> None:
    look_at_points(verdict, result, edit.takes or {}, edit.must)


_LOOKS: Mapping[str, Callable[[Verdict, Result, Case], None]] = {
    "sound": look_at_sound, "faulty": look_at_fault, "lookalikes": look_at_fault, "pairs": look_at_fault, "broken": look_at_broken,
    "module level": look_at_edit, "nothing": look_at_nothing, "extensions": look_at_extension,
}  # fmt: skip


# ---------------------------------------------------------------- grading


@cache
def _marker() -> Marker:
    return Marker(rubric.load(LAB), bundles.shipped()).__enter__()


def handed_in(case: Case) -> Submission:
    """A case as the marker gets it."""
    with tempfile.TemporaryDirectory() as scratch:
        return read_submission(write(case.files, Path(scratch) / "submission", case.as_), LAB.files)


def grade(case: Case) -> Verdict:
    """Grade one case in this process; the marker stays warm for the next."""
    return graded_by(_marker(), case)


def graded_by(marker: Marking, case: Case) -> Verdict:
    """What the scoreboard says of a case that this marker grades."""
    verdict = Verdict(case)
    try:
        verdict.result = marker.mark(handed_in(case), only=case.only)
    except Exception as problem:
        verdict.trouble("grader failed", f"{type(problem).__name__}: {problem}")
        return verdict
    if case.part in ("faulty", "lookalikes", "pairs", "broken", "nothing"):
        look_at_words(verdict)
    _LOOKS[case.part](verdict, verdict.result, case)
    return verdict


def grade_all(chosen: Sequence[Case]) -> Iterator[Verdict]:
    """Verdicts in order, with a line for each trouble as it is found, and the progress."""
    with ProcessPoolExecutor() as pool:
        for number, verdict in enumerate(pool.map(grade, chosen), 1):
            end = "\r" if sys.stderr.isatty() else "\n"
            print(f"{number} of {len(chosen)} submissions graded", end=end, file=sys.stderr, flush=True)
            for kind, text in verdict.troubles:
                print(f"{verdict.case.part}/{verdict.case.name}: {kind}: {text}", flush=True)
            yield verdict


def table(verdicts: Sequence[Verdict]) -> str:
    """Of each part of the corpus how many cases were graded, and how many of them have each kind of trouble."""
    lines = []
    for part, size in Counter(verdict.case.part for verdict in verdicts).items():
        kinds = Counter(kind for v in verdicts if v.case.part == part for kind in {kind for kind, _ in v.troubles})
        lines.append(f"{part:<12} {size:>4}  {', '.join(f'{kind}: {n}' for kind, n in kinds.items()) or 'no trouble'}")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.scoreboard", description=__doc__)
    parser.add_argument("--only", default="", help="cases whose name holds this, or of this criterion")
    options = parser.parse_args(arguments)
    chosen = [case for case in as_written() if options.only in case.name or options.only == case.criterion]
    if not chosen:
        parser.error(
            f"no row of the corpus has {options.only!r} in its name, and no criterion is called so; "
            "rows of habits.yaml and unforeseen.yaml are judged by python -m pytest tests/test_deducted_once.py"
        )
    verdicts = list(grade_all(chosen))
    print(table(verdicts))
    return int(any(verdict.troubles for verdict in verdicts))


if __name__ == "__main__":
    sys.exit(main())
