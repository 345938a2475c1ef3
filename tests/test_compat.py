"""What runs on the student's own desk counts: other releases, TeX, a folder that was made there once, a break point."""

from __future__ import annotations

import pytest

from grader.engine.breakpoints import breakpoints
from tests.corpus.pieces import edit, tidy, verbatim
from tests.recordings import Marking
from tests.single_faults import marked

READER = "imu_reader.py"
PLOT, SAVE, STEP = "def plot_imu_data(imu_data):", "    plt.savefig(", "    dt = model.opt.timestep\n"
OLD_NUMPY = """
    import numpy as np
    from numpy import NaN
    values = np.array([1, np.infty, np.Inf, -np.PINF, np.NINF, NaN], dtype=np.float)
    assert np.sometrue(values) and not np.alltrue([0, 1])
    assert (np.trapz([1, 1]), np.product([2, 3]), np.round_(1.23, 1), np.int(3.5)) == (1, 6, 1.2, 3)
    assert np.in1d([[1], [2]], [1]).tolist() == [True, False] and np.cumproduct([2, 3])[1] == 6
    assert np.asfarray([1]).dtype == np.float_ and np.row_stack([[1], [2]]).shape == np.mat("1; 2").shape
    assert (np.trapezoid([1, 1]), np.concat([[1], [2]])[1], np.atan2(0, 1), np.math.sqrt(4)) == (1, 2, 0, 2)
    assert issubclass(np.VisibleDeprecationWarning, Warning) and isinstance("x", np.str) and np.bool(1)
"""
OLD_SCIPY = """
    from scipy.integrate import cumtrapz, simps, trapz
    from scipy import signal
    assert (trapz([1, 1]), simps([1, 1, 1]), cumtrapz([1, 1])[0]) == (1, 2, 1)
    assert len(signal.hann(5)) == len(signal.gaussian(5, 1)) == 5
"""
OTHER_SYSTEM = """
    import os, msvcrt, winsound
    print('-' * os.get_terminal_size().columns)
    assert not msvcrt.kbhit()
    winsound.Beep(440, 10)
"""
OLD_MATPLOTLIB = """
    from matplotlib import cm
    cm.get_cmap('viridis', 3)(cm.get_cmap()(0.5)[0])
    plt.style.use('seaborn-darkgrid')
    plt.rc('text', usetex=True)
"""
OLD_CANVAS = """
    old, axes = plt.subplots()
    axes.plot([0, 1], label='old')
    assert len(axes.legend().legendHandles) == 1
    old.canvas.draw()
    assert len(old.canvas.tostring_rgb()) == 3 * old.canvas.get_width_height()[0] * old.canvas.get_width_height()[1]
    plt.close(old)
"""
WINDOW = """
    plt.gcf().canvas.set_window_title('IMU')
    manager = plt.get_current_fig_manager()
    manager.window.state('zoomed')
    manager.resize(*manager.window.maxsize())
    manager.window.setGeometry(1, 2, 3, 4)
    manager.frame.Maximize(True)
"""
FOLDERS = ("imu_data.png", "figures/lab 4/imu_data.png"), (SAVE, f"    np.savez('data/run.npz', **imu_data)\n{SAVE}")


@pytest.mark.parametrize(
    ("edits", "part"),
    [
        pytest.param([(STEP, OLD_NUMPY + STEP)], "data_collection", id="old names of numpy"),
        pytest.param([(STEP, OLD_SCIPY + STEP)], "data_collection", id="old names of scipy"),
        pytest.param([(STEP, OTHER_SYSTEM + STEP)], "data_collection", id="a terminal, and Windows"),
        pytest.param([(PLOT, PLOT + OLD_MATPLOTLIB)], "visualization", id="old names of matplotlib, and TeX"),
        pytest.param([(PLOT, PLOT + OLD_CANVAS)], "visualization", id="old names of matplotlib's canvas and legend"),
        pytest.param([(SAVE, WINDOW + SAVE)], "visualization", id="a window with a title, a size and a place"),
        pytest.param(FOLDERS, "visualization", id="a picture and numbers in folders of the desk"),
    ],
)
def test_what_runs_there_loses_nothing_here(edits: list[tuple[str, str]], part: str, player: Marking) -> None:
    (criterion,) = marked(player, edit(verbatim(), READER, *edits), part).criteria
    assert {check.id: check.message for check in criterion.checks if check.points != check.max_points} == {}


def test_what_this_release_means_by_a_name_stays(player: Marking) -> None:
    kept = "import numpy as np\nassert np.bool is np.bool_ and 'seaborn-v0_8' in plt.style.available\n"
    files = edit(verbatim(), READER, (PLOT, f"{kept}\n{PLOT}"))
    assert marked(player, files, "visualization").notes == ()


# --- break points ---


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("x = 1\nbreakpoint()\n", [("breakpoint", 2)]),
        ("import pdb; pdb.set_trace()\n", [("pdb.set_trace", 1)]),
        ("from ipdb import set_trace\nset_trace ( )\n", [("set_trace", 2)]),
        ("# breakpoint()\n'''\nbreakpoint()\n'''\nprint(\"breakpoint()\")\n", []),
        ("my_breakpoint()\nself.breakpoints()\n", []),
        ("s = 'never closed\nbreakpoint()\n", [("breakpoint", 2)]),
        ("\udcff".encode("utf-8", "surrogateescape").decode("latin-1") + "\nbreakpoint()", [("breakpoint", 2)]),
    ],
)
def test_calls_are_found_where_they_stand_and_not_in_comments_or_strings(
    source: str, found: list[tuple[str, int]]
) -> None:
    assert list(breakpoints(source.encode())) == found


def test_a_flood_is_looked_at_in_no_time() -> None:
    assert list(breakpoints(b"'" * 1_000_000)) == []
    assert list(breakpoints(b"a." * 200_000)) == []


def test_a_check_that_passes_over_one_says_so_and_takes_nothing_for_it(player: Marking) -> None:
    head = "def update(self, measurement):"
    files = edit({"filters.py": tidy()["filters.py"]}, "filters.py", (head, f"{head}\n        breakpoint()"))
    result = marked(player, files, "filtering")
    line = str(files["filters.py"]).splitlines().index("        breakpoint()") + 1
    assert result.score == 20.0
    assert result.notes[-1] == (
        f"filters.py, line {line}: breakpoint() was skipped: nobody can type during grading. A program from `imugrade repro` stops there"
    )
