"""JUnit XML that is valid against Jenkins' schema (xunit-plugin, `junit-10.xsd`), for GitLab and other CI servers.

JUnit has no points: they are properties of the suite, because the schema allows none for a case. A failed or partial check is a
failure. A check that the grader could not judge is an error. A skipped check is skipped. A submission without files to grade has
only skipped checks, which a CI server would show as green; so it has one more case, which fails and says why.
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
    """Return JUnit XML, which most CI systems show: a suite per criterion and a case per check; `at` is the time of grading."""
    root = Element("testsuites", name="imugrade")
    for part in rows.parts(result):
        _suite(root, part, result, at)
    if result.repairs:
        _repairs(root, result, at)
    if words.STATUS[result.status] and result.status != "incomplete":
        _nothing_to_grade(root, result, at)
    for failure in root.findall("testsuite/testcase/failure")[:1]:  # the file has no text on the whole result
        failure.text = rows.with_help(failure.text or "", result)
    for name in _COUNTED:
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    root.set("time", _seconds(check.duration_s for part in rows.parts(result) for check in part.checks))
    indent(root)
    text = tostring(root, encoding="unicode")
    # GitHub's runner would execute a line that begins with :: or with the older ##[ as a command.
    text = text.replace("::", "&#58;&#58;").replace("##[", "&#35;#[")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _suite(root: Element, part: rows.ResultPart, result: Result, at: datetime) -> None:
    suite = _new_suite(root, part.id, at, _facts(part))
    for check in part.checks:
        _case(suite, check, part, result)
    _set_counts(suite, part.checks)


def _new_suite(root: Element, name: str, at: datetime, facts: Iterable[tuple[str, str]] = ()) -> Element:
    """Add a suite, such as one of a criterion, with these facts as its properties, and return it."""
    suite = SubElement(root, "testsuite", name=name, timestamp=at.isoformat(timespec="seconds"))
    properties = SubElement(suite, "properties")
    for key, value in facts:
        SubElement(properties, "property", name=key, value=value)
    return suite


def _set_counts(suite: Element, checks: Iterable[CheckResult] = ()) -> None:
    """Set a suite's numbers of cases by outcome, and the time that its checks took."""
    for name, path in {**_COUNTED, "skipped": "testcase/skipped"}.items():
        suite.set(name, str(len(suite.findall(path))))
    suite.set("time", _seconds(check.duration_s for check in checks))


def _repairs(root: Element, result: Result, at: datetime) -> None:
    """Add a suite without cases that lists the repairs (patches by an instructor); its negative score is their deduction."""
    lines = ((f"repair.{number}", line) for number, line in enumerate(words.repairs(result), 1))
    _set_counts(_new_suite(root, "repairs", at, [("score", words.number(-result.repair_deduction)), *lines]))


def _facts(part: rows.ResultPart) -> Iterator[tuple[str, str]]:
    """Yield the properties of a suite, then those of each case, such as ``follows_address.score``. Unknown values are left out."""
    yield "score", words.number(part.points)
    yield "max_score", words.number(part.max_points)
    for check in part.checks:
        facts = {
            "score": "" if check.points is None else words.number(check.points),
            "max_score": words.number(check.max_points),
            "outcome": check.outcome,
            "title": printable(check.title, 300),
            "faults": ", ".join(_faults(check)),
        }
        yield from ((f"{_name(check)}.{fact}", value) for fact, value in facts.items() if value)


def _case(suite: Element, check: CheckResult, part: rows.ResultPart, result: Result) -> None:
    time = _seconds([check.duration_s])
    case = SubElement(suite, "testcase", classname=f"imugrade.{part.id}", name=_name(check), time=time)
    verdict = _element_name(check)
    if verdict:
        text = rows.plain_text(check, part, result.lab)
        SubElement(case, verdict, message=_headline(check, text), type=check.outcome).text = text


def _name(check: CheckResult) -> str:
    return printable(check.id.partition(".")[2] or check.id, words.NAME_LIMIT)


def _seconds(durations: Iterable[float]) -> str:
    return f"{sum(durations):.3f}"


def _faults(check: CheckResult) -> list[str]:
    return [printable(id_, 80) for id_ in check.misconceptions if id_ not in words.FOR_THE_INSTRUCTOR]


def _nothing_to_grade(root: Element, result: Result, at: datetime) -> None:
    """Add the one failing case of an empty or unreadable submission, so that a CI server does not show it as passed."""
    suite = _new_suite(root, "submission", at)
    case = SubElement(suite, "testcase", classname="imugrade.submission", name="can_be_graded", time=_seconds([]))
    failure = SubElement(case, "failure", message=words.STATUS[result.status], type=result.status)
    failure.text = "\n".join([words.STATUS[result.status], *words.notes(result)])
    _set_counts(suite)


def _element_name(check: CheckResult) -> str:
    """Return the name of the XML element for a check's outcome; "" for a passed check, which has none."""
    return {"passed": "", "not_judged": "error", "skipped": "skipped"}.get(check.outcome, "failure")


def _headline(check: CheckResult, text: str) -> str:
    points = words.fraction(check.points, check.max_points)
    return f"{points} points: {printable(check.title, 300)}" if text else f"{points} points"


PLATFORM = Platform(
    name="junit",
    title="JUnit XML (GitLab, Jenkins)",
    help=Help(
        respond="""\
    imugrade kit --gitlab starter-repository

writes `.gitlab-ci.yml` and the wheel beside it. Elsewhere:

    imugrade ci --out junit.xml

`imugrade ci` writes JUnit if it recognizes no platform. The file is valid against Jenkins' own schema.

- A partial check is a failure with its points in the message: JUnit has no half.
- A check that needs another one is skipped. A check that the grader could not judge is an error.
- A submission without files to grade has only skipped checks and one failure, `imugrade.submission.can_be_graded`. So the job is
  red, and the number of failures is not 30.
- Points are the properties `score` and `max_score` of each suite, and of each case as `follows_address.score`.""",
    ),
    respond=lambda result, _: junit(result, datetime.now(timezone.utc)),
    recognise=lambda *_: True,  # any other CI server may read it
)
