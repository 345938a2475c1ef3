"""Find data files of the grader's packages, in the same way in a wheel, an unpacked source archive and a checkout."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def beside(package: str, name: str) -> Path:
    """Return the path of a data file or folder `name` (with slashes) in a Python package's folder; it may not exist.

    Pass `__package__` as `package`: if the package is renamed, the call still finds its files.
    """
    return Path(str(files(package).joinpath(*name.split("/"))))
