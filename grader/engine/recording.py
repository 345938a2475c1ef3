"""Bundles that are recorded where the grading happens, by the lab's own program, and kept for the next time.

A simulator's last digits differ between versions and processors, so a bundle holds for one machine and is always compared with a
tolerance.
"""

from __future__ import annotations

import hashlib
import os
import platform
import secrets
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from grader.base.errors import GraderError, RequestError
from grader.base.package_data import beside
from grader.engine.lab import Lab
from grader.engine.traces import SCHEMA, Traces, load

CACHE_VARIABLE = "IMUGRADE_CACHE"
RECORDING_LIMIT_S = 300

_SOURCES = beside("grader", "").parent


class Subject(Protocol):
    """What the recorder is told to record in the place of what it records by itself."""

    @property
    def identity(self) -> Sequence[str]:
        """Everything that a recording of this subject depends on; part of the cache key."""
        ...

    def options(self, folder: Path) -> list[str]:
        """Of the recorder's command; files that they name are written into this new folder."""
        ...


def folder_of(lab: Lab) -> Path | None:
    """The recorder's folder beside this package. Not looked up by name: a student's folder could be called that."""
    package, _, module = lab.recorder.partition(".")
    folder = _SOURCES / package
    return folder if (folder / f"{module}.py").is_file() else None


def default_cache_dir() -> Path:
    """`$IMUGRADE_CACHE`, or the place where this platform keeps what can be made again."""
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "imugrade" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "imugrade"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "imugrade"


def recorded(lab: Lab, name: str, seed: str, cache_dir: Path, subject: Subject | None = None) -> Traces:
    """From the cache, or recorded and put there. A damaged entry is made again; a cache is not needed.

    Raises
    ------
    GraderError
        If the recorder fails.
    """
    entry = cache_dir / "traces" / _cache_key(lab, name, seed, subject)
    try:
        return load(entry / f"{name}.npz")
    except RequestError:
        shutil.rmtree(entry, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        fresh = Path(scratch) / "bundle"
        traces = _fresh(lab, name, seed, fresh, subject)
        _keep(fresh, entry)
    return traces


def rehearse(lab: Lab) -> Traces | None:
    """Hidden traces from a secret that is thrown away, to see whether they can be had here; None without the recorder.

    Raises
    ------
    GraderError, RequestError
        If they cannot be recorded, or not read.
    """
    if folder_of(lab) is None:
        return None
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        return _fresh(lab, "hidden", secrets.token_hex(), Path(scratch, "bundle"), None)


def run(module: Sequence[str], what: str, text: str = "") -> subprocess.CompletedProcess[str]:
    """Run a module that lies beside this package with its arguments, in a process of its own.

    Raises
    ------
    GraderError
        If it cannot be started or does not end; whether it failed is the caller's to see.
    """
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"} | {"MPLBACKEND": "Agg"}
    try:
        return subprocess.run(
            [sys.executable, "-m", *module],
            input=text,
            cwd=_SOURCES,  # `-m` looks here first
            env=environment,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=RECORDING_LIMIT_S,
            check=False,
        )
    except OSError as error:
        raise GraderError(f"{what} failed: {error.filename or sys.executable}: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise GraderError(f"{what} did not end within {RECORDING_LIMIT_S} s") from None


def last_line(done: subprocess.CompletedProcess[str]) -> str:
    """What a program that failed said last."""
    return (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]


def _fresh(lab: Lab, name: str, seed: str, folder: Path, subject: Subject | None) -> Traces:
    _record(lab, name, seed, folder, subject)
    return load(folder / f"{name}.npz")


def _record(lab: Lab, name: str, seed: str, out: Path, subject: Subject | None) -> None:
    """Run the recorder. The seed goes by a pipe: a command line can be read by other users."""
    command = [lab.recorder, "--out", str(out), "--name", name, "--seed", "-"]
    if subject is not None:
        beside_it = out.parent / "subject"
        beside_it.mkdir()
        command += subject.options(beside_it)
    what = f"recording the {name} traces"
    done = run(command, what, seed)
    if done.returncode:
        raise GraderError(f"{what} failed: {last_line(done)}")


def _keep(fresh: Path, entry: Path) -> None:
    """Put a bundle into the cache in one move, so that nobody sees half of it. Failing to is no harm."""
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=".staging-", dir=entry.parent))  # mode 0700: hidden traces are secret
    except OSError:
        return
    try:
        shutil.copytree(fresh, staging, dirs_exist_ok=True)
        staging.chmod(0o700)  # copytree copies the folder's own mode too
        staging.rename(entry)  # fails where another process was faster, with the same bundle
    except OSError:
        shutil.rmtree(staging, ignore_errors=True)


def _cache_key(lab: Lab, name: str, seed: str, subject: Subject | None = None) -> str:
    """What the numbers depend on: name, seed, subject, versions, processor and the recorder's own files."""
    digest = hashlib.sha256()
    parts = [SCHEMA, name, seed, *map(version, lab.depends_on), platform.machine(), platform.system()]
    parts += [] if subject is None else subject.identity
    digest.update("\0".join(parts).encode("utf-8", "surrogatepass"))
    folder = folder_of(lab)
    sources = [path for path in folder.rglob("*") if path.suffix in (".py", ".xml")] if folder else []
    for source in sorted(sources):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:32]
