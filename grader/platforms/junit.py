"""JUnit XML as Jenkins' schema has it (xunit-plugin, `junit-10.xsd`), for GitLab and whoever else reads it.

JUnit has no word for points: they are properties of the suite, since the schema allows none of a case. What a student lost is a
failure, a part of it too (JUnit knows no half); an error is what the grader failed to judge.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import datetime, timezone
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from grader.base.text import printable
from grader.engine.results import CheckResult, Result
from grader.platforms import rows
from grader.platforms.platform import Help, Platform
from grader.report import words

_COUNTED = {"tests": "testcase", "failures": "testcase/failure", "errors": "testcase/error"}


def junit(result: Result, at: datetime) -> str:
    """One suite a criterion, one case a check; `at` is when it was marked."""
    root = Element("testsuites", name="imugrade")
    for part in rows.parts(result):
        _suite(root, part, result, at)
    if result.repairs:
        _repairs(root, result, at)
    for name in _COUNTED:
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    root.set("time", _seconds(check.duration_s for part in rows.parts(result) for check in part.checks))
    indent(root)
    text = tostring(root, encoding="unicode")
    # In a job on GitHub a line that begins with :: would be a command of the runner; so would the older ##[.
    text = text.replace("::", "&#58;&#58;").replace("##[", "&#35;#[")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _suite(root: Element, part: rows.Part, result: Result, at: datetime) -> None:
    suite = SubElement(root, "testsuite", name=part.id, timestamp=at.isoformat(timespec="seconds"))
    properties = SubElement(suite, "properties")
    for name, value in _facts(part):
        SubElement(properties, "property", name=name, value=value)
    for check in part.checks:
        _case(suite, check, part, result)
    for name, path in {**_COUNTED, "skipped": "testcase/skipped"}.items():
        suite.set(name, str(len(suite.findall(path))))
    suite.set("time", _seconds(check.duration_s for check in part.checks))


def _repairs(root: Element, result: Result, at: datetime) -> None:
    """A suite without cases: what was repaired, and the points that it takes from the sum of the others."""
    suite = SubElement(root, "testsuite", name="repairs", timestamp=at.isoformat(timespec="seconds"), time="0")
    properties = SubElement(suite, "properties")
    SubElement(properties, "property", name="score", value=words.number(-result.repair_deduction))
    for number, line in enumerate(words.repairs(result), 1):
        SubElement(properties, "property", name=f"repair.{number}", value=line)
    for name in (*_COUNTED, "skipped"):
        suite.set(name, "0")


def _facts(part: rows.Part) -> Iterator[tuple[str, str]]:
    """The points of the suite, then of each case: ``follows_address.score``; nothing for what is not known."""
    yield "score", words.number(part.points)
    yield "max_score", words.number(part.max_points)
    for check in part.checks:
        facts = {
            "score": "" if check.points is None else words.number(check.points),
            "max_score": words.number(check.max_points),
            "outcome": check.outcome,
            "title": printable(check.title, 300),
            "mistake": ", ".join(_mistakes(check)),
        }
        yield from ((f"{_name(check)}.{fact}", value) for fact, value in facts.items() if value)


def _case(suite: Element, check: CheckResult, part: rows.Part, result: Result) -> None:
    time = _seconds([check.duration_s])
    case = SubElement(suite, "testcase", classname=f"imugrade.{part.id}", name=_name(check), time=time)
    verdict = _verdict(check, result)
    if verdict:
        told = rows.plain(check, part, result.lab)
        SubElement(case, verdict, message=_headline(check, told), type=check.outcome).text = told


def _name(check: CheckResult) -> str:
    return printable(check.id.partition(".")[2] or check.id, words.NAME_LIMIT)


def _seconds(durations: Iterable[float]) -> str:
    return f"{sum(durations):.3f}"


def _mistakes(check: CheckResult) -> list[str]:
    return [printable(id_, 80) for id_ in check.misconceptions if id_ not in words.FOR_THE_INSTRUCTOR]


def _verdict(check: CheckResult, result: Result) -> str:
    """The element of a check that was not earned; empty for one that was."""
    if check.outcome == "passed":
        return ""
    if check.outcome == "not_judged":
        return "error"
    # A skipped check names the check to fix first. An empty submission has none, and skipped would look green.
    return "skipped" if check.outcome == "skipped" and result.status in ("graded", "incomplete") else "failure"


def _headline(check: CheckResult, told: str) -> str:
    points = words.fraction(check.points, check.max_points)
    return f"{points} points: {printable(check.title, 300)}" if told else f"{points} points"


PLATFORM = Platform(
    name="junit",
    title="JUnit XML (GitLab, Jenkins)",
    help=Help(
        respond="""\
    imugrade kit --gitlab starter-repository

writes `.gitlab-ci.yml` and the wheel beside it. Elsewhere:

    imugrade ci --out junit.xml

Where no platform is recognised JUnit is what `imugrade ci` writes; the file is valid against Jenkins' own schema. A part earned is
a failure with the fraction in its message, since JUnit knows no half; points are the properties `score` and `max_score` of each
suite, and of each case as `follows_address.score`. An error is what the grader could not judge.""",
    ),
    respond=lambda result, _: junit(result, datetime.now(timezone.utc)),
    recognise=lambda *_: True,  # whatever runs jobs reads it
)
