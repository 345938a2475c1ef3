"""The repair editor of the review desk in a real browser: open, edit, preview, save and undo."""

from __future__ import annotations

from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, expect

from grader.desk import repair_jobs
from tests.browser.conftest import at_the_desk
from tests.class_commands import column
from tests.desk import Desk, desk_over
from tests.test_desk_repairs import SENTENCE, desk, out, pool_here  # noqa: F401 - fixtures


def test_what_is_typed_survives_other_pages_a_reload_and_a_restart_until_it_is_saved(
    browser: Browser,
    out: Path,  # noqa: F811 - a fixture
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(repair_jobs, "Pool", pool_here)
    edited, points = "# 1\n\n", "#override-filtering input[name=points]"
    with desk_over(out) as first:
        visit = at_the_desk(browser, first)
        page = visit.open("/submission/ada?edit=filters.py")
        page.get_by_role("textbox", name="filters.py").fill(edited)
        page.get_by_role("button", name="Preview grade").click()
        with page.expect_response("**/draft"):
            page.locator("form.editor").get_by_label("Comment", exact=True).fill("x was never set")
        page.get_by_role("link", name="Class", exact=True).click()
        page.goto(f"{first.origin}/submission/bob")
        page.locator("#override-filtering summary").click()
        with page.expect_response("**/draft"):
            page.locator(points).fill("7")
        page.get_by_role("link", name="Needs review", exact=True).click()
        expect(page.get_by_text("Typed, but not saved yet:")).to_have_text("Typed, but not saved yet: ada, bob")
        visit.close()
        assert visit.troubles == []
    with desk_over(out) as second:
        visit = at_the_desk(browser, second)
        page = visit.open("/")
        page.get_by_role("main").get_by_role("link", name="ada").first.click()
        expect(page.get_by_role("textbox", name="filters.py")).to_have_value(edited)
        expect(page.locator(".gutter li")).to_have_count(3)
        page.get_by_role("button", name="Preview grade").click()
        form = page.locator("form.editor")
        expect(form.locator("textarea[name=comment]")).to_have_value("x was never set", timeout=30_000)
        form.get_by_label("bob").uncheck()
        form.get_by_role("button", name="Save repair").click()
        expect(page.locator("main")).to_contain_text("94 points before")
        page.goto(f"{second.origin}/submission/bob")
        page.reload()
        expect(page.locator(points)).to_have_value("7")
        page.get_by_role("button", name="Discard").click()
        expect(page.locator(points)).to_have_value("")
        page.goto(f"{second.origin}/")
        expect(page.get_by_text("Typed, but not saved yet:")).to_have_count(0)
        visit.close()
        assert visit.troubles == []


def test_a_file_is_opened_edited_previewed_saved_and_the_repair_undone(
    browser: Browser,
    desk: Desk,  # noqa: F811 - a fixture
    out: Path,  # noqa: F811 - a fixture
) -> None:
    visit = at_the_desk(browser, desk)
    page = visit.open("/", bypass_csp=True)
    page.get_by_role("link", name="Repair").first.click()
    text = page.get_by_role("textbox", name="filters.py")
    expect(text).to_have_value("stops\n")
    expect(page.locator(".gutter .named")).to_have_text("1")
    expect(page.locator(".stops")).to_contain_text(SENTENCE.replace("&#39;", "'"))
    assert Axe().run(page).response["violations"] == []

    text.fill("# 1\n\n")
    expect(page.locator(".gutter li")).to_have_count(3)
    page.get_by_role("button", name="Preview grade").click()
    expect(page.locator(".compared .sum td")).to_have_text(["94", "100", "+6"])
    expect(page.get_by_role("textbox", name="filters.py")).to_have_value("# 1\n\n")
    assert column(out / "gradebook.csv", "total")["ada"] == "94"

    form = page.locator("form.editor")
    form.get_by_label("Deduct").fill("5")
    form.get_by_label("Comment", exact=True).fill("x was never set")
    form.get_by_label("bob").uncheck()
    form.get_by_role("button", name="Save repair").click()
    expect(page.locator("main")).to_contain_text("94 points before, 95 points now")
    desk.book.settled()
    assert column(out / "gradebook.csv", "total") == {"ada": "95", "bob": "94", "cyd": "97", "dan": "94"}

    page.get_by_role("button", name="Undo repair").click()
    expect(page.get_by_role("button", name="Undo repair")).to_have_count(0)
    desk.book.settled()
    assert column(out / "gradebook.csv", "total")["ada"] == "94"
    visit.close()
    assert visit.troubles == []
