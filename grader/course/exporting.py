"""A graded class as a platform's upload: the marks, and the report of each student."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.course.publishing import outdated_pages
from grader.course.record import Store
from grader.ground.errors import RequestError
from grader.ground.files import write_whole
from grader.ground.text import printable
from grader.people.standing import Standing, given_out
from grader.platforms.platform import Fill, Platform

Marks = tuple[bytes, int, list[str]]  # the file, how many grades are in it, and who was left out
UNREADABLE = ("blank", "0")
MAX_TEMPLATE = 64_000_000
_STAMP = (2020, 1, 1, 0, 0, 0)  # the same results make the same bytes


@dataclass(frozen=True)
class Export:
    """What is to be written.

    `template` is the file that the platform exported, `feedback` a zip for the reports; `scaled` whether points follow what the
    platform's assignment is out of; `unreadable` one of `UNREADABLE`, for what could not be read or held nothing.
    """

    out: Path
    platform: Platform
    target: Path | None = None
    template: Path | None = None
    column: str | None = None
    feedback: Path | None = None
    scaled: bool = False
    unreadable: str = "blank"


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
        If nothing was graded in OUT, the platform takes no grades, the template is missing, not wanted or not the platform's, or
        reports that are asked for do not match the record.
    """
    marks = _way(order)
    with Store.existing(order.out) as store:
        standings = store.standings()
        sent = [each for each in standings.values() if order.feedback and each.hand_in.reply]
        outdated = outdated_pages(order.out, sent, store)
    if outdated:
        named = ", ".join(printable(id_, 80) for id_ in outdated[:5]) + ", …" * (len(outdated) > 5)
        raise RequestError(
            f"{order.out}: {len(outdated)} of {len(sent)} reports do not match the record ({named}); "
            "give the `imugrade grade` command again: it writes them anew"
        )
    if order.unreadable == "blank":
        standings = given_out(standings)
    target = order.target or order.out / order.platform.gradebook
    data, grades, remarks = marks(standings)
    write_whole(target, data)
    remarks = [*remarks, *_unread(standings)]
    told = [f"{target}  {grades} grade{'s' * (grades != 1)}"]
    if order.feedback is not None:
        reports, absent = _feedback(order.out, standings)
        write_whole(order.feedback, reports)
        told.append(f"{order.feedback}  {len(standings) - len(absent)} reports")
        remarks += [f"no report for the platform to place: {', '.join(absent)}"] if absent else []
    return Written(tuple(told), tuple(remarks))


def _unread(standings: Mapping[str, Standing]) -> list[str]:
    """What there was nothing to mark in, and what stands for it."""
    blank = [printable(id_, 80) for id_, each in standings.items() if each.unseen]
    told = "nothing in them could be marked: left blank until you have looked (adjust them, or give --unreadable 0)"
    return [f"{told}: {', '.join(blank)}"] if blank else []


def _way(order: Export) -> Callable[[Mapping[str, Standing]], Marks]:
    """How the platform gets the marks: its own file filled in, or one that is written."""
    fill, write, template = order.platform.fill, order.platform.write, order.template
    if fill is not None and template is not None:
        return lambda standings: _filled(fill, template, order, standings)
    if write is not None and template is None:
        return lambda standings: (write(standings), sum(each.final is not None for each in standings.values()), [])
    if fill is None and write is None:
        raise RequestError(f"--format {order.platform.name}: {order.platform.title} takes no grades")
    needs = "needs --template with the file that it exports" if template is None else "takes no --template"
    raise RequestError(f"--format {order.platform.name} {needs}")


def _filled(fill: Fill, template: Path, order: Export, standings: Mapping[str, Standing]) -> Marks:
    source = printable(str(template), 500)
    filled = fill(_bytes(template, source), source, order.column, standings, scaled=order.scaled)
    return filled.data, filled.grades, list(filled.left_out(standings))


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
