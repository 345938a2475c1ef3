"""Packages that submissions import and that student code cannot import on this machine, for the instructor to install.

Only well-known packages are named. A student chooses the names in an import, and an instructor would install what is named here.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections import Counter
from collections.abc import Iterable, Mapping

from grader.base.text import some
from grader.engine.lab import Lab
from grader.engine.reading import Readable, ReadingProcess
from grader.engine.results import Result
from grader.engine.rubric import Rubric
from grader.intake import Submission
from grader.report import words
from grader.sandbox import packages

DISTRIBUTIONS: Mapping[str, str] = {
    "PIL": "pillow", "allantools": "allantools", "control": "control", "cv2": "opencv-python-headless", "dm_control": "dm-control",
    "filterpy": "filterpy", "glfw": "glfw", "gymnasium": "gymnasium", "h5py": "h5py", "imageio": "imageio",
    "ipywidgets": "ipywidgets", "mediapy": "mediapy", "numba": "numba", "pandas": "pandas", "plotly": "plotly",
    "pyquaternion": "pyquaternion", "quaternion": "numpy-quaternion", "rich": "rich", "seaborn": "seaborn",
    "skimage": "scikit-image", "sklearn": "scikit-learn", "statsmodels": "statsmodels", "sympy": "sympy",
    "transforms3d": "transforms3d", "xarray": "xarray", "yaml": "PyYAML",
}  # fmt: skip
"""The distribution that `pip` installs, by the name that is imported."""
Missing = Mapping[str, Mapping[str, float]]
"""By submission, its packages that are not available, each with the points that it loses without it, or may lose."""
_IMPORTED = re.compile(rb"""(?:^|["\n])[ \t]*(?:import|from)[ \t]+([A-Za-z_]\w{0,40})""", re.MULTILINE)
"""An import in a Python file, or in a line of a notebook's JSON."""
_FAILED = re.compile(r"No module named '([A-Za-z_]\w{0,40})")
_MOST_NAMES = 5
_MANY, _SHARE = 3, 0.1
"""Submissions, and share of the class, that many submissions are at least."""


def imported(submission: Submission, rubric: Rubric) -> Mapping[str, float]:
    """Return the well-known packages (`DISTRIBUTIONS`) that a submission imports, each with the points at risk if it is missing.

    At risk are the points of the criteria whose required names the importing files define; of all criteria if they define none.
    """
    sources = {path: text for path, text in submission.files.items() if path.lower().endswith((".py", ".ipynb"))}
    own = {path.rpartition("/")[2].partition(".")[0] for path in submission.files}
    users: dict[str, dict[str, bytes]] = {}
    for path, content in sources.items():
        for name in {name.decode() for name in _IMPORTED.findall(content)} & DISTRIBUTIONS.keys() - own:
            users.setdefault(name, {})[path] = content
    points = {criterion.id: criterion.points for criterion in rubric.criteria}
    everything = sum(points.values())
    parts = rubric.lab.parts
    return {
        name: sum(points.get(part.id, 0.0) for part in parts if part.named_in(files)) or everything
        for name, files in users.items()
    }


def of_class(entries: Iterable[Readable], rubric: Rubric) -> Missing:
    """Return for each submission, by id, the packages in `DISTRIBUTIONS` that it imports and that student code cannot import here.

    Each package has the points that the submission may lose without it. Code is searched as text and not run.
    """
    there = available(rubric.lab)
    with ReadingProcess() as reader:
        found = {entry.id: imported(submission, rubric) for entry, submission in reader.each(entries)}
    return {id_: {name: n for name, n in names.items() if name not in there} for id_, names in found.items()}


def failed(result: Result) -> Mapping[str, float]:
    """Return the packages of `DISTRIBUTIONS` that failed to import, each with its highest cost: the points lost to exceptions."""
    checks = [check for part in result.parts for check in part.checks]
    texts = (*result.notes, *(check.got for check in checks))
    lost = sum(check.max_points - (check.points or 0.0) for check in checks if check.outcome == "error")
    return {name: lost for text in texts for name in _FAILED.findall(text) if name in DISTRIBUTIONS}


def many(missing: Missing) -> Missing:
    """Keep packages that at least three submissions and a tenth of the class import: `grade` asks whether to go on without them."""
    users = Counter(name for names in missing.values() for name in names)
    least = max(_MANY, _SHARE * len(missing))
    return {id_: {name: n for name, n in names.items() if users[name] >= least} for id_, names in missing.items()}


def available(lab: Lab) -> set[str]:
    """Return names that student code can import: of NumPy, matplotlib, `Lab.packages`, and packages not for the grader alone."""
    return {os.path.basename(path).partition(".")[0] for path in packages.shown(packages.folders(), lab.packages)}


def lines(missing: Missing) -> list[str]:
    """Return lines for an instructor: each missing package with who needs it, then the command to install all; empty if none is."""
    users: dict[str, dict[str, float]] = {}
    for id_, names in missing.items():
        for name, points in sorted(names.items()):
            users.setdefault(name, {})[id_] = points
    if not users:
        return []
    lines = [f"{name} is not installed for student code: {_who(ids)}" for name, ids in sorted(users.items())]
    wanted = [DISTRIBUTIONS[name] for name in sorted(users)]
    return [
        *lines,
        f"{command(wanted)} installs {'them' if len(wanted) > 1 else 'it'}; then `imugrade grade` grades only these again",
    ]


def command(distributions: Iterable[str]) -> str:
    """Return the shell command that installs packages into the Python in which the grader runs."""
    return shlex.join([sys.executable, "-m", "pip", "install", *distributions])


def _who(users: Mapping[str, float]) -> str:
    one, most = len(users) == 1, max(users.values())
    cost = f", and without it {'it loses' if one else 'they lose'} up to {words.number(most)} points" if most else ""
    return f"{words.counted(len(users), 'submission')} import{'s' * one} it ({some([*users], _MOST_NAMES, '; ')}){cost}"
