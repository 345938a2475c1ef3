"""What a faulty submission is: a sound one with one fault, and what a fair marker would say to it."""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.writing import Files


@dataclass(frozen=True)
class Faulty:
    """A submission with one fault.

    Attributes
    ----------
    name : str
        Unique; words joined by hyphens.
    mistake : str
        The id of misconceptions.yaml that the fault is; "" where it has no name.
    criterion : str
        The only criterion that may lose points; "" if none may.
    files : Files
    also : tuple of str
        Other ids that are a true description of the same fault.
    reason : str
        Why a fair marker says so.
    never : tuple of str
        Ids that describe another fault that looks like this one; naming them would be wrong.
    loses : tuple of str
        Where the contract is explicit: the only checks that may be lost.
    elsewhere : tuple of str
        Criteria that need the same missing part, and may lose points too.
    """

    name: str
    mistake: str
    criterion: str
    files: Files
    also: tuple[str, ...] = ()
    reason: str = ""
    never: tuple[str, ...] = ()
    loses: tuple[str, ...] = ()
    elsewhere: tuple[str, ...] = ()


@dataclass(frozen=True)
class Pair:
    """A submission with two faults, each with the criterion that it costs."""

    name: str
    faults: tuple[tuple[str, str], ...]
    files: Files
    also: tuple[str, ...] = ()
