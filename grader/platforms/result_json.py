"""`--format json`: the result as it is in `result.json`, for a program of the user's own."""

from __future__ import annotations

from grader.engine.results import to_json
from grader.platforms.platform import Help, Platform

PLATFORM = Platform(
    name="json",
    title="result.json",
    help=Help(respond="The result as it is, for a program of your own."),
    respond=lambda result, _: to_json(result),
    keeps_secrets=True,
)
