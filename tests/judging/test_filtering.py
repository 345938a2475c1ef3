"""Filtering, on facts that are made by hand: what each filter is charged, and in which words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grader.engine import hidden_feedback
from grader.engine.faults import rows
from grader.engine.findings import Charge, Charged, StudentError
from grader.labs.imu.answers import FilterRun
from grader.labs.imu.compare import Array
from grader.labs.imu.filtering import checks
from grader.labs.imu.filtering.explain import JUDGE, recursion
from grader.labs.imu.filtering.measure import Facts, asked, facts, measure
from grader.labs.imu.lab import LAB
from grader.labs.imu.student import FilterCase
from tests.generated import differs
from tests.judging.fake_students import WORDS, FakeStudent, pinned, truth, words

pytestmark = pytest.mark.quick
CASES = asked(truth()["filter"])
FIRST, SECOND = list(CASES)[:2]
ROWS = rows(LAB)
OF, START, CONSTANT, NOISE, SIGNAL, OWN = (
    "follows_recursion", "starts_from_first_measurement", "passes_constant", "reduces_noise", "preserves_signal",
    "instances_independent",
)  # fmt: skip
Filter = Callable[[float, Array, Array | None], Array]
"""alpha, measurements (n, 3) and the initial value to outputs (n, 3)."""


def sheet(alpha: float, x: Array, initial: Array | None = None) -> Array:
    start = x[0] if initial is None else alpha * x[0] + (1 - alpha) * initial
    return recursion(alpha, x, start)


def of(a: Callable[[float], float], b: Callable[[float], float]) -> Filter:
    """``y[n] = a x[n] + b y[n-1]`` from the first measurement, or from the initial value, on."""

    def answer(alpha: float, x: Array, initial: Array | None) -> Array:
        y = [x[0] if initial is None else a(alpha) * x[0] + b(alpha) * initial]
        for sample in x[1:]:
            y.append(a(alpha) * sample + b(alpha) * y[-1])
        return np.array(y)

    return answer


def out(change: Callable[[Array], Array]) -> Filter:
    """The sheet's filter, and something done to what comes out."""
    return lambda alpha, x, initial: change(sheet(alpha, x, initial))


def memoryless(change: Callable[[Array], Array]) -> Filter:
    return lambda _alpha, x, _initial: change(x)


def window(size: int) -> Filter:
    return lambda _a, x, _i: np.array([x[max(0, n - size + 1) : n + 1].mean(axis=0) for n in range(len(x))])


def _behind(alpha: float, x: Array, initial: Array | None) -> Array:
    return np.vstack([x[:1], sheet(alpha, x, initial)[:-1]])


def judged(found: Facts) -> dict[str, tuple[float, str]]:
    """By check: the share that it keeps, with the rows that tell it; "not charged" or "not reached" where another one does."""
    return {name.removeprefix("filtering."): _short(charge) for name, charge in JUDGE.judge(found, ROWS).items()}


def _short(charge: Charge | Exception) -> tuple[float, str]:
    if isinstance(charge, Exception):
        return 0.0, type(charge).__name__
    seen = "not charged"
    return charge.keeps, seen if not charge.costs else " ".join(
        cost.row.removeprefix("filtering.") for cost in charge.costs
    )


def runs_of(answer: Filter) -> dict[str, FilterRun]:
    """What a filter answers in each case."""
    return {
        name: FilterRun(answer(case.alpha or 0.1, case.signal, case.initial), None, None)
        for name, case in CASES.items()
    }


def facts_of(runs: Mapping[str, FilterRun], stumbles: StudentError | None = None) -> Facts:
    """What is known of a filter that answers so, and as the sheet's in all other cases."""
    return facts(CASES, list({**RAN, **runs}.values()), stumbles=stumbles)


RAN = runs_of(sheet)


def no_filter(fault: str) -> dict[str, tuple[float, str]]:
    return dict.fromkeys((OF, START, CONSTANT, NOISE, SIGNAL), (0.0, fault))


FILTERS: list[tuple[str, Filter, Mapping[str, tuple[float, str]]]] = [
    ("sound", sheet, {}),
    ("single precision", out(lambda y: y.astype(np.float32).astype(float)), {}),
    ("another default", lambda a, x, i: sheet(0.3 if len(x) == 100 else a, x, i), {OF: (0.5, "alpha-default")}),
    ("two decimals", out(lambda y: y.round(2)), {OF: (0.0, "output-rounded"), START: (1.0, "not charged"), CONSTANT: (1.0, "not charged")}),
    ("gain of two", of(lambda a: a, lambda a: 1), {**dict.fromkeys((OF, CONSTANT, SIGNAL), (0.0, "gain-not-one")), START: (1.0, "not charged"), NOISE: (1.0, "not charged")}),
    ("updates twice", of(lambda a: 1 - (1 - a) ** 2, lambda a: (1 - a) ** 2), {OF: (0.0, "updates-twice"), START: (1.0, "not charged")}),
    ("a mean of ten", window(10), {OF: (0.0, "moving-average"), START: (1.0, "not charged")}),
    ("one behind", _behind, {OF: (0.0, "one-behind"), START: (1.0, "not charged")}),
    ("high-pass", lambda a, x, i: x - sheet(a, x, i), {**dict.fromkeys((OF, CONSTANT, SIGNAL), (0.0, "high-pass")), START: (1.0, "not charged")}),
    ("kept nowhere", lambda a, x, i: a * x + (1 - a) * (x[0] if i is None else i), {OF: (0.0, "state-not-kept"), SIGNAL: (1.0, "not charged")}),
    ("from zero", lambda a, x, i: sheet(a, x, np.zeros(3) if i is None else i), {START: (0.0, "zero-initial-state")}),
    ("initial value ignored", lambda a, x, _: sheet(a, x), {START: (0.5, "initial-value-ignored")}),
    ("nothing of a constant", lambda a, x, i: sheet(a, x, i) * bool(np.ptp(x, axis=0).any()), {CONSTANT: (0.0, CONSTANT)}),
    ("the first for ever", memoryless(lambda x: x[:1] + 0 * x), {**no_filter("output-stuck"), START: (0.0, "output-stuck initial-value-ignored")}),
    ("tanh", memoryless(np.tanh), no_filter("does-not-filter")),
    ("a mean with zero", lambda a, x, _: a * x, {**no_filter("does-not-filter"), START: (0.0, "does-not-filter zero-initial-state")}),
    ("zero", memoryless(lambda x: 0 * x), {**no_filter("output-stuck"), START: (0.0, "output-stuck zero-initial-state"), OWN: (0.0, "Skipped")}),
]  # fmt: skip


@pytest.mark.parametrize(("answer", "marked"), [row[1:] for row in FILTERS], ids=[row[0] for row in FILTERS])
def test_what_a_filter_is_charged(answer: Filter, marked: Mapping[str, tuple[float, str]]) -> None:
    assert judged(facts_of(runs_of(answer))) == marked


FAULT = StudentError("ValueError", "no", "filters.py", 7, None)
ANSWERS: list[tuple[str, Mapping[str, FilterRun], Mapping[str, tuple[float, str]]]] = [
    ("needs alpha", {"no alpha": FilterRun(None, None, FAULT)}, {OF: (0.5, "needs-alpha")}),
    ("raises", {SECOND: FilterRun(None, None, FAULT)}, dict.fromkeys((OF, START, CONSTANT, NOISE, SIGNAL), (0.0, "Raised"))),
    ("other parameters", {FIRST: replace(RAN[FIRST], departs=("measurement",))}, {OF: (0.5, "other-parameters")}),
    ("a global", {FIRST: replace(RAN[FIRST], departs=("global alpha",))}, {OF: (0.5, "global-for-parameter")}),
    ("pairs", {name: replace(run, odd="a tuple of 2") for name, run in RAN.items()}, {OF: (0.5, "wrong-return-type")}),
    ("numbers", {name: FilterRun(run.output * np.nan, "a number", None) for name, run in RAN.items()}, dict.fromkeys((OF, START, CONSTANT, NOISE, SIGNAL, OWN), (0.0, "Unusable"))),
    ("beyond all numbers in the end", {"slow": replace(RAN["slow"], output=np.where(np.arange(len(RAN["slow"].output))[:, None] > 300, np.inf, RAN["slow"].output))}, {SIGNAL: (0.0, SIGNAL)}),
    ("beyond all numbers", {"noise": replace(RAN["noise"], output=RAN["noise"].output * np.inf)}, {NOISE: (0.0, "Unusable")}),
    ("None at first", {name: FilterRun(np.vstack([[[np.nan] * 3], run.output[1:]]), "None", None) for name, run in RAN.items()}, {START: (0.0, "first-output-missing")}),
    ("shared, and handed out", {name: replace(RAN[name], output=RAN[name].output + 1) for name in ("beside", "spoilt_output")}, {OWN: (0.0, "shared-state aliased-output")}),
    ("spoilt output", {"spoilt_output": replace(RAN["beside"], output=RAN["beside"].output + 1)}, {OWN: (0.5, "aliased-output")}),
    ("one array for all", {"noise": replace(RAN["noise"], output_changed=True)}, {OWN: (0.5, "aliased-output")}),
    ("spoilt input", {"spoilt_input": replace(RAN["beside"], output=RAN["beside"].output + 1)}, {OWN: (0.5, "aliased-input")}),
    ("writes into what it is given", {"initial": replace(RAN["initial"], input_changed=True)}, {OWN: (0.5, "mutates-input"), OF: (0.75, "mutates-input")}),
]  # fmt: skip


@pytest.mark.parametrize(("changed", "marked"), [row[1:] for row in ANSWERS], ids=[row[0] for row in ANSWERS])
def test_what_an_answer_is_charged(changed: Mapping[str, FilterRun], marked: Mapping[str, tuple[float, str]]) -> None:
    assert judged(facts_of(changed)) == marked


def test_outputs_that_are_no_numbers_do_not_show_that_a_filter_has_no_memory() -> None:
    past = RAN["another_past"]
    assert facts_of({"another_past": replace(past, output=past.output * np.nan)}).own.remembers
    assert not facts_of(runs_of(memoryless(lambda x: x))).own.remembers


class Stumbling:
    """A submission whose second filter raises in the process of the first one."""

    def filter(self, cases: Sequence[FilterCase], called: str) -> list[FilterRun]:
        return [next(iter(RAN.values())), *(FilterRun(None, None, FAULT) for _ in cases[1:])]

    def filter_alone(self, case: FilterCase) -> FilterRun:
        return FilterRun(sheet(case.alpha or 0.1, case.signal, case.initial), None, None)


def test_filters_that_stumble_are_asked_again_each_in_its_own_process() -> None:
    assert judged(measure(Stumbling(), truth())) == {OWN: (0.0, "shared-state")}  # type: ignore[arg-type] # asked for filters alone


def test_numbers_of_chance_are_no_memory() -> None:
    rng = np.random.default_rng(1)
    found = judged(facts_of(runs_of(memoryless(lambda x: x + rng.normal(0, 0.01, x.shape)))))
    assert found == {**no_filter("does-not-filter"), OWN: (1.0, "not charged")}


def _charged() -> dict[str, Charged]:
    """Every charge of these filters and answers, by check and name."""
    known = {name: facts_of(runs_of(answer)) for name, answer, _ in FILTERS}
    known |= {name: facts_of(changed) for name, changed, _ in ANSWERS} | {"stumbles": facts_of({}, stumbles=FAULT)}
    judged = (
        (check, name, charge) for name, each in known.items() for check, charge in JUDGE.judge(each, ROWS).items()
    )
    return {f"{check}: {name}": Charged(c) for check, name, c in judged if isinstance(c, Charge) and c.costs}


def all_words() -> dict[str, dict[str, str]]:
    return {name: words(charged) for name, charged in _charged().items()}


def test_every_charge_is_told_in_the_pinned_words_and_of_hidden_data_without_numbers() -> None:
    for name, charged in _charged().items():
        told, hidden = words(charged), hidden_feedback.feedback_on(charged, ROWS)
        if told != (before := pinned().get(name)):
            differs(WORDS, f"{name}: expected {before}, got {told}")
        assert "said" in told or told["expected"] != told["got"], name
        assert hidden.hint.startswith(told["hint"]), name
        assert not any(digit in hidden.got.partition(" by ")[0] for digit in "23456789"), hidden.got


def weighted(of_measurement: Callable[[float], float], of_output: Callable[[float], float]) -> type:
    """A filter with these weights, from alpha; it starts from the first measurement, or from the initial value."""

    class LowPassFilter:
        def __init__(self, alpha: float = 0.1, initial_value: Any = None) -> None:
            self.alpha, self.value = alpha, None if initial_value is None else np.array(initial_value, float)

        def update(self, measurement: Any) -> Any:
            x = np.array(measurement, float)
            before = x if self.value is None else self.value
            self.value = of_measurement(self.alpha) * x + of_output(self.alpha) * before
            return self.value.copy()

    return LowPassFilter


def test_the_worker_is_asked_every_case_once_and_sound_code_is_charged_nothing() -> None:
    student = FakeStudent(LowPassFilter=weighted(lambda alpha: alpha, lambda alpha: 1 - alpha))
    assert judged(measure(student, truth())) == {}
    assert [len(run.output) for run in student.stored_answer("filter")[:4]] == [400, 400, 400, 100]
    checks.check_follows_recursion(student, truth())
