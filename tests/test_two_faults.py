"""Two faults cost what each of them costs, whatever the other one spoils: the sheet's own layout with two of its lines edited."""

from __future__ import annotations

import pytest

from tests.corpus.pieces import edit, verbatim
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

READER, NOISY, FILTER = "imu_reader.py", "noisy_imu.py", "filters.py"
RETURNED = "return acceleration, angular_velocity"
EDITS: dict[str, tuple[str, str, str]] = {
    "the other's address": (READER, "gyro_adr = model.sensor_adr[gyro_sensor_id]", "gyro_adr = model.sensor_adr[accel_sensor_id]"),
    "in units of g": (READER, RETURNED, "return acceleration / 9.81, angular_velocity"),
    "a reader that raises": (READER, "model.sensor_adr[accel_sensor_id]", "model.sensor_adr[accel_sensor_id, 0]"),
    "no reset": (READER, "    mujoco.mj_resetData(model, data)\n", ""),
    "another key": (READER, "'time': times,", "'t': times,"),
    "no unit": (READER, "axes[0].set_ylabel('Acceleration (m/s²)')", "axes[0].set_ylabel('Acceleration')"),
    "a plot that raises": (READER, "axes[1].set_title(", "axes[2].set_title("),
    "no gyroscope's bias": (NOISY, " + self.gyro_bias", ""),
    "a variance": (NOISY, "np.random.normal(0, self.accel_noise_std, 3)", "np.random.normal(0, self.accel_noise_std**2, 3)"),
    "noise that raises": (NOISY, "+ self.accel_bias", "+ self.accel_bias[3]"),
    "a coefficient's other half": (FILTER, "self.alpha * measurement + (1 - self.alpha)", "(1 - self.alpha) * measurement + self.alpha"),
    "from zero": (FILTER, "self.value = measurement.copy()", "self.value = 0 * measurement"),
}  # fmt: skip
PAIRS = (
    ("in units of g", "no gyroscope's bias"), ("the other's address", "no gyroscope's bias"), ("the other's address", "in units of g"),
    ("a reader that raises", "no reset"), ("a reader that raises", "a variance"), ("a reader that raises", "no unit"),
    ("in units of g", "another key"), ("the other's address", "a variance"), ("another key", "no unit"),
    ("a plot that raises", "no reset"), ("a plot that raises", "from zero"), ("noise that raises", "from zero"),
    ("noise that raises", "a coefficient's other half"), ("a variance", "a coefficient's other half"),
)  # fmt: skip


@pytest.fixture(scope="module")
def alone(player: Marking) -> dict[str, dict[str, float]]:
    """What each edit costs by itself."""
    return {name: lost_by(marked(player, _edited(name))) for name in EDITS}


def _edited(*names: str) -> dict[str, str]:
    files = verbatim()
    for path, old, new in (EDITS[name] for name in names):
        files = edit(files, path, (old, new))
    return files


@pytest.mark.parametrize("pair", PAIRS, ids=" and ".join)
def test_two_faults_cost_what_each_of_them_costs(
    pair: tuple[str, str], alone: dict[str, dict[str, float]], player: Marking
) -> None:
    both = lost_by(marked(player, _edited(*pair)))
    checks = {check for name in pair for check in alone[name]}
    assert all(alone[name] for name in pair)
    assert both == {check: sum(alone[name].get(check, 0.0) for name in pair) for check in checks}
