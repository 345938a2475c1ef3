"""Take the pictures of the documentation from the product: `python -m docs.pictures`, two minutes. Look at each of them.

They show the example class: its page, a report, and the review desk. The browser is Chromium, as in the tests of the pages.
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
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
_LARGEST = 150_000
"""Bytes of a picture: a page with all of them loads in seconds on a slow network."""


def main() -> int:
    argparse.ArgumentParser(prog="python -m docs.pictures", description=__doc__).parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        out = Path(folder) / "out"
        subprocess.run([sys.executable, "-m", "grader", "grade", EXAMPLES, "-o", out], check=True)
        browser = playwright.chromium.launch(executable_path=next(filter(None, map(shutil.which, BROWSERS))))
        _take(browser.new_page(viewport={"width": 1000, "height": 760}), out)
        browser.close()
    return 0


def _take(page: Page, out: Path) -> None:
    page.goto((out / "index.html").as_uri())
    _save(page, "pictures/class.png")
    page.set_viewport_size({"width": 600, "height": 1160})
    page.goto((out / "submissions" / "s06-id-as-address" / "report.html").as_uri())
    _save(page, "students/report.png")
    page.set_viewport_size({"width": 1000, "height": 700})
    with _desk(out) as address:
        page.goto(address)
        _save(page, "pictures/desk.png")
        page.get_by_role("link", name="Repair", exact=False).last.click()
        _save(page, "pictures/repair.png")
        page.get_by_role("link", name="Rubric what-if").click()
        _save(page, "pictures/what-if.png")


@contextmanager
def _desk(out: Path) -> Iterator[str]:
    """Run the review desk over a class; the address that it prints lets a browser in."""
    command = [sys.executable, "-m", "grader", "review", out]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield next(line.strip() for line in process.stdout if line.startswith("http"))
        process.terminate()


def _save(page: Page, name: str) -> None:
    """Save what the window shows, in 256 colours: a third of the bytes, and nothing that the eye misses."""
    page.wait_for_load_state("networkidle")
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shot.quantize(256, dither=Image.Dither.NONE).save(FOLDER / name, optimize=True)
    size = (FOLDER / name).stat().st_size
    print(f"{name}: {size:,} bytes")
    if size >= _LARGEST:
        raise SystemExit(f"{name}: {size:,} bytes; take less of the page")


if __name__ == "__main__":
    sys.exit(main())
