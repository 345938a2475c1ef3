"""Files of the instructor: read within a limit, and written whole, so that no reader ever sees half of one."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable


def read_file(path: Path, most: int, advice: str) -> bytes:
    """Return the bytes of a file that a command names.

    Raises
    ------
    RequestError
        If it cannot be read or has more than `most` bytes; the message ends with the `advice`.
    """
    source = printable(str(path), 500)
    try:
        with open(path, "rb") as stream:
            data = stream.read(most + 1)
    except OSError as error:
        raise RequestError(f"{source}: cannot be read ({error.strerror}); {advice}") from error
    if len(data) > most:
        raise RequestError(f"{source}: is larger than {most // 1_000_000} MB; {advice}")
    return data


def write_whole(path: Path, content: str | bytes) -> None:
    """Write text (as UTF-8) or bytes beside `path`, then rename that file, so that no reader sees a half-written one.

    A device or pipe, such as ``/dev/stdout``, is written to directly.

    Raises
    ------
    RequestError
        If the folder cannot be made or written; names the path and the system's reason.
    """
    data = content.encode("utf-8", "replace") if isinstance(content, str) else content
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if _is_stream(path):
            path.write_bytes(data)
        else:
            _replace(path, data)
    except OSError as problem:
        raise RequestError(f"{path}: cannot write it: {problem.strerror or problem}; choose another place") from problem


def seen_from(folder: Path, path: Path) -> str:
    """Return a path relative to a folder; the absolute path if no relative one exists, as between two drives of Windows."""
    try:
        return os.path.relpath(path, folder)
    except ValueError:
        return os.path.abspath(path)


def _is_stream(path: Path) -> bool:
    """Return whether the path is a device, a pipe or an open file of this process, so that no file can replace it."""
    if path.parent in (Path("/dev"), Path("/dev/fd"), Path("/proc/self/fd")):
        return True
    return path.exists() and not path.is_file() and not path.is_dir()


def _replace(path: Path, content: bytes) -> None:
    """Write the content to a temporary file beside `path`, then rename it to `path`."""
    handle, scratch = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
        os.chmod(scratch, 0o666 & ~_umask())  # mkstemp makes private files; these are meant to be served
        os.replace(scratch, path)
    except BaseException:
        Path(scratch).unlink(missing_ok=True)
        raise


def _umask() -> int:
    """Return the process's umask, which can be read only by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
