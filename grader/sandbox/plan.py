"""What the grader tells a zygote before anything else: which walls to raise, what to show, what to import."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

RUNGS = ("full", "bubblewrap", "landlock", "none")  # best first


@dataclass(frozen=True)
class Contents:
    """What a box is opened for.

    Attributes
    ----------
    harness
        A package folder with `warm_up(thorough)` and `answer(op, fields, arrays) -> (fields, arrays)`.
    readable
        Further paths that the box shows read-only.
    warm
        Modules that are imported once for all workers. On the lowest rung each worker imports what it needs.
    thorough
        Whether the harness also uses each part once before the first worker: it pays where many of them follow.
    """

    harness: Path
    readable: tuple[Path, ...] = ()
    warm: tuple[str, ...] = ()
    thorough: bool = False


@dataclass(frozen=True)
class Plan:
    """Paths are absolute and, but for `visible`, free of links.

    Attributes
    ----------
    rung
        One of `RUNGS`.
    harness
        The folder that is imported as a package.
    visible, hidden
        What can be read in the box, and the folders below that which cannot.
    code
        The sandbox's own modules that run in the box.
    search
        `sys.path` of the box.
    warm, thorough
        See `Contents`.
    fonts
        Files for the zygote's cache: matplotlib's lists of fonts, which take 150 ms to make.
    scratch
        Folders that workers start in, one of them a worker.
    cache
        The zygote's own writable folder.
    decoy
        A file that no box may read: the walls are tried against it.
    end_with_parent
        Whether the kernel kills the zygote with the thread that started it; it ends anyway when the grader hangs up.
    """

    rung: str
    harness: str
    visible: tuple[str, ...]
    hidden: tuple[str, ...]
    code: tuple[str, ...]
    search: tuple[str, ...]
    warm: tuple[str, ...]
    thorough: bool
    fonts: tuple[str, ...]
    scratch: tuple[str, ...]
    cache: str
    decoy: str
    end_with_parent: bool

    def to_json(self) -> bytes:
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_json(cls, text: bytes) -> Plan:
        values = json.loads(text).items()
        fields: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in values}
        return cls(**fields)
