"""The sandbox that a lab's questions are asked in: a sandbox with the worker code, and the libraries that all submissions share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.engine.lab import Lab
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox

WORKER_CODE = Path(__file__).parent.parent / "worker"


def libraries_of(lab: Lab, files: Mapping[str, bytes]) -> tuple[str, ...]:
    """Those of a lab's libraries that the code of one submission can mean: it holds the first and the last part of the name."""
    code = b"\n".join(content for path, content in files.items() if path.endswith((".py", ".ipynb")))
    return tuple(name for name in lab.libraries if all(name.split(".")[end].encode() in code for end in (0, -1)))


def open_sandbox(
    lab: Lab, isolation_level: str | None = None, *, libraries: Sequence[str] = (), thorough: bool = True
) -> Sandbox:
    """A sandbox for many submissions, which warms up while the caller goes on.

    Parameters
    ----------
    isolation_level : the best that this machine allows if None
    libraries : imported beforehand; a marker has those that a submission can mean imported with the first that does, for all that
        follow, and any other is imported by the submission that wants it, with the same marks
    thorough : also use each part once beforehand, so that no submission pays for a first time
    """
    return Sandbox(
        Contents(WORKER_CODE, lab.folder / "worker", warm=tuple(libraries), thorough=thorough),
        isolation_level=isolation_level,
    )


def open_sandbox_for(lab: Lab, files: Mapping[str, bytes], isolation_level: str | None = None) -> Sandbox:
    """A sandbox for one submission, ready sooner: nothing is done beforehand that it can do without."""
    return open_sandbox(lab, isolation_level, libraries=libraries_of(lab, files), thorough=False)
