"""Record ground truth (traces of each scenario) on this machine with the program of a lab's reference solution, and cache it.

A simulator's last digits differ between versions and processors, so a recording is valid for one machine only and is always
compared with a tolerance.
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
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from grader.base.errors import GraderError, RequestError
from grader.base.package_data import beside
from grader.engine.lab import Lab
from grader.engine.traces import SCHEMA, Traces, load

CACHE_VARIABLE = "IMUGRADE_CACHE"
RECORDING_LIMIT_S = 300
SCRYPT_COST = {"n": 1 << 17, "r": 8, "p": 2}
"""About a second and 128 MiB for each secret: what somebody pays who tests one guess. Student code sees some 39 bits of what a seed
chose, such as masses and durations, and could test thousands of short secrets a second without this."""

_SOURCES = beside("grader", "").parent


class Subject(Protocol):
    """Protocol of a robot that an instructor provides in place of the lab's: the recorder simulates it to record ground truth."""

    @property
    def identity(self) -> Sequence[str]:
        """Values that a recording of this robot depends on, such as its file's digest; the recording's cache key contains them."""
        ...

    def options(self, folder: Path) -> list[str]:
        """Write the files that the recorder needs into an empty folder, and return the options of its command that name them."""
        ...


def folder_of(lab: Lab) -> Path | None:
    """Return the folder, beside this package, of the program that records a lab's ground truth; None if there is no such program.

    The students' wheel has none. The program is looked for, not imported: an import could run a student's module of the same name.
    """
    package, _, module = lab.recorder.partition(".")
    folder = _SOURCES / package
    return folder if (folder / f"{module}.py").is_file() else None


def default_cache_dir() -> Path:
    """Return the folder of the grader's cache: `$IMUGRADE_CACHE`, or `imugrade` in the platform's folder for caches."""
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "imugrade" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "imugrade"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "imugrade"


@cache
def stretched(secret: str) -> str:
    """Return the seed of hidden traces: scrypt makes it of the instructor's secret in a second, so that guesses are slow to test.

    The seed is not stored: to find it again, a file would need a name or digest of the secret, and who reads that could test
    guesses fast. So each command computes the seed once, and hands the traces to the processes that grade.
    """
    salt, text = b"imugrade hidden scenarios", secret.encode("utf-8", "surrogatepass")
    return hashlib.scrypt(text, salt=salt, **SCRYPT_COST, maxmem=256 << 20, dklen=32).hex()


def recorded(lab: Lab, name: str, seed: str, cache_dir: Path, subject: Subject | None = None) -> Traces:
    """Return a lab's ground truth, `name` being "public" or "hidden", from the cache; if missing or damaged, record and cache it.

    The recorder simulates `subject`; None stands for the lab's own. For "public", `seed` is used as it is. For "hidden" it is the
    instructor's secret and is stretched first: else the numbers, or the cache entry's name, would let anybody test guesses fast.

    Raises
    ------
    GraderError
        If the recorder fails.
    """
    if name != "public":
        seed = stretched(seed)
    entry = cache_dir / "traces" / _cache_key(lab, name, seed, subject)
    try:
        return load(entry / f"{name}.npz")
    except RequestError:
        shutil.rmtree(entry, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        fresh = Path(scratch) / "bundle"
        traces = _record(lab, name, seed, fresh, subject)
        _move_into_cache(fresh, entry)
    return traces


def try_recording(lab: Lab) -> Traces | None:
    """Return ground truth recorded here from a random secret, so that `imugrade doctor` can test this machine.

    None where the package has no program that records, as in a student's kit.

    Raises
    ------
    GraderError, RequestError
        If recording fails, or what it wrote cannot be read.
    """
    if folder_of(lab) is None:
        return None
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        return _record(lab, "hidden", secrets.token_hex(), Path(scratch, "bundle"), None)


def run(module: Sequence[str], what: str, text: str = "") -> subprocess.CompletedProcess[str]:
    """Run a Python module in a new process, as ``python -m`` does in the folder that holds this package; return the ended process.

    Parameters
    ----------
    module : name of the module, then its arguments
    what : the task in an error message
    text : what the process reads from stdin

    Raises
    ------
    GraderError
        If the process cannot be started or exceeds `RECORDING_LIMIT_S`; the caller checks the exit code.
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
    """Return the last line of a failed program's stderr, for an error message; its exit code if stderr is empty."""
    return (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]


def _record(lab: Lab, name: str, seed: str, out: Path, subject: Subject | None) -> Traces:
    """Run the lab's recorder, which writes ground truth into the folder `out`, and return it.

    The seed goes through a pipe, because other users can read a command line.
    """
    command = [lab.recorder, "--out", str(out), "--name", name, "--seed", "-"]
    if subject is not None:
        beside_it = out.parent / "subject"
        beside_it.mkdir()
        command += subject.options(beside_it)
    what = f"recording the {name} traces"
    done = run(command, what, seed)
    if done.returncode:
        raise GraderError(f"{what} failed: {last_line(done)}")
    return load(out / f"{name}.npz")


def _move_into_cache(fresh: Path, entry: Path) -> None:
    """Move a new recording into the cache in one step, so that no process reads half of it; a failure is ignored."""
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
    """Return a recording's name in the cache: a digest of its name, seed, subject, versions, processor and the recorder's files."""
    digest = hashlib.sha256()
    parts = [SCHEMA, name, seed, *map(version, lab.depends_on), platform.machine(), platform.system()]
    parts += [] if subject is None else subject.identity
    digest.update("\0".join(parts).encode("utf-8", "surrogatepass"))
    folder = folder_of(lab)
    sources = [path for path in folder.rglob("*") if path.suffix in (".py", ".xml")] if folder else []
    for source in sorted(sources):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:32]
