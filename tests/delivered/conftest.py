"""The package is built and installed once, as a new user does it, and its sources are taken away."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import uuid
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: pip compiles what a run never imports; Python compiles the rest when it does.
PIP = {key: value for key, value in os.environ.items() if key.startswith("PIP_")} | {"PIP_COMPILE": "0"}
SECRET = "a secret that no report may tell 0815"


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


@dataclass(frozen=True)
class Delivered:
    """What was built, and the environment that it was installed into; `graded` is what the README's command left."""

    place: Path
    sdist: Path
    wheel: Path
    python: Path
    environ: dict[str, str]
    user: User
    graded: Path

    @property
    def programs(self) -> Path:
        return self.place / "fresh" / ".venv" / "bin"

    @property
    def examples(self) -> Path:
        return self.place / "submissions_example"

    def empty(self) -> Path:
        """A new folder of the user's."""
        return self.user.owns(self.user.home / uuid.uuid4().hex)

    def run(self, *words: object, cwd: Path, **more: Any) -> subprocess.CompletedProcess[str]:
        """`imugrade WORDS`, or another program of the environment if the first word is a path."""
        program = words[0] if isinstance(words[0], Path) else self.programs / "imugrade"
        arguments = words[1:] if isinstance(words[0], Path) else words
        environ = {**self.environ, **more.pop("environ", {})}
        return subprocess.run(
            [str(word) for word in (program, *arguments)],
            cwd=cwd, env=environ, capture_output=True, text=True, check=False, timeout=600, **self.user.identity, **more,
        )  # fmt: skip


@pytest.fixture(scope="session")
def delivered() -> Iterator[Delivered]:
    place = Path(tempfile.mkdtemp(prefix="imugrade-delivered-"))  # not below pytest's, where other users cannot enter
    place.chmod(0o755)
    try:
        yield _delivered(place)
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _delivered(place: Path) -> Delivered:
    user = somebody(place / "home")
    python, environ = python_for(user, place / "python")
    subprocess.run(
        [sys.executable, "-m", "build", "--outdir", place / "dist", ROOT], check=True, stdout=subprocess.DEVNULL
    )
    (sdist,), (wheel,) = place.glob("dist/*.tar.gz"), place.glob("dist/*.whl")  # the wheel is built from the sdist
    with tarfile.open(sdist) as archive:
        archive.extractall(place)
    (place / sdist.name.removesuffix(".tar.gz")).rename(place / "fresh")
    _as_the_readme_says(place / "fresh", python, environ)
    pip = [place / "fresh" / ".venv" / "bin" / "python", "-m", "pip", "install", "-q", "--no-deps", "--force-reinstall"]
    subprocess.run([*pip, wheel], check=True)
    shutil.move(place / "fresh" / "out", place / "out")
    shutil.move(place / "fresh" / "submissions_example", place / "submissions_example")
    for path in (place / "fresh").iterdir():
        if path.name != ".venv":
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    environ |= {
        "PATH": "/usr/bin:/bin",
        "HOME": str(user.home),
        "TMPDIR": str(user.owns(user.home / "tmp")),
        "LANG": "C.UTF-8",
    }
    return Delivered(place, sdist, wheel, python, environ, user, place / "out")


def _as_the_readme_says(folder: Path, python: Path, environ: dict[str, str]) -> None:
    """The first command of the README, in a fresh copy of the sources."""
    first, *_ = re.findall(r"```sh\n(python3 -m venv .*?)\n```", (folder / "README.md").read_text(encoding="utf-8"))
    kept = {
        key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "IMUGRADE", "VIRTUAL_ENV"))
    }
    path = f"{python.parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(["bash", "-c", first], cwd=folder, env={**kept, **PIP, **environ, "PATH": path}, check=True)


# --- who runs what was installed: an ordinary user, also where the tests are run by root --------------------------------


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
