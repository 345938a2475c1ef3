"""One charge for a definition that does not fit in as the sheet's does, and that all else is judged of as if it did."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from grader.engine.findings import Fault, Lost, Size
from grader.ground.text import printable
from grader.labs.imu.student import Student

_GLOBAL, _NAME = "global ", "name for "
_REFUSED = ("a file that Python can read", "text that Python refuses")
_STOPS = ("a definition that Python can make", "a definition that stops where it is made")


@dataclass(frozen=True)
class _Lack:
    """What a definition lacks: what was expected, what came, what of it is off in short, and the name of the mistake."""

    expected: str
    got: str
    off: str
    mistake: str
    fault: Fault | None = None
    of_its_parameters: bool = False
    of_a_call: bool = False


def fits_in(
    student: Student,
    name: str,
    departs: Collection[str],
    *,
    keeps: float = 0.5,
    belongs_to: str = "",
    left_out: tuple[str, ...] = (),
) -> None:
    """Charge what a definition needed in order to be of use at all: its name, an import, a return, or the sheet's parameters.

    Parameters
    ----------
    departs : the sheet's names for the parameters by which it could not be called as the sheet does, and for those in whose place
        it reads a ``global``, or takes a ``name``; nothing of the student's
    belongs_to : the check that charges the same, of what it departs by
    left_out : those that do of a call that was left out
    """
    for lack in _lacks(student, name, departs):
        raise Lost(
            lack.expected,
            lack.got,
            off=Size(lack.off),
            mistakes=[lack.mistake],
            keeps=keeps,
            fault=lack.fault,
            belongs_to=belongs_to if lack.of_its_parameters else left_out if lack.of_a_call else "",
        )


def _lacks(student: Student, name: str, departs: Collection[str]) -> Iterator[_Lack]:
    """What stands first in the way comes first."""
    for first in student.completed_in(name)[:1]:
        got = f"{first.type}: {printable(first.message, 200)} at {first.where}; mended, so that the rest counts"
        refused = first.type.endswith(("SyntaxError", "IndentationError", "TabError"))
        expected, off = _REFUSED if refused else _STOPS
        mistake = "missing-package" if first.type == "ModuleNotFoundError" else "does-not-import"
        yield _Lack(expected, got, off, mistake, first)
    wanted, own = student.misspelt(name)
    if own:
        taken = f"{printable(own, 60)}, which was taken for {wanted}"
        yield _Lack(wanted, taken, f"a name that is not spelled as {wanted}", "name-missing")
    if lent := ", ".join(student.lent_to(name)):
        got, off = f"no {lent} there: lent to it", f"no {lent} there"
        yield _Lack("a file that has what it uses when it is imported", got, off, "import-missing")
    slips = student.slips_in(name)
    if mended := [slip for slip in slips if not slip.is_left_out]:
        meant = _each_once(slip.meant for slip in mended)
        written = _each_once("no self" if slip.kind == "self" else slip.own for slip in mended)
        got = f"{written} at {mended[0].fault.where}, which it stops at; taken for {meant}"
        yield _Lack(meant, got, "what it stops at", mended[0].mistake, mended[0].fault)
    for slip in slips[:1]:
        got = f"{printable(slip.meant, 200)} at {slip.fault.where}; {printable(slip.own, 60)} was left out, so that the rest counts"
        yield _Lack("no exception", got, "what it stops at", slip.mistake, slip.fault, of_a_call=True)
    if student.returns_nothing(name):
        got = "none: what stands last was taken"
        yield _Lack("a return at the end", got, "no return at the end", "return-missing")
    if read := " and ".join(each.removeprefix(_GLOBAL) for each in departs if each.startswith(_GLOBAL)):
        got = f"a global in place of {read}"
        yield _Lack(f"the {read} that {name} is given", got, got, "global-for-parameter", of_its_parameters=True)
    if any(each.startswith(_NAME) for each in departs):
        got, off = (
            "names: it stops at ids, and was called with the names of the sensors",
            "names of sensors in place of ids",
        )
        yield _Lack(
            "the ids of both sensors, as mj_name2id gives them", got, off, "other-parameters", of_its_parameters=True
        )
    if odd := ", ".join(departs):
        expected = "the sheet's parameters, under its names and in its order"
        got, off = f"others in place of, or beside, these: {odd}", f"those that differ: {odd}"
        yield _Lack(expected, got, off, "other-parameters", of_its_parameters=True)


def _each_once(texts: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(printable(text, 60) for text in texts))
