"""Which walls this machine allows, found out by raising them: the best rung for a box, all of them for the doctor."""

from __future__ import annotations

import contextlib
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .plan import RUNGS, Contents
from .process import WallsRefusedError, ZygoteGoneError

if TYPE_CHECKING:
    from .launch import Zygote


@dataclass(frozen=True)
class Rung:
    """One rung of the ladder, best first: whether it holds here, and if not (or not quite), why."""

    name: str
    usable: bool
    reason: str


def probe() -> list[Rung]:
    """Try every rung in a child process, with its walls tested from inside; about 50 ms each."""
    return [_tried(name) for name in RUNGS]


def _tried(name: str) -> Rung:
    if name == "none":
        return Rung(name, True, "a fresh process with a time limit, and no walls")
    try:
        zygote = raise_walls(name, Contents(Path(__file__).parent))
    except WallsRefusedError as error:
        return Rung(name, False, str(error))
    zygote.close()
    return Rung(name, True, caveat(zygote))


def caveat(zygote: Zygote) -> str:
    """What is missing on a rung that holds; empty if nothing is."""
    return "this kernel has no Landlock; the other walls hold" if zygote.without_landlock else ""


def raise_walls(name: str, contents: Contents) -> Zygote:
    """Start a zygote on this very rung, or raise WallsRefusedError."""
    if sys.platform != "linux":
        raise WallsRefusedError("needs Linux")
    from . import bubblewrap, launch  # noqa: PLC0415 - of Linux only

    if name == "bubblewrap" and not bubblewrap.is_installed():
        raise WallsRefusedError("the program bwrap is not installed")
    with contextlib.suppress(ZygoteGoneError):
        return launch.Zygote(name, contents)
    try:
        return launch.Zygote(name, contents)
    except ZygoteGoneError as error:
        raise WallsRefusedError(f"{error}, twice") from None


def climb(contents: Contents) -> tuple[Zygote | None, str]:
    """Start a zygote on the best rung that holds (None: there is none), and say why it is not a better one."""
    refused: list[str] = []
    for name in RUNGS[:-1]:
        try:
            zygote = raise_walls(name, contents)
        except WallsRefusedError as error:
            refused.append(f"{name}: {error}")
            continue
        return zygote, "; ".join(filter(None, [*refused, caveat(zygote)]))
    return None, "; ".join(refused)
