"""The class page of 2,000 in Chromium: first paint, and a sort until it is drawn: ``python -m tests.benchmarks.pages [N]``."""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from playwright.sync_api import sync_playwright

from grader.report.pages import index_page
from tests.browser.conftest import CHROMIUM, STUDENTS, final_grade

_PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
_SORT = """heading => new Promise(done => {
    const buttons = Array.from(document.querySelectorAll("#submissions th button"));
    const start = performance.now();
    buttons.find(button => button.textContent.trim() === heading).click();
    requestAnimationFrame(() => setTimeout(() => done(performance.now() - start)));
})"""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.pages", description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=2000)
    count = parser.parse_args().count
    final_grades = {
        f"s{number:05}": replace(final_grade(number % STUDENTS), id=f"s{number:05}") for number in range(count)
    }
    begun = time.perf_counter()
    page = index_page(final_grades)
    print(f"{count} rows: made in {time.perf_counter() - begun:.2f} s, {len(page) / 1e6:.2f} MB")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        Path(folder, "index.html").write_text(page, encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=CHROMIUM)
        tab = browser.new_context(offline=True, viewport={"width": 1400, "height": 900}).new_page()
        tab.goto(Path(folder, "index.html").as_uri())
        print(f"first paint {tab.evaluate(_PAINT) / 1000:.2f} s")
        for heading in ("Score", "Name", "Final"):
            print(f"sorted by {heading} in {tab.evaluate(_SORT, heading) / 1000:.2f} s")
        browser.close()


if __name__ == "__main__":
    main()
