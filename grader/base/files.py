"""Read an instructor's file up to a size limit; write a file in one step, so that no reader ever sees half of it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable


def read_file(path: Path, most: int, advice: str) -> bytes:
    """Return the bytes of a file that the user named, such as a roster or a CSV file of points.

    Raises
    ------
    RequestError
        If the file cannot be read or has more than `most` bytes. The message ends with `advice`, which says what to do.
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
    """Write text (as UTF-8) or bytes to a temporary file, then rename it to `path`, so that no reader sees a half-written file.

    Missing folders are made. A device or pipe, such as ``/dev/stdout``, is written to directly.

    Raises
    ------
    RequestError
        If the folder cannot be made, or the file cannot be written; the message names the path and the system's reason.
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
    """Return `path` relative to `folder`, for messages and generated programs; absolute if they are on two Windows drives."""
    try:
        return os.path.relpath(path, folder)
    except ValueError:
        return os.path.abspath(path)


def _is_stream(path: Path) -> bool:
    """Return whether a path is a device, a pipe or an open file of this process: `write_whole` must not replace it by a file."""
    if path.parent in (Path("/dev"), Path("/dev/fd"), Path("/proc/self/fd")):
        return True
    return path.exists() and not path.is_file() and not path.is_dir()


def _replace(path: Path, content: bytes) -> None:
    """Write the content to a temporary file beside `path`, then rename that file to `path`; remove it if one of the two fails."""
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
    """Return this process's umask, the mode bits that new files lack. It can be read only by setting another, which is set back."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
