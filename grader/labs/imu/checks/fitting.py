"""One charge for a definition that does not fit in as the sheet's does, and that all else is judged of as if it did."""

from __future__ import annotations

from collections.abc import Collection

from grader.engine.findings import Lost, Size
from grader.ground.text import printable
from grader.labs.imu.student import Student

_GLOBAL = "global "


def fits_in(student: Student, name: str, departs: Collection[str], *, keeps: float = 0.5, belongs_to: str = "") -> None:
    """Charge what a definition needed in order to be of use at all: its name, an import, a return, or the sheet's parameters.

    Parameters
    ----------
    departs : the sheet's names for the parameters by which it could not be called as the sheet does, and for those in whose place
        it reads a ``global``; nothing of the student's
    """
    if refused := student.completed_in(name):
        first = refused[0]
        got = f"{first.type}: {printable(first.message, 200)} at {first.where}; what it expects was put there"
        off = Size("text that Python refuses")
        raise Lost("a file that Python can read", got, off=off, mistakes=["does-not-import"], keeps=keeps, fault=first)
    wanted, own = student.misspelt(name)
    if own:
        off = Size(f"a name that is not spelled as {wanted}")
        raise Lost(
            wanted, f"{printable(own, 60)}, which was taken for it", off=off, mistakes=["name-missing"], keeps=keeps
        )
    if lent := ", ".join(student.lent_to(name)):
        off = Size(f"no import of {lent}")
        raise Lost(
            "a file that imports what it uses",
            f"{lent} without an import",
            off=off,
            mistakes=["import-missing"],
            keeps=keeps,
        )
    if slips := student.slips_in(name):
        meant = ", ".join(dict.fromkeys(printable(slip.meant, 60) for slip in slips))
        written = ", ".join(
            dict.fromkeys("no self" if slip.kind == "self" else printable(slip.own, 60) for slip in slips)
        )
        off, got = Size("what it stops at"), f"{written} at {slips[0].fault.where}, for which that was taken"
        mistake = "unknown-name" if slips[0].is_of_a_name else "raises"
        raise Lost(meant, got, off=off, mistakes=[mistake], keeps=keeps, fault=slips[0].fault)
    if student.returns_nothing(name):
        off = Size("no return at the end")
        raise Lost(
            "a return at the end",
            "none: what stands last was taken",
            off=off,
            mistakes=["return-missing"],
            keeps=keeps,
        )
    if read := [name for name in departs if name.startswith(_GLOBAL)]:
        these = " and ".join(name.removeprefix(_GLOBAL) for name in read)
        got, off = f"a global in place of {these}", Size(f"a global in place of {these}")
        raise Lost(
            f"the {these} that {name} is given",
            got,
            off=off,
            mistakes=["global-for-parameter"],
            keeps=keeps,
            belongs_to=belongs_to,
        )
    if odd := ", ".join(departs):
        got, off = f"others in place of, or beside, these: {odd}", Size(f"those that differ: {odd}")
        expected = "the sheet's parameters, under its names and in its order"
        raise Lost(expected, got, off=off, mistakes=["other-parameters"], keeps=keeps, belongs_to=belongs_to)
