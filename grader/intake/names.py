"""Judge file names from strangers: which paths may be used, and folder names that are safe on every system."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

CODE = (".py", ".ipynb")
ARCHIVES = (".zip", ".tar.gz", ".tgz", ".tar")
FOREIGN_ARCHIVES = (".rar", ".7z", ".xz", ".bz2", ".gz", ".zst", ".txz", ".tbz2")

MAX_PARTS = 16
MAX_PART = 255  # what Linux, macOS and Windows take
MAX_PATH = 1000
MAX_ID = 80

# What tools leave behind: never part of a submission, and often thousands of files.
_LITTER_FOLDERS = frozenset(
    {
        *("__MACOSX", ".Trash", ".Spotlight-V100"),
        ".imugrade",
        *(".git", ".svn", ".hg"),
        *(".venv", "venv", "site-packages", "node_modules"),
        *("__pycache__", ".ipynb_checkpoints", ".tox", ".nox", ".mypy_cache", ".pytest_cache", ".ruff_cache"),
    }
)
_LITTER_FILES = frozenset({".ds_store", "thumbs.db", "desktop.ini"})

HOME_VERSIONS = (".imugrade", "versions.txt")
"""Folder and file in which `check` writes the versions on the student's computer."""

_DRIVE = re.compile(r"[A-Za-z]:")
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³])\s*(\.|$)", re.IGNORECASE)
_NOT_ON_WINDOWS = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]|[. ]$')


def has_suffix(name: str, suffixes: tuple[str, ...]) -> bool:
    return name.casefold().endswith(suffixes)


def is_code(path: str) -> bool:
    return has_suffix(path, CODE)


def is_litter(parts: Sequence[str]) -> bool:
    """Return whether a path's `parts` show a tool's file (``.git/HEAD``); not ``.imugrade/versions.txt``, which grading reads."""
    if parts[-2:] == HOME_VERSIONS:
        return False
    return any(part in _LITTER_FOLDERS or part.startswith("._") or part.casefold() in _LITTER_FILES for part in parts)


def archive_parts(name: str) -> tuple[str, ...] | None:
    """Return the parts of a path in an archive; None if it leads out of the archive or means something else on another system."""
    if "\0" in name or "\\" in name or name.startswith("/") or _DRIVE.match(name):
        return None
    parts = tuple(part for part in name.split("/") if part not in ("", "."))
    return None if ".." in parts else parts


def joined(parts: tuple[str, ...]) -> str | None:
    """Return the parts as one path, the same on every system (composed letters, no lone surrogates); None if too long or deep."""
    path = "/".join(unicodedata.normalize("NFC", _underscored(part)) for part in parts)
    fits = 0 < len(parts) <= MAX_PARTS and len(path) <= MAX_PATH
    return path if fits and all(len(part.encode()) <= MAX_PART for part in path.split("/")) else None


def _underscored(text: str) -> str:
    """Return a name with an underscore for each lone surrogate, which stands for a byte that is not UTF-8."""
    return re.sub("[\ud800-\udfff]", "_", text)


def encodable(name: str) -> str:
    """Return a submission's name with a replacement character for each lone surrogate, so that it can be written as UTF-8."""
    return re.sub("[\ud800-\udfff]", "\ufffd", name)


def portable(path: str) -> bool:
    """Return whether each part is a legal file name on Windows too, where a sandbox may have to write it."""
    return not any(_NOT_ON_WINDOWS.search(part) or _DEVICE.match(part) for part in path.split("/"))


def folded(path: str) -> str:
    """Return a form of a path for comparisons: equal for names that a case-insensitive file system takes for one."""
    return unicodedata.normalize("NFC", path.casefold())


def safe_id(name: str) -> str:
    """Return a safe folder name for any name: letters, digits, ``-``, ``_`` and ``.``, no leading dot, at most 80 characters."""
    kept = (char if char.isalnum() or char in "-_." else "_" for char in unicodedata.normalize("NFC", name[:1000]))
    safe = _shortened("".join(kept).strip("."), MAX_ID)
    return f"_{safe}"[:MAX_ID] if _DEVICE.match(safe) else safe or "submission"


def _shortened(name: str, limit: int) -> str:
    """Return a name cut to `limit` characters and 200 bytes, as a folder's name may have 255 bytes, and some letters take three."""
    return name[:limit].encode()[:200].decode(errors="ignore").rstrip(".")


def distinct_ids(names: Iterable[str]) -> list[str]:
    """Return a safe folder name for each name, in order; folders that would be equal, apart from case, are numbered (``-2``, …)."""
    names = list(names)
    ids: list[str] = []
    # A name that is safe as it stands keeps its id, even if the number of another would fall on it.
    taken = {folded(name) for name in names if safe_id(name) == name}
    owned: set[str] = set()
    for name in names:
        wanted = chosen = safe_id(name)
        number = 1
        while folded(chosen) in owned or (folded(chosen) in taken and chosen != name):
            number += 1
            suffix = f"-{number}"
            chosen = _shortened(wanted, MAX_ID - len(suffix)) + suffix
        owned.add(folded(chosen))
        ids.append(chosen)
    return ids
