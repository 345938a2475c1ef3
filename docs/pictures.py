"""Take the pictures of the documentation from the product: `python -m docs.pictures`, two minutes. Look at each of them.

They show the example class, its review desk, and how `calibrate` compares it with two markers. The browser is Chromium, as in the
tests of the pages.
"""

from __future__ import annotations

import argparse
import io
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

FOLDER = Path(__file__).resolve().parent
EXAMPLES = FOLDER.parent / "submissions_example"
MARKED = FOLDER.parent / "tests" / "corpus" / "calibration"
"""Twenty submissions with the marks of two persons."""
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
_LARGEST = 150_000
"""Bytes of a picture: a page with all of them loads in seconds on a slow network."""


def main() -> int:
    argparse.ArgumentParser(prog="python -m docs.pictures", description=__doc__).parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        out, marked = Path(folder) / "out", Path(folder) / "marked"
        _run("grade", EXAMPLES, "-o", out)
        _run("grade", MARKED, "-o", marked)
        _run("calibrate", marked, "--sample", "12")
        _run("calibrate", marked, "--marks", MARKED / "marks-1.csv", "--marks", MARKED / "marks-2.csv")
        browser = playwright.chromium.launch(executable_path=next(filter(None, map(shutil.which, BROWSERS))))
        page = browser.new_page()
        _take_reports(page, out)
        with _desk(out) as address:
            _take_desk(page, address)
        _take_calibration(page, marked / "calibration")
        browser.close()
    return 0


def _run(*words: str | Path) -> None:
    subprocess.run([sys.executable, "-m", "grader", *words], check=True)


def _take_reports(page: Page, out: Path) -> None:
    page.goto((out / "index.html").as_uri())
    _save(page, "pictures/class.png", 1000, 1510)
    page.goto((out / "submissions" / "s06-id-as-address" / "report.html").as_uri())
    _save(page, "students/report.png", 840, 912)


def _take_desk(page: Page, address: str) -> None:
    """Take what the tutorial does: a repair that is previewed and not saved, and a deduction of another size."""
    page.goto(address)
    _save(page, "pictures/desk.png", 1000, 700)
    page.get_by_role("link", name="Repair", exact=False).last.click()
    code = page.get_by_role("textbox", name="imu_reader.py")
    last = "        angular_velocities[i] = gyro\n"
    code.fill(code.input_value().replace(last, f"{last}        i += 1\n"))
    page.get_by_role("button", name="Preview grade").click()
    form = page.get_by_role("group", name="Save the repair")
    form.get_by_label("Deduct").fill("5")
    form.get_by_label("Comment", exact=True).fill("The loop did not count: i += 1 was missing.")
    _save(page, "pictures/repair.png", 800, 935, top="Edit imu_reader.py")
    page.get_by_role("link", name="Rubric what-if").click()
    page.get_by_label("no units").fill("1")
    page.get_by_role("button", name="Preview changes").click()
    _save(page, "pictures/what-if.png", 1000, 710)


def _take_calibration(page: Page, folder: Path) -> None:
    page.goto((folder / "marking.html").as_uri())
    _save(page, "pictures/calibrate-marking.png", 1100, 900)
    page.goto((folder / "comparison.html").as_uri())
    _save(page, "pictures/calibrate-comparison.png", 1100, 1040)
    _save(page, "pictures/calibrate-differences.png", 1100, 1025, top="cells differ")


@contextmanager
def _desk(out: Path) -> Iterator[str]:
    """Run the review desk over a class; the address that it prints lets a browser in."""
    command = [sys.executable, "-m", "grader", "review", out, "--author", "Ada"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield next(line.strip() for line in process.stdout if line.startswith("http"))
        finally:
            process.terminate()


def _save(page: Page, name: str, width: int, height: int, top: str = "") -> None:
    """Save what a window of this size shows from its top, or from the heading `top`.

    In 256 colours the picture has a third of the bytes, and the eye misses nothing.
    """
    page.set_viewport_size({"width": width, "height": height})
    page.wait_for_load_state("networkidle")
    if top:
        page.get_by_role("heading", name=top).evaluate("it => it.scrollIntoView()")
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shot.quantize(256, dither=Image.Dither.NONE).save(FOLDER / name, optimize=True)
    size = (FOLDER / name).stat().st_size
    print(f"{name}: {size:,} bytes")
    if size >= _LARGEST:
        raise SystemExit(f"{name}: {size:,} bytes; take less of the page")


if __name__ == "__main__":
    sys.exit(main())
