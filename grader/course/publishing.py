"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader import __version__
from grader.course.record import Store
from grader.engine.fingerprint import of_the_sheet
from grader.engine.lab import Lab
from grader.engine.mistakes import catalogue
from grader.engine.results import to_json
from grader.ground.files import write_whole
from grader.people.standing import Standing
from grader.platforms.gradebook import gradebook
from grader.report.pages import Drawn, drawn, drawn_in, index_page, report_around


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

    `result.json` holds the automatic marks alone; the report is made from the whole standing. Digests of both are on record. Charts
    stay as they stand in the report that is there, as long as they are those of the record.
    """
    folder = out / "submissions" / standing.id
    known = _Known.of(store.page_digest(standing.id))
    record = _record(folder / "result.json", standing, known)
    facts = _digest(record, repr((standing.hand_in, standing.adjustments, standing.unseen)))
    report = folder / "report.html"
    if report.is_file() and (known.record, known.report) == (record, facts):
        return
    packed = store.packed_charts(standing.id)
    there = drawn_in(_bytes(report).decode("utf-8", "replace"))
    same = (
        _of_figures(there, standing, packed) == known.figures
    )  # to draw them takes ten times as long as all the rest of a page
    page = report_around(there if same else drawn(store.charts(standing.id)), standing, catalogue(lab))
    write_whole(report, page)
    store.keep_page_digest(standing.id, f"{record} {facts} {_of_figures(drawn_in(page), standing, packed)}")


@dataclass(frozen=True)
class _Known:
    """Digests of what the files of a submission were made from, and of the charts in its report; "" where none is on record."""

    record: str = ""
    report: str = ""
    figures: str = ""

    @classmethod
    def of(cls, text: str) -> _Known:
        digests = text.split()
        return cls(*digests) if len(digests) == 3 else cls()


def _record(path: Path, standing: Standing, known: _Known) -> str:
    """Write `result.json` unless it is current; its digest."""
    result = repr(standing.result)
    there = _digest(result, _bytes(path))
    if there == known.record:
        return there
    text = to_json(standing.result).encode()
    write_whole(path, text)
    return _digest(result, text)


def _of_figures(figures: Drawn, standing: Standing, packed: bytes) -> str:
    """What they were drawn from, by which program, for which parts; and how they came out."""
    parts = [part.id for part in standing.result.parts if part.checks]
    return _digest(__version__, repr(parts), packed, *(figures[part] for part in parts if part in figures))


def _digest(*facts: str | bytes) -> str:
    digest = hashlib.sha256()
    for fact in facts:
        content = fact if isinstance(fact, bytes) else fact.encode("utf-8", "replace")
        digest.update(len(content).to_bytes(8, "little") + content)
    return digest.hexdigest()


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""
