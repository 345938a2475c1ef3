"""Scoreboard of false deductions and missed faults: `python -m tests.scoreboard [--only NAME]`."""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.results import CheckResult, Result
from grader.intake import Submission, read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.report.words import tells
from tests.corpus.cases import CRITERIA, Case, of
from tests.corpus.pieces import LAYOUTS
from tests.corpus.writing import write
from tests.layout_variants import VARIANTS, can_be_rearranged
from tests.recordings import Marking

ONE_FAULT = ("faulty", "lookalikes")
_WHOLE_FILE = "the file that is missing was to hold two parts or more, and each part has nothing to show"
_UNPARSED_FILE = "the file that does not parse defines three parts, and none of them can run"
_NO_GYROSCOPE = "half of the recording is missing: the key, and the rows under it"
_HALF_A_PICTURE = "half of the picture is missing: the panel, and the three curves in it"
MORE_THAN_ONE: Mapping[str, str] = {
    "no-imu-reader": _WHOLE_FILE,
    "no-imu-reader-sheet": _WHOLE_FILE,
    "no-filters": _WHOLE_FILE,
    "reader-with-a-syntax-error": _UNPARSED_FILE,
    "recorder-with-a-syntax-error": _UNPARSED_FILE,
    "record-no-gyroscope": _NO_GYROSCOPE,
    "accelerometer-panel-only": _HALF_A_PICTURE,
    "saved-before-the-gyroscope": _HALF_A_PICTURE,
}
"""Single faults that cost more than one check, and why a marker would take both."""


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


def recast(only: Container[str] | None = None) -> Iterator[Case]:
    """Styles and single faults that are also asked for in other layouts; to tell which can be takes seconds for all of them."""
    styles_and_faults = (*of("sound"), *of("faulty"), *of("lookalikes"))
    wanted = (case for case in styles_and_faults if only is None or case.name in only)
    yield from (Case("recast", case.name, case.files) for case in wanted if can_be_rearranged(case.files))


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


def look_at_sound(verdict: Verdict, result: Result, sound: Case) -> None:
    if result.status != "graded":
        verdict.trouble("false deduction", f"status is {result.status}")
    if gone := lost(result):
        verdict.trouble("false deduction", words(gone))
    if result.misconceptions:
        verdict.trouble("named wrong", ", ".join(result.misconceptions))


def look_at_fault(verdict: Verdict, result: Result, fault: Case) -> None:
    gone = lost(result)
    inside = [c for c in gone if criterion_of(c) == fault.criterion]
    outside = [c for c in gone if criterion_of(c) not in (fault.criterion, *fault.elsewhere)]
    if fault.criterion and not inside:
        verdict.trouble("missed", f"{fault.fault} costs nothing in {fault.criterion}")
    if outside:
        verdict.trouble("cascade", words(outside))
    if fault.loses and (more := [c for c in inside if c.id not in fault.loses]):
        verdict.trouble("too much", f"only {', '.join(fault.loses)} should be lost, but also {words(more)}")
    names = named(result, without=fault.elsewhere)  # a missing file may be named again where it is missed
    _look_at_names(verdict, result, names, {fault.fault}, {fault.fault, *fault.also}, fault.never)


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


def look_at_charges(verdict: Verdict) -> None:
    """One fault costs one check; what could not be asked then, for want of an answer, belongs to it."""
    charged = [check for check in verdict.lost if check.outcome != "skipped"]
    if len(charged) > 1 and verdict.case.name not in MORE_THAN_ONE:
        verdict.trouble("charged twice", words(charged))


def look_at_nothing(verdict: Verdict, result: Result, nothing: Case) -> None:
    for criterion in result.criteria:
        if criterion.id == nothing.criterion and criterion.points > nothing.earns:
            verdict.trouble("earns too much", f"{criterion.points} for {criterion.title}; lost: {words(lost(result))}")
        if criterion.id != nothing.criterion and criterion.points < criterion.max_points:
            verdict.trouble("cascade", words(c for c in lost(result) if criterion_of(c) == criterion.id))


def look_at_casting(verdict: Verdict, result: Result, cast: Result, layout: str) -> None:
    before, after = ({c.id: c for each in r.criteria for c in each.checks} for r in (result, cast))
    moved = [after[id_] for id_, check in before.items() if after[id_].points != check.points]
    if moved:
        was = ", ".join(f"{check.id} {before[check.id].points}" for check in moved)
        verdict.trouble("another mark", f"{layout}: {words(moved)}; was {was}")


def look_at_pair(verdict: Verdict, result: Result, pair: Case) -> None:
    gone, faults = lost(result), pair.faults or {}
    for mistake, criterion in faults.items():
        if not any(criterion_of(c) == criterion for c in gone):
            verdict.trouble("missed", f"{mistake} costs nothing in {criterion}")
    if outside := [c for c in gone if criterion_of(c) not in faults.values()]:
        verdict.trouble("cascade", words(outside))
    _look_at_names(verdict, result, named(result), set(faults), {*faults, *pair.also}, ())


def named(result: Result, without: Sequence[str] = ()) -> set[str]:
    """The mistakes that the checks name, other than those of some criteria."""
    checks = [check for criterion in result.criteria if criterion.id not in without for check in criterion.checks]
    return {mistake for check in checks for mistake in check.misconceptions}


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
    for criterion in result.criteria:
        if criterion.id in broken.keeps and criterion.points != criterion.max_points:
            verdict.trouble("cascade", words(c for c in lost(result) if criterion_of(c) == criterion.id))
    if broken.costs and not any(criterion_of(c) == broken.costs for c in lost(result)):
        verdict.trouble("missed", f"costs nothing in {broken.costs}")
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
        verdict.trouble(
            "cascade" if wanted else "false deduction", words(c for c in extension.checks if c.id in gone - wanted)
        )
    named = (case.fault,) if case.fault else ()
    if result.misconceptions != named:
        verdict.trouble(
            "named wrong", f"{', '.join(result.misconceptions) or 'none'} in place of {', '.join(named) or 'none'}"
        )


def look_at_edit(verdict: Verdict, result: Result, edit: Case) -> None:
    takes = edit.takes or {}
    for criterion in result.criteria:
        taken = sum(check.max_points - (check.points or 0.0) for check in criterion.checks)
        if taken > takes.get(criterion.id, 0.0) + 1e-6:
            verdict.trouble("too much", words(c for c in lost(result) if criterion_of(c) == criterion.id))
        if criterion.id in edit.must and not taken:
            verdict.trouble("missed", f"costs nothing in {criterion.id}")


_LOOKS: Mapping[str, Callable[[Verdict, Result, Case], None]] = {
    "sound": look_at_sound, "faulty": look_at_fault, "lookalikes": look_at_fault, "pairs": look_at_pair, "broken": look_at_broken,
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
    result = verdict.result
    look_at(verdict, result)
    if case.part == "recast":
        for layout, put in VARIANTS.items():
            cast = marker.mark(handed_in(Case(case.part, case.name, put(case.files))))
            look_at_casting(verdict, result, cast, layout)
    return verdict


def look_at(verdict: Verdict, result: Result) -> None:
    """Compare the result of a case with what the corpus says of it."""
    case = verdict.case
    if case.part in ("faulty", "lookalikes", "pairs", "broken", "nothing"):
        look_at_words(verdict)
    if case.part in ONE_FAULT:
        look_at_charges(verdict)
    if case.part != "recast":  # which is compared with its own variants
        _LOOKS[case.part](verdict, result, case)


def grade_all(chosen: Sequence[Case]) -> Iterator[Verdict]:
    """Verdicts in order, with a line for each trouble as it is found."""
    with ProcessPoolExecutor() as pool:
        for verdict in pool.map(grade, chosen):
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
    parser.add_argument("--only", default="", help="cases whose name holds this")
    options = parser.parse_args(arguments)
    verdicts = list(grade_all([case for case in (*as_written(), *recast()) if options.only in case.name]))
    print(table(verdicts))
    return int(any(verdict.troubles for verdict in verdicts))


if __name__ == "__main__":
    sys.exit(main())
