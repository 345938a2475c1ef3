"""What is pinned is asked for: no words of a case that there is not."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from tests.judging.made import Case, pinned


def _cases() -> list[Case]:
    names = sorted(path.stem for path in Path(__file__).parent.glob("test_check_*.py"))
    return [case for name in names for case in importlib.import_module(f"tests.judging.{name}").CASES]


@pytest.mark.quick
def test_the_words_are_those_of_cases_that_there_are() -> None:
    assert set(pinned()) <= {case.id for case in _cases()}


@pytest.mark.quick
def test_every_case_has_a_name_of_its_own() -> None:
    names = [case.id for case in _cases()]
    assert len(set(names)) == len(names)
