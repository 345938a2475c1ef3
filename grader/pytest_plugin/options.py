"""Parse the arguments of `pytest --imugrade`: the path of a submission, and names of criteria, checks or files in it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.text import printable

_CODE = (".py", ".ipynb")


@dataclass(frozen=True)
class Name:
    """Selection of checks by one argument of `pytest --imugrade`: by file, by criterion, or a single check.

    `file` is the file under which pytest lists the checks, None for any. `names` is a criterion's id, or its id and the name of
    one of its checks; () selects all checks of the file.
    """

    file: Path | None
    names: tuple[str, ...]

    def holds(self, file: Path, *names: str) -> bool:
        return (self.file is None or self.file == file) and names[: len(self.names)] == self.names


@dataclass(frozen=True)
class PluginOptions:
    """Request to `pytest --imugrade`: a submission's path, and names of files, criteria or checks; without names, all checks."""

    path: Path
    named: tuple[Name, ...]

    def wants(self, file: Path, criterion: str, check: str) -> bool:
        return not self.named or any(each.holds(file, criterion, check) for each in self.named)


def options_of(arguments: Sequence[str], criteria: Collection[str]) -> PluginOptions:
    """Separate arguments that name checks, files or criteria from the one that is the submission's path.

    `criteria` are the ids of the lab's criteria and extensions.
    ``sensor_access`` and ``sensor_access::follows_address`` are names, and so is what pytest and editors call a test:
    ``imu_reader.py::sensor_access::follows_address``. A Python file or notebook that exists is also a name: it selects the checks
    listed under it. Any other argument is the path; without one it is the working folder.

    Raises
    ------
    RequestError
        If more than one submission is named.
    """
    named = {argument: name for argument in arguments if (name := _name(argument, criteria)) is not None}
    paths = [argument for argument in arguments if argument not in named]
    if len(paths) > 1:
        raise RequestError(f"one submission at a time: {' '.join(printable(path) for path in paths)}")
    return PluginOptions(Path(paths[0] if paths else "."), tuple(named.values()))


def _name(argument: str, criteria: Collection[str]) -> Name | None:
    head, *rest = argument.split("::")
    if head in criteria:
        return Name(None, (head, *rest))
    if rest or (head.endswith(_CODE) and Path(head).is_file()):
        return Name(Path(head).absolute(), tuple(rest))
    return None
