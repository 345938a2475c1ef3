"""Sessions with processes that take long or end: waiting costs, too, and a statement that ends its process is not run again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from grader.base.errors import Crashed, TimedOut
from grader.engine.findings import StudentError
from grader.engine.load_report import DeadlyStatements, not_handed_in
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


def test_data_is_sent_last_and_of_other_files_the_nearest_is_searched_first() -> None:
    talk = conversation(Boxes(0.0, 0.0))
    assert sorted(["a.csv", "filters.py", "b.py"], key=talk._send_order) == ["filters.py", "b.py", "a.csv"]
    talk._outline = {path: ["LowPassFilter"] for path in ("backup/a.py", "solution.py")}
    assert talk._other_files_defining("LowPassFilter", "filters.py") == ["solution.py", "backup/a.py"]


@pytest.mark.slow
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


# --- statements that end their process: which place is used of what such a process wrote down ---

CRASH, LATE = Crashed("it ended"), TimedOut("no answer", cpu_s=1.0, wall_s=1.0)
PLACE = json.dumps([["lab.py", 3]]).ljust(100)


def overran(path: str, number: int, *within: str) -> dict[str, object]:
    facts = {"type": "", "message": "", "file": None, "line": None, "text": None, "name": None}
    return facts | {"path": path, "number": number, "at": 1, "how": "overran", "defines": [], "within": list(within)}


def frame(*stepped_over: dict[str, object]) -> Frame:
    return Frame({"stepped_over": list(stepped_over)}, dict[str, np.ndarray]())


def test_who_ends_the_process_once_may_be_innocent_and_twice_is_not_run_again() -> None:
    endings = DeadlyStatements()
    endings.learn_place(PLACE, CRASH, ())
    assert (endings.to_skip(()), endings.count) == ([], 1)
    endings.learn_place(PLACE, CRASH, ())
    assert endings.to_skip(()) == [("lab.py", 3, "it ends the process")]


def test_what_had_to_be_ended_is_not_run_again_but_beside_other_stand_ins() -> None:
    endings = DeadlyStatements()
    endings.learn_place(PLACE, LATE, ["NoisyIMU"])
    assert [where[:2] for where in endings.to_skip(["NoisyIMU"])] == [("lab.py", 3)]
    assert endings.to_skip(["NoisyIMU", "LowPassFilter"]) == []


def test_no_process_can_claim_so_many_that_the_next_question_grows_too_long() -> None:
    endings = DeadlyStatements()
    for start in range(0, 400, 40):
        endings.learn_overrun(frame(*(overran("lab.py", start + n) for n in range(40))), ())
    assert len(endings.to_skip(())) == 24


@pytest.mark.parametrize(("has_seen_data", "skipped"), [(False, [("lab.py", 3)]), (True, [])])
def test_a_place_that_a_process_wrote_down_after_it_saw_data_is_not_used(
    has_seen_data: bool, skipped: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The place could hold data: which statement is skipped would tell it to the next process."""
    monkeypatch.setattr(Slow, "place", lambda _: PLACE, raising=False)
    session = conversation(Boxes(cpu_s=1.0, wall_s=1e6))
    session._fresh_session().has_seen_data = has_seen_data
    with pytest.raises(TimedOut):
        session.ask("load", {"path": "lab.py"})
    assert [where[:2] for where in session._endings.to_skip(())] == skipped


@pytest.mark.parametrize(
    ("type_", "message", "told"),
    [
        ("FileNotFoundError", "[Errno 2] No such file or directory: 'a.csv'", " (hand in a.csv, too)"),
        ("FileNotFoundError", "a.csv not found.", " (hand in a.csv, too)"),
        ("ValueError", "ParseXML: Error opening file 'a.xml'", " (hand in a.xml, too)"),
        ("ValueError", "torso not found", ""),
    ],
)
def test_a_file_that_code_reads_and_nobody_handed_in_is_asked_for(type_: str, message: str, told: str) -> None:
    assert not_handed_in(StudentError(type_, message, None, None, None)) == told
