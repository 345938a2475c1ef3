"""Worker code: our code that runs in the sandbox beside a student's code, loads its files, runs experiments and reports results.

Nothing here decides a grade, and the grader trusts nothing that comes from here. The grader sends requests over a socket, the
worker answers with arrays and facts (plain data), and a check in another process judges them. So this package holds no check,
trace, rubric or seed, and imports nothing of the grader.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import artist_facts, environment, loading, pictures
from .guard import Guard
from .submission import STATE

Handler = Callable[[dict[str, Any], dict[str, Any]], tuple[dict[str, Any], dict[str, Any]]]
_HANDLERS: dict[str, Handler] = {
    "submit": loading.submit,
    "outline": loading.outline,
    "load": loading.load,
    "run_script": loading.run_script,
    "image": pictures.decode,
}


_guard: Guard | None = None


def warm_up(thorough: bool, questions: Any = None) -> None:
    """Import what every submission needs, once, before the first worker is forked, so that no worker waits for it.

    Parameters
    ----------
    thorough : whether to use each library once, too, because its first use is slow
    questions : the lab's own module, if it has one. It may define `HANDLERS`, {request: function that answers it};
        `warm_up(thorough)`, called here; `install(lab_configuration)`, which prepares each worker; and `sheet_names`, which
        returns what a star import from a file of the lab sheet brings
    """
    global _guard  # noqa: PLW0603 - there is one worker code in a process
    _HANDLERS.update(getattr(questions, "HANDLERS", {}))
    STATE.sheet_names = getattr(questions, "sheet_names", STATE.sheet_names)
    STATE.install_lab = getattr(questions, "install", STATE.install_lab)
    environment.import_libraries()
    artist_facts.remember_classes()
    if thorough:
        environment.use_libraries()
    getattr(questions, "warm_up", lambda thorough: None)(thorough)
    _guard = Guard(__name__.partition(".")[0])
    _guard.hide()


def answer(op: str, fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the reply (data, arrays) to request `op`; raise KeyError if unknown, ChangedError if worker code was replaced."""
    reply = _HANDLERS[op](fields, arrays)
    if _guard is not None:
        _guard.check()
    return reply
