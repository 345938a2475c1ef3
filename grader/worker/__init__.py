"""Run in the sandbox beside a student's code: load files, run experiments and report the outcome.

Nothing here decides anything, and nothing here is trusted: the questions come over the wire, the answers are plain arrays
and facts, and the grader judges them in another process. So this package holds no check, no trace, no rubric and no seed,
and imports nothing of the trusted part.
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
    thorough : use each part once, too
    questions : a lab's, with its `HANDLERS` and, if the sheet's code brings names along for ``import *``, `sheet_names`
    """
    global _guard  # noqa: PLW0603 - there is one worker code in a process
    _HANDLERS.update(getattr(questions, "HANDLERS", {}))
    STATE.sheet_names = getattr(questions, "sheet_names", STATE.sheet_names)
    environment.import_libraries()
    artist_facts.remember_classes()
    if thorough:
        environment.use_libraries()
    _guard = Guard(__name__.partition(".")[0])
    _guard.hide()


def answer(op: str, fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer one question of the grader; ChangedError where the worker code was rewritten meanwhile."""
    reply = _HANDLERS[op](fields, arrays)
    if _guard is not None:
        _guard.check()
    return reply
