"""One `imugrade check` that notes when each of its parts ended: ``python -m tests.benchmarks.stamped FILE SUBMISSION``.

An audit hook tells what is being imported and stamps are put on functions once they are there, so that nothing is imported
earlier than it would be. The clock is the machine's, the same for all processes.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def stamped(file: Path, sample: str) -> None:
    """Check, and write when each part ended."""
    stamps: dict[str, float] = {}

    def stamp(name: str) -> None:
        stamps.setdefault(name, time.perf_counter())

    def after(owner: Any, function: str, name: str) -> None:
        known: Callable[..., Any] = getattr(owner, function)

        def call(*arguments: Any, **named: Any) -> Any:
            try:
                return known(*arguments, **named)
            finally:
                stamp(name)

        setattr(owner, function, call)

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event != "import":
            return
        if arguments[0] == "grader.report.terminal" and "grader.engine.grader" in sys.modules:
            from grader.engine import check_runner, grader
            from grader.sandbox import launch

            after(launch.Zygote, "await_ready", "ready")
            after(check_runner.Session, "run", "judged")
            after(grader.Marker, "mark", "gathered")

    sys.addaudithook(hook)
    from grader import cli
    from grader.commands import opening

    after(opening, "begins", "begun")
    after(opening, "found", "found")
    after(opening, "waiting", "imported")
    code = cli.main(["check", sample])
    stamp("shown")
    file.write_text(json.dumps(stamps))
    raise SystemExit(code)


if __name__ == "__main__":
    stamped(Path(sys.argv[1]), sys.argv[2])
