"""One charge for a function that has other parameters than the sheet's: it is called by its own, and all else judged as usual."""

from __future__ import annotations

from collections.abc import Collection

from grader.engine.findings import Lost, Size

_HINT = (
    "Give the function the parameters that it has on the sheet, by the same names and in the same order: whoever calls it "
    "goes by these."
)


def as_on_the_sheet(departs: Collection[str], *, keeps: float = 0.5, belongs_to: str = "") -> None:
    """Charge parameters by which a function could not be called as the sheet does.

    Parameters
    ----------
    departs : the sheet's names for them; nothing of the student's
    """
    if departs:
        got = f"other parameters in place of, or beside, these: {', '.join(departs)}"
        off = Size(f"parameters that are not the sheet's: {', '.join(departs)}")
        raise Lost("the sheet's parameters, under its names and in its order", got, off=off, keeps=keeps, hint=_HINT, belongs_to=belongs_to)
