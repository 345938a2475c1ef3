"""The review desk in a real browser: keyboard alone, light and dark, a phone, without scripts, and with hostile submissions."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from grader.desk import app
from grader.engine.findings import Where
from grader.people.final_grade import HandIn, Lateness, Person
from tests.browser.conftest import PHONE, Watched, at_the_desk, complaints, width_on_a_phone
from tests.desk import FILTER, PNG, Desk, Student, desk_over, make_class
from tests.test_desk import ADDRESS, HOSTILE_FILES, MISTAKE, NASTY, TITLES

DESKTOP = {"width": 1280, "height": 720}
RAISED = {
    "expected": "no exception",
    "got": "TypeError at filters.py, line 2",
    "where": Where("filters.py", 2),
    "misconceptions": ("sensor-id-as-address",),
}
FILES = {**HOSTILE_FILES, "huge.py": b"a = 1\n" * 60}
"""axe needs a minute for a page with a thousand lines more."""
STUDENTS = (
    Student("ada", files={"filters.py": FILTER * 40, "imu_data.png": PNG}, prints=tuple(range(60))),
    Student("bob", {ADDRESS: 0.0, TITLES: 0.5}, {ADDRESS: RAISED}, {"filters.py": FILTER}, hand_in=HandIn((Person("Bob Bird"),), late=Lateness("", None))),
    Student("cyd", {ADDRESS: 0.5}, {ADDRESS: MISTAKE}, {"filters.py": FILTER * 40}, prints=tuple(range(60))),
    Student("evil", {ADDRESS: 0.0}, {ADDRESS: {"got": NASTY, "hint": NASTY}}, FILES, name=NASTY, notes=(NASTY,)),
    Student("open", {ADDRESS: None}, status="incomplete"),
    Student("void", status="empty", notes=("No .py or .ipynb file was found.",)),
)  # fmt: skip
PAGES = (
    *(path for path in app.PAGES if "{" not in path and path != "/find"),  # /find only redirects
    "/groups/fault/sensor-id-as-address", "/similar/ada/cyd", f"/what-if?weight:{ADDRESS}=14", "/calibrate?id=bob", "/calibrate?compare=yes", "/submission/bob", "/submission/ada", "/submission/void", "/submission/evil", "/submission/nobody",
)  # fmt: skip
SOME_PAGES = ("/", "/class", f"/what-if?weight:{ADDRESS}=14", "/submission/evil")


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    out = make_class(tmp_path_factory.mktemp("desk") / "out", STUDENTS, {"leftover": ["notes.txt"]})
    with desk_over(out) as opened:
        opened.post("/regrade-requests", {"text": "Please look at this again.", "who": "bob", "about": ADDRESS})
        opened.post("/submission/ada/override", {"target": "bonus", "points": "1", "comment": "neat", "seen": 0})
        opened.post("/calibrate", {"id": "bob", "points:sensor_access": "20", "comment:sensor_access": NASTY})
        yield opened


@pytest.fixture
def visit(browser: Browser, desk: Desk) -> Iterator[Watched]:
    pages = at_the_desk(browser, desk)
    yield pages
    pages.close()
    # a page that is asked for and not there
    troubles = [each for each in pages.troubles if "status of 400" not in each]
    assert troubles == []


def test_a_draft_that_comes_back_says_that_somebody_else_has_changed_the_points(visit: Watched, desk: Desk) -> None:
    page = visit.open("/submission/cyd")
    page.locator("#override-filtering summary").click()
    with page.expect_response("**/draft"):
        page.locator("#override-filtering input[name=points]").fill("7")
    page.reload()
    note = page.locator("#override-filtering .unsaved")
    expect(note).to_have_text("Not saved yet. Discard")
    fields = {
        "target": "filtering",
        "points": "12",
        "comment": "seen",
        "seen": desk.book.on_thread(desk.book.store.last_adjustment),
    }
    assert desk.post("/submission/cyd/override", fields, "Eve").status == 303
    page.reload()
    expect(note).to_contain_text("What this page shows was changed after you typed this")
    expect(page.locator("#override-filtering input[name=points]")).to_have_value("7")
    note.get_by_role("button", name="Discard").click()
    desk.post("/submission/cyd/override", {"target": "filtering", "do": "withdraw", "seen": 999})


@pytest.mark.parametrize("paths", [SOME_PAGES, pytest.param(PAGES, marks=pytest.mark.weekly)], ids=["some", "all"])
def test_axe_finds_nothing_to_complain_of_and_a_phone_needs_no_sideways_scrolling(
    visit: Watched, desk: Desk, paths: tuple[str, ...]
) -> None:
    page = visit.open("/", bypass_csp=True)
    found = {}
    for path in paths:
        page.set_viewport_size(DESKTOP)
        page.goto(desk.origin + path)
        found[path] = (complaints(page), max(width_on_a_phone(page), PHONE["width"]))
    assert found == dict.fromkeys(paths, ([], PHONE["width"]))


def test_a_doubtful_case_is_decided_without_a_mouse(visit: Watched, desk: Desk) -> None:
    page = visit.open("/submission/ada")
    page.keyboard.press("n")
    expect(page.get_by_role("heading", level=1)).to_have_text("Bob Bird")
    page.keyboard.press("b")
    expect(page.locator(f"#override-{ADDRESS.replace('.', '-')} input[name=points]")).to_be_focused()
    page.keyboard.type("4.5")
    page.keyboard.press("Tab")
    page.keyboard.type("pn: the letters of a key are only letters here")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator(".score")).to_contain_text("98")
    page.keyboard.press("t")
    expect(page.locator(".queue").first).to_contain_text("Reviewed by prof")
    page.keyboard.press("l")
    expect(page.get_by_role("heading", level=1)).to_have_text("cyd")
    assert desk.book.on_thread(lambda: desk.book.history("bob"))[-1].points == 4.5


def test_without_scripts_everything_can_still_be_decided(visit: Watched) -> None:
    page = visit.open("/submission/cyd", java_script_enabled=False)
    form = page.locator("#override-filtering")
    form.locator("summary").click()
    form.locator("input[name=points]").fill("19")
    form.locator("textarea").fill("untidy")
    form.get_by_role("button", name="Save").click()
    expect(page.locator("#override-filtering .given")).to_contain_text("19, automatic 20, by prof: untidy")


def test_the_class_page_searches_filters_and_sorts_and_a_student_is_found_from_every_page(visit: Watched) -> None:
    page = visit.open("/class")
    names = page.locator("#submissions tbody tr:visible th a")
    expect(names).to_have_count(6)
    page.locator("#find").fill("bird")
    expect(names).to_have_text(["Bob Bird"])
    page.locator("#find").fill("")
    page.locator("select#status").select_option(label="empty (1)")
    expect(names).to_have_text(["void"])
    page.get_by_role("button", name="Show everyone").click()
    page.locator("#submissions").get_by_role("button", name="Name").click()
    assert names.all_inner_texts()[1:3] == ["ada", "Bob Bird"]
    page.locator("header input[name=who]").fill("bob")
    page.get_by_role("button", name="Open", exact=True).click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Bob Bird")
    page.locator("header input[name=who]").fill("bird")
    page.get_by_role("button", name="Open", exact=True).click()
    expect(names).to_have_text(["Bob Bird"])
