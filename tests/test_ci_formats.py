"""What the CI platforms read, held to each platform's rules and to what a hostile submission would make of it."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree

import jsonschema
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from junitparser import xunit2
from markdown_it import MarkdownIt

from grader.engine.findings import Where
from grader.engine.results import Result, Status, to_json
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.platforms import github, registry
from grader.platforms.classroom50 import classroom50, identity_of, shares
from grader.platforms.gradescope import gradescope
from grader.platforms.job import recognise
from grader.platforms.junit import junit
from grader.platforms.places import FileLine, Places, find_places
from grader.platforms.platform import ResultContext
from grader.platforms.prairielearn import prairielearn
from grader.report import words
from tests.corpus.writing import write
from tests.fake_results import HOSTILE, check, lost, result, submission
from tests.hostile.outputs import ENVIRONMENT as ID
from tests.pages import Page
from tests.test_results import SCHEMA

EVIL = (
    f"{HOSTILE}\n::error file=/etc/passwd::owned\n  ::set-output name=x::y\n##[error]x\n]]></failure><evil/>\n"
    "```\n</pre></code><img src=x onerror=alert(1)>\n# heading\n| a | b |\n[a](http://evil.example) @someone http://evil.example"
    "\r\n\x00\x08\ufffe\ud800 %0A%3A ::stop-commands::x"
)
WHEN = "2026-11-01T10:00:00Z"


def evil() -> Result:
    """A submission that puts its text wherever it can."""
    rows = (lost(message=f"Expected  x\nGot       {EVIL}", hint=EVIL), check("error", 0.0, message=EVIL, title=EVIL))
    return result(*rows, name=EVIL, notes=(EVIL,))


def mixed() -> Result:
    """One check of each outcome that a complete result has."""
    return result(
        check(id="sensor_access.a"),
        check("partial", 3.33, id="sensor_access.b", message="Expected  six\nGot       five"),
        lost(id="sensor_access.c"),
        check("skipped", 0.0, id="sensor_access.d", message="Not graded until “Reads” is fixed."),
        check("crashed", 0.0, id="sensor_access.e", message="Expected  an answer\nGot       none: killed"),
    )


def record(required: str, **properties: object) -> dict[str, object]:
    """A schema: an object that has these properties, the required ones at least, and no others."""
    return {
        "type": "object", "additionalProperties": False, "required": required.split(),
        "properties": properties,
    }  # fmt: skip


def listed(items: dict[str, object]) -> dict[str, object]:
    return {"type": "array", "items": items}


NUMBER, TEXT, FLAG, SOME = ({"type": kind} for kind in ("number", "string", "boolean", "object"))


def read(text: str, schema: Mapping[str, object]) -> dict[str, Any]:
    told: dict[str, Any] = json.loads(text)
    jsonschema.validate(told, schema)
    return told


# --- GitHub -----------------------------------------------------------------------------------------------------------

COMMAND = re.compile(r"::(?P<kind>error|warning|notice) (?P<properties>[^:\n]*)::(?P<message>[^\n]*)")


def as_the_runner_reads(text: str) -> list[tuple[str, dict[str, str], str]]:
    """The commands in a log: every line that begins with :: after spaces is one."""
    commands = []
    for line in text.split("\n"):
        if line.lstrip().startswith("::") or "##[" in line:
            found = COMMAND.fullmatch(line)
            assert found, line
            properties = dict(pair.split("=", 1) for pair in found["properties"].split(","))
            commands.append((found["kind"], {k: unquote(v) for k, v in properties.items()}, unquote(found["message"])))
    return commands


def test_github_gets_one_annotation_for_each_cause_and_the_score() -> None:
    commands = as_the_runner_reads(github.commands(mixed(), Places(LAB)))
    assert [kind for kind, _, _ in commands] == ["error", "error", "warning", "notice"]
    crashed, lost_, *_ = commands
    assert "\nCosts     12 points now, because 1 more check could not run. Everything else was" in crashed[2]
    assert lost_[1] == {"title": "Reads the right sensor (0 / 6)"}
    assert lost_[2].splitlines() == [
        "Expected  accel ≈ [ 0.412 -0.031 -9.702] m/s²",
        "Got       accel = [ 1.000  0.412 -0.031]",
        "Try       data.sensordata is flat: sensor i starts at model.sensor_adr[i], not at i",
        "Read      Lab 04-01, Step 2; imugrade explain sensor-id-as-address",
        "Rerun     imugrade check --only sensor_access",
    ]
    assert commands[-1][2].splitlines() == ["9.33 / 30", "Help      open guide.html, in your starter files"]


def test_an_annotation_points_to_the_line_that_raised_in_a_file_of_the_submission() -> None:
    places = Places(LAB, {"filters.py": "lab/filters.py"}, {"get_imu_readings": FileLine("lab/imu_reader.py", 7)})
    row = check("error", 0.0, "ValueError: no at evil.py, line 3", where=Where("filters.py", 12))
    told = as_the_runner_reads(github.commands(result(row), places))[0][1]
    assert (told["file"], told["line"]) == ("lab/filters.py", "12")
    assert places.line_for(check("error", 0.0, where=Where("/etc/passwd", 1))) == FileLine("lab/imu_reader.py", 7)


def test_definitions_are_found_in_the_folder_that_holds_the_lab(tmp_path: Any) -> None:
    lab = "class LowPassFilterState: ...\n\n\nclass LowPassFilter:\n    pass\n"
    draw = "class NoisyIMU:\n    def plot_imu_data(): ...\n"
    write(
        {
            "week4/lab/lab.py": lab,
            "week4/lab/imu_reader.py": "x = 1\ndef plot_imu_data(): ...\n",
            "week4/draw.py": draw,
        },
        tmp_path,
    )
    places = find_places(LAB, read_submission(tmp_path, LAB.files), tmp_path, tmp_path)
    assert places.definitions["LowPassFilter"] == FileLine("week4/lab/lab.py", 4)
    assert places.definitions["get_imu_readings"] == FileLine("week4/lab/imu_reader.py")
    assert places.definitions["NoisyIMU"] == FileLine("week4/draw.py", 1)
    assert places.definitions["plot_imu_data"] == FileLine("week4/lab/imu_reader.py", 2)
    assert "multi_imu" not in places.definitions


SUMMARY_TAGS = {"h2", "h3", "h4", "table", "thead", "tbody", "tr", "th", "td", "ul", "li", "p", "pre", "code", "strong"}


def rendered(markdown: str) -> Page:
    return Page(MarkdownIt("commonmark").enable("table").render(markdown))


# --- JUnit ------------------------------------------------------------------------------------------------------------

JENKINS: Mapping[str, tuple[set[str], set[str], set[str]]] = {
    # `junit-10.xsd` of Jenkins' xunit-plugin. Element: attributes that it must have, that it may have, and its children
    "testsuites": (set(), {"name", "time", "tests", "failures", "errors"}, {"testsuite"}),
    "testsuite": (
        {"name", "tests", "failures", "errors"},
        {"group", "time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url"},
        {"testsuite", "properties", "testcase", "system-out", "system-err"},
    ),
    "testcase": (
        {"name"},
        {"time", "classname", "group"},
        {"skipped", "error", "failure", "rerunFailure", "rerunError", "flakyFailure", "flakyError", "system-out", "system-err"},
    ),
    "properties": (set(), set(), {"property"}),
    "property": ({"name", "value"}, set(), set()),
    **dict.fromkeys(("failure", "error", "skipped"), (set(), {"type", "message"}, set())),
}  # fmt: skip
SUREFIRE_TIME = r"(([0-9]{0,3},)*[0-9]{3}|[0-9]{0,3})*(\.[0-9]*)?"
AT = datetime(2026, 11, 22, 17, 0, 1, 5, timezone.utc)
COUNTED = {"tests": ".//testcase", "failures": ".//failure", "errors": ".//error", "skipped": ".//skipped"}


def as_jenkins_reads(text: str) -> ElementTree.Element:
    """The tree, each of its elements held to Jenkins' schema, and its totals to what they count."""
    root = ElementTree.fromstring(text.encode())
    assert root.tag == "testsuites"
    for element in root.iter():
        must, may, children = JENKINS[element.tag]
        assert must <= set(element.keys()) <= must | may, element.tag
        assert {child.tag for child in element} <= children, element.tag
        if element.tag in ("testsuites", "testsuite"):
            assert re.fullmatch(SUREFIRE_TIME, element.get("time", ""))
            for name, path in COUNTED.items():
                if (element.tag, name) != ("testsuites", "skipped"):  # the schema allows no such total
                    assert element.get(name) == str(len(element.findall(path))), f"{name} of {element.tag}"
        if element.tag == "testcase":
            assert len(element) <= 1
    assert [suite.get("timestamp") for suite in root] == ["2026-11-22T17:00:01+00:00"] * len(root)
    return root


def test_another_parser_reads_the_same_points_and_outcomes_from_junit() -> None:
    read = xunit2.JUnitXml.fromstring(junit(mixed(), AT).encode())
    parts = [part for part in (*mixed().criteria, *mixed().extensions) if part.checks]
    assert [(suite.name, suite.tests) for suite in read] == [(part.id, len(part.checks)) for part in parts]
    for suite, part in zip(read, parts, strict=True):
        told = {each.name: each.value for each in suite.properties()}
        for row in part.checks:
            name = row.id.partition(".")[2]
            assert (float(told[f"{name}.score"]), told[f"{name}.outcome"]) == (row.points, row.outcome)


@pytest.mark.parametrize("status", ["empty", "unreadable"])
def test_a_check_that_needs_another_is_skipped_and_what_cannot_be_graded_is_one_failure_and_no_attempt(
    status: Status,
) -> None:
    row = check("skipped", 0.0)
    assert as_jenkins_reads(junit(result(row), AT))[0].get("skipped") == "1"
    empty = as_jenkins_reads(junit(result(row, status=status), AT))
    assert (empty[0].get("skipped"), empty[0].get("failures")) == ("1", "0")
    (failure,) = empty.findall("testsuite[@name='submission']/testcase/failure")
    assert (failure.get("message"), failure.get("type")) == (words.STATUS[status], status)
    assert empty.get("failures") == "1"


@settings(max_examples=60, deadline=None)
@given(st.text(st.characters(exclude_categories=[]), max_size=80))
def test_any_text_makes_well_formed_xml(text: str) -> None:
    as_jenkins_reads(junit(result(lost(message=text, hint=text, title=text)), AT))


# --- Gradescope -------------------------------------------------------------------------------------------------------

VISIBILITY = {"enum": ["hidden", "after_due_date", "after_published", "visible"]}
FORMAT = {"enum": ["text", "html", "simple_format", "md", "ansi"]}
GRADESCOPE = record(
    "score tests", score=NUMBER, execution_time=NUMBER, output=TEXT, output_format=FORMAT, visibility=VISIBILITY,
    stdout_visibility=VISIBILITY, extra_data=SOME,
    tests=listed(
        record(
            "name status", score=NUMBER, max_score=NUMBER, status={"enum": ["passed", "failed"]}, name=TEXT, name_format=FORMAT,
            number=TEXT, output=TEXT, output_format=FORMAT, tags=listed(TEXT), visibility=VISIBILITY,
        )
        | {"dependentRequired": {"score": ["max_score"]}}
    ),
)  # fmt: skip


def test_gradescope_gets_a_test_a_check_whose_points_sum_to_the_total() -> None:
    told = read(gradescope(mixed()), GRADESCOPE)
    assert told["score"] == round(sum(test.get("score", 0.0) for test in told["tests"]), 2) == 9.33
    assert sum(test.get("max_score", 0.0) for test in told["tests"]) == 30
    assert [test["number"] for test in told["tests"]] == ["1.1", "1.2", "1.3", "1.4", "1.5", "2.1"]
    assert told["tests"][2]["output"].startswith("<pre>Expected  accel ≈ [ 0.412 -0.031 -9.702] m/s²</pre>")


# --- PrairieLearn -----------------------------------------------------------------------------------------------------

PRAIRIELEARN = record(
    "score gradable", score=NUMBER | {"minimum": 0, "maximum": 1}, gradable=FLAG, message=TEXT, output=TEXT,
    format_errors=listed(TEXT),
    tests=listed(
        record(
            "name points max_points", name=TEXT, description=TEXT, points=NUMBER, max_points=NUMBER, message=TEXT, output=TEXT
        )
    ),
)  # fmt: skip


def read_prairielearn(text: str) -> dict[str, Any]:
    assert len(text.encode()) <= 1_000_000
    return read(text, PRAIRIELEARN)


def test_github_and_prairielearn_are_given_no_more_than_they_take() -> None:
    huge = result(*(lost(id=f"sensor_access.c{i}", message="ü" * 2000, hint="ü" * 5000) for i in range(200)))
    assert max(map(len, github.commands(huge, Places(LAB)).splitlines())) < 8000
    told = read_prairielearn(prairielearn(huge))
    assert told["score"] == 0
    assert told["tests"] == []


# --- Classroom 50 -----------------------------------------------------------------------------------------------------

WHOLE = {"type": "integer", "minimum": 0}
NAME = TEXT | {"minLength": 1}
CLASSROOM50 = record(
    "schema classroom assignment owner submission commit release review datetime score max-score tests",
    schema={"const": "classroom50/result/v1"}, classroom=NAME, assignment=NAME, owner=NAME, submission=NAME, commit=NAME,
    release=NAME, review=NAME, assignment_type={"enum": ["individual", "group"]}, score=WHOLE, tests=listed(
        record("test-name passed score max-score", passed=FLAG, score=WHOLE, **{"max-score": WHOLE, "test-name": TEXT})
        | {"additionalProperties": True}
    ),
    datetime=TEXT | {"pattern": r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$"}, **{"max-score": WHOLE},
)  # fmt: skip


def read_classroom50(graded: Result) -> dict[str, Any]:
    return read(classroom50(graded, identity_of(ID), WHEN), CLASSROOM50)


def test_classroom50_gets_whole_points_that_sum_to_the_total_and_the_exact_ones_beside_them() -> None:
    told = read_classroom50(mixed())
    assert (told["score"], told["max-score"]) == (9, 30)
    assert [test["score"] for test in told["tests"]] == [6, 3, 0, 0, 0]
    assert told["tests"][1]["exact-score"] == 3.33
    assert [test["passed"] for test in told["tests"]] == [True, False, False, False, False]
    assert told["datetime"] == WHEN


hundredths = st.integers(0, 2000).map(lambda n: n / 100)


@given(st.lists(st.tuples(hundredths, st.floats(0, 1)), min_size=1, max_size=12))
@example([(3.24, 1.0), (3.32, 1.0), (3.33, 0.28125)])  # two that are full leave their rest to the third
def test_whole_points_sum_to_the_rounded_total_and_never_exceed_their_most(rows: list[tuple[float, float]]) -> None:
    full = [points for points, _ in rows]
    earned = [round(points * share, 2) for points, share in rows]
    most = shares(full, [1e9] * len(full))
    scores = shares(earned, most)
    assert sum(most) == int(round(sum(full), 2) + 0.5)
    assert sum(scores) == min(int(round(sum(earned), 2) + 0.5), sum(most))
    assert all(0 <= score <= top for score, top in zip(scores, most, strict=True))
    assert all(abs(top - points) < 1 for top, points in zip(most, full, strict=True))


# --- extra credit -----------------------------------------------------------------------------------------------------


def test_extra_credit_counts_and_leaves_the_assignments_points_alone() -> None:
    """3.33 of 6 points, and 8 of extensions that are capped at 4.5."""
    base = result(check("partial", 3.33))
    tried = (check(id="allan_variance.a", points=8.0, max_points=10.0),)
    extension = replace(base.extensions[0], max_points=10.0, checks=tried)
    made = replace(base, extensions=(extension,), extra_credit_cap=4.5)
    scope = read(gradescope(made), GRADESCOPE)
    assert scope["score"] == 7.83 == round(sum(test.get("score", 0.0) for test in scope["tests"]), 2)
    assert sum(test.get("max_score", 0.0) for test in scope["tests"]) == 6
    room = read_classroom50(made)
    assert (room["score"], room["max-score"]) == (3 + 5, 6)
    assert room["tests"][-1]["exact-score"] == 4.5
    assert read_prairielearn(prairielearn(made))["score"] == 1.0


# --- a class ------------------------------------------------------------------------------------------------------------

CLASS = {
    "good": result(),
    "with faults": mixed(),
    "that hangs": result(check(), check("timeout", 0.0)),
    "with hostile text": evil(),
    "empty": result(check("skipped", 0.0, message=EVIL), status="empty", notes=(EVIL,)),
    "unreadable": result(check("skipped", 0.0, message=EVIL), status="unreadable", notes=(EVIL,)),
}


def keeps_rules_of_junit(graded: Result) -> None:
    root = as_jenkins_reads(junit(graded, AT))
    assert (int(root.get("failures", "0")) > 0) == (graded.score < graded.max_score)
    assert re.findall(r"::|##\[", junit(graded, AT)) == []


def keeps_rules_of_github(graded: Result) -> None:
    *told, total = as_the_runner_reads(github.commands(graded, Places(LAB)))
    assert total[2].startswith(f"{graded.score:g} / {graded.max_score:g}")
    assert bool(told) == (graded.score < graded.max_score and graded.status == "graded")
    assert total[0] == ("notice" if graded.status == "graded" else "error")
    page = rendered(github.summary(graded, LAB))
    assert page.names <= SUMMARY_TAGS
    assert {tag for tag, data in page.texts if "@someone" in data} <= {"pre", "code", "h4"}


def keeps_rules_of_gradescope(graded: Result) -> None:
    scope = read(gradescope(graded), GRADESCOPE)
    assert scope["score"] == graded.score
    for text in (scope["output"], *(test["output"] for test in scope["tests"])):
        assert Page(text).names <= {"p", "b", "pre"}


def keeps_rules_of_classroom50(graded: Result) -> None:
    assert read_classroom50(graded)["score"] == round(graded.score)


def keeps_rules_of_prairielearn(graded: Result) -> None:
    shown = read_prairielearn(prairielearn(graded))
    assert (shown["gradable"], shown["score"]) == (graded.status == "graded", graded.score / graded.max_score)
    assert bool(shown.get("format_errors")) != shown["gradable"]


def keeps_rules_of_json(graded: Result) -> None:
    assert read(to_json(graded), SCHEMA)["score"] == graded.score


@pytest.mark.parametrize("graded", CLASS.values(), ids=CLASS)
@pytest.mark.parametrize("platform", registry.names("respond"))
def test_every_answer_keeps_the_rules_of_its_platform_for_each_of_a_class(platform: str, graded: Result) -> None:
    """A new platform that answers wants a function here, `keeps_rules_of_<its name>`."""
    globals()[f"keeps_rules_of_{platform}"](graded)


@pytest.mark.parametrize("graded", CLASS.values(), ids=CLASS)
@pytest.mark.parametrize("platform", sorted({*registry.names("respond")} - {"json"}))
def test_every_answer_names_the_students_guide_once_where_something_was_lost(platform: str, graded: Result) -> None:
    """Not `json`, the result as it is: programs read it."""
    record, handed = registry.platform(platform), ResultContext(LAB, submission("one"), Path(), ID)
    for respond in filter(None, (record.respond, record.aside.text if record.aside else None)):
        text = html.unescape(respond(graded, handed))
        assert text.count("open guide.html, in your starter files") == (graded.score < graded.max_score)


def test_hostile_text_is_told_as_text() -> None:
    lost_, *_ = as_the_runner_reads(github.commands(evil(), Places(LAB)))
    assert "::error file=/etc/passwd::owned" in lost_[2]
    assert " %0A%3A ::stop" in lost_[2]
    assert "<img src=x onerror=alert(1)>" in rendered(github.summary(evil(), LAB)).text
    assert "]]></failure><evil/>" in str(as_jenkins_reads(junit(evil(), AT)).findtext("testsuite/testcase/failure"))


# --- which platform ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("environ", "folder", "name"),
    [
        ({"GITHUB_ACTIONS": "true"}, "", "github"),
        ({"GITHUB_ACTIONS": "true", **ID}, "", "classroom50"),
        ({}, "autograder/submission", "gradescope"),
        ({}, "grade/student", "prairielearn"),
        ({}, "", "junit"),
    ],
)
def test_the_platform_is_recognised(tmp_path: Any, environ: dict[str, str], folder: str, name: str) -> None:
    (tmp_path / folder).mkdir(parents=True, exist_ok=True)
    assert recognise(environ, tmp_path).name == name
