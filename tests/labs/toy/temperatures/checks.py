"""The toy lab's checks."""

from __future__ import annotations

import numpy as np

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed
from grader.engine.traces import Traces
from tests.labs.toy.lab import Student


@check("conversion.known_points", lab_step=1)
def check_known_points(student: Student, truth: Traces) -> None:
    """to_celsius knows where water freezes and boils"""
    fahrenheit = truth["readings"]["fahrenheit"]
    got, wanted = student.call("to_celsius", fahrenheit), (fahrenheit - 32) / 1.8
    if got is None or got.shape != wanted.shape or np.abs(got - wanted).max() > 1e-9:
        forgot = got is not None and np.allclose(got, fahrenheit / 1.8)
        raise CheckFailed(
            f"{wanted[0]:g} °C", f"{got[0]:g} °C" if got is not None else "no array", faults=["no-offset"] * forgot
        )


@check("averaging.mean", lab_step=2)
def check_mean(student: Student, truth: Traces) -> None:
    """mean_celsius averages what to_celsius gives"""
    fahrenheit = truth["readings"]["fahrenheit"]
    got, wanted = student.call("mean_celsius", fahrenheit), ((fahrenheit - 32) / 1.8).mean()
    if got is None or abs(float(got) - wanted) > 1e-9:
        raise CheckFailed(f"{wanted:g} °C", "another number")
