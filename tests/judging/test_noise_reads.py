"""What one sensor's reads tell: their mean and spread, the law of their noise, what a read keeps of those before it, and its twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import special

from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array
from grader.labs.imu.noise_model import reads as facts_of
from grader.labs.imu.noise_model.reads import Reads, Twins

pytestmark = pytest.mark.quick
_READS, _ATOL, _STD = 1250, facts_of.TRUTH_ATOL, 0.05
_AXES = np.eye(3)
_RNG = np.random.default_rng(21)


def _standard(series: Array) -> Array:
    """(states, reads, 3) with a mean of zero and a spread of one on every axis in every state."""
    centred = series - series.mean(axis=1, keepdims=True)
    return np.asarray(centred / centred.std(axis=1, keepdims=True))


_RAW = _RNG.normal(size=(2, _READS, 3))
_WHITE, _WALK, _STILL = _standard(_RAW), _standard(np.cumsum(_RAW, axis=1)), np.zeros_like(_RAW)
_QUANTILES = special.ndtri((np.arange(_READS) + 0.5) / _READS)
_NORMAL = np.stack([_RNG.permutation(_QUANTILES) for _ in range(6)], axis=1).reshape(_READS, 2, 3).swapaxes(0, 1)
"""Normal as nearly as so many values can be."""
_POSITIVE = np.abs(_WHITE) - np.abs(_WHITE).min(axis=(0, 1))
_TRUTH, _BIAS = np.array([[0.5, -0.9, 9.6], [1.2, 0.4, -9.1]]), np.array([0.3, -0.2, 0.4])


def _of(noise: Array, std: float = _STD) -> Reads:
    """Reads with this noise, in units of the size asked for."""
    return Reads(_BIAS + std * noise, _TRUTH, std, _BIAS)


def _reading(readings: Array) -> Reads:
    return replace(_of(_STILL), residual=readings - _TRUTH[:, None, :])


_READ = _of(_WHITE).residual + _TRUTH[:, None, :]
_HALF = _READ.astype(np.float16).astype(float)


@pytest.mark.parametrize(
    ("readings", "grain"),
    [
        (_READ, 0.0),
        (_READ.round(4), 0.0001),
        (_READ.round(5), 0.0),
        ((_READ / 0.005).round() * 0.005, 0.005),
        (_READ.round(1) + 2e-9, 0.1),
        (_READ.round(1) + 1e-8 * _READ, 0.0),
        (_HALF, 2.0**-7),
    ],
)
def test_the_grain_is_that_of_the_last_digit_of_noisy_reads(readings: Array, grain: float) -> None:
    assert _reading(readings).grain == pytest.approx(grain)


def _remembering(share: float, lag: int = 1) -> Array:
    series = _RAW.copy()
    for n in range(lag, _READS):
        series[:, n] += share * series[:, n - lag]
    return series


def _drawn_anew_beyond(cut: float) -> Array:
    low = special.ndtr(-cut)
    values = special.ndtri(low + (1 - 2 * low) * (np.arange(_READS) + 0.5) / _READS)
    return np.stack([_RNG.permutation(values) for _ in range(6)], axis=1).reshape(_READS, 2, 3).swapaxes(0, 1)


def _powered(power: float) -> Array:
    return np.asarray(np.sign(_NORMAL) * np.abs(_NORMAL) ** power)


(_LEAST, _MOST), (_LEAST_OF_AXIS, _MOST_OF_AXIS) = st.spread_bounds(6 * _READS, 6), st.spread_bounds(2 * _READS, 2)
_SIZES = np.abs(_TRUTH)[:, None, :]
NOISES: dict[str, tuple[Array, str]] = {
    "white": (_WHITE, "size bias normal"),
    "none": (_STILL, "bias normal"),
    # its size, as far as chance and a tolerance go
    "just large enough": ((_LEAST + 1e-6) * _WHITE, "size bias normal"),
    "too small": ((_LEAST - 1e-6) * _WHITE, "bias normal"),
    "just small enough": ((_MOST - 1e-6) * _WHITE, "size bias normal"),
    "too large": ((_MOST + 1e-6) * _WHITE, "bias normal"),
    "just large enough on one axis": (_WHITE * [_LEAST_OF_AXIS + 1e-6, 1, 1], "size bias normal"),
    "too small on one axis": (_WHITE * [_LEAST_OF_AXIS - 1e-6, 1, 1], "bias normal"),
    "too large on one axis": (_WHITE * [1, 1, _MOST_OF_AXIS + 1e-6], "bias normal"),
    "as large as the reading": (_SIZES * _WHITE, "bias normal proportional"),
    "larger with the reading": ((_SIZES + 3) * _WHITE, "bias normal"),
    "as large as the reading, by another factor on each axis": (_SIZES * _WHITE * [1, 1.2, 0.8], "bias normal"),
    # of one sign it begins at the truth
    "negative": (-_POSITIVE, "normal one_signed"),
    "positive, but for what rounds": (_POSITIVE - 0.9 * _ATOL / _STD, "normal one_signed"),
    "not quite positive": (_POSITIVE - 1.1 * _ATOL / _STD, "normal"),
    "positive, from near the truth on": (_POSITIVE + 0.04 * 0.6, "normal one_signed"),
    "negative, on one axis further from the truth": (-_POSITIVE - 0.06 * 0.6 * _AXES[0], "normal"),
    # its law
    "normal": (_NORMAL, "size bias normal"),
    "normal on two axes": (_NORMAL * [1, 0, 2], "bias normal"),
    "normal, of another size in each state": (_NORMAL * [[[1, 1, 1]], [[5, 5, 5]]], "bias normal"),
    "of thin tails": (_powered(0.8), "bias"),
    "of heavy tails": (_powered(1.2), "bias"),
    "of heavy tails on one axis": (_powered(1.3) * [0, 0, 1], "bias"),
    "cut off at one": (_NORMAL.clip(-1, 1), "bias clipped"),
    "cut off at two": (_NORMAL.clip(-2, 2), "size bias normal clipped"),
    "cut off at nearly three": (_NORMAL.clip(-2.95, 2.95), "size bias normal clipped"),
    "cut off at two, and enlarged": (1.06 * _NORMAL.clip(-2, 2), "size bias normal"),
    "drawn anew beyond 1.2": (_drawn_anew_beyond(1.2), "bias clipped"),
    "drawn anew beyond 0.8": (_drawn_anew_beyond(0.8), "bias"),
    "drawn anew beyond 3.2": (_drawn_anew_beyond(3.2), "size bias normal"),
    # what a read keeps of those before it
    "added up": (_WALK, "bias accumulates drifts"),
    "added up on one axis": (_WALK * _AXES[0] + _WHITE * _AXES[1], "bias normal drifts"),
    "added up in one state": (np.stack([_WALK[0], _WHITE[1]]), "size bias"),
    "added up, at first": (-_WALK[:, :100] + 100, "normal accumulates drifts"),
    "of a long memory": (_remembering(0.8), "bias normal drifts"),
    "of a short memory": (_remembering(0.3), "size bias normal"),
}
"""Noise in units of the size asked for, with what it is."""


@pytest.mark.parametrize(("noise", "told"), NOISES.values(), ids=NOISES)
def test_noise_is_told_by_its_size_its_law_and_its_memory(noise: Array, told: str) -> None:
    reads = _of(noise)
    found = {
        "size": reads.size_is_right, "bias": reads.bias_is_right, "normal": reads.is_normal, "proportional": reads.proportional,
        "one_signed": reads.one_signed, "clipped": reads.clipped, "accumulates": reads.accumulates, "drifts": reads.drifts,
    }  # fmt: skip
    assert {name for name, is_so in found.items() if is_so} == set(told.split())
    assert not replace(reads, truth=np.ones((2, 3))).proportional


@pytest.mark.parametrize(("decimals", "right"), [(2, True), (1, True), (0, False)])
def test_rounding_widens_no_tolerance(decimals: int, right: bool) -> None:
    rounded = _reading(_READ.round(decimals))
    assert rounded.size_is_right == right
    assert not replace(rounded, bias=_BIAS - 0.011).bias_is_right


def _off(offset: Array, noise: Array = _WHITE) -> Reads:
    """Reads with an exact mean of (3,) or (states, 3) beside the bias."""
    return _of(noise + np.broadcast_to(offset, (2, 3))[:, None, :] / _STD)


_BOUND, _BOTH = st.mean_bound(_READS, _STD) + _ATOL, st.mean_bound(2 * _READS, _STD) + _ATOL


@pytest.mark.parametrize(
    ("reads", "right"),
    [
        (_off(0.999 * _BOTH * _AXES[2]), True),
        (_off(1.001 * _BOTH * _AXES[2]), False),
    ],
)
def test_the_bias_is_right_where_it_is_the_mean_as_far_as_chance_goes(reads: Reads, right: bool) -> None:
    assert reads.bias_is_right == right


def test_an_offset_follows_the_truth_that_is_the_same_in_all_states() -> None:
    apart = np.array([[0, 0, 0], [1.0, 0, 0]])
    assert _off(0.5 + 1.9 * _BOUND * apart).keeps_its_offset
    assert not _off(0.5 + 2.1 * _BOUND * apart).keeps_its_offset
    assert _off(0.9 * _BOUND * _AXES[0]).offset_is(_BIAS)
    assert not _off(1.1 * _BOUND * _AXES[0]).offset_is(_BIAS)


@pytest.mark.parametrize(("count", "again"), [(3, False), (4, True)])
def test_four_of_the_extremes_come_again_where_a_bound_cuts_them_off(count: int, again: bool) -> None:
    series = _WHITE.copy()
    for state, axis in [(state, axis) for state in (0, 1) for axis in range(3)][:count]:
        series[state, :2, axis] = 9.0
    assert _of(series)._repeats_extremes() == again


@pytest.mark.parametrize(
    ("noise", "memory"),
    [
        (_remembering(-0.5), 0.5),
        (_remembering(0.3, 3), 0.3),
        (_remembering(0.3, 4), 0),
        (np.stack([_WHITE[0], _remembering(0.5)[1]]), 0.5),
    ],
)
def test_the_memory_is_the_largest_correlation_with_one_of_three_reads_before(noise: Array, memory: float) -> None:
    assert _of(noise).memory == pytest.approx(memory, abs=0.06)


def test_pairs_share_no_read_and_leave_the_odd_one_out() -> None:
    reads = np.array([1.0, 4, 10, 8, 7])[None, :, None] * np.ones((2, 1, 3))
    for residual in (reads, reads[:, :4]):
        paired = replace(_of(_STILL), residual=residual).paired
        assert (paired.residual - _BIAS)[0, :, 0] * 2**0.5 == pytest.approx([3, -2])
    assert _of(_NORMAL + 0.02 * _WALK).paired.pooled_spread == pytest.approx(_STD, rel=0.05)


_COUNT = np.arange(_READS)[None, :, None] * np.ones((2, 1, 3))


@pytest.mark.parametrize(
    ("sequence", "is_noise"),
    [
        (_COUNT, False),
        (1e-6 * _COUNT, False),
        (_COUNT % 2, False),
        (np.sin(_COUNT), False),
        (_RAW[:, _COUNT[0, :, 0].astype(int) % 16], False),
        (_COUNT == 700, False),
        (_RAW > 1.3, False),
        (np.sign(_RAW), True),
        (_remembering(0.9), True),
        (_RAW, True),
    ],
)
def test_what_counts_repeats_or_rarely_happens_is_no_noise(sequence: Array, is_noise: bool) -> None:
    assert _of(sequence.astype(float)).is_noise == is_noise


# --- twins: series from one seed with one thing changed ------------------------------------------------------------------

_SEED = np.random.default_rng(3)
_NOISE = 0.05 * _SEED.normal(size=(40, 3))
_DRIFT = np.cumsum(0.01 * _SEED.normal(size=(40, 3)), axis=0)
_CHANGE = np.array([0.1, -0.4, 0.2])
_BASE = _DRIFT + _NOISE
_TWINS = Twins(_BASE, _BASE, _BASE + _CHANGE, _DRIFT + 3 * _NOISE, _CHANGE, 3.0)
_OTHER_SEED = replace(_TWINS, again=_BASE[::-1])
_FIRST = np.eye(40, 3)[:, :1]
"""One at the first read, nothing after it."""


def _responding(response: Array) -> Twins:
    """Twins without noise, so that what the bias does is exact."""
    still = np.zeros_like(_BASE)
    return replace(_TWINS, base=still, again=still, other=still + response)


@pytest.mark.parametrize(
    ("response", "told"),
    [
        (_CHANGE + 0.9 * _ATOL, "adds begins"),
        (_CHANGE + 1.1 * _ATOL, "begins"),
        (_CHANGE + 0.019, "begins"),
        (_CHANGE - 0.021, ""),
        (_CHANGE * _FIRST, "begins"),
        (_CHANGE * (1 - _FIRST), ""),
        (0 * _CHANGE, "ignores"),
        (_ATOL * _FIRST, "ignores"),
        (-_ATOL * _FIRST, "ignores"),
        (1.1 * _ATOL * _FIRST, ""),
        (-1.1 * _ATOL * _FIRST, ""),
    ],
)
def test_a_bias_is_added_to_every_read_or_to_the_first_one_or_ignored(response: Array, told: str) -> None:
    twins = _responding(response)
    found = {"adds": twins.adds_bias(), "begins": twins.begins_with_bias(), "ignores": twins.ignores_bias()}
    assert {name for name, is_so in found.items() if is_so} == set(told.split())


def test_the_noise_is_told_beside_a_drift_by_what_more_of_it_adds() -> None:
    assert _TWINS.noise_size() == pytest.approx(np.sqrt(np.mean(np.diff(_NOISE, axis=0) ** 2) / 2))


def test_noise_scales_where_most_differences_of_reads_do() -> None:
    assert not _TWINS.scales()
    assert replace(_TWINS, scaled=3 * _BASE + 1).scales()
    assert replace(_TWINS, scaled=3 * _BASE + 0.9 * _ATOL * _FIRST).scales()
    jumps = np.arange(40)[:, None] % 10 == 5
    assert replace(_TWINS, scaled=3 * _BASE + jumps).scales()
    assert not replace(_TWINS, scaled=3 * _BASE + np.arange(40)[:, None] % 2).scales()
    assert not replace(_responding(_CHANGE), scaled=np.zeros_like(_BASE)).scales()


def test_series_that_no_seed_determines_tell_nothing() -> None:
    assert not _OTHER_SEED.seeded
    assert not any((_OTHER_SEED.adds_bias(), _OTHER_SEED.begins_with_bias(), _OTHER_SEED.ignores_bias()))
    assert not replace(_OTHER_SEED, other=_BASE).ignores_bias()
    assert not replace(_OTHER_SEED, scaled=3 * _BASE).scales()
    assert _OTHER_SEED.noise_size() == 0
    unknown = facts_of.UNSEEDED
    assert not any((unknown.seeded, unknown.scales(), unknown.adds_bias(), unknown.ignores_bias()))
