"""What all tests run under.

Ctrl-C reaches what the tests start, also where a shell runs them in the background and has switched it off for them. And modules are
compiled once, as they are wherever the package is installed, also where the environment says otherwise: the tests start hundreds of
processes.
"""
# ruff: noqa: E402 - what is imported before that is not compiled once

from __future__ import annotations

import os
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.engine.marking import Marker
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from tests.boxes import Opened, opener
from tests.tapes import suite

SECRET = "a secret that must not leave 4711"
FIRST = ("test_documented_commands", "test_examples", "test_durability", "test_cluster")
"""They wait more than they work, or take a minute in one test: at the end one core would wait for them."""


@pytest.hookimpl(optionalhook=True)  # mutants are tested without xdist
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """For two cores, however many a shared machine says that it has; where boxes and clocks are waited for, one more."""
    return 2 if config.option.markexpr == "quick" else 3


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.stem not in FIRST)


@pytest.fixture(scope="session")
def opened() -> Iterator[Opened]:
    """Opens markers with one box, for whatever is marked by other traces or another rubric."""
    with opener() as opens:
        yield opens


@pytest.fixture(scope="session")
def marker(opened: Opened) -> Iterator[Marker]:
    """A warm one for whatever is marked by the lab's own rubric and data."""
    with opened(bundles.shipped()) as warm:
        yield warm


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where traces are kept for all workers of a run: to record some takes seconds."""
    own = tmp_path_factory.getbasetemp()
    return (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "traces"


@pytest.fixture(scope="session")
def hidden(cache: Path) -> Traces:
    """Traces of a secret, for whatever holds under any."""
    return bundles.obtain(SECRET, cache)


@pytest.fixture(scope="session")
def player() -> Iterator[suite.Marking]:
    """The same from tapes, for what a test of `tests.tapes.suite` marks."""
    with suite.opened() as marking:
        yield marking
