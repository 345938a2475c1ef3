"""Findings of a check: records and exceptions with the measured numbers. `feedback` turns them into text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypedDict, TypeVar

from grader.base.text import printable

NEEDS_REVIEW = "an instructor may give more points"
"""Part of a note; it puts the submission into the review queue."""


@dataclass(frozen=True)
class Where:
    """A place in a student's file. `line` is None if it is unknown, and in a notebook, where each cell counts its own lines."""

    file: str
    line: int | None = None


@dataclass(frozen=True)
class StudentError:
    """An exception raised by the student's code, with its place in their file."""

    type: str
    message: str
    file: str | None
    line: int | None
    text: str | None
    name: str | None = None
    path: str | None = None

    @classmethod
    def of(cls, facts: Mapping[str, Any] | None) -> StudentError | None:
        if not facts:
            return None
        known = {key: facts.get(key) for key in cls.__dataclass_fields__}
        return cls(**known | {"message": " ".join(str(facts.get("message") or "").split())})  # type: ignore[arg-type]

    @property
    def where(self) -> str:
        """The place as printable text: ``imu_reader.py, line 12``; "" if no line of the student's was running."""
        if not self.file:
            return ""
        file = printable(self.file.replace(":cell ", ", cell "), 120)
        return f"{file}, line {self.line}" if self.line else file

    @property
    def at(self) -> Where | None:
        """The place as a `Where`; None if no line of the student's was running."""
        named = self.file or ""
        file = named.partition(":cell ")[0]
        return Where(printable(file, 120), self.line if file == named else None) if file else None

    @property
    def lines(self) -> list[str]:
        """The source line as printable text, then a line with a caret for a syntax error; empty if the line is unknown."""
        return [printable(line, 160) for line in (self.text or "").split("\n")[:2] if line.strip()]


@dataclass(frozen=True)
class Size:
    """Kind and order of magnitude of an error, for feedback on hidden scenarios.

    Attributes
    ----------
    what : beginning of a sentence, a constant of the grader's code: never text or a name of the student's
    value, unit : size of the error; a message shows one of three steps, because code could encode hidden data in the digits
    """

    what: str
    value: float | None = None
    unit: str = ""

    def __str__(self) -> str:
        if self.value is None:
            return self.what
        size = abs(self.value)
        step = "less than 0.1" if size < 0.1 else "0.1 to 10" if size < 10.0 else "more than 10"  # NaN is the largest
        return f"{self.what} by {step} {self.unit}".rstrip()


class GraderText(str):
    """Text that is a constant of the grader's code. Joined with other text it is a plain `str`, which may hold a student's text."""

    __slots__ = ()


Numbers = TypeVar("Numbers", bound=Mapping[str, object])
"""The type of a property's numbers, a `TypedDict`: a test holds the keys of the fault table's templates against it."""


class NoNumbers(TypedDict):
    """Empty numbers, for a deviation whose feedback quotes no values."""


class Came(TypedDict):
    """Numbers of a deviation that one text describes: `came`, the answer in place of the one that was asked for."""

    came: str


class Form(TypedDict):
    """Numbers of an answer in a wrong form, such as a wrong shape: the form that was asked for, and what came."""

    form: str
    came: str


@dataclass(frozen=True)
class Deviation(Generic[Numbers]):
    """Deviation of a measured property from what its check asks.

    Attributes
    ----------
    numbers : values for the templates of any row of the fault table that may describe the deviation
    share : share of the check's points that is lost if no row lists another
    affected : affected fraction of the property, such as one of two sensors; each share is multiplied by it
    size : size of the error, shown in place of the numbers for a hidden scenario
    error : the exception that caused it
    """

    numbers: Numbers
    share: float = 1.0
    size: Size | None = None
    error: StudentError | None = None
    affected: float = 1.0


@dataclass(frozen=True)
class Cost:
    """Deduction of one fault at one check, as a share of the check's points.

    Attributes
    ----------
    row : id of the fault's row, or of the check's row if no fault is known
    share : the share of the check's points
    shown : the deviation through which the fault was found; its numbers fill the templates of the fault's row
    own : the deviation of the check itself; None if it does not show the fault
    see : title of the check that reports the fault; "" if it is this one
    """

    row: str
    share: float
    shown: Deviation[Any]
    own: Deviation[Any] | None = None
    see: str = ""


@dataclass(frozen=True)
class Charge:
    """Charge of one check: what each fault costs there.

    Attributes
    ----------
    costs : what is deducted, together at most all points of the check
    see : title of the check that deducts for the fault, if this check fails by it and deducts nothing; else ""
    """

    check: str
    costs: tuple[Cost, ...] = ()
    see: str = ""

    @property
    def keeps(self) -> float:
        """The share of the points that is earned."""
        return max(0.0, 1.0 - sum(cost.share for cost in self.costs))


class Charged(AssertionError):  # noqa: N818 - an outcome
    """Exception that carries a charge through pytest."""

    def __init__(self, charge: Charge) -> None:
        super().__init__(f"{charge.check} keeps {charge.keeps:g}")
        self.charge = charge


class CheckFailed(AssertionError):  # noqa: N818 - an outcome
    """Exception: a check fails and loses all or some of its points.

    Parameters
    ----------
    expected, got : the expected and the actual result: number, unit and place
    faults : ids of the faults that the measurement shows; empty if it shows none
    keeps : share of the points that is still earned, 0 to 1
    hint : hint to show instead of those of the faults; for a hidden scenario it is shown only if it is `GraderText`
    off : size of the error, shown in place of the data for a hidden scenario
    error : the exception that caused it; gives the place
    """

    def __init__(
        self,
        expected: str,
        got: str,
        *,
        faults: Sequence[str] = (),
        keeps: float = 0.0,
        hint: str = "",
        off: Size | None = None,
        error: StudentError | None = None,
    ) -> None:
        super().__init__(f"expected {expected}; got {got}")
        self.expected, self.got, self.off = expected, got, off
        self.faults, self.keeps, self.hint = tuple(faults), keeps, hint
        self.where = error.at if error else None


class Unusable(CheckFailed):
    """No check of the part can judge the answer: one check reports it, and the others are skipped."""


class Skipped(Exception):  # noqa: N818 - an outcome
    """The check cannot be judged because something that it needs is missing; the message completes "Needs …"."""


class Raised(Exception):  # noqa: N818 - an outcome
    """The student's code raised on valid input."""

    def __init__(self, error: StudentError, doing: str) -> None:
        super().__init__(f"{error.type}: {error.message}")
        self.error, self.doing = error, doing


def raised(error: StudentError | None, doing: str) -> None:
    """Raise `Raised`, which ends the check, if the student's code raised an `error` while `doing` (``reading the sensors``)."""
    if error is not None:
        raise Raised(error, doing)


class Missing(Exception):  # noqa: N818 - it is a finding about the submission, not a grader error
    """A required name is not defined: its file is missing, does not import, or does not define it."""

    def __init__(self, name: str, fault: str, message: str, where: Where | None = None) -> None:
        super().__init__(message)
        self.name, self.fault, self.where = name, fault, where
