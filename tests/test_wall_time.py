"""Waiting costs, too: a question that is kept just above the idle threshold, or answered after a sleep, pays for its time on the clock."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import pytest

from grader.base.errors import TimedOut
from grader.engine.submission_session import SubmissionSession
from grader.labs.imu.lab import LAB
from grader.sandbox.process import WallClock
from grader.sandbox.wire import Frame

CALL_CPU_S, SUBMISSION_CPU_S = 10.0, 120.0
SHARE_S = SUBMISSION_CPU_S / 6


class Slow:
    """A worker whose every answer takes its time, on a clock of its own."""

    alive = True

    def __init__(self, cpu_s: float, wall_s: float) -> None:
        self.cpu_s = self.wall_s = 0.0
        self._takes = cpu_s, wall_s

    def ask(self, op: str, fields: Any = None, arrays: Any = None, **limits: float) -> Frame:
        if op == "submit":
            return Frame({"written": []}, {})
        cpu_s, wall_s = self._takes
        self.cpu_s += cpu_s
        self.wall_s += min(wall_s, limits["most_s"])
        if wall_s > limits["most_s"]:
            raise TimedOut("no answer", cpu_s=cpu_s, wall_s=limits["most_s"])
        return Frame({"names": {}}, {})

    def printed(self) -> str:
        return ""

    def close(self) -> None:
        self.alive = False


class Boxes:
    def __init__(self, cpu_s: float, wall_s: float) -> None:
        self._takes = cpu_s, wall_s
        self.workers: list[Slow] = []

    def worker(self) -> Slow:
        self.workers.append(Slow(*self._takes))
        return self.workers[-1]


def conversation(sandbox: Boxes) -> SubmissionSession:
    return SubmissionSession(
        sandbox, LAB, {}, above={}, lab_configuration={"paths": []}, call_cpu_s=CALL_CPU_S, submission_cpu_s=SUBMISSION_CPU_S,
    )  # type: ignore[arg-type] # fmt: skip


def asked(talk: SubmissionSession, times: int) -> Iterator[bool]:
    for _ in range(times):
        try:
            talk.ask("outline", {})
            yield True
        except TimedOut:
            yield False


def test_answers_that_come_late_use_up_the_time_of_their_part_and_of_no_other() -> None:
    talk = conversation(sandbox := Boxes(cpu_s=0.1, wall_s=25.0))
    talk.account_to("filtering")
    assert list(asked(talk, 6)) == [True, True, True, False, False, False]
    assert sum(worker.wall_s for worker in sandbox.workers) == 4 * SHARE_S
    talk.account_to("noise_model")
    assert list(asked(talk, 1)) == [True]


@pytest.mark.skipif(
    not os.path.exists("/proc/self/schedstat"), reason="this system does not tell who waits for a processor"
)
def test_the_clock_stands_still_for_what_waits_for_a_processor_and_runs_for_what_sleeps() -> None:
    """Two that compute share one processor: each waits half of the time, and neither is slow."""
    one_core = sorted(os.sched_getaffinity(0))[:1]
    spins = f"import os, time; os.sched_setaffinity(0, {one_core}); print(flush=True)\nwhile time.process_time() < 0.6: pass\ninput()"
    busy = [
        subprocess.Popen([sys.executable, "-c", spins], stdin=subprocess.PIPE, stdout=subprocess.PIPE) for _ in range(2)
    ]
    assert all(each.stdout is not None and each.stdout.readline() for each in busy)
    clocks, before = [WallClock(each.pid) for each in busy], time.monotonic()
    while any(_state(each.pid) != "S" for each in busy):
        time.sleep(0.01)
    took, counted = time.monotonic() - before, [clock.read() for clock in clocks]
    time.sleep(0.2)
    slept = [clock.read() for clock in clocks]
    for each in busy:
        each.communicate(b"\n")
    assert sum(counted) < took + 0.6 * took
    assert all(after - then >= 0.19 for after, then in zip(slept, counted, strict=True))


def _state(pid: int) -> str:
    with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
        return file.read().rpartition(")")[2].split()[0]
