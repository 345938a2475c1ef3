"""What a hostile program is, and how an attack is put into a submission that is otherwise sound."""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.cases import CRITERIA
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files

FAMILIES = ("forgery", "denial", "escape", "poison", "bytes")
READER, NOISE, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"


@dataclass(frozen=True)
class Program:
    """One attack.

    Attributes
    ----------
    name, family
    files
        The submission. Texts hold marks such as ``@SECRET@`` that `decoys.Decoys.fill` replaces by the decoys of the run.
    twin
        The same submission without the attack, which must score as much or more; None where nothing is to be gained.
    only
        The criterion that it is graded on, where one is enough.
    keeps
        Criteria that must keep all their points: the attack is the submission's own loss, and only where it is.
    hidden
        Graded on hidden scenarios.
    """

    name: str
    family: str
    files: Files
    twin: Files | None = None
    only: str | None = None
    keeps: tuple[str, ...] = ()
    as_: str = "folder"
    folder: str = "submission"
    hidden: bool = False


def but(*lost: str) -> tuple[str, ...]:
    """All criteria other than these."""
    return tuple(criterion for criterion in CRITERIA if criterion not in lost)


def first(files: Files, path: str, attack: str) -> Files:
    """The submission with the attack before everything else in a file."""
    return {**files, path: attack.strip("\n") + "\n\n\n" + str(files[path])}


def last(files: Files, path: str, attack: str) -> Files:
    """The submission with the attack after everything else in a file."""
    return {**files, path: str(files[path]) + "\n\n\n" + attack.strip("\n") + "\n"}


def indented(code: str) -> str:
    return "\n".join("    " + line for line in code.strip("\n").split("\n"))


def in_method(cls: str, method: str, attack: str) -> str:
    """Code that lets a class run the attack each time before a method; ``self``, ``args`` are in its reach."""
    return f"""
_sound = {cls}.{method}


def _attacking(self, *args, **kwargs):
{indented(attack)}
    return _sound(self, *args, **kwargs)


{cls}.{method} = _attacking
"""


def in_function(name: str, attack: str) -> str:
    """Code that lets a function run the attack each time before it does its work."""
    return f"""
_sound_{name} = {name}


def {name}(*args, **kwargs):
{indented(attack)}
    return _sound_{name}(*args, **kwargs)
"""


def sound() -> Files:
    return dict(tidy())
