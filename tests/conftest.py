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
import tempfile

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from grader.engine.grader import Marker
from grader.engine.recording import CACHE_VARIABLE
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from tests import sandboxes
from tests.recordings import Marking, store
from tests.recordings.marker import Counts, RecordedMarker, without_charts
from tests.sandboxes import Opened

SECRET = "a secret that must not leave 4711"
FIRST = ("test_documented_commands", "test_examples", "test_durability", "test_cluster")
"""They wait more than they work, or take a minute in one test: at the end one core would wait for them."""


@pytest.hookimpl(optionalhook=True)  # mutants are tested without xdist
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """For two cores, however many a shared machine says that it has; where sandboxes and clocks are waited for, one more."""
    return 2 if config.option.markexpr == "quick" else 3


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.stem not in FIRST)
    for item in items:
        if "player" in getattr(item, "fixturenames", ()):
            item.add_marker("recorded")


# --- recordings: counted by each test worker, told once ---------------------------------------------------------------

_COUNTED = pytest.StashKey[dict[str, float]]()


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_COUNTED] = dict.fromkeys(("recorded", "compared", "seconds"), 0)
    Counts.compare_all = config.option.markexpr == "recorded"
    if not hasattr(config, "workerinput"):
        store.tidy_up()
        _use_an_empty_cache(config)


def _use_an_empty_cache(config: pytest.Config) -> None:
    """No test reads or writes what the user's own commands keep; recordings stay where they are."""
    os.environ[store.VARIABLE] = str(store.FOLDER)  # for the test workers, which are started later
    folder = tempfile.TemporaryDirectory(prefix="imugrade-tests-")
    config.add_cleanup(folder.cleanup)
    os.environ[CACHE_VARIABLE] = folder.name


def pytest_sessionfinish(session: pytest.Session) -> None:
    sandboxes.close()
    mine = {name: getattr(Counts, name) for name in session.config.stash[_COUNTED]}
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["recordings"] = mine
    else:
        _count(session.config, mine)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    _count(node.config, getattr(node, "workeroutput", {}).get("recordings", {}))


def _count(config: pytest.Config, more: Mapping[str, float]) -> None:
    for name, number in more.items():
        config.stash[_COUNTED][name] += number


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell how many submissions ran in a real sandbox, and how long that took of all test workers' time."""
    counted = config.stash[_COUNTED]
    if counted["recorded"] or counted["compared"]:
        terminalreporter.write_line(
            f"{counted['recorded']} submissions recorded in {store.FOLDER}, {counted['compared']} compared with a real sandbox: "
            f"{counted['seconds']:.0f} s of the test workers' time"
        )


@pytest.fixture(scope="session")
def opened() -> Opened:
    """Opens markers with one sandbox, for whatever is marked by other traces or another rubric."""
    return sandboxes.opened


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
def player() -> Marking:
    """A marker that judges from recordings by the lab's own rubric and data, without charts."""
    return RecordedMarker(without_charts())
