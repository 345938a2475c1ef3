"""Set-up of a sandbox: the part that its caller chooses (`Contents`), and all that the zygote (parent process) is sent (`Plan`)."""

from __future__ import annotations

import json
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from .isolation_levels import LEVELS, IsolationLevel


@dataclass(frozen=True)
class Contents:
    """The code that runs in a sandbox beside student code, and what it needs; the caller that opens a sandbox fills it in.

    Attributes
    ----------
    worker_code
        A package folder with `warm_up(thorough)` and `answer(op, fields, arrays) -> (fields, arrays)`.
    questions
        Folder of the lab's package for further requests, or None. With one, the call is `warm_up(thorough, imported_package)`.
    readable
        Further paths that the sandbox shows read-only.
    packages
        Names of distributions that the sandbox shows, with what they need; others that only the grader needs stay hidden.
    warm
        Modules imported once for all workers (on the lowest level, by each that needs them); `Sandbox.warm` can add more.
    thorough
        Whether each library is also used once before the first worker: it pays if many workers follow. Ignored on the lowest level.
    """

    worker_code: Path
    questions: Path | None = None
    readable: tuple[Path, ...] = ()
    packages: tuple[str, ...] = ()
    warm: tuple[str, ...] = ()
    thorough: bool = False


@dataclass(frozen=True)
class Plan:
    """Set-up of a zygote (the parent process), sent to it first. Paths are absolute and, but for `visible`, free of links.

    Attributes
    ----------
    isolation_level
        The level that is set up.
    worker_code, questions
        The folders that are imported as packages: the worker's own code, and the lab's handlers of its questions ("": none).
    visible, hidden
        What can be read in the sandbox, and what below that cannot.
    code
        Paths of the modules of `grader.sandbox` that run in the sandbox.
    search
        `sys.path` of the sandbox.
    warm, thorough
        Modules to import once for all workers; whether to also use each library once, so that the first use costs no worker time.
    fonts
        Matplotlib's lists of fonts, put into the zygote's cache, as they take 150 ms to make.
    scratch
        Folders that workers start in: one for all if each worker mounts a new one there, else one for each running worker.
    cache
        The zygote's own writable folder.
    decoy
        A file of the grader that no sandbox may read: the isolation is tried against it.
    end_with_parent
        Whether the kernel kills the zygote with the thread that started it; it ends anyway when the grader hangs up.
    """

    isolation_level: IsolationLevel
    worker_code: str
    questions: str
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

    def packed(self) -> bytes:
        """Return the plan as one compressed message, which fits into a socket's buffer even with thousands of packages."""
        return zlib.compress(
            json.dumps({**asdict(self), "isolation_level": LEVELS.index(self.isolation_level)}).encode(), 1
        )

    @classmethod
    def unpacked(cls, message: bytes) -> Plan:
        values = json.loads(zlib.decompress(message)).items()
        fields: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in values}
        return cls(**{**fields, "isolation_level": LEVELS[fields["isolation_level"]]})
