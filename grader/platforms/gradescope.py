"""Gradescope: `results.json` by its specification, reading of its exports, and grades in its own columns.

`results.json` cannot express an unjudged check, because a missing score counts as zero. So an incomplete result is refused: the
platform then reports that the autograder failed, and the instructor runs it again.
"""

from __future__ import annotations

import codecs
import html
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from grader.base import tables
from grader.base.stamps import stamp
from grader.base.text import printable
from grader.engine.results import CheckResult, CriterionResult, LabName, Result, shown_provenance
from grader.intake.downloads import Download
from grader.intake.names import encodable
from grader.people.final_grade import FinalGrade, HandIn, Person
from grader.platforms import rows
from grader.platforms.found import Found, Shape
from grader.platforms.platform import Help, Platform
from grader.report import words

SUBMISSION = "autograder/submission"


# --- results.json -----------------------------------------------------------------------------------------------------


def gradescope(result: Result, *, hidden: bool = False) -> str:
    """Return the text of Gradescope's `results.json`: one test per check, numbered in the order of the rubric.

    With `hidden`, the result comes from hidden scenarios, and the output says so. Raise GraderError if a part of the submission
    could not be judged.
    """
    rows.require_complete(result)
    record = {
        "score": result.total,
        "execution_time": round(result.duration_s, 3),
        "output": _output(result, hidden),
        "output_format": "html",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "tests": [
            _test(check, part, f"{i}.{j}", result.lab)
            for i, part in enumerate(rows.parts(result), 1)
            for j, check in enumerate(part.checks, 1)
        ]
        + _extra_credit(result),
        "extra_data": _extra_data(result),
    }
    return rows.as_json(record)


def _test(check: CheckResult, part: rows.ResultPart, number: str, lab: LabName) -> dict[str, Any]:
    test: dict[str, Any] = {
        "name": f"{rows.title(part)}: {printable(check.title, 300)}",
        "name_format": "text",
        "number": number,
        "status": "passed" if check.outcome == "passed" else "failed",
        "output": _output_of(check, part, lab),
        "output_format": "html",
        "tags": [part.id],
        "visibility": "visible",
    }
    # A test with a status and no points is shown as information. Extensions are: Gradescope wants the sum of `max_score` to be
    # the assignment's points, which extra credit does not change.
    points = {"score": check.points, "max_score": check.max_points}
    return {**test, **points} if isinstance(part, CriterionResult) else test


def _extra_credit(result: Result) -> list[dict[str, Any]]:
    """Return the extensions' points as one test without a maximum; no test if the rubric gives no extra credit."""
    if result.extra_credit_cap is None:
        return []
    test = {"name": "Extra credit", "score": result.extra_credit, "max_score": 0.0, "status": "passed"}
    limit = f"At most {words.number(result.extra_credit_cap)}, beside the score."
    return [{**test, "output": limit, "output_format": "text", "tags": ["extensions"], "visibility": "visible"}]


def _output_of(check: CheckResult, part: rows.ResultPart, lab: LabName) -> str:
    """Return the feedback of a check as HTML: labels, and text of fixed width. Gradescope removes unsafe HTML again."""
    set_lines = [_line(line) for line in rows.lines(check, part, lab)]
    return "".join(set_lines) or f"<p>{words.row(check, part.id, lab).outcome.word}</p>"


def _line(line: words.LabelledLine) -> str:
    text = html.escape(line.text)
    if line.label in ("", "Try", "Read"):
        return f"<p><b>{line.label}</b> {text}</p>" if line.label else f"<p>{text}</p>"
    return f"<pre>{line.label:<10}{text}</pre>"


def _output(result: Result, hidden: bool) -> str:
    said = [words.STATUS[result.status]] if words.STATUS[result.status] else []
    said += [rows.HIDDEN] if hidden else []
    said += [f"Note: {note}" for note in rows.notes(result)]
    said += [f"Fault: {fault}" for fault in words.faults(result)]
    said += [f"{line.label}: {line.text}" for line in words.help_lines(result)]
    return "".join(f"<p>{html.escape(line)}</p>" for line in said) or "<p>Graded.</p>"


def _extra_data(result: Result) -> dict[str, Any]:
    """Return what Gradescope keeps for the instructor alone: recognised faults and provenance, but no traces and no seed."""
    provenance = {key: str(value) for key, value in shown_provenance(result).items() if key != "seed"}
    return {"status": result.status, "misconceptions": list(result.misconceptions), "provenance": provenance}


# --- grades -----------------------------------------------------------------------------------------------------------

COLUMNS = (
    "First Name", "Last Name", "SID", "Email", "Sections", "Total Score", "Max Points", "Status", "Submission ID",
    "Submission Time", "Lateness (H:M:S)", "View Count", "Submission Count",
)  # fmt: skip
_SUFFIXES = ("jr", "jr.", "sr", "sr.", "ii", "iii", "iv")


def gradescope_csv(final_grades: Mapping[str, FinalGrade], absent: Sequence[Person] = (), missing: str = "") -> str:
    """Return a CSV with a row per person, in the columns of Gradescope's own export of grades.

    All members of a group have the final points of the group. Columns without a counterpart here are blank. `missing` is the grade
    of the people in `absent`, who did not hand in; "" for a blank cell.
    """
    handed_in = [_row(each, person) for each in final_grades.values() for person in each.people]
    others = [[*_who(person), missing, "", "Missing", *[""] * 5] for person in absent]
    return tables.written([COLUMNS, *handed_in, *others])


def _who(person: Person) -> list[str]:
    first, last = _first_and_last_name(person.name)
    return [printable(text, 500) for text in (first, last, person.number, person.email, person.section)]


def _row(final_grade: FinalGrade, person: Person) -> list[str]:
    final = final_grade.final
    return [
        *_who(person),
        "" if final is None else words.number(final),
        words.number(final_grade.result.max_score),
        "Ungraded" if final is None else "Graded",
        *(printable(text, 80) for text in (final_grade.hand_in.number, final_grade.hand_in.submitted)),
        _lateness(final_grade),
        "",
        "",
    ]


def _first_and_last_name(name: str) -> tuple[str, str]:
    """Return first and last name. Without a comma as in ``Doe, Jane``, the last word and a suffix are the last name."""
    last, comma, first = (part.strip() for part in name.partition(","))
    if comma and first.casefold() not in _SUFFIXES:
        return first, last
    given, _, family = last.rpartition(" ")
    return given.strip(), f"{family}, {first}" if comma else family


def _lateness(final_grade: FinalGrade) -> str:
    seconds = final_grade.late.seconds if final_grade.late else 0
    if seconds is None:
        return ""
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}"


# --- an export --------------------------------------------------------------------------------------------------------

TITLE = "Gradescope export"
METADATA = "submission_metadata.yml"
MAX_METADATA = 64_000_000
_NOT_OURS = f"{METADATA} does not name it, so whose it is cannot be told"
_NO_FILES = f"{METADATA} names it, and it has no folder"


def read(download: Download) -> Shape | None:
    """Return the submissions of a Gradescope export, one per group; None for any other download.

    An export has a folder `submission_<id>` for each group, and `submission_metadata.yml`, in which keys begin with a colon.
    """
    data = download.read(METADATA, MAX_METADATA) if METADATA in download.top else None
    if data is None:
        return None
    try:
        # CSafeLoader where PyYAML has it: the results in the file make it long, and this one is twenty times as fast
        records = yaml.load(data, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return None
    if not isinstance(records, dict):
        return None
    known = {str(folder): record if isinstance(record, dict) else {} for folder, record in records.items()}
    left = [(name, _NOT_OURS) for name in download.top if name not in known and name != METADATA]
    left += [(folder, _NO_FILES) for folder in known if folder not in download.top]
    return Shape(TITLE, tuple(_found(download, f, known[f]) for f in known if f in download.top), tuple(left))


def _found(download: Download, folder: str, record: Mapping[str, Any]) -> Found:
    submitters = record.get(":submitters")
    people = (
        tuple(_person(each) for each in submitters if isinstance(each, dict)) if isinstance(submitters, list) else ()
    )
    submitted = stamp(record.get(":created_at"))
    number = folder.rpartition("_")[2]
    keys = sorted(person.sid or person.email or person.name for person in people)
    first = min(people, key=lambda person: person.sid or person.email or person.name, default=Person(encodable(folder)))
    return Found(
        f"gradescope:{keys or folder}",
        "_".join(filter(None, (first.name, first.sid))),
        "; ".join(person.name for person in people) or encodable(folder),
        download.path,
        ((download.place(folder), ""),),
        HandIn(people, submitted, number=number if number.isdecimal() else ""),
        (submitted, int(number[:18]) if number.isdecimal() else 0, folder),
    )


def _person(record: Mapping[str, Any]) -> Person:
    name, sid, email = (encodable(str(record.get(key) or ""))[:500] for key in (":name", ":sid", ":email"))
    return Person(name or email or sid, sid=sid, email=email)


PLATFORM = Platform(
    name="gradescope",
    title="Gradescope",
    help=Help(
        respond="""\
1. Write the archive. For [hidden scenarios](../instructors/hidden.md) set `IMUGRADE_SEED` before; the archive then holds the hidden
   traces, never the secret. Without it, the public scenarios are used.

       imugrade kit --gradescope autograder.zip

2. In Gradescope, create a *Programming Assignment* with 100 autograder points, the sum of the rubric.
3. On *Configure Autograder*, choose Ubuntu 22.04 as base image, or another with Python 3.10 to 3.13, upload the archive and
   choose *Update Autograder*. The log ends with what `imugrade doctor` says of the container. The smallest container is enough:
   one process marks one submission, and a sound one stays [far below its 768 MB](cost.md). Raise the timeout under
   *Autograder Settings* to 40 minutes: Gradescope gives 0 to who reaches it. Code that never ends takes
   [2 to 8 minutes](cost.md), and longer in a slow container.
4. Choose *Test Autograder*, and hand in the files of `submissions_example/s01-sheet-verbatim`. The score is 100, and with hidden
   traces the text above the checks says *Graded on hidden scenarios*. Where the container isolates nothing, a run with hidden
   traces is refused: write the archive without a secret, and grade the final hand-ins on your own machine with hidden scenarios,
   from [*Export Submissions*](../instructors/downloads.md).

With hidden traces students see which checks they lost and what to try, not the numbers: those they find with `imugrade check`.
Code can carry some hidden data out in its score, so limit how often they hand in. If a part could not be judged there is no
`results.json`, and Gradescope says that the autograder failed; run it again from its page. A hand-in without gradable files gets 0.
Nothing is deducted for lateness: Gradescope does that.

To try the archive on your own machine, unpack it into `/tmp/ag/source`, put the files of a student into `/tmp/ag/submission`, make
the folder `/tmp/ag/results`, and run `setup.sh` and then `run_autograder` in `source`, each with `AUTOGRADER_ROOT=/tmp/ag bash`.
They have not run on Gradescope's own machines.""",
        read=("*Export Submissions*", "`submission_metadata.yml`", "the submitters; a group is one submission"),
        grades="the columns in which it exports grades, a row a person.",
    ),
    respond=lambda result, handed: gradescope(result, hidden=handed.hidden),
    recognise=lambda _, root: (root / SUBMISSION).is_dir(),
    submission=SUBMISSION,
    answer="autograder/results/results.json",
    keeps_secrets=True,
    read=read,
    write=lambda final_grades, absent, missing: (
        codecs.BOM_UTF8 + gradescope_csv(final_grades, absent, missing).encode("utf-8", "replace")
    ),  # marked: a spreadsheet spoils umlauts
    gradebook="gradescope.csv",
)
