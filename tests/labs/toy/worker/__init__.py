"""The toy lab's one question, as it runs in the sandbox."""

from __future__ import annotations

from typing import Any

from grader.worker import faults, submission
from grader.worker.values import Packer


def call(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Call one function with the values."""
    packer = Packer()
    answer: dict[str, Any] = {"value": None}
    try:
        answer["value"] = packer.node(submission.find(fields["name"], fields["path"])(arrays["values"].copy()))
    except BaseException as raised:  # whatever student code raises
        answer["error"] = faults.describe(raised)
    return answer, packer.arrays


HANDLERS = {"call": call}
