"""Find the package's data files in the same way in a wheel, an sdist's folder and a checkout."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def beside(package: str, name: str) -> Path:
    """Return the path of a file or folder in the folder of a package.

    Parameters
    ----------
    package
        The package's name, best `__package__`: if the package moves, the call still finds its files.
    name
        A path from there, with slashes.
    """
    return Path(str(files(package).joinpath(*name.split("/"))))
