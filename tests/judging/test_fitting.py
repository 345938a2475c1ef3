"""What is deducted for parameters by which a definition cannot be called as the sheet calls it."""

from __future__ import annotations

import pytest

from grader.engine.findings import CheckFailed
from grader.labs.imu.checks.fitting import fits_in

pytestmark = pytest.mark.quick


def test_a_definition_with_the_sheets_parameters_loses_nothing() -> None:
    fits_in("get_imu_readings", ())


def test_two_globals_in_place_of_parameters() -> None:
    with pytest.raises(CheckFailed) as lost:
        fits_in("get_imu_readings", ("global model", "global data"), belongs_to="sensor_access.follows_address")
    assert (lost.value.got, lost.value.keeps) == ("it uses a global variable instead of model and data", 0.5)
    assert lost.value.mistakes == ("global-for-parameter",)
    assert lost.value.belongs_to == ("sensor_access.follows_address",)


def test_other_parameters_are_named_by_the_sheets_names() -> None:
    with pytest.raises(CheckFailed) as lost:
        fits_in("NoisyIMU", ("accel_id", "gyro_id"), keeps=0.0)
    assert lost.value.got == "other parameters for accel_id, gyro_id"
    assert (lost.value.keeps, lost.value.mistakes) == (0.0, ("other-parameters",))
