"""What the grader supplies or reads as another name costs nothing, in any layout, and is noted. The corpus has the rest."""

from __future__ import annotations

import pytest

from tests.corpus.pieces import verbatim
from tests.corpus.writing import Files, notebook
from tests.recordings import Marking
from tests.single_faults import changed, lost_by, marked

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"
MISSPELLED = (
    ("LowPassFilter", "LowpassFilter"),
    ("NoisyIMU", "NoisyImu"),
    ("get_imu_readings", "get_imu_reading"),
    ("simulate_and_collect", "simulateAndCollect"),
)
BORROWED_ON_PURPOSE = {
    "by text": 'exec("import numpy as np")\n',
    "or nothing": "try:\n    import numpy as np\nexcept ImportError:\n    np = None\n",
}
SHEET = "\n\n".join(
    "\n".join(line for line in str(verbatim()[name]).splitlines() if not line.startswith("from "))
    for name in (READER, NOISY, FILTER)
)


def test_what_was_supplied_and_what_was_misspelled_is_noted(player: Marking) -> None:
    misspelled: Files = {path: str(text).replace("LowPassFilter", "LowpassFilter") for path, text in verbatim().items()}
    assert marked(player, changed(misspelled, READER, {"import numpy as np\n": ""})).notes == (
        "imu_reader.py uses np without an import; the grader supplied it",
        "filters.py defines LowpassFilter; the grader used it as LowPassFilter",
    )


@pytest.mark.parametrize("line", BORROWED_ON_PURPOSE.values(), ids=BORROWED_ON_PURPOSE)
def test_a_name_that_comes_by_another_way_is_not_forgotten(line: str, player: Marking) -> None:
    result = marked(player, changed(verbatim(), READER, {"import numpy as np\n": line}))
    assert (result.score, result.notes) == (100.0, ())


@pytest.mark.parametrize(("name", "own"), MISSPELLED)
def test_a_misspelled_name_counts_in_one_file_and_in_a_notebook(name: str, own: str, player: Marking) -> None:
    """What is asked for is at home there, as the files of the sheet were not handed in."""
    code = SHEET.replace(name, own)
    layouts: tuple[Files, ...] = ({"lab.py": code}, {"lab.ipynb": notebook(code)})
    assert [lost_by(marked(player, files)) for files in layouts] == [{}, {}]
