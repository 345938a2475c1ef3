"""How much a submission can say of hidden data through its feedback: ``python -m tests.hostile.channel``.

One program chooses, for each of ten checks, how it fails: by which error, in a power of ten, or whether at all. Several gradings under a
secret show how many different feedbacks each check gives; their logarithms add up to the bits that one grading lets out by these checks.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence

from grader.engine.grader import Marker
from grader.engine.results import CheckResult
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files
from tests.single_faults import marked

SIZES: Sequence[float] = (0.0, *(10.0**power for power in range(-3, 14)))
"""What is added to an answer: nothing, or an error of each order of magnitude, the last of them beyond all measure."""
SIZED = ("sensor_access.matches_truth", "data_collection.matches_truth", "noise_model.given_bias", "filtering.passes_constant")
"""Checks that say the size of an error, where no fault explains it."""
LOST_OR_NOT = (
    "sensor_access.leaves_simulation_alone", "visualization.titles", "visualization.legend_names_curves",
    "visualization.axis_labels_with_units", "noise_model.leaves_simulation_alone", "filtering.instances_independent",
)  # fmt: skip
"""Checks that say whether the answer was right."""
_READER = """
_read, _collect = get_imu_readings, simulate_and_collect
_ODD = np.array([1.0, -0.7, 0.4])

def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    accel, gyro = _read(model, data, accel_sensor_id, gyro_sensor_id)
    data.time += {lost}
    return accel + {size} * _ODD * np.sin(1e3 * accel), gyro

def simulate_and_collect(model, data, duration_seconds=5.0):
    get_imu_readings.__globals__["get_imu_readings"] = _read
    found = _collect(model, data, duration_seconds)
    found["acceleration"] += {size} * _ODD * np.sin(1e3 * found["acceleration"])
    return found
"""
_NOISE = """
class NoisyIMU(NoisyIMU):
    def __init__(self, *given, **named):
        super().__init__(*given, **named)
        if len(given) > 6 or named.get("accel_bias") is not None:
            self.accel_bias = self.accel_bias + {size} * np.array([1.0, -0.7, 0.4])
    def read(self):
        self.data.time += {lost}
        return super().read()
"""
_FILTER = """
class LowPassFilter(LowPassFilter):
    def update(self, measurement):
        found = super().update(measurement)
        same, self.last = np.array_equal(measurement, getattr(self, "last", None)), np.array(measurement)
        return found + {size} * np.array([1.0, -0.7, 0.4]) if same and {size} else found
"""


def program(size: float, lost: bool) -> Files:
    """Return a submission whose answers are off by `size` and which loses what it can choose to lose, or not."""
    files, values = tidy(), {"size": repr(size), "lost": int(lost)}
    reader = files["imu_reader.py"]
    if lost:
        for said in ('"Torso accelerometer"', '"Torso gyroscope"'):
            reader = reader.replace(said, '""')
        reader = reader.replace(" [m/s^2]", "").replace(" [rad/s]", "").replace('ax.legend(loc="best")', "pass")
    smooth = files["filters.py"].replace("return self.state.copy()", "return self.state") if lost else files["filters.py"]
    return {
        "imu_reader.py": reader + _READER.format(**values),
        "noisy_imu.py": files["noisy_imu.py"] + _NOISE.format(**values),
        "filters.py": smooth + _FILTER.format(**values),
    }  # fmt: skip


def _told(check: CheckResult) -> tuple[object, ...]:
    return check.outcome, check.points, check.message, check.hint, check.misconceptions


def measured(marker: Marker) -> Mapping[str, set[tuple[object, ...]]]:
    """Return the different feedbacks of each of the ten checks, from a grading for each size."""
    found: dict[str, set[tuple[object, ...]]] = {name: set() for name in (*SIZED, *LOST_OR_NOT)}
    for number, size in enumerate(SIZES):
        for criterion in marked(marker, program(size, number % 2 == 1)).criteria:
            for check in criterion.checks:
                if check.id in found:
                    found[check.id].add(_told(check))
    return found


def bits(found: Mapping[str, set[tuple[object, ...]]]) -> float:
    """Return the bits of one grading, to one decimal."""
    return round(sum(math.log2(len(each)) for each in found.values()), 1)


if __name__ == "__main__":
    argparse.ArgumentParser(prog="python -m tests.hostile.channel", description=__doc__).parse_args()

    from grader.labs.imu import bundles
    from grader.labs.imu.lab import LAB
    from tests import sandboxes

    with sandboxes.opened(bundles.obtain(LAB, "a secret to measure with")) as opened:
        told = measured(opened)
    print(*(f"{len(each):3} {name}" for name, each in told.items()), f"{bits(told)} bits a grading", sep="\n")
    sandboxes.close()
