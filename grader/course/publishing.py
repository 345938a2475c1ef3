"""The files of OUT, written from the record: pages and `result.json` of a submission, gradebook and index of the class."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
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

_AHEAD = 32
"""Submissions whose files wait for the disk: some four megabytes."""


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
    """Write the two files of one submission, unless they are current."""
    publish_all(out, [standing], store, lab)


def publish_all(out: Path, standings: Iterable[Standing], store: Store, lab: Lab) -> None:
    """Write the two files of each submission, unless they are current.

    `result.json` holds the automatic marks alone; the report is made from the whole standing. Digests of both are on record. Charts
    stay as they stand in the report that is there, as long as they are those of the record.
    """
    with ThreadPoolExecutor(
        1
    ) as disk:  # to put one file in another's place waits for the disk: the next is made meanwhile
        ahead: deque[tuple[str, str, Future[None]]] = deque()
        for standing in standings:
            files, digests = _due(out / "submissions" / standing.id, standing, store, lab)
            if files:
                ahead.append((standing.id, digests, disk.submit(_write, files)))
            if len(ahead) == _AHEAD:
                _keep(store, [ahead.popleft() for _ in range(_AHEAD // 2)])
        _keep(store, ahead)


def _write(files: Mapping[Path, bytes]) -> None:
    for path, content in files.items():
        write_whole(path, content)


def _keep(store: Store, written: Collection[tuple[str, str, Future[None]]]) -> None:
    for *_, done in written:
        done.result()
    if written:
        store.keep_page_digests({id_: digests for id_, digests, _ in written})


def _due(folder: Path, standing: Standing, store: Store, lab: Lab) -> tuple[dict[Path, bytes], str]:
    """The files of a submission that are not current, and the digests to keep once they are written."""
    known = _Known.of(store.page_digest(standing.id))
    record, report = folder / "result.json", folder / "report.html"
    result, files = store.digest(standing.id), {}
    made_from = _digest(result, _bytes(record))
    if made_from != known.record:
        files[record] = to_json(standing.result).encode()
        made_from = _digest(result, files[record])
    facts = _digest(made_from, repr((standing.hand_in, standing.adjustments, standing.unseen)))
    if report.is_file() and known.report == facts:
        return files, f"{known.record} {known.report} {known.figures}"
    packed = store.packed_charts(standing.id)
    figures, of_figures = drawn_in(_bytes(report).decode("utf-8", "replace")), known.figures
    drawn_anew = _of_figures(figures, standing, packed) != of_figures
    if drawn_anew:  # takes ten times as long as all the rest of a page
        figures = drawn(store.charts(standing.id))
    page = report_around(figures, standing, catalogue(lab))
    if drawn_anew:
        of_figures = _of_figures(drawn_in(page), standing, packed)
    files[report] = page.encode("utf-8", "replace")
    return files, f"{made_from} {facts} {of_figures}"


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
