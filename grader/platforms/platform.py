"""The record that describes a platform (learning platform or CI server). Each platform's module defines one at its end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from grader.engine.lab import Lab
    from grader.engine.results import Result
    from grader.intake import Submission
    from grader.intake.downloads import Download
    from grader.people.final_grade import FinalGrade, Person
    from grader.platforms.filled import Filled
    from grader.platforms.found import Shape


@dataclass(frozen=True)
class Template:
    """A file that a platform exported, to be filled in with grades; people without a grade keep what their cell holds.

    Attributes
    ----------
    data, source
        The bytes of the file, and its name in messages.
    column
        Title of the column of grades; for Canvas also the assignment's number. None if the platform's code finds the column.
    scaled
        Whether points are scaled if the maximum in the file differs from the rubric's. Otherwise such a file is refused.
    missing
        Grade to write into blank cells of people without a submission; "" writes none. A cell also stays blank if
        somebody who handed in resembles the person in the row.
    """

    data: bytes
    source: str
    column: str | None = None
    scaled: bool = False
    missing: str = ""


@dataclass(frozen=True)
class ResultContext:
    """Facts beside the result that a platform's CI output is made from: lab, submission, its path, environment variables.

    `hidden` says that the scenarios are secret. The result then holds no data of the scenarios.
    """

    lab: Lab
    submission: Submission
    path: Path
    environ: Mapping[str, str]
    hidden: bool = False


@dataclass(frozen=True)
class SecondOutput:
    """Result of `text`, such as GitHub's summary, which a CI job appends to the file in environment variable `variable`, if set."""

    variable: str
    text: Callable[[Result, ResultContext], str]


@dataclass(frozen=True)
class Help:
    """Documentation of a platform in Markdown, one text for each thing that the platform supports; "" if it does not.

    Attributes
    ----------
    respond
        Section on the page about CI, below the title.
    read
        Row of a table: what the download is, by which sign it is recognised, and how students are identified.
    grades
        Instructions for importing the grades.
    """

    respond: str = ""
    read: tuple[str, str, str] = ("", "", "")
    grades: str = ""


@dataclass(frozen=True)
class Platform:
    """A learning platform or CI server, one value of `--format` or `--from`. A function that it does not support is None.

    Attributes
    ----------
    name, title
        The value of the option, and the name to show.
    help
        Documentation of the platform.
    respond
        Function that returns a CI job's output for a result. It raises GraderError if the format cannot express that a part was
        not judged.
    recognise
        Function that returns whether a process runs on the platform, from the environment variables and the root folder.
    refuse
        Function that is called before grading with the environment and `--min-score`; raises RequestError if the job cannot run.
    aside
        `SecondOutput` of a CI job, such as GitHub's step summary: a text, and the file that it is appended to; None without one.
    submission
        Folder of a CI job's submission, an absolute path without its leading slash; "" is the working folder.
    answer
        Output file of a CI job: a name in the working folder, or an absolute path without its leading slash; "" is stdout.
    keeps_secrets
        Whether students see only the output. It is False if a job runs in their own repository; hidden scenarios are then refused.
    read
        Function that returns the submissions of a download; None for downloads of other platforms.
    fill
        Function that fills the grades of a class into a file that the platform exported. It raises RequestError if it is no such
        file, or if its maximum differs from the rubric's and points are not scaled.
    write
        Function that returns the grades of a class as a file: from the final grades by id, the people of the roster without a
        submission, and the grade of those people, "" for a blank cell.
    gradebook
        Name of the grades file that `imugrade export` writes into the output folder.
    """

    name: str
    title: str
    help: Help
    respond: Callable[[Result, ResultContext], str] | None = None
    recognise: Callable[[Mapping[str, str], Path], bool] | None = None
    refuse: Callable[[Mapping[str, str], float | None], None] | None = None
    aside: SecondOutput | None = None
    submission: str = ""
    answer: str = ""
    keeps_secrets: bool = False
    read: Callable[[Download], Shape | None] | None = None
    fill: Callable[[Template, Mapping[str, FinalGrade]], Filled] | None = None
    write: Callable[[Mapping[str, FinalGrade], Sequence[Person], str], bytes] | None = None
    gradebook: str = ""
