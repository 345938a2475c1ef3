"""Answers of the sandbox, mangled on their way to the checks.

A sound submission with all extensions is marked once and its answers are kept; then it is marked again and again without a sandbox:
with one to three of the answers mangled. Whatever comes back, every check must be judged, and no exception raised.
"""

from __future__ import annotations

import random
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from typing import Any
from unittest import mock

import numpy as np

from grader.base.errors import Crashed
from grader.engine import rubric
from grader.engine.chart_data import Evidence, packed
from grader.engine.check_runner import CheckRun
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.isolation_levels import NO_ISOLATION
from grader.sandbox.sandbox import Sandbox, Worker
from grader.sandbox.wire import Frame
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files
from tests.examples import files
from tests.fuzz.mangling import mangled_array, mangled_value
from tests.recordings.answers import history_after
from tests.sandboxes import opened
from tests.single_faults import marked, submission_of

Answers = dict[str, Frame]
Leading = defaultdict[tuple[str, str | None], Frame | None]


def _key(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    return f"{op} {history_after('', op, fields, arrays)}"


def everything() -> Files:
    """A sound submission with every extension: all questions are asked of it."""
    extensions = {path.name: path.read_text("utf-8") for path in files("s15-extensions") if path.suffix == ".py"}
    return {**extensions, **tidy()}


def recorded(files: Files) -> tuple[Answers, Leading]:
    """What the sandbox answers when a submission is marked, and to questions that lead to others, whatever else they say."""
    answers: Answers = {}
    leading: Leading = defaultdict(lambda: None)
    ask = Worker.ask

    def recording(self: Worker, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Frame:
        frame = ask(self, op, fields, arrays, **limits)
        answers[_key(op, fields or {}, arrays or {})] = leading[op, (fields or {}).get("path")] = frame
        return frame

    with mock.patch.object(Worker, "ask", recording), opened(bundles.shipped()) as marker:
        marked(marker, files)
    return answers, leading


Ask = Callable[[str, Mapping[str, Any], Mapping[str, np.ndarray]], Frame]
_LEADING = ("submit", "outline", "load")
"""Questions without whose sound answer nothing else is asked."""


class _Replay(nullcontext["_Replay"]):
    """A worker that answers as it is told to."""

    alive, closed, cpu_s, wall_s = True, False, 0.0, 0.0

    def __init__(self, answer: Ask) -> None:
        super().__init__(self)
        self._answer = answer

    def close(self) -> None:
        """Nothing to close."""

    def place(self) -> str:
        return ""

    def printed(self) -> str:
        return ""

    def ask(self, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Frame:
        return self._answer(op, fields or {}, arrays or {})


def mangled_frame(frame: Frame, chance: random.Random) -> Frame:
    """A frame with one to four changes."""
    fields, arrays = frame.fields, dict(frame.arrays)
    for _ in range(chance.randint(1, 4)):
        if arrays and chance.random() < 0.5:
            name = chance.choice(sorted(arrays))
            arrays[name] = mangled_array(arrays[name], chance)
        else:
            changed = mangled_value(fields, chance)
            fields = changed if isinstance(changed, dict) else fields
    return Frame(fields, arrays)


class Bench:
    """A marker without a sandbox, and one submission's answers; a context manager."""

    def __init__(self, files: Files) -> None:
        self._answers, self._leading = recorded(files)
        self._submission = submission_of(files)
        self.troubles: list[str] = []

    @contextmanager
    def open(self) -> Iterator[Bench]:
        def no_sandbox(sandbox: Sandbox, *args: Any, **kwargs: Any) -> None:
            sandbox.isolation_level = NO_ISOLATION

        write_down = CheckRun.end

        def noting(this: CheckRun, check: Any, ended: BaseException | None, duration_s: float) -> None:
            write_down(this, check, ended, duration_s)
            if this.judgements[check.id].feedback is None and ended is not None:
                self.troubles.append("".join(traceback.format_exception(ended)[-3:]))

        def evidence(this: Marker, student: Any) -> Evidence:
            """As a marker gathers it, without its net."""
            return Evidence(packed(LAB.charts(student, this._traces)), ())

        with (
            mock.patch.object(Sandbox, "__init__", no_sandbox),
            mock.patch.object(Sandbox, "warm"),
            mock.patch.object(CheckRun, "end", noting),
            mock.patch.object(Marker, "_evidence", evidence),
        ):
            self._marker = Marker(rubric.load(LAB), bundles.shipped())
            yield self

    def mark(self, seed: int) -> Result:
        """Mark with some answers mangled; `troubles` holds what could not be judged."""
        chance = random.Random(seed)
        asked = [key for key in sorted(self._answers) if not key.startswith(("submit", "image"))]
        changed = set(chance.sample(asked, chance.randint(1, 3)))

        def answer(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
            key = _key(op, fields, arrays)
            if key not in self._answers:
                raise Crashed("nothing is on record")
            frame = self._answers[key]
            return mangled_frame(frame, random.Random(f"{seed} {key}")) if key in changed else frame

        return self._marked(answer)

    def points(self, lie: Callable[[str, Frame], Frame] = lambda op, frame: frame) -> dict[str, float]:
        """Points of each check where one claim of the process is replaced; what is asked beyond the record gets no answer."""

        def answer(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
            known = self._answers.get(_key(op, fields, arrays))
            if known is None and op in _LEADING:
                known = self._leading[op, fields.get("path")]
            if known is None:
                raise Crashed("nothing is on record")
            return lie(op, known)

        result = self._marked(answer)
        assert self.troubles == []
        return {check.id: float(check.points or 0.0) for criterion in result.criteria for check in criterion.checks}

    def _marked(self, answer: Ask) -> Result:
        self.troubles.clear()
        with mock.patch.object(Sandbox, "worker", lambda sandbox: _Replay(answer)):
            return self._marker.mark(self._submission)
