"""Submissions whose process lies about itself: the record of what one answered, with one of its claims replaced."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from grader.base.errors import Crashed
from grader.sandbox.wire import Frame
from tests.fuzz.answers import Bench, _key

Lie = Callable[[str, Frame], Frame]


def points(bench: Bench, lie: Lie | None = None) -> dict[str, float]:
    """Points of each check; what is asked beyond the record gets no answer."""

    def answer(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        known = bench._answers.get(_key(op, fields, arrays)) or bench._leading.get((op, fields.get("path")))
        if known is None or (op not in ("submit", "outline", "load") and _key(op, fields, arrays) not in bench._answers):
            raise Crashed("nothing is on record")
        return known if lie is None else lie(op, known)

    result = bench._marked(answer)
    assert bench.troubles == []
    return {check.id: float(check.points or 0.0) for criterion in result.criteria for check in criterion.checks}
