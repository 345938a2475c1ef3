"""Which fault of a noise model predicts the reads, by reads whose mean and spread are exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.noise_model import explain, measure
from grader.labs.imu.noise_model.measure import Facts, Sensor
from grader.labs.imu.noise_model.reads import Reads

pytestmark = pytest.mark.quick
_RNG = np.random.default_rng(5)
_NO_BIAS = np.zeros(3)


def _exact(std: float, truth: Array, bias: Array) -> Reads:
    noise = _RNG.normal(size=(2, 600, 3))
    noise -= noise.mean(axis=1, keepdims=True)
    return Reads(bias + std * noise / noise.std(axis=1, keepdims=True), truth, std, bias)


ACCEL = _exact(0.05, np.array([[0.5, -0.9, 9.6], [1.2, 0.4, -9.1]]), np.array([0.3, -0.2, 0.4]))
GYRO = _exact(0.005, np.array([[0.2, -0.1, 0.5], [-0.3, 0.4, 0.06]]), np.array([-0.03, 0.05, 0.02]))


def _quiet(reads: Reads, spread: float = 0.0) -> Reads:
    """Reads that were given no bias, with so much noise."""
    return replace(reads, residual=spread * (reads.residual - reads.bias) / reads.std, bias=_NO_BIAS)


def _facts(accel: Reads = ACCEL, gyro: Reads = GYRO, silent: tuple[float, float] = (0.0, 0.0)) -> Facts:
    return Facts((Sensor(accel, _quiet(ACCEL, silent[0])), Sensor(gyro, _quiet(GYRO, silent[1]))))


def _off(reads: Reads, offset: Array) -> Reads:
    """The same reads with a mean of (3,) or (states, 3)."""
    return replace(reads, residual=reads.residual - reads.bias + np.broadcast_to(offset, (2, 3))[:, None, :])


def _wrong(accel: Array | None = None, gyro: Array | None = None) -> Facts:
    """Both sensors with these means, or the given bias."""
    return _facts(ACCEL if accel is None else _off(ACCEL, accel), GYRO if gyro is None else _off(GYRO, gyro))


def _first_again(reads: Reads) -> Array:
    return reads.truth[0] + reads.bias - reads.truth


_OTHERS = [GYRO.truth - ACCEL.truth + ACCEL.bias, ACCEL.truth - GYRO.truth + GYRO.bias]


@pytest.mark.parametrize(
    ("facts", "told"),
    [
        (_wrong(gyro=_NO_BIAS), "no-bias"),
        (_wrong(-ACCEL.bias, -GYRO.bias), "bias-sign-flipped"),
        (_wrong(_first_again(ACCEL), _first_again(GYRO)), "stale-clean-reading"),
        (_wrong(_first_again(ACCEL) - 1), ""),
        (_wrong(*_OTHERS), "swapped-sensors"),
        (_wrong(_OTHERS[0]), ""),
        (_wrong(GYRO.bias, ACCEL.bias), "biases-exchanged"),
        (_wrong(gyro=ACCEL.bias), "bias-shared"),
        (_wrong(ACCEL.bias[[1, 0, 2]], GYRO.bias[[2, 0, 1]]), "bias-axes-exchanged"),
        (_wrong(ACCEL.bias + 0.5, GYRO.bias + 0.05), "noise-not-zero-mean"),
        (_wrong(np.array([5.0, 6, 7])), "bias-argument-ignored"),
    ],
)  # fmt: skip
def test_an_offset_that_is_not_the_bias_is_named(facts: Facts, told: str) -> None:
    assert explain.offset_fault(facts) == told


def _sized(accel: float, gyro: float, silent: tuple[float, float] = (0.0, 0.0)) -> Facts:
    """Both sensors with noise so many times as large as it was asked for."""
    more = (
        replace(f, residual=f.bias + by * (f.residual - f.bias))
        for f, by in zip((ACCEL, GYRO), (accel, gyro), strict=True)
    )
    return _facts(*more, silent=silent)


@pytest.mark.parametrize(
    ("facts", "told"),
    [
        (_sized(0.1, 10), "stds-swapped"),
        (_sized(1, 10.6), "stds-swapped"),
        (_sized(0.1, 3), "noise_model.noise_size"),  # the other sensor's noise has another cause
        (_sized(0.05, 0.005), "variance-as-std"),
        (_sized(0.05, 1.5), "noise_model.noise_size"),
        (_sized(0.002**0.5, 0.002**0.5), "noise-density"),
        (_sized(3, 3, (0.15, 0.015)), "std-ignored"),
        (_sized(3, 3, (0.1, 0.01)), "bias-redrawn"),
        (_sized(1.5, 1.5), "noise_model.noise_size"),
    ],
)
def test_a_wrong_size_of_the_noise_is_named(facts: Facts, told: str) -> None:
    assert explain.sizes_off(facts)
    reasons = [each for each in explain.REASONS if each.of == explain.SIZE]
    found = explain.hypothesis.explain(reasons, facts)
    assert (found.cause if found else "") == told


def test_noise_that_nobody_asked_for_is_no_redrawn_bias_if_the_size_that_was_asked_for_is_right() -> None:
    silent = (0.02, 0.002)
    assert _sized(3, 3, silent).redrawn
    assert not _facts(silent=silent).redrawn


_INSTANCES = _RNG.normal(size=(24, 1, 3))


def _creeping(step: float) -> Array:
    """Three reads of each instance, of which each is a step further on."""
    between = np.sqrt(np.mean(np.var(_INSTANCES[:, 0], axis=0)))
    return np.asarray(_INSTANCES + step * between * np.arange(3)[None, :, None])


@pytest.mark.parametrize(
    ("biases", "creeps"),
    [
        (_creeping(-0.01), True),
        (_creeping(0.29), True),
        (_creeping(0.31), False),
        (_creeping(0.01) - 1e8, False),
        (np.tile([1.0, 5, 9], (24, 3, 1)) + 0.01 * np.arange(3)[None, :, None], False),
    ],
)
def test_biases_creep_that_move_by_little_against_how_they_differ(biases: Array, creeps: bool) -> None:
    assert measure._creeps(biases) == creeps


def _moves(bias: Array) -> tuple[str, ...]:
    """The faults of a default bias (instances, reads, 3) without noise that moves, the cheapest first."""
    sensor = Sensor(ACCEL, _quiet(ACCEL), default=bias)
    facts = Facts((sensor, sensor))
    moving = [each for each in explain.REASONS if each.of == explain.DEFAULT and each.cost <= 5 and each.fits(facts)]
    return tuple(each.cause for each in moving[:1]) if explain.moves(facts) else ()


@pytest.mark.parametrize("size", [1e6, -1e6])
def test_a_large_bias_stays_where_it_moves_by_its_last_digits(size: float) -> None:
    bias = np.full((4, 3, 3), size)
    bias[:, 1] += 1e-4
    assert _moves(bias) == ()
    bias[:, 1] += 1e-2
    assert _moves(bias) != ()


def test_a_bias_that_moves_is_told_by_what_the_later_reads_have() -> None:
    first = np.arange(12.0).reshape(4, 1, 3)
    none, another = np.zeros((4, 1, 3)), -0.1 * (1 + first)
    assert _moves(np.concatenate([first + 1, none, none], axis=1)) == ("bias-drifts",)
    assert _moves(np.concatenate([first + 1, another, none], axis=1)) == ("bias-redrawn",)
    assert _moves(np.concatenate([first + 1, another, another], axis=1)) == ("bias-redrawn",)
    assert _moves(np.concatenate([first + 1, none - 2, none - 2], axis=1)) == ("bias-shared",)
