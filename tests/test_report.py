from __future__ import annotations

import base64
import hashlib
import io
import re
from collections.abc import Mapping
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from rich.console import Console

from grader import words
from grader.answers import Drawing
from grader.evidence import Chart
from grader.exhibits import drawn
from grader.people.standing import Adjustment, HandIn, Lateness, Person, Standing
from grader.report.pages import index_page, report_page
from grader.report.progress import Lines
from grader.report.terminal import show
from grader.results import Outcome, Result
from tests.made_up import HOSTILE, check, lost, result

HOSTILE_RESULT = result(
    lost(title=HOSTILE, message=f"Expected  {HOSTILE}\nGot  {HOSTILE}", hint=HOSTILE),
    name=HOSTILE,
    notes=(HOSTILE,),
)


def terminal(made: Result, *, width: int = 90, only: str | None = None, colour: bool = False) -> str:
    out = io.StringIO()
    system = "truecolor" if colour else None
    console = Console(file=out, width=width, force_terminal=colour, color_system=system, highlight=False)  # type: ignore[arg-type]
    show(made, console, only=only)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


class Tags(HTMLParser):
    """Every tag with its attributes, and the text between them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


def report(made: Result, *charts: Chart) -> str:
    return report_page(Standing("x", made), charts)


def index(results: Mapping[str, Result]) -> str:
    return index_page({id_: Standing(id_, made) for id_, made in results.items()})


def hostile_charts() -> list[Chart]:
    """A student's words wherever a figure has words, and a colour that is none."""
    line = {"label": HOSTILE, "colour": '"><script>', "kind": "line", "visible": True, "n": 3, "x": "x", "y": "y"}
    axes = {"title": HOSTILE, "xlabel": HOSTILE, "ylabel": HOSTILE, "visible": True, "curves": [line]}
    legend = [{"text": HOSTILE, "colour": '"><script>'}]
    figure = {"event": "saved", "size_px": [640, 480], "title": HOSTILE, "xlabel": "", "ylabel": "", "legends": []}
    facts = {**figure, "axes": [{**axes, "legend": legend}]}
    drawing = Drawing((facts,), {"x": np.arange(3.0), "y": np.arange(3.0)}, ())
    return [replace(chart, part="sensor_access") for chart in drawn.charts(drawing, [])]


def hostile_standing(id_: str) -> Standing:
    person = Person(name=HOSTILE, section=HOSTILE)
    given = Adjustment("sensor_access", 1.0, HOSTILE, HOSTILE, "2026-11-21T21:00:00+00:00", {})
    return Standing(id_, HOSTILE_RESULT, HandIn((person,), late=Lateness("", 3600, 1, 2.0)), (given,))


PAGES = [
    report_page(hostile_standing("x"), tuple(hostile_charts())),
    index_page({"x": hostile_standing("x"), "y": Standing("y", result())}),
]


def test_the_terminal_tells_a_lost_check_with_the_labels_in_their_order() -> None:
    assert terminal(result(lost(title="Reads the right sensor when the model's sensors are in another order"))) == (
        "Sensor access                                                                        0 / 6\n"
        " ✗ lost       Reads the right sensor when the model's sensors are in another order   0 / 6\n"
        "   Expected  accel ≈ [ 0.412 -0.031 -9.702] m/s²\n"
        "   Got       accel = [ 1.000  0.412 -0.031]\n"
        "   Try       data.sensordata is flat: sensor i starts at model.sensor_adr[i], not at i\n"
        "   Read      Lab 04-01, Step 2          Again   imugrade check --only sensor_access\n"
        "\n"
        "Extension: allan variance                                                     1 of 1 shown\n"
        " ✓ earned     Reads the right sensor\n"
        "\n"
        "Score                                                                                0 / 6"
    )


def test_a_command_stays_in_one_line_to_copy_where_the_terminal_is_narrow() -> None:
    shown = terminal(result(lost()), width=80)
    assert "   Read      Lab 04-01, Step 2\n   Again     imugrade check --only sensor_access\n" in shown


def test_a_submission_with_nothing_to_mark_is_told_once_and_not_for_every_check() -> None:
    said = "Nothing recognisable was handed in: no Python file and no notebook was found."
    rows = [check("skipped", 0.0, message=said) for _ in range(5)]
    for only in (None, "sensor_access"):
        shown = terminal(result(*rows, status="empty", notes=("No .py or .ipynb file was found.",)), only=only)
        assert shown.startswith(
            "Note  No .py or .ipynb file was found.\nNothing that the lab asks for was found in this submission."
        )
        assert said not in shown


def test_an_earned_check_is_one_line_on_the_terminal() -> None:
    assert terminal(result(check(lab_step=2)), only="sensor_access") == (
        "Sensor access                                                                        6 / 6\n"
        " ✓ earned     Reads the right sensor                                                 6 / 6\n"
    )


OUTCOMES: list[tuple[Outcome, str]] = [
    ("passed", "earned"),
    ("partial", "partly"),
    ("failed", "lost"),
    ("error", "raised"),
    ("timeout", "timed out"),
    ("crashed", "crashed"),
    ("skipped", "skipped"),
    ("not_judged", "not judged"),
]


@pytest.mark.parametrize(("outcome", "word"), OUTCOMES)
def test_every_outcome_has_its_word_on_the_terminal_and_on_the_page(outcome: Outcome, word: str) -> None:
    points = None if outcome == "not_judged" else 0.0
    made = result(check(outcome, points))
    assert word in terminal(made)
    assert word in Tags(report(made)).text


def test_points_that_are_open_are_a_dash_and_not_a_zero() -> None:
    made = result(check("not_judged", None), check(points=3.0), status="incomplete")
    assert re.search(r"Sensor access +– / 12\n", terminal(made))
    assert re.search(r"Score +– / 12$", terminal(made))
    assert "Those points are open, not lost." in Tags(report(made)).text
    assert ">–<" in index({"a": made})


def test_a_message_keeps_its_plain_sentences_and_its_further_lines() -> None:
    message = "It raised.\nGot  ValueError: no\n  imu_reader.py, line 14\nExpected a number"
    assert words.row(check("error", 0.0, message=message), "filtering").lines == (
        words.Line("", "It raised."),
        words.Line("Got", "ValueError: no\nimu_reader.py, line 14"),
        words.Line("", "Expected a number"),
    )


@pytest.mark.parametrize(("outcome", "word"), OUTCOMES)
def test_what_to_read_and_to_run_stands_where_points_were_lost_and_nowhere_else(outcome: Outcome, word: str) -> None:
    shown = terminal(result(check(outcome, None if outcome == "not_judged" else 0.0, lab_step=2)))
    assert ("Again" in shown) == ("Lab 04-01, Step 2" in shown) == (word not in ("earned", "skipped", "not judged"))


def test_hostile_text_reaches_the_terminal_as_text() -> None:
    shown = terminal(HOSTILE_RESULT, width=300, colour=True)
    assert "[bold]x[/bold]" in shown
    assert "\\x1b[31m\\u202e" in shown
    assert "\x1b[31m\\" not in shown
    assert "\u202e" not in shown


@pytest.mark.parametrize("page", PAGES, ids=("report", "index"))
def test_hostile_text_reaches_a_page_as_text(page: str) -> None:
    read = Tags(page)
    assert "<script>alert(1)</script>[bold]x[/bold]\\x1b[31m\\u202e{{ 7 * 7 }}" in read.text
    assert page.count("<script") == page.count("</script") == ('id="filters"' in page)
    assert not set("\x1b\u202e") & set(page)


@pytest.mark.parametrize("page", PAGES, ids=("report", "index"))
def test_a_page_fetches_nothing_and_has_no_handler_in_its_tags(page: str) -> None:
    read = Tags(page)
    assert {tag for tag, _ in read.tags}.isdisjoint({"link", "img", "iframe", "object", "embed", "base"})
    for tag, attributes in read.tags:
        assert not [
            name for name in attributes if name.startswith("on") or name in ("src", "style", "srcset", "xlink:href")
        ], tag
        assert not (attributes.get("href") or "").startswith(("http", "javascript", "data", "//"))
    assert "url(" not in page
    assert "@import" not in page


@pytest.mark.parametrize("page", PAGES, ids=("report", "index"))
def test_the_policy_of_a_page_allows_its_own_style_sheet_and_script_and_nothing_else(page: str) -> None:
    def digest(tag: str) -> str:
        inlined = re.search(rf"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        assert inlined is not None
        return f"'sha256-{base64.b64encode(hashlib.sha256(inlined[1].encode()).digest()).decode()}'"

    policy = next(attributes for tag, attributes in Tags(page).tags if attributes.get("http-equiv"))
    script = f"; script-src {digest('script')}" if "<script" in page else ""
    wanted = (
        f"default-src 'none'; style-src {digest('style')}; img-src data:{script}; base-uri 'none'; form-action 'none'"
    )
    assert policy["content"] == wanted


def test_tampering_is_told_to_the_instructor_and_not_to_the_student() -> None:
    made = result(lost(misconceptions=("tampering", "off-by-one-address")))
    assert "tampering" not in report(made)
    assert "off by one address" in report(made)
    assert "tampering" in index({"a": made})


def test_the_seed_is_not_on_a_page() -> None:
    made = Result("a", "graded", (), provenance={"seed": 424242, "python": "3.11.7"})
    assert "424242" not in report(made)
    assert "3.11.7" in report(made)


def test_the_index_links_each_report_and_counts_the_class() -> None:
    page = index({"a": result(name="Ann"), "b b": result(lost(), name="Bob")})
    hrefs = [attributes["href"] or "" for tag, attributes in Tags(page).tags if tag == "a"]
    table = page[page.index('<table id="submissions"') : page.index("What was misunderstood")]
    assert [attributes["href"] for tag, attributes in Tags(table).tags if tag == "a"] == [
        "submissions/a/report.html",
        "submissions/b%20b/report.html",
    ]
    assert {href for href in hrefs if href[0] != "#"} == {"submissions/a/report.html", "submissions/b%20b/report.html"}
    text = Tags(page).text
    assert "2 submissions" in text
    assert re.search(r"mean\s*10\s*median\s*10\s*lowest\s*0\s*highest\s*20", text)
    assert re.search(r"sensor id as address\s*1\s*Bob", text)


def test_the_distribution_is_told_in_words_as_well() -> None:
    page = index({str(i): made for i, made in enumerate([result(), result(), result(lost())])})
    label = next(attributes["aria-label"] for tag, attributes in Tags(page).tags if attributes.get("role") == "img")
    assert label == "0–2 points: 1; 18–20 points: 2"


def test_an_empty_class_has_an_index() -> None:
    assert "0 submissions" in Tags(index({})).text


def test_what_cost_points_is_told_first_with_what_to_try() -> None:
    page = report(result(check(), lost(max_points=2.0, title="A small loss", hint=""), lost(title="A large loss")))
    head = Tags(page[page.index("What cost points") : page.index('id="sensor_access"')]).text
    assert re.search(
        r"−6\s*A large loss\s*data.sensordata is flat: sensor i starts at model.sensor_adr\[i\], not at i\s*−2\s*A small loss",
        head,
    )
    skipped = Tags(report(result(lost(), check("skipped", 0.0, id="sensor_access.b", message="Needs a reader.")))).text
    assert re.search(r"−6\s*1 check not reached\s*Each names what it needs\.", skipped)
    assert "What cost points" not in report(result())
    assert "Every check of the criteria was earned." in report(result())


def test_points_by_hand_and_lateness_stand_beside_the_automatic_marks() -> None:
    given = Adjustment("sensor_access", 5.0, "Shown in the lab.", "Ada", "2026-11-21T21:00:00+00:00", {})
    standing = Standing(
        "x", result(lost()), HandIn((Person("Bob", section="Tue"),), late=Lateness("", 90000, 2, 1.5)), (given,)
    )
    text = Tags(report_page(standing)).text
    assert "0 / 6" in text
    assert re.search(
        r"Sensor access\s*5 / 6 given by Ada in place of 0: Shown in the lab\.\s*Late\s*1 d 1 h, −1\.5 points\s*Final\s*3\.5 / 6",
        text,
    )
    row = Tags(index_page({"x": standing})).text
    assert re.search(r"Bob\s*Tue\s*5\s*0\s*1 d 1 h\s*3\.5\s*graded, adjusted", row)
    assert "Points given by hand whose automatic marks have changed since: Bob." in row


def test_a_report_without_charts_says_where_there_are_some() -> None:
    assert "drawn of public scenarios alone" in report(result())
    assert "drawn of public scenarios alone" not in report(result(), *hostile_charts())


def test_marks_of_two_rubrics_in_one_class_are_told() -> None:
    other = replace(result(), provenance={**result().provenance, "rubric_sha256": "f" * 64})
    assert "Not marked alike: this class holds marks of 2 rubrics." in Tags(index({"a": result(), "b": other})).text
    assert "Not marked alike" not in index({"a": result(), "b": result()})


def test_equal_results_give_equal_pages() -> None:
    assert report(result(lost())) == report(result(lost()))


def test_in_a_pipe_every_submission_is_one_plain_line(capsys: pytest.CaptureFixture[str]) -> None:
    with Lines() as lines:
        lines.begins(3)
        lines.done("alice", result(check(points=87.5)), resumed=False)
        lines.done("bob", result(lost(), status="empty"), resumed=True)
        lines.done("eve\n", result(check("not_judged", None), status="incomplete"), resumed=False)
    assert capsys.readouterr().out == "1/3 alice 87.5\n2/3 bob 0 (empty) (on record)\n3/3 eve\\x0a not judged\n"
