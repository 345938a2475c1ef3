"""Charts of a report, made of the answers that the student's code gave while it was graded; nothing more is asked."""

from __future__ import annotations

import numpy as np

from grader.engine.chart_data import Chart
from grader.engine.traces import Traces
from grader.labs.imu.charts import drawn, filtering, handed_in, motion, noise
from grader.labs.imu.student import Student


def charts(student: Student, truth: Traces) -> tuple[Chart, ...]:
    """Return the charts of a report; with hidden traces, only the handed-in pictures, as other charts may show hidden data."""
    pictures = tuple(handed_in.chart(name, student.stored_answer(name)) for name in student.pictures)
    if truth.name != "public":
        return tuple(chart for chart in pictures if chart is not None)
    with np.errstate(all="ignore"):  # a student's numbers may overflow
        found = (
            motion.chart(student.stored_answer("push"), truth["push"]),
            *drawn.charts(student.stored_answer("plot"), student.drawings()),
            *pictures,
            *noise.charts(student.stored_answer("noise"), truth),
            filtering.chart(student.stored_answer("filter"), truth["filter"]),
        )
    return tuple(chart for chart in found if chart is not None)
