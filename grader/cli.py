"""The command line: words to calls, results to an exit code. Nothing heavy is imported until a command runs.

Exit codes: 0 done, 1 done but below --min-score, 2 the request was wrong, 3 the grader itself failed, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader import __version__
from grader.errors import GraderError, RequestError

if TYPE_CHECKING:
    from rich.console import Console

    from grader.results import Result

INTERRUPTED = 130  # 128 + SIGINT, as shells count

app = typer.Typer(
    help="Autograder for Lab 04-01, Reading IMU data in MuJoCo.\n\n"
    "\b\nStudents:     imugrade check\nInstructors:  imugrade grade SUBMISSIONS -o OUT\n\n"
    "With IMUGRADE_DEBUG=1 in the environment a failure shows its traceback.",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
traces_app = typer.Typer(
    help="Ground-truth traces: what submissions are compared with.\n\n"
    "\b\nExamples:\n  imugrade traces list\n  imugrade traces plot -o plots\n"
    "  IMUGRADE_SEED=... imugrade traces record -o traces",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.add_typer(traces_app, name="traces")

RubricOption = Annotated[Path | None, typer.Option("--rubric", metavar="FILE", help="Another rubric.yaml.")]
SeedOption = Annotated[
    str | None,
    typer.Option(
        "--seed",
        envvar="IMUGRADE_SEED",
        show_envvar=False,
        metavar="TEXT",
        help="Hidden scenarios from this secret. Better set IMUGRADE_SEED: a command line is visible to other users.",
    ),
]
RungOption = Annotated[str | None, typer.Option("--rung", hidden=True)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: the one place where failures become codes and lines."""
    _accept_any_encoding()
    try:
        code = app(args=arguments, prog_name="imugrade", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED  # newer versions of typer return it themselves
    except RequestError as problem:
        return _fail(str(problem), 2)
    except GraderError as problem:
        return _fail(f"the grader itself failed: {problem}", 3)
    except Exception as problem:
        if hasattr(problem, "format_message"):  # a usage error; its class moved from click into typer
            return _misused(problem, problem.format_message())
        return _fail(f"the grader itself failed: {type(problem).__name__}: {problem}", 3)
    if code == INTERRUPTED:
        return _fail("stopped; run the same command again to go on", INTERRUPTED)
    return code if isinstance(code, int) else 0


def _misused(problem: Exception, message: str) -> int:
    """One line; but a group that was called without a command answers with its help, as it is."""
    if "\n" in message:
        print(message, file=sys.stderr)
        return 2
    context = getattr(problem, "ctx", None)
    return _fail(f"{message.rstrip('.')}; see {getattr(context, 'command_path', 'imugrade')} --help", 2)


def _fail(message: str, code: int) -> int:
    if os.environ.get("IMUGRADE_DEBUG") and code != INTERRUPTED:
        traceback.print_exc()
    for line in message.splitlines() or [""]:
        _say(line)
    return code


def _say(line: str) -> None:
    """One line on stderr, with the command's name in front."""
    from grader.text import printable  # noqa: PLC0415

    print(f"imugrade: {printable(line, 2000)}", file=sys.stderr, flush=True)


def _accept_any_encoding() -> None:
    """A terminal that has no ✓ gets a question mark, not a traceback."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr] # not every stand-in for stdout has it


def _console() -> Console:
    from rich.console import Console  # noqa: PLC0415

    return Console(highlight=False, markup=False, emoji=False)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"imugrade {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass


@app.command()
def check(
    path: Annotated[
        Path,
        typer.Argument(metavar="PATH", help="A folder or archive; the working folder by default.", show_default=False),
    ] = Path(),
    *,
    html: Annotated[Path | None, typer.Option("--html", metavar="FILE", help="Write the report as a page.")] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the result as JSON.")] = None,
    only: Annotated[str | None, typer.Option("--only", metavar="CRITERION", help="Check one criterion.")] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Check again whenever a file is saved.")] = False,
    rubric: RubricOption = None,
    rung: RungOption = None,
) -> int:
    """Check one submission against the public scenarios.

    \b
    Examples:
      imugrade check
      imugrade check my_lab --only filtering --watch
      imugrade check my_lab.zip --html report.html
    """
    from grader import opening  # noqa: PLC0415
    from grader import rubric as rubrics  # noqa: PLC0415
    from grader.intake import read_submission  # noqa: PLC0415

    chosen = rubrics.load(rubric)
    if only is not None:
        from grader.selfcheck import know_part  # noqa: PLC0415

        know_part(chosen, only)
    submission = read_submission(path)
    ready = submission.status == "ready"
    if ready:
        print(opening.found(submission), flush=True)  # at once: the rest takes seconds on a cold machine
    from grader import selfcheck, traces  # noqa: PLC0415

    bundle = traces.obtain(None, None)
    waiting = opening.waiting(submission, chosen, bundle, only) + "\n"
    if watch:
        for result in selfcheck.check_on_save(path, chosen, bundle, only=only):
            _console().clear()
            print(waiting)
            _show(result, html, json, only)
            print("\nWatching for changes; Ctrl-C ends.", flush=True)
        return 0
    if ready:
        print(waiting, flush=True)
    result = selfcheck.check(path, chosen, bundle, only=only, rung=rung)
    _show(result, html, json, only)
    return 3 if result.status == "incomplete" else 0


def _show(result: Result, html: Path | None, json: Path | None, only: str | None) -> None:
    from grader.files import write_whole  # noqa: PLC0415
    from grader.report import terminal  # noqa: PLC0415

    terminal.show(result, _console(), only=only)
    if html is not None:
        from grader.report.pages import report_page  # noqa: PLC0415

        write_whole(html, report_page(result))
    if json is not None:
        from grader.results import to_json  # noqa: PLC0415

        write_whole(json, to_json(result))


@app.command()
def grade(
    paths: Annotated[
        list[Path], typer.Argument(metavar="PATH", help="A folder of submissions, submissions, or an LMS download.")
    ],
    *,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="OUT", help="Where results go; an earlier run is resumed.")
    ],
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, metavar="N", help="Markers at work; one a core by default.")
    ] = None,
    rubric: RubricOption = None,
    seed: SeedOption = None,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="ID", help="Grade this submission alone; repeatable.")
    ] = None,
    min_score: Annotated[
        float | None, typer.Option("--min-score", metavar="N", help="Exit with 1 if a submission has fewer points.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Grade again what is on record.")] = False,
    trust: Annotated[
        bool, typer.Option("--trust-submissions", help="Grade where nothing isolates students' code.")
    ] = False,
    rung: RungOption = None,
) -> int:
    """Grade a class. Killed or stopped, the same command goes on where it ended.

    \b
    Examples:
      imugrade grade submissions -o out
      IMUGRADE_SEED=... imugrade grade moodle.zip -o out --jobs 8
      imugrade grade submissions -o out --only alice --force
    """
    from grader import classroom, traces  # noqa: PLC0415
    from grader import rubric as rubrics  # noqa: PLC0415
    from grader.report import progress, terminal  # noqa: PLC0415

    bundle = traces.obtain(seed, None)
    order = classroom.Order(
        tuple(paths), out, rubrics.load(rubric), bundle, jobs, tuple(only or ()), force, trust, rung
    )
    if seed is None:
        _say("no seed: graded on the public scenarios only, which students have as well (set IMUGRADE_SEED)")
    console = _console()
    with progress.Bar(console) if console.is_terminal else progress.Lines() as audience:
        outcome = classroom.grade_class(order, audience)
    terminal.show_class(outcome, str(out / "index.html"), console)
    below = min_score is not None and bool(outcome.below(min_score))
    return 3 if outcome.incomplete else int(below)


@app.command()
def ci(
    path: Annotated[
        Path | None,
        typer.Argument(
            metavar="PATH", help="A folder or archive; by default where the platform puts it.", show_default=False
        ),
    ] = None,
    *,
    format_: Annotated[
        str,
        typer.Option(
            "--format", "-f", metavar="F", help="github, gradescope, classroom50, junit, prairielearn, json or auto."
        ),
    ] = "auto",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="Where the answer goes; - is standard output."),
    ] = None,
    min_score: Annotated[
        float | None, typer.Option("--min-score", metavar="N", help="Exit with 1 if there are fewer points.")
    ] = None,
    rubric: RubricOption = None,
    traces_: Annotated[
        Path | None,
        typer.Option("--traces", metavar="FILE", help="A recorded bundle (.npz), where students cannot read it."),
    ] = None,
    visibility: Annotated[
        str,
        typer.Option(metavar="WHEN", help="Gradescope: visible, after_due_date, after_published or hidden."),
    ] = "visible",
    trust: Annotated[
        bool, typer.Option("--trust-submissions", help="Hidden scenarios where nothing isolates students' code.")
    ] = False,
    rung: RungOption = None,
) -> int:
    """Grade one submission in a CI job, in the words of its platform.

    \b
    Examples:
      imugrade ci
      imugrade ci --format github --min-score 60
      imugrade ci lab --format junit -o junit.xml
    """
    from grader import rubric as rubrics  # noqa: PLC0415
    from grader import traces  # noqa: PLC0415
    from grader.formats import job, platforms  # noqa: PLC0415

    bundle = traces.obtain(None, None) if traces_ is None else traces.load(traces_)
    order = job.Job(
        platforms.named(format_), rubrics.load(rubric), bundle, path, out,
        job.visible(visibility), trust, rung,
    )  # fmt: skip
    job.refuse_limit(order, min_score)
    result = job.run(order)
    if result.status == "incomplete":
        return 3
    return int(min_score is not None and result.score < min_score)


@app.command()
def kit(
    out: Annotated[
        Path | None, typer.Argument(metavar="OUT_DIR", help="A new folder for students.", show_default=False)
    ] = None,
    *,
    gradescope: Annotated[
        Path | None, typer.Option("--gradescope", metavar="FILE", help="Write an autograder.zip.")
    ] = None,
    classroom50: Annotated[
        Path | None, typer.Option("--classroom50", metavar="DIR", help="Write an autograder for Classroom 50.")
    ] = None,
    github: Annotated[
        Path | None, typer.Option("--github", metavar="DIR", help="Write a workflow into a repository.")
    ] = None,
    rubric: RubricOption = None,
    seed: SeedOption = None,
) -> int:
    """Write what students and platforms get: no reference solution, no seed.

    Hidden scenarios go to Gradescope alone, and only with a seed: everywhere else students could read them.

    \b
    Examples:
      imugrade kit lab-04-01
      IMUGRADE_SEED=... imugrade kit --gradescope autograder.zip
      imugrade kit --github starter-repository
    """
    from grader import traces  # noqa: PLC0415
    from grader.kit import give  # noqa: PLC0415

    if out is None and gradescope is None and classroom50 is None and github is None:
        raise RequestError("kit: nothing to write; give OUT_DIR, --gradescope, --classroom50 or --github")
    hidden = traces.obtain(seed, None) if gradescope and seed is not None else None
    for each in give.kits(give.Wanted(out, gradescope, classroom50, github, rubric, hidden)):
        print(f"{each.place}  for {each.title}; {each.scenarios}")
    return 0


@app.command()
def explain(
    id_: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="A mistake, a check or a criterion; without one, all that there are."),
    ] = None,
) -> int:
    """Explain a mistake that a report names, or what a check asks for.

    \b
    Examples:
      imugrade explain
      imugrade explain sensor-id-as-address
      imugrade explain filtering.follows_recursion
    """
    from grader.handbook import entries  # noqa: PLC0415

    if id_ is None:
        print(entries.listing(), end="")
    else:
        _show_markdown(entries.explain(id_))
    return 0


def _show_markdown(text: str) -> None:
    """Set on a terminal, as it is in a pipe."""
    console = _console()
    if console.is_terminal:
        from rich.markdown import Markdown  # noqa: PLC0415

        console.print(Markdown(text), width=min(console.width, 100))
    else:
        print(text, end="")


@traces_app.command("list")
def traces_list(seed: SeedOption = None) -> int:
    """What the bundle in use holds."""
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    print(truth.listing(traces.obtain(seed, None)))
    return 0


@traces_app.command("plot")
def traces_plot(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the pictures go.")],
    seed: SeedOption = None,
) -> int:
    """Draw every scenario that is a motion over time, one PNG each."""
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    for path in truth.plot(traces.obtain(seed, None), out):
        print(path)
    return 0


@traces_app.command("record")
def traces_record(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Where the bundle goes.")],
    seed: SeedOption = None,
) -> int:
    """Write a bundle for this machine's MuJoCo: the public one, or the hidden one of a seed.

    \b
    Example:
      IMUGRADE_SEED=... imugrade traces record -o traces
    """
    from grader import traces  # noqa: PLC0415
    from grader.report import truth  # noqa: PLC0415

    print(truth.save(traces.obtain(seed, None), out))
    return 0


@app.command()
def doctor() -> int:
    """Tell what this machine can isolate, and which versions are in use."""
    from grader import doctor as doctors  # noqa: PLC0415
    from grader.report import terminal  # noqa: PLC0415

    terminal.show_findings(doctors.examine(), _console())
    return 0
