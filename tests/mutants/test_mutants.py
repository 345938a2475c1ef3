"""Mutants in the reduced form that every change must pass; `python -m tests.mutants` is the whole of it."""

from __future__ import annotations

import pytest

from tests.mutants.grading import FILES, REFERENCE, all_mutants, lost, reasons
from tests.mutants.operators import OPERATORS, Mutant


def _one_of_each_operator() -> list[Mutant]:
    """For each operator a mutant from the middle of those that no reason excuses."""
    unexcused = [mutant for mutant in all_mutants() if not reasons().of(mutant)]
    made = {name: [m for m in unexcused if m.operator == name] for name in OPERATORS}
    return [of_it[len(of_it) // 2] for of_it in made.values() if of_it]


@pytest.mark.parametrize(
    "mutant",
    [
        pytest.param(mutant, marks=[pytest.mark.weekly] if n % 3 else [], id=mutant.operator)
        for n, mutant in enumerate(_one_of_each_operator())
    ],
)
def test_a_mutant_loses_points(mutant: Mutant) -> None:
    assert lost(mutant), mutant.key


def test_the_reference_itself_loses_none() -> None:
    source = (REFERENCE / "filters.py").read_text(encoding="utf-8")
    assert lost(Mutant("filters.py", "", "", 0, "", source)) == ()


def test_every_reason_speaks_of_a_mutant_that_there_is() -> None:
    made = all_mutants(FILES)
    explained = {pattern for mutant in made for pattern in reasons().of(mutant)}
    assert reasons().patterns - explained == set()
