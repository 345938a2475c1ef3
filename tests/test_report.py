"""Tests of the report pages and the terminal report."""

from __future__ import annotations

import base64
import hashlib
import io
import re
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from grader.engine.chart_data import Chart
from grader.engine.faults import catalogue
from grader.engine.figures import Axes, Curve, Entry, Figure, VisibleParts
from grader.engine.results import Deducted, ExtensionResult, LabName, Result, from_dict, to_record
from grader.labs.imu.answers import Drawing
from grader.labs.imu.charts import drawn
from grader.labs.imu.lab import LAB
from grader.people.final_grade import Adjustment, FinalGrade, HandIn, Lateness, Person
from grader.report import overview, words
from grader.report.pages import index_page, report_page
from grader.report.terminal import screen, show_line
from tests.fake_results import HOSTILE, check, lost, result
from tests.pages import Page


def terminal(made: Result, *, width: int = 90, colours: str | None = "auto", **how: Any) -> str:
    """What a terminal shows: its letters, and with truecolor its codes."""
    out = io.StringIO()
    console = Console(file=out, width=width, force_terminal=True, color_system=colours, highlight=False)  # type: ignore[arg-type]
    for line in screen(made, console, LAB, **how):
        show_line(line, console)
    return out.getvalue() if colours == "truecolor" else re.sub(r"\x1b\[[0-9;]*m", "", out.getvalue())


def report(made: Result, *charts: Chart) -> str:
    return report_page(FinalGrade("x", made), charts)


def index(results: Mapping[str, Result]) -> str:
    return index_page({id_: FinalGrade(id_, made) for id_, made in results.items()})


def hostile_charts() -> list[Chart]:
    """A student's words wherever a figure has words, and a colour that is none."""
    colour, x = '"><script>', np.arange(3.0)
    seen = VisibleParts(np.ones(100, bool), np.ones(100, bool))
    line = Curve(HOSTILE, colour, "line", 3, x, x, "-", "None", "", 1.0, (colour,), 1.5, seen)
    legend = (Entry(HOSTILE, colour, "-", "None", ""),)
    ends = (0.0, 1.0)
    axes = Axes(
        True, (*ends, *ends), HOSTILE, HOSTILE, HOSTILE, legend, (), (line,), ends, ends, (HOSTILE, HOSTILE), own_ticks=False
    )  # fmt: skip
    figure = Figure("saved", HOSTILE, "png", (640, 480), (axes,), title=HOSTILE)
    return [replace(chart, part="sensor_access") for chart in drawn.charts(Drawing((figure,)), [])]


HOSTILE_RESULT = result(
    lost(title=HOSTILE, message=f"Expected  {HOSTILE}\nGot  {HOSTILE}", hint=HOSTILE), name=HOSTILE, notes=(HOSTILE,)
)
HOSTILE_GRADE = FinalGrade(
    "x",
    HOSTILE_RESULT,
    HandIn((Person(name=HOSTILE, section=HOSTILE),), late=Lateness("", 3600, 1, 2.0)),
    (Adjustment("sensor_access", 1.0, HOSTILE, HOSTILE, "2026-11-21T21:00:00+00:00", {}),),
)
PAGES = report_page(HOSTILE_GRADE, hostile_charts()), index_page({"x": HOSTILE_GRADE, "y": FinalGrade("y", result())})


def test_code_that_does_not_run_comes_first_with_what_it_costs() -> None:
    rows = (
        lost(title="A wrong value", lab_step=2),
        check("error", 0.0, title="Code that raises", lab_step=3, message="Expected  a series\nGot       NameError"),
        check("skipped", 0.0, message="Not reached"),
        check("skipped", 0.0, message="Not reached"),
    )
    assert terminal(replace(result(*rows), extensions=()), width=80) == (
        "Does not run\n"
        "\n"
        " ✗ raised   Code that raises                                               0 / 6\n"
        "   Expected  a series\n"
        "   Got       NameError\n"
        "   Costs     18 points now, because 2 more checks could not run. Everything else\n"
        "             was graded without it.\n"
        "   Read      Lab 04-01, Step 3\n"
        "\n"
        " ✗ Sensor access  ░░░░░░░░░░░░░░░░░░░░  0 / 24\n"
        "   Score                                0 / 24\n"
        "\n"
        "Next  Step 3, get_imu_readings\n"
        "\n"
        " ✗ failed   A wrong value                                                  0 / 6\n"
        "   Expected  accel ≈ [ 0.412 -0.031 -9.702] m/s²\n"
        "   Got       accel = [ 1.000  0.412 -0.031]\n"
        "   Try       data.sensordata is flat: sensor i starts at model.sensor_adr[i],\n"
        "             not at i\n"
        "\n"
        " – skipped  2 checks, 12 points: not graded until the checks above are fixed\n"
        "\n"
        "Rerun  imugrade check --only sensor_access\n"
        "All lines  imugrade check -v\n"
        "Help  open guide.html, in your starter files\n"
    )


def test_points_gained_and_lost_since_the_last_check_are_marked() -> None:
    now = result(
        check(id="sensor_access.a", title="Gained"),
        lost(id="sensor_access.b", title="Lost"),
        check(id="sensor_access.c"),
    )
    rows = terminal(now, before={"sensor_access.a": 0.0, "sensor_access.b": 3.0, "sensor_access.c": 6.0}).splitlines()
    assert rows[0].endswith("12 / 18  +3")
    assert [row.split("  ")[-1] for row in rows if "Score" in row] == ["+3 since the last check"]
    assert [row.split() for row in rows if "was" in row] == [
        ["✓", "passed", "Gained", "6", "/", "6,", "was", "0"],
        ["✗", "failed", "Lost", "0", "/", "6,", "was", "3"],
    ]
    assert sum("✓ passed" in row for row in rows) == 1


def test_at_84_of_100_the_screen_has_forty_lines_at_most() -> None:
    """Three faults, four earned criteria; words as long as the longest of the lab's."""
    long = "a sentence of a check that is a little longer than one line of a terminal that has a hundred columns"
    lost_ = [
        lost(title=f"{n}, {long}", hint=f"{n} {long}.", misconceptions=(f"fault-{n}",), max_points=5.33) for n in "abc"
    ]
    passed = [check(max_points=84.01, points=84.01)]
    made = replace(result(*passed, *lost_), extensions=())
    assert len(terminal(made, width=100).splitlines()) + len(("checking …", "files", "checks", "")) <= 40
    assert terminal(made, width=100).endswith(
        "All lines  imugrade check -v\nHelp  open guide.html, in your starter files\n"
    )
    assert "All lines" not in terminal(made, width=100, verbose=True)


@pytest.mark.parametrize("status", ["empty", "unreadable"])
def test_the_guide_is_named_where_nothing_could_be_graded_and_not_where_nothing_is_lost(status: Any) -> None:
    none = replace(result(name="lab", status=status), criteria=(), extensions=())
    assert terminal(none) == f"lab: {words.STATUS[status]}\n\nHelp  open guide.html, in your starter files\n"
    assert "guide.html" not in terminal(result())


OUTCOMES = {"error": "raised", "timeout": "timed out", "not_judged": "not judged"}
OUTCOMES |= {each: each for each in ("passed", "partial", "failed", "crashed", "skipped")}


@pytest.mark.parametrize(("outcome", "word"), OUTCOMES.items())
def test_every_outcome_has_its_word_on_the_terminal_and_on_the_page(outcome: Any, word: str) -> None:
    points = None if outcome == "not_judged" else 0.0
    made = result(check(outcome, points))
    assert word in terminal(made, only="sensor_access")
    assert word in Page(report(made)).text


def test_points_that_are_open_are_a_dash_and_not_a_zero() -> None:
    made = result(check("not_judged", None), check(points=3.0), status="incomplete")
    assert re.search(r"\? Sensor access +– / 12\n", terminal(made))
    assert re.search(r"Score +– / 12\n", terminal(made))
    assert "Those points are open; they are not lost." in Page(report(made)).text
    assert ">–<" in index({"a": made})


def test_a_message_keeps_its_plain_sentences_and_its_further_lines() -> None:
    got = "ValueError: no\nEvil  x\nGot       nothing"
    raised = check("error", 0.0, expected="no exception", got=got)
    lines = (words.LabelledLine("Expected", "no exception"), words.LabelledLine("Got", got))
    assert words.row(raised, "filtering", LabName()).lines == lines
    plain = check("skipped", 0.0, said="Needs a reader.")
    assert words.row(plain, "filtering", LabName()).lines == (words.LabelledLine("", "Needs a reader."),)
    assert plain.message == "Needs a reader."


def test_hostile_text_reaches_the_terminal_as_text() -> None:
    shown = terminal(HOSTILE_RESULT, width=300, colours="truecolor")
    assert "[bold]x[/bold]" in shown
    assert "\\x1b[31m\\u202e" in shown
    assert "\x1b[31m\\" not in shown
    assert "\u202e" not in shown


def digest(page: str, tag: str) -> str:
    """What a policy names what stands in the only element of this kind by."""
    inlined = re.search(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
    assert inlined is not None
    return f"'sha256-{base64.b64encode(hashlib.sha256(inlined[1].encode()).digest()).decode()}'"


@pytest.mark.parametrize("page", PAGES, ids=("report", "index"))
def test_a_page_shows_hostile_text_as_text_and_fetches_and_allows_nothing_that_is_not_its_own(page: str) -> None:
    read = Page(page)
    assert "<script>alert(1)</script>[bold]x[/bold]\\x1b[31m\\u202e{{ 7 * 7 }}" in read.text
    assert page.count("<script") == page.count("</script") == 1
    assert not set("\x1b\u202e") & set(page)
    assert read.names.isdisjoint({"link", "img", "iframe", "object", "embed", "base"})
    for tag, attributes in read.tags:
        assert attributes.keys().isdisjoint({"src", "style", "srcset", "xlink:href"}), tag
        assert not [name for name in attributes if name.startswith("on")], tag
        assert not (attributes.get("href") or "").startswith(("http", "javascript", "data", "//"))
    assert "url(" not in page
    assert "@import" not in page
    policy = next(attributes for tag, attributes in read.tags if attributes.get("http-equiv"))
    assert policy["content"] == (
        f"default-src 'none'; style-src {digest(page, 'style')}; img-src data:; script-src {digest(page, 'script')}; "
        "base-uri 'none'; form-action 'none'"
    )


def test_a_student_is_told_neither_of_tampering_nor_the_seed() -> None:
    made = result(lost(misconceptions=("tampering", "off-by-one-address")))
    assert "tampering" not in report(made)
    assert "Off by one address" in report(made)
    assert "tampering" in index({"a": made})
    page = report(Result("a", "graded", (), provenance={"seed": 424242, "python": "3.11.7"}))
    assert ("424242" in page, "3.11.7" in page) == (False, True)


def test_the_index_links_each_report_and_counts_the_class() -> None:
    page = index({"a": result(name="Ann"), "b b": result(lost(), name="Bob")})
    reports = ["submissions/a/report.html", "submissions/b%20b/report.html"]
    table = page[page.index('<table id="submissions"') : page.index('<h2 id="checks"')]
    assert [attributes["href"] for tag, attributes in Page(table).tags if tag == "a"] == reports
    hrefs = [attributes["href"] or "" for tag, attributes in Page(page).tags if tag == "a"]
    assert {href for href in hrefs if href[0] != "#"} == set(reports)
    text = Page(page).text
    assert "2 submissions" in text
    assert re.search(r"mean of graded\s*10\s*median\s*10\s*lowest\s*0\s*highest\s*20", text)
    assert re.search(r"sensor id as address\s*1\s*Bob", text)


def test_the_class_table_uses_every_field_of_its_rows() -> None:
    template = Path(overview.__file__).parent / "templates" / "class_table.html.j2"
    used = re.findall(r"\bentry\.(\w+)", template.read_text(encoding="utf-8"))
    assert {each.name for each in fields(overview.Entry)} == set(used)


def test_a_report_has_a_form_for_a_regrade_request_and_sends_nothing_by_itself() -> None:
    page = report_page(FinalGrade("a <b>", result(check(), lost())))
    form = next(attributes for tag, attributes in Page(page).tags if tag == "form")
    own = {"data-submission": "a <b>", "data-lab": "Lab 04-01"}
    assert form == {"id": "regrade", "class": "request", "hidden": None, **own}
    options = [attributes["value"] for tag, attributes in Page(page).tags if tag == "option"]
    assert options == ["", "sensor_access.follows_address", "sensor_access.follows_address"]
    assert "Request a regrade" not in report_page(FinalGrade("", result()))


def losses(page: str) -> str:
    """What stands before the criteria."""
    return Page(page[page.index('id="deductions"') : page.index('id="sensor_access"')]).text


def test_what_cost_points_is_told_first_by_cause_the_dearest_first() -> None:
    small = lost(
        max_points=2.0, title="A small loss", id="sensor_access.a", misconceptions=(), hint="", message="Got  x"
    )
    large = [lost(title=f"A large loss {name}", id=f"sensor_access.{name}") for name in "bc"]
    told = losses(report_page(FinalGrade("x", result(check(), small, *large)), (), catalogue(LAB)))
    assert re.search(
        r"−12\s*Uses the sensor's id as its place in sensordata\s*data\.sensordata is one flat array[^−]*"
        r"A large loss b\s*0 / 6\s*Expected[^−]*A large loss c\s*0 / 6\s*Try\s*data\.sensordata is flat: sensor i starts[^−]*"
        r"Rerun\s*imugrade check --only sensor_access\s*−2\s*A small loss\s*✗failed\s*A small loss",
        told,
    )
    assert told.count("accel ≈ ") == told.count("Try") == 1
    assert "Deductions" not in report(result())
    assert "All checks passed." in report(result())


def test_a_fault_has_one_entry_with_what_it_costs_where_and_the_check_that_tells_first() -> None:
    """`told` costs half of a check beside `other`, and a whole one that says nothing of it."""
    silent = Deducted("told", 1.0, "Do this.")
    told, other = (
        Deducted("told", 0.5, "Do this.", "", "one", "another"),
        Deducted("other", 0.25, "Do that.", "It is odd."),
    )
    both = check("partial", 1.5, "Expected  one", id="sensor_access.b", title="Both", deducted=(told, other))
    checks = (check("failed", 0.0, "Broken.", id="sensor_access.a", title="Silent", deducted=(silent,)), both)
    page = report(from_dict(to_record(result(*checks))))
    assert re.search(
        r"−9\s*Both\s*◐partial\s*Both\s*−3\s*Expectedone\s*Gotanother\s*✗failed\s*Silent\s*0 / 6\s*TryDo this\.[^−]*"
        r"−1\.5\s*Both\s*◐partial\s*Both\s*−1\.5\s*NoteIt is odd\.\s*TryDo that\.",
        losses(page),
    )
    assert page.count('id="sensor_access-b"') == 1


def test_a_submission_that_could_not_be_opened_says_why_and_has_no_rows() -> None:
    row = check("skipped", 0.0, message="It could not be opened.")
    page = report(result(row, row, status="unreadable", notes=("It is no zip archive.",)))
    text = Page(page).text
    assert "This submission could not be opened. It is no zip archive." in text
    assert text.count("It is no zip archive.") == 1
    assert 'id="sensor_access"' not in page


def test_points_by_hand_and_lateness_stand_beside_the_automatic_marks_and_the_final_ones_lead() -> None:
    given = Adjustment("sensor_access", 5.0, "Shown in the lab.", "Ada", "2026-11-21T21:00:00+00:00", {})
    late = Lateness("2026-11-20T20:00:00+00:00", 86_401, 2, 1.5)  # an hour that has begun counts
    hand_in = HandIn((Person("Bob", section="Tue"),), submitted="2026-11-21T21:00:00+00:00", late=late)
    final_grade = FinalGrade("x", result(lost()), hand_in, (given,))
    page = report_page(final_grade)
    text = Page(page).text
    assert re.search(r"Bob\s*3\.5 / 6 · automatic 0 / 6", text)
    assert re.search(r"Sensor access\s*5 / 6 override by Ada, automatic 0: Shown in the lab\.", text)
    assert re.search(
        r"−1\.5\s*Late\s*1 d 1 h; due 2026-11-20 20:00 UTC; handed in 2026-11-21 21:00 UTC; counted as 2 days late",
        losses(page),
    )
    assert 'class="fill" width="83.3"' in page  # the bar shows the points that count
    sound = report_page(FinalGrade("x", result(), hand_in))
    assert re.search(r"Deductions\s*−1\.5\s*Late\s*1 d 1 h; due 2026-11-20 20:00 UTC", losses(sound))
    assert "All checks passed." not in sound
    row = Page(index_page({"x": final_grade})).text
    assert re.search(r"Bob\s*Tue\s*5\s*0\s*1 d 1 h\s*3\.5\s*graded, adjusted", row)
    assert "Overrides whose automatic points have changed since: Bob." in row


def test_a_lost_check_is_explained_once_and_its_criterion_links_there_an_extension_where_it_stands() -> None:
    page = report(result(check(), lost(title="Lost", id="sensor_access.a")))
    its_criterion = page[page.index('<section id="sensor_access"') :]
    assert page.count("accel ≈ ") == 1
    assert "accel ≈ " not in its_criterion
    assert re.search(r'<h3><a href="#[^"]+">Lost</a></h3>', its_criterion)
    tried = ExtensionResult("allan_variance", True, 0.0, (lost(title="Lost", id="allan_variance.a"),))
    page = report(replace(result(), extensions=(tried,)))
    assert "accel ≈ " in page[page.index('<section id="allan_variance"') :]


def test_a_page_says_why_it_has_no_charts_and_that_a_class_is_long_or_was_graded_with_two_rubrics() -> None:
    alice = result()
    assert "This page has no charts" in Page(report(alice)).text
    assert "This page has no charts" not in PAGES[0]
    assert 'id="rest"' in index({f"s{n}": alice for n in range(201)})
    assert 'id="rest"' not in PAGES[1]
    other = replace(alice, provenance={**alice.provenance, "rubric_sha256": "f" * 64})
    told = "These results are not comparable: the class was graded with 2 rubrics."
    assert told in Page(index({"a": alice, "b": other})).text
    assert "not comparable" not in index({"a": alice, "b": alice})
