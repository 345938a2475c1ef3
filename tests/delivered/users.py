"""Who runs what was installed: an ordinary user, also where the tests are run by root, and a Python that this user can run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

_NOBODY = 65534
_HEAVY = ("site-packages", "test", "__pycache__", "*.a", "share", "include")


@dataclass(frozen=True)
class User:
    """Somebody with a home of their own; `identity` is for `subprocess.run`, empty for whoever runs the tests."""

    home: Path
    identity: dict[str, Any] = field(default_factory=dict)

    def owns(self, folder: Path) -> Path:
        """A new folder of this user's."""
        folder.mkdir(parents=True)
        if self.identity:
            os.chown(folder, self.identity["user"], self.identity["group"])
        return folder


def somebody(home: Path) -> User:
    """An ordinary user: another one for root, else the one that we are."""
    as_root = hasattr(os, "geteuid") and os.geteuid() == 0
    user = User(home, {"user": _NOBODY, "group": _NOBODY, "extra_groups": []} if as_root else {})
    user.owns(home)
    return user


def python_for(user: User, place: Path) -> tuple[Path, dict[str, str]]:
    """The `python3` beside the one that runs the tests, or a copy of it where root alone may enter there, and what it needs of the environment."""
    base = os.path.realpath(sys._base_executable)  # type: ignore[attr-defined] # what a virtual environment stands on
    ours = Path(base).with_name("python3")
    if _runs(ours, {}, user):
        return ours, {}
    prefix = os.path.realpath(sys.base_prefix)
    shutil.copytree(prefix, place, symlinks=True, ignore=shutil.ignore_patterns(*_HEAVY))
    copied, environ = place / ours.relative_to(prefix), {"LD_LIBRARY_PATH": str(place / "lib")}
    assert _runs(copied, environ, user), "an ordinary user cannot run this Python, nor a copy of it"
    return copied, environ


def _runs(python: Path, environ: dict[str, str], user: User) -> bool:
    try:
        subprocess.run([python, "-c", "import venv, ensurepip, ssl"], env=environ, check=True, **user.identity)
    except (OSError, subprocess.CalledProcessError):
        return False
    return True
