"""Pictures of *How to check us against yourself*, from a real run: `python -m tests.browser.calibration_pictures`, some minutes.

The class is `submissions_example` with the twenty submissions of `corpus/calibration`, the marks are those of both markers.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from grader import cli
from tests import calibrated, examples
from tests.browser.conftest import CHROMIUM
from tests.desk import desk_over

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"
_SIZE = {"width": 1100, "height": 760}
_COLOURS = 64
"""Colours of a picture: enough for text and dots, and a third of the bytes."""


def main() -> int:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        out = _graded(Path(folder))
        browser = playwright.chromium.launch(executable_path=CHROMIUM)
        page = browser.new_page(viewport=_SIZE)  # type: ignore[arg-type]
        page.goto((out / "calibration" / "marking.html").as_uri())
        page.locator("#s2 input").first.fill("14")
        page.get_by_role("link", name="2", exact=True).click()
        _save(page, "calibrate-marking")
        page.goto((out / "calibration" / "comparison.html").as_uri())
        _save(page, "calibrate-comparison")
        page.locator("#differences").scroll_into_view_if_needed()
        page.evaluate("document.getElementById('differences').scrollIntoView()")
        _save(page, "calibrate-differences")
        with desk_over(out, "Ada") as desk:
            page.goto(desk.keys.first_address)
            page.goto(f"{desk.origin}/calibrate")
            page.get_by_text("Begin").click()
            _save(page, "calibrate-desk")
        browser.close()
    return 0


def _graded(folder: Path) -> Path:
    """Grade the class, draw a sample and compare."""
    for path in (*examples.folders(), *(path for path in calibrated.FOLDER.iterdir() if path.is_dir())):
        shutil.copytree(path, folder / "class" / path.name)
    out = str(folder / "out")
    marks = [word for number in (1, 2) for word in ("--marks", str(calibrated.FOLDER / f"marks-{number}.csv"))]
    for command in (
        ["grade", str(folder / "class"), "-o", out],
        ["calibrate", out, "--sample", "12"],
        ["calibrate", out, *marks],
    ):
        assert cli.main(command) == 0, command
    return Path(out)


def _save(page: Page, name: str) -> None:
    path = PICTURES / f"{name}.png"
    page.screenshot(path=str(path))
    Image.open(path).convert("RGB").quantize(_COLOURS).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size:,} bytes")


if __name__ == "__main__":
    sys.exit(main())
