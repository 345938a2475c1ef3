"""Robots of the dm_control wheel, which is fetched from the package index and never kept in this repository."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.examples import files

ROOT = Path(__file__).parent.parent
PACKAGE = "dm_control>=1.0.20,<2"
_FOLDERS = ("suite", "third_party/ant", "locomotion/soccer/assets/boxhead")


@dataclass(frozen=True)
class Other:
    """A model of the wheel: its file, and the names of its accelerometer and gyroscope."""

    path: str
    accelerometer: str
    gyroscope: str


OTHERS = {
    "humanoid": Other("suite/humanoid.xml", "torso_accel", "torso_gyro"),
    "quadruped": Other("suite/quadruped.xml", "imu_accel", "imu_gyro"),
    "ant": Other("third_party/ant/ant.xml", "torso_accel", "torso_gyro"),
    "dog": Other("suite/dog.xml", "accelerometer", "gyro"),
    "boxhead": Other("locomotion/soccer/assets/boxhead/boxhead.xml", "sensor_torso_accel", "sensor_torso_gyro"),
}


def fetched(kept: Path) -> Path:
    """The folder `dm_control` with its models; what was fetched once is used again.

    Without a package index the tests that ask for it fail: they are the proof that other robots can be graded.
    """
    if not (kept / "whole").exists():
        command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "download", "--quiet", "--no-deps"]
        done = subprocess.run([*command, "--dest", str(kept), PACKAGE], capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.fail(f"{PACKAGE} cannot be fetched: {done.stderr[-500:]}")
        wheel = max(kept.glob("dm_control-*.whl"))
        with zipfile.ZipFile(wheel) as archive:
            wanted = [n for n in archive.namelist() if n.startswith(tuple(f"dm_control/{f}/" for f in _FOLDERS))]
            archive.extractall(kept, [name for name in wanted if not name.endswith(".py")])
        wheel.unlink()
        (kept / "whole").touch()
    return kept / "dm_control"


def rubric_for(folder: Path, model: Path | str | None, accelerometer: str, gyroscope: str) -> Path:
    """A copy of the shipped rubric that names this robot."""
    text = (ROOT / "rubric.yaml").read_text(encoding="utf-8")
    if model is not None:
        text = text.replace("  # path: my-humanoid.xml", f"  path: {model}")
    text = text.replace("accelerometer: torso_accelerometer", f"accelerometer: {accelerometer}")
    text = text.replace("gyroscope: torso_gyroscope", f"gyroscope: {gyroscope}")
    path = folder / "rubric.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def exchanged(folder: Path, accelerometer: str, gyroscope: str, file: str = "humanoid-sensors.xml") -> Path:
    """The sheet's own code with the names of these sensors, and of this model's file."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in files("s01-sheet-verbatim"):
        content = path.read_bytes()
        if path.suffix == ".py":
            for old, new in (
                ("torso_accelerometer", accelerometer),
                ("torso_gyroscope", gyroscope),
                ("humanoid-sensors.xml", file),
            ):
                content = content.replace(old.encode(), new.encode())
        (folder / path.name).write_bytes(content)
    return folder
