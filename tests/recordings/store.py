"""The folder of recordings: one file a case, keyed by all that can change an answer.

A file that is damaged, or that belongs to another key, is as good as none.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import os
import pickle
import platform
import tempfile
import zlib
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path

from grader.engine.lab_sandbox import WORKER_CODE
from grader.engine.recording import default_cache_dir
from grader.engine.rubric import Limits
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from grader.sandbox import surroundings
from tests.recordings.answers import Recording

VARIABLE = "IMUGRADE_RECORDINGS"
FOLDER = Path(os.environ.get(VARIABLE) or default_cache_dir() / "recordings")
MOST_BYTES = 2_000_000_000
"""Most that the folder may hold, some four times what one state of the worker code needs; the longest unread is deleted first."""
_SCHEMA = "imugrade/recording/v1"
_LIBRARIES = ("mujoco", "numpy", "scipy", "matplotlib", "pillow")
_DIGEST_BYTES = 32
_LEVEL = 1  # of zlib: reading takes the same time at each, writing four times as long at 6


def key(submission: Submission, only: str | None, limits: Limits) -> str:
    """Return the key of a case: worker code, versions, submission and limits.

    The questions are not in it: each answer has its own key, see `answers`.
    """
    case = (only, sorted(submission.above.items()), sorted(submission.files.items()), asdict(limits))
    return hashlib.sha256(f"{_machine()}\0{worker_code()}\0{case!r}".encode("utf-8", "surrogatepass")).hexdigest()


@cache
def _machine() -> str:
    versions = (f"{name} {version(name)}" for name in _LIBRARIES)
    python = (platform.python_implementation(), platform.python_version(), platform.system(), platform.machine())
    return " ".join((_SCHEMA, *python, *versions))


def worker_files() -> list[Path]:
    """Return the modules that run beside student code: of the sandbox, of the worker and of the lab's questions."""
    folders = (WORKER_CODE, LAB.folder / "worker")
    return [*map(Path, surroundings.code()), *(path for folder in folders for path in sorted(folder.rglob("*.py")))]


@cache
def worker_code() -> str:
    """Return a digest of what the worker's modules mean: comments, docstrings and layout change nothing."""
    digest = hashlib.sha256()
    for path in worker_files():
        digest.update(f"{path.parent.name}/{path.name}\0{meaning(path.read_text('utf-8'))}\0".encode())
    return digest.hexdigest()


def meaning(source: str) -> str:
    """Return the syntax tree of a module as text, without docstrings."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return ast.dump(tree)


def _is_text(statement: ast.stmt) -> bool:
    """Whether a statement is a string and nothing else: a docstring, or the comment below a constant."""
    return isinstance(statement, ast.Expr) and isinstance(getattr(statement.value, "value", None), str)


def path_of(key: str) -> Path:
    return FOLDER / f"{key[:32]}.pickle"


def read(key: str) -> Recording:
    """Return the recording of a case; an empty one if there is none, or if its file is damaged or another's."""
    path = path_of(key)
    try:
        data = path.read_bytes()
        digest, body = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
        if hashlib.sha256(body).digest() != digest:
            return Recording()
        of, recording = pickle.loads(zlib.decompress(body))
        os.utime(path)
    except (OSError, ValueError, TypeError, AttributeError, ImportError, pickle.UnpicklingError):
        return Recording()
    assert isinstance(recording, Recording)
    return recording if of == key else Recording()


def write(key: str, recording: Recording) -> None:
    """Put a recording in place in one step: other processes see the old file or the new one."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    body = zlib.compress(pickle.dumps((key, replace(recording, new=False)), protocol=5), _LEVEL)
    with tempfile.NamedTemporaryFile(dir=FOLDER, prefix=".", delete=False) as file:
        file.write(hashlib.sha256(body).digest() + body)
    os.replace(file.name, path_of(key))


def tidy_up(most_bytes: int = MOST_BYTES) -> None:
    """Delete the files that were not read for the longest time, until the rest is small enough."""
    total = 0
    read_at = []
    for path in FOLDER.glob("*"):
        with contextlib.suppress(FileNotFoundError):  # another run was quicker
            read_at.append((path.stat().st_mtime, path.stat().st_size, path))
    for _, size, path in sorted(read_at, reverse=True):
        total += size
        if total > most_bytes:
            path.unlink(missing_ok=True)
