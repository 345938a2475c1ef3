"""Find out which isolation levels this machine allows, by trying: the best one for a sandbox, all of them for `doctor`."""

from __future__ import annotations

import contextlib
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .isolation_levels import LEVELS, IsolationLevel
from .plan import Contents
from .process import IsolationRefusedError, ZygoteGoneError

if TYPE_CHECKING:
    from .launch import Zygote


@dataclass(frozen=True)
class LevelResult:
    """An isolation level, whether it works on this machine, and the reason if it does not, or not completely (else "")."""

    isolation_level: IsolationLevel
    usable: bool
    reason: str


def probe() -> list[LevelResult]:
    """Return for each isolation level, best first, whether it works here, for `imugrade doctor`; a try takes about 50 ms."""
    return [_try_level(isolation_level) for isolation_level in LEVELS]


def _try_level(isolation_level: IsolationLevel) -> LevelResult:
    if not isolation_level.isolates:
        return LevelResult(isolation_level, True, "a fresh process with a time limit, and no isolation")
    try:
        zygote = start_zygote(isolation_level, Contents(Path(__file__).parent))
    except IsolationRefusedError as error:
        return LevelResult(isolation_level, False, str(error))
    zygote.close()
    return LevelResult(isolation_level, True, caveat(zygote))


def caveat(zygote: Zygote) -> str:
    """Return what a zygote's isolation lacks on this kernel, which may have no Landlock, as a text for reports; "" if nothing."""
    return "this kernel has no Landlock; the other layers hold" if zygote.without_landlock else ""


def start_zygote(isolation_level: IsolationLevel, contents: Contents) -> Zygote:
    """Start a zygote (the parent process) on exactly this isolation level, for the worker code (not the student's) in `contents`.

    A zygote that is killed before it is isolated, for lack of memory say, is started once more. Raise IsolationRefusedError if it
    is killed again, or if this machine does not allow the level.
    """
    if sys.platform != "linux":
        raise IsolationRefusedError("needs Linux")
    from . import launch  # noqa: PLC0415 - of Linux only

    if isolation_level.program and shutil.which(isolation_level.program) is None:
        raise IsolationRefusedError(f"the program {isolation_level.program} is not installed")
    with contextlib.suppress(ZygoteGoneError):
        return launch.Zygote(isolation_level, contents)
    try:
        return launch.Zygote(isolation_level, contents)
    except ZygoteGoneError as error:
        raise IsolationRefusedError(f"{error}, twice") from None


def best_zygote(contents: Contents) -> tuple[Zygote | None, str]:
    """Return a zygote (parent process) for the worker code in `contents`, on the best level possible here, and a text for reports.

    None as zygote means that only the level "none" works, without isolation or zygote. The text says why no better level
    works, and what the level in use lacks on this kernel; "" if there is nothing to say.
    """
    refused: list[str] = []
    for isolation_level in filter(lambda each: each.isolates, LEVELS):
        try:
            zygote = start_zygote(isolation_level, contents)
        except IsolationRefusedError as error:
            refused.append(f"{isolation_level.name}: {error}")
            continue
        return zygote, "; ".join(filter(None, [*refused, caveat(zygote)]))
    return None, "; ".join(refused)
