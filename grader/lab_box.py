"""The box that the lab's questions are asked in: a sandbox with the harness `inside/`, and the libraries that it shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from .sandbox.box import Box
from .sandbox.plan import Contents

HARNESS = Path(__file__).parent / "inside"
LIBRARIES = (
    "scipy.integrate", "scipy.signal", "scipy.spatial.transform", "scipy.stats", "matplotlib.animation",
)  # fmt: skip
"""What some submissions import, each of which takes longer to import than the rest of its work; a class shares it."""


def libraries_of(files: Mapping[str, bytes]) -> tuple[str, ...]:
    """Those of `LIBRARIES` that the code of one submission can mean: it holds the first and the last part of the name."""
    code = b"\n".join(content for path, content in files.items() if path.endswith((".py", ".ipynb")))
    return tuple(name for name in LIBRARIES if all(name.split(".")[end].encode() in code for end in (0, -1)))


def open_box(rung: str | None = None, libraries: Sequence[str] = LIBRARIES, *, thorough: bool = True) -> Box:
    """A box for many submissions, which warms up while the caller goes on.

    Parameters
    ----------
    rung : the best that this machine allows if None
    libraries : imported once for all submissions; any other is imported by the submission that wants it, with the same marks
    thorough : also use each part once beforehand, so that no submission pays for a first time
    """
    return Box(Contents(HARNESS, warm=tuple(libraries), thorough=thorough), rung=rung)


def open_box_for(files: Mapping[str, bytes], rung: str | None = None) -> Box:
    """A box for one submission, ready sooner: nothing is done beforehand that it can do without."""
    return open_box(rung, libraries_of(files), thorough=False)
