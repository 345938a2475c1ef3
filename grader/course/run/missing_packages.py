"""Packages that submissions import and that student code cannot import on this machine.

Only well-known packages are named. A student chooses the names in an import, and an instructor would install what is named here.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Iterable, Mapping

from grader.base.text import some
from grader.engine.results import Result
from grader.intake import Submission
from grader.sandbox import packages

DISTRIBUTIONS: Mapping[str, str] = {
    "PIL": "pillow", "allantools": "allantools", "control": "control", "cv2": "opencv-python-headless", "dm_control": "dm-control",
    "filterpy": "filterpy", "glfw": "glfw", "gymnasium": "gymnasium", "h5py": "h5py", "imageio": "imageio",
    "ipywidgets": "ipywidgets", "mediapy": "mediapy", "numba": "numba", "pandas": "pandas", "plotly": "plotly",
    "pyquaternion": "pyquaternion", "quaternion": "numpy-quaternion", "rich": "rich", "seaborn": "seaborn",
    "skimage": "scikit-image", "sklearn": "scikit-learn", "statsmodels": "statsmodels", "sympy": "sympy", "tqdm": "tqdm",
    "transforms3d": "transforms3d", "xarray": "xarray", "yaml": "PyYAML",
}  # fmt: skip
"""The distribution that `pip` installs, by the name that is imported."""
_IMPORTED = re.compile(rb"""(?:^|["\n])[ \t]*(?:import|from)[ \t]+([A-Za-z_]\w{0,40})""", re.MULTILINE)
"""An import in a Python file, or in a line of a notebook's JSON."""
_FAILED = re.compile(r"No module named '([A-Za-z_]\w{0,40})")
_MOST_NAMES = 5


def imported(submission: Submission) -> set[str]:
    """Return the known packages that a submission imports, in any Python file or notebook."""
    sources = (content for path, content in submission.files.items() if path.lower().endswith((".py", ".ipynb")))
    own = {path.rpartition("/")[2].partition(".")[0] for path in submission.files}
    return {name.decode() for content in sources for name in _IMPORTED.findall(content)} & DISTRIBUTIONS.keys() - own


def failed(result: Result) -> set[str]:
    """Return the known packages whose import failed when a submission was graded."""
    texts = (*result.notes, *(check.got for part in result.parts for check in part.checks))
    return {name for text in texts for name in _FAILED.findall(text)} & DISTRIBUTIONS.keys()


def available() -> set[str]:
    """Return the names that student code can import from installed packages on this machine."""
    return {os.path.basename(path).partition(".")[0] for path in packages.shown(packages.folders())}


def lines(missing: Mapping[str, Iterable[str]]) -> list[str]:
    """Return what to tell an instructor: each package with its submissions, then the command that installs all of them.

    Parameters
    ----------
    missing
        The packages of each submission that are not available, by id.
    """
    users: dict[str, list[str]] = {}
    for id_, names in missing.items():
        for name in sorted(names):
            users.setdefault(name, []).append(id_)
    if not users:
        return []
    lines = [f"{name} is not installed for student code: {_who(ids)}" for name, ids in sorted(users.items())]
    wanted = [DISTRIBUTIONS[name] for name in sorted(users)]
    return [
        *lines,
        f"{command(wanted)} installs {'them' if len(wanted) > 1 else 'it'}; then `imugrade grade` grades only these again",
    ]


def command(distributions: Iterable[str]) -> str:
    """Return the command that installs packages beside the grader."""
    return shlex.join([sys.executable, "-m", "pip", "install", *distributions])


def _who(ids: list[str]) -> str:
    return (
        f"{len(ids)} submission{'s' * (len(ids) > 1)} import{'s' * (len(ids) == 1)} it ({some(ids, _MOST_NAMES, '; ')})"
    )
