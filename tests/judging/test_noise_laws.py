"""Which law noise has, and whether a bias stays, by reads that are made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import special

from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import noise_laws as laws
from grader.labs.imu.diagnosis.noise import Facts

pytestmark = pytest.mark.quick
_READS, _STD = 1250, 0.05
_RNG = np.random.default_rng(21)
_WHITE = _RNG.normal(size=(2, _READS, 3))
_WALK = np.cumsum(_WHITE, axis=1)
_BIAS = np.array([0.3, -0.2, 0.4])
_QUANTILES = special.ndtri((np.arange(_READS) + 0.5) / _READS)
_NORMAL = np.stack([_RNG.permutation(_QUANTILES) for _ in range(6)], axis=1).reshape(_READS, 2, 3).swapaxes(0, 1)
"""Normal as nearly as so many values can be."""
_STILL = np.zeros_like(_WHITE)


def _of(noise: Array, std: float = _STD) -> Facts:
    return Facts(_BIAS + std * noise, np.ones((2, 3)), std, _BIAS)


def _remembering(share: float, lag: int = 1) -> Array:
    series = _WHITE.copy()
    for n in range(lag, _READS):
        series[:, n] += share * series[:, n - lag]
    return series


@pytest.mark.parametrize(
    ("series", "drifts"),
    [(_WALK, True), (_WHITE, False), (_STILL, False), (_remembering(0.8), True), (_remembering(0.3), False),
     (_WALK[:, :100], True), (-_WALK + 100, True)],
)  # fmt: skip
def test_reads_that_move_by_little_against_what_they_move_by_in_the_end_drift(series: Array, drifts: bool) -> None:
    assert laws.drifts(_of(series)) is drifts


_INSTANCES = _RNG.normal(size=(24, 1, 3))


def _creeping(step: float) -> Array:
    """Three reads of each instance, of which each is a step further on."""
    between = np.sqrt(np.mean(np.var(_INSTANCES[:, 0], axis=0)))
    return np.asarray(_INSTANCES + step * between * np.arange(3)[None, :, None])


@pytest.mark.parametrize(
    ("biases", "creeps"),
    [
        (_creeping(0), False),
        (_creeping(0.01), True),
        (_creeping(-0.01), True),
        (_creeping(0.29), True),
        (_creeping(0.31), False),
        (_creeping(1.4), False),
        (_creeping(0.01) + 1e8, False),
        (_creeping(0.01) - 1e8, False),
        (1e-8 * _creeping(0.01), False),
        (1e-6 * _creeping(0.01), True),
        (np.tile(_INSTANCES[:, :, :1], (1, 3, 3)) + 0.01 * np.arange(3)[None, :, None], True),
        (np.tile([1.0, 5, 9], (24, 3, 1)) + 0.01 * np.arange(3)[None, :, None], False),
        (np.tile(_INSTANCES[:1], (24, 3, 1)) + np.arange(3)[None, :, None], False),
    ],
)
def test_biases_creep_that_move_by_little_against_how_they_differ(biases: Array, creeps: bool) -> None:
    assert laws.creeps(biases) == creeps


def test_steadied_reads_have_the_noise_and_not_the_drift() -> None:
    drift = 0.5 * _WALK
    steady, white = laws.steadied(_of(_NORMAL + drift), _of(drift)), _of(_NORMAL)
    assert steady.residual.shape == (2, _READS // 2, 3)
    assert steady.pooled_spread == pytest.approx(white.pooled_spread, rel=0.04)
    assert steady.offset.mean(axis=0) == pytest.approx(_BIAS, abs=0.01)
    assert laws.steadied(_of(_NORMAL), _of(_STILL)).pooled_spread == pytest.approx(_STD, rel=0.04)
    assert laws.steadied(_of(_STILL), _of(_STILL)).pooled_spread == pytest.approx(0, abs=1e-12)
    halved = laws.steadied(_of(_NORMAL), _of(_NORMAL))
    assert halved.pooled_spread == pytest.approx(0.5 * laws.paired(_of(_NORMAL)).pooled_spread)


def test_pairs_share_no_read_and_leave_the_odd_one_out() -> None:
    reads = np.array([1.0, 4, 10, 8, 7])[None, :, None] * np.ones((2, 1, 3))
    paired = laws.paired(replace(_of(_WHITE), residual=reads))
    assert (paired.residual - _BIAS)[0, :, 0] * 2**0.5 == pytest.approx([3, -2])
    even = laws.paired(replace(_of(_WHITE), residual=reads[:, :4]))
    assert (even.residual - _BIAS)[1, :, 2] * 2**0.5 == pytest.approx([3, -2])


_BOUND = st.correlation_bound(_READS)


@pytest.mark.parametrize(
    ("series", "correlated"),
    [
        (_WHITE, False),
        (_remembering(0.3), True),
        (_remembering(-0.3), True),
        (_remembering(0.3, 2), True),
        (_remembering(-0.3, 3), True),
        (_remembering(0.3, 4), False),
        (np.stack([_remembering(0.3)[0], _WHITE[1]]), True),
        (np.stack([_WHITE[0], _remembering(0.3)[1]]), True),
        (_WHITE * [1, 0, 1] + _remembering(0.3) * [0, 1, 0], True),
        (_WALK, False),
        (_STILL, False),
    ],
)
def test_reads_are_correlated_that_depend_on_one_of_the_three_before(series: Array, correlated: bool) -> None:
    assert laws.correlated(_of(series)) == correlated


def test_the_correlation_is_the_largest_of_all_channels_without_its_sign() -> None:
    assert laws.correlation(_of(_remembering(-0.5)), 1) == pytest.approx(0.5, abs=0.06)
    assert laws.correlation(_of(_remembering(-0.5)), 2) == pytest.approx(0.25, abs=0.09)
    assert laws.correlation(_of(_STILL), 1) == 0


def test_the_innovation_is_what_is_new_in_a_read() -> None:
    for share in (0.6, -0.6, 0.0):
        facts = _of(_remembering(share))
        assert laws.innovation(facts) == pytest.approx(_STD, rel=0.05)
    assert laws.innovation(_of(_WALK)) < 0.2 * _of(_WALK).pooled_spread


def _drawn_anew_beyond(cut: float) -> Array:
    low = special.ndtr(-cut)
    values = special.ndtri(low + (1 - 2 * low) * (np.arange(_READS) + 0.5) / _READS)
    return np.stack([_RNG.permutation(values) for _ in range(6)], axis=1).reshape(_READS, 2, 3).swapaxes(0, 1)


def _with_one(series: Array, value: float) -> Array:
    changed = series.copy()
    changed[0, 7, 1] = value
    return changed


_FLAT = _drawn_anew_beyond(0.5) / 0.5


@pytest.mark.parametrize(
    ("series", "clipped"),
    [
        (_NORMAL.clip(-2, 2), True),
        (_NORMAL.clip(-1, 1), True),
        (_NORMAL.clip(-2.85, 2.85), True),
        (_NORMAL.clip(-2.95, 2.95), True),
        (_drawn_anew_beyond(2), True),
        (_drawn_anew_beyond(1.2), True),
        (_drawn_anew_beyond(0.8), False),
        (_drawn_anew_beyond(3.2), False),
        (_NORMAL, False),
        (1.06 * _NORMAL.clip(-2, 2), False),
        (1.5 * _NORMAL.clip(-2, 2), False),
        (0.5 * _NORMAL.clip(-2, 2), False),
        (2 * _FLAT, False),
        (_STILL, False),
        (0.5 * _NORMAL.clip(-4, 4), False),
        (_with_one(_NORMAL.clip(-2, 2), -5), False),
        (_with_one(0.5 * _NORMAL, 2.5), False),
        (np.where(np.abs(_NORMAL) > 1.427, 2.5 * np.sign(_NORMAL), 0), False),
    ],
)
def test_noise_is_cut_off_that_is_what_a_normal_law_leaves_within_a_bound(series: Array, clipped: bool) -> None:
    assert laws.clipped(_of(series)) == clipped
    assert laws.clipped(_of(-series)) == clipped


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("count", "again"), [(3, False), (4, True), (6, True)])
def test_four_of_the_extremes_come_again_where_a_bound_cuts_them_off(side: int, count: int, again: bool) -> None:
    series = _WHITE.copy()
    for state, axis in [(state, axis) for state in (0, 1) for axis in range(3)][:count]:
        series[state, :2, axis] = 9 * side
    assert laws._repeats_extremes(_of(series)) == again


def _sized(accel: float, gyro: float) -> list[Facts]:
    return [_of(accel * _NORMAL), _of(gyro * _NORMAL, 0.005)]


_ROOT = 0.002**0.5


@pytest.mark.parametrize(
    ("sensors", "density"),
    [
        (_sized(1 / _ROOT, 1 / _ROOT), True),
        (_sized(_ROOT, _ROOT), True),
        (_sized(1.05 * _ROOT, 0.95 * _ROOT), True),
        (_sized(1.09 * _ROOT, _ROOT), False),
        (_sized(_ROOT, 0.91 * _ROOT), False),
        (_sized(_ROOT, 1 / _ROOT), False),
        (_sized(1, 1), False),
    ],
)
def test_a_density_is_off_by_the_root_of_rate_or_step_on_both_sensors(sensors: list[Facts], density: bool) -> None:
    assert laws.density(sensors, 0.002) == density


def _powered(power: float) -> Array:
    return np.asarray(np.sign(_NORMAL) * np.abs(_NORMAL) ** power)


@pytest.mark.parametrize(
    ("series", "normal"),
    [
        (_NORMAL, True),
        (3 * _NORMAL, True),
        (_NORMAL * [1, 0, 2], True),
        (_NORMAL * [[[1, 1, 1]], [[5, 5, 5]]], True),
        (_STILL, True),
        (_powered(0.8), False),
        (_powered(1.2), False),
        (_powered(1.3) * [0, 0, 1], False),
    ],
)
def test_noise_is_normal_by_its_deviations_on_the_axes_that_have_any(series: Array, normal: bool) -> None:
    assert laws.is_normal(_of(series)) == normal


def test_living_noise_is_that_of_the_axes_that_move() -> None:
    assert laws.living(_of(_NORMAL * [1, 0, 2])).size == 4 * _READS
    assert laws.living(_of(_NORMAL * [1, 0, 2])).std() == pytest.approx(1)
    assert laws.living(_of(_STILL)).size == 0


def _with_strays(share: float, off: float, others: Array = _NORMAL) -> Facts:
    far = np.arange(_READS) % round(1 / share) == 0
    return _of(others + off * far[None, :, None])


@pytest.mark.parametrize(
    ("facts", "count"),
    [
        (_of(_NORMAL), None),
        (_with_strays(0.01, 40.0), 78),
        (_with_strays(0.05, -40.0), 378),
        (_with_strays(0.01, 11.0), 78),
        (_with_strays(1 / 3, 40.0), None),
        (_with_strays(0.5, 40.0), None),
        (_with_strays(0.01, 40.0, _RNG.uniform(-1, 1, (2, _READS, 3))), None),
        (_of(_STILL), None),
    ],
)
def test_values_far_beyond_a_normal_law_are_counted_where_the_others_have_it(facts: Facts, count: int | None) -> None:
    strays = laws.strays(facts)
    assert (strays and strays.count) == count
    assert strays is None or strays.spread == pytest.approx(_STD, rel=0.02)


def test_strays_of_one_axis_leave_the_axes_that_stand_still() -> None:
    noise = _NORMAL * [1, 0, 0]
    noise[:, 7, 0] = 30.0
    strays = laws.strays(_of(noise))
    assert strays is not None
    assert strays.count == 2
