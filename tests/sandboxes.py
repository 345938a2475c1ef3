"""One sandbox for the markers of many tests, because opening one takes longer than grading a submission."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache
from typing import Any

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.lab_sandbox import open_sandbox
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.labs.imu.lab import LAB
from grader.sandbox.sandbox import Sandbox

Opened = Callable[..., AbstractContextManager[Marker]]
"""A marker by traces, and by the lab's own rubric or another one."""


class Lasting:
    """A sandbox that a marker does not close when it is closed."""

    def __init__(self, sandbox: Sandbox) -> None:
        self._sandbox = sandbox

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sandbox, name)

    def __enter__(self) -> Lasting:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """It stays open for the next one."""


@cache
def shared() -> Sandbox:
    """The sandbox of this process, opened when it is first used; `close` ends it."""
    return open_sandbox(LAB)


def close() -> None:
    if shared.cache_info().currsize:
        shared().close()
        shared.cache_clear()


def opened(truth: Traces, by: Rubric | None = None) -> Marker:
    """A marker with the shared sandbox."""
    return Marker(by or rubric.load(LAB), truth, sandbox=Lasting(shared()))  # type: ignore[arg-type] # speaks as a sandbox does
