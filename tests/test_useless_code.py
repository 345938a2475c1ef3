"""Tests of parts that do nothing, such as filters without memory and readers without a sensor: they earn a few points for their form at most."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from grader.engine import rubric
from grader.engine.findings import Charged, Missing, Raised, Skipped
from grader.labs.imu.lab import LAB
from grader.labs.imu.noise_model import checks
from tests.corpus.pieces import FILTERS, IMU_READER, verbatim
from tests.judging.fake_students import FakeStudent, truth
from tests.recordings import Marking
from tests.single_faults import marked

FORM = {"filtering": 4.0, "sensor_access": 4.0, "data_collection": 6.0, "visualization": 6.0, "noise_model": 4.0}
"""Points of each criterion that a part without work may keep."""
RETURNED_BY_FILTERS = (
    "np.tanh(m)", "np.clip(m, -1, 1)", "np.round(m, 1)", "0.3 * m", "m[::-1].copy()", "np.zeros(3)", "np.full(3, m.mean())", "self.alpha * m",
    "m * 0.99 ** self.n", "first * 0.99 ** self.n", "first * self.n", "np.random.normal(0, 1, 3)",
)  # fmt: skip
RETURNED_BY_READERS = (
    "np.zeros(3), np.zeros(3)", "np.array([0.0, 0.0, -9.81]), np.zeros(3)", "np.array([next(count), 0.0, -9.81]), np.full(3, next(count))",
    "np.array([0.0, 0.0, -9.81]), np.random.normal(0, 0.05, 3)", "np.full(3, float(accel_sensor_id)), np.full(3, float(gyro_sensor_id))",
    "np.full(3, data.time), np.sin(next(count) * np.arange(3.0))", "np.full(3, np.nan), np.random.uniform(-1, 1, 3)",
)  # fmt: skip
ROWS = (
    "np.zeros((n, 3))", "np.tile([0.0, 0.0, -9.81], (n, 1))", "np.random.normal(0, 1, (n, 3))", "np.sin(np.arange(3 * n).reshape(n, 3))",
    "np.cumsum(np.random.normal(0, 1, (n, 3)), axis=0)",
)  # fmt: skip
SIMULATED = "mujoco.mj_resetData(model, data); data.qvel[0] = 0.5; [mujoco.mj_step(model, data) for _ in range(n)]"
"""A run of the simulation of which nothing is read."""
CURVES = (
    "np.zeros(300)", "np.arange(300.0)", "np.sin(np.arange(300) / 9)", "np.full(300, -9.81)", "imu_data['time'] * 0", "imu_data['time'] ** 2",
    "np.ones(2)", "np.cumsum(np.random.normal(0, 1, 300))", "np.random.normal(0, 1, len(imu_data['time']))", "np.sin(9 * imu_data['time'])",
)  # fmt: skip
"""Sums of chance once passed for data."""


def parts() -> Iterator[Any]:
    """Each part by its criterion, and the files with it: it stands below the sheet's own, and takes its place."""
    for value in RETURNED_BY_FILTERS:
        source = (
            "import numpy as np\nclass LowPassFilter:\n    def __init__(self, alpha=0.1, initial_value=None):\n"
            "        self.alpha, self.value = alpha, initial_value\n    def update(self, measurement):\n"
            "        m = np.asarray(measurement, float); self.n = getattr(self, 'n', -1) + 1\n"
            f"        first = self.first = getattr(self, 'first', m.copy())\n        return {value}\n"
        )
        yield pytest.param("filtering", {**verbatim(), "filters.py": f"{FILTERS}\n\n{source}"}, id=f"filter: {value}")
    for values in RETURNED_BY_READERS:
        source = (
            "import itertools\ncount = itertools.count(1.0)\n"
            f"def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n    return {values}\n"
        )
        yield pytest.param("sensor_access", _in_reader(source), id=f"reader: {values}")
    whole = ("int(duration_seconds / model.opt.timestep)", "(np.arange(n) + 1) * model.opt.timestep")
    for rows, (count, stamps), run in [
        *itertools.product(ROWS, [whole], ("pass", SIMULATED)),
        *itertools.product(ROWS[:1], [("1", "np.zeros(n)"), ("1500", "np.arange(float(n))")], ("pass",)),
    ]:
        source = (
            f"def simulate_and_collect(model, data, duration_seconds=5.0):\n    n = {count}\n    {run}\n"
            f"    return {{'time': {stamps}, 'acceleration': {rows}, 'angular_velocity': {rows}}}\n"
        )
        name = f"recorder: {count} of {rows} at {stamps}{', simulated' * (run == SIMULATED)}"
        yield pytest.param("data_collection", _in_reader(source), id=name)
    for curve, times in zip(CURVES, itertools.cycle((3, 1, 6))):
        source = (
            "def plot_imu_data(imu_data):\n    fig, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)\n"
            f"    [a.plot({curve}, label='XYZ'[i % 3]) for a in axes for i in range({times})]; [a.legend() for a in axes]\n"
            "    axes[0].set_title('Accelerometer'); axes[1].set_title('Gyroscope'); axes[1].set_xlabel('Time (s)')\n"
            "    axes[0].set_ylabel('Acceleration (m/s²)'); axes[1].set_ylabel('Angular velocity (rad/s)')\n"
            "    plt.savefig('imu_data.png', dpi=150)\n"
        )
        yield pytest.param("visualization", _in_reader(source), id=f"plot: {curve}, {times} times")


def _in_reader(source: str) -> dict[str, str]:
    imports = "import mujoco\nimport numpy as np\nimport matplotlib.pyplot as plt\n"
    return {**verbatim(), "imu_reader.py": f"{IMU_READER}\n\n{imports}{source}"}


@pytest.mark.parametrize(("criterion", "files"), [*parts()])
def test_a_part_that_does_nothing_earns_its_form_at_most(
    criterion: str, files: dict[str, str], player: Marking
) -> None:
    (part,) = marked(player, files, criterion).criteria
    assert part.points <= FORM[criterion], {check.id: check.points for check in part.checks if check.points}


# --- noise models: made-up students in this process -------------------------------------------------------------------

Vector = Callable[[Any, int], Any]
NUMBERS: dict[str, Vector] = {
    "zeros": lambda self, which: np.zeros(3),
    "its reads": lambda self, which: np.full(3, float(self.reads)),
    "waves": lambda self, which: np.sin(self.reads + np.arange(3.0)),
    "std": lambda self, which: np.full(3, self.stds[which]),
    "loud": lambda self, which: np.random.normal(0, 300, 3),
    "normal of std": lambda self, which: np.random.normal(0, self.stds[which], 3),
    "normal about gravity": lambda self, which: np.random.normal((0, 0, -9.81), self.stds[which], 3),
    "one normal": lambda self, which: np.full(3, np.random.normal(0, self.stds[which])),
    "drawn once": lambda self, which: self.drawn,
    "walk": lambda self, which: self.walked(which),
    "time": lambda self, which: np.full(3, self.data.time),
}
ADDED: dict[str, Vector] = {
    "nothing": lambda self, which: 0.0,
    "the bias": lambda self, which: self.biases[which],
    "a constant": lambda self, which: np.array([0.1, -0.2, 0.3]),
    "noise": lambda self, which: np.random.normal(0, self.stds[which], 3),
}
STANDING = ("normal about gravity", "normal of std", "the bias")
"""What a standing robot reads, with the noise and the bias that were asked for: as a `read` that forgot to call the reader, and uses
what an earlier line of the file has read. It shows noise and bias, and loses `white_and_gaussian`."""
LIKE_STANDING = (STANDING, ("normal about gravity", "one normal", "the bias"))
NOISE_MODELS = [each for each in itertools.product(NUMBERS, NUMBERS, ADDED) if each not in LIKE_STANDING]
"""The two vectors and what is added to both."""


class NoSensor:
    """A class of the sheet's form whose two vectors are `numbers` plus `added`."""

    numbers: tuple[Vector, Vector]
    added: Callable[[int], Any]

    def __init__(
        self, model: Any, data: Any, accel_id: int, gyro_id: int, accel_noise_std: float = 0.05,
        gyro_noise_std: float = 0.005, accel_bias: Any = None, gyro_bias: Any = None,
    ) -> None:  # fmt: skip
        self.data, self.stds, self.reads = data, (accel_noise_std, gyro_noise_std), 0
        given = zip((accel_bias, gyro_bias), (0.1, 0.01), strict=True)
        self.biases = [np.random.normal(0, size, 3) if bias is None else bias for bias, size in given]
        self.drawn, self.sums = np.random.normal(0, 0.1, 3), [np.zeros(3), np.zeros(3)]

    def walked(self, which: int) -> Any:
        self.sums[which] = self.sums[which] + np.random.normal(0, self.stds[which], 3)
        return self.sums[which]

    def read(self) -> Any:
        self.reads += 1
        return tuple(self.numbers[which](self, which) + self.added(which) for which in (0, 1))


def kept(kind: type) -> dict[str, float]:
    """Points of each check of the noise model."""
    worth = {check.id: check.max_points for part in rubric.load(LAB).criteria for check in part.checks}
    student, points = FakeStudent(NoisyIMU=kind), {}
    for check in [check for name, check in vars(checks).items() if name.startswith("check_")]:
        try:
            check(student, truth())
            keeps = 1.0
        except Charged as charged:
            keeps = charged.charge.keeps
        except (Skipped, Raised, Missing):
            keeps = 0.0
        points[check.check.id] = keeps * worth[check.check.id]
    return points


@pytest.mark.parametrize(("accel", "gyro", "added"), [STANDING, *random.Random(42).sample(NOISE_MODELS, 8)])
def test_a_noise_model_without_a_sensor_earns_its_form_at_most(accel: str, gyro: str, added: str) -> None:
    points = kept(type("Noisy", (NoSensor,), {"numbers": (NUMBERS[accel], NUMBERS[gyro]), "added": ADDED[added]}))
    if (accel, gyro, added) == STANDING:
        assert points["noise_model.white_and_gaussian"] == 0.0
        assert sum(points.values()) == 17.0
    else:
        assert points["noise_model.leaves_simulation_alone"] == 2.0, "it did not run"
        assert sum(points.values()) <= FORM["noise_model"], points
