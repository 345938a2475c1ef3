from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

from grader.engine.chart_data import unpacked
from grader.engine.faults import catalogue
from grader.engine.grader import Marker
from grader.engine.results import CriterionResult
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.people.final_grade import Adjustment, FinalGrade, HandIn, Lateness, Person
from grader.report.pages import index_page, report_page
from tests.desk import Desk
from tests.examples import FOLDER
from tests.fake_results import HOSTILE, check, lost, result

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next(filter(None, map(shutil.which, BROWSERS)), None)
"""The shell first: a page in it takes a third of the work, as no window is made around it."""
STUDENTS = 36
PHONE = {"width": 320, "height": 640}
"""The narrowest that WCAG 2.2 asks for (1.4.10, reflow)."""


def final_grade(number: int) -> FinalGrade:
    """Scores from 0 to 20 in an order that is neither that of the names nor of the ids."""
    points = number * 7 % 15
    wrong = lost(id="sensor_access.matches_truth", title="Reads what is there", max_points=14.0)
    first = check(points=float(number % 7), outcome="partial" if number % 7 < 6 else "passed")
    second = replace(wrong, points=float(points), misconceptions=("sign-flipped",) if points < 3 else ())
    made = result(first, second, name=HOSTILE if number == 5 else f"Student {number}", duration_s=0.2 + number / 100)
    made = replace(made, criteria=(CriterionResult("sensor_access", "Sensor access", 20.0, made.criteria[0].checks),))
    person = Person(made.submission, section="Tue" if number % 2 else "Thu")
    late = Lateness("", 7200 * number, 1, 2.0) if number % 12 == 3 else None
    by_hand = (Adjustment("sensor_access", 11.0, "Shown.", "Ada", "2026-11-21T21:00:00+00:00", {}),) * (number == 9)
    return FinalGrade(f"s{number:02}", made, HandIn((person,), late=late), by_hand)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory, marker: Marker) -> Path:
    """A class on disk as `grade` leaves it: one submission really marked, with its charts, and made-up ones."""
    folder = tmp_path_factory.mktemp("out")
    marked = marker.mark(read_submission(FOLDER / "s09-variance-as-std", LAB.files))
    final_grades = {s.id: s for s in map(final_grade, range(STUDENTS))} | {"real": FinalGrade("real", marked)}
    for id_, each in final_grades.items():
        place = folder / "submissions" / id_
        place.mkdir(parents=True)
        charts = unpacked(each.result.evidence.charts)
        (place / "report.html").write_text(report_page(each, charts, catalogue(LAB)), encoding="utf-8")
    prints = {id_: tuple(range(60)) for id_ in ("s01", "s02")}
    (folder / "index.html").write_text(index_page(final_grades, prints), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """One browser for these tests alone: its event loop and its processes must be gone when the others run."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine: the pages are not looked at in a browser")
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=CHROMIUM)
        yield launched
        launched.close()


def complaints(page: Page) -> list[tuple[str, list[str]]]:
    """What axe finds: in light colours, and in dark ones by the rules about colours, for the rest is the same page."""
    page.emulate_media(color_scheme="light")
    found = Axe().run(page).response["violations"]
    page.emulate_media(color_scheme="dark")
    found += Axe().run(page, options={"runOnly": ["color-contrast", "link-in-text-block"]}).response["violations"]
    return [(each["id"], [node["html"][:160] for node in each["nodes"][:3]]) for each in found]


def width_on_a_phone(page: Page) -> int:
    """The width of what a page shows on a phone."""
    page.set_viewport_size(PHONE)
    width: int = page.evaluate("document.documentElement.scrollWidth")
    return width


class Watched:
    """Pages of a browser; what goes wrong in them is written down, and so is each address that does not begin as it may.

    `first` is an address that is opened before each page, and `options` are those of every page.
    """

    def __init__(self, browser: Browser, home: str, may: tuple[str, ...], first: str = "", **options: object) -> None:
        self._browser, self._home, self._may, self._first, self._options = browser, home, may, first, options
        self.troubles: list[str] = []

    def open(self, path: str, **options: object) -> Page:
        context = self._browser.new_context(**self._options, **options)  # type: ignore[arg-type]
        page = context.new_page()
        page.on("console", lambda message: self.troubles.append(message.text))
        page.on("pageerror", lambda error: self.troubles.append(str(error)))
        page.on("dialog", lambda dialog: self.troubles.append(dialog.message))
        page.on(
            "request", lambda request: self.troubles.extend([request.url] * (not request.url.startswith(self._may)))
        )
        if self._first:
            page.goto(self._first)
        page.goto(self._home + path)
        return page

    def close(self) -> None:
        for context in self._browser.contexts:
            context.close()


def at_the_desk(browser: Browser, desk: Desk) -> Watched:
    return Watched(browser, desk.origin, (f"{desk.origin}/", "data:"), first=desk.keys.first_address)


@pytest.fixture
def watched(browser: Browser, out: Path) -> Iterator[Watched]:
    """Pages that are opened from disk, without a network."""
    pages = Watched(browser, f"{out.as_uri()}/", ("file:",), offline=True)
    yield pages
    pages.close()
    assert pages.troubles == []
