"""What a filter does, told from outputs that are made of the sheet's recursion or of another one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import filtering
from grader.labs.imu.diagnosis.filter_outputs import recursion

pytestmark = pytest.mark.quick
_N, _ATOL, _ALPHAS = 160, 1e-5, (0.3, 0.6)
_RNG = np.random.default_rng(12)
_X = _RNG.normal((0.5, -9.6, 2), 1, (_N, 3))
_ONE = np.eye(_N, 3, k=-40)
Answers = Callable[[float, Array], Array]


def _sheet(alpha: float, x: Array) -> Array:
    return recursion(alpha, x, x[0])


def _of(a: float, b: float, x: Array = _X) -> Array:
    """``y[n] = a x[n] + b y[n-1]`` from the first measurement on."""
    y = [x[0]]
    for sample in x[1:]:
        y.append(a * sample + b * y[-1])
    return np.array(y)


def _high_passed(c: float, x: Array) -> Array:
    y = [np.zeros(3)]
    for n in range(1, len(x)):
        y.append(c * (y[-1] + x[n] - x[n - 1]))
    return np.array(y)


def _restarting(seldom: int) -> Answers:
    def answer(alpha: float, x: Array) -> Array:
        y = [x[0]]
        for n in range(1, len(x)):
            y.append(x[n] if n % seldom == 0 else alpha * x[n] + (1 - alpha) * y[-1])
        return np.array(y)

    return answer


def _starting_late(alpha: float, x: Array) -> Array:
    """The first ten come out as they are."""
    return np.vstack([x[:10], recursion(alpha, x[9:], x[9])[1:]])


def _averaged(size: int) -> Answers:
    return lambda _, x: np.array([x[max(0, n - size + 1) : n + 1].mean(axis=0) for n in range(len(x))])


def _on_axes(*axes: int, others: Answers = lambda _, x: x) -> Answers:
    def answer(alpha: float, x: Array) -> Array:
        y = others(alpha, x).copy()
        y[:, list(axes)] = _sheet(alpha, x)[:, list(axes)]
        return y

    return answer


def _below_now_and_then(alpha: float, x: Array) -> Array:
    y = _restarting(20)(alpha, x)
    return np.where(np.arange(len(x))[:, None] % 20 == 19, x - 1, y)


def _late_and_again(alpha: float, x: Array) -> Array:
    return np.vstack([_starting_late(alpha, x[:60]), _starting_late(alpha, x[60:])])


_CROSSED = np.array([[1.0, 0.1, 0], [0, 0.9, 0], [0, 0, 1]])
_LESS = np.array([[1.0, -0.1, 0], [0, 1, 0], [0, 0, 1]])


def _from(constant: float | list[float]) -> Answers:
    return lambda alpha, x: np.asarray(alpha * x + constant)


_TOLD: dict[str, tuple[Answers, list[str]]] = {
    "sound": (_sheet, []),
    "exchanged weights": (lambda alpha, x: _of(1 - alpha, alpha, x), ["alpha-swapped"]),
    "the measurement": (lambda _, x: x, ["no-filtering"]),
    "the measurement but for the first": (lambda _, x: np.vstack([0 * x[:1], x[1:]]), ["no-filtering"]),
    "the first": (lambda _, x: np.tile(x[0], (len(x), 1)), ["output-stuck"]),
    "zeros": (lambda _, x: 0 * x, ["output-stuck"]),
    "the first, then zeros": (lambda _, x: np.vstack([x[:1], 0 * x[1:]]), ["output-stuck"]),
    "hardly anything moves": (lambda _, x: 0 * x + 0.7 * _ATOL * np.eye(len(x), 3), ["output-stuck"]),
    "from the same value": (_from(3), ["state-not-kept"]),
    "from the same three values": (_from([3, 4, 5]), ["state-not-kept"]),
    "from the same value, weights exchanged": (lambda alpha, x: (1 - alpha) * x - 2, ["state-not-kept"]),
    "of two measurements": (lambda c, x: c * x + (1 - c) * np.roll(x, 1, axis=0), ["filters-input-history"]),
    "of two, exchanged": (lambda c, x: (1 - c) * x + c * np.roll(x, 1, axis=0), ["filters-input-history"]),
    "high-pass": (_high_passed, ["high-pass"]),
    "high-pass, exchanged": (lambda alpha, x: _high_passed(1 - alpha, x), ["high-pass"]),
    "without the low part": (lambda alpha, x: x - _sheet(alpha, x), ["high-pass"]),
    "without the low part, exchanged": (lambda alpha, x: x - _sheet(1 - alpha, x), ["high-pass"]),
    "starts again": (_restarting(20), ["filter-restarts"]),
    "starts again each sixth": (_restarting(6), ["filter-restarts"]),
    "starts again each fifth": (_restarting(4), []),
    "starts late": (_starting_late, []),
    "starts late, and starts again late": (_late_and_again, ["filter-restarts"]),
    "below the measurement now and then": (_below_now_and_then, []),
    "mean of so many that one or three are": (lambda alpha, x: _averaged(int(1 / alpha))(alpha, x), ["moving-average"]),
    "mean of two": (_averaged(2), ["moving-average"]),
    "mean of twenty": (_averaged(20), ["moving-average"]),
    "a gain without memory": (lambda _, x: 0.5 * x, ["does-not-filter"]),
    "a gain an axis, and an offset": (lambda _, x: x * [1, 2, 3] + 4, ["does-not-filter"]),
    "a sum of weights of more than one": (lambda alpha, x: _of(alpha, 1.05 - alpha, x), ["gain-not-one"]),
    "a sum of weights of less than one": (lambda alpha, x: _of(alpha, 0.95 - alpha, x), ["gain-not-one"]),
    "a sum of weights that is one, nearly": (lambda alpha, x: _of(alpha + 1e-5, 1 - alpha, x), ["gain-not-one"]),
    "another alpha, always": (lambda _, x: _of(0.2, 0.8, x), ["alpha-ignored"]),
    "another alpha, never the same": (lambda alpha, x: _of(alpha**2, 1 - alpha**2, x), []),
    "two axes": (_on_axes(0, 1), ["axes-mixed"]),
    "one axis": (_on_axes(2), ["axes-mixed"]),
    "two axes, one stuck": (_on_axes(0, 2, others=lambda _, x: 0 * x + 1), ["axes-mixed"]),
    "two axes, one stuck after the first": (_on_axes(1, 2, others=lambda _, x: np.vstack([x[:1], 0 * x[1:]])), ["axes-mixed"]),
    "two axes, one of noise": (_on_axes(0, 2, others=lambda _, x: np.cos(9 * x)), []),
    "crossed": (lambda alpha, x: _sheet(alpha, x @ _CROSSED), ["axes-mixed"]),
    "taken off another one": (lambda alpha, x: _sheet(alpha, x @ _LESS), ["axes-mixed"]),
    "squared": (lambda _, x: x**2, []),
    "another recursion an axis": (lambda alpha, x: np.stack([_of(a, 1 - a, x)[:, i] for i, a in enumerate((alpha, 0.2, 0.9))], axis=1), []),
}  # fmt: skip


@pytest.mark.parametrize("name", _TOLD)
def test_the_one_mistake_that_predicts_every_run_is_told(name: str) -> None:
    answer, told = _TOLD[name]
    assert filtering.mistakes([(alpha, _X, answer(alpha, _X)) for alpha in _ALPHAS]) == told


@pytest.mark.parametrize(
    "name", [name for name, (_, told) in _TOLD.items() if told and not name.startswith(("starts", "a sum"))]
)
def test_a_mistake_in_one_of_two_runs_predicts_not_both(name: str) -> None:
    answer, told = _TOLD[name]
    assert filtering.mistakes([(0.3, _X, answer(0.3, _X)), (0.6, _X, _sheet(0.6, _X))]) != told


def test_of_one_alpha_nobody_knows_whether_it_is_heeded() -> None:
    y = _of(0.2, 0.8)
    assert filtering.mistakes([(0.3, _X, y), (0.3, _X, y)]) == []


@pytest.mark.parametrize(
    ("y", "found"),
    [
        (_of(0.3, 0.7), (0.3, 0.7)),
        (_of(-0.2, 0.5), (-0.2, 0.5)),
        (_of(0.3, 1.2), (0.3, 1.2)),
        (_of(0.3, 0.7) + 0.9 * _ATOL * _ONE, (0.3, 0.7)),
        (_of(0.3, 0.7) + 3 * _ATOL * _ONE, None),
        (_of(0.3, 2), (0.3, 2)),
        (_of(0.3, 30), None),
        (-_of(0.3, 2), (-0.3, 2)),
        (_X**2, None),
    ],
)
def test_the_coefficients_of_a_recursion_are_found_until_it_runs_away(
    y: Array, found: tuple[float, float] | None
) -> None:
    assert filtering.recursion_of(_X, y) == (None if found is None else pytest.approx(found, abs=1e-5))


def test_a_recursion_runs_away_below_zero_as_above() -> None:
    below = -np.abs(_X)
    assert filtering.recursion_of(below, _of(0.3, 2, below)) == pytest.approx((0.3, 2))


def test_six_outputs_tell_two_coefficients() -> None:
    y = _of(0.3, 0.7)
    assert filtering.recursion_of(_X[:6], y[:6]) == pytest.approx((0.3, 0.7))
    assert filtering.recursion_of(_X[:5], y[:5]) is None


@pytest.mark.parametrize(
    ("y", "away"),
    [
        (_of(0.3, 1.02), True), (_of(-0.3, -1.02), True), (_of(0.3, 1.005), False), (_of(0.3, 0.9), False),
        (_of(0.005, 1.05), False), (_of(0.02, 1.05), True), (_of(-0.02, 1.05), True), (_X**2, False),
    ],
)  # fmt: skip
def test_what_grows_by_itself_runs_away(y: Array, away: bool) -> None:
    assert filtering.runs_away(_X, y) == away


@pytest.mark.parametrize(
    ("x", "y", "none"),
    [
        (_X, _X, True),
        (_X, -2 * _X + 7, True),
        (_X, _X * [1, 0, 3], True),
        (_X, np.vstack([0 * _X[:1], 2 * _X[1:]]), True),
        (_X, 0 * _X + [1, 2, 3], False),
        (_X, np.vstack([_X[:1], 0 * _X[1:]]), False),
        (_X, _of(1 - 1e-3, 1e-3), False),
        (_X, _X + 0.7 * _ATOL * _ONE, True),
        (_X, _X + 3 * _ATOL * _ONE, False),
        (0 * _X, _X, False),
        (_X * [1, 0, 1], _X * [1, 0, 1] + 1, True),
    ],
)
def test_a_filter_without_memory_follows_each_measurement_alone(x: Array, y: Array, none: bool) -> None:
    assert filtering.has_no_memory(x, y) == none


@pytest.mark.parametrize(
    ("y", "keeps"),
    [
        (0.1 * _X + 0.9 * _X[0], True),
        (0.9 * _X + 0.1 * _X[0], True),
        (0.1 * _X + 0.9 * _X[1], False),
        (0.2 * _X + 0.8 * _X[0], False),
        (0.1 * _X, False),
        (_X, False),
        (0.1 * _X + 0.9 * _X[0] + 0.7 * _ATOL, True),
        (0.1 * _X + 0.9 * _X[0] + 3 * _ATOL, False),
    ],
)
def test_a_filter_that_keeps_the_first_measurement_starts_each_output_from_it(y: Array, keeps: bool) -> None:
    assert filtering.keeps_the_first(0.1, _X, y) == keeps


_LATE = np.arange(400)
_WAVE = np.sin(2 * np.pi * _LATE / 40)[:, None] * [1.0, 2, 0.5]
_NOISE = np.random.default_rng(4).normal(0, 1, (400, 3))


def test_weights_that_never_change_and_have_another_sum_are_a_gain() -> None:
    assert filtering.mistakes([(alpha, _X, _of(0.2, 0.85, _X)) for alpha in _ALPHAS]) == ["gain-not-one"]


def test_noise_and_signal_are_measured_over_the_second_half() -> None:
    loud = np.vstack([100 * _NOISE[:200], _NOISE[200:]])
    assert filtering.noise_gain(_NOISE, 0.5 * loud[::1]) == pytest.approx(0.25)
    assert filtering.noise_gain(loud, _NOISE) == pytest.approx(1)
    assert filtering.noise_gain(_NOISE[:401], _NOISE * [2, 0, 0]) == pytest.approx(4 / 3, rel=0.2)
    assert filtering.signal_error(_WAVE, np.vstack([loud[:200], 0.5 * _WAVE[200:]])) == pytest.approx(0.5)
    assert filtering.signal_error(_WAVE + 9, _WAVE + 9) == 0
    apart = np.array([0.0, 5, -9])
    assert filtering.signal_error(_WAVE + apart, 0.5 * _WAVE + apart) == pytest.approx(0.5)
    begins_loud = np.vstack([9 * _WAVE[:200], _WAVE[200:]])
    assert filtering.signal_error(begins_loud, 0.5 * begins_loud) == pytest.approx(0.5)
    assert filtering.signal_error(_WAVE * [1, 1, 1], _WAVE * [2, 1, 1]) == pytest.approx((1 / 5.25) ** 0.5)


@pytest.mark.parametrize(
    ("y", "share"),
    [
        (_WAVE, 1),
        (0.01 * np.roll(_WAVE, 7, axis=0) + 5 + _LATE[:, None] / 100, 1),
        (_WAVE * [0, 0, 1] + _NOISE * [1, 1, 0], 1),
        (0 * _WAVE + 3, 0),
        (0.5 * _ATOL * _WAVE, 0),
        (_LATE[:, None] * np.ones(3), 0),
        (np.vstack([_NOISE[:200], _WAVE[200:]]), 1),
        (np.sin(2 * np.pi * _LATE / 20)[:, None] * np.ones(3), 0),
        (_WAVE * [1, 0, 0] + np.sin(2 * np.pi * _LATE / 20)[:, None] * [1.0, 0, 0], 1 - 0.5**0.5),
    ],
)
def test_the_share_of_a_signal_is_what_swings_with_its_period(y: Array, share: float) -> None:
    assert filtering.share_of_signal(y, 40) == pytest.approx(share, abs=0.01)


def _holding(size: float) -> Answers:
    """What jumps by more is left out."""

    def answer(alpha: float, x: Array) -> Array:
        y = [x[0]]
        for sample in x[1:]:
            y.append(y[-1] if np.abs(sample - y[-1]).max() > size else alpha * sample + (1 - alpha) * y[-1])
        return np.array(y)

    return answer


def _every_second(alpha: float, x: Array) -> Array:
    return np.repeat(recursion(alpha, x[::2], x[0]), 2, axis=0)[: len(x)]


def _from_a_mean(alpha: float, x: Array) -> Array:
    """The mean of all, of the first ten measurements."""
    means = np.cumsum(x, axis=0) / np.arange(1, len(x) + 1)[:, None]
    return np.vstack([means[:10], recursion(alpha, x[9:], means[9])[1:]])


def _odd_once(alpha: float, x: Array) -> Array:
    return _sheet(alpha, x) + _ONE


def _falling(alpha: float, x: Array) -> Array:
    """At every fifth measurement the output falls, whatever that is, and goes on from there."""
    y = [x[0]]
    for n, sample in enumerate(x[1:], 1):
        y.append(y[-1] - 5 if n % 5 == 0 else alpha * sample + (1 - alpha) * y[-1])
    return np.array(y)


def _late_and_odd(alpha: float, x: Array) -> Array:
    return _starting_late(alpha, x) + _ONE


@pytest.mark.parametrize(
    ("answer", "holds", "late"),
    [
        (_sheet, False, False),
        (_holding(2.0), True, False),
        (_holding(1.0), True, False),
        (_every_second, True, False),
        (lambda _, x: 0 * x + x[0], False, False),
        (_averaged(4), False, False),
        (_starting_late, False, True),
        (_from_a_mean, False, True),
        (_odd_once, False, False),
        (_late_and_odd, False, False),
        (_falling, False, False),
        (_restarting(20), False, False),
        (lambda alpha, x: np.vstack([x[:140], recursion(alpha, x[139:], x[139])[1:]]), False, False),
    ],
    ids=[
        "sheet", "jumps left out", "more left out", "every second", "stuck", "averaged", "late", "from a mean", "odd once",
        "late and odd", "falling", "restarting", "too late",
    ],
)  # fmt: skip
def test_outputs_that_stay_and_outputs_that_begin_late_are_told(answer: Answers, holds: bool, late: bool) -> None:
    runs = [(alpha, _X, answer(alpha, _X)) for alpha in _ALPHAS]
    assert (filtering.stays_at_times(runs), filtering.begins_late(runs)) == (holds, late)
    sound = (0.5, _X, _sheet(0.5, _X))
    assert (filtering.stays_at_times([sound, *runs]), filtering.begins_late([sound, *runs])) == (holds, late)
