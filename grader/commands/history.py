"""The points of the last check of a submission, kept in the user's cache folder: `check` writes nothing into the submission's.

The memory is a convenience. If it cannot be read or written, there is no history, and nobody is told.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.engine.recording import default_cache_dir
from grader.engine.results import CriterionResult, ExtensionResult, Result

SCHEMA = "imugrade/last-check/v1"


def last_points(path: Path, result: Result) -> dict[str, float]:
    """Return the points of each check at the last check of `path`, by id, if rubric and traces were those of `result`."""
    record = _record(path)
    points = record.get("points")
    if any(record.get(key) != value for key, value in _for(result).items()) or not isinstance(points, dict):
        return {}
    return {id_: value for id_, value in points.items() if type(value) in (int, float) and math.isfinite(value)}


def remember(path: Path, result: Result, before: Mapping[str, float]) -> dict[str, float]:
    """Keep the points of `result`, and those of checks that were not run this time; return them all."""
    parts: tuple[CriterionResult | ExtensionResult, ...] = (*result.criteria, *result.extensions)
    now = {check.id: check.points for part in parts for check in part.checks if check.points is not None}
    points = {**before, **now}
    if result.status in ("graded", "incomplete"):
        with suppress(OSError, RequestError, RuntimeError):
            write_whole(place_of(path), json.dumps({**_for(result), "points": points}, indent=1) + "\n")
    return points


def place_of(path: Path) -> Path:
    """Return the file that remembers the last check of `path`.

    Raises
    ------
    RuntimeError
        If this user has no home folder.
    """
    name = hashlib.sha256(os.fsencode(os.path.realpath(path))).hexdigest()[:32]
    return default_cache_dir() / "last_checks" / f"{name}.json"


def _for(result: Result) -> dict[str, Any]:
    """Return what has to be the same for points to be compared: the rubric and the traces."""
    return {"schema": SCHEMA, **{key: result.provenance.get(key) for key in ("rubric_sha256", "traces_sha256")}}


def _record(path: Path) -> dict[str, Any]:
    try:
        record = json.loads(place_of(path).read_bytes())
    except (OSError, ValueError, RecursionError, RuntimeError):
        return {}
    return record if isinstance(record, dict) else {}
