"""What comes back in another form than the sheet's is one fault: the numbers in it are judged as if they had come as they should."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.corpus.pieces import edit, tidy, verbatim
from tests.corpus.writing import Files
from tests.slips import Slip, costs_what_it_is
from tests.tapes import Marking

FORM = "wrong-return-type"


READS = {
    "six in a line": "np.hstack([acceleration, angular_velocity])",
    "a dictionary": '{"acceleration": acceleration, "angular_velocity": angular_velocity}',
    "columns": "acceleration.reshape(3, 1), angular_velocity.reshape(3, 1)",
}
NOISY = {
    "six in a line": "np.hstack([accel_noisy, gyro_noisy])",
    "six in a list": "[*accel_noisy, *gyro_noisy]",
    "six": "(*accel_noisy, *gyro_noisy)",
    "the time as well": "accel_noisy, gyro_noisy, self.data.time",
    "the time first": "self.data.time, accel_noisy, gyro_noisy",
    "a dictionary": '{"accel": accel_noisy, "gyro": gyro_noisy}',
    "a dictionary with the time": '{"gyro": gyro_noisy, "time": self.data.time, "accel": accel_noisy}',
}
FILTERED = {
    "beside the measurement": "self.value.copy(), measurement",
    "in a dictionary": '{"value": self.value.copy(), "alpha": self.alpha}',
}
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
    "one axis of the accelerometer": (
        ("'acceleration': accelerations", "'acceleration': accelerations[:, 2]"),
        {"returns_named_arrays": 3.0, "matches_truth": 3.0}, (FORM,),
    ),
    "both side by side": (
        (BOTH, "        'imu': np.hstack([accelerations, angular_velocities])\n"),
        {"returns_named_arrays": 3.0}, ("wrong-keys", FORM),
    ),
    "a dimension too many": (
        ("'acceleration': accelerations", "'acceleration': accelerations[:, :, None]"),
        {"returns_named_arrays": 3.0}, (FORM,),
    ),
    "returned after the first row": (
        ("    return {\n        'time'", "        return {\n        'time'"),
        {"matches_truth": 6.0}, (),
    ),
}  # fmt: skip


def _slips() -> Iterator[Slip]:
    for name, value in READS.items():
        files = edit(verbatim(), "imu_reader.py", ("return acceleration, angular_velocity", f"return {value}"))
        yield Slip(f"read: {name}", files, {"sensor_access.returns_two_vectors": 3.0}, (FORM,))
    for name, value in NOISY.items():
        files = edit(verbatim(), "noisy_imu.py", ("return accel_noisy, gyro_noisy", f"return {value}"))
        yield Slip(f"noise: {name}", files, {"noise_model.noise_size": 3.0}, (FORM,))
    for name, value in FILTERED.items():
        files = edit(verbatim(), "filters.py", ("return self.value.copy()", f"return {value}"))
        yield Slip(f"filter: {name}", files, {"filtering.follows_recursion": 3.0}, (FORM,))
    for name, (change, lost, mistakes) in COLLECTED.items():
        files = edit(verbatim(), "imu_reader.py", change)
        yield Slip(f"record: {name}", files, {f"data_collection.{check}": p for check, p in lost.items()}, mistakes)
    files = edit(tidy(), "filters.py", ("alpha=0.1, initial_value", "alpha, initial_value"))
    yield Slip("filter: alpha has no default", files, {"filtering.follows_recursion": 3.0}, ())
    yield Slip(
        "read: a signature of its own, and a colon missing",
        _own_signature(),
        {f"sensor_access.{check}": points for check, points in READER.items()},
        ("does-not-import",),
    )


READER = {
    "returns_two_vectors": 3.0, "matches_truth": 6.0, "follows_address": 6.0, "reading_is_a_copy": 3.0,
    "leaves_simulation_alone": 2.0,
}  # fmt: skip


def _own_signature() -> Files:
    """A reader that nothing can run; the rest calls it without the model, and finds one that takes that."""
    define = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):"
    files = edit(
        tidy(),
        "imu_reader.py",
        (define, "def get_imu_readings(data, accel_sensor_id, gyro_sensor_id)"),
        ("get_imu_readings(model, data, accel_id, gyro_id)", "get_imu_readings(data, accel_id, gyro_id)"),
    )
    return edit(files, "noisy_imu.py", ("get_imu_readings(self.model, self.data", "get_imu_readings(self.data"))


@pytest.mark.parametrize("slip", [*_slips()], ids=lambda slip: slip.name)
def test_another_form_costs_what_it_is_and_nothing_else(slip: Slip, player: Marking) -> None:
    costs_what_it_is(slip, player)
