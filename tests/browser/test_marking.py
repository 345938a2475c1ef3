"""The page to mark a sample on, in a real browser without a network: what is typed is saved as a file that the command reads."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Browser, expect

from grader.course.calibration import calibrating
from grader.course.calibration.marks import Mark
from grader.course.record.store import Store
from grader.labs.imu.lab import LAB
from tests.browser.conftest import PHONE, Watched, complaints, width_on_a_phone
from tests.desk import PNG, Student, make_class
from tests.test_desk import HOSTILE_FILES

CLASS = (Student("ada", files={"filters.py": b"x = 1\n", "imu_data.png": PNG}), Student("evil", files=HOSTILE_FILES))


def test_marks_typed_offline_come_back_as_a_file_and_a_closed_page_keeps_a_draft(
    browser: Browser, tmp_path: Path
) -> None:
    out = make_class(tmp_path / "out", CLASS)
    calibrating.write_sample(LAB, out, tmp_path / "sample", 12)
    pages = Watched(browser, f"{(tmp_path / 'sample').as_uri()}/", ("file:", "blob:"), offline=True)
    page = pages.open("marking.html")
    ada = page.locator("section:has(fieldset[data-id=ada])")
    ada.get_by_label("Points in Filtering").fill("13.5")
    ada.get_by_label("Reason in Filtering").fill('=1, "quoted"; ü')
    ada.get_by_role("button", name="Full points").click()
    ada.get_by_label("Points in Noise model").fill("")
    expect(page.locator("#done")).to_have_text("4 of 10 fields have points, not saved yet")
    page.on("dialog", lambda question: question.accept())
    page.reload()
    assert pages.troubles == [""]  # it asked before it left
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the marks").click()
    expect(page.locator("#done")).to_have_text("4 of 10 fields have points")
    saved.value.save_as(tmp_path / "marks.csv")
    with Store.existing(out) as store:
        found = calibrating.read(store, tmp_path / "marks.csv").cells
    full = {("ada", part): Mark(20, 20, 20) for part in ("sensor_access", "data_collection", "visualization")}
    assert found == {**full, ("ada", "filtering"): Mark(13.5, 13.5, 13.5, '=1, "quoted"; ü')}
    pages.close()
    page = Watched(browser, f"{(tmp_path / 'sample').as_uri()}/", ("file:",), bypass_csp=True).open("marking.html")
    assert complaints(page) == []
    assert width_on_a_phone(page) == PHONE["width"]
    page.context.close()
