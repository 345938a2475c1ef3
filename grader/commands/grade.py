"""`imugrade grade`: grade a class of submissions."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.base.errors import RequestError
from grader.base.text import enumerated
from grader.commands.common import (
    LevelOption,
    RubricOption,
    SeedOption,
    TrustOption,
    WeakSecretOption,
    as_points,
    console,
    one_of,
    say,
    shown_path,
)
from grader.platforms import registry

if TYPE_CHECKING:
    from grader.course.record.class_settings import Change
    from grader.course.run.classroom import RunOutcome
    from grader.course.run.grade_request import GradeRequest
    from grader.course.run.submissions import Class


def grade(
    paths: Annotated[
        list[Path], typer.Argument(metavar="PATH", help="Folders of submissions, submissions, or LMS downloads.")
    ],
    *,
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", metavar="OUT", resolve_path=True, help="The output folder. An earlier run is resumed."
        ),
    ],
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, metavar="N", help="Parallel workers. Default: one per core.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="Grade on this Dask cluster: tcp://HOST:PORT.")
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help=f"{enumerated((registry.FOLDERS, *registry.names('read')), 'or')}; default: recognize it.",
        ),
    ] = None,
    roster: Annotated[
        Path | None, typer.Option("--roster", metavar="FILE", help="A CSV file with names, sections and due dates.")
    ] = None,
    attempts: Annotated[
        str | None,
        typer.Option("--attempts", metavar="WHICH", help="Which attempt to grade: latest (default) or best."),
    ] = None,
    rubric: RubricOption = None,
    seed: SeedOption = None,
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="ID", help="Grade only this student: id, name or e-mail; repeatable."),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the submissions, and grade nothing.")] = False,
    min_score: Annotated[
        float | None,
        typer.Option("--min-score", parser=as_points, metavar="N", help="Exit with 1 if a score is below N."),
    ] = None,
    change: Annotated[
        bool, typer.Option("--change", help="Allow changes of recorded scores, for example by a new rubric.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would be graded and which scores would change.")
    ] = False,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Grade although packages are missing that many submissions import.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Grade recorded submissions again.")] = False,
    trust: TrustOption = False,
    weak_secret: WeakSecretOption = False,
    isolation_level: LevelOption = None,
) -> int:
    """Grade a class. After an interruption, the same command continues.

    The output folder keeps the rubric, the roster and the attempt rule. You need not give them again. Give the secret of hidden
    scenarios each time, in IMUGRADE_SEED; `openssl rand -hex 16` makes one. If you give another rubric, rule or secret, the
    command first says which scores change. It changes them with --change, or after a yes on a terminal.
    `imugrade diff` compares the two versions. The first run asks before it grades on a machine without packages that many
    submissions import.

    \b
    Examples:
      imugrade grade submissions -o out
      imugrade grade moodle.zip -o out --jobs 8
      imugrade grade canvas.zip -o out --roster gradebook.csv
      imugrade grade submissions -o out --only alice --force
    """
    from rich.text import Text  # noqa: PLC0415

    from grader.course.record import class_settings  # noqa: PLC0415
    from grader.course.run import classroom, secret_strength, submissions  # noqa: PLC0415
    from grader.course.run.grade_request import GradeRequest  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.people import late_policy  # noqa: PLC0415
    from grader.platforms.classes import ATTEMPTS  # noqa: PLC0415
    from grader.report import progress  # noqa: PLC0415

    if cluster is not None and jobs is not None:
        raise RequestError("--jobs does not work with --cluster; start more workers on the cluster instead")
    known = classroom.on_record(out)
    class_settings.refuse_without_secret(None if list_ else known, seed)
    if not weak_secret and (known is None or not known.hidden):
        secret_strength.refuse_guessable(seed)
    lab = chosen_lab(known.lab if known else "")
    chosen = class_settings.rubric_of(lab, known, rubric)
    bundle = lab.truth(seed, chosen.settings)
    which = one_of("--attempts", attempts, ATTEMPTS) or (known.attempts if known else ATTEMPTS[0])
    people = class_settings.roster_of(known, roster, late_policy.zone_of(chosen.late))
    request = GradeRequest(
        tuple(paths), out, chosen, bundle, jobs, tuple(only or ()), force, trust, isolation_level, cluster,
        one_of("--from", from_, (registry.FOLDERS, *registry.names("read"))), people, which,
        at_least=known.isolation if known and not change else "",
    )  # fmt: skip
    found = submissions.find(request)
    for line in found.notices:
        say(line)
    if list_:
        for line in (*submissions.listing(found), *(f"Not placed: {left}" for left in found.leftovers)):
            print(line)
        return 0
    changed = classroom.change(request, found)
    if dry_run:
        for line in (*classroom.forecast(request, found), *([changed.in_words()] if changed else [])):
            print(line)
        return 0
    if known is None and not anyway:
        _ask_about_packages(request, found)
    if changed is not None:
        request = replace(request, change=_confirmed(changed, change))
    screen = console()
    with progress.ProgressBar(screen) if screen.is_terminal else progress.ProgressLines() as listener:
        outcome = classroom.grade_class(request, found, listener)
    screen.print(Text("\n".join(_summary(outcome, shown_path(out / "index.html")))), soft_wrap=True)
    for line in (lab.blind_spot(bundle), *_notices(outcome, secret=seed is not None)):
        if line:
            say(line)
    below = min_score is not None and bool(outcome.below(min_score))
    return 3 if outcome.incomplete else int(below)


def _summary(outcome: RunOutcome, index: str) -> Iterator[str]:
    """Yield the last lines of a run: counts, mean, submissions that were not graded, where the pages are."""
    import statistics  # noqa: PLC0415

    from grader.base.text import printable  # noqa: PLC0415

    facts = [f"{len(outcome.results) - outcome.resumed} graded"]
    facts += [f"{outcome.resumed} on record"] if outcome.resumed else []
    for status in ("empty", "unreadable"):
        count = sum(result.status == status for result in outcome.results.values())
        facts += [f"of these {count} {status}"] if count else []
    facts += [f"mean of graded {statistics.fmean(outcome.grades):.1f}"] if outcome.grades else []
    yield " · ".join(facts)
    yield from (f"Not placed: {printable(leftover, 300)}" for leftover in outcome.leftovers)
    if outcome.incomplete:
        names = ", ".join(printable(id_, 120) for id_ in outcome.incomplete)
        yield f"Not judged, because the grader failed: {names}. Run the command again: only these are graded again."
        yield "If that does not help: `imugrade doctor --report OUT` prints what to report, without names and files."
    yield f"Open {printable(index, 1000)}"


def _notices(outcome: RunOutcome, *, secret: bool) -> Iterator[str]:
    """Yield what an instructor should know of a run: missing secret, regraded results, contradictions, warnings."""
    if not secret:
        yield "no seed: graded on the public scenarios only, which students have too (set IMUGRADE_SEED)"
    if outcome.remarked:
        yield f"{outcome.remarked} recorded results were regraded with the new rubric"
    yield from (*outcome.contradictions, *outcome.remarks)
    if outcome.known:
        many = f"{outcome.known} warning{'s' * (outcome.known != 1)}"
        yield f"{many}, unchanged since the last run (`imugrade review` lists them)"


def _ask_about_packages(request: GradeRequest, found: Class) -> None:
    """Ask before a class is graded on a machine without packages that many submissions import; refuse without a terminal."""
    from grader.course.run import missing_packages  # noqa: PLC0415

    lines = missing_packages.lines(missing_packages.many(missing_packages.of_class(found.entries, request.rubric)))
    for line in lines:
        say(line)
    if lines and not (sys.stdin.isatty() and typer.confirm("Grade without?")):
        raise RequestError("packages are missing (see above); install them, or add --anyway. Nothing was graded")


def _confirmed(changed: Change, change: bool) -> bool:
    """Return whether to change settings that are on record: as `change` says, or if scores move, after a yes on a terminal.

    The effect on the scores is printed.
    """
    if changed.moves_scores and not change:
        return sys.stdin.isatty() and typer.confirm(f"{changed.in_words()}. Change them?")
    say(changed.in_words())
    return change
