"""Answers of the box, mangled on their way to the checks: ``python -m tests.fuzz.answers [--runs N] [--seed S]``.

A sound submission is marked once and its answers are kept; then it is marked again and again without a box, with one to
three of the answers changed. Whatever comes back, every check must be judged.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from grader.engine import rubric, traces
from grader.engine.examination import Examination
from grader.engine.marking import Marker
from grader.engine.results import Result
from grader.ground.errors import Crashed, Malformed
from grader.intake import Submission, read_submission
from grader.labs.imu.lab import LAB
from grader.sandbox.box import Box, Worker
from grader.sandbox.wire import Frame
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files, write
from tests.fuzz.mangling import mangled_array, mangled_value

Answers = dict[str, Frame]


def _key(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    digest = hashlib.sha256(json.dumps([op, fields], sort_keys=True).encode())
    for name in sorted(arrays):
        digest.update(name.encode() + np.asarray(arrays[name]).tobytes())
    return f"{op} {digest.hexdigest()}"


def submission(files: Files) -> Submission:
    with tempfile.TemporaryDirectory() as scratch:
        return read_submission(write(files, Path(scratch) / "fuzzed"), LAB.files)


def recorded(files: Files) -> Answers:
    """What the box answers when a submission is marked."""
    answers: Answers = {}
    ask = Worker.ask

    def recording(self: Worker, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Frame:
        frame = ask(self, op, fields, arrays, **limits)
        answers[_key(op, fields or {}, arrays or {})] = frame
        return frame

    with mock.patch.object(Worker, "ask", recording), Marker(rubric.load(LAB), traces.shipped()) as marker:
        marker.mark(submission(files))
    return answers


class _Replay:
    """A worker that answers from a record, with some of the answers changed."""

    alive, closed, cpu_s = True, False, 0.0

    def __init__(self, answers: Answers, changed: set[str], seed: int) -> None:
        self._answers, self._changed, self._seed = answers, changed, seed

    def __enter__(self) -> _Replay:
        return self

    def __exit__(self, *error: object) -> None:
        """Nothing to close."""

    def close(self) -> None:
        """Nothing to close."""

    def place(self) -> str:
        return ""

    def ask(self, op: str, fields: Any = None, arrays: Any = None, **limits: Any) -> Frame:
        key = _key(op, fields or {}, arrays or {})
        if key not in self._answers:
            raise Crashed("nothing is on record")
        frame = self._answers[key]
        return mangled_frame(frame, random.Random(f"{self._seed} {key}")) if key in self._changed else frame


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
    """A marker without a box, and one submission's answers; a context manager."""

    def __init__(self, files: Files) -> None:
        self._answers, self._submission = recorded(files), submission(files)
        self.troubles: list[str] = []

    @contextmanager
    def open(self) -> Iterator[Bench]:
        def no_box(box: Box, *args: Any, **kwargs: Any) -> None:
            box.rung = "none"

        write_down = Examination.end

        def noting(this: Examination, check: Any, ended: BaseException | None, duration_s: float) -> None:
            write_down(this, check, ended, duration_s)
            if this.judgements[check.id].told is None and ended is not None:
                self.troubles.append("".join(traceback.format_exception(ended)[-3:]))

        with mock.patch.object(Box, "__init__", no_box), mock.patch.object(Examination, "end", noting):
            self._marker = Marker(rubric.load(LAB), traces.shipped())
            yield self

    def mark(self, seed: int) -> Result:
        """Mark with some answers mangled; `troubles` holds what could not be judged."""
        chance = random.Random(seed)
        asked = [key for key in sorted(self._answers) if not key.startswith(("submit", "image"))]
        changed = set(chance.sample(asked, chance.randint(1, 3)))
        self.troubles.clear()
        with mock.patch.object(Box, "worker", lambda box: _Replay(self._answers, changed, seed)):
            return self._marker.mark(self._submission)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.answers", description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    bad, slowest, started = 0, 0.0, time.monotonic()
    with Bench(tidy()).open() as bench:
        for seed in range(options.seed, options.seed + options.runs):
            before = time.monotonic()
            try:
                bench.mark(seed)
            except (Exception, Malformed):
                bench.troubles.append(traceback.format_exc(limit=-3))
            slowest = max(slowest, time.monotonic() - before)
            if bench.troubles:
                bad += 1
                print(f"seed {seed}: {bench.troubles[0]}", flush=True)
    print(
        f"{options.runs} runs, {bad} with a check that was not judged, {time.monotonic() - started:.0f} s, slowest {slowest:.1f} s"
    )
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
