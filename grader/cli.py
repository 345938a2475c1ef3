"""The command line `imugrade`: it calls one command and turns its end into an exit code. A command's modules load when it runs.

Exit codes: 0 done, 1 done but below --min-score, 2 the request was wrong, 3 the grader itself failed, 130 interrupted, 141 the
reader of the output went away.
"""

from __future__ import annotations

import atexit
import functools
import gc
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated, Any

import typer
import typer.main

from grader import __version__
from grader.base.errors import GraderError, RequestError, fault_text
from grader.commands import (
    adjust,
    calibrate,
    check,
    ci,
    diff,
    doctor,
    explain,
    export,
    grade,
    kit,
    repair,
    repro,
    review,
    traces,
)
from grader.commands.common import say
from grader.labs.imu.lab import LAB

INTERRUPTED = 130  # 128 + SIGINT, as shells count
UNREAD = 141  # 128 + SIGPIPE

app = typer.Typer(
    help=f"Autograder for {LAB.label}, {LAB.title}.\n\n"
    "\b\nStudents:     imugrade check\nInstructors:  imugrade grade SUBMISSIONS -o OUT\n\n"
    "With IMUGRADE_DEBUG=1 in the environment a failure shows its traceback.",
    add_completion=True,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _command in (
    check.check,
    grade.grade,
    review.review,
    adjust.adjust,
    repair.repair,
    diff.diff,
    calibrate.calibrate,
    export.export,
    ci.ci,
    kit.kit,
    explain.explain,
    repro.repro,
    doctor.doctor,
):
    app.command()(_command)
app.add_typer(traces.app, name="traces")
atexit.register(gc.freeze)  # what is left goes with the process: to search it for cycles takes a tenth of a second
gc.set_threshold(50_000)  # a class of thousands is millions of objects without a cycle: a search takes a second


@functools.cache
def command() -> Any:
    """Return typer's `app`, the command line, as a click command, built once per process; a call of `app` builds it anew."""
    return typer.main.get_command(app)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command in `arguments` (None: `sys.argv`); return its exit code, also for exceptions, which it reports on stderr."""
    _accept_any_encoding()
    _keep_to_one_core()
    try:
        code = command()(args=arguments, prog_name="imugrade", standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED  # newer versions of typer return it themselves
    except SystemExit as left:
        # typer and rich leave with a 1 when nobody reads on, which here would mean a low score
        return UNREAD if left.code else 0
    except RequestError as problem:
        return _fail(str(problem), 2)
    except GraderError as problem:
        return _fail(f"the grader itself failed: {problem}", 3)
    except Exception as problem:
        if hasattr(problem, "format_message"):  # a usage error; its class moved from click into typer
            return _misused(problem, problem.format_message())
        return _fail(f"the grader itself failed: {fault_text(problem)}", 3)
    if code == INTERRUPTED:
        return _fail("stopped; run the same command again to go on", INTERRUPTED)
    return code if isinstance(code, int) else 0


def _misused(problem: Exception, message: str) -> int:
    """Print one line about a wrong request with the command whose --help helps, or a group's help; return exit code 2."""
    if "\n" in message:
        print(message, file=sys.stderr)
        return 2
    context = getattr(problem, "ctx", None)
    return _fail(f"{message.rstrip('.')}; see {getattr(context, 'command_path', 'imugrade')} --help", 2)


def _fail(message: str, code: int) -> int:
    """Print a message on stderr, with a traceback if IMUGRADE_DEBUG is set and nobody interrupted; return the exit code `code`."""
    if os.environ.get("IMUGRADE_DEBUG") and code != INTERRUPTED:
        traceback.print_exc()
    for line in message.splitlines() or [""]:
        say(line)
    return code


def _keep_to_one_core() -> None:
    """Limit the threads of NumPy's linear algebra to one; NumPy reads these variables when it is imported.

    More threads gain nothing on matrices as small as ours, and several processes that grade share the cores.
    """
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def _accept_any_encoding() -> None:
    """Print a question mark for characters that the terminal's encoding lacks, such as ✓, in place of an exception."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):
            stream.reconfigure(errors="replace")  # type: ignore[union-attr] # not every stand-in for stdout has it


def _version(wanted: bool) -> None:
    if wanted:
        print(f"imugrade {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", "-V", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
