"""A graded class as a platform's upload: the marks, and the report of each student."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.errors import RequestError
from grader.files import write_whole
from grader.formats import canvas, moodle
from grader.formats.gradebook import gradebook
from grader.formats.gradescope_csv import gradescope_csv
from grader.formats.sheet import BOM
from grader.people.standing import Standing
from grader.store import Store
from grader.text import printable

FORMATS = ("csv", "canvas", "moodle", "gradescope")
TEMPLATED = {"canvas": canvas.fill, "moodle": moodle.fill}
MAX_TEMPLATE = 64_000_000
_STAMP = (2020, 1, 1, 0, 0, 0)  # the same results make the same bytes


@dataclass(frozen=True)
class Export:
    """What is to be written. `template` is the file that the platform exported, `feedback` a zip for the reports."""

    out: Path
    format: str
    target: Path | None = None
    template: Path | None = None
    column: str | None = None
    feedback: Path | None = None


@dataclass(frozen=True)
class Written:
    """What was written, and lines on who was left out."""

    told: tuple[str, ...]
    remarks: tuple[str, ...]


def export(order: Export) -> Written:
    """Write the marks, and with `feedback` the reports.

    Raises
    ------
    RequestError
        If nothing was graded in OUT, or the template is missing, not wanted or not the platform's.
    """
    if (order.format in TEMPLATED) != (order.template is not None):
        needs = "needs --template with the file that it exports" if order.template is None else "takes no --template"
        raise RequestError(f"--format {order.format} {needs}")
    with Store.existing(order.out) as store:
        standings = store.standings()
    target = order.target or order.out / f"{'gradebook' if order.format == 'csv' else order.format}.csv"
    data, grades, remarks = _marks(order, standings)
    write_whole(target, data)
    told = [f"{target}  {grades} grade{'s' * (grades != 1)}"]
    if order.feedback is not None:
        reports, absent = _feedback(order.out, standings)
        write_whole(order.feedback, reports)
        told.append(f"{order.feedback}  {len(standings) - len(absent)} reports")
        remarks += [f"no report for the platform to place: {', '.join(absent)}"] if absent else []
    return Written(tuple(told), tuple(remarks))


def _marks(order: Export, standings: Mapping[str, Standing]) -> tuple[bytes, int, list[str]]:
    if order.template is not None:
        source = printable(str(order.template), 500)
        filled = TEMPLATED[order.format](_bytes(order.template, source), source, order.column, standings)
        return filled.data, filled.grades, list(filled.left_out(standings))
    grades = sum(standing.final is not None for standing in standings.values())
    text = gradebook(standings) if order.format == "csv" else gradescope_csv(standings)
    mark = b"" if order.format == "csv" else BOM  # for a spreadsheet, which otherwise spoils umlauts
    return mark + text.encode("utf-8", "replace"), grades, []


def _bytes(path: Path, source: str) -> bytes:
    try:
        with open(path, "rb") as stream:
            data = stream.read(MAX_TEMPLATE + 1)
    except OSError as error:
        raise RequestError(
            f"{source}: cannot be read ({error.strerror}); give the file that the platform exports"
        ) from error
    if len(data) > MAX_TEMPLATE:
        raise RequestError(
            f"{source}: is larger than {MAX_TEMPLATE // 1_000_000} MB; give the file that the platform exports"
        )
    return data


def _feedback(out: Path, standings: Mapping[str, Standing]) -> tuple[bytes, list[str]]:
    """The reports under the names that the platform gave, and those of whom it gave none."""
    buffer = io.BytesIO()
    absent: list[str] = []
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for id_, standing in standings.items():
            report = out / "submissions" / id_ / "report.html"
            if not standing.hand_in.reply or not report.is_file():
                absent.append(printable(id_, 80))
                continue
            entry = zipfile.ZipInfo(f"{standing.hand_in.reply}report.html", _STAMP)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, report.read_bytes())
    return buffer.getvalue(), absent
