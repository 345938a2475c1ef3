"""A short way through every isolation level that this machine allows, for users other than the one who runs the tests.

python -m tests.sandbox.smoke: prints one line an isolation level; with an argument: opens a sandbox on that isolation level, prints the processes
behind it, and waits to be killed.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from grader.sandbox.level_choice import probe
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox

WORKER_CODE = Path(__file__).parent / "probe_worker"
SOURCE = f"""
import os, socket
def held(call, *arguments):
    try:
        call(*arguments)
    except OSError:
        return True
result = [held(socket.socket), held(os.fork), held(open, {os.path.abspath(__file__)!r}), held(open, '../leak', 'w')]
"""


def survey() -> None:
    for tried in probe():
        if tried.usable and tried.isolation_level.isolates:
            with (
                Sandbox(Contents(WORKER_CODE), isolation_level=tried.isolation_level.name) as sandbox,
                sandbox.worker() as worker,
            ):
                held = worker.ask("run", {"source": SOURCE}).fields["result"]
                print(tried.isolation_level.name, os.getuid(), all(held), flush=True)


def linger(name: str) -> None:
    with Sandbox(Contents(WORKER_CODE), isolation_level=name) as sandbox, sandbox.worker() as worker:
        process = worker._process
        pids = [process._popen.pid] if not sandbox.isolation_level.isolates else [sandbox._zygote.pid, process._pid]  # type: ignore
        print(*pids, flush=True)
        worker.ask("run", {"source": "while True: pass"}, cpu_s=60)


if __name__ == "__main__":
    linger(sys.argv[1]) if sys.argv[1:] else survey()
