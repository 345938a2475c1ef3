"""Sound stand-ins, sent into the box in place of a part that a student's own version gets wrong.

They go over the wire as text, and only after the checks of that part are over. Each says no more than the lab sheet itself.
"""

from __future__ import annotations

from pathlib import Path

NAMES = ("get_imu_readings", "simulate_and_collect", "plot_imu_data", "NoisyIMU", "LowPassFilter")


def source(name: str) -> str:
    """The text of one stand-in."""
    return (Path(__file__).parent / f"{name}.txt").read_text(encoding="utf-8")
