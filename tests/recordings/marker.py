"""A marker that judges from recordings, and records what is missing."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache
from typing import Any

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.results import Result, to_dict
from grader.engine.rubric import Rubric
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Sandbox
from tests import sandboxes
from tests.fake_results import without_durations
from tests.recordings import store
from tests.recordings.answers import RecordedSandbox, UnrecordedError
from tests.rubrics import edited
from tests.scoreboard import Case, Verdict, as_written, graded_by

_CALL_CPU_S = 4
"""Limit of one call: an endless loop uses it up; of 19,616 calls that end, the slowest took 1.8 s on two busy cores."""
COMPARED = 40
"""Every so many submissions are also judged in a real sandbox, if they were not recorded from one in this run.

With `-m recorded` every one is, with `-m quick` none.
"""
_NOT_FROM_RECORDINGS = ("module level", "nothing")
"""Parts of the corpus that have tests of their own."""


class Counts:
    """What this process did: submissions recorded and compared, and the seconds that this took."""

    recorded = compared = 0
    seconds = 0.0
    every = COMPARED


class RecordedMarker:
    """A marker whose sandbox is a recording.

    Parameters
    ----------
    by : the rubric
    records : whether a missing answer is recorded; otherwise asking for it raises `UnrecordedError`
    """

    def __init__(self, by: Rubric, *, records: bool = True) -> None:
        self._rubric = by
        self._records = records
        self._sandbox = RecordedSandbox(sandboxes.shared if records else _nothing)
        self._marker = Marker(by, bundles.shipped(), sandbox=self._sandbox)  # type: ignore[arg-type] # speaks as a sandbox does

    def mark(self, submission: Submission, only: str | None = None) -> Result:
        key = store.key(submission, only, self._rubric.limits)
        begun = time.perf_counter()
        self._sandbox.recording = recording = store.read(key)
        result = self._marker.mark(submission, only=only)
        if recording.new:
            store.write(key, recording)
            Counts.recorded += 1
            Counts.seconds += time.perf_counter() - begun
        elif self._records and Counts.every and int(key, 16) % Counts.every == 0:
            self._compare(submission, only, result, key)
        return result

    def _compare(self, submission: Submission, only: str | None, result: Result, key: str) -> None:
        """Judge a submission in a real sandbox, too: the verdict has to be the same."""
        begun = time.perf_counter()
        real = Marker(self._rubric, bundles.shipped(), sandbox=sandboxes.Lasting(sandboxes.shared()))  # type: ignore[arg-type]
        wanted = _without_chance(real.mark(submission, only=only))
        Counts.compared += 1
        Counts.seconds += time.perf_counter() - begun
        path = store.path_of(key)
        assert _without_chance(result) == wanted, (
            f"the sandbox answers otherwise than {path}: if the test passes once that is deleted, `store.key` lacks something"
        )


def _nothing() -> Sandbox:
    raise UnrecordedError("a question was asked that is not recorded")


def _without_chance(result: Result) -> Any:
    """What has to be the same each time: all but durations, and the isolation level of the machine that recorded."""
    plain = without_durations(to_dict(result))
    del plain["provenance"]["isolation"]
    return plain


@cache
def without_charts(more: str = "") -> Rubric:
    """The shipped rubric without charts, with a lower limit of a call, and with `more` lines."""
    limited = edited("call_cpu_s: 10", f"call_cpu_s: {_CALL_CPU_S}")
    return rubric.parse(replace(LAB, charts=lambda student, truth: ()), (limited + more).encode())


@cache
def recorded_corpus() -> tuple[Case, ...]:
    """The cases of the corpus that are judged from recordings."""
    return tuple(case for case in as_written() if case.part not in _NOT_FROM_RECORDINGS)


@cache
def corpus_marker(*, records: bool = True) -> RecordedMarker:
    """The process's one marker of the corpus; extensions have points, so that their partial credit shows."""
    return RecordedMarker(without_charts("\nextra_credit:\n  each: 10\n"), records=records)


def verdict(case: Case, *, records: bool = True) -> Verdict:
    return graded_by(corpus_marker(records=records), case)
