"""A marker records what is missing, believes nothing that is damaged, and notices where the sandbox answers otherwise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from grader.intake import Submission
from grader.sandbox.wire import Frame
from tests.corpus.pieces import VERBATIM
from tests.recordings import store
from tests.recordings.answers import RecordedWorker, Recording
from tests.recordings.marker import Counts, RecordedMarker, without_charts

# --- workers ----------------------------------------------------------------------------------------------------------


class Echo:
    """A worker that tells its questions."""

    cpu_s = wall_s = 0.0

    def __init__(self, heard: list[str]) -> None:
        self._heard = heard

    def ask(self, op: str, *_: object) -> Frame:
        self._heard.append(op)
        return Frame({"op": op, "asked": len(self._heard)})


def test_a_question_that_is_not_recorded_is_asked_after_those_before_it() -> None:
    heard: list[str] = []
    recording = Recording()
    for questions in ("a", "ac"):
        heard.clear()
        worker = RecordedWorker(recording, lambda: Echo(heard))  # type: ignore[arg-type, return-value]
        for number, op in enumerate(questions, 1):
            recording.new = False
            assert worker.ask(op).fields == {"op": op, "asked": number}
            assert recording.new == (op == questions[-1])
    assert worker.ask("d").fields == {"op": "d", "asked": 3}
    assert (heard, len(recording.answers)) == (["a", "c", "d"], 3)


# --- markers ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def submission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Submission:
    monkeypatch.setattr(store, "FOLDER", tmp_path)
    for name in ("recorded", "compared", "seconds"):
        monkeypatch.setattr(Counts, name, 0)
    monkeypatch.setattr(Counts, "every", 0)
    return Submission("s", "s", {name: text.encode() for name, text in VERBATIM.items()}, (), "ready", "")


def test_a_case_is_recorded_once_then_compared_and_recorded_anew_where_its_file_is_damaged(
    submission: Submission, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Counts, "every", 1)
    marker = RecordedMarker(without_charts())
    assert marker.mark(submission, only="filtering").score == 20.0
    assert (Counts.recorded, Counts.compared) == (1, 0)  # what was just recorded is the sandbox's own answer
    (file,) = store.FOLDER.iterdir()
    content = file.read_bytes()
    marker.mark(submission, only="filtering")
    assert (Counts.recorded, Counts.compared, file.read_bytes() == content) == (1, 1, True)
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
    for history, answer in recording.answers.items():
        assert answer.frame is not None
        arrays = {name: 2 * array if array.dtype.kind == "f" else array for name, array in answer.frame.arrays.items()}
        recording.answers[history] = replace(answer, frame=replace(answer.frame, arrays=arrays))
    store.write(key, recording)
    monkeypatch.setattr(Counts, "every", 1)
    with pytest.raises(AssertionError, match=f"the sandbox answers otherwise than .*{store.path_of(key).name}"):
        marker.mark(submission, only="filtering")
