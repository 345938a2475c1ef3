"""Putting a submission on disk: a folder, or an archive of one."""

from __future__ import annotations

import io
import json
import tarfile
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Link:
    """A symbolic link in a submission, and where it points."""

    target: str


Content = str | bytes | Link
Files = Mapping[str, Content]


class Late(Mapping[str, Content]):
    """Files of which some are made when they are asked for: bombs take seconds."""

    def __init__(self, files: Mapping[str, Content | Callable[[], Content]]) -> None:
        self._files = files

    def __getitem__(self, name: str) -> Content:
        content = self._files[name]
        return content() if callable(content) else content

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


_STAMP = (2024, 5, 17, 12, 0, 0)  # archives with the same content are the same bytes


def as_bytes(content: str | bytes) -> bytes:
    return content.encode("utf-8") if isinstance(content, str) else content


def write(files: Files, target: Path, as_: str = "folder") -> Path:
    """Write a submission and return the path to hand in.

    Parameters
    ----------
    files : mapping of str to str, bytes or Link
        Paths with slashes to contents; a path that ends in a slash is an empty folder.
    target : Path
        The folder to make, or the archive's path without its ending.
    as_ : {"folder", "zip", "tar.gz", "tar", "file", "zip in folder"}
        "file" writes the only entry beside `target`, under its own name; "zip in folder" makes a folder that holds one zip.
    """
    if as_ in ("folder", "file"):
        return _folder(files, target) if as_ == "folder" else _folder(files, target.parent) / next(iter(files))
    if as_ == "zip in folder":
        return _folder({"my submission.zip": zipped(files)}, target)
    archive = f"{target.name}.{as_}"
    return _folder({archive: zipped(files) if as_ == "zip" else tarred(files, as_)}, target.parent) / archive


def _folder(files: Files, target: Path) -> Path:
    target.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        path = target / name
        if name.endswith("/"):
            path.mkdir(parents=True, exist_ok=True)
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, Link):
            path.symlink_to(content.target)
        else:
            path.write_bytes(as_bytes(content))
    return target


def zipped(files: Files) -> bytes:
    """The bytes of a zip archive; links become what zip makes of them, a flagged entry."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _STAMP)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o120777 if isinstance(content, Link) else 0o100644) << 16
            archive.writestr(entry, content.target if isinstance(content, Link) else as_bytes(content))
    return buffer.getvalue()


def tarred(files: Files, kind: str = "tar.gz") -> bytes:
    """The bytes of a tar archive, compressed if `kind` is "tar.gz"."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz" if kind == "tar.gz" else "w") as archive:
        for name, content in files.items():
            entry = tarfile.TarInfo(name)
            if isinstance(content, Link):
                entry.type, entry.linkname = tarfile.SYMTYPE, content.target
                archive.addfile(entry)
                continue
            raw = as_bytes(content)
            entry.size = len(raw)
            archive.addfile(entry, io.BytesIO(raw))
    return buffer.getvalue()


def notebook(*cells: str | tuple[str, str], lines: bool = True) -> str:
    """A Jupyter notebook; a cell is its code, or (kind, text) for another kind. Its outputs are as after a run."""
    body = [
        _cell(*(("code", cell) if isinstance(cell, str) else cell), lines=lines, number=i)
        for i, cell in enumerate(cells)
    ]
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    meta = {"kernelspec": kernel, "language_info": {"name": "python", "version": "3.11.7"}}
    return json.dumps({"cells": body, "metadata": meta, "nbformat": 4, "nbformat_minor": 5}, indent=1)


def _cell(kind: str, text: str, *, lines: bool, number: int) -> dict[str, object]:
    source = text.strip("\n").splitlines(keepends=True) if lines else text.strip("\n")
    cell: dict[str, object] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": source}
    if kind == "code":
        cell |= {"execution_count": number + 1, "outputs": []}
    return cell
