"""Progress of a class run: a bar on a terminal, one line per submission in a pipe."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from grader.base.text import printable
from grader.engine.results import Result
from grader.report import words


def result_line(id_: str, result: Result) -> str:
    """Return a submission's id and score as ``alice 87.5``; without a score ``alice not judged``, or "empty" or "unreadable"."""
    blank = {"incomplete": "not judged", "empty": "empty", "unreadable": "unreadable"}.get(result.status)
    return f"{printable(id_, words.NAME_LIMIT)} {blank or words.number(result.score)}"


class ProgressLines:
    """Printer of ``12/300 alice 87.5`` for each submission graded in this run; results of an earlier run only raise the count."""

    def __init__(self) -> None:
        self._total = 0
        self._count = 0

    def __enter__(self) -> ProgressLines:
        return self

    def __exit__(self, *problem: object) -> None:
        return

    def started(self, total: int) -> None:
        self._total = total

    def done(self, id_: str, result: Result, *, resumed: bool) -> None:
        self._count += 1
        if not resumed:
            print(f"{self._count}/{self._total} {result_line(id_, result)}", flush=True)


class ProgressBar:
    """Bar on a terminal that shows the progress of a run: count, rate and time left."""

    def __init__(self, console: Console) -> None:
        self._progress = Progress(
            BarColumn(bar_width=None),
            MofNCompleteColumn(),
            _Rate(),
            TimeRemainingColumn(compact=True),
            TextColumn("{task.description}", markup=False),
            console=console,
            expand=True,
        )
        self._task = self._progress.add_task("", total=None)

    def __enter__(self) -> ProgressBar:
        self._progress.start()
        return self

    def __exit__(self, *problem: object) -> None:
        self._progress.stop()

    def started(self, total: int) -> None:
        self._progress.update(self._task, total=total)

    def done(self, id_: str, result: Result, *, resumed: bool) -> None:
        self._progress.update(self._task, description=result_line(id_, result)[:40])
        self._progress.advance(self._task)


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{60 * speed:.0f}/min", "bright_black")
