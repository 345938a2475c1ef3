"""Tests of statements that end their process: which place is used of what such a process wrote down."""

from __future__ import annotations

import json

import numpy as np
import pytest

from grader.base.errors import Crashed, TimedOut
from grader.engine.load_report import DeadlyStatements
from grader.sandbox.wire import Frame
from tests.test_wall_time import Boxes, Slow, conversation

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
