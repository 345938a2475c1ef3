"""What a check says: nothing when all is earned, otherwise a finding with numbers in it. Words are made in `feedback`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from grader.base.text import printable

A_PERSON_MAY = "an instructor may give more points"
"""Part of a note; it puts the submission into the review queue."""


@dataclass(frozen=True)
class Where:
    """A place in a student's files, by the name that they gave the file; no line in a notebook, whose cells count their own."""

    file: str
    line: int | None = None


@dataclass(frozen=True)
class Fault:
    """An exception of the student's: what, and where in their own file."""

    type: str
    message: str
    file: str | None
    line: int | None
    text: str | None
    name: str | None = None
    path: str | None = None

    @classmethod
    def of(cls, facts: Mapping[str, Any] | None) -> Fault | None:
        if not facts:
            return None
        known = {key: facts.get(key) for key in cls.__dataclass_fields__}
        return cls(**known | {"message": " ".join(str(facts.get("message") or "").split())})  # type: ignore[arg-type]

    @property
    def where(self) -> str:
        """``imu_reader.py, line 12``, as it can be shown; empty where no line of the student's was running."""
        if not self.file:
            return ""
        file = printable(self.file.replace(":cell ", ", cell "), 120)
        return f"{file}, line {self.line}" if self.line else file

    @property
    def at(self) -> Where | None:
        """The same as a place; None where no line of the student's was running."""
        named = self.file or ""
        file = named.partition(":cell ")[0]
        return Where(printable(file, 120), self.line if file == named else None) if file else None

    @property
    def lines(self) -> list[str]:
        """The line itself, as it can be shown; below one that is no Python, a caret."""
        return [printable(line, 160) for line in (self.text or "").split("\n")[:2] if line.strip()]


@dataclass(frozen=True)
class Size:
    """What is wrong and by how much, for where the data itself is hidden.

    Attributes
    ----------
    what : a sentence's beginning that stands in our code: never text or a name of the student's
    value, unit : how large the error is; a message holds only its power of ten, as code could put more into a number
    """

    what: str
    value: float | None = None
    unit: str = ""

    def __str__(self) -> str:
        if self.value is None:
            return self.what
        if not 1e-12 < abs(self.value) < 1e12:  # NaN is not, either
            return f"{self.what}, beyond all measure"
        power = math.floor(math.log10(abs(self.value)))
        return f"{self.what} by {_power(power)} to {_power(power + 1)} {self.unit}".rstrip()


def _power(exponent: int) -> str:
    return f"{10.0**exponent:g}"


class Ours(str):
    """Words that stand in our code just so. Put together with any others they are a plain `str`: those may be a student's."""

    __slots__ = ()


@dataclass(frozen=True)
class Deviation:
    """How a measured property misses what its check asks.

    Attributes
    ----------
    numbers : what the templates of rows may name
    share : of the check's points, lost where no fault explains it
    affected : how much of the property is off, such as one of two sensors; what a fault deducts is multiplied by it
    size : what is said of a hidden scenario
    fault : the exception that it came of
    """

    numbers: Mapping[str, object] = field(default_factory=dict)
    share: float = 1.0
    size: Size | None = None
    fault: Fault | None = None
    affected: float = 1.0


@dataclass(frozen=True)
class Charge:
    """What one check is charged.

    Attributes
    ----------
    keeps : the share of its points that is earned
    found : the id of each row that tells why, with the deviation that it explains
    see : title of the check that tells it; with nothing kept, this one could not be reached, else it is not charged again
    """

    check: str
    keeps: float
    found: tuple[tuple[str, Deviation], ...] = ()
    see: str = ""

    def plus(self, row: str, share: float, deviation: Deviation) -> Charge:
        """With another fault: what they deduct adds up."""
        return replace(self, keeps=max(0.0, self.keeps - share), found=(*self.found, (row, deviation)))

    @classmethod
    def of(cls, check: str, deviation: Deviation) -> Charge:
        """What no fault explains, charged to the check that measures it."""
        return cls(check, 1.0 - deviation.share * deviation.affected, ((check, deviation),))


class Charged(AssertionError):  # noqa: N818 - an outcome
    """How pytest hears of a charge."""

    def __init__(self, charge: Charge) -> None:
        super().__init__(f"{charge.check} keeps {charge.keeps:g}")
        self.charge = charge


class CheckFailed(AssertionError):  # noqa: N818 - an outcome
    """Points are lost, all of them or a part.

    Parameters
    ----------
    expected, got : what was expected and what came: number, unit and place
    mistakes : ids of the mistakes that the measurement shows; empty where it shows none
    keeps : share of the points that is earned all the same, 0 to 1
    hint : words for `Try` where the measurement says more than the names of the mistakes, or names none; told of a hidden scenario
        where they are `Ours`
    off : the size of the error, which is said in place of the data where the scenario is hidden
    belongs_to : id of the check that charges the same fault, or of several: where one is lost, this one keeps its points
    fault : the exception that it came of, which says where
    """

    def __init__(
        self,
        expected: str,
        got: str,
        *,
        mistakes: Sequence[str] = (),
        keeps: float = 0.0,
        hint: str = "",
        off: Size | None = None,
        belongs_to: str | tuple[str, ...] = "",
        fault: Fault | None = None,
    ) -> None:
        super().__init__(f"expected {expected}; got {got}")
        self.expected, self.got, self.off = expected, got, off
        self.belongs_to = (belongs_to,) if isinstance(belongs_to, str) else belongs_to
        self.mistakes, self.keeps, self.hint = tuple(mistakes), keeps, hint
        self.where = fault.at if fault else None


class Unusable(CheckFailed):
    """No check of the part can judge what came: one says so, and the others are not reached."""


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


class Missing(Exception):  # noqa: N818 - it is a finding about the submission, not an error of ours
    """A required name is not there: the file is missing, does not import, or does not define it."""

    def __init__(self, name: str, mistake: str, message: str, where: Where | None = None) -> None:
        super().__init__(message)
        self.name, self.mistake, self.where = name, mistake, where
