"""The pages in a real browser: Debian's Chromium, as `.ci/run` installs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.conftest import PHONE, STUDENTS, Watched, complaints, width_on_a_phone

INDEX, REPORT, BY_HAND = "index.html", "submissions/real/report.html", "submissions/s09/report.html"


def column(page: Page, heading: str) -> list[str]:
    """The cells that are shown below a heading of the class table, from top to bottom."""
    return page.evaluate(
        """heading => {
            const table = document.getElementById("submissions");
            const place = Array.from(table.tHead.rows[0].cells).findIndex(cell => cell.textContent.trim() === heading);
            return Array.from(table.tBodies[0].rows).filter(row => !row.hidden).map(row => row.cells[place].textContent.trim());
        }""",
        heading,
    )


# --- the class ------------------------------------------------------------------------------------------------------


def test_a_click_on_a_heading_sorts_and_a_second_one_the_other_way_and_a_word_filters(watched: Watched) -> None:
    page = watched.open(INDEX)
    before = [float(cell) for cell in column(page, "Score")]
    assert before != sorted(before)
    for order, scores in (("descending", sorted(before, reverse=True)), ("ascending", sorted(before))):
        page.locator("#submissions").get_by_role("button", name="Score").click()
        assert [float(cell) for cell in column(page, "Score")] == scores
        expect(page.locator("#submissions th[aria-sort]")).to_have_attribute("aria-sort", order)
    page.locator("#submissions").get_by_role("button", name="Name").click()
    expect(page.locator("#shown")).to_have_text("")
    for text, numbers in (("thu 1", (10, 12, 14, 16, 18)), ("no such name", ())):
        page.get_by_label("Find").fill(text)
        assert column(page, "Name") == [f"Student {number}" for number in numbers]
        expect(page.locator("#shown")).to_have_text(f"{len(numbers)} of {STUDENTS + 1}")


def test_a_fault_leads_to_those_who_have_it_and_a_name_to_the_report(watched: Watched) -> None:
    page = watched.open(INDEX)
    fault = page.get_by_role("button", name="variance as std")
    fault.click()
    assert column(page, "Name") == ["s09-variance-as-std"]
    expect(page.locator("select#fault")).to_have_value(fault.get_attribute("data-only") or "")
    expect(fault).to_have_attribute("aria-pressed", "true")
    page.locator("#submissions").get_by_role("link", name="s09-variance-as-std").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("s09-variance-as-std")
    expect(page.locator(".deductions h3").first).to_have_text(
        "Takes the standard deviation as a variance, or squares it"
    )
    page.locator(".check.brief a").first.click()
    expect(page.locator(".check:target h4")).to_have_text(
        "The noise of each sensor has the requested standard deviation"
    )
    expect(page.locator(".check:target")).to_be_in_viewport()


def test_a_check_leads_to_those_who_lost_points_on_it_and_a_second_click_back_to_all(watched: Watched) -> None:
    page = watched.open(INDEX)
    check = page.locator("#checks + p + .scroll").get_by_role("button", name="Reads what is there")
    check.click()
    lost = [number for number in range(STUDENTS) if number * 7 % 15 < 14]
    assert len(column(page, "Name")) == len(lost) < STUDENTS
    expect(page.locator("#filters")).to_be_in_viewport()
    check.click()
    assert len(column(page, "Name")) == STUDENTS + 1


def test_a_bar_leads_to_those_who_stand_in_it_and_goes_together_with_the_other_filters(watched: Watched) -> None:
    page = watched.open(INDEX)
    bars = page.locator(".distribution button")
    assert sum(int(text.split()[-1]) for text in bars.all_inner_texts()) == STUDENTS + 1
    bar = page.locator(".distribution").get_by_role("button", name="10–20 points")
    bar.focus()
    page.keyboard.press("Enter")
    assert {10.0 <= float(score) < 20.0 for score in column(page, "Final")} == {True}
    assert str(len(column(page, "Name"))) == bar.inner_text().split()[-1]
    page.get_by_label("Find").fill("no such name")
    assert column(page, "Name") == []
    page.get_by_role("button", name="Show everyone").click()
    expect(page.locator("#shown")).to_have_text("")
    assert len(column(page, "Name")) == STUDENTS + 1
    expect(bar).to_have_attribute("aria-pressed", "false")


# --- a report -------------------------------------------------------------------------------------------------------


def test_every_chart_is_drawn_inside_its_frame(watched: Watched) -> None:
    page = watched.open(REPORT)
    boxes = page.evaluate(
        """() => Array.from(document.querySelectorAll("svg.plane"), svg => {
            const frame = svg.getBoundingClientRect();
            const strokes = Array.from(svg.querySelectorAll(".stroke, path.bars"), each => each.getBoundingClientRect());
            const outside = strokes.filter(box => box.left < frame.left - 1 || box.right > frame.right + 1
                || box.top < frame.top - 1 || box.bottom > frame.bottom + 1);
            const widest = Math.max(...strokes.map(box => box.width));
            return { wide: frame.width, strokes: strokes.length, outside: outside.length, widest };
        })"""
    )
    assert len(boxes) == 11
    for box in boxes:
        assert box["wide"] > 300
        assert box["strokes"] >= 1
        assert box["outside"] == 0
        assert box["widest"] > 0.7 * box["wide"]


def test_without_scripts_the_class_page_is_whole_and_on_paper_no_control_is_printed(watched: Watched) -> None:
    page = watched.open(INDEX, java_script_enabled=False)
    expect(page.locator("#submissions tbody tr")).to_have_count(STUDENTS + 1)
    expect(page.get_by_label("Find")).to_be_hidden()
    watched.troubles.clear()  # Chromium says that the script was blocked, which is what was asked for
    page = watched.open(INDEX)
    page.emulate_media(media="print")
    expect(page.locator("nav")).to_be_hidden()
    expect(page.get_by_label("Find")).to_be_hidden()
    assert watched.open(REPORT).pdf(format="A4")[:5] == b"%PDF-"


# --- everyone -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", [INDEX, REPORT, BY_HAND])
def test_axe_finds_nothing_to_complain_of_and_a_phone_needs_no_sideways_scrolling(watched: Watched, path: str) -> None:
    page = watched.open(path, bypass_csp=True)
    assert complaints(page) == []
    assert width_on_a_phone(page) <= PHONE["width"]
    smallest = page.evaluate(
        """() => Math.min(...Array.from(document.querySelectorAll("main p, main td, main dd, main li, main h3"))
            .filter(each => each.offsetParent !== null).map(each => parseFloat(getComputedStyle(each).fontSize)))"""
    )
    assert smallest >= 12


def test_the_policy_stops_a_script_that_is_not_ours(watched: Watched) -> None:
    page = watched.open(REPORT)
    page.evaluate(
        "document.body.append(Object.assign(document.createElement('script'), {textContent: 'window.ran = 1'}))"
    )
    assert page.evaluate("window.ran") is None
    assert len(watched.troubles) == 1
    assert "Content Security Policy" in watched.troubles.pop()


def test_a_regrade_request_is_saved_as_a_file_and_prepared_as_an_e_mail(watched: Watched) -> None:
    page = watched.open("submissions/s09/report.html")
    form = page.locator("#regrade")
    form.get_by_label("Check").select_option(label="Reads what is there")
    form.locator("textarea").fill("The sign is that of the sheet, line 7.")
    with page.expect_download() as started:
        form.get_by_role("button", name="Save as a file").click()
    assert started.value.suggested_filename == "regrade-request-s09.json"
    assert json.loads(Path(started.value.path()).read_text(encoding="utf-8")) == {
        "submission": "s09",
        "check": "sensor_access.matches_truth",
        "text": "The sign is that of the sheet, line 7.",
    }
    mail = form.get_by_role("link", name="Open as an e-mail").get_attribute("href") or ""
    assert mail.startswith("mailto:?subject=Lab%2004-01%3A%20regrade%20request&body=Submission%3A%20s09")
    watched.troubles[:] = [each for each in watched.troubles if not each.startswith("blob:")]  # the file itself
