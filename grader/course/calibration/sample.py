"""Sample of a class for people to mark by hand without seeing grades: many faults, every criterion, some sound work."""

from __future__ import annotations

import base64
import hashlib
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace

from markupsafe import Markup

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.calibration.comparison import is_comparable
from grader.course.record.store import Store
from grader.course.record.submission_archive import source, unpack, unshowable
from grader.engine.chart_data import Chart
from grader.engine.lab import Lab
from grader.engine.results import Result
from grader.intake.names import is_code
from grader.report.pages import drawn

DEFAULT_SIZE = 12
_SOUND = 0.25
"""Share of the sample that has full points: a marker who finds faults in it shows faults that we miss."""
_MOST_LINES, _LONGEST_LINE = 1500, 300
_MOST_PICTURES = 4


@dataclass(frozen=True)
class BlindSubmission:
    """A submission as shown to a person who marks it by hand: code, pictures and figures, nothing of the grader's result.

    `files` are pairs of path and text with line numbers, `pictures` pairs of path and submitted PNG in base64. `figures` is the
    HTML of the curves that the code drew while it was graded.
    """

    id: str
    files: tuple[tuple[str, str], ...]
    pictures: tuple[tuple[str, str], ...]
    figures: Markup


def draw(results: Mapping[str, Result], size: int) -> list[str]:
    """Return at most `size` ids of submissions to mark by hand, the same for the same results, in an order that reveals no grade.

    Only graded submissions without repairs are chosen, because people mark the files as handed in. A quarter of `size` have full
    points, if there are enough. The rest are chosen one by one, for faults and lost points that the sample has rarely or not yet.

    Raises
    ------
    RequestError
        If no submission was graded without repairs.
    """
    able = {id_: results[id_] for id_ in sorted(results, key=_shuffled) if is_comparable(results[id_])}
    if not able:
        raise RequestError("the class has no submission that is graded as it was handed in; grade it first")
    left = {
        id_: {*each.misconceptions, *(c.id for c in each.criteria if c.points < c.max_points)}
        for id_, each in able.items()
    }
    chosen = [id_ for id_, result in able.items() if result.score >= result.max_score][: math.ceil(size * _SOUND)]
    shown = Counter(feature for id_ in chosen for feature in left.pop(id_))
    while left and len(chosen) < size:
        best = max(left, key=lambda id_: sum(1 / (1 + 3 * shown[feature]) for feature in left[id_]))
        shown.update(left.pop(best))
        chosen.append(best)
    return sorted(chosen, key=_shuffled)


def _shuffled(id_: str) -> str:
    return hashlib.sha256(f"calibrate {id_}".encode("utf-8", "replace")).hexdigest()


def to_mark(store: Store, lab: Lab, id_: str, result: Result) -> BlindSubmission:
    """Return a submission for a person to mark without seeing its grade, the lab sheet's files first.

    `result` is its current result, whose digest finds the stored files; if the database lacks them, no files are shown.
    """
    kept = unpack(store.files(str(result.provenance.get("submission_sha256", "")))).files
    first = [name for name in lab.files if name in kept]
    kept = {path: kept[path] for path in (*first, *sorted(kept.keys() - set(first)))}
    files = tuple(
        (printable(path), _numbered(source(path, content))) for path, content in kept.items() if is_code(path)
    )
    pictures = [(path, content) for path, content in kept.items() if not unshowable(content)][:_MOST_PICTURES]
    encoded = tuple((printable(path), base64.b64encode(content).decode()) for path, content in pictures)
    figures = drawn(filter(None, map(_without_remarks, store.charts(id_))))
    return BlindSubmission(id_, files, encoded, Markup().join(map(Markup, figures.values())))


def _numbered(text: str) -> str:
    lines = text.rstrip("\n").split("\n")
    shown = [f"{n:4}  {printable(line, _LONGEST_LINE, newlines=True)}" for n, line in enumerate(lines[:_MOST_LINES], 1)]
    return "\n".join([*shown, *([f"… and {len(lines) - _MOST_LINES} more lines"] if len(lines) > _MOST_LINES else [])])


def _without_remarks(chart: Chart) -> Chart | None:
    """Keep only the curves that the student's code drew in a chart; None if there are none, as the others show the solution."""
    panels = [
        replace(panel, curves=tuple(curve for curve in panel.curves if curve.role == "drawn")) for panel in chart.panels
    ]
    seen = tuple(panel for panel in panels if panel.curves)
    return replace(chart, panels=seen, caption="", png="") if seen else None
