"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from pathlib import Path

from grader.course.record import Store
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.results import to_json
from grader.ground.files import write_whole
from grader.people.standing import Standing
from grader.platforms.gradebook import gradebook
from grader.report.pages import index_page, report_page


def publish_class(out: Path, store: Store, lab: Lab) -> dict[str, Standing]:
    """Write the gradebook and the index of everything on record, and return that."""
    standings = store.standings()
    write_whole(out / "gradebook.csv", gradebook(standings))
    write_whole(out / "index.html", index_page(standings, store.fingerprints(), of_the_sheet(lab)))
    return standings


def publish(out: Path, standing: Standing, store: Store) -> None:
    """Write the two files of one submission, unless they are current.

    `result.json` holds the automatic marks alone; the report is made from the whole standing, whose digest is on record.
    """
    folder = out / "submissions" / standing.id
    text = to_json(standing.result)
    digest = hashlib.sha256(repr((text, standing.hand_in, standing.adjustments)).encode("utf-8", "replace")).hexdigest()
    current = (folder / "report.html").is_file() and _holds(folder / "result.json", text)
    if not current or store.page_digest(standing.id) != digest:
        write_whole(folder / "report.html", report_page(standing, store.charts(standing.id)))
        write_whole(folder / "result.json", text)
        store.keep_page_digest(standing.id, digest)


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False
