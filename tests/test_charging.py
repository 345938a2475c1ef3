"""From deviations to what each check is charged: reasons of a property's own first, and each fault once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import pytest

from grader.engine import feedback, hidden_feedback
from grader.engine.charging import Part
from grader.engine.faults import Mistake
from grader.engine.findings import Charge, Charged, Deviation, Size, Skipped
from grader.engine.hypothesis import Reason
from grader.labs.imu.lab import LAB

pytestmark = pytest.mark.quick


@dataclass(frozen=True)
class Facts:
    """Properties that are off, and faults that fit."""

    off: str = ""
    fits: str = ""
    stopped: Mapping[str, Exception] = field(default_factory=dict)


def reason(of: str, cost: int, told: str, *predicts: str) -> Reason[Facts]:
    return Reason(of, cost, told, lambda facts: told in facts.fits.split(), frozenset(predicts))


PART: Part[Facts] = Part(
    LAB,
    "part",
    lambda student, truth: Facts(),
    (
        reason("a", 1, "cheap", "b"),
        reason("a", 2, "dear", "b", "c"),
        reason("a", 2, "as-dear"),
        reason("a", 9, "part.a", "b"),
        reason("b", 1, "precise"),
        reason("b", 1, "cheap"),
        reason("b", 5, "dear"),
        reason("c", 1, "nothing-there"),
        reason("form", 1, "odd"),
    ),
    {"form": lambda facts: Deviation() if "form" in facts.off.split() else None},
)


def check_of(name: str, deviation: Deviation) -> Callable[[Facts], Deviation | None]:
    def check(facts: Facts) -> Deviation | None:
        return deviation if name in facts.off.split() else None

    check.__doc__ = f"{name.upper()} holds"
    return check


for name, deviation in {
    "a": Deviation({"came": 1.5}, size=Size("a is off", 0.02, "m")),
    "b": Deviation({"came": 2}, share=0.5),
    "c": Deviation({"came": 3}),
}.items():
    PART.check(f"part.{name}", lab_step=1)(check_of(name, deviation))


def row(id_: str, **more: object) -> tuple[str, Mistake]:
    return id_, Mistake(id_, "part", f"do not {id_}", title=f"it is {id_}", **more)  # type: ignore[arg-type]


ROWS = dict(
    [
        row("cheap", explanation="…"),
        row("dear", explanation="…", deducts={"a": 0.75}),
        row("as-dear", explanation="…"),
        row("precise", deducts={"b": 0.25}),
        row("nothing-there", explanation="…", deducts={"c": 1.0}, takes=("a", "b")),
        row("odd", explanation="…", deducts={"other.x": 1.0, "part.a": 0.25}, expected="{form}"),
        *(row(f"part.{name}", expected=f"{name} that holds", got="{came}") for name in "abc"),
    ]
)


def charged(off: str, fits: str = "", **stopped: Exception) -> dict[str, Exception | tuple[float, str]]:
    """By check: why it is not judged, or what it keeps, and the rows that tell it, or the check that does."""
    charges = PART.judge(Facts(off, fits, stopped), ROWS)
    return {name.removeprefix("part."): _short(charge) for name, charge in charges.items()}


def _short(charge: Charge | Exception) -> Exception | tuple[float, str]:
    if isinstance(charge, Exception):
        return charge
    return charge.keeps, charge.see or " ".join(id_ for id_, _ in charge.found)


@pytest.mark.parametrize(
    ("off", "fits", "marked"),
    [
        ("", "cheap dear", {}),
        ("a", "cheap dear", {"a": (0.0, "cheap")}),
        ("a", "dear", {"a": (0.25, "dear")}),
        ("a", "dear as-dear", {"a": (0.0, "part.a")}),
        ("a", "", {"a": (0.0, "part.a")}),
        ("b", "", {"b": (0.5, "part.b")}),
        ("b", "precise", {"b": (0.75, "precise")}),
        ("a b", "cheap", {"a": (0.0, "cheap"), "b": (1.0, "A holds")}),
        ("a b", "dear precise", {"a": (0.25, "dear"), "b": (0.75, "precise")}),
        ("a b", "part.a", {"a": (0.0, "part.a"), "b": (1.0, "A holds")}),
        ("a c", "cheap", {"a": (0.0, "cheap"), "c": (0.0, "part.c")}),
        ("a c", "dear", {"a": (0.25, "dear"), "c": (1.0, "A holds")}),
        ("c", "nothing-there", {"c": (0.0, "nothing-there"), "a": (0.0, "C holds"), "b": (0.0, "C holds")}),
        ("a b c", "cheap precise nothing-there", {"c": (0.0, "nothing-there"), "a": (0.0, "C holds"), "b": (0.0, "C holds")}),
        ("form", "odd", {"a": (0.75, "odd")}),
        ("form a", "odd dear", {"a": (0.0, "dear odd")}),
        ("form a", "odd cheap", {"a": (0.0, "cheap odd")}),
    ],
)  # fmt: skip
def test_what_each_check_is_charged(off: str, fits: str, marked: dict[str, tuple[float, str]]) -> None:
    assert charged(off, fits) == marked


def test_where_nothing_could_be_measured_nothing_is_charged_and_a_fault_is_charged_to_the_check_that_saw_it() -> None:
    why = Skipped("an output")
    assert charged("a form", "cheap odd", a=why) == {"a": why}
    assert charged("b c", "dear", a=why) == {"a": why, "b": (0.5, "part.b"), "c": (0.0, "part.c")}


def test_a_check_that_stumbles_is_not_judged_and_the_others_are() -> None:
    def broken(facts: Facts) -> Deviation | None:
        raise ZeroDivisionError("a fault of ours")

    part = Part(LAB, "part", lambda student, truth: Facts(), PART.reasons, PART.others, dict(PART.checks))
    part.check("part.b", lab_step=1)(broken)
    found = part.judge(Facts("a b", "cheap"), ROWS)
    assert isinstance(found["part.b"], ZeroDivisionError)
    assert _short(found["part.a"]) == (0.0, "cheap")


def test_the_words_are_those_of_the_fault_or_of_the_check_and_of_hidden_data_a_size_alone() -> None:
    found = Charged(PART.judge(Facts("a", "cheap"), ROWS)["part.a"])  # type: ignore[arg-type]
    public, hidden = feedback.feedback_on(found, None, ROWS), hidden_feedback.feedback_on(found, ROWS)
    assert (public.expected, public.got, public.hint, public.mistakes) == (
        "a that holds", "1.5", "do not cheap", ("cheap",)
    )  # fmt: skip
    assert (hidden.expected, hidden.got, hidden.hint, hidden.mistakes) == (
        "the same result on the hidden scenarios", "it is cheap; a is off by 0.01 to 0.1 m", "do not cheap", ("cheap",)
    )  # fmt: skip


def test_a_check_that_is_not_charged_says_where_the_fault_is_told() -> None:
    for off, fits, id_, said in (
        ("a b", "cheap", "part.b", "No further deduction: the same fault was deducted under “A holds”."),
        ("c", "nothing-there", "part.a", "Not graded until “C holds” is fixed."),
    ):
        charge = PART.judge(Facts(off, fits), ROWS)[id_]
        assert feedback.feedback_on(Charged(charge), None, ROWS).said == said  # type: ignore[arg-type]
