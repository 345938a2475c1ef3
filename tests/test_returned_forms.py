"""What comes back in another form than the sheet's is one fault: the numbers in it are judged as if they had come as they should."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.corpus.pieces import edit, tidy, verbatim
from tests.corpus.writing import Files
from tests.recordings import Marking
from tests.single_faults import SingleFault, assert_loses

FORM = "wrong-return-type"


READS = {
    "six in a line": "np.hstack([acceleration, angular_velocity])",
    "a dictionary": '{"acceleration": acceleration, "angular_velocity": angular_velocity}',
    "columns": "acceleration.reshape(3, 1), angular_velocity.reshape(3, 1)",
}
NOISY = {
    "six in a line": "np.hstack([accel_noisy, gyro_noisy])",
    "the time as well": "accel_noisy, gyro_noisy, self.data.time",
    "a dictionary with the time": '{"gyro": gyro_noisy, "time": self.data.time, "accel": accel_noisy}',
}
FILTERED = {
    "beside the measurement": "self.value.copy(), measurement",
    "in a dictionary": '{"value": self.value.copy(), "alpha": self.alpha}',
    "its length": "np.linalg.norm(self.value)",
    "whether it was done": "True",
}
KEEPING: dict[str, tuple[str, str]] = {
    "beside the measurement": ("self.last, self.count = measurement, 1", "self.count"),
}
"""What a filter keeps beside its state, and what it returns."""
BOTH = "        'acceleration': accelerations,\n        'angular_velocity': angular_velocities\n"
COLLECTED: dict[str, tuple[tuple[str, str], dict[str, float], tuple[str, ...]]] = {
        "no gyroscope": (
        ("        'angular_velocity': angular_velocities\n", ""),
        {"returns_named_arrays": 3.0, "matches_truth": 3.0}, ("wrong-keys",),
    ),
        "one axis of it": (
        ("'angular_velocity': angular_velocities", "'angular_velocity': angular_velocities[:, 2]"),
        {"returns_named_arrays": 3.0, "matches_truth": 3.0}, (FORM,),
    ),
        "both side by side": (
        (BOTH, "        'imu': np.hstack([accelerations, angular_velocities])\n"),
        {"returns_named_arrays": 3.0}, ("wrong-keys", FORM),
    ),
        "returned after the first row": (
        ("    return {\n        'time'", "        return {\n        'time'"),
        {"matches_truth": 6.0}, (),
    ),
    }  # fmt: skip


def _slips() -> Iterator[SingleFault]:
    for name, value in READS.items():
        files = edit(verbatim(), "imu_reader.py", ("return acceleration, angular_velocity", f"return {value}"))
        yield SingleFault(f"read: {name}", files, {"sensor_access.returns_two_vectors": 3.0}, (FORM,))
    for name, value in NOISY.items():
        files = edit(verbatim(), "noisy_imu.py", ("return accel_noisy, gyro_noisy", f"return {value}"))
        yield SingleFault(f"noise: {name}", files, {"noise_model.noise_size": 3.0}, (FORM,))
    for name, value in FILTERED.items():
        files = edit(verbatim(), "filters.py", ("return self.value.copy()", f"return {value}"))
        yield SingleFault(f"filter: {name}", files, {"filtering.follows_recursion": 3.0}, (FORM,))
    for name, (line, value) in KEEPING.items():
        files = edit(verbatim(), "filters.py", ("return self.value.copy()", f"{line}\n        return {value}"))
        yield SingleFault(f"filter: kept {name}", files, {"filtering.follows_recursion": 3.0}, (FORM,))
    alone = edit(verbatim(), "imu_reader.py", ("return acceleration, angular_velocity", "return acceleration"))
    yield SingleFault("read: the accelerometer alone", alone, {"sensor_access.matches_truth": 6.0}, (FORM,))
    for name, (change, lost, mistakes) in COLLECTED.items():
        files = edit(verbatim(), "imu_reader.py", change)
        yield SingleFault(
            f"record: {name}", files, {f"data_collection.{check}": p for check, p in lost.items()}, mistakes
        )
    for name, form in OWN_FORMS.items():
        named = {"columns": "arrays-transposed", "a key for each axis": "wrong-keys"}.get(name, FORM)
        yield SingleFault(
            f"record and plot: {name}", _recorded_as(*form), {"data_collection.returns_named_arrays": 3.0}, (named,)
        )
    files = edit(tidy(), "filters.py", ("alpha=0.1, initial_value", "alpha, initial_value"))
    yield SingleFault("filter: alpha has no default", files, {"filtering.follows_recursion": 3.0}, ())


RECORDING = "{\n        'time': times,\n        'acceleration': accelerations,\n        'angular_velocity': angular_velocities\n    }"
OWN_FORMS: dict[str, tuple[str, str, str, str]] = {
        "a tuple": ("times, accelerations, angular_velocities", "imu_data[0]", "imu_data[1][:, {}]", "imu_data[2][:, {}]"),
        "one array": (
        "np.column_stack([times, accelerations, angular_velocities])",
        "imu_data[:, 0]", "imu_data[:, 1 + {}]", "imu_data[:, 4 + {}]",
    ),
        "columns": (
        "{'time': times, 'acceleration': accelerations.T, 'angular_velocity': angular_velocities.T}",
        "imu_data['time']", "imu_data['acceleration'][{}]", "imu_data['angular_velocity'][{}]",
    ),
        "rows": (
        "[(t, *a, *w) for t, a, w in zip(times, accelerations, angular_velocities)]",
        "[row[0] for row in imu_data]", "[row[1 + {}] for row in imu_data]", "[row[4 + {}] for row in imu_data]",
    ),
        "by axis": (
        "{'time': times, 'accel': dict(zip('xyz', accelerations.T)), 'gyro': dict(zip('xyz', angular_velocities.T))}",
        "imu_data['time']", "imu_data['accel']['xyz'[{}]]", "imu_data['gyro']['xyz'[{}]]",
    ),
        "within another": (
        "{'imu': " + RECORDING + "}",
        "imu_data['imu']['time']", "imu_data['imu']['acceleration'][:, {}]", "imu_data['imu']['angular_velocity'][:, {}]",
    ),
        "a key for each axis": (
        "{'time': times} | {f'accel_{n}': accelerations[:, k] for k, n in enumerate('xyz')}"
        " | {f'gyro_{n}': angular_velocities[:, k] for k, n in enumerate('xyz')}",
        "imu_data['time']", "imu_data['accel_' + 'xyz'[{}]]", "imu_data['gyro_' + 'xyz'[{}]]",
    ),
    }  # fmt: skip
"""What is returned, and how the plot reads the time, an axis of the accelerometer and of the gyroscope in it."""


def _recorded_as(returned: str, time: str, accel: str, gyro: str) -> Files:
    text = str(verbatim()["imu_reader.py"]).replace(f"return {RECORDING}", f"return {returned}")
    for axis in range(3):
        text = text.replace(f"imu_data['acceleration'][:, {axis}]", accel.format(axis))
        text = text.replace(f"imu_data['angular_velocity'][:, {axis}]", gyro.format(axis))
    head, plot = text.split("def plot_imu_data", 1)
    read = [line if "plot(" not in line else line.replace("imu_data['time']", time) for line in plot.split("\n")]
    return verbatim() | {"imu_reader.py": head + "def plot_imu_data" + "\n".join(read)}


@pytest.mark.parametrize("slip", [*_slips()], ids=lambda slip: slip.name)
def test_another_form_costs_what_it_is_and_nothing_else(slip: SingleFault, player: Marking) -> None:
    assert_loses(slip, player)
