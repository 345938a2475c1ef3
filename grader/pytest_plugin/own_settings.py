"""Start pytest with the grader's settings, so that it reads none of a submission: those can import and run code.

pytest reads `pytest.ini`, `pyproject.toml`, `tox.ini` or `setup.cfg` of the folder, with `addopts = -p MODULE` and `pythonpath`,
before it loads any installed plugin. So this module has to run earlier: `imugrade-pytest.pth`, which the installation puts beside
the packages, imports it when Python starts with `--imugrade` among its arguments.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path


def options() -> str:
    """Return pytest's options to read an empty settings file instead of a student's, and to show paths from the working folder."""
    empty = Path(__file__).with_name("empty.ini")
    return shlex.join(("-c", empty.as_posix(), "--rootdir", Path.cwd().as_posix()))


def _start() -> None:
    """Put the grader's options before those of the command line, and keep the folder in which pytest starts off Python's path.

    For the latter, Python starts again where `python -m` or `-c` has put the folder there.
    """
    before = os.environ.get("PYTEST_ADDOPTS", "")
    if options() not in before:
        os.environ["PYTEST_ADDOPTS"] = f"{before} {options()}".strip()
    imports_here = sys.argv[:1] in (["-m"], ["-c"]) and not getattr(sys.flags, "safe_path", True)
    told = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"  # for the processes of pytest-xdist as well
    if imports_here and not told:
        again = [sys.executable, *sys.orig_argv[1:]]
        if sys.platform == "win32":  # where execv returns to the shell at once, with exit code 0
            os._exit(subprocess.call(again))
        os.execv(sys.executable, again)


_start()
