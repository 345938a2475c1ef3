"""Tests that a fault costs what it spoils and nothing else, and that the report says where the rest went."""

from __future__ import annotations

import pytest

from grader.engine.results import Result
from tests.corpus.cases import Case, of
from tests.corpus.pieces import COMPARE, PLOT_LOOP, edit, lab, verbatim
from tests.corpus.writing import Files, notebook
from tests.recordings import Marking
from tests.scoreboard import Verdict, breaks, look_at_words, lost
from tests.single_faults import lost_by, marked, thinned

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"
LOAD = """

def load():
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    return model, mujoco.MjData(model)
"""
PLOT_FIRST = "imu_reader.plot_imu_data(imu_reader.simulate_and_collect(*imu_reader.load(), 1.0))\n"
STOPPED_IN_PLOT = {
    "an exception": ('imu_data["time"]', 'imu_data["clock"]'),
    "a loop without an end": ("    t = ", "    while True:\n        pass\n    t = "),
}
PLOTS_FIRST = {
    "under a guard": COMPARE.replace("    compare()\n", f"    import imu_reader\n    {PLOT_FIRST}    compare()\n"),
    "in main": COMPARE.replace("    compare()\n", "    main()\n").replace(
        "if __name__", f"def main():\n    import imu_reader\n    {PLOT_FIRST}    compare()\n\n\nif __name__"
    ),
    "at module level": COMPARE.partition("if __name__")[0] + f"import imu_reader\n{PLOT_FIRST}compare()\n",
}


def test_who_uses_what_is_not_there_is_told_what_is(player: Marking) -> None:
    files = edit(lab(), "noisy_imu.py", ("    def read(self):\n", "    def read(self):\n        tqdm()\n"))
    files["noisy_imu.py"] = "from tqdm_of_mine import tqdm\n" + files["noisy_imu.py"]
    message = marked(player, files, "noise_model").criteria[0].checks[0].message
    assert "ModuleNotFoundError: No module named 'tqdm_of_mine'" in message


@pytest.mark.parametrize("stopped", ["an exception", pytest.param("a loop without an end", marks=pytest.mark.slow)])
@pytest.mark.parametrize("where", PLOTS_FIRST)
def test_a_plot_that_stops_the_script_does_not_cost_what_is_drawn_later(
    player: Marking, where: str, stopped: str
) -> None:
    before, after = STOPPED_IN_PLOT[stopped]
    assert (PLOT_LOOP.count(before), PLOTS_FIRST[where].count(PLOT_FIRST)) == (1, 1)
    files = lab(plot=PLOT_LOOP.replace(before, after), compare=PLOTS_FIRST[where])
    files["imu_reader.py"] += LOAD
    (criterion,) = marked(player, files, "visualization").criteria
    assert [check.id for check in criterion.checks if check.points] == ["visualization.comparison_plot"]


@pytest.mark.parametrize(
    ("slip", "why"),
    [("print(raw_data)", "NameError"), ("raise SystemExit", "SystemExit"), ("while True: pass", "it had not ended")],
)
def test_a_statement_that_fails_below_a_main_guard_costs_nothing(player: Marking, slip: str, why: str) -> None:
    files = lab(compare=COMPARE.replace("    compare()\n", f"    {slip}\n    compare()\n"))
    result = marked(player, files)
    (note,) = [note for note in result.notes if "went on" in note]
    line = files["filters.py"].split("\n").index(f"    {slip}") + 1
    assert result.score == 100.0
    assert note.startswith(f"filters.py, line {line} was stopped when the file was run: {why}")


def test_of_a_name_that_is_defined_twice_a_note_says_which_one_was_graded(player: Marking) -> None:
    files = lab()
    again = files["filters.py"] + "\n\nclass LowPassFilter(LowPassFilter):\n    pass\n"
    for given, told in (
        (
            {**files, "Copy of filters.py": files["filters.py"]},
            "Copy of filters.py and filters.py; the one in filters.py",
        ),
        ({**files, "filters.py": again}, "filters.py; the last one in filters.py"),
        ({**files, "report.txt": files["filters.py"]}, ""),
    ):
        said = [note for note in marked(player, given, "filtering").notes if "is defined" in note]
        assert said == ([f"LowPassFilter is defined 2 times, in {told} was graded"] if told else [])


# --- what the grader supplies or reads as another name costs nothing, in any layout, and is noted; the corpus has the rest ---

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
    misspelled = {path: str(text).replace("LowPassFilter", "LowpassFilter") for path, text in verbatim().items()}
    assert marked(player, edit(misspelled, READER, ("import numpy as np\n", ""))).notes == (
        "imu_reader.py uses np without an import; the grader supplied it",
        "filters.py defines LowpassFilter; the grader used it as LowPassFilter",
    )


@pytest.mark.parametrize("line", BORROWED_ON_PURPOSE.values(), ids=BORROWED_ON_PURPOSE)
def test_a_name_that_comes_by_another_way_is_not_forgotten(line: str, player: Marking) -> None:
    result = marked(player, edit(verbatim(), READER, ("import numpy as np\n", line)))
    assert (result.score, result.notes) == (100.0, ())


@pytest.mark.parametrize(("name", "own"), MISSPELLED)
def test_a_misspelled_name_counts_in_one_file_and_in_a_notebook(name: str, own: str, player: Marking) -> None:
    """What is asked for is at home there, as the files of the sheet were not handed in."""
    code = SHEET.replace(name, own)
    layouts: tuple[Files, ...] = ({"lab.py": code}, {"lab.ipynb": notebook(code)})
    assert [lost_by(marked(player, files)) for files in layouts] == [{}, {}]


# --- work that no list foresaw loses what a careful marker said before it was judged, each fault once, with a true name or none ---

_EVERY = 6
"""Of so many plots one is drawn."""
_EVERYWHERE = {
    "class-with-the-id-as-address", "class-in-the-other-order", "class-that-clips", "one-key-misspelled",
    "keys-in-the-plural", "three-long-rows", "append-without-an-axis", "a-dataclass-in-place-of-a-dictionary",
}  # fmt: skip
"""Faults that reach into other criteria: into the plot by the recording's form, into all by a shared class."""


def _chosen(*parts: str) -> list[Case]:
    every = [case for part in parts for case in of(part)]
    plots = [case for case in every if case.criterion == "visualization"]
    return [case for case in every if case.criterion != "visualization"] + plots[::_EVERY]


def _judged(player: Marking, sample: Case) -> Result:
    return marked(player, sample.files, None if sample.name in _EVERYWHERE else sample.criterion)


@pytest.mark.slow
@pytest.mark.parametrize("sample", thinned(_chosen("unforeseen sound"), 4))
def test_sound_work_in_a_style_of_its_own_loses_nothing(sample: Case, player: Marking) -> None:
    result = _judged(player, sample)
    assert [(check.id, check.message) for check in lost(result)] == []
    assert result.misconceptions == ()


@pytest.mark.slow
@pytest.mark.parametrize("sample", thinned(_chosen("unforeseen", "habits"), 4))
def test_a_fault_loses_what_the_marker_said_and_is_told_why(sample: Case, player: Marking) -> None:
    result = _judged(player, sample)
    found = lost_by(result)
    names, right = set(result.misconceptions), {*sample.names, *sample.also, sample.fault} - {""}
    said = Verdict(sample, result=result)
    look_at_words(said)
    assert said.troubles == []
    assert found
    assert names <= right
    assert sample.fault in ("", *names)
    assert names or not sample.names or sample.part == "habits"  # a habit may have a name
    listed = {check for name in names for check in breaks(name)}  # what a fault breaks is decided in its row
    elsewhere = {id_: points for id_, points in found.items() if id_ not in listed}
    if sample.takes is not None:
        assert {id_: points for id_, points in elsewhere.items() if points > sample.takes.get(id_, 0.0) + 1e-6} == {}
    else:
        assert set(elsewhere) <= set(sample.loses)
        assert sum(elsewhere.values()) <= sample.most + 1e-9
