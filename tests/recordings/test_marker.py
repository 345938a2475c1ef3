"""A marker records what is missing, believes nothing that is damaged, and notices where the sandbox answers otherwise."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from grader.base.errors import TimedOut
from grader.intake import Submission
from grader.sandbox.wire import Frame
from tests.corpus.pieces import VERBATIM
from tests.recordings import store
from tests.recordings.answers import Answer, RecordedWorker, Recording
from tests.recordings.marker import Counts, RecordedMarker, without_charts

# --- workers ----------------------------------------------------------------------------------------------------------


class Echo:
    """A worker that tells its questions, and dies of "die"."""

    cpu_s = wall_s = 0.0

    def __init__(self, heard: list[str]) -> None:
        self._heard = heard

    def ask(self, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Frame:
        self._heard.append(op)
        self.cpu_s += 0.5
        if op == "die":
            raise TimedOut("no answer", cpu_s=1.0, wall_s=2.0)
        return Frame({"op": op, "asked": len(self._heard)})

    def place(self) -> str:
        return "line 1"

    def close(self) -> None: ...


def worker(recording: Recording, heard: list[str]) -> RecordedWorker:
    return RecordedWorker(recording, lambda: Echo(heard))  # type: ignore[arg-type, return-value]


def test_a_question_that_is_not_recorded_is_asked_after_those_before_it() -> None:
    recording = Recording()
    worker(recording, []).ask("a")
    recording.new = False
    heard: list[str] = []
    changed = worker(recording, heard)
    changed.ask("a")
    assert (heard, recording.new) == ([], False)
    assert changed.ask("c").fields == {"op": "c", "asked": 2}
    assert changed.ask("d").fields == {"op": "d", "asked": 3}
    assert (heard, recording.new, len(recording.answers)) == (["a", "c", "d"], True, 3)


# --- markers ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def submission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Submission:
    monkeypatch.setattr(store, "FOLDER", tmp_path)
    for name in ("recorded", "compared", "seconds"):
        monkeypatch.setattr(Counts, name, 0)
    monkeypatch.setattr(Counts, "every", 0)
    return Submission("s", "s", {name: text.encode() for name, text in VERBATIM.items()}, (), "ready", "")


def test_a_case_is_recorded_once_and_anew_where_its_file_is_damaged(submission: Submission) -> None:
    marker = RecordedMarker(without_charts())
    assert marker.mark(submission, only="filtering").score == 20.0
    (file,) = store.FOLDER.iterdir()
    content = file.read_bytes()
    marker.mark(submission, only="filtering")
    assert (Counts.recorded, file.read_bytes() == content) == (1, True)
    file.write_bytes(content[:-100])
    assert marker.mark(submission, only="filtering").score == 20.0
    assert (Counts.recorded, len(file.read_bytes()) >= len(content) - 100) == (2, True)


def test_a_wrong_answer_is_noticed_where_the_case_is_compared(
    submission: Submission, monkeypatch: pytest.MonkeyPatch
) -> None:
    marker = RecordedMarker(without_charts())
    marker.mark(submission, only="filtering")
    key = store.key(submission, "filtering", without_charts().limits)
    recording = store.read(key)
    recording.answers = {history: _wrong(answer) for history, answer in recording.answers.items()}
    store.write(key, recording)
    monkeypatch.setattr(Counts, "every", 1)
    with pytest.raises(AssertionError, match=f"the sandbox answers otherwise than .*{store.path_of(key).name}"):
        marker.mark(submission, only="filtering")


def test_a_case_that_was_just_recorded_is_not_judged_in_the_sandbox_again(
    submission: Submission, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Counts, "every", 1)
    marker = RecordedMarker(without_charts())
    compared = []
    for _ in range(2):
        marker.mark(submission, only="filtering")
        compared.append(Counts.compared)
    assert compared == [0, 1]


def _wrong(answer: Answer) -> Answer:
    assert answer.frame is not None
    arrays = {name: 2 * array if array.dtype.kind == "f" else array for name, array in answer.frame.arrays.items()}
    return Answer(answer.cpu_s, Frame(answer.frame.fields, arrays))
