"""GitHub Actions: workflow commands that annotate the student's lines, and the Markdown of the step summary.

The runner executes any line that begins with ``::`` as a command, so every text is encoded as its toolkit does. In Markdown
every character with a meaning there or in HTML is written as an entity. Text that may come from a submission is placed in
``<code>`` or ``<pre>``, where GitHub links no mention.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from grader.base.text import printable
from grader.engine.lab import Lab
from grader.engine.results import CheckResult, Result
from grader.platforms import rows
from grader.platforms.places import FileLine, Places, find_places
from grader.platforms.platform import Help, Platform, ResultContext, SecondOutput
from grader.report import causes, words
from grader.report.causes import Cause

MESSAGE_LIMIT = 4000
CHECKOUT = "actions/checkout@de0fac2e4500dabe0009e67214ff5f5447ce83dd # v6.0.2"
SETUP_PYTHON = "actions/setup-python@a309ff8b426b58ec0e2a45f0f869d46889d02405 # v6.2.0"
_PLAIN = frozenset(" ,;?%—…·✓✗◐–")


def commands(result: Result, places: Places) -> str:
    """Return workflow commands, by which GitHub shows messages at lines of code: one per fault and line, largest loss first.

    Checks without a known fault share a command if their messages are equal. The last command shows the total score. `places` finds
    the lines. No command is left out, but GitHub shows only the first ten errors, ten warnings and ten notices of a job's step.
    """
    worst_first = sorted(_annotations(result, places), key=lambda each: -each[1].lost)
    lines = [*(_command(place, cause, result) for place, cause in worst_first), _total_command(result)]
    return "".join(f"{command}\n" for command in lines)


def _annotations(result: Result, places: Places) -> Iterator[tuple[FileLine | None, Cause]]:
    """Yield a place and the checks that one cause fails there; the first place also lists the checks that wait for the cause."""
    for cause in _causes(result):
        there: dict[FileLine | None, list[CheckResult]] = {}
        for check in cause.checks:
            there.setdefault(places.line_for(check), []).append(check)
        waiting = (cause.waiting, *[()] * len(there))
        yield from (
            (place, Cause(tuple(checks), after)) for (place, checks), after in zip(there.items(), waiting, strict=False)
        )


def _causes(result: Result) -> list[Cause]:
    """Return the failed checks grouped by what made them fail, then, as one group, those that were not judged."""
    checks = [check for part in rows.parts(result) for check in part.checks]
    unjudged = tuple(check for check in checks if check.outcome == "not_judged")
    return [*causes.causes_of(checks), *([Cause(unjudged)] if unjudged else [])]


def _command(place: FileLine | None, cause: Cause, result: Result) -> str:
    checks = cause.checks
    kind = {"partial": "warning", "not_judged": "notice"}.get(checks[0].outcome, "error")
    where = [f"file={_property(place.file)}"] if place else []
    where += [f"line={place.line}"] if place and place.line else []
    where.append(f"title={_property(printable(_headline(checks), 250))}")
    also = "".join(f"\nAlso      {printable(check.title, 300)} ({_points(check)})" for check in checks[1:])
    message = rows.text_of_cause(cause, result.lab)
    return f"::{kind} {','.join(where)}::{_data(f'{message}{also}'[:MESSAGE_LIMIT])}"


def _headline(checks: Sequence[CheckResult]) -> str:
    first, many = checks[0], len(checks) - 1
    if not many:
        return f"{first.title} ({_points(first)})"
    more = f"and {many} more check{'s' * (many > 1)}"
    return f"{first.title}, {more} ({words.minus(words.points_lost(checks))})"


def _points(check: CheckResult) -> str:
    return words.fraction(check.points, check.max_points)


def _total_command(result: Result) -> str:
    """Return the workflow command that shows the total; without gradable files an error, as a passing job would hide that."""
    kind = "error" if result.status in ("empty", "unreadable") else "notice"
    said = ": ".join(filter(None, [words.total_points(result), words.STATUS[result.status]]))
    return f"::{kind} title={_property(result.lab.label)}::{_data(rows.with_help(said, result))}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def summary(result: Result, lab: Lab, *, hidden: bool = False) -> str:
    """Return Markdown for the step summary: points, outcomes of the checks of plots, deductions with hints, and notes."""
    blocks = [f"## {result.lab.label}: {escaped(words.total_points(result))}"]
    blocks += [f"**{escaped(words.STATUS[result.status])}**"] if words.STATUS[result.status] else []
    blocks += [_table(result), *_plots(result, lab), *_findings(result)]
    noted = [f"- <code>{escaped(note)}</code>" for note in rows.notes(result)]
    blocks += ["\n".join(["### Notes", "", *noted])] if noted else []
    blocks.append(rows.HIDDEN if hidden else "These are the public checks. On your own machine: `imugrade check`")
    blocks += [f"{line.label}: {line.text}" for line in words.help_lines(result)]
    return "\n\n".join(blocks) + "\n"


def _table(result: Result) -> str:
    lines = ["| Criterion | Points | Checks passed |", "| --- | ---: | ---: |"]
    for part in rows.parts(result):
        earned = sum(check.outcome == "passed" for check in part.checks)
        unknown = any(check.points is None for check in part.checks)
        points = words.fraction(None if unknown else part.points, part.max_points)
        lines.append(f"| {escaped(rows.title(part))} | {escaped(points)} | {earned} of {len(part.checks)} |")
    return "\n".join(lines)


def _plots(result: Result, lab: Lab) -> Iterator[str]:
    """Yield the outcomes of checks of plots, passed ones too, because a log cannot show the pictures themselves."""
    pictured = {part.id for part in lab.parts if part.pictures}
    for part in result.criteria:
        if part.id in pictured:
            found = [words.row(check, part.id, result.lab) for check in part.checks]
            listed = [f"- {row.outcome.sign} {escaped(row.title)} — {row.outcome.word}" for row in found]
            yield "\n".join(["### Plots", "", *listed])


def _findings(result: Result) -> Iterator[str]:
    for cause in _causes(result):
        heads = (words.row(check, "", result.lab) for check in cause.checks)
        head = "\n".join(
            f"#### {row.outcome.sign} {escaped(row.title)} — {row.outcome.word}, {escaped(row.points)}" for row in heads
        )
        yield f"{head}\n\n<pre>{escaped(rows.text_of_cause(cause, result.lab)[:MESSAGE_LIMIT])}</pre>"


def escaped(text: str) -> str:
    """Return text that Markdown and HTML show unchanged: all but letters, digits and a few harmless signs become entities."""
    return "".join(char if char.isalnum() or char in _PLAIN else _entity(char) for char in text)


def _entity(char: str) -> str:
    # An empty line ends an HTML block in Markdown, so line ends inside <pre> are entities as well.
    return f"&#{ord(char)};"


def _respond(result: Result, handed: ResultContext) -> str:
    root = Path(handed.environ.get("GITHUB_WORKSPACE") or ".").resolve()
    return commands(result, find_places(handed.lab, handed.submission, handed.path.resolve(), root))


PLATFORM = Platform(
    name="github",
    title="GitHub Actions",
    help=Help(
        respond=f"""\
    imugrade kit --github starter-repository

writes `.github/workflows/imugrade.yml` and the wheel beside it. On every push the job annotates what lost points, at the line
that raised or at the definition, once for each cause, and writes a summary with the table, the plots' findings and what to try.
GitHub shows ten errors and ten warnings of a step; those that cost most come first, and the summary has all of them. The workflow
may read the repository and nothing else, and its actions are pinned by their hashes.

Hidden scenarios stay out of a repository that students can read. In a private one of your own, with the wheel and a bundle in it
(`IMUGRADE_SEED=... imugrade traces record -o .`), a job that is started by hand grades a student's repository with them:

    name: Lab 04-01, hidden scenarios
    on:
      workflow_dispatch:
        inputs:
          repository:
            description: The student's repository
            required: true
    permissions:
      contents: read
    concurrency:
      group: imugrade-${{{{ inputs.repository }}}}
      cancel-in-progress: true
    jobs:
      grade:
        name: Hidden scenarios
        runs-on: ubuntu-latest
        timeout-minutes: 15
        environment: grading
        steps:
          - uses: {CHECKOUT}
            with:
              persist-credentials: false
          - uses: {CHECKOUT}
            with:
              repository: ${{{{ inputs.repository }}}}
              path: student
              token: ${{{{ secrets.STUDENTS_TOKEN }}}}
              persist-credentials: false
          - uses: {SETUP_PYTHON}
            with:
              python-version: "3.12"
          - run: python -m pip install imugrade-*.whl
          - run: imugrade ci student --traces hidden.npz --private

`--private` is your word that students can read neither the files nor the log of this job; the bundle stays outside the sandbox that
their code runs in. `STUDENTS_TOKEN`, a secret of the environment `grading`, may read the students' repositories and no more.""",
    ),
    respond=_respond,
    recognise=lambda environ, _: environ.get("GITHUB_ACTIONS") == "true",
    aside=SecondOutput("GITHUB_STEP_SUMMARY", lambda result, handed: summary(result, handed.lab, hidden=handed.hidden)),
)
