"""From deviations to what each check is charged: all shares of every fault, and what no fault lists."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from grader.base.errors import GraderError, Malformed
from grader.engine import feedback, hidden_feedback
from grader.engine.charging import Judge
from grader.engine.faults import FaultRow
from grader.engine.findings import Charge, Charged, Cost, Deviation, Raised, Size, Skipped, StudentError
from grader.engine.hypothesis import Reason
from grader.labs.imu.lab import LAB

pytestmark = pytest.mark.quick


@dataclass(frozen=True)
class Facts:
    """Properties that are off, and faults that fit."""

    off: str = ""
    fits: str = ""
    stopped: Mapping[str, Exception] = field(default_factory=dict)


def reason(of: str, cost: int, told: str, *, beside: bool = False) -> Reason[Facts]:
    return Reason(of, cost, told, lambda facts: told in facts.fits.split(), beside)


JUDGE: Judge[Facts] = Judge(
    LAB,
    "part",
    lambda student, truth: Facts(),
    (
        reason("a", 1, "cheap"),
        reason("a", 2, "dear"),
        reason("a", 2, "as-dear"),
        reason("a", 9, "beside", beside=True),
        reason("b", 1, "precise"),
        reason("b", 1, "cheap"),
        reason("form", 1, "odd"),
        reason("a", 3, "quiet"),
        reason("b", 3, "quiet"),
    ),
    {"form": lambda facts: Deviation({}) if "form" in facts.off.split() else None},
)


def check_of(name: str, deviation: Deviation[Any]) -> Callable[[Facts], Deviation[Any] | None]:
    def check(facts: Facts) -> Deviation[Any] | None:
        return deviation if name in facts.off.split() else None

    check.__doc__ = f"{name.upper()} holds"
    return check


for name, deviation in {
    "a": Deviation({"came": 1.5}, size=Size("a is off", 0.02, "m")),
    "b": Deviation({"came": 2}, share=0.5),
    "c": Deviation({"came": 3}),
}.items():
    JUDGE.check(f"part.{name}", lab_step=1)(check_of(name, deviation))


def row(id_: str, **more: object) -> tuple[str, FaultRow]:
    return id_, FaultRow(id_, "part", f"do not {id_}", title=f"it is {id_}", **more)  # type: ignore[arg-type]


ROWS = dict(
    [
        row("cheap", explanation="…"),
        row("dear", explanation="…", deducts={"a": 0.75, "b": 0.5, "c": 0}),
        row("as-dear", explanation="…"),
        row("beside", explanation="…", deducts={"a": 0.5}),
        row("precise", deducts={"b": 0.25}),
        row("quiet", explanation="…", deducts={"b": 0}),
        row("odd", explanation="…", deducts={"other.x": 1.0, "part.a": 0.25}, expected="{form}"),
        row("part.a", expected="a that holds", got="{came}", deducts={"c": 0}),
        *(row(f"part.{name}", expected=f"{name} that holds", got="{came}") for name in "bc"),
    ]
)
for name in "abc":
    ROWS[f"part.{name}"] = replace(ROWS[f"part.{name}"], group="checks")


def charged(off: str, fits: str = "", **stopped: Exception) -> dict[str, Exception | tuple[float, str]]:
    """By check: why it is not judged, or what it keeps, and the rows that cost it points, or the check that tells why."""
    charges = JUDGE.judge(Facts(off, fits, stopped), ROWS)
    return {name.removeprefix("part."): _short(charge) for name, charge in charges.items()}


def _short(charge: Charge | Exception) -> Exception | tuple[float, str]:
    if isinstance(charge, Exception):
        return charge
    return charge.keeps, " ".join(cost.row for cost in charge.costs) or charge.see


@pytest.mark.parametrize(
    ("off", "fits", "marked"),
    [
        ("", "cheap dear", {}),
        # a row that lists nothing costs what the checks say that show it; one that lists shares costs all of them
        ("a", "cheap dear", {"a": (0.0, "cheap")}),
        ("a b", "cheap", {"a": (0.0, "cheap"), "b": (0.5, "cheap")}),
        ("a", "dear", {"a": (0.25, "dear"), "b": (0.5, "dear")}),
        ("a b", "dear", {"a": (0.25, "dear"), "b": (0.5, "dear")}),
        ("a b", "quiet", {"a": (0.0, "quiet"), "b": (1.0, "A holds")}),
        # what a fault lists costs nothing more; what none lists is charged to its own check
        ("a c", "dear", {"a": (0.25, "dear"), "b": (0.5, "dear"), "c": (1.0, "A holds")}),
        ("a c", "cheap", {"a": (0.0, "cheap"), "c": (0.0, "part.c")}),
        ("a c", "", {"a": (0.0, "part.a"), "c": (1.0, "A holds")}),
        ("b", "", {"b": (0.5, "part.b")}),
        # faults of one cost exclude each other, and none is believed; others add up to the points of the check
        ("a", "dear as-dear", {"a": (0.0, "part.a")}),
        ("a", "beside", {"a": (0.5, "beside")}),
        ("a b", "dear beside precise", {"a": (0.0, "dear beside"), "b": (0.25, "dear precise")}),
        ("form", "odd", {"a": (0.75, "odd")}),
        ("form a", "odd dear", {"a": (0.0, "dear odd"), "b": (0.5, "dear")}),
    ],
)  # fmt: skip
def test_what_each_check_is_charged(off: str, fits: str, marked: dict[str, tuple[float, str]]) -> None:
    assert charged(off, fits) == marked


def test_a_fault_in_half_of_a_property_costs_half_at_each_check_and_is_told_where_it_is_seen() -> None:
    seen_at_b = Judge(LAB, "part", JUDGE.measure, (reason("b", 1, "dear"),), {}, dict(JUDGE.checks))
    seen_at_b.check("part.b", lab_step=1)(check_of("b", Deviation({"came": 2}, affected=0.5)))
    found = {id_: (each.keeps, each.costs[0].see) for id_, each in seen_at_b.judge(Facts("b", "dear"), ROWS).items()}  # type: ignore[union-attr]
    assert found == {"part.a": (0.625, "B holds"), "part.b": (0.75, "")}


@pytest.mark.parametrize(("off", "fits", "named"), [("a", "cheap", "cheap"), ("form a", "odd", "odd part.a")])
def test_a_fault_of_any_criterion_explains_only_a_check_that_shows_it(off: str, fits: str, named: str) -> None:
    found = JUDGE.judge(Facts(off, fits), {**ROWS, fits: replace(ROWS[fits], group="any")})
    assert {name: _short(each) for name, each in found.items()} == {"part.a": (0.0, named)}


def test_a_second_fault_gives_no_points_back() -> None:
    shows = {"cheap": "a b", "dear": "a b", "beside": "a", "precise": "b", "odd": "form"}

    def lost(*fits: str) -> float:
        marked = charged(" ".join(shows[fault] for fault in fits), " ".join(fits))
        return sum(1 - kept for kept, _ in marked.values())  # type: ignore[misc]

    pairs = list(itertools.permutations(shows, 2))
    assert [pair for pair in pairs if lost(pair[0]) > lost(*pair)] == []


def test_where_nothing_could_be_measured_nothing_is_charged() -> None:
    why = Skipped("an output")
    assert charged("a form", "cheap odd", a=why) == {"a": why}
    assert charged("b c", "dear", a=why) == {"a": why, "b": (0.5, "part.b"), "c": (0.0, "part.c")}


def test_a_check_that_stumbles_is_not_judged_and_the_others_are() -> None:
    def broken(facts: Facts) -> Deviation | None:
        raise ZeroDivisionError("a fault of ours")

    part = Judge(LAB, "part", lambda student, truth: Facts(), JUDGE.reasons, JUDGE.others, dict(JUDGE.checks))
    part.check("part.b", lab_step=1)(broken)
    found = part.judge(Facts("a b", "cheap"), ROWS)
    assert isinstance(found["part.b"], ZeroDivisionError)
    assert _short(found["part.a"]) == (0.0, "cheap")


def test_a_check_without_a_row_in_the_fault_table_is_a_fault_of_the_grader() -> None:
    """An instructor who forgets the row is told; no student loses points for it."""
    with pytest.raises(GraderError, match=r"the fault table has no row for part\.b$"):
        JUDGE.judge(Facts(""), {id_: each for id_, each in ROWS.items() if id_ != "part.b"})


def test_the_words_are_those_of_the_fault_or_of_the_check_and_of_hidden_data_a_name_alone() -> None:
    found = Charged(JUDGE.judge(Facts("a", "cheap"), ROWS)["part.a"])  # type: ignore[arg-type]
    public, hidden = feedback.feedback_on(found, None, ROWS), hidden_feedback.feedback_on(found, ROWS)
    assert (public.expected, public.got, public.hint, public.faults) == (
        "a that holds", "1.5", "do not cheap", ("cheap",)
    )  # fmt: skip
    assert (hidden.expected, hidden.got, hidden.hint, hidden.faults) == (
        "the same result on the hidden scenarios", "it is cheap", "do not cheap", ("cheap",)
    )  # fmt: skip


def test_a_check_that_lost_nothing_or_does_not_show_the_fault_says_where_it_is_told() -> None:
    for off, id_, said in (
        ("a c", "part.c", "No further deduction: the same fault was deducted under “A holds”."),
        ("a", "part.b", "Broken by the same fault as “A holds”."),
    ):
        charge = JUDGE.judge(Facts(off, "dear"), ROWS)[id_]
        assert feedback.feedback_on(Charged(charge), None, ROWS).said == said  # type: ignore[arg-type]


def test_an_answer_that_cannot_be_read_is_reviewed_unless_it_shows_tampering() -> None:
    odd, tampered = Malformed("no array"), Malformed("the worker code was changed")
    told = [
        *(feedback.feedback_on(each, None, ROWS) for each in (odd, tampered)),
        hidden_feedback.feedback_on(odd, ROWS),
    ]
    assert [(each.faults, each.not_understood) for each in told] == [((), True), (("tampering",), False), ((), True)]


def test_each_criterion_tells_an_exception_on_hidden_scenarios() -> None:
    finding = Raised(StudentError("IndexError", "", None, None, None), "filtering")
    keys = [hidden_feedback.cause_key(finding, part) for part in ("filtering", "filtering", "noise_model")]
    assert keys[0] == keys[1] != keys[2]


def test_words_that_cannot_be_formatted_decide_nothing() -> None:
    lost = Charged(Charge("part.a", (Cost("odd", 0.25, Deviation({}), Deviation({"came": 2})),)))
    told = feedback.feedback_on(lost, None, ROWS)
    assert (told.keeps, told.expected, told.got) == (0.75, "a that holds", "2")
    plain = feedback.feedback_on(Charged(Charge("part.a", (Cost("odd", 0.25, Deviation({})),))), None, ROWS)
    assert (plain.keeps, plain.said, plain.faults) == (0.75, "It is odd.", ("odd",))
