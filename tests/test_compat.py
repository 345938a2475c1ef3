"""What runs on the student's own desk counts: other releases, TeX, a folder that was made there once."""

from __future__ import annotations

import pytest

from tests.corpus.pieces import edit, verbatim
from tests.corpus.writing import Files
from tests.recordings import Marking
from tests.single_faults import marked

READER, FILTER = "imu_reader.py", "filters.py"
PLOT, SAVE, RECORDER = "def plot_imu_data(imu_data):", "    plt.savefig(", "times = np.zeros(n_steps)"
OLD_NAMES = """
import numpy as np
from numpy import NaN
values = np.array([1, np.infty, -np.PINF, np.NINF, NaN], dtype=np.float)
assert np.sometrue(values) and not np.alltrue([0, 1])
assert (np.trapz([1, 1]), np.product([2, 3]), np.round_(1.23, 1), np.int(3.5)) == (1, 6, 1.2, 3)
assert np.in1d([[1], [2]], [1]).tolist() == [True, False] and np.cumproduct([2, 3])[1] == 6
assert np.asfarray([1]).dtype == np.float_ and np.row_stack([[1], [2]]).shape == np.mat("1; 2").shape
"""


def _with(name: str, old: str, new: str) -> Files:
    return edit(verbatim(), name, (old, new))


MANAGER = "plt.get_current_fig_manager()"
ELSEWHERE = {
    "a type of numpy 1 in the recorder": (_with(READER, RECORDER, "times = np.zeros(n_steps, dtype=np.float_)"), "data_collection"),
    "a number of numpy 1 in the filter": (_with(FILTER, "self.alpha = alpha", "self.alpha = alpha\n        self.worst = -np.Inf"), "filtering"),
    "old names in the recorder": (
        _with(READER, "    dt = model.opt.timestep\n", "".join(f"    {line}\n" for line in OLD_NAMES.split("\n")) + "    dt = model.opt.timestep\n"),
        "data_collection",
    ),
    "a style that has another name now": (_with(READER, PLOT, f"{PLOT}\n    plt.style.use('seaborn-darkgrid')"), "visualization"),
    "the old way to a colour map": (
        _with(READER, PLOT, f"{PLOT}\n    from matplotlib import cm\n    cm.get_cmap('viridis', 3)(cm.get_cmap()(0.5)[0])"),
        "visualization",
    ),
    "the old way to a window's title": (_with(READER, SAVE, f"    plt.gcf().canvas.set_window_title('IMU')\n{SAVE}"), "visualization"),
    "texts set by TeX": (_with(READER, PLOT, f"{PLOT}\n    plt.rc('text', usetex=True)"), "visualization"),
    "a picture in a folder of the desk": (_with(READER, "imu_data.png", "figures/lab 4/imu_data.png"), "visualization"),
    "a window that fills the screen": (_with(READER, PLOT, f"{PLOT}\n    {MANAGER}.window.state('zoomed')\n    {MANAGER}.resize(*{MANAGER}.window.maxsize())"), "visualization"),
    "a window somewhere": (_with(READER, PLOT, f"{PLOT}\n    {MANAGER}.window.setGeometry(1, 2, 3, 4)\n    {MANAGER}.frame.Maximize(True)"), "visualization"),
    "a terminal, and Windows": (
        _with(
            READER, "    # Reset simulation\n",
            "    import os, msvcrt, winsound\n    print('-' * os.get_terminal_size().columns)\n    assert not msvcrt.kbhit()\n    winsound.Beep(440, 10)\n",
        ),
        "data_collection",
    ),
    "numbers in a folder of the desk": (_with(READER, SAVE, f"    np.savez('data/run.npz', **imu_data)\n{SAVE}"), "visualization"),
}  # fmt: skip


@pytest.mark.parametrize("name", ELSEWHERE)
def test_what_runs_there_loses_nothing_here(name: str, player: Marking) -> None:
    files, part = ELSEWHERE[name]
    (criterion,) = marked(player, files, part).criteria
    assert {check.id: check.message for check in criterion.checks if check.points != check.max_points} == {}


def test_what_this_release_means_by_a_name_stays(player: Marking) -> None:
    kept = "import numpy as np\nassert np.bool is np.bool_ and 'seaborn-v0_8' in plt.style.available\n"
    files = _with(READER, PLOT, f"{kept}\n{PLOT}")
    result = marked(player, files, "visualization")
    assert result.notes == ()
