"""The script of a zygote, the parent process from which workers are forked; it starts with nothing of the grader in it.

    python -B -s zygote.py CONTROL_FD             a zygote on Linux: receives its set-up, then serves workers
    python -B -s zygote.py --plain LINE_FD PLAN   one worker without isolation, on any system

The set-up is a `plan.Plan`; PLAN is a short one in JSON (see `plain_worker.start`). As the script must not import the grader's
package, it makes its own folder a package `_imugrade_sandbox`, and takes the folder off `sys.path` before any import but `sys`.
"""

from __future__ import annotations

import sys

_FOLDER = sys.path.pop(0)

import importlib  # noqa: E402
import types  # noqa: E402

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

_PACKAGE = "_imugrade_sandbox"


def _module(name: str) -> types.ModuleType:
    if _PACKAGE not in sys.modules:
        package = types.ModuleType(_PACKAGE)
        package.__path__ = [_FOLDER]
        sys.modules[_PACKAGE] = package
    return importlib.import_module(f"{_PACKAGE}.{name}")


def _start() -> Callable[[], None] | None:
    plain = sys.argv[1] == "--plain"
    work: Callable[[], None] | None
    work = _module("plain_worker").start(sys.argv[2:]) if plain else _module("serve").main(int(sys.argv[1]))
    return work


if __name__ == "__main__":
    _work = _start()
    if _work is not None:  # here, with every other frame gone, so that the student's code finds none to walk up to
        _work()
