"""Sweep over generated parts that do nothing: filters without memory, readers and noise models without a sensor, and others."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from grader.engine import rubric
from grader.engine.findings import Charged, Missing, Raised, Skipped
from grader.engine.grader import Marker
from grader.labs.imu.lab import LAB
from grader.labs.imu.noise_model import checks
from tests.corpus.cases import Case
from tests.corpus.pieces import verbatim
from tests.judging.fake_students import FakeStudent, truth
from tests.recordings import Marking
from tests.single_faults import marked

_WITHOUT_MEMORY = (
    "np.tanh({x})", "{x} * {x}", "np.clip({x}, -1, 1)", "np.round({x}, 3)", "np.round({x}, 1)", "np.abs({x})", "np.sign({x})", "{x} + 1",
    "-{x}", "0.3 * {x}", "{x}[::-1].copy()", "np.zeros(3)", "np.full(3, self.alpha)", "np.sin({x})", "np.exp(-{x} * {x})", "np.floor({x})",
    "np.full(3, {x}.mean())", "{x} * 0.99 ** self.n", "{x} * self.n", "np.random.normal(0, 1, 3)", "self.alpha * {x}", "np.sqrt(np.abs({x}))",
)  # fmt: skip
_HEAD = (
    "m = np.asarray(measurement, float); self.n = getattr(self, 'n', -1) + 1; "
    "first = self.first = getattr(self, 'first', m.copy()); return "
)


_IMPORTS = {
    "imu_reader.py": "import mujoco\nimport numpy as np\nimport matplotlib.pyplot as plt\n",
    "filters.py": "import numpy as np\n",
}
_FILTER = """\
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha, self.value = alpha, initial_value
    def update(self, measurement):
        {body}
"""
_PLOT = """\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)
    {body}
    axes[0].set_title('Accelerometer'); axes[1].set_title('Gyroscope')
    axes[0].set_ylabel('Acceleration (m/s²)'); axes[1].set_ylabel('Angular velocity (rad/s)')
    axes[1].set_xlabel('Time (s)')
    plt.savefig('imu_data.png', dpi=150)
"""


def _nothing(name: str, criterion: str, file: str, source: str, earns: float) -> Case:
    """The sheet's code, with a part below it that takes the place of its own."""
    files = {**verbatim(), file: f"{verbatim()[file]}\n\n{_IMPORTS[file]}{source}"}
    return Case("nothing", name, files, criterion=criterion, earns=earns)


def filters() -> list[Case]:
    bodies = dict.fromkeys(each.format(x=x) for each, x in itertools.product(_WITHOUT_MEMORY, ("m", "first")))
    return [
        _nothing(f"filter-{body}", "filtering", "filters.py", _FILTER.format(body=f"{_HEAD}{body}"), 4)
        for body in bodies
    ]


_COUNTING = "import itertools\n_count = itertools.count(1.0)\n"
_VECTORS = (
    "np.zeros(3)", "np.ones(3)", "np.array([0.0, 0.0, -9.81])", "np.random.normal(0, 9, 3)", "np.random.normal(0, 0.05, 3)",
    "np.random.uniform(-1, 1, 3)", "np.full(3, next(_count))", "np.full(3, np.pi)", "np.arange(3.0)", "np.sin(next(_count) * np.arange(3.0))",
    "np.full(3, float(accel_sensor_id))", "np.full(3, data.time)", "np.full(3, np.nan)", "np.full(3, float(model.nsensor))",
    "np.array([next(_count), 0.0, -9.81])",
)  # fmt: skip
_ROWS = (
    "np.zeros((n, 3))", "np.ones((n, 3))", "np.tile([0.0, 0.0, -9.81], (n, 1))", "np.random.normal(0, 1, (n, 3))",
    "np.cumsum(np.random.normal(0, 1, (n, 3)), axis=0)", "np.sin(np.arange(3 * n).reshape(n, 3))", "np.arange(3.0 * n).reshape(n, 3)",
    "np.full((n, 3), np.pi)",
)  # fmt: skip
_LENGTHS = ("1", "2", "10", "int(duration_seconds / model.opt.timestep)", "1500")
_STAMPS = ("np.zeros(n)", "(np.arange(n) + 1) * model.opt.timestep", "np.arange(float(n))")
_SIMULATED = "mujoco.mj_resetData(model, data); data.qvel[0] = 0.5; [mujoco.mj_step(model, data) for _ in range(n)]"  # and nothing read


def readers() -> list[Case]:
    head = f"{_COUNTING}def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
    return [
        _nothing(f"{a} and {g}", "sensor_access", "imu_reader.py", f"{head}    return {a}, {g}\n", 4)
        for a, g in itertools.product(_VECTORS, repeat=2)
    ]


def recorders() -> list[Case]:
    def written(n: str, stamps: str, rows: str, before: str) -> str:
        return (
            f"def simulate_and_collect(model, data, duration_seconds=5.0):\n    n = {n}\n    {before}\n"
            f"    return {{'time': {stamps}, 'acceleration': {rows}, 'angular_velocity': {rows}}}\n"
        )

    parts = [
        *itertools.product(_LENGTHS, _STAMPS, _ROWS, ("pass",)),
        *itertools.product(_LENGTHS, _STAMPS[1:2], _ROWS, (_SIMULATED,)),
    ]
    return [
        _nothing(
            f"{'steps and ' * (before == _SIMULATED)}{n} of {rows} at {stamps}",
            "data_collection",
            "imu_reader.py",
            written(n, stamps, rows, before),
            6,
        )
        for n, stamps, rows, before in parts
    ]


_CURVES = (
    "np.zeros(300)", "np.arange(300.0)", "np.random.normal(0, 1, 300)", "np.sin(np.arange(300) / 9)", "np.full(300, -9.81)",
    "imu_data['time'] * 0", "imu_data['time']", "imu_data['time'] ** 2", "np.ones(2)", "np.cumsum(np.random.normal(0, 1, 300))",
    "np.random.normal(0, 1, len(imu_data['time']))", "np.sin(9 * imu_data['time'])",
)  # fmt: skip
_AGAINST = ("", "np.linspace(0, 1, 300), ")


def plots() -> list[Case]:
    ways = [*itertools.product(_CURVES, (1, 3, 6), _AGAINST[:1]), *itertools.product(_CURVES[1:4], (3,), _AGAINST[1:])]
    return [
        _nothing(
            f"plot-{x}{y}, {k} times",
            "visualization",
            "imu_reader.py",
            _PLOT.format(
                body=f"[a.plot({x}{y}, label='XYZ'[i % 3]) for a in axes for i in range({k})]; [a.legend() for a in axes]"
            ),
            6,
        )
        for y, k, x in ways
    ]


EVERY = [*filters(), *readers(), *recorders(), *plots()]
SAMPLE = [part for every in (filters(), readers(), recorders(), plots()) for part in random.Random(42).sample(every, 6)]
SAMPLE += [
    part for part in plots() if "cumsum" in part.name and part not in SAMPLE
]  # sums of chance once passed for data


def name_of(part: Case) -> str:
    return part.name


def earned(marker: Marking, part: Case) -> tuple[float, dict[str, float]]:
    (criterion,) = marked(marker, part.files, part.criterion).criteria
    return criterion.points, {check.id: check.points for check in criterion.checks if check.points}


@pytest.mark.parametrize("part", SAMPLE, ids=name_of)
def test_a_sampled_part_that_does_nothing_earns_its_form_at_most(part: Case, player: Marking) -> None:
    points, kept = earned(player, part)
    assert points <= part.earns, kept


@pytest.mark.sweep
@pytest.mark.parametrize("part", EVERY, ids=name_of)
def test_no_part_that_does_nothing_earns_more_than_its_form(part: Case, marker: Marker) -> None:
    points, kept = earned(marker, part)
    assert points <= part.earns, kept


# --- noise models: made-up students in this process, so that hundreds take a minute -----------------------------------

_COUNT = itertools.count()
_FORM = 4.0
_NUMBERS: dict[str, Callable[[Any, int], Any]] = {
    "zeros": lambda self, which: np.zeros(3),
    "gravity": lambda self, which: np.array([0.0, 0.0, -9.81]),
    "its reads": lambda self, which: np.full(3, float(self.reads)),
    "all reads": lambda self, which: np.full(3, float(next(_COUNT))),
    "waves": lambda self, which: np.sin(self.reads + np.arange(3.0)),
    "std": lambda self, which: np.full(3, self.stds[which]),
    "normal": lambda self, which: np.random.normal(0, 9, 3),
    "loud": lambda self, which: np.random.normal(0, 300, 3),
    "normal of std": lambda self, which: np.random.normal(0, self.stds[which], 3),
    "normal about gravity": lambda self, which: np.random.normal((0, 0, -9.81), self.stds[which], 3),
    "uniform": lambda self, which: np.random.uniform(-1, 1, 3),
    "one normal": lambda self, which: np.full(3, np.random.normal(0, self.stds[which])),
    "drawn once": lambda self, which: self.drawn,
    "walk": lambda self, which: self.walked(which),
    "time": lambda self, which: np.full(3, self.data.time),
}
_WITH: dict[str, Callable[[Any, int], Any]] = {
    "nothing": lambda self, which: 0.0,
    "the bias": lambda self, which: self.biases[which],
    "a constant": lambda self, which: np.array([0.1, -0.2, 0.3]),
    "noise": lambda self, which: np.random.normal(0, self.stds[which], 3),
}
CHECKS = [check for name, check in vars(checks).items() if name.startswith("check_")]


class NoSensor:
    """A class of the sheet's form whose two vectors are `numbers` plus `added`."""

    numbers: tuple[Callable[[Any, int], Any], Callable[[Any, int], Any]]
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


_STANDING = ("normal about gravity", "normal of std", "the bias")
"""What a standing robot reads, with the noise and the bias that were asked for: as a `read` that forgot to call the reader, and uses
what an earlier line of the file has read. It shows noise and bias, and loses `white_and_gaussian`."""

_STANDING_ON_ONE_AXIS = ("normal about gravity", "one normal", "the bias")
"""The same with one draw for all axes of the gyroscope."""


def noise_models() -> Iterator[Any]:
    for (accel, gyro), added in itertools.product(itertools.product(_NUMBERS, repeat=2), _WITH):
        if (accel, gyro, added) in (_STANDING, _STANDING_ON_ONE_AXIS):
            continue
        steps = {"numbers": (_NUMBERS[accel], _NUMBERS[gyro]), "added": _WITH[added]}
        yield pytest.param(type("Noisy", (NoSensor,), steps), id=f"{accel}, {gyro}, with {added}")


def kept(kind: type) -> dict[str, float]:
    """Points of each check of the noise model."""
    worth = {check.id: check.max_points for part in rubric.load(LAB).criteria for check in part.checks}
    student, points = FakeStudent(NoisyIMU=kind), {}
    for check in CHECKS:
        try:
            check(student, truth())
            keeps = 1.0
        except Charged as charged:
            keeps = charged.charge.keeps
        except (Skipped, Raised, Missing):
            keeps = 0.0
        points[check.check.id] = keeps * worth[check.check.id]
    return points


NOISE_MODELS = [*noise_models()]


def test_noise_and_bias_beside_the_reading_of_a_standing_robot_lose_what_they_are_added_to() -> None:
    accel, gyro, bias = _STANDING
    points = kept(type("Noisy", (NoSensor,), {"numbers": (_NUMBERS[accel], _NUMBERS[gyro]), "added": _WITH[bias]}))
    assert {check: kept for check, kept in points.items() if "white" in check} == {
        "noise_model.white_and_gaussian": 0.0
    }
    assert sum(points.values()) == 17.0


@pytest.mark.parametrize("kind", random.Random(42).sample(NOISE_MODELS, 8))
def test_a_sampled_noise_model_without_a_sensor_earns_its_form_at_most(kind: type) -> None:
    points = kept(kind)
    assert points["noise_model.leaves_simulation_alone"] == 2.0, "it did not run"
    assert sum(points.values()) <= _FORM, points


@pytest.mark.sweep
@pytest.mark.parametrize("kind", NOISE_MODELS)
def test_no_noise_model_without_a_sensor_earns_more_than_its_form(kind: type) -> None:
    points = kept(kind)
    assert points["noise_model.leaves_simulation_alone"] == 2.0, "it did not run"
    assert sum(points.values()) <= _FORM, points
