"""The folder of recordings: one file a case, keyed by all that can change an answer.

A file that is damaged, or that belongs to another key, is as good as none.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import json
import os
import platform
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from grader.engine.lab_sandbox import WORKER_CODE
from grader.engine.recording import default_cache_dir
from grader.engine.rubric import Limits
from grader.intake import Submission
from grader.labs.imu.lab import LAB
from grader.sandbox import surroundings
from grader.sandbox.wire import Frame
from tests.recordings.answers import Answer, Recording

VARIABLE = "IMUGRADE_RECORDINGS"
FOLDER = Path(os.environ.get(VARIABLE) or default_cache_dir() / "recordings")
MOST_BYTES = 2_000_000_000
"""Most that the folder may hold, some four times what one state of the worker code needs; the longest unread is deleted first."""
_SCHEMA = "imugrade/recording/v1"
_LIBRARIES = ("mujoco", "numpy", "scipy", "matplotlib", "pillow")
_DIGEST_BYTES, _LENGTH_BYTES = 32, 8
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
    return FOLDER / f"{key[:32]}.recording"


def read(key: str) -> Recording:
    """Return the recording of a case; an empty one if there is none, or if its file is damaged or another's."""
    path = path_of(key)
    try:
        recording = _decoded(path.read_bytes(), key)
        os.utime(path)
    except (OSError, ValueError, KeyError, TypeError, IndexError, zlib.error):
        return Recording()
    return recording


def write(key: str, recording: Recording) -> None:
    """Put a recording in place in one step: other processes see the old file or the new one."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=FOLDER, prefix=".", delete=False) as file:
        file.write(_encoded(recording, key))
    os.replace(file.name, path_of(key))


def tidy_up(most_bytes: int = MOST_BYTES) -> None:
    """Delete the files that were not read for the longest time, until the rest is small enough."""
    total = 0
    for path in sorted(FOLDER.glob("*"), key=_last_read, reverse=True):
        with contextlib.suppress(FileNotFoundError):  # another run was quicker
            total += path.stat().st_size
            if total > most_bytes:
                path.unlink()


def _last_read(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0


# ---------------------------------------------------------------- bytes


def _encoded(recording: Recording, key: str) -> bytes:
    """SHA-256 of the rest; then compressed: length of the JSON, JSON, the arrays' bytes."""
    arrays: list[np.ndarray] = []
    answers = {history: _row(answer, arrays) for history, answer in recording.answers.items()}
    head = json.dumps({"key": key, "isolation_level": recording.isolation_level, "answers": answers}).encode()
    parts = (len(head).to_bytes(_LENGTH_BYTES, "little"), head, *(array.tobytes() for array in arrays))
    body = zlib.compress(b"".join(parts), _LEVEL)
    return hashlib.sha256(body).digest() + body


def _row(answer: Answer, arrays: list[np.ndarray]) -> dict[str, Any]:
    row: dict[str, Any] = {"cpu_s": round(answer.cpu_s, 4), "failure": answer.failure, "place": answer.place}
    if answer.frame is not None:
        row["fields"] = answer.frame.fields
        row["arrays"] = {name: [each.dtype.str, each.shape] for name, each in answer.frame.arrays.items()}
        arrays += answer.frame.arrays.values()
    return row


def _decoded(data: bytes, key: str) -> Recording:
    digest, body = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
    if hashlib.sha256(body).digest() != digest:
        raise ValueError("damaged")
    content = zlib.decompress(body)
    end = _LENGTH_BYTES + int.from_bytes(content[:_LENGTH_BYTES], "little")
    head = json.loads(content[_LENGTH_BYTES:end])
    if head["key"] != key:
        raise ValueError("the recording of something else")
    bytes_left = memoryview(content)[end:]
    answers = {}
    for history, row in head["answers"].items():
        frame = None
        if "fields" in row:
            arrays = dict(_cut(row["arrays"], bytes_left))
            bytes_left = bytes_left[sum(array.nbytes for array in arrays.values()) :]
            frame = Frame(row["fields"], arrays)
        failure = row["failure"] and tuple(row["failure"])
        answers[history] = Answer(row["cpu_s"], frame, failure, row["place"])
    return Recording(head["isolation_level"], answers)


def _cut(shapes: dict[str, Any], content: memoryview) -> Iterator[tuple[str, np.ndarray]]:
    start = 0
    for name, (kind, shape) in shapes.items():
        count = int(np.prod(shape, dtype=np.int64))
        array = np.frombuffer(content, dtype=kind, count=count, offset=start).reshape(shape)
        start += array.nbytes
        yield name, array
