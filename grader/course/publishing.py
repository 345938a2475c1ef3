"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from grader.course.record import Store
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.mistakes import catalogue
from grader.engine.results import to_json
from grader.ground.files import write_whole
from grader.people.standing import Standing
from grader.platforms.gradebook import gradebook
from grader.report.pages import index_page, report_page


def publish_class(out: Path, store: Store, lab: Lab) -> dict[str, Standing]:
    """Write the gradebook and the index of everything on record, and return that."""
    standings = store.standings()
    write_class(out, standings, store, lab)
    return standings


def write_class(out: Path, standings: Mapping[str, Standing], store: Store, lab: Lab) -> None:
    """Write the gradebook and the index of these, which are everything on record."""
    write_whole(out / "gradebook.csv", gradebook(standings))
    write_whole(out / "index.html", index_page(standings, store.fingerprints(), of_the_sheet(lab)))


def publish(out: Path, standing: Standing, store: Store, lab: Lab) -> None:
    """Write the two files of one submission, unless they are current.

    `result.json` holds the automatic marks alone; the report is made from the whole standing. A digest of both is on record.
    """
    folder = out / "submissions" / standing.id
    known = store.page_digest(standing.id)
    if (folder / "report.html").is_file() and known == _digest(standing, _bytes(folder / "result.json")):
        return
    text = to_json(standing.result)
    write_whole(folder / "report.html", report_page(standing, store.charts(standing.id), catalogue(lab)))
    write_whole(folder / "result.json", text)
    store.keep_page_digest(standing.id, _digest(standing, text.encode()))


def _digest(standing: Standing, record: bytes) -> str:
    return hashlib.sha256(repr(standing).encode("utf-8", "replace") + record).hexdigest()


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""
