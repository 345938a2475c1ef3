"""What runs in the box beside a student's code: it loads files, runs experiments and reports what came out.

Nothing here decides anything, and nothing here is trusted: the questions come over the wire, the answers are plain arrays
and facts, and the grader judges them in another process. So this package holds no check, no trace, no rubric and no seed,
and imports nothing of the trusted part.
"""

from __future__ import annotations

from typing import Any

from . import extensions, loading, noise, pictures, questions, seeing, world
from .guard import Guard

_HANDLERS = {
    "submit": loading.submit,
    "outline": loading.outline,
    "load": loading.load,
    "run_script": loading.run_script,
    "read": questions.read,
    "simulate": questions.simulate,
    "replay": questions.replay,
    "noise": noise.noise,
    "default_bias": noise.default_bias,
    "filter": questions.filter_cases,
    "plot": questions.plot,
    "image": pictures.decode,
    **extensions.HANDLERS,
}


_guard: Guard | None = None


def warm_up(thorough: bool) -> None:
    """Import what every submission needs, once, before the first worker is forked; if asked to, use each part once, too."""
    global _guard  # noqa: PLW0603 - there is one harness in a process
    world.import_libraries()
    seeing.remember_classes()
    if thorough:
        world.use_libraries()
    _guard = Guard(__name__)
    _guard.hide()


def answer(op: str, fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer one question of the grader; ChangedError where the harness was rewritten meanwhile."""
    reply = _HANDLERS[op](fields, arrays)
    if _guard is not None:
        _guard.check()
    return reply
