"""Findings: exceptions that end a check, and the measured numbers in them. `feedback` turns a finding into text for students."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypedDict, TypeVar

from grader.base.text import printable

NEEDS_REVIEW = "an instructor may give more points"
"""Part of a note; it puts the submission into the review queue."""


@dataclass(frozen=True)
class Where:
    """Place in a student's file, for messages. `line` is None if unknown and in notebooks, where each cell counts its own lines."""

    file: str
    line: int | None = None


@dataclass(frozen=True)
class StudentError:
    """An exception that a student's code raised in the sandbox: its type and message, and where in the student's file.

    Attributes
    ----------
    file, line, text : the innermost line of the student's code that was running, and its source; None if there was none
    name : the name, attribute or module that was missing; None for other exceptions
    """

    type: str
    message: str
    file: str | None
    line: int | None
    text: str | None
    name: str | None = None

    @classmethod
    def of(cls, facts: Mapping[str, Any] | None) -> StudentError | None:
        if not facts:
            return None
        known = {key: facts.get(key) for key in cls.__dataclass_fields__}
        return cls(**known | {"message": " ".join(str(facts.get("message") or "").split())})  # type: ignore[arg-type]

    @property
    def where(self) -> str:
        """The place as printable text for a message: ``imu_reader.py, line 12``; "" if no line of the student's was running."""
        if not self.file:
            return ""
        file = printable(self.file.replace(":cell ", ", cell "), 120)
        return f"{file}, line {self.line}" if self.line else file

    @property
    def at(self) -> Where | None:
        """The place as a `Where`; None if no line of the student's code was running."""
        named = self.file or ""
        file = named.partition(":cell ")[0]
        return Where(printable(file, 120), self.line if file == named else None) if file else None

    @property
    def lines(self) -> list[str]:
        """The source line as printable text, and a second line with a caret for a syntax error; [] if the line is unknown."""
        return [printable(line, 160) for line in (self.text or "").split("\n")[:2] if line.strip()]


@dataclass(frozen=True)
class Size:
    """Kind and order of magnitude of an error, which feedback on hidden scenarios shows in place of the measured numbers.

    Attributes
    ----------
    what : beginning of a sentence, a constant of the grader's code: never text or a name of the student's
    value, unit : size of the error; messages show one of three ranges, as "0.1 to 10", because digits could encode hidden data
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
    """Text that is a constant of the grader's code, so it holds no hidden data; joined with other text it is a plain `str`."""

    __slots__ = ()


Numbers = TypeVar("Numbers", bound=Mapping[str, object])
"""The type of a property's numbers, a `TypedDict`: a test holds the keys of the fault table's templates against it."""


class NoNumbers(TypedDict):
    """Empty `numbers` of a `Deviation`, for faults whose feedback quotes no values."""


class Came(TypedDict):
    """Type of `Deviation.numbers` if the message quotes one text alone: `came`, what the student's code returned or did instead."""

    came: str


class Form(TypedDict):
    """Type of `Deviation.numbers` for a value of a wrong form or shape, in words: the `form` asked for, and what `came` instead."""

    form: str
    came: str


@dataclass(frozen=True)
class Deviation(Generic[Numbers]):
    """How a measured property deviates from what its check asks. A check returns it, and `charging.Judge` deducts points for it.

    The judge finds the known fault that explains the deviation, and looks the fault up in the lab's table of deductions and texts
    (`faults.rows`); without a known fault it looks up the check.

    Attributes
    ----------
    numbers : values by name, numbers or text, that fill the message templates of the table
    share : share of the check's points that is lost if the table lists none for the fault
    affected : affected fraction of the property, 0.5 for one of two sensors; the share is multiplied by it
    size : size of the error, which a message on hidden scenarios shows in place of the numbers; None shows no size
    error : the exception of the student's code that caused it; None if the code raised none
    """

    numbers: Numbers
    share: float = 1.0
    size: Size | None = None
    error: StudentError | None = None
    affected: float = 1.0


@dataclass(frozen=True)
class Cost:
    """Deduction for one fault at one check. A `Charge` holds all deductions of the check.

    Attributes
    ----------
    row : id of the fault in the fault table; if no fault is known, id of the check, which has an entry there, too
    share : the deduction as a share of the check's points
    shown : the deviation (`Deviation`) in which the fault shows, at this check or another; its numbers fill the fault's templates
    own : the deviation that this check found itself; None if it found none, and loses points by a fault seen at another check
    see : title of another check that reports the fault; "" if this check reports it
    """

    row: str
    share: float
    shown: Deviation[Any]
    own: Deviation[Any] | None = None
    see: str = ""


@dataclass(frozen=True)
class Charge:
    """All deductions of one check, one `Cost` for each fault. `charging.Judge` makes it, `feedback` puts it into words.

    Attributes
    ----------
    check : id of the check
    costs : what is deducted, together at most all points of the check
    see : title of the check that deducts for the fault, if this check shows it and deducts nothing for it; else ""
    """

    check: str
    costs: tuple[Cost, ...] = ()
    see: str = ""

    @property
    def keeps(self) -> float:
        """Share of the check's points that is still earned, 0 to 1."""
        return max(0.0, 1.0 - sum(cost.share for cost in self.costs))


class Charged(AssertionError):  # noqa: N818 - an outcome
    """Exception that ends a check with deductions: it carries the check's `Charge` through pytest to the grader."""

    def __init__(self, charge: Charge) -> None:
        super().__init__(f"{charge.check} keeps {charge.keeps:g}")
        self.charge = charge


class CheckFailed(AssertionError):  # noqa: N818 - an outcome
    """Exception that a check raises if it fails, so that all or some of its points are lost.

    Parameters
    ----------
    expected, got : the expected and the actual result in words, such as a number, its unit and where in the data it is
    faults : ids, as in `imugrade explain`, of the faults that explain the failure; () if none does
    keeps : share of the points that is still earned, 0 to 1
    hint : hint to show instead of those of the faults; for a hidden scenario it is shown only if it is `GraderText`
    off : size of the error, shown in place of `got` for a hidden scenario if no fault is named
    error : the exception of student code that caused the failure; gives the line that students are shown
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
    """Exception: no check of the criterion can judge what the code returned. The first check reports it; the others are skipped."""


class Skipped(Exception):  # noqa: N818 - an outcome
    """Exception: no points, as the student's result lacks what a check judges; the message ("an output") follows "Needs"."""


class Raised(Exception):  # noqa: N818 - an outcome
    """Exception: student code raised `error` on valid input. `doing` says during what, such as ``reading the sensors``."""

    def __init__(self, error: StudentError, doing: str) -> None:
        super().__init__(f"{error.type}: {error.message}")
        self.error, self.doing = error, doing


def raised(error: StudentError | None, doing: str) -> None:
    """Raise `Raised`, which ends the check, if the student's code raised an `error` while `doing` (``reading the sensors``)."""
    if error is not None:
        raise Raised(error, doing)


class Missing(Exception):  # noqa: N818 - it is a finding about the submission, not a grader error
    """Exception: a required name is not defined, because its file is missing, does not import, or does not define it.

    `fault` is the id of the fault that explains it, `where` the place of the cause in a student's file; None if no place is known.
    """

    def __init__(self, name: str, fault: str, message: str, where: Where | None = None) -> None:
        super().__init__(message)
        self.name, self.fault, self.where = name, fault, where
