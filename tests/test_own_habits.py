"""Other parameters are one fault, whatever would fail for them; a forgotten import and a misspelled name cost nothing."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from tests.corpus.pieces import tidy, verbatim
from tests.corpus.writing import Files
from tests.recordings import Marking
from tests.single_faults import Changes, SingleFault, assert_loses, changed, lost_by, marked

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"


def _renamed(files: Files, old: str, new: str) -> Files:
    return {path: text.replace(old, new) if path.endswith(".py") else text for path, text in files.items()}


NOISE, READ, RECURSION = "noise_model.noise_size", "sensor_access.returns_two_vectors", "filtering.follows_recursion"
RECORD, PLOT = "data_collection.returns_named_arrays", "visualization.saves_image"

OTHER = ("other-parameters",)

FILTER_IN_TIME = {
    "alpha=0.1, initial_value=None": "cutoff_hz, dt, initial_value=None",
    "self.alpha = alpha": "self.alpha = dt / (1 / (2 * np.pi * cutoff_hz) + dt)",
}
PARAMETERS: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
        "standard deviations": (NOISY, {"accel_noise_std": "acc_std", "gyro_noise_std": "gyr_std"}, {NOISE: 3.0}, OTHER),
        "biases": (NOISY, {"accel_bias": "b_acc", "gyro_bias": "b_gyro"}, {NOISE: 3.0}, OTHER),
        "no ids": (
        NOISY,
        {
            "model, data, accel_id, gyro_id,": "model, data,",
            "NoisyIMU(model, data, accel_id, gyro_id)": "NoisyIMU(model, data)",
            "= accel_id": "= model.sensor('torso_accelerometer').id",
            "= gyro_id": "= model.sensor('torso_gyroscope').id",
        },
        {NOISE: 3.0},
        OTHER,
    ),
        "smoothing": (
        FILTER,
        {
            "alpha=0.1, initial_value=None": "smoothing=0.1, start=None",
            "self.alpha = alpha": "self.alpha = smoothing",
            "= initial_value": "= start",
            "LowPassFilter(alpha=0.1)": "LowPassFilter(smoothing=0.1)",
        },
        {RECURSION: 3.0},
        OTHER,
    ),
        "a cutoff": (FILTER, FILTER_IN_TIME | {"LowPassFilter(alpha=0.1)": "LowPassFilter(10.0, 0.002)"}, {RECURSION: 3.0}, OTHER),
        "a cutoff with a default": (
        FILTER,
        FILTER_IN_TIME | {"cutoff_hz, dt,": "cutoff_hz=10.0, dt=0.002,", "LowPassFilter(alpha=0.1)": "LowPassFilter()"},
        {RECURSION: 3.0},
        OTHER,
    ),
        "a sampling rate": (
        FILTER,
        FILTER_IN_TIME
        | {"cutoff_hz, dt,": "fc, sampling_freq,", "dt / (1 / (2 * np.pi * cutoff_hz) + dt)": "1 / (1 + sampling_freq / (2 * np.pi * fc))"}
        | {"LowPassFilter(alpha=0.1)": "LowPassFilter(fc=10.0, sampling_freq=500)"},
        {RECURSION: 3.0},
        OTHER,
    ),
        "an alpha, or a cutoff": (
        FILTER,
        {
            "alpha=0.1, initial_value=None": "alpha=0.1, initial_value=None, cutoff_hz=0.0, dt=0.002",
            "self.alpha = alpha": "self.alpha = dt / (1 / (2 * np.pi * cutoff_hz) + dt) if cutoff_hz else alpha",
        },
        {},
        (),
    ),
        "standard deviations of biases": (
        NOISY,
        {
            "accel_bias=None, gyro_bias=None": "accel_bias_std=0.1, gyro_bias_std=0.01",
            "accel_bias if accel_bias is not None else np.random.normal(0, 0.1, 3)": "np.random.normal(0, accel_bias_std, 3)",
            "gyro_bias if gyro_bias is not None else np.random.normal(0, 0.01, 3)": "np.random.normal(0, gyro_bias_std, 3)",
        },
        {"noise_model.given_bias": 4.0},
        ("bias-argument-ignored",),
    ),
        "the time between measurements, by default": (
        FILTER, {"(self, measurement)": "(self, measurement, dt=0.002)"}, {}, (),
    ),
        "the duration first": (
        READER,
        {
            "(model, data, duration_seconds=5.0)": "(duration_seconds, model, data)",
            "(model, data, duration_seconds=3.0)": "(3.0, model, data)",
        },
        {RECORD: 3.0},
        OTHER,
    ),
        "the number of steps": (
        READER,
        {
            "(model, data, duration_seconds=5.0)": "(model, data, n_steps)",
            "    n_steps = int(duration_seconds / dt)\n": "",
            "(model, data, duration_seconds=3.0)": "(model, data, 1500)",
        },
        {RECORD: 3.0},
        OTHER,
    ),
        "a file name": (
        READER,
        {
            "plot_imu_data(imu_data):": "plot_imu_data(imu_data, filename):",
            "\nplot_imu_data(imu_data)": "\nplot_imu_data(imu_data, 'imu_data.png')",
            "savefig('imu_data.png'": "savefig(filename",
        },
        {PLOT: 2.0},
        OTHER,
    ),
        "the series one by one": (
        READER,
        {
            "plot_imu_data(imu_data):": "plot_imu_data(t, accel, gyro):\n"
            "    imu_data = {'time': t, 'acceleration': accel, 'angular_velocity': gyro}",
            "\nplot_imu_data(imu_data)": "\nplot_imu_data(*imu_data.values())",
        },
        {PLOT: 2.0},
        OTHER,
    ),
    }  # fmt: skip
FORGOTTEN: dict[str, tuple[str, str, dict[str, float]]] = {
    "numpy": (READER, "import numpy as np\n", {}),
    "mujoco": (READER, "import mujoco\n", {}),
    "pyplot": (READER, "import matplotlib.pyplot as plt\n", {}),
    "the reader and all that comes with it": (NOISY, "from imu_reader import *\n", {"visualization.comparison_plot": 4.0}),
    "the noise model and all that comes with it": (FILTER, "from noisy_imu import *\n", {"visualization.comparison_plot": 4.0}),
}  # fmt: skip
MISSPELLED = (
    ("LowPassFilter", "LowpassFilter"),
    ("NoisyIMU", "NoisyImu"),
    ("get_imu_readings", "get_imu_reading"),
    ("simulate_and_collect", "simulateAndCollect"),
)
_STORED = (
    "accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)",
    "accelerations[i] = accel",
    "angular_velocities[i] = gyro",
)
EDITED: dict[str, tuple[str, Changes, dict[str, float], tuple[str, ...]]] = {
        "one sensor in both places": (
        NOISY, {"return accel_noisy, gyro_noisy": "return gyro_noisy, gyro_noisy"}, {"noise_model.given_bias": 4.0}, (),
    ),
        "dates along the axis": (
        READER,
        {
            "import numpy as np\n": "import numpy as np\nfrom datetime import datetime, timedelta\n",
            "imu_data['time']": "[datetime(2026, 5, 1) + timedelta(seconds=float(t)) for t in imu_data['time']]",
        },
        {},
        (),
    ),
        "a duration along the axis": (
        READER, {"imu_data['time']": "(1e6 * imu_data['time']).astype('timedelta64[us]')", "Time (s)": "Time (us)"}, {}, (),
    ),
        "a sandbox plot and bars with names beside the curves": (
        READER,
        {
            "plt.savefig('imu_data.png', dpi=150)": "boxes, bars = fig.add_axes([0.8, 0.7, 0.1, 0.1]), fig.add_axes([0.8, 0.2, 0.1, 0.1])\n"
            "    boxes.boxplot([[1, 2, 3], [2, 3, 4]])\n"
            "    bars.bar(['a', 'b'], [1, 2])\n"
            "    bars.plot(['a', 'b'], [1, 2])\n"
            "    plt.savefig('imu_data.png', dpi=150)"
        },
        {},
        (),
    ),
        "a filter of the program's own measurement": (
        FILTER, {"measurement.copy()": "noisy_accel.copy()", "self.alpha * measurement": "self.alpha * noisy_accel"},
        {RECURSION: 3.0}, ("global-for-parameter",),
    ),
        "rows that are stored behind the loop": (
        READER, {f"        {line}": f"    {line}" for line in _STORED}, {"data_collection.matches_truth": 6.0}, ("only-last-row",),
    ),
    }  # fmt: skip


LEGEND, CURVES, LABELS = (
    "visualization.legend_names_curves",
    "visualization.curves_match_data",
    "visualization.axis_labels_with_units",
)
READING = {
    "both readings": ("accel, gyro", "*get_imu_readings(model, data, accel_id, gyro_id)"),
    "the ids": ("accel_id, gyro_id", "accel_id, gyro_id"),
}
"""What a `read` takes, and what the program gives it."""


def _slips() -> Iterator[SingleFault]:
    for name, (path, changes, lost, named) in (PARAMETERS | EDITED).items():
        yield SingleFault(name, changed(verbatim(), path, changes), lost, named)
    for name, (path, line, lost) in FORGOTTEN.items():
        yield SingleFault(f"forgotten: {name}", changed(verbatim(), path, {line: ""}), lost)
    yield SingleFault("forgotten: a partner", changed(tidy(), FILTER, {"from noisy_imu import NoisyIMU\n": ""}), {})
    for name, own in MISSPELLED:
        yield SingleFault(f"misspelled: {own}", _renamed(verbatim(), name, own), {})
    methods = changed(verbatim(), FILTER, {"def update": "def Up_date", ".update(": ".Up_date("})
    yield SingleFault("misspelled: Up_date", methods, {})
    for name, (takes, reads) in READING.items():
        own = {"def read(self)": f"def read(self, {takes})", "noisy_imu.read()": f"noisy_imu.read({reads})"}
        files = changed(verbatim(), NOISY, own)
        files = changed(files, FILTER, {"noisy_imu.read()": own["noisy_imu.read()"]})
        yield SingleFault(f"read() is given {name}", files, {NOISE: 3.0}, OTHER)
    flag = {"class LowPassFilter:": "first = True\n\n\nclass LowPassFilter:",
            "        if self.state is None:\n": "        global first\n        if first and self.state is None:\n            first = False\n"}  # fmt: skip
    yield SingleFault(
        "a flag that all filters share",
        changed(tidy(), FILTER, flag),
        {"filtering.instances_independent": 3.0},
        ("shared-state",),
    )
    yield SingleFault(
        "legends of the parts of a figure",
        changed(
            tidy(),
            READER,
            {
                "fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6), sharex=True)": "fig = plt.figure(figsize=(10, 6))\n"
                "    parts = fig.subfigures(2, 1)\n    top, bottom = parts[0].subplots(), parts[1].subplots()",
                '    for ax in (top, bottom):\n        ax.legend(loc="best")': "    for part, ax in zip(parts, (top, bottom)):\n        part.legend()",
                'top.set_title("Torso accelerometer")': 'parts[0].text(0.5, 0.95, "Torso")',
                '    bottom.set_title("Torso gyroscope")\n': "",
                "    fig.tight_layout()\n": "",
            },
        ),
        {},
    )


def _notebook(*cells: str) -> Files:
    told = [
        {"cell_type": "code", "source": cell, "metadata": {}, "outputs": [], "execution_count": None} for cell in cells
    ]
    return {"lab.ipynb": json.dumps({"cells": told, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})}


SHEET = "\n\n".join(
    "\n".join(line for line in str(verbatim()[name]).splitlines() if not line.startswith("from "))
    for name in (READER, NOISY, FILTER)
)


@pytest.mark.parametrize("slip", [*_slips()], ids=lambda slip: slip.name)
def test_it_costs_what_it_is_and_nothing_else(slip: SingleFault, player: Marking) -> None:
    assert_loses(slip, player)


def test_what_was_supplied_is_noted(player: Marking) -> None:
    notes = marked(player, changed(verbatim(), READER, {"import numpy as np\n": ""})).notes
    assert "imu_reader.py uses np without an import; the grader supplied it" in notes


def test_a_misspelled_name_is_noted(player: Marking) -> None:
    notes = marked(player, _renamed(verbatim(), "LowPassFilter", "LowpassFilter")).notes
    assert "filters.py defines LowpassFilter; the grader used it as LowPassFilter" in notes


BORROWED_ON_PURPOSE = {
    "by text": 'exec("import numpy as np")\n',
    "or nothing": "try:\n    import numpy as np\nexcept ImportError:\n    np = None\n",
}


@pytest.mark.parametrize("line", BORROWED_ON_PURPOSE.values(), ids=BORROWED_ON_PURPOSE)
def test_a_name_that_comes_by_another_way_is_not_forgotten(line: str, player: Marking) -> None:
    result = marked(player, changed(verbatim(), READER, {"import numpy as np\n": line}))
    assert (result.score, result.notes) == (100.0, ())


@pytest.mark.parametrize(("name", "own"), MISSPELLED)
def test_a_misspelled_name_counts_in_one_file_and_in_a_notebook(name: str, own: str, player: Marking) -> None:
    """What is asked for is at home there, as the files of the sheet were not handed in."""
    code = SHEET.replace(name, own)
    assert [lost_by(marked(player, files)) for files in ({"lab.py": code}, _notebook(code))] == [{}, {}]
