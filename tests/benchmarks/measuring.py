"""What a command costs, with everything that it starts."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {
    **os.environ, "PYTHONDONTWRITEBYTECODE": "", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "COLUMNS": "80",
    "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
}  # fmt: skip
"""One thread, no plugins, and modules that are compiled once, as they are where they are installed."""
PLAIN_PYTEST = (
    "-m",
    "pytest",
    "-q",
    "-p",
    "no:cacheprovider",
    "-c",
    os.devnull,
    str(ROOT / "tests/benchmarks/plain.py"),
)


@contextmanager
def _kept_to(cores: Collection[int]) -> Iterator[None]:
    """This process on some cores, and so whatever it starts meanwhile."""
    every = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores or every)
    try:
        yield
    finally:
        os.sched_setaffinity(0, every)


def cost(command: list[str], folder: Path, cores: Collection[int] = ()) -> tuple[float, float]:
    """CPU and wall seconds of a command with everything that it starts; on these cores alone, where some are given."""
    started = time.perf_counter()
    with (
        _kept_to(cores),
        subprocess.Popen(
            command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process,
    ):
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)[:200]}: ended with {process.returncode}")
    return used.ru_utime + used.ru_stime, time.perf_counter() - started
