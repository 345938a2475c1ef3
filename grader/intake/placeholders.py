"""Recognise placeholder files: what Git LFS, cloud drives and failed downloads leave in place of a student's file."""

from __future__ import annotations

import re

from grader.intake.names import is_code

_HTML = re.compile(rb"\s*<(!doctype html|html)\b", re.IGNORECASE)


def placeholder(path: str, content: bytes) -> str:
    """Say for a note what was handed in instead of a file (a Git LFS pointer, a web page), and what to do; "" for a real file."""
    if re.fullmatch(r"\..+\.icloud", path.rpartition("/")[2]):
        return "iCloud had not downloaded the file (open it once in Finder, then hand in again)"
    if not is_code(path):
        return ""
    if content.startswith(b"version https://git-lfs.github.com/spec/"):
        return (
            "it is a Git LFS pointer and not the file (run `git lfs push --all origin` where the file is, "
            "or stop tracking it with LFS and commit it again)"
        )
    if _HTML.match(content):
        return "it is a web page, such as a login page saved in place of the file (download the file again)"
    if content and not content.strip(b"\0"):
        return "it holds null bytes only, as an interrupted sync leaves it (copy the file again)"
    return ""


def is_empty_program(content: bytes) -> bool:
    """Return whether a program has no content but white space, as after a failed upload."""
    return not content.strip()
