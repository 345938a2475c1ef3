"""`imugrade check`: a student's check of their own work on public scenarios: simulated motions that students have, none hidden."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grader.commands.common import SECRET_VARIABLE, LevelOption, RubricOption, console

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

    from grader.commands.prints import Prints
    from grader.engine.lab import Lab
    from grader.engine.results import Result


def check(
    path: Annotated[
        Path,
        typer.Argument(metavar="PATH", help="A folder or archive. Default: the working folder.", show_default=False),
    ] = Path(),
    *,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write the report as an HTML page.")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the result as JSON.")] = None,
    only: Annotated[str | None, typer.Option("--only", metavar="CRITERION", help="Check only this criterion.")] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Check again whenever a file is saved.")] = False,
    prints: Annotated[bool, typer.Option("--prints", "-s", help="Show what your own code prints.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Show all lines of every deduction, and each passed check.")
    ] = False,
    rubric: RubricOption = None,
    isolation_level: LevelOption = None,
) -> int:
    """Check one submission against the public scenarios (simulated motions, none hidden), and show its points and what to fix.

    The guide, guide.html in your starter files, explains what the report says.

    \b
    Examples:
      imugrade check
      imugrade check my_lab --only filtering --watch
      imugrade check my_lab.zip --html report.html
    """
    arguments = _Arguments(path, only, html, json, prints, verbose, rubric)
    if watch:
        return _watch(arguments, rubric, isolation_level)
    from grader.commands import opening  # noqa: PLC0415

    if path.exists():
        print(opening.checking_line(path), flush=True)  # at once: the rest takes seconds on a cold machine
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.engine.lab_sandbox import open_sandbox_for  # noqa: PLC0415
    from grader.engine.reading import read_apart  # noqa: PLC0415

    lab = chosen_lab()
    submission = read_apart(path, lab.files)
    with open_sandbox_for(lab, submission.files, isolation_level) as sandbox:
        from grader.base import class_versions  # noqa: PLC0415
        from grader.engine import rubric as rubrics  # noqa: PLC0415 - this and the next while the sandbox warms up

        chosen = rubrics.load(lab, rubric)
        rubrics.know_part(chosen, only)
        ready = submission.status == "ready"
        if ready:
            print(opening.found(lab, submission), flush=True)
        if differing := class_versions.line(lab.folder):
            print(differing, flush=True)
        _keep_versions(lab, path)
        from grader.commands.prints import Prints  # noqa: PLC0415
        from grader.engine.grader import Marker, Stopped  # noqa: PLC0415
        from grader.report import terminal  # noqa: F401, PLC0415

        bundle = lab.truth(None, chosen.settings)
        if ready:
            print(
                opening.waiting(
                    submission, chosen, bundle, only, secret=bool(os.environ.get(SECRET_VARIABLE, "").strip())
                )
                + "\n",
                flush=True,
            )
        printed = Prints()
        try:
            with Marker(chosen, bundle, sandbox=sandbox) as marker:
                result = marker.mark(submission, only=only, waiting=partial(print, flush=True), listen=printed.add)
        except Stopped as stopped:
            print()  # below the terminal's own ^C
            _show(stopped.result, lab, arguments, printed)
            raise
    _show(result, lab, arguments, printed)
    _write(result, lab, arguments)
    return 3 if result.status == "incomplete" else 0


def _keep_versions(lab: Lab, path: Path) -> None:
    """Write the package versions of this machine into a student's folder, so that a report from another machine can name both.

    This happens only where the class's kit is installed, so that an instructor's check changes no hand-in. A failure is ignored.
    """
    from grader.base import class_versions  # noqa: PLC0415
    from grader.base.errors import RequestError  # noqa: PLC0415
    from grader.base.files import write_whole  # noqa: PLC0415
    from grader.commands.repeating import folder_in  # noqa: PLC0415
    from grader.intake.names import HOME_VERSIONS  # noqa: PLC0415

    if path.is_dir() and (lab.folder / class_versions.FILE).is_file():
        with suppress(RequestError, OSError):
            write_whole(folder_in(path) / HOME_VERSIONS[1], class_versions.here(lab.packages))


_CHECKING = "checking …"


@dataclass(frozen=True)
class _Arguments:
    """The arguments of `imugrade check`, as typed."""

    path: Path
    only: str | None
    html: Path | None
    json: Path | None
    prints: bool
    verbose: bool
    rubric: Path | None

    @property
    def command(self) -> str:
        """Return the command that checks the submission again, which the screen names for a rerun."""
        return _typed("imugrade", "check", *self._path_argument)

    @property
    def repeat(self) -> str:
        """Return the `imugrade repro` command for a check, with ``{}`` for the check's id; "" if there is no Python file."""
        if not any(next(self.path.glob(each), None) for each in ("*.py", "*/*.py")):
            return ""
        rubric = () if self.rubric is None else ("--rubric", str(self.rubric))
        typed = "".join(f" {_typed(each)}" for each in (*self._path_argument, *rubric))
        return f"imugrade repro {{}}{typed.replace('{', '{{').replace('}', '}}')}"

    @property
    def _path_argument(self) -> tuple[str, ...]:
        """The path as it is typed in a command; nothing for the working folder, which is the default."""
        return () if self.path == Path() else (str(self.path),)


def _typed(*arguments: str) -> str:
    """Return a command as it is typed in the system's shell, with quotes where it needs them, for the user to copy."""
    return subprocess.list2cmdline(arguments) if sys.platform == "win32" else shlex.join(arguments)


def _watch(arguments: _Arguments, rubric: Path | None, isolation_level: str | None) -> int:
    """Check the submission on every save and show the result until Ctrl-C; return the exit code."""
    from grader.commands.watching import WatchView  # noqa: PLC0415
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.intake.submission import original_name  # noqa: PLC0415

    lab = chosen_lab()
    chosen = rubrics.load(lab, rubric)
    rubrics.know_part(chosen, arguments.only)
    screen = console()
    view = WatchView(screen, original_name(arguments.path), arguments.command)
    view.tell(_CHECKING)  # at once: the rest takes seconds on a cold machine
    from grader.commands import checking  # noqa: PLC0415
    from grader.commands.prints import Prints  # noqa: PLC0415

    _keep_versions(lab, arguments.path)
    bundle = lab.truth(None, chosen.settings)
    written = [each for each in (arguments.html, arguments.json) if each is not None]
    before: dict[str, float] = {}
    printed = Prints()

    def begins() -> None:
        view.tell(_CHECKING)
        printed.clear()

    try:
        for result in checking.check_on_save(
            arguments.path, chosen, bundle, only=arguments.only, isolation_level=isolation_level, written=written,
            begins=begins, waits=view.refit,
            waiting=view.tell, listen=printed.add,
        ):  # fmt: skip
            prints = printed.lines(lab) if arguments.prints else []
            at = f"checked at {time.strftime('%H:%M:%S')}; again on every save, Ctrl-C ends"
            view.show(partial(_lines, result, lab, arguments, screen, before, prints), at)
            _write(result, lab, arguments)
            checks = [check for part in result.parts for check in part.checks]
            before = before | {check.id: check.points for check in checks if check.points is not None}
    except KeyboardInterrupt:  # it is how one ends it
        print()
    return 0


def _show(result: Result, lab: Lab, arguments: _Arguments, printed: Prints) -> None:
    from grader.report import terminal  # noqa: PLC0415

    screen = console()
    for line in _lines(result, lab, arguments, screen, {}, printed.lines(lab) if arguments.prints else []):
        terminal.show_line(line, screen)


def _lines(
    result: Result,
    lab: Lab,
    arguments: _Arguments,
    screen: Console,
    before: Mapping[str, float],
    prints: Sequence[Text],
) -> list[Text]:
    """Return the lines of the report for the terminal, followed by `prints`, what the student's code printed."""
    from grader.report import terminal  # noqa: PLC0415

    lines = terminal.screen(
        result, screen, lab, only=arguments.only, before=before, command=arguments.command, repeat=arguments.repeat,
        verbose=arguments.verbose,
    )  # fmt: skip
    return [*lines, *prints]


def _write(result: Result, lab: Lab, arguments: _Arguments) -> None:
    """Write the files of `--html` and `--json`, if given."""
    from grader.base.files import write_whole  # noqa: PLC0415

    if arguments.html is not None:
        from grader.engine.chart_data import unpacked  # noqa: PLC0415
        from grader.engine.faults import catalogue  # noqa: PLC0415
        from grader.people.final_grade import FinalGrade  # noqa: PLC0415
        from grader.report.pages import report_page  # noqa: PLC0415

        whole = FinalGrade("", result, reviewed=True)
        write_whole(arguments.html, report_page(whole, unpacked(result.evidence.charts), catalogue(lab)))
    if arguments.json is not None:
        from grader.engine.results import to_json  # noqa: PLC0415

        write_whole(arguments.json, to_json(result))
