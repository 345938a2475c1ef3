"""What the judging says of whole families of code: drawn orders, signs, scales, delays and weights, and not one example of each.

``python -m pytest tests/judging/test_invariances.py --hypothesis-profile long`` draws fifty times as many.
"""

from __future__ import annotations

from collections.abc import Callable, Set
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grader.engine.charging import Judge
from grader.engine.findings import Charge
from grader.labs.imu.compare import Array
from grader.labs.imu.data_collection.explain import JUDGE as RECORDING
from grader.labs.imu.filtering.explain import JUDGE as FILTERING
from grader.labs.imu.noise_model.explain import JUDGE as NOISE
from grader.labs.imu.sensor_access.explain import JUDGE as READING
from tests.judging.fake_students import FakeStudent, truth
from tests.judging.test_check_data_collection import function, telling
from tests.judging.test_check_noise_model import Sound, of
from tests.judging.test_check_sensor_access import altered
from tests.judging.test_filtering import weighted

BOTH = st.sampled_from([(0,), (1,), (0, 1)])
"""Indices of the sensors that are treated."""
ORDERS = st.permutations(range(3)).map(list)
SIGNS = st.tuples(*[st.sampled_from([1.0, -1.0])] * 3).map(np.array)
OTHER_SCALES = st.floats(0.2, 0.85) | st.floats(1.15, 5.0)
"""Factors that a marker would not take for one: the tests of noise find 10 % with a probability above 0.999."""


def deducted(judge: Judge[Any], **functions: Any) -> dict[str, float]:
    """Return the share that each check of a criterion deducts, without those that refer to another check's deduction."""
    assert judge.checks
    found = judge._measure_and_judge(FakeStudent(**functions), truth())
    assert all(isinstance(each, Charge) for each in found.values()), found
    charges = {name.partition(".")[2]: each for name, each in found.items() if isinstance(each, Charge)}
    return {name: 1 - each.keeps for name, each in charges.items() if each.keeps < 1 and not each.see}


def only(found: dict[str, float], checks: Set[str]) -> bool:
    """Return whether a check deducts, and none but these, which the fault breaks."""
    return bool(found) and found.keys() <= checks


# --- readers ----------------------------------------------------------------------------------------------------------


@given(which=BOTH, order=ORDERS, signs=SIGNS)
def test_a_reader_loses_points_once_for_axes_in_another_order_or_of_another_sign(
    which: tuple[int, ...], order: list[int], signs: Array
) -> None:
    turned = [(lambda x: x[order] * signs) if sensor in which else np.array for sensor in (0, 1)]
    found = deducted(READING, get_imu_readings=altered(*turned))
    sound = order == [0, 1, 2] and bool((signs > 0).all())
    assert found == {} if sound else only(found, {"matches_truth"})


@given(which=BOTH, factor=OTHER_SCALES, offset=st.floats(-3.0, 3.0))
def test_a_reader_loses_points_once_for_another_scale_or_zero(
    which: tuple[int, ...], factor: float, offset: float
) -> None:
    scaled = [(lambda x: factor * x + offset) if sensor in which else np.array for sensor in (0, 1)]
    assert only(deducted(READING, get_imu_readings=altered(*scaled)), {"matches_truth"})


# --- recordings -------------------------------------------------------------------------------------------------------


def recorded(change: Callable[[Array, Array, Array, float], tuple[Any, Any, Any]]) -> dict[str, float]:
    """Return what a recorder is charged that changes the sound stamps and rows; the last argument is the time step."""
    kind = telling(lambda t, a, g, model: change(t, a, g, model.opt.timestep))
    return deducted(RECORDING, simulate_and_collect=function(kind()))


@given(late=st.integers(1, 40))
def test_rows_that_are_late_lose_points_once_however_late_they_are(late: int) -> None:
    found = recorded(lambda t, a, g, _dt: (t, np.roll(a, late, axis=0), np.roll(g, late, axis=0)))
    assert only(found, {"matches_truth"})


@given(first=st.integers(2, 100), own_stamps=st.booleans())
def test_a_recording_without_its_first_steps_loses_points_once(first: int, own_stamps: bool) -> None:
    found = recorded(lambda t, a, g, _dt: (t[first:] if own_stamps else t[:-first], a[first:], g[first:]))
    assert only(found, {"matches_truth"})


@given(every=st.integers(2, 40))
def test_thinned_rows_lose_points_once_however_thin_they_are(every: int) -> None:
    found = recorded(lambda t, a, g, _dt: (t[::every], a[::every], g[::every]))
    assert only(found, {"matches_truth", "sample_count"})


@given(steps=st.integers(-50, 50))
def test_stamps_are_right_from_the_start_or_the_end_of_the_first_step_alone(steps: int) -> None:
    found = recorded(lambda t, a, g, dt: (t + steps * dt, a, g))
    assert found == {} if steps in (-1, 0) else only(found, {"time_axis"})


@given(which=BOTH, order=ORDERS, signs=SIGNS)
def test_recorded_axes_in_another_order_or_of_another_sign_lose_points_once(
    which: tuple[int, ...], order: list[int], signs: Array
) -> None:
    found = recorded(
        lambda t, a, g, _dt: (t, *(x[:, order] * signs if i in which else x for i, x in enumerate((a, g))))
    )
    sound = order == [0, 1, 2] and bool((signs > 0).all())
    assert found == {} if sound else only(found, {"matches_truth"})


# --- noise ------------------------------------------------------------------------------------------------------------


@given(which=BOTH, factor=OTHER_SCALES)
def test_noise_of_another_size_loses_points_once_whatever_its_size(which: tuple[int, ...], factor: float) -> None:
    noise = of(noise=lambda self, i: Sound.noise(self, i) * (factor if i in which else 1.0))
    assert only(deducted(NOISE, NoisyIMU=noise), {"noise_size"})


@given(which=BOTH, share=st.floats(0.3, 3.0), signs=SIGNS)
def test_an_offset_beside_the_bias_loses_points_once_whatever_its_size(
    which: tuple[int, ...], share: float, signs: Array
) -> None:
    beside = of(one=lambda self, i: Sound.one(self, i) + (share * (0.1, 0.01)[i] * signs if i in which else 0.0))
    assert only(deducted(NOISE, NoisyIMU=beside), {"given_bias", "white_and_gaussian", "noise_size"})


@given(seed=st.integers(0, 2**31))
def test_sound_noise_keeps_all_points_whatever_is_drawn(seed: int) -> None:
    drawn = of(seed=lambda self: setattr(self, "rng", np.random.default_rng((seed, np.random.randint(0, 2**31)))))
    assert deducted(NOISE, NoisyIMU=drawn) == {}


# --- filters ----------------------------------------------------------------------------------------------------------


@given(power=st.floats(0.2, 0.9) | st.floats(1.1, 3.0))
def test_a_mean_with_another_alpha_loses_points_once_whatever_it_is(power: float) -> None:
    found = deducted(FILTERING, LowPassFilter=weighted(lambda alpha: alpha**power, lambda alpha: 1 - alpha**power))
    assert only(found, {"follows_recursion"})


@given(gain=st.floats(0.3, 0.97) | st.floats(1.005, 1.05))
def test_a_filter_whose_weights_do_not_sum_to_one_loses_points_once(gain: float) -> None:
    found = deducted(FILTERING, LowPassFilter=weighted(lambda alpha: gain * alpha, lambda alpha: 1 - alpha))
    assert only(found, {"follows_recursion", "passes_constant", "preserves_signal"})


def test_what_is_sound_loses_nothing() -> None:
    """Else the properties above could hold of anything."""
    assert recorded(lambda t, a, g, _dt: (t, a, g)) == {}
    assert deducted(FILTERING, LowPassFilter=weighted(lambda alpha: alpha, lambda alpha: 1 - alpha)) == {}
