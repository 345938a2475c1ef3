"""Tapes: what the box answered to the questions about a submission, played again without a box.

A tape is keyed by the history of questions: what a worker was asked so far, word for word, decides what comes next. A judging that
asks what was never asked gets no answer: the tape is then stale, and `python -m tests.tapes` records it anew.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Protocol

import numpy as np

from grader.engine.results import Result
from grader.ground.errors import Crashed, Malformed, NoAnswer, TimedOut
from grader.intake import Submission
from grader.sandbox.box import Box, Worker
from grader.sandbox.rungs import named
from grader.sandbox.wire import Frame

_KINDS = {kind.__name__: kind for kind in (Crashed, Malformed)}


class Marking(Protocol):
    """What most tests need of a marker."""

    def mark(self, submission: Submission, only: str | None = None) -> Result: ...


class StaleError(AssertionError):
    """The judging asks what was not asked when the tape was recorded."""


@dataclass(frozen=True)
class Played:
    """One answer, or what came in place of it, and what it cost."""

    cpu_s: float
    frame: Frame | None = None
    failure: tuple[str, str, float, float] | None = None
    place: str = ""

    def give(self) -> Frame:
        if self.frame is not None:
            return self.frame
        assert self.failure is not None
        kind, message, cpu_s, wall_s = self.failure
        raise TimedOut(message, cpu_s=cpu_s, wall_s=wall_s) if kind == "TimedOut" else _KINDS[kind](message)


@dataclass
class Tape:
    """Answers by the history that they ended."""

    rung: str
    answers: dict[str, Played] = field(default_factory=dict)


def _asked(before: str, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """The history after one more question. Numbers count to nine decimals: the last digits of a sum differ between processors."""
    digest = hashlib.sha256(before.encode())
    digest.update(json.dumps([op, fields], sort_keys=True, default=str).encode("utf-8", "surrogatepass"))
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        if array.dtype.kind == "f":
            array = array.round(9) + 0.0
        digest.update(f"{name}\0{array.dtype.str}\0{array.shape}\0".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()[:32]


class _Line:
    """A worker's place in the tape: the questions that it was asked so far."""

    def __init__(self, tape: Tape) -> None:
        self._tape, self._history, self._place = tape, "", ""
        self.alive, self.closed = True, False

    def __enter__(self) -> _Line:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _next(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
        self._history = _asked(self._history, op, fields, arrays)
        return self._history

    def printed(self) -> str:
        return ""

    def place(self) -> str:
        """What the process had written down of where it was when it ended."""
        return self._place

    def close(self) -> None:
        self.alive, self.closed = False, True


class RecordedWorker(_Line):
    """A real worker whose answers are kept."""

    def __init__(self, tape: Tape, worker: Worker) -> None:
        super().__init__(tape)
        self._worker = worker

    @property
    def cpu_s(self) -> float:
        return self._worker.cpu_s

    @property
    def wall_s(self) -> float:
        return self._worker.wall_s

    def ask(
        self,
        op: str,
        fields: Mapping[str, Any] | None = None,
        arrays: Mapping[str, np.ndarray] | None = None,
        **limits: Any,
    ) -> Frame:
        key = self._next(op, fields or {}, arrays or {})
        before = self._worker.cpu_s
        try:
            frame = self._worker.ask(op, fields, arrays, **limits)
        except NoAnswer as nothing:
            self.alive = False
            times = (nothing.cpu_s, nothing.wall_s) if isinstance(nothing, TimedOut) else (0.0, 0.0)
            self._place = self._worker.place()
            failure = (type(nothing).__name__, str(nothing), *times)
            self._keep(key, Played(self._worker.cpu_s - before, failure=failure, place=self._place))
            raise
        self._keep(key, Played(self._worker.cpu_s - before, frame))
        return frame

    def _keep(self, key: str, played: Played) -> None:
        self._tape.answers.setdefault(key, played)

    def close(self) -> None:
        self._worker.close()
        super().close()


class PlayedWorker(_Line):
    """A worker that is only a tape."""

    cpu_s = wall_s = 0.0

    def ask(
        self,
        op: str,
        fields: Mapping[str, Any] | None = None,
        arrays: Mapping[str, np.ndarray] | None = None,
        **limits: Any,
    ) -> Frame:
        if not self.alive:
            raise Crashed("the process had already ended")
        key = self._next(op, fields or {}, arrays or {})
        if key not in self._tape.answers:
            raise StaleError(f"the question {op!r} was not asked when the tape was recorded; run python -m tests.tapes")
        played = self._tape.answers[key]
        self.cpu_s += played.cpu_s
        self.alive, self._place = played.failure is None, played.place
        return played.give()


class RecordingBox:
    """A box that keeps what its workers answer."""

    def __init__(self, box: Box) -> None:
        self._box, self.rung, self.tape = box, box.rung, Tape(box.rung.name)

    def begin(self) -> Tape:
        """An empty tape, for the next submission."""
        self.tape = Tape(self.rung.name)
        return self.tape

    def worker(self) -> RecordedWorker:
        return RecordedWorker(self.tape, self._box.worker())

    def warm(self, modules: Sequence[str]) -> None:
        self._box.warm(modules)

    def close(self) -> None:
        self._box.close()


class PlayingBox:
    """A box without a process: `tape` is what it plays."""

    def __init__(self, rung: str) -> None:
        self.rung, self.tape = named(rung), Tape(rung)

    def worker(self) -> PlayedWorker:
        return PlayedWorker(self.tape)

    def warm(self, modules: Sequence[str]) -> None:
        """There is nothing to import."""

    def close(self) -> None:
        """There is nothing to end."""
