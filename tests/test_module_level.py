"""The sheet's own layout, everything at module level, with one edit: each costs what a fair marker takes, in every layout."""

from __future__ import annotations

import pytest

from grader.engine.grader import Marker
from grader.intake import Submission
from tests.corpus.cases import Case, of
from tests.corpus.pieces import LAYOUTS, steps
from tests.recordings import Marking
from tests.scoreboard import Verdict, look_at_edit
from tests.single_faults import submission_of

_WAITING = ("loop-", "long-", "waits-", "live-", "thread-", "demo-below-a-guard")
_ALIKE = ("sys-exit-in-", "segfault-in-", "abort-in-")
"""The first are waited for, some seconds each, the others end like `exit-in-`; `tests.scoreboard` has them all."""
QUICK = [
    edit for edit in of("module level") if not edit.name.startswith((*_WAITING, *_ALIKE)) or edit.name == "loop-between"
]
ELSEWHERE = (
    "exit-in-reader", "exit-between", "misspelled-call", "pandas-unused", "pylab-star", "pdb-in-the-noise", "defined-in-an-if",
)  # fmt: skip


def in_layout(edit: Case, layout: str) -> Submission:
    return submission_of({name: text for name, text in LAYOUTS[layout](edit.files).items() if isinstance(text, str)})


@pytest.mark.parametrize(
    ("edit", "layout"),
    [
        *((edit, "three-files") for edit in QUICK),
        *(
            (edit, layout)
            for edit in of("module level")
            if edit.name in ELSEWHERE
            for layout in ("one-file", "notebook")
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_an_edit_costs_what_a_fair_marker_takes(player: Marking, edit: Case, layout: str) -> None:
    verdict = Verdict(edit)
    look_at_edit(verdict, player.mark(in_layout(edit, layout)), edit)
    assert verdict.troubles == []


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import os\nos._exit(0)", "imu_reader.py, line 50 was skipped: it ends the process; the rest of the file was used"),
        ("1 / 0", "imu_reader.py, line 49 was skipped: ZeroDivisionError: division by zero; the rest of the file was used"),
        (
            "import pandas as pd\nmean = pd.Series(accel).mean()",
            "imu_reader.py, line 49 was skipped: ModuleNotFoundError: No module named 'pandas'; so was 1 more statement; "
            "the rest of the file was used",
        ),
    ],
)  # fmt: skip
def test_what_is_stepped_over_is_a_note_with_file_and_line(player: Marking, code: str, said: str) -> None:
    sheet = steps()
    sheet["recorder.py"] = f"{code}\n\n{sheet['recorder.py']}"
    result = player.mark(in_layout(Case("module level", "one", sheet), "three-files"))
    assert (result.score, result.notes) == (100.0, (said,))


def test_who_waits_is_told_for_what(marker: Marker) -> None:
    edit = next(each for each in of("module level") if each.name == "loop-between")
    said: list[str] = []
    marker.mark(in_layout(edit, "three-files"), only="sensor_access", waiting=said.append)
    assert said == ["Waiting for imu_reader.py to be imported: 10 s of CPU time at most."]
