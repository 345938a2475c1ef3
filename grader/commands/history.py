"""What the last check of a folder found, kept in the folder: ``.imugrade/``, which git ignores and no submission holds.

It is a convenience. Where it cannot be kept, or what is there is none of ours, there is no history and no complaint.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from grader.engine.results import CriterionResult, ExtensionResult, Result
from grader.ground.errors import RequestError
from grader.ground.files import write_whole
from grader.ground.text import printable

FOLDER = ".imugrade"
SCHEMA = "imugrade/last-check/v1"
_MOST_BYTES = 100_000


def recalled(path: Path, result: Result) -> dict[str, float]:
    """The points of each check at the last check, by its id, as far as they were for the same thing as those of `result`."""
    record = _record(path)
    points = record.get("points")
    if any(record.get(key) != value for key, value in _for(result).items()) or not isinstance(points, dict):
        return {}
    return {id_: value for id_, value in points.items() if type(value) in (int, float) and math.isfinite(value)}


def remember(path: Path, result: Result, before: Mapping[str, float]) -> dict[str, float]:
    """Keep the points of `result` beside those of checks that were not asked for this time; returns them all."""
    parts: tuple[CriterionResult | ExtensionResult, ...] = (*result.criteria, *result.extensions)
    now = {check.id: check.points for part in parts for check in part.checks if check.points is not None}
    points = {**before, **now}
    if result.status in ("graded", "incomplete"):
        with suppress(OSError, RequestError):
            _keep(path, {**_for(result), "points": points})
    return points


def made(path: Path) -> Path:
    """The cache of a folder, which git ignores and no submission holds.

    Raises
    ------
    RequestError
        If it cannot be there.
    """
    place = path / FOLDER
    if place.is_symlink() or (place.exists() and not place.is_dir()) or not path.is_dir():
        raise RequestError(f"{printable(str(place), 500)} is no folder of ours; name another with -o")
    place.mkdir(exist_ok=True)
    write_whole(place / ".gitignore", "*\n")
    return place


def _keep(path: Path, record: Mapping[str, Any]) -> None:
    write_whole(made(path) / "last_check.json", json.dumps(record, indent=1) + "\n")


def _for(result: Result) -> dict[str, Any]:
    """Points compare with points of the same rubric and the same truth alone."""
    return {"schema": SCHEMA, **{key: result.provenance.get(key) for key in ("rubric_sha256", "traces_sha256")}}


def _record(path: Path) -> dict[str, Any]:
    """Whatever stands there; the folder may be a stranger's."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        with open(path / FOLDER / "last_check.json", "rb", opener=lambda name, _: os.open(name, flags)) as stream:
            record = json.loads(stream.read(_MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return {}
    return record if isinstance(record, dict) else {}
