"""Find branches of a submitted git clone that have the lab's files, for a student who left the wrong one checked out.

No command runs in the clone, and its settings and hooks are never read, because they can name programs that git would start: git
gets a repository of ours that borrows the clone's objects, and lists the files of a commit.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Collection, Mapping
from pathlib import Path

from grader.base.text import printable, some

_MAX_BYTES = 1_000_000
_MAX_NAMES = 1_000
_PACKED = re.compile(r"^([0-9a-f]{40,64}) refs/(?:heads|remotes/[^/\n]+)/(.+)$", re.MULTILINE)
_COMMIT = re.compile(r"[0-9a-f]{40,64}")
_A_FEW = 5
_SEARCHED = 20
_WITHIN_S = 2.0


def branches_note(folder: Path, required: Collection[str]) -> str:
    """Return a note on a clone's other branches: those in which git finds files of the lab, else (or without git) all; "" if none.

    Parameters
    ----------
    folder : the submission, in which no code was found; if it is no git clone, the note is ""
    required : names of the files that the lab asks for
    """
    git = folder / ".git"
    head = _read(git / "HEAD").strip().removeprefix("ref: refs/heads/")
    commits = {name: commit for commit, name in _PACKED.findall(_read(git / "packed-refs"))}
    for kind in ("heads", *_remotes(git)):
        commits |= {name: _read(git / "refs" / kind / name).strip() for name in _loose(git / "refs" / kind)}
    others = {name: commit for name, commit in sorted(commits.items()) if name not in (head, "HEAD")}
    if not head or not others:
        return ""
    have = _with_files(git / "objects", others, required)
    told = (
        f"{_names_of(have)} {'has' if len(have) == 1 else 'have'} them: check it out, and grade again"
        if have
        else f"Its other branches: {_names_of(list(others))}"
    )
    return f"The checked-out branch {printable(head, 80)} of this git clone has no files of the lab. {told}."


def _names_of(branches: list[str]) -> str:
    return some([printable(name, 80) for name in branches], _A_FEW)


def _with_files(objects: Path, commits: Mapping[str, str], required: Collection[str]) -> list[str]:
    """Return the branches whose commit has a file that the lab asks for, as far as git finds out: it may be missing or too slow."""
    git = shutil.which("git")
    if git is None:
        return []
    found = []
    with tempfile.TemporaryDirectory() as own:
        for name in ("objects", "refs"):
            Path(own, name).mkdir()
        Path(own, "HEAD").write_text("ref: refs/heads/none\n", encoding="ascii")
        surroundings = {
            "GIT_DIR": own,
            "GIT_OBJECT_DIRECTORY": str(objects.absolute()),
            "GIT_CONFIG_NOSYSTEM": "1",
            "GIT_CONFIG_GLOBAL": os.devnull,
            "GIT_ALLOW_PROTOCOL": "none",
        }
        for branch, commit in list(commits.items())[:_SEARCHED]:
            if not _COMMIT.fullmatch(commit):
                continue
            command = [git, "ls-tree", "-r", "-z", "--name-only", commit]
            try:
                listed = subprocess.run(
                    command, env=surroundings, cwd=own, capture_output=True, timeout=_WITHIN_S, check=False
                )
            except (OSError, subprocess.TimeoutExpired):
                break
            names = {
                path.rpartition(b"/")[2].decode("utf-8", "replace").casefold() for path in listed.stdout.split(b"\0")
            }
            found += [branch] if names & set(required) else []
    return found


def _remotes(git: Path) -> list[str]:
    return [f"remotes/{name}" for name in _names(git / "refs" / "remotes", folders=True)]


def _loose(folder: Path) -> set[str]:
    """Return the branches that git keeps in a file each; a slash in their names makes a folder, of which one level is searched."""
    inner = {f"{name}/{last}" for name in _names(folder, folders=True) for last in _names(folder / name)}
    return {*_names(folder), *inner}


def _names(folder: Path, *, folders: bool = False) -> list[str]:
    """Return the first names of files, or of folders, in a folder, sorted; links are left out. [] for an unreadable folder."""
    try:
        with os.scandir(folder) as entries:
            kinds = [
                each.name for each in entries if each.is_dir(follow_symlinks=False) == folders and not each.is_symlink()
            ]
            return sorted(kinds)[:_MAX_NAMES]
    except OSError:
        return []


def _read(path: Path) -> str:
    """Return the beginning of a plain file as text; "" if there is no such file."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(handle, "rb") as stream:
            return stream.read(_MAX_BYTES).decode("utf-8", "replace")
    except OSError:
        return ""
