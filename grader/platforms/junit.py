"""JUnit XML as pytest writes it, for GitLab and whoever else reads it. Points are properties: JUnit has no word for them.

What a student lost is a failure, a part of it too (JUnit knows no half); an error is what the grader failed to judge.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from grader.engine.results import CheckResult, Result
from grader.ground.text import printable
from grader.platforms import rows
from grader.platforms.platform import Help, Platform
from grader.report import words


def junit(result: Result) -> str:
    """One suite a criterion, one case a check."""
    root = Element("testsuites", name="imugrade")
    for part in rows.parts(result):
        _suite(root, part, result)
    indent(root)
    text = tostring(root, encoding="unicode")
    # In a job on GitHub a line that begins with :: would be a command of the runner; so would the older ##[.
    text = text.replace("::", "&#58;&#58;").replace("##[", "&#35;#[")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _suite(root: Element, part: rows.Part, result: Result) -> None:
    suite = SubElement(root, "testsuite", name=part.id)
    _properties(suite, {"score": words.number(part.points), "max_score": words.number(part.max_points)})
    for check in part.checks:
        _case(suite, check, part, result)
    counts = {"tests": "testcase", "failures": "testcase/failure", "errors": "testcase/error"}
    for name, path in {**counts, "skipped": "testcase/skipped"}.items():
        suite.set(name, str(len(suite.findall(path))))
    suite.set("time", f"{sum(check.duration_s for check in part.checks):.3f}")


def _case(suite: Element, check: CheckResult, part: rows.Part, result: Result) -> None:
    name = printable(check.id.partition(".")[2] or check.id, words.NAME_LIMIT)
    case = SubElement(suite, "testcase", classname=f"imugrade.{part.id}", name=name, time=f"{check.duration_s:.3f}")
    facts = {
        "criterion": part.id,
        "score": "" if check.points is None else words.number(check.points),
        "max_score": words.number(check.max_points),
        "outcome": check.outcome,
        "title": printable(check.title, 300),
    }
    _properties(case, facts | {"mistake": ", ".join(_mistakes(check))})
    verdict = _verdict(check, result)
    if verdict:
        told = rows.plain(check, part, result.lab)
        SubElement(case, verdict, message=_headline(check, told), type=check.outcome).text = told


def _mistakes(check: CheckResult) -> list[str]:
    return [printable(id_, 80) for id_ in check.misconceptions if id_ not in words.FOR_THE_INSTRUCTOR]


def _properties(parent: Element, values: dict[str, str]) -> None:
    properties = SubElement(parent, "properties")
    for name, value in values.items():
        if value:
            SubElement(properties, "property", name=name, value=value)


def _verdict(check: CheckResult, result: Result) -> str:
    """The element of a check that was not earned; empty for one that was."""
    if check.outcome == "passed":
        return ""
    if check.outcome == "not_judged":
        return "error"
    # "Not reached" points to the check that tells. Where nothing was handed in, none does: skipped would look green.
    return "skipped" if check.outcome == "skipped" and result.status in ("graded", "incomplete") else "failure"


def _headline(check: CheckResult, told: str) -> str:
    points = words.fraction(check.points, check.max_points)
    return f"{points} points: {printable(check.title, 300)}" if told else f"{points} points"


PLATFORM = Platform(
    name="junit",
    title="JUnit XML (GitLab, Jenkins)",
    help=Help(
        respond="""\
    lab:
      image: python:3.12
      script:
        - pip install imugrade-*.whl
        - imugrade ci --format junit --out junit.xml --min-score 60
      artifacts:
        when: always
        reports:
          junit: junit.xml

A part earned is a failure with the fraction in its message, since JUnit knows no half; points are the properties `score` and
`max_score` of each case and suite. An error is what the grader could not judge.""",
    ),
    respond=lambda result, _: junit(result),
    recognise=lambda environ, _: environ.get("GITLAB_CI") == "true",
)
