"""What a check says: nothing when all is earned, otherwise a finding with numbers in it. Words are made in `feedback`."""

from __future__ import annotations

from collections.abc import Sequence

from .answers import Fault


class Lost(AssertionError):  # noqa: N818 - an outcome
    """Points are lost, all of them or a part.

    Parameters
    ----------
    expected, got : what was expected and what came: number, unit and place
    mistakes : ids of the mistakes that the measurement shows; empty where it shows none
    keeps : share of the points that is earned all the same, 0 to 1
    hint : words for `Try` where the measurement says more than the names of the mistakes, or names none
    off : the size of the error in words, which is said in place of the data where the scenario is hidden
    """

    def __init__(
        self,
        expected: str,
        got: str,
        *,
        mistakes: Sequence[str] = (),
        keeps: float = 0.0,
        hint: str = "",
        off: str = "",
    ) -> None:
        super().__init__(f"expected {expected}; got {got}")
        self.expected, self.got, self.off = expected, got, off
        self.mistakes, self.keeps, self.hint = tuple(mistakes), keeps, hint


class Skipped(Exception):  # noqa: N818 - an outcome
    """Cannot be judged because something that it needs is missing; `reason` completes "Needs …"."""


class Raised(Exception):  # noqa: N818 - an outcome
    """The student's code raised on valid input."""

    def __init__(self, fault: Fault, doing: str) -> None:
        super().__init__(f"{fault.type}: {fault.message}")
        self.fault, self.doing = fault, doing


def raised(fault: Fault | None, doing: str) -> None:
    """Stop the check if the student's code raised while `doing` (``reading the sensors``)."""
    if fault is not None:
        raise Raised(fault, doing)
