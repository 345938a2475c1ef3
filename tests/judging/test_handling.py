"""What a reader did over several calls or with the pose, told from sequences of readings that are made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import reader_faults

pytestmark = pytest.mark.quick
_N, _ATOL = 30, 1e-5
_RNG = np.random.default_rng(8)
_ACCEL, _GYRO = _RNG.normal(0, 3, (_N, 3)), _RNG.normal(0, 1, (_N, 3))


def _about(axis: Array, angle: float) -> Array:
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


_POSES = np.array([_about(_RNG.normal(size=3), angle) for angle in _RNG.uniform(0.5, 2.5, _N)])
_MOUNT = _about(np.array([1, 2, 3]), 0.7)
_MIRROR = np.diag([1.0, 1.0, -1.0])


def _turned(x: Array, mount: Array = _MOUNT) -> Array:
    """In the world's axes, by a body whose axes are the sensor's turned by the mount."""
    return np.einsum("nij,jk,nk->ni", _POSES, mount, x)


def _turned_back(x: Array, mount: Array = _MOUNT) -> Array:
    return np.einsum("ij,nkj,nk->ni", mount, _POSES, x)


def _every_third_new(x: Array) -> Array:
    """The first two calls read anew; from then on every third does, and the others give what came before."""
    given = x.copy()
    for n in range(2, len(x)):
        given[n] = x[n] if n % 3 == 0 else given[n - 1]
    return given


def _low_passed(x: Array, weight: float = 0.3) -> Array:
    given = x.copy()
    for n in range(2, len(x)):
        given[n] = weight * x[n] + (1 - weight) * given[n - 1]
    return given


def _weighted(x: Array, *weights: float) -> Array:
    """Of the new reading and the ones before; the first calls as they are."""
    mean = sum(weight * np.roll(x, lag, axis=0) for lag, weight in enumerate(weights))
    return np.concatenate([x[: len(weights)], np.asarray(mean)[len(weights) :]])


def _mean_of(count: int) -> Callable[[Array], Array]:
    return lambda x: _weighted(x, *[1 / count] * count)


_TOLD: list[tuple[Callable[[Array], Array], str | None]] = [
    (lambda x: x.clip(-2, 2), "reading-clipped"),
    (lambda x: x.clip(None, 1), "reading-clipped"),
    (lambda x: x.clip(-1.5, None), "reading-clipped"),
    (lambda x: x.clip([-1, -0.5, -0.7], [0.6, 0.8, 1]), "reading-clipped"),
    (_every_third_new, "cached-reading"),
    (_low_passed, "reading-smoothed"),
    (_mean_of(2), "reading-smoothed"),
    (_mean_of(5), "reading-smoothed"),
    (lambda x: _weighted(x, 0.2, 0.5, 0.3), "reading-smoothed"),
    (_turned, "turned-by-body"),
    (_turned_back, "turned-by-body"),
    (lambda x: _turned(x, _MOUNT @ _MIRROR), None),
    (lambda x: 1.01 * _turned(x), None),
    (lambda x: _turned_back(x, np.eye(3)), None),
    (lambda x: 2 * x, None),
    (np.cos, None),
    (lambda x: 0 * x, None),
    (lambda x: np.full_like(x, 0.1), None),
    (lambda x: x * [0, 0, 1], None),
    (lambda x: np.full_like(x, np.nan), None),
    (lambda x: np.full_like(x, 1e9), None),
    (lambda x: x.copy(), None),
]  # fmt: skip


@pytest.mark.parametrize(("change", "told"), _TOLD)
def test_what_was_done_to_the_numbers_is_told_of_both_sensors_or_of_one(
    change: Callable[[Array], Array], told: str | None
) -> None:
    for got in ((change(_ACCEL), change(_GYRO)), (change(_ACCEL), _GYRO), (_ACCEL, change(_GYRO))):
        assert reader_faults.handled(got, (_ACCEL, _GYRO), _POSES, _ATOL) == told


def test_two_sensors_that_were_handled_differently_have_no_name_together() -> None:
    got = (_ACCEL.clip(-2, 2), _low_passed(_GYRO))
    assert reader_faults.handled(got, (_ACCEL, _GYRO), _POSES, _ATOL) is None


def test_of_a_reading_that_never_changes_nothing_is_told() -> None:
    held = np.tile(_ACCEL[0], (_N, 1))
    assert reader_faults.handled((held, _GYRO), (_ACCEL, _GYRO), _POSES, _ATOL) is None


def test_numbers_beyond_all_reason_are_of_no_mistake() -> None:
    true = 1e9 * _ACCEL
    for low, high, told in ((-0.9e9, 0.9e9, "reading-clipped"), (-1.1e9, 0.9e9, None), (-0.9e9, 1.1e9, None)):
        got = true.clip(low, high)
        assert reader_faults.handled((got, _GYRO), (true, _GYRO), _POSES, 1e-3) == told


def _standing_at(limit: float, times: int) -> tuple[Array, Array]:
    """True readings of which so many are beyond a limit, and those that stay within it."""
    true = 0.1 * _ACCEL
    true[3 : 3 + times, 1] = limit * np.arange(2, 2 + times)
    return true.clip(-abs(limit), abs(limit)), true


@pytest.mark.parametrize(
    ("limit", "times", "told"), [(3.0, 1, False), (3.0, 2, True), (-3.0, 2, True), (-3.0, 1, False)]
)
def test_a_limit_is_one_at_which_two_readings_stand(limit: float, times: int, told: bool) -> None:
    assert reader_faults.clipped(*_standing_at(limit, times), _ATOL) == told


def test_a_limit_is_passed_by_more_than_the_tolerance() -> None:
    true = np.array([[0.0, 0, 0], [1, 0, 0], [1 + 0.5e-5, 0, 0], [1 + 0.9e-5, 0, 0]])
    assert not reader_faults.clipped(np.minimum(true, 1), true, _ATOL)
    assert not reader_faults.clipped(np.maximum(-true, -1), -true, _ATOL)
    further = np.array([[0.0, 0, 0], [1, 0, 0], [1 + 1.5e-5, 0, 0], [1 + 1.9e-5, 0, 0]])
    assert reader_faults.clipped(np.minimum(further, 1), further, _ATOL)
    assert reader_faults.clipped(np.maximum(-further, -1), -further, _ATOL)


@pytest.mark.parametrize(("never_moves", "read", "told"), [(9.81, 9.81, True), (9.81, -50, False), (9.81, 50, False)])
def test_an_axis_that_never_moves_is_within_a_limit_where_it_is_right(
    never_moves: float, read: float, told: bool
) -> None:
    true = np.column_stack([_ACCEL[:, :2], np.full(_N, never_moves)])
    got = np.column_stack([_ACCEL[:, :2].clip([-1, -0.5], [0.6, 0.8]), np.full(_N, read)])
    assert reader_faults.clipped(got, true, _ATOL) is told


def _new_at(*rows: int) -> Array:
    given = _ACCEL.copy()
    for n in range(2, _N):
        given[n] = _ACCEL[n] if n in rows else given[n - 1]
    return given


@pytest.mark.parametrize(
    ("got", "kept"),
    [
        (_new_at(5), True),  # the first two, and one more
        (_new_at(), False),
        (_new_at(*range(2, _N - 3)), True),
        (_new_at(*range(2, _N - 2)), False),
        (_new_at(5) + 0.4 * _ATOL * np.sign(_GYRO), True),
        (_new_at(5) + np.outer(np.arange(_N) == 9, [0, 2 * _ATOL, 0]), False),
        (_new_at(5) + np.outer(np.arange(_N) == 2, [0, 2 * _ATOL, 0]), False),
        (_new_at(5) + np.outer(np.arange(_N) == 1, [0, 2 * _ATOL, 0]), False),
        (_new_at(5) + np.outer(np.arange(_N) == 0, [0, 2, 0]), False),
        (_new_at(5) - np.outer(np.arange(_N) == _N - 1, [3, 3, 3]), False),
        (_new_at(5, 6) + np.outer(np.arange(_N) == 0, [0, 2, 0]), True),
    ],
)
def test_a_kept_reading_is_the_own_one_or_the_one_before_and_some_of_both(got: Array, kept: bool) -> None:
    assert reader_faults.kept(got, _ACCEL, _ATOL) == kept


@pytest.mark.parametrize(
    ("got", "smoothed"),
    [
        (_mean_of(10)(_ACCEL), True),
        (_mean_of(11)(_ACCEL), False),
        (_ACCEL, False),
        (_weighted(_ACCEL, 0.9985, 0.0015), True),
        (_weighted(_ACCEL, 0.9995, 0.0005), False),
        (_weighted(_ACCEL, 0.0, 1.0), True),
        (_weighted(_ACCEL, 0.6, 0.41), False),
        (_weighted(_ACCEL, 0.5, 0.4), False),
        (_weighted(_ACCEL, 0.6, 0.3995), True),
        (_weighted(_ACCEL, 1.2, -0.2), False),
        (_weighted(_ACCEL, 0.7, 0.6, -0.3), False),
        (_low_passed(_ACCEL, 0.05), True),
        (_low_passed(_ACCEL, -0.1), False),
        (_mean_of(2)(_ACCEL) + 0.7 * _ATOL * np.sign(_GYRO), True),
        (_mean_of(2)(_ACCEL) + 2 * _ATOL * np.sign(_GYRO), False),
        (_mean_of(2)(_ACCEL) + np.outer(np.arange(_N) == 20, [0, 0.01, 0]), False),
        (_mean_of(2)(_ACCEL) - np.outer(np.arange(_N) == 20, [0, 0.01, 0]), False),
        (_mean_of(7)(_ACCEL)[:12], True),
        (_mean_of(8)(_ACCEL)[:12], False),
    ],
)
def test_a_smoothed_reading_is_a_mean_of_the_latest_or_of_the_new_one_and_the_one_given_before(
    got: Array, smoothed: bool
) -> None:
    assert reader_faults.smoothed(got, _ACCEL[: len(got)], _ATOL) == smoothed


@pytest.mark.parametrize("off", [0.01, -0.01])
def test_a_mean_that_is_off_by_the_same_everywhere_is_none(off: float) -> None:
    true = np.outer(_ACCEL[:, 0], [1, -1, 0])
    assert reader_faults.smoothed(_mean_of(2)(true), true, _ATOL)
    assert not reader_faults.smoothed(_mean_of(2)(true) + np.array([off, off, 0]), true, _ATOL)


@pytest.mark.parametrize(
    ("mount", "turned"),
    [
        (_MOUNT, True),
        (_about(np.array([0, 0, 1]), 0.002), True),
        (_about(np.array([0, 0, 1]), 0.0005), False),
        (_about(np.array([1, 0, 0]), np.pi), True),
        (np.eye(3), False),
        (-_MOUNT, False),
        (_MOUNT @ _MIRROR, False),
        (_MOUNT * 1.002, False),
        (_MOUNT * 0.99, False),
        (_MOUNT * 1.0003, True),
    ],
)
def test_a_body_is_turned_by_a_rotation_that_is_not_none(mount: Array, turned: bool) -> None:
    assert reader_faults.turned(_turned(_ACCEL, mount), _ACCEL, _POSES, _ATOL) == turned
    assert reader_faults.turned(_turned_back(_ACCEL, mount), _ACCEL, _POSES, _ATOL) == turned


def test_a_turn_predicts_every_reading() -> None:
    off = np.outer(np.arange(_N) == 7, [0, 1, 0])
    assert reader_faults.turned(_turned(_ACCEL) + 0.3 * _ATOL * off, _ACCEL, _POSES, _ATOL)
    assert not reader_faults.turned(_turned(_ACCEL) + 2 * _ATOL * off, _ACCEL, _POSES, _ATOL)
    assert not reader_faults.turned(_turned(_ACCEL) - 2 * _ATOL * off, _ACCEL, _POSES, _ATOL)
