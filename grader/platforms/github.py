"""GitHub Actions: workflow commands that annotate the student's lines, and the Markdown of the step summary.

The runner takes a line that begins with ``::`` for a command, wherever it comes from, so every text is encoded the way that
its toolkit does. In Markdown every character that means something there or in HTML is written as an entity, and text that
may stem from a submission stands in ``<code>`` or ``<pre>``, where GitHub links no mention.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from grader.engine.lab import Lab
from grader.engine.results import CheckResult, Result
from grader.ground.text import printable
from grader.platforms import rows
from grader.platforms.places import Places, find_places
from grader.platforms.platform import Aside, Handed, Help, Platform
from grader.report import words

MESSAGE_LIMIT = 4000
_PLAIN = frozenset(" ,;?%—…·✓✗◐–")


def commands(result: Result, places: Places) -> str:
    """Workflow commands, one a line: those that cost most first, since GitHub shows ten of a kind for a step."""
    found = [(part, check) for part in rows.parts(result) for check in part.checks if _speaks(check)]
    found.sort(key=lambda pair: (pair[1].points or 0.0) - pair[1].max_points)
    told = [_command(check, rows.plain(check, part, result.lab), places) for part, check in found]
    return "".join(f"{command}\n" for command in [*told, _closing(result)])


def _speaks(check: CheckResult) -> bool:
    return rows.lost(check) or check.outcome == "not_judged"


def _command(check: CheckResult, message: str, places: Places) -> str:
    kind = {"partial": "warning", "not_judged": "notice"}.get(check.outcome, "error")
    place = places.of(check)
    where = [f"file={_property(place.file)}"] if place else []
    where += [f"line={place.line}"] if place and place.line else []
    points = words.fraction(check.points, check.max_points)
    name = f"title={_property(printable(f'{check.title} ({points})', 250))}"
    return f"::{kind} {','.join([*where, name])}::{_data(message[:MESSAGE_LIMIT])}"


def _closing(result: Result) -> str:
    """The total; where there was nothing to grade, as an error: a job that is green would hide it."""
    kind = "error" if result.status in ("empty", "unreadable") else "notice"
    said = ": ".join(filter(None, [words.total_points(result), words.STATUS[result.status]]))
    return f"::{kind} title={_property(result.lab.label)}::{_data(said)}"


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def summary(result: Result, lab: Lab) -> str:
    """Markdown for the step summary: the table, the plots' findings, then what was lost and how to go on."""
    blocks = [f"## {result.lab.label}: {inert(words.total_points(result))}"]
    blocks += [f"**{inert(words.STATUS[result.status])}**"] if words.STATUS[result.status] else []
    blocks += [_table(result), *_plots(result, lab), *_findings(result)]
    noted = [f"- <code>{inert(note)}</code>" for note in rows.notes(result)]
    blocks += ["\n".join(["### Notes", "", *noted])] if noted else []
    blocks.append("These are the public checks. On your own machine: `imugrade check`")
    return "\n\n".join(blocks) + "\n"


def _table(result: Result) -> str:
    lines = ["| Criterion | Points | Checks earned |", "| --- | ---: | ---: |"]
    for part in rows.parts(result):
        earned = sum(check.outcome == "passed" for check in part.checks)
        unknown = any(check.points is None for check in part.checks)
        points = words.fraction(None if unknown else part.points, part.max_points)
        lines.append(f"| {inert(rows.title(part))} | {inert(points)} | {earned} of {len(part.checks)} |")
    return "\n".join(lines)


def _plots(result: Result, lab: Lab) -> Iterator[str]:
    """Each finding about the pictures, the good ones too: a picture cannot be seen in a log."""
    pictured = {part.id for part in lab.parts if part.pictures}
    for part in result.criteria:
        if part.id in pictured:
            found = [words.row(check, part.id, result.lab) for check in part.checks]
            listed = [f"- {row.outcome.sign} {inert(row.title)} — {row.outcome.word}" for row in found]
            yield "\n".join(["### Plots", "", *listed])


def _findings(result: Result) -> Iterator[str]:
    for part in rows.parts(result):
        for check in part.checks:
            if _speaks(check):
                row = words.row(check, part.id, result.lab)
                head = f"#### {row.outcome.sign} {inert(row.title)} — {row.outcome.word}, {inert(row.points)}"
                yield f"{head}\n\n<pre>{inert(rows.plain(check, part, result.lab)[:MESSAGE_LIMIT])}</pre>"


def inert(text: str) -> str:
    """Text that neither Markdown nor HTML takes for anything else: all but letters, digits and spaces as entities."""
    return "".join(char if char.isalnum() or char in _PLAIN else _entity(char) for char in text)


def _entity(char: str) -> str:
    # An empty line ends an HTML block in Markdown, so line ends inside <pre> are entities as well.
    return f"&#{ord(char)};"


def _respond(result: Result, handed: Handed) -> str:
    root = Path(handed.environ.get("GITHUB_WORKSPACE") or ".").resolve()
    return commands(result, find_places(handed.lab, handed.submission, handed.path.resolve(), root))


PLATFORM = Platform(
    name="github",
    title="GitHub Actions",
    help=Help(
        respond="""\
    imugrade kit --github starter-repository

writes `.github/workflows/imugrade.yml` and the wheel beside it. On every push the job annotates what lost points, at the line
that raised or at the definition, and writes a summary with the table, the plots' findings and what to try. GitHub shows ten
errors and ten warnings of a step; those that cost most come first, and the summary has all of them.""",
    ),
    respond=_respond,
    recognise=lambda environ, _: environ.get("GITHUB_ACTIONS") == "true",
    aside=Aside("GITHUB_STEP_SUMMARY", lambda result, handed: summary(result, handed.lab)),
)
