"""Workers that answer from a recording, and ask a real sandbox what the recording lacks.

An answer is keyed by the questions that its worker was asked so far, word for word, since they decide it together.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grader.base.errors import Crashed, Malformed, NoAnswer, TimedOut
from grader.sandbox.isolation_levels import IsolationLevel, named
from grader.sandbox.sandbox import Sandbox, Worker
from grader.sandbox.wire import Frame

_FAILURES = {kind.__name__: kind for kind in (Crashed, Malformed)}


class UnrecordedError(AssertionError):
    """A question has no recorded answer, and nothing may be recorded."""


@dataclass(frozen=True)
class Answer:
    """One answer and its CPU time; in its place the failure, and where the student's code was then."""

    cpu_s: float
    frame: Frame | None = None
    failure: tuple[str, str, float, float] | None = None
    place: str = ""

    def give(self) -> Frame:
        if self.frame is not None:
            return self.frame
        assert self.failure is not None
        kind, message, cpu_s, wall_s = self.failure
        raise TimedOut(message, cpu_s=cpu_s, wall_s=wall_s) if kind == "TimedOut" else _FAILURES[kind](message)


@dataclass
class Recording:
    """The answers about one submission, by question history, and the isolation level that they come from.

    Attributes
    ----------
    new : whether an answer was added since it was read
    """

    isolation_level: str = ""
    answers: dict[str, Answer] = field(default_factory=dict)
    new: bool = False


def history_after(before: str, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """Return the key of a history with one more question.

    Floats count to nine decimals: the last digits of a sum differ between processors.
    """
    digest = hashlib.sha256(before.encode())
    digest.update(json.dumps([op, fields], sort_keys=True, default=str).encode("utf-8", "surrogatepass"))
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        if array.dtype.kind == "f":
            array = array.round(9) + 0.0
        digest.update(f"{name}\0{array.dtype.str}\0{array.shape}\0".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()[:32]


class RecordedWorker(nullcontext["RecordedWorker"]):
    """A worker that answers from a recording as long as it can, then repeats its questions to a real worker and goes on there."""

    def __init__(self, recording: Recording, start: Callable[[], Worker]) -> None:
        super().__init__(self)
        self._recording, self._start = recording, start
        self._real: Worker | None = None
        self._asked: list[tuple[str, Mapping[str, Any], Mapping[str, np.ndarray], Mapping[str, Any]]] = []
        self._history, self._place, self._cpu_s = "", "", 0.0
        self.alive, self.closed = True, False

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def cpu_s(self) -> float:
        return self._real.cpu_s if self._real is not None else self._cpu_s

    @property
    def wall_s(self) -> float:
        return self._real.wall_s if self._real is not None else 0.0

    def ask(
        self,
        op: str,
        fields: Mapping[str, Any] | None = None,
        arrays: Mapping[str, np.ndarray] | None = None,
        **limits: Any,
    ) -> Frame:
        if not self.alive:
            raise Crashed("the process had already ended")
        self._asked.append((op, fields or {}, arrays or {}, limits))
        self._history = history_after(self._history, op, fields or {}, arrays or {})
        answer = self._recording.answers.get(self._history) if self._real is None else None
        if answer is None:
            answer = self._ask_for_real()
            self._recording.answers[self._history] = answer
            self._recording.new = True
        self._cpu_s += answer.cpu_s
        self.alive, self._place = answer.failure is None, answer.place
        return answer.give()

    def _ask_for_real(self) -> Answer:
        """Ask the real worker the last question; a new worker is asked all earlier ones first."""
        missed = self._asked[-1:]
        if self._real is None:
            self._real, missed = self._start(), self._asked
        try:
            for op, fields, arrays, limits in missed:
                before = self._real.cpu_s
                frame = self._real.ask(op, fields, arrays, **limits)
        except NoAnswer as nothing:
            times = (nothing.cpu_s, nothing.wall_s) if isinstance(nothing, TimedOut) else (0.0, 0.0)
            failure = (type(nothing).__name__, str(nothing), *times)
            return Answer(self._real.cpu_s - before, failure=failure, place=self._real.place())
        return Answer(self._real.cpu_s - before, frame)

    def printed(self) -> str:
        return ""

    def place(self) -> str:
        """Return what the process had written down of where it was when it ended."""
        return self._place

    def close(self) -> None:
        if self._real is not None:
            self._real.close()
        self.alive, self.closed = False, True


class RecordedSandbox:
    """The sandbox of a marker: its workers answer from `recording`, and from a real sandbox where that lacks an answer.

    Parameters
    ----------
    sandbox : opens the real one, or raises `UnrecordedError`
    """

    def __init__(self, sandbox: Callable[[], Sandbox]) -> None:
        self._sandbox, self._warm = sandbox, list[str]()
        self.recording = Recording()

    @property
    def isolation_level(self) -> IsolationLevel:
        self.recording.isolation_level = self.recording.isolation_level or self._sandbox().isolation_level.name
        isolation_level = named(self.recording.isolation_level)
        assert isolation_level is not None
        return isolation_level

    def worker(self) -> RecordedWorker:
        return RecordedWorker(self.recording, self._real_worker)

    def _real_worker(self) -> Worker:
        self._sandbox().warm(self._warm)
        return self._sandbox().worker()

    def warm(self, modules: Sequence[str]) -> None:
        self._warm += [name for name in modules if name not in self._warm]

    def close(self) -> None:
        """The real sandbox stays open for other markers."""
