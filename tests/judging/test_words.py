"""What is pinned is asked for: no words of a case that there is not."""

from __future__ import annotations

import pytest

from tests.judging import test_filtering
from tests.judging.fake_students import all_cases, pinned


@pytest.mark.quick
def test_the_words_are_those_of_cases_that_each_have_a_name_of_their_own() -> None:
    names = [case.id for case in all_cases()]
    assert len(set(names)) == len(names)
    assert set(pinned()) <= {*names, *test_filtering.all_words()}
