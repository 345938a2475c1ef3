"""What this machine can isolate, and which versions are in use: `imugrade doctor`."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
from dataclasses import dataclass

from grader import __version__
from grader.sandbox.ladder import probe

_PACKAGES = ("mujoco", "numpy", "scipy", "matplotlib", "pytest")


@dataclass(frozen=True)
class Finding:
    """One line: a name, whether it is as it should be (None: neither), and what was found."""

    name: str
    good: bool | None
    text: str


def examine() -> list[tuple[str, list[Finding]]]:
    """All findings under their headings. The walls are tried out, not looked up."""
    return [("Isolation", _isolation()), ("Versions", _versions()), ("Traces", [_reference()])]


def _isolation() -> list[Finding]:
    rungs = probe()
    best = next((rung.name for rung in rungs if rung.usable), "none")
    use = {"none": "no isolation: fine for your own code, `grade` asks for --trust-submissions"}
    rows = [Finding(rung.name, rung.usable, rung.reason or "works here") for rung in rungs if rung.name != "none"]
    return [*rows, Finding("in use", best != "none", use.get(best, best))]


def _versions() -> list[Finding]:
    rows = [Finding("imugrade", None, __version__), Finding("Python", None, platform.python_version())]
    rows += [Finding(name, *_version(name)) for name in _PACKAGES]
    return [*rows, Finding("system", None, platform.platform())]


def _version(package: str) -> tuple[bool | None, str]:
    try:
        return None, importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return False, f"not installed; pip install {package}"


def _reference() -> Finding:
    if importlib.util.find_spec("reference") is None:
        return Finding("reference", None, "not installed: the public traces only, no --seed")
    return Finding("reference", True, "installed: traces can be recorded from a seed")
