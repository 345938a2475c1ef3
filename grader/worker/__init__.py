"""Worker code: it runs in the sandbox beside a student's code, loads files, runs experiments and reports the outcome.

Nothing here decides a grade, and nothing here is trusted. Questions come over a socket, answers are plain arrays and facts, and the
grader judges them in another process. So this package holds no check, trace, rubric or seed, and imports nothing of the grader.
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
    """Import what every submission needs, once, before the first worker is forked.

    Parameters
    ----------
    thorough
        Whether to use each library once, too.
    questions
        A lab's questions: a module with `HANDLERS`, with `sheet_names` if the sheet's code passes names on by ``import *``, with
        `warm_up(thorough)` if it needs libraries of its own, and with `install(lab_configuration)` if it prepares each worker.
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
    """Answer one question of the grader; raise ChangedError if student code has rewritten the worker code."""
    reply = _HANDLERS[op](fields, arrays)
    if _guard is not None:
        _guard.check()
    return reply
