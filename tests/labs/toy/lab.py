"""Lab 0, Temperatures: convert Fahrenheit to Celsius, and average a series."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from grader.engine.chart_data import Chart
from grader.engine.findings import StudentError, raised
from grader.engine.lab import Lab, Part
from grader.engine.question import Question
from grader.engine.replies import Answer, Called, Rule, checked
from grader.engine.submission_session import SubmissionSession
from grader.engine.traces import Scenario, Traces
from grader.sandbox.wire import Frame


class Student(SubmissionSession):
    """The proxy that the checks talk to."""

    def __init__(self, *args: Any, truth: Traces, **limits: Any) -> None:
        super().__init__(*args, lab_configuration={}, **limits)

    def call(self, name: str, values: np.ndarray) -> np.ndarray | None:
        """What the function makes of an array; None where no array of numbers came."""
        frame = self.answer(Question("call", name, lambda frame: frame, {"name": name}, {"values": values}))
        raised(StudentError.of(frame.fields.get("error")), f"calling {name}")
        value = frame.fields["value"]
        return frame.arrays[value["key"]] if value and "key" in value else None


class Call(Called, kw_only=True):
    """What the function returned."""

    value: Any


def _call(answer: Answer, reply: Call) -> None:
    answer.node(reply.value)


def _checked(op: str, frame: Frame, fields: Mapping[str, Any], arrays: Mapping[str, Any]) -> Frame:
    return checked(op, frame, fields, arrays, {"call": Rule(Call, _call)})


def _charts(student: SubmissionSession, truth: Traces) -> tuple[Chart, ...]:
    return ()


def _truth(seed: str | None, settings: Mapping[str, Any]) -> Traces:
    return TRUTH


LAB = Lab(
    module=__name__,
    id="toy",
    label="Lab 0",
    title="Temperatures",
    parts=(
        Part("conversion", "Conversion", ("to_celsius",), "convert.py"),
        Part("averaging", "Averaging", ("mean_celsius",), "average.py", needed=False),
    ),
    bonuses=(),
    student=Student,
    charts=_charts,
    checked=_checked,
    truth=_truth,
)
FAHRENHEIT = np.array([32.0, 212.0, -40.0, 98.6])
TRUTH = Traces(
    "public",
    "0" * 64,
    {"models": {}, "versions": {}},
    {},
    {"readings": Scenario("readings", "A few temperatures.", None, {}, {"fahrenheit": FAHRENHEIT})},
)
