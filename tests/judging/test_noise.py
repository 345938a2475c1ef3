"""What is told of a noise model's reads, by reads whose mean and spread are exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import noise
from grader.labs.imu.diagnosis.noise import Facts

pytestmark = pytest.mark.quick
_READS, _ROUNDING, _ATOL = 600, 1e-9, 1e-5
_AXES = np.eye(3)
_NO_BIAS = np.zeros(3)


def _standard(series: Array) -> Array:
    """(states, reads, 3) with a mean of zero and a spread of one on every axis in every state."""
    centred = series - series.mean(axis=1, keepdims=True)
    return np.asarray(centred / centred.std(axis=1, keepdims=True))


_RNG = np.random.default_rng(5)
_WHITE, _OTHER = _standard(_RNG.normal(size=(2, _READS, 3))), _standard(_RNG.normal(size=(2, _READS, 3)))
_WALK = _standard(np.cumsum(_WHITE, axis=1))
_SLOW = np.zeros_like(_WHITE)
for _n in range(1, _READS):
    _SLOW[:, _n] = 0.94 * _SLOW[:, _n - 1] + _WHITE[:, _n]
_EVEN = np.tile(np.linspace(-1, 1, _READS)[None, :, None], (2, 1, 3))
_STILL = np.zeros_like(_WHITE)
_POSITIVE = np.abs(_WHITE) - np.abs(_WHITE).min(axis=(0, 1))
ACCEL = Facts(
    0.05 * _WHITE + [0.3, -0.2, 0.4], np.array([[0.5, -0.9, 9.6], [1.2, 0.4, -9.1]]), 0.05, np.array([0.3, -0.2, 0.4])
)
GYRO = Facts(
    0.005 * _OTHER + [-0.03, 0.05, 0.02], np.array([[0.2, -0.1, 0.5], [-0.3, 0.4, 0.06]]), 0.005,
    np.array([-0.03, 0.05, 0.02]),
)  # fmt: skip


def _of(noise_: Array, facts: Facts = ACCEL) -> Facts:
    """The facts with other noise, in units of the size asked for."""
    return replace(facts, residual=facts.bias + facts.std * noise_)


def _reading(readings: Array) -> Facts:
    return replace(ACCEL, residual=readings - ACCEL.truth[:, None, :])


_READ = ACCEL.residual + ACCEL.truth[:, None, :]
_HALF = _READ.astype(np.float16).astype(float)


@pytest.mark.parametrize(
    ("readings", "grain"),
    [
        (_READ, 0.0),
        (_READ.round(1), 0.1),
        (_READ.round(2), 0.01),
        (_READ.round(3), 0.001),
        (_READ.round(4), 0.0001),
        (_READ.round(5), 0.0),
        (_READ.round(1) + 0.006, 0.001),
        ((_READ / 0.005).round() * 0.005, 0.005),
        ((_READ * 256).round() / 256, 1 / 256),
        ((_READ / 0.00007).round() * 0.00007, 0.0),
        (_READ.round(1) + 2e-9, 0.0),
        (_HALF, 2.0**-7),
        (_HALF - 1e-5, 0.0),
        (_HALF + 1e-5, 0.0),
        (np.full_like(_READ, 0.5), 0.0),
    ],
)
def test_the_grain_is_that_of_the_last_digit_of_noisy_reads(readings: Array, grain: float) -> None:
    assert _reading(readings).grain == pytest.approx(grain)


@pytest.mark.parametrize("grain", [0.1, 0.01, 0.001, 0.0001])
def test_the_grain_is_a_decimal_where_no_two_reads_are_as_near(grain: float) -> None:
    reads = np.random.default_rng(3).choice([0, 3, 10, 22, 47], _READ.shape)
    assert _reading(9.0 + grain * reads).grain == grain


def test_reads_that_are_all_alike_are_nowhere_near_each_other() -> None:
    assert noise._closest(np.full(9, 3.0)) == 0


def test_the_grain_of_half_precision_is_that_of_the_largest_number_whatever_its_sign() -> None:
    truth = np.array([[0.5, -0.9, -9.6], [1.2, 0.4, -9.1]])
    residual = (truth[:, None, :] + 0.05 * _WHITE).astype(np.float16) - truth[:, None, :]
    assert replace(ACCEL, residual=residual, truth=truth).grain == 2.0**-7


def test_reads_that_differ_by_rounding_alone_are_still() -> None:
    assert _of(0.5 * _ROUNDING * _WHITE).still
    for moving in (2 * _ROUNDING * _WHITE, _WHITE * _AXES[0]):
        assert not _of(moving).still
    half = _of(_WHITE * [1, 0, 3]).standardised.std(axis=0)
    assert half == pytest.approx([1, 0, 1])
    assert _of(_WHITE * [1, 2 * _ROUNDING, 0.5 * _ROUNDING]).standardised.std(axis=0) == pytest.approx(
        [1, 1, 0], abs=0.01
    )
    assert (_of(_WHITE * [[[2, 1, 1]], [[1, 1, 1]]]).pooled_spread / ACCEL.std) ** 2 == pytest.approx(9 / 6)


@pytest.mark.parametrize(
    ("series", "adds_up"),
    [(_WALK, True), (_WHITE, False), (_SLOW, True), (_STILL, False), (_WALK * _AXES[0] + _WHITE * _AXES[1], False),
     (np.stack([_WALK[0], _WHITE[1]]), False)],
)  # fmt: skip
def test_reads_that_hardly_differ_from_the_one_before_add_up(series: Array, adds_up: bool) -> None:
    assert noise.accumulates(_of(series)) == adds_up


@pytest.mark.parametrize(
    ("series", "one"),
    [
        (_POSITIVE, True),
        (-_POSITIVE, True),
        (_POSITIVE + 0.9 * _ATOL / ACCEL.std, True),
        (_POSITIVE - 0.9 * _ATOL / ACCEL.std, True),
        (0.9 * _ATOL / ACCEL.std - _POSITIVE, True),
        (_POSITIVE - 1.1 * _ATOL / ACCEL.std, False),
        (1.1 * _ATOL / ACCEL.std - _POSITIVE, False),
        (_POSITIVE + 0.04 * 0.6, True),
        (-_POSITIVE - 0.04 * 0.6, True),
        (_POSITIVE + 0.06 * 0.6, False),
        (-_POSITIVE - 0.06 * 0.6, False),
        (_POSITIVE + 0.06 * _AXES[1], False),
        (-_POSITIVE - 0.06 * _AXES[0], False),
        (_POSITIVE * [1, 1, -1], False),
        (_POSITIVE * [1, 1, 0] + _WHITE * _AXES[2], False),
        (_WHITE, False),
        (_STILL, False),
    ],
)
def test_noise_of_one_sign_begins_at_the_truth(series: Array, one: bool) -> None:
    assert _POSITIVE.std() == pytest.approx(0.6, abs=0.02)
    assert noise.one_signed(_of(series)) == one


@pytest.mark.parametrize(
    ("series", "even"),
    [
        (_EVEN, True),
        (1.04 * _EVEN, True),
        (0.96 * _EVEN, True),
        (1.06 * _EVEN, False),
        (0.94 * _EVEN, False),
        (_EVEN * 3**0.5, False),
        (np.where(_EVEN < -0.99, -1.1, _EVEN), False),
        (np.sign(_EVEN), False),
        (np.sign(_EVEN) * np.abs(_EVEN) ** 0.7, False),
        (np.sign(_EVEN) * np.abs(_EVEN) ** 1.4, False),
        (_WHITE / np.abs(_WHITE).max(), False),
    ],
)
def test_even_noise_within_its_size_takes_that_for_a_half_width(series: Array, even: bool) -> None:
    assert noise.half_width_is_std(_of(series)) == even


def _bounds(values: int, means: int) -> tuple[float, float]:
    """The smallest and the largest ratio of spread and standard deviation that is right."""
    low, high = st.spread_bounds(values, means)
    return low - noise.SIZE_TOLERANCE, high + noise.SIZE_TOLERANCE


_POOLED, _EACH = _bounds(6 * _READS, 6), _bounds(2 * _READS, 2)


@pytest.mark.parametrize(
    ("size", "right"),
    [
        (1.0, True),
        (_POOLED[0] + 1e-6, True),
        (_POOLED[0] - 1e-6, False),
        (_POOLED[1] - 1e-6, True),
        (_POOLED[1] + 1e-6, False),
        ([_EACH[0] + 1e-6, 1, 1], True),
        ([_EACH[0] - 1e-6, 1, 1], False),
        ([1, _EACH[1] - 1e-6, 1], True),
        ([1, 1, _EACH[1] + 1e-6], False),
    ],
)
def test_the_size_of_noise_is_right_as_far_as_chance_goes(size: Array, right: bool) -> None:
    assert noise.size_is_right(_of(np.array(size) * _WHITE)) == right


@pytest.mark.parametrize(
    ("size", "right"),
    [
        (_POOLED[0] - 0.04, True),
        (_POOLED[0] - 0.06, False),
        (_POOLED[1] + 0.04, True),
        (_POOLED[1] + 0.06, False),
        ([1, 1, _EACH[1] + 0.04], True),
        ([1, 1, _EACH[1] + 0.06], False),
    ],
)
def test_a_tolerance_widens_what_chance_allows(size: Array, right: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise, "SIZE_TOLERANCE", 0.05)
    assert noise.size_is_right(_of(np.array(size) * _WHITE)) == right


@pytest.mark.parametrize(
    ("series", "right"),
    [(1.05 * _WHITE, True), (1.16 * _WHITE, True), (0.84 * _WHITE, True), (1.22 * _WHITE, False), (0.78 * _WHITE, False),
     (_WHITE * [0.82, 1.1, 1.1], True), (_WHITE * [1.2, 1, 1], True), (_WHITE * [1.3, 0.9, 0.9], False)],
)  # fmt: skip
def test_rounding_adds_half_a_grain_to_a_spread(series: Array, right: bool) -> None:
    rounded = _reading((_of(series).residual + ACCEL.truth[:, None, :]).round(2))
    assert rounded.grain == 0.01
    assert noise.size_is_right(rounded) == right


def test_of_a_spread_that_is_known_otherwise_the_axes_say_nothing() -> None:
    lopsided = _of(_WHITE * [2, 1, 1])
    assert not noise.size_is_right(lopsided)
    assert noise.size_is_right(lopsided, ACCEL.std)
    assert not noise.size_is_right(ACCEL, 2 * ACCEL.std)


_SIZES = np.abs(ACCEL.truth)[:, None, :]


@pytest.mark.parametrize(
    ("facts", "goes_with"),
    [
        (_of(_SIZES * _WHITE), True),
        (_of(_WHITE), False),
        (_of(_STILL), False),
        (_of((_SIZES + 3) * _WHITE), False),
        (_of(_SIZES * _WHITE * [1, 1.1, 0.9]), True),
        (_of(_SIZES * _WHITE * [1, 1.2, 0.8]), False),
        (replace(_of(_WHITE), truth=np.array([[1, -1, 1.05], [1.05, 0.95, 0.95]])), False),
        (replace(_of([1, 2, 1] * _WHITE), truth=np.array([[1.0, -2, 1], [-1, 2, 1]])), False),
        (replace(_of([2, 3, 4] * _WHITE), truth=np.array([[2.0, -3, 4], [-2, 3, 4]])), True),
        (replace(_of([10, 11, 12] * _WHITE), truth=np.array([[10.0, -11, 12], [-10, 11, 12]])), False),
    ],
)
def test_noise_goes_with_the_reading(facts: Facts, goes_with: bool) -> None:
    assert noise.proportional(facts) == goes_with


def _still(facts: Facts, offset: Array) -> Facts:
    """The same offset (3,) or (states, 3) on every read."""
    offsets = np.broadcast_to(offset, (2, 3))
    return replace(facts, residual=np.repeat(offsets[:, None, :], _READS, axis=1))


def _noiseless(facts: Facts) -> Facts:
    return replace(_still(facts, _NO_BIAS), bias=_NO_BIAS)


def _sized(accel: float, gyro: float) -> list[Facts]:
    """Both sensors with noise so many times as large as it was asked for."""
    return [_of(accel * _WHITE), _of(gyro * _OTHER, GYRO)]


def _unasked(accel: float, gyro: float) -> list[Facts]:
    """Both without a bias, and noise of this size in m/s² and rad/s where none was asked for."""
    return [
        replace(ACCEL, residual=accel * _WHITE, bias=_NO_BIAS), replace(GYRO, residual=gyro * _OTHER, bias=_NO_BIAS),
    ]  # fmt: skip


_OBEYING = [_noiseless(ACCEL), _noiseless(GYRO)]
_DRAWN = [_still(ACCEL, ACCEL.bias + 0.04), _still(GYRO, np.subtract(GYRO.bias, [0.004, 0.002, 0]))]
_APART = 2 * st.Z * ACCEL.std


def _moved(facts: Facts, by: float) -> Facts:
    """Still in each state, and so far apart in the second one."""
    return _still(facts, facts.bias + [0.02, 0, 0] + np.array([[0.0], [by]]) * _AXES[1])


@pytest.mark.parametrize(
    ("sensors", "again", "silent", "told"),
    [
        ([_still(ACCEL, ACCEL.bias), _still(GYRO, GYRO.bias)], None, _OBEYING, ["no-noise"]),
        ([_still(ACCEL, _NO_BIAS), _still(GYRO, GYRO.bias)], None, _OBEYING, ["no-noise"]),
        ([_still(ACCEL, ACCEL.bias + 0.9 * _ATOL), _still(GYRO, [0, -0.9 * _ATOL, 0])], None, _OBEYING, ["no-noise"]),
        ([_still(ACCEL, ACCEL.bias), _still(GYRO, 2 * GYRO.bias)], None, _OBEYING, ["reseeded"]),
        ([_still(f, f.bias + f.std) for f in (ACCEL, GYRO)], None, _OBEYING, ["no-noise"]),
        ([_still(f, f.bias - 0.4 * f.std) for f in (ACCEL, GYRO)], None, _OBEYING, ["no-noise"]),
        ([_still(f, f.bias + f.std + 0.9 * _ATOL * _AXES[0]) for f in (ACCEL, GYRO)], None, _OBEYING, ["no-noise"]),
        ([_still(ACCEL, ACCEL.bias + ACCEL.std), _still(GYRO, GYRO.bias - GYRO.std)], None, _OBEYING, ["reseeded"]),
        (_DRAWN, None, _OBEYING, ["reseeded"]),
        (_DRAWN, [_still(ACCEL, ACCEL.bias - 0.04), _DRAWN[1]], _OBEYING, ["frozen-noise"]),
        (_DRAWN, [_DRAWN[0], _still(GYRO, GYRO.bias + 1e-5)], _OBEYING, ["frozen-noise"]),
        ([_moved(ACCEL, 0.99 * _APART), _DRAWN[1]], None, _OBEYING, ["reseeded"]),
        ([_moved(ACCEL, 1.01 * _APART), _DRAWN[1]], None, _OBEYING, []),
        ([_moved(ACCEL, -1.01 * _APART), _DRAWN[1]], [_DRAWN[0], _DRAWN[1]], _OBEYING, []),
        ([ACCEL, _still(GYRO, GYRO.bias)], None, _OBEYING, ["gyro-not-noisy"]),
        ([_still(ACCEL, ACCEL.bias), GYRO], None, _OBEYING, ["gyro-not-noisy"]),
        ([ACCEL, _still(GYRO, GYRO.bias)], None, _unasked(0.05, 0.01), ["gyro-not-noisy"]),
        ([ACCEL, _still(GYRO, GYRO.bias)], [ACCEL, _still(GYRO, GYRO.bias + 1)], _OBEYING, ["gyro-not-noisy"]),
        ([_of(_SIZES * _WHITE), GYRO], None, _OBEYING, ["multiplicative-noise"]),
        ([_of(_SIZES * _WHITE), GYRO], None, _unasked(0.5, 0.005), ["multiplicative-noise"]),
        ([ACCEL, _of(np.abs(GYRO.truth)[:, None, :] * _OTHER, GYRO)], None, _OBEYING, ["multiplicative-noise"]),
        ([_of(_SIZES * _WHITE), _still(GYRO, GYRO.bias)], None, _OBEYING, ["gyro-not-noisy"]),
        (_sized(3, 3), None, _unasked(0.15, 0.015), ["std-ignored"]),
        (_sized(3, 3), None, [_noiseless(ACCEL), _unasked(0.15, 0.015)[1]], ["std-ignored"]),
        (_sized(3, 3), None, _unasked(0.1, 0.01), []),
        (_sized(0.1, 10), None, _OBEYING, ["stds-swapped"]),
        (_sized(0.1, 1), None, _OBEYING, ["stds-swapped"]),
        (_sized(1, 10.6), None, _OBEYING, ["stds-swapped"]),
        (_sized(0.1, 3), None, _OBEYING, []),  # the other sensor's noise has another cause
        (_sized(3, 10.6), None, _OBEYING, []),
        (_sized(3, 10.8), None, _OBEYING, []),
        (_sized(3, 9.2), None, _OBEYING, []),
        (_sized(0.1, 10), None, _unasked(0.005, 0.05), ["std-ignored"]),
        (_sized(0.05, 0.005), None, _OBEYING, ["variance-as-std"]),
        (_sized(0.05**-0.5, 0.005**-0.5), None, _OBEYING, ["variance-as-std"]),
        (_sized(0.05, 1), None, _OBEYING, ["variance-as-std"]),
        (_sized(0.05, 1.5), None, _OBEYING, []),
        (_sized(0.05, 0.005), None, _unasked(0.0025, 0.000025), ["std-ignored"]),
        # The root of the gyroscope's standard deviation, 0.0025, is the accelerometer's.
        ([_of(0.05**-0.5 * _WHITE), _of(20 * _OTHER, replace(GYRO, std=0.0025))], None, _OBEYING, ["variance-as-std"]),
        ([_of(_WHITE), _of(20 * _OTHER, replace(GYRO, std=0.0025))], None, _OBEYING, []),  # either may be meant
        (_sized(1, 1), None, _OBEYING, []),
        (_sized(1.5, 1.5), None, _OBEYING, []),
    ],
)  # fmt: skip
def test_a_wrong_size_of_the_noise_is_named(
    sensors: list[Facts], again: list[Facts] | None, silent: list[Facts], told: list[str]
) -> None:
    assert noise.size_mistakes(sensors, sensors if again is None else again, silent) == told


def _now_and_then(share: float) -> list[Facts]:
    """Reads that were asked for no noise, of which a share is another one."""
    others = np.random.default_rng(8).random((2, _READS, 1)) < share
    return [replace(f, residual=f.bias + others * (f.residual - f.bias)) for f in _unasked(0.05, 0.005)]


@pytest.mark.parametrize(
    ("sensors", "silent", "redrawn"),
    [
        (_sized(1, 1), _OBEYING, False),
        (_sized(1.1, 1.1), _unasked(0.05, 0.005), False),
        (_sized(1.1, 1.15), _unasked(0.05, 0.005), True),
        (_sized(1.15, 9), [_unasked(0.05, 0.005)[0], _noiseless(GYRO)], True),
        (_sized(1.1, 9), [_unasked(0.05, 0.005)[0], _noiseless(GYRO)], False),
        (_sized(3, 3), _now_and_then(0.02), False),
        (_sized(3, 3), _now_and_then(0.4), True),
    ],
)
def test_a_bias_is_redrawn_where_noise_comes_on_top(sensors: list[Facts], silent: list[Facts], redrawn: bool) -> None:
    assert noise.bias_is_redrawn(sensors, silent) == redrawn


def _off(facts: Facts, offset: Array) -> Facts:
    """The same reads with an exact mean of (3,) or (states, 3)."""
    return replace(facts, residual=facts.residual - facts.bias + np.broadcast_to(offset, (2, 3))[:, None, :])


_BOUND = {facts.std: st.mean_bound(_READS, facts.std) + _ATOL for facts in (ACCEL, GYRO)}
_BOTH_BOUND = st.mean_bound(2 * _READS, ACCEL.std) + _ATOL


@pytest.mark.parametrize(
    ("facts", "right"),
    [
        (ACCEL, True),
        (_off(ACCEL, ACCEL.bias + 0.999 * _BOTH_BOUND * _AXES[2]), True),
        (_off(ACCEL, ACCEL.bias + 1.001 * _BOTH_BOUND * _AXES[2]), False),
        (_off(ACCEL, ACCEL.bias - 1.001 * _BOTH_BOUND * _AXES[0]), False),
        (_off(ACCEL, ACCEL.bias + np.outer([1, -1], 0.999 * _BOUND[ACCEL.std] * _AXES[1])), True),
        (_off(ACCEL, ACCEL.bias + np.outer([1, -1], 1.001 * _BOUND[ACCEL.std] * _AXES[1])), False),
        (_off(_of(3 * _WHITE), ACCEL.bias + 2 * _BOTH_BOUND), True),
        (_off(_of(0.1 * _WHITE), ACCEL.bias + 0.9 * _BOTH_BOUND), True),
        (replace(_off(_of(1e-4 * _WHITE), ACCEL.bias + 0.99 * _ATOL + 6.7e-7), std=1e-9), True),
        (_still(ACCEL, ACCEL.bias + st.Z * ACCEL.std + 0.9 * _ATOL), True),
        (_still(ACCEL, ACCEL.bias - st.Z * ACCEL.std - 1.1 * _ATOL), False),
        (replace(_still(ACCEL, ACCEL.bias + 0.9 * _ATOL), std=1e-9), True),
        (replace(_still(ACCEL, ACCEL.bias + 1.1 * _ATOL), std=1e-9), False),
        (replace(_reading(_READ.round(2)), bias=ACCEL.bias - 0.0142), True),
        (replace(_reading(_READ.round(2)), bias=ACCEL.bias - 0.0155), False),
    ],
)
def test_the_bias_is_right_where_it_is_the_mean_as_far_as_chance_goes(facts: Facts, right: bool) -> None:
    assert noise.bias_is_right(facts) == right


def _wrong(accel: Array | None = None, gyro: Array | None = None) -> list[Facts]:
    """Both sensors with these means, or the given bias."""
    means = zip((ACCEL, GYRO), (accel, gyro), strict=True)
    return [facts if mean is None else _off(facts, mean) for facts, mean in means]


def _first_again(facts: Facts) -> Array:
    return facts.truth[0] + facts.bias - facts.truth


_OTHERS = [GYRO.truth - ACCEL.truth + ACCEL.bias, ACCEL.truth - GYRO.truth + GYRO.bias]
_SLIGHT = 0.85 * _BOUND[ACCEL.std] * _AXES[0]


@pytest.mark.parametrize(
    ("sensors", "told"),
    [
        (_wrong(), []),
        (_wrong(_NO_BIAS, _NO_BIAS), ["no-bias"]),
        (_wrong(_NO_BIAS), ["no-bias"]),
        (_wrong(gyro=_NO_BIAS), ["no-bias"]),
        ([replace(_off(ACCEL, _NO_BIAS), bias=_SLIGHT), GYRO], ["no-bias"]),
        (_wrong(-ACCEL.bias, -GYRO.bias), ["bias-sign-flipped"]),
        (_wrong(-ACCEL.bias, _NO_BIAS), []),
        ([_off(_of(3 * _WHITE), 2 * _BOUND[ACCEL.std] - ACCEL.bias), GYRO], ["bias-sign-flipped"]),
        ([replace(_still(ACCEL, 0.9 * _ATOL - ACCEL.bias), std=1e-9), GYRO], ["bias-sign-flipped"]),
        (_wrong(gyro=-GYRO.bias), ["bias-sign-flipped"]),
        (_wrong(_first_again(ACCEL), _first_again(GYRO)), ["stale-clean-reading"]),
        (_wrong(gyro=_first_again(GYRO)), ["stale-clean-reading"]),
        (_wrong(_first_again(ACCEL) - 1), []),
        (_wrong(*_OTHERS), ["swapped-sensors"]),
        (_wrong(_OTHERS[0]), []),
        (_wrong(_OTHERS[0], GYRO.bias + 1), []),
        (_wrong(GYRO.bias, ACCEL.bias), ["biases-exchanged"]),
        (_wrong(GYRO.bias), ["bias-shared"]),
        (_wrong(gyro=ACCEL.bias), ["bias-shared"]),
        (_wrong(GYRO.bias, GYRO.bias + 1), ["bias-shared"]),
        (_wrong(ACCEL.bias[[1, 0, 2]], GYRO.bias[[2, 0, 1]]), ["bias-axes-exchanged"]),
        (_wrong(gyro=GYRO.bias[[0, 2, 1]]), ["bias-axes-exchanged"]),
        (_wrong(ACCEL.bias + 0.9 * _BOUND[ACCEL.std] * _AXES[2]), ["noise-not-zero-mean"]),
        (_wrong(np.full(3, ACCEL.bias[0]), np.full(3, GYRO.bias[0])), ["bias-shared"]),
        (_wrong(np.full(3, ACCEL.bias[0])), ["bias-shared"]),
        (_wrong(np.full(3, ACCEL.bias[0]), np.add(GYRO.bias, [0.5, 0, 0])), ["bias-argument-ignored"]),
        (_wrong(np.full(3, ACCEL.bias[1])), ["bias-argument-ignored"]),
        (_wrong(ACCEL.bias + 0.5, GYRO.bias + 0.05), ["noise-not-zero-mean"]),
        (_wrong(ACCEL.bias - 0.5), ["noise-not-zero-mean"]),
        (_wrong(ACCEL.bias + 0.5 + 1.9 * _BOUND[ACCEL.std] * _AXES[2]), ["noise-not-zero-mean"]),
        (_wrong(ACCEL.bias + 0.5 + 2.1 * _BOUND[ACCEL.std] * _AXES[2]), ["bias-argument-ignored"]),
        (_wrong(2 * ACCEL.bias, 2 * GYRO.bias), []),
        (_wrong(0.5 * ACCEL.bias, [1, 2, 3]), []),
        (_wrong(np.add(ACCEL.bias, [0.5, 0.1, 0.7]), np.add(GYRO.bias, [0.1, 0, 0])), ["bias-argument-ignored"]),
        (_wrong([[5.0, 6, 7], [5 + 1.9 * _BOUND[ACCEL.std], 6, 7]]), ["bias-argument-ignored"]),
        (_wrong([[5.0, 6, 7], [5 + 2.1 * _BOUND[ACCEL.std], 6, 7]]), []),
    ],
)  # fmt: skip
def test_an_offset_that_is_not_the_bias_is_named(sensors: list[Facts], told: list[str]) -> None:
    assert noise.bias_mistakes(sensors) == told
