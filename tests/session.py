"""From the kit's starter files to 100: the steps of a student, and what `imugrade check --watch` shows after each save.

`python -m tests.regenerate` records it anew, in `session.txt`.
"""

from __future__ import annotations

import io
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from grader import cli
from grader.commands import checking
from grader.labs.imu.lab import LAB
from tests.corpus.sheet import COLLECT, LOW_PASS, NOISY_IMU, PLOT, READER

RECORD = Path(__file__).with_suffix(".txt")
_COMPARISON = """\
def plot_filtering(raw, filtered):
    plt.plot(raw[:, 2], alpha=0.5, label="Raw Z-acceleration")
    plt.plot(filtered[:, 2], label="Filtered Z-acceleration")
    plt.xlabel("Sample")
    plt.ylabel("Acceleration (m/s²)")
    plt.title("Low-pass filtering of noisy IMU data")
    plt.legend()
    plt.savefig("filtered_imu.png")
"""
_RECORDER = COLLECT.partition("\n\n")[2]
_BY_ID = READER.replace("model.sensor_adr[accel_sensor_id]", "accel_sensor_id").replace(
    "model.sensor_adr[gyro_sensor_id]", "gyro_sensor_id"
)
_FROM_ZERO = LOW_PASS.replace("self.value = initial_value", "self.value = np.zeros(3)")

STEPS: tuple[tuple[str, dict[str, dict[str, str]]], ...] = (
    ("The starter files, untouched", {}),
    ("Step 2, with the ids taken for addresses", {"imu_reader.py": {"def get_imu_readings": _BY_ID}}),
    ("Step 2 mended; Step 3", {
        "imu_reader.py": {"def get_imu_readings": READER, "def simulate_and_collect": _RECORDER}
    }),
    ("Step 4; Step 5", {"imu_reader.py": {"def plot_imu_data": PLOT}, "noisy_imu.py": {"class NoisyIMU": NOISY_IMU}}),
    ("Step 6, with a filter that starts at zero", {
        "filters.py": {"class LowPassFilter": _FROM_ZERO, "def plot_filtering": _COMPARISON}
    }),
    ("Step 6 mended", {"filters.py": {"class LowPassFilter": LOW_PASS}}),
)  # fmt: skip


def replayed() -> str:
    """What the terminal shows: one command, one result after each save."""
    shown = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, _steps(Path(folder), shown), redirect_stdout(shown):
        cli.main(["check", folder, "--watch"])
    return _lasting(shown.getvalue(), Path(folder))


@contextmanager
def _steps(folder: Path, shown: io.StringIO) -> Iterator[None]:
    """The student saves in the place of the clock that waits for a save."""
    for path in (LAB.folder / "starter").glob("*.py.txt"):
        (folder / path.stem).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")

    def saves(*_: object) -> Iterator[None]:
        for name, edits in STEPS:
            for file, written in edits.items():
                _edit(folder / file, written)
            shown.write(f"\n--- {name} ---\n\n")
            yield
        raise KeyboardInterrupt

    really, checking.saves = checking.saves, saves
    width = {"COLUMNS": "100"}
    before = {name: os.environ.get(name) for name in width}
    os.environ.update(width)
    try:
        yield
    finally:
        checking.saves = really
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _edit(path: Path, written: dict[str, str]) -> None:
    """Write definitions in the place of those that begin so, each up to the next thing at the left edge."""
    text = path.read_text(encoding="utf-8")
    for start, code in written.items():
        pattern = rf"^{re.escape(start)}\b.*?\n(?=\S)"
        text, count = re.subn(pattern, lambda _, code=code: f"{code}\n\n", text, flags=re.MULTILINE | re.DOTALL)
        assert count == 1, f"{path.name} has {count} of {start}"
    path.write_text(text, encoding="utf-8")


def _lasting(text: str, folder: Path) -> str:
    """Without what is another the next time."""
    named = text.replace(str(folder), "my_lab").replace(folder.name, "my_lab")
    return "$ imugrade check my_lab --watch\n" + re.sub(r"checked at \d\d:\d\d:\d\d", "checked at 12:00:00", named)
