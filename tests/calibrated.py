"""The twenty submissions of `corpus/calibration`, marked twice by hand: `python -m tests.calibrated` prints how far we are from the marks."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from grader.course.calibration import comparison
from grader.course.calibration.marks import Marks, read_marks
from grader.engine.results import Result
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from tests.recordings.marker import RecordedMarker, without_charts

FOLDER = Path(__file__).parent / "corpus" / "calibration"
TABLE = FOLDER / "agreement.txt"
"""The table as it was last regenerated; the page on fairness quotes it."""


@cache
def results() -> Mapping[str, Result]:
    """Grade the twenty from recordings."""
    marker = RecordedMarker(without_charts())
    return {folder.name: marker.mark(read_submission(folder, LAB.files)) for folder in _folders()}


def _folders() -> list[Path]:
    return sorted(path for path in FOLDER.iterdir() if path.is_dir())


def marks(found: Mapping[str, Result]) -> Sequence[Marks]:
    """Read what both markers gave, independently of each other and before anything graded them."""
    most = comparison.maxima(found)
    return [read_marks(FOLDER / f"marks-{number}.csv", str, most) for number in (1, 2)]


def cells() -> list[comparison.ComparedCell]:
    """Compare the twenty with both markers' marks."""
    return comparison.compare(results(), marks(results()))


def table() -> str:
    """Return the table that the page on fairness shows."""
    return "\n".join([*comparison.table(comparison.by_criterion(cells())), ""])


def main() -> int:
    argparse.ArgumentParser(prog="python -m tests.calibrated", description=__doc__).parse_args()
    print(table())
    for cell in comparison.differing(cells()):
        told = ", ".join(f"{mark.points:g} ({mark.low:g} to {mark.high:g})" for mark in cell.marks)
        out = " outside" if cell.is_outside else ""
        print(
            f"{cell.id} {cell.criterion.id}: we {cell.criterion.points:g}, they {told}; {cell.kind}{out}; {', '.join(cell.faults)}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
