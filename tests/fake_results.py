"""Fake results, submissions and marker, for tests of what comes after grading."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grader.base.errors import GraderError
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Outcome, Result, Status
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.sandbox.isolation_levels import LEVELS, IsolationLevel

HOSTILE = "<script>alert(1)</script>[bold]x[/bold]\x1b[31m\u202e{{ 7 * 7 }}"
SHA = "0123456789abcdef" * 4


def said(message: str) -> dict[str, Any]:
    """What a check says, as its fields: what is labelled ``Expected`` and ``Got``, or else a sentence."""
    labelled = re.findall(r"^(Expected|Got) {2,}((?:.*(?:\n {10})?)*)", message, re.MULTILINE)
    return {label.lower(): text.strip("\n").replace("\n" + 10 * " ", "\n") for label, text in labelled} or {
        "said": message
    }


def check(outcome: Outcome = "passed", points: float | None = 6.0, message: str = "", **more: object) -> CheckResult:
    values: dict[str, object] = {
        "id": "sensor_access.follows_address",
        "title": "Reads the right sensor",
        "max_points": 6.0,
    }
    return CheckResult(outcome=outcome, points=points, **{**values, **said(message), **more})  # type: ignore[arg-type]


def lost(**more: object) -> CheckResult:
    values: dict[str, object] = {
        "message": "Expected  accel ≈ [ 0.412 -0.031 -9.702] m/s²\nGot  accel = [ 1.000  0.412 -0.031]",
        "hint": "data.sensordata is flat: sensor i starts at model.sensor_adr[i], not at i",
        "lab_step": 2,
        "misconceptions": ("sensor-id-as-address",),
    }
    return check("failed", 0.0, **{**values, **more})


def result(
    *checks: CheckResult,
    name: str = "alice",
    status: Status = "graded",
    notes: tuple[str, ...] = (),
    duration_s: float = 0.31,
) -> Result:
    """One submission with one criterion of the given checks, and an extension that was tried."""
    checks = checks or (check(), check(id="sensor_access.matches_truth", points=14.0, max_points=14.0))
    full = round(sum(each.max_points for each in checks), 2)
    extension = ExtensionResult(
        "allan_variance", True, 0.0, (check(id="allan_variance.white_noise", max_points=0.0, points=0.0),)
    )
    return Result(
        submission=name,
        status=status,
        lab=LabName(LAB.label, LAB.title),
        criteria=(CriterionResult("sensor_access", "Sensor access", full, checks),),
        extensions=(extension,),
        notes=notes,
        provenance={"grader": "0.1.0", "rubric_sha256": SHA, "isolation": "full", "seed": 0},
        duration_s=duration_s,
    )


def submission(id_: str) -> Submission:
    return Submission(id_, id_, {}, (), "ready", SHA)


@dataclass
class FakeMarker:
    """Does what the submission's id says."""

    folder: Path
    isolation: IsolationLevel = LEVELS[0]
    pid: int = field(default_factory=os.getpid)

    def mark(self, submission: Submission, cpu_s: float | None = None, *, only: str | None = None) -> Result:
        with open(self.folder / "marked", "a", encoding="utf-8") as log:
            log.write(f"{submission.id} {self.pid}\n")
        if submission.id.startswith("kill") or (submission.id.startswith("once") and self._first(submission.id)):
            os.kill(self.pid, signal.SIGKILL)
        if submission.id.startswith("wait"):
            threading.Event().wait(60)
        if submission.id.startswith("first wait"):
            threading.Event().wait(60) if self._first(submission.id) else os.kill(self.pid, signal.SIGKILL)
        if submission.id.startswith("interrupt"):
            threading.Event().wait(0.5)  # what came before it is recorded by then
            os.kill(os.getppid(), signal.SIGINT)
            threading.Event().wait(60)
        if submission.id.startswith("burn"):
            re.match(r"(a|a)*$", "a" * 64 + "b")  # never gives way to another thread
        if submission.id.startswith("fat"):
            self.hoard = bytearray(400 << 20)
            threading.Event().wait(60)
        if submission.id.startswith("bug"):
            raise GraderError("the zygote is gone")
        return result(name=submission.id)

    def _first(self, id_: str) -> bool:
        return (self.folder / "marked").read_text(encoding="utf-8").count(f"{id_} ") == 1

    def marked(self) -> list[str]:
        return [line.split()[0] for line in (self.folder / "marked").read_text(encoding="utf-8").splitlines()]


@contextmanager
def fake_marker(folder: Path) -> Iterator[FakeMarker]:
    yield FakeMarker(folder)
    (folder / f"closed-{os.getpid()}").touch()


class Nobody:
    """Is told how a class goes on, and does not listen."""

    def started(self, total: int) -> None: ...

    def done(self, id_: str, result: Result, *, resumed: bool) -> None: ...

    def pages(self, final_grades: Sequence[FinalGrade]) -> Sequence[FinalGrade]:
        return final_grades


def without_durations(value: Any) -> Any:
    """A record as it must be the same every time: durations are the clock's."""
    if isinstance(value, dict):
        return {key: without_durations(part) for key, part in value.items() if key != "duration_s"}
    return [without_durations(part) for part in value] if isinstance(value, list) else value
