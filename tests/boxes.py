"""One box for the markers of many tests: to open one takes longer than to mark a submission."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager

from grader.engine import rubric
from grader.engine.lab_box import open_box
from grader.engine.marking import Marker
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.labs.imu.lab import LAB
from grader.sandbox.box import Box, Worker
from grader.sandbox.rungs import Rung

Opened = Callable[..., AbstractContextManager[Marker]]
"""A marker by traces, and by the lab's own rubric or another one."""


class Lasting:
    """A box that a marker does not close when it is closed."""

    def __init__(self, box: Box) -> None:
        self._box = box

    @property
    def rung(self) -> Rung:
        return self._box.rung

    def worker(self) -> Worker:
        return self._box.worker()

    def warm(self, modules: Sequence[str]) -> None:
        self._box.warm(modules)

    def close(self) -> None:
        """It stays open for the next one."""


@contextmanager
def opener() -> Iterator[Opened]:
    """What opens markers with one box."""
    with open_box(LAB) as box:

        def opened(truth: Traces, by: Rubric | None = None) -> Marker:
            return Marker(by or rubric.load(LAB), truth, box=Lasting(box))  # type: ignore[arg-type] # speaks as a box does

        yield opened
