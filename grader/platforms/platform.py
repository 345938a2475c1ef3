"""The record of a platform, one at the end of each platform's module: everything else asks this record."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from grader.engine.lab import Lab
    from grader.engine.results import Result
    from grader.intake import Submission
    from grader.intake.downloads import Download
    from grader.people.final_grade import FinalGrade, Person
    from grader.platforms.filled import Filled
    from grader.platforms.found import Shape

Visibility = Literal["visible", "after_due_date", "after_published", "hidden"]
"""When students see the tests, in the words of Gradescope."""


class Fill(Protocol):
    """Fill in a file that the platform exported; who is not graded keeps what stands there."""

    def __call__(
        self,
        template: bytes,
        source: str,
        column: str | None,
        final_grades: Mapping[str, FinalGrade],
        *,
        scaled: bool = False,
    ) -> Filled:
        """The file with the final points.

        Parameters
        ----------
        template
            Its bytes.
        source
            What messages call it.
        column
            That of the grades, if it is named.
        final_grades
            By id of the submission.
        scaled
            Whether points are scaled where it is out of others than the rubric.

        Raises
        ------
        RequestError
            If it is no such file, or out of other points.
        """
        ...


@dataclass(frozen=True)
class Handed:
    """One submission on a platform, beside its result: where it lies, what the platform says, how the result is to be told.

    `hidden` is whether the scenarios are an instructor's secret: students are then told what is wrong, and none of their data.
    """

    lab: Lab
    submission: Submission
    path: Path
    environ: Mapping[str, str]
    hidden: bool = False
    visibility: Visibility = "visible"


@dataclass(frozen=True)
class Aside:
    """A second text, appended to the file that a variable of the environment names; nothing is written where it names none."""

    variable: str
    text: Callable[[Result, Handed], str]


@dataclass(frozen=True)
class Help:
    """Documentation of a platform in Markdown; everything that it does has a text here.

    Attributes
    ----------
    respond
        Its section on the page about CI, below the title.
    read
        Its row: what is downloaded, by what it is recognised, what a student is there.
    grades
        How the grades get there.
    """

    respond: str = ""
    read: tuple[str, str, str] = ("", "", "")
    grades: str = ""


@dataclass(frozen=True)
class Platform:
    """One value of `--format` or `--from`. What a platform does not do is None.

    Attributes
    ----------
    name, title
        The value, and what it is called.
    help
        Its documentation.
    respond
        A job's answer: what the platform reads of a result. Raises GraderError if it has no way to say that a part could not be
        judged.
    recognise
        Whether a process runs on it, by the variables of the environment and the place where absolute paths start.
    refuse
        Raises RequestError where a job could not be answered (the environment, the fewest points that pass), before it is marked.
    aside
        What a job writes beside the answer.
    submission
        Where it puts what was handed in, without the leading slash; "" is the working folder.
    answer
        Where it looks for the answer, without the leading slash for an absolute place; "" is standard output.
    keeps_secrets
        Whether students see only what the answer holds. Where a job runs in their own repository it is False, and hidden
        scenarios are refused.
    read
        The hand-ins of its download; None if it is none of its own.
    fill
        The file that it exported, with the grades of a class filled in.
    write
        The grades of a class as a file of its own, with those of the roster who handed in nothing.
    gradebook
        What the file of the grades is called in OUT.
    """

    name: str
    title: str
    help: Help
    respond: Callable[[Result, Handed], str] | None = None
    recognise: Callable[[Mapping[str, str], Path], bool] | None = None
    refuse: Callable[[Mapping[str, str], float | None], None] | None = None
    aside: Aside | None = None
    submission: str = ""
    answer: str = ""
    keeps_secrets: bool = False
    read: Callable[[Download], Shape | None] | None = None
    fill: Fill | None = None
    write: Callable[[Mapping[str, FinalGrade], Sequence[Person]], bytes] | None = None
    gradebook: str = ""
