"""The comparison picture beside a filter file that does not parse: it counts where the code that draws it parses and runs."""

from __future__ import annotations

import pytest

from grader.engine.results import Result
from tests.corpus.pieces import edit, tidy, verbatim
from tests.recordings import Marking
from tests.single_faults import marked

NO_COLON = ("def update(self, measurement):", "def update(self, measurement)")


def points(result: Result) -> dict[str, float]:
    return {criterion.id: criterion.points for criterion in result.criteria}


@pytest.mark.parametrize(
    "change",
    [
        NO_COLON,
        ("class LowPassFilter:", "class LowPassFilter"),
        ("measurement):", "measurement):\n        x = (1"),
        ("measurement):", "measurement):\n        x = '"),
        ("measurement):", "measurement):\n      pass\n   pass"),
    ],
    ids=["colon of a method", "colon of a class", "bracket", "quote", "indentation"],
)
@pytest.mark.parametrize("files", [tidy, verbatim], ids=["below a main guard", "as on the sheet"])
def test_a_filter_that_does_not_parse_keeps_the_comparison_that_its_file_draws(
    files: object, change: tuple[str, str], player: Marking
) -> None:
    result = marked(player, edit(files(), "filters.py", change))  # type: ignore[operator]
    assert points(result)["visualization"] == 20
    assert points(result)["filtering"] == 0
    assert not any("was stopped" in note for note in result.notes), result.notes


@pytest.mark.parametrize(
    "source",
    [
        "raise SyntaxError",
        "def broken(:\n    plt.savefig('filtered_imu.png')\n",
        "# savefig\nx = (\n",
        "def broken(:\n    pass\n\nimport matplotlib.pyplot as plt\nplt.savefig('filtered_imu.png')\n",
    ],
    ids=["type name", "in what does not parse", "in a comment", "an empty figure"],
)
def test_a_filter_file_that_draws_no_comparison_loses_it(source: str, player: Marking) -> None:
    files = tidy() | {"filters.py": source}
    result = marked(player, files)
    assert points(result)["visualization"] == 16
    assert points(result)["filtering"] == 0
