"""A folder in which every module that the grader imports has a namesake; a namesake that is run writes that to a file."""

from __future__ import annotations

import sys
from pathlib import Path

_PACKAGES = (
    "PIL", "_pytest", "click", "distributed", "grader", "jinja2", "markupsafe", "matplotlib", "mujoco", "numpy", "pluggy", "pytest", "reference",
    "rich", "scipy", "sitecustomize", "typer", "usercustomize", "yaml",
)  # fmt: skip
_TELLS = """\
import posix, sys
line = b"{name} by %r\\n" % " ".join(getattr(sys, "orig_argv", sys.argv)).encode()
try:
    posix.write(posix.open({told!r}, posix.O_WRONLY | posix.O_APPEND), line)
except OSError:
    pass
raise ImportError("a student's {name}")
"""


def write_shadowing_modules(folder: Path, told: Path, but: frozenset[str] = frozenset()) -> Path:
    """Write them.

    Parameters
    ----------
    told
        The file in which each tells; anyone may write into it.
    but
        Names that are left out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    told.touch()
    told.chmod(0o666)
    for name in {*sys.stdlib_module_names, *_PACKAGES} - {"posix", "sys", *but}:
        (folder / f"{name}.py").write_text(_TELLS.format(name=name, told=str(told)), encoding="utf-8")
    (folder / "conftest.py").write_text(_TELLS.format(name="conftest", told=str(told)), encoding="utf-8")
    (folder / "pytest.ini").write_text("[pytest]\naddopts = --no-such-option\n", encoding="utf-8")
    return folder
