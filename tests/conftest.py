"""Configuration of the test run: one thread for NumPy, compiled modules, slow files, recordings and shared fixtures.

The tests start hundreds of processes, so modules are compiled once, also if the environment switches that off. Two test workers
run on two cores, so NumPy uses one thread, as in the command line. Ctrl-C reaches the processes that the tests start, also if a
shell has switched it off for them.
"""
# ruff: noqa: E402 - what is imported before that is not compiled once, and NumPy reads the variables as it is loaded

from __future__ import annotations

import os
import shlex
import signal
import sys
import tempfile

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")})

from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from grader.engine.grader import Marker
from grader.engine.recording import CACHE_VARIABLE
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests import generated, sandboxes
from tests.recordings import Marking, store
from tests.recordings.marker import COMPARED, Counts, RecordedMarker, recorded_corpus, without_charts
from tests.sandboxes import Opened

HERE = Path(__file__).parent
settings.register_profile("short", max_examples=6, deadline=None, derandomize=True)
settings.register_profile("long", max_examples=750, deadline=None)
settings.load_profile("short")
SECRET = "a secret that must not leave 4711"
FIRST = ("test_documented_commands", "test_examples", "test_durability", "test_cluster")
"""They wait more than they work, or take a minute in one test: at the end one core would wait for them."""
SLOW = (
    *FIRST, "browser", "fuzz", "hostile", "labs", "mutants", "sandbox",
    "test_absent", "test_adjusting", "test_advice", "test_agreement", "test_batch", "test_budgets", "test_calibrate", "test_chance", "test_charts",
    "test_claims", "test_class_analysis", "test_class_memory", "test_class_people", "test_cli", "test_compat", "test_deducted_once",
    "test_desk_repairs",
    "test_docs", "test_drawing", "test_exports", "test_extensions", "test_first_screen",
    "test_hidden_feedback", "test_invariances", "test_kit", "test_marker", "test_marking", "test_missing_packages", "test_not_running", "test_other_systems",
    "test_own_checks", "test_own_robot", "test_pytest_plugin", "test_reading", "test_regrading",
    "test_repair_suggestions", "test_repairs", "test_repeatable", "test_replays", "test_repository", "test_repro", "test_second_faults",
    "test_shadowing_modules", "test_statements", "test_styles", "test_traces", "test_two_faults",
    "test_variants",
)  # fmt: skip
"""Files and folders that `pytest` without arguments leaves out, but for tests marked `plain`: processes, sandboxes, browsers. `-m full`,
as in CI, and `pytest FILE` run them."""
LEFT_OUT = 1700
"""About how many tests that is; a test compares it. `pytest` does not count them, since it does not import their files."""
MINUTES = 5
"""About how long they take on two cores: 2 minutes on a fast machine, 8 on a slow one, and longer without recordings."""
LONGER = ("test_check_data_collection", "test_check_noise_model", "test_check_extensions")
"""Files that `pytest -m quick` leaves out, too: they judge hundreds of made-up students."""
QUICK = "quick and not slow and not longer and not weekly"
ALL = "not delivered and not weekly"
EVERYDAY = f"{ALL} and not slow"
"""The marker expressions of `-m quick`, of a run of named tests, and of one without arguments."""


@pytest.hookimpl(optionalhook=True)  # mutants are tested without xdist
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """For two cores, however many a shared machine says that it has; where sandboxes and clocks are waited for, one more."""
    return 2 if config.option.markexpr in ("quick", ALL) else 3


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not import files and folders without a test for this run: each test worker would take seconds for it."""
    marks = {QUICK: "mark.quick", "delivered": "mark.delivered"}
    if _is_slow(collection_path):
        marks[EVERYDAY] = "mark.plain"
    mark = marks.get(config.option.markexpr)
    if mark is None:
        return None
    files = [collection_path] if collection_path.suffix == ".py" else collection_path.rglob("test_*.py")
    return None if any(mark in file.read_text(encoding="utf-8") for file in files) else True


def _is_slow(path: Path) -> bool:
    return bool({path.stem, *path.relative_to(HERE).parts[:1]} & {*SLOW})


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.stem not in FIRST)
    for item in items:
        if _is_slow(item.path) and not item.get_closest_marker("plain"):
            item.add_marker("slow")
        if item.path.stem in LONGER:
            item.add_marker("longer")
        if "player" in getattr(item, "fixturenames", ()):
            item.add_marker("recorded")


# --- what each test worker found, told once at the end ----------------------------------------------------------------


_FOUND = pytest.StashKey[list[dict[str, Any]]]()
"""Of each test worker: the numbers of recordings, and the generated files that it found stale."""


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_FOUND] = []
    _choose(config)
    Counts.every = {"recorded": 1, QUICK: 0}.get(config.option.markexpr, COMPARED)
    if not hasattr(config, "workerinput"):
        store.tidy_up()
        _use_an_empty_cache(config)


def _choose(config: pytest.Config) -> None:
    """Run all tests for `-m full`, what is beyond a run without it for `-m slow`; leave out the slow ones where neither tests nor markers are named.

    The name of a row of the corpus as `-k` runs that row, also one that only the weekly run judges. A run that names no tests tells the
    slowest ten.
    """
    option = config.option
    whole_run = config.args_source is pytest.Config.ArgsSource.TESTPATHS and not option.keyword
    more = {"full": ALL, "quick": QUICK, "slow": f"slow and {ALL}"} | ({ALL: EVERYDAY} if whole_run else {})
    if option.markexpr == ALL and option.keyword and option.keyword in {case.name for case in recorded_corpus()}:
        more = {ALL: "not delivered"}
    option.markexpr = more.get(option.markexpr, option.markexpr)
    if whole_run and option.durations is None:
        option.durations = 10


def _use_an_empty_cache(config: pytest.Config) -> None:
    """No test reads or writes what the user's own commands keep; recordings stay where they are."""
    os.environ[store.VARIABLE] = str(store.FOLDER)  # for the test workers, which are started later
    folder = tempfile.TemporaryDirectory(prefix="imugrade-tests-")
    config.add_cleanup(folder.cleanup)
    os.environ[CACHE_VARIABLE] = folder.name


def pytest_sessionfinish(session: pytest.Session) -> None:
    sandboxes.close()
    mine = {name: getattr(Counts, name) for name in ("recorded", "compared", "seconds")} | {
        "stale": generated.differences
    }
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["found"] = mine
        return
    found = session.config.stash[_FOUND]
    found.append(mine)
    for file, text in generated.failures([each["stale"] for each in found]).items():
        report = pytest.TestReport(f"tests/{file}", (file, 0, file), {}, "failed", text, "call")
        session.config.hook.pytest_runtest_logreport(report=report)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    if found := getattr(node, "workeroutput", {}).get("found"):
        node.config.stash[_FOUND].append(found)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell how many submissions ran in a real sandbox and how long that took, and how many slow tests were left out."""
    counted = {name: sum(each[name] for each in config.stash[_FOUND]) for name in ("recorded", "compared", "seconds")}
    if counted["recorded"] or counted["compared"]:
        terminalreporter.write_line(
            f"{counted['recorded']} submissions recorded in {store.FOLDER}, {counted['compared']} compared with a real sandbox: "
            f"{counted['seconds']:.0f} s of the test workers' time"
        )
    if config.option.markexpr == EVERYDAY:
        terminalreporter.write_line(f"about {LEFT_OUT:,} more tests with -m full, in about {MINUTES} minutes")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Tell with each failure the command that repeats this test alone."""
    report = yield
    if report.failed:
        report.sections.append(("repeat it alone", f"python -m pytest -n 0 {shlex.quote(item.nodeid)}"))
    return report


@pytest.fixture(scope="session")
def opened() -> Opened:
    """Opens markers with one sandbox, for whatever is marked by other traces or another rubric."""
    return sandboxes.opened


@pytest.fixture(scope="session")
def marker(opened: Opened) -> Iterator[Marker]:
    """A warm one for whatever is marked by the lab's own rubric and data."""
    with opened(bundles.shipped()) as warm:
        yield warm


@pytest.fixture
def ran() -> list[str]:
    """What a made-up marker was given, in order: mostly ids."""
    return []


@pytest.fixture(scope="session")
def cache() -> Path:
    """Where commands, too, keep traces for all workers of a run: to record some takes seconds."""
    return Path(os.environ[CACHE_VARIABLE])


@pytest.fixture(scope="session")
def hidden(cache: Path) -> Traces:
    """Traces of a secret, for whatever holds under any."""
    return bundles.obtain(LAB, SECRET, cache)


@pytest.fixture(scope="session")
def player() -> Marking:
    """A marker that judges from recordings by the lab's own rubric and data, without charts."""
    return RecordedMarker(without_charts())
