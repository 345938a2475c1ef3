"""Sound submissions of markers from outside that something of ours stumbled over."""

from __future__ import annotations

from tests.corpus.pieces import tidy
from tests.corpus.writing import Files


def _hints_for_checkers_alone() -> Files:
    """Names that type hints alone need, imported where nothing runs."""
    files = tidy()
    head = (
        "from __future__ import annotations\n\nfrom typing import TYPE_CHECKING\n\n"
        "if TYPE_CHECKING:\n    from collections.abc import Sequence\n\n    from matplotlib.axes import Axes\n\n"
    )
    text = files["imu_reader.py"].replace("def read_sensor(model, data, sensor_id):", "def read_sensor(model, data, sensor_id) -> Sequence[float]:")
    text = text.replace("def plot_imu_data(imu_data):\n", "def plot_imu_data(imu_data):\n    top: Axes\n    bottom: Axes\n")
    return files | {"imu_reader.py": head + text}


OUTSIDE: dict[str, Files] = {"hints_for_checkers_alone": _hints_for_checkers_alone()}
