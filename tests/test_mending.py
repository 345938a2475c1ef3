"""How often a function raised is counted whatever a process claims: a count that stumbles would leave a check without a mark."""

from __future__ import annotations

from typing import Any

import pytest

from grader.engine.conversation import _errors
from grader.sandbox.wire import Frame

pytestmark = pytest.mark.quick


@pytest.mark.parametrize(
    ("fields", "count"),
    [
        ({}, 0),
        ({"error": None}, 0),
        ({"error": {}}, 1),
        ({"error": None, "cases": [{"error": {}}, {"error": None}, {"error": {}}]}, 2),
        ({"cases": 5}, 0),
        ({"cases": "errors"}, 0),
        ({"cases": {"error": 1}}, 0),
        ({"cases": [5, None, "error", ["error"], {}]}, 0),
    ],
)
def test_what_raised_is_counted(fields: dict[str, Any], count: int) -> None:
    assert _errors(Frame(fields, {})) == count
