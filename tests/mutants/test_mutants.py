"""Mutants in the reduced form that every change must pass; `python -m tests.mutants` is the whole of it."""

from __future__ import annotations

import ast

import pytest

from tests.mutants.grading import FILES, REFERENCE, SHEET, all_mutants, lost, reasons
from tests.mutants.operators import OPERATORS, Mutant, mutants


def _one_of_each_operator() -> list[Mutant]:
    """For each operator a mutant from the middle of those that no reason excuses."""
    unexcused = [mutant for mutant in all_mutants() if not reasons().of(mutant)]
    made = {name: [m for m in unexcused if m.operator == name] for name in OPERATORS}
    return [of_it[len(of_it) // 2] for of_it in made.values() if of_it]


@pytest.mark.parametrize("mutant", _one_of_each_operator(), ids=lambda mutant: mutant.operator)
def test_a_mutant_loses_points(mutant: Mutant) -> None:
    assert lost(mutant), mutant.key


def test_the_reference_itself_loses_none() -> None:
    source = (REFERENCE / "filters.py").read_text(encoding="utf-8")
    assert lost(Mutant("filters.py", "", "", 0, "", source)) == ()


def test_every_mutant_is_another_program_that_can_be_read() -> None:
    found = all_mutants()
    originals = {file: ast.dump(ast.parse((REFERENCE / file).read_text(encoding="utf-8"))) for file in SHEET}
    assert len(found) > 300
    assert len({mutant.key for mutant in found}) == len(found)
    assert [m.key for m in found if ast.dump(ast.parse(m.source)) == originals[m.file]] == []


def test_every_reason_speaks_of_a_mutant_that_there_is() -> None:
    made = all_mutants(FILES)
    explained = {pattern for mutant in made for pattern in reasons().of(mutant)}
    assert reasons().patterns - explained == set()


def test_docstrings_annotations_imports_and_lists_of_names_are_left_alone() -> None:
    source = '"""Words."""\nimport math\n\n__all__ = ["f"]\n\n\ndef f(x: int = 1) -> int:\n    """More."""\n    return x + 1\n'
    changes = {m.change for m in mutants("f.py", source, frozenset())}
    assert changes == {"1 → 2", "1 → 2 (2)", "x + 1 → x - 1", "return x + 1 → return"}
