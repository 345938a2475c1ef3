"""What other tests play from tapes is what a box answers."""

from __future__ import annotations

import pytest

from grader.engine.marking import Marker
from grader.engine.results import to_dict
from tests.corpus.module_level import Edit
from tests.made_up import without_durations
from tests.tapes import Marking
from tests.test_module_level import QUICK, marked


@pytest.mark.parametrize("edit", QUICK[::16], ids=lambda edit: edit.name)
def test_the_verdict_from_the_tape_is_that_of_the_box(edit: Edit, marker: Marker, player: Marking) -> None:
    played, boxed = (to_dict(marked(each, edit, "three-files")) for each in (player, marker))
    assert without_durations(played) == without_durations(boxed)
