"""`imugrade calibrate`: compare the grades with marks given by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import OutArgument, shown_path


def calibrate(
    out: OutArgument,
    *,
    sample: Annotated[
        int | None,
        typer.Option(
            "--sample", min=1, max=200, metavar="N", help="Draw N submissions to mark by hand; 12 is a good number."
        ),
    ] = None,
    marks: Annotated[
        list[Path] | None,
        typer.Option(
            "--marks", metavar="FILE", help="A person's marks, a CSV. Give the option again for a second person."
        ),
    ] = None,
    folder: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="DIR", help="Where the pages go. Default: OUT/calibration.")
    ] = None,
) -> int:
    """Measure how close the grades are to your own marks, and propose deductions for faults that would bring them closer.

    First draw a sample with --sample, and mark it on the page that is written. Then compare with --marks. Each run needs one of
    the two options, not both. No grade changes.

    \b
    Examples:
      imugrade calibrate out --sample 12 -o sample
      imugrade calibrate out --marks marks-a.csv --marks marks-b.csv
    """
    from grader.course.calibration import calibrating  # noqa: PLC0415
    from grader.course.run.classroom import lab_on_record  # noqa: PLC0415

    if (sample is None) == (not marks):
        raise RequestError("calibrate: give --sample N to draw submissions, or --marks FILE to compare")
    where = folder or out / calibrating.FOLDER
    if sample is not None:
        lines = calibrating.write_sample(lab_on_record(out), out, where, sample)
    else:
        lines = calibrating.write_comparison(lab_on_record(out), out, where, marks or [])
    for line in lines:
        print(line)
    print(f"written to {shown_path(where)}")
    return 0
