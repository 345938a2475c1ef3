"""The comparison picture beside a filter file that does not parse: it counts where the code that draws it parses and runs."""

from __future__ import annotations

import pytest

from tests.corpus.pieces import edit, tidy, verbatim
from tests.recordings import Marking
from tests.single_faults import marked

METHOD = "def update(self, measurement):"


def points(player: Marking, files: dict[str, str]) -> tuple[float, float]:
    result = marked(player, files)
    assert not any("was stopped" in note for note in result.notes), result.notes
    found = {criterion.id: criterion.points for criterion in result.criteria}
    return found["visualization"], found["filtering"]


@pytest.mark.parametrize(
    ("files", "old", "new"),
    [
        (tidy(), METHOD, METHOD.removesuffix(":")),
        (tidy(), "class LowPassFilter:", "class LowPassFilter"),
        (tidy(), METHOD, f"{METHOD}\n        x = (1"),
        (tidy(), METHOD, f"{METHOD}\n        x = '"),
        (tidy(), METHOD, f"{METHOD}\n      pass\n   pass"),
        (verbatim(), METHOD, METHOD.removesuffix(":")),
        (verbatim(), METHOD, f"{METHOD}\n        x = (1"),
    ],
    ids=["colon of a method", "colon of a class", "bracket", "quote", "indentation", "colon on the sheet", "bracket on the sheet"],
)  # fmt: skip
def test_a_filter_that_does_not_parse_keeps_the_comparison_that_its_file_draws(
    files: dict[str, str], old: str, new: str, player: Marking
) -> None:
    assert points(player, edit(files, "filters.py", (old, new))) == (20, 0)


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
    assert points(player, tidy() | {"filters.py": source}) == (16, 0)
