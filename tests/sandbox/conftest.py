"""Fixtures with a sandbox: one for each isolation level, shared by all tests, with the small worker code of `probe_worker/`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.sandbox.isolation_levels import LEVELS
from grader.sandbox.level_choice import LevelResult, probe
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox, Worker

WORKER_CODE = Path(__file__).parent / "probe_worker"
ISOLATING = [isolation_level.name for isolation_level in LEVELS if isolation_level.isolates]


@pytest.fixture(scope="session")
def isolation_levels() -> dict[str, LevelResult]:
    return {tried.isolation_level.name: tried for tried in probe()}


@pytest.fixture(scope="session")
def sandbox_on(isolation_levels: dict[str, LevelResult]) -> Iterator[Callable[[str], Sandbox]]:
    """The one sandbox of an isolation level; skips the test where this machine does not allow the isolation level."""
    sandboxes: dict[str, Sandbox] = {}

    def get(name: str) -> Sandbox:
        if not isolation_levels[name].usable:
            pytest.skip(f"no isolation level {name} here: {isolation_levels[name].reason}")
        if name not in sandboxes:
            sandboxes[name] = Sandbox(Contents(WORKER_CODE), isolation_level=name)
        return sandboxes[name]

    yield get
    for sandbox in sandboxes.values():
        sandbox.close()


@pytest.fixture(params=[isolation_level.name for isolation_level in LEVELS])
def sandbox(request: pytest.FixtureRequest, sandbox_on: Callable[[str], Sandbox]) -> Sandbox:
    return sandbox_on(request.param)


@pytest.fixture(params=ISOLATING)
def isolating_sandbox(request: pytest.FixtureRequest, sandbox_on: Callable[[str], Sandbox]) -> Sandbox:
    return sandbox_on(request.param)


@pytest.fixture
def worker(sandbox: Sandbox) -> Iterator[Worker]:
    with sandbox.worker() as worker:
        yield worker


@pytest.fixture(scope="session")
def best() -> Iterator[Sandbox]:
    """A sandbox on the best isolation level, for what is the same on all of them."""
    with Sandbox(Contents(WORKER_CODE)) as sandbox:
        yield sandbox


@pytest.fixture
def anyone(best: Sandbox) -> Iterator[Worker]:
    """A worker on the best isolation level."""
    with best.worker() as worker:
        yield worker


@pytest.fixture
def isolated_worker(isolating_sandbox: Sandbox) -> Iterator[Worker]:
    """An isolated worker, on each level that isolates."""
    with isolating_sandbox.worker() as worker:
        yield worker


def run(worker: Worker, source: str, **limits: Any) -> dict[str, Any]:
    """Run source in a worker: what it left in `result`, or its error."""
    return worker.ask("run", {"source": source}, **limits).fields
