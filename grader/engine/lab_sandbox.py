"""Open the sandbox of a lab: its processes hold imported libraries and the code that loads and calls student code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from grader.engine.lab import Lab
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox

WORKER_CODE = Path(__file__).parent.parent / "worker"


def libraries_of(lab: Lab, files: Mapping[str, bytes]) -> tuple[str, ...]:
    """Return those of the lab's slow libraries that a submission may import, to be imported before its code runs.

    A library is returned if its first and its last part, as in ``scipy.signal``, occur in the submission's programs.
    """
    code = b"\n".join(content for path, content in files.items() if path.endswith((".py", ".ipynb")))
    return tuple(name for name in lab.libraries if all(name.split(".")[end].encode() in code for end in (0, -1)))


def open_sandbox(
    lab: Lab, isolation_level: str | None = None, *, libraries: Sequence[str] = (), thorough: bool = True
) -> Sandbox:
    """Open a sandbox for many submissions, which the caller closes; it gets ready in the background, while the caller goes on.

    Parameters
    ----------
    isolation_level : name of an isolation level; GraderError if this machine does not allow it. None takes the best that it allows
    libraries : modules imported in advance, to save time. A submission imports any other itself; its points are the same. The
        grader that uses the sandbox (`Marker`) adds those of `Lab.libraries` once a submission may import them.
    thorough : also run each part of the sandbox's own code once in advance, so that a first use takes none of a submission's time
    """
    return Sandbox(
        Contents(WORKER_CODE, lab.folder / "worker", packages=lab.packages, warm=tuple(libraries), thorough=thorough),
        isolation_level=isolation_level,
    )


def open_sandbox_for(lab: Lab, files: Mapping[str, bytes], isolation_level: str | None = None) -> Sandbox:
    """Open a sandbox as `open_sandbox` does, but for one submission: sooner, as only what its `files` may need is prepared."""
    return open_sandbox(lab, isolation_level, libraries=libraries_of(lab, files), thorough=False)
