"""Noise models and filters that no list foresaw lose what a careful marker said before, each fault once, with a true word."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.results import CheckResult, CriterionResult
from grader.intake import Submission
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import noise_laws
from grader.labs.imu.diagnosis.noise import Facts, bias_mistakes
from grader.labs.imu.diagnosis.noise_twins import Twins
from grader.labs.imu.number_format import told_apart
from tests.corpus.unforeseen_noise_filter import FAULTY, SOUND, Unforeseen
from tests.recordings import Marking


def _marked(player: Marking, sample: Unforeseen) -> CriterionResult:
    content = {name: text.encode() for name, text in sample.files.items()}
    return player.mark(Submission("s", "s", content, (), "ready", ""), only=sample.criterion).criteria[0]


def _lost(criterion: CriterionResult) -> dict[str, CheckResult]:
    return {c.id.partition(".")[2]: c for c in criterion.checks if c.points != c.max_points}


@pytest.mark.parametrize("sample", SOUND, ids=lambda sample: sample.name)
def test_a_sound_one_in_a_style_of_its_own_loses_nothing(sample: Unforeseen, player: Marking) -> None:
    criterion = _marked(player, sample)
    assert {name: check.message for name, check in _lost(criterion).items()} == {}
    assert [m for check in criterion.checks for m in check.misconceptions] == []


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_a_faulty_one_loses_what_the_marker_said_and_is_told_why(sample: Unforeseen, player: Marking) -> None:
    criterion = _marked(player, sample)
    lost = _lost(criterion)
    names = {mistake for check in lost.values() for mistake in check.misconceptions}
    assert lost
    assert set(lost) <= set(sample.checks)
    assert sum(check.max_points - (check.points or 0.0) for check in lost.values()) <= sample.most + 1e-9
    assert names <= set(sample.names)
    assert bool(names) == bool(sample.names)
    assert [name for name, check in lost.items() if not check.hint and check.outcome != "skipped"] == []
    for check in lost.values():
        if check.outcome != "skipped":
            expected, got = check.message.split("\nGot ", 1)
            assert expected.removeprefix("Expected").strip() != got.strip()


# --- the functions behind it, with arrays ----------------------------------------------------------------------------

TRUTH = np.array([[3.0, -2.0, -9.0], [1.0, 4.0, 2.0]])
BIAS = np.array([-0.25, -0.67, 0.45])
STD = 0.08


def _facts(noise: Array, std: float = STD, bias: Array = BIAS) -> Facts:
    return Facts(bias + noise, TRUTH, std, bias)


def _white(reads: int = st.READS, seed: int = 3) -> Array:
    return np.random.default_rng(seed).normal(0, STD, (2, reads, 3))


def _remembering(share: float, seed: int = 3) -> Array:
    noise = _white(seed=seed)
    for read in range(1, noise.shape[1]):
        noise[:, read] += share * noise[:, read - 1]
    return noise


def _walk(step: float, reads: int, seed: int = 5) -> Array:
    return np.cumsum(np.random.default_rng(seed).normal(0, step, (2, reads, 3)), axis=1)


@pytest.mark.quick
def test_a_walk_and_a_ramp_drift_and_white_noise_or_none_does_not() -> None:
    ramp = np.broadcast_to(1e-4 * np.arange(100)[None, :, None], (2, 100, 3)).copy()
    assert all(noise_laws.drifts(_facts(moves)) for moves in (ramp, _walk(0.001, 100), _walk(0.5, 100)))
    assert not any(noise_laws.drifts(_facts(moves)) for moves in (np.zeros((2, 100, 3)), _white(100)))


@pytest.mark.quick
def test_biases_that_are_drawn_anew_do_not_creep_and_those_that_fade_do() -> None:
    first = np.random.default_rng(1).normal(0, 0.1, (24, 1, 3))
    assert noise_laws.creeps(first * 0.99 ** np.arange(3)[None, :, None])
    assert not noise_laws.creeps(np.random.default_rng(1).normal(0, 0.1, (24, 3, 3)))
    assert not noise_laws.creeps(np.repeat(first, 3, axis=1))


@pytest.mark.quick
def test_neighbouring_reads_tell_the_noise_as_if_the_bias_stood_still() -> None:
    step = 0.5 * STD
    steady = noise_laws.steadied(
        _facts(_white() + _walk(step, st.READS)), _facts(_walk(step, 100, seed=8), bias=np.zeros(3))
    )
    assert steady.pooled_spread == pytest.approx(STD, rel=0.05)  # half of all reads: 3,750 values err by 1.2 %
    assert np.abs(steady.offset - BIAS).max() < 0.02
    assert not noise_laws.correlated(steady)


@pytest.mark.quick
@pytest.mark.parametrize("share", [0.3, 0.6, -0.5])
def test_a_share_of_the_read_before_is_a_memory_and_what_is_new_has_the_size_asked_for(share: float) -> None:
    facts = _facts(_remembering(share))
    assert noise_laws.correlated(facts)
    assert noise_laws.innovation(facts) == pytest.approx(STD, rel=0.05)
    assert not noise_laws.correlated(_facts(_white()))


@pytest.mark.quick
@pytest.mark.parametrize("cut", [1.0, 2.0, 2.5, 2.8])
def test_a_normal_law_that_is_cut_off_is_told_and_its_moments_are_those_of_the_formula(cut: float) -> None:
    unit = np.random.default_rng(2).standard_normal((2, 400_000))
    kept = unit[1][np.abs(unit[1]) < cut]
    for values, moments in zip((np.clip(unit[0], -cut, cut), kept), st.limited_moments(cut), strict=True):
        assert (values.std(), np.abs(values).mean()) == pytest.approx(moments, rel=0.01)
        assert noise_laws.clipped(_facts(STD * values[: 6 * st.READS].reshape(2, st.READS, 3)))


@pytest.mark.quick
@pytest.mark.parametrize("law", ["normal", "uniform", "triangular", "two-point", "laplace"])
def test_other_laws_are_not_called_cut_off(law: str) -> None:
    rng, shape = np.random.default_rng(4), (2, st.READS, 3)
    draws = {
        "normal": lambda: rng.standard_normal(shape),
        "uniform": lambda: rng.uniform(-(3**0.5), 3**0.5, shape),
        "triangular": lambda: rng.triangular(-(6**0.5), 0, 6**0.5, shape),
        "two-point": lambda: rng.choice([-1.0, 1.0], shape),
        "laplace": lambda: rng.laplace(0, 0.5**0.5, shape),
    }
    assert not noise_laws.clipped(_facts(STD * draws[law]()))


@pytest.mark.quick
def test_a_density_is_off_by_the_root_of_the_step_or_rate_on_both_sensors() -> None:
    off = 0.002**-0.5
    assert noise_laws.density([_facts(off * _white()), _facts(_white() / 20 * off, STD / 20)], 0.002)
    assert noise_laws.density([_facts(_white() / off), _facts(_white() / 20 / off, STD / 20)], 0.002)
    assert not noise_laws.density([_facts(off * _white()), _facts(_white() / 20, STD / 20)], 0.002)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("order", "names"),
    [([2, 1, 0], ["bias-axes-exchanged"]), ([1, 2, 0], ["bias-axes-exchanged"]), ([0, 1, 2], [])],
)
def test_biases_on_other_axes_are_told_and_those_on_their_own_are_not(order: list[int], names: list[str]) -> None:
    sensors = [
        Facts(_white() + BIAS[order], TRUTH, STD, BIAS),
        Facts(_white(seed=4) / 20 + 0.1 * BIAS[order], TRUTH[::-1] / 7, STD / 20, 0.1 * BIAS),
    ]
    assert bias_mistakes(sensors) == names


def _twins(change: Array, response: Array, noise: Array, factor: float = 1.5, again: Array | None = None) -> Twins:
    return Twins(noise, noise if again is None else again, noise + response, factor * noise, change, factor)


@pytest.mark.quick
def test_twins_show_a_bias_that_is_added_under_any_law_of_the_noise() -> None:
    change, coloured = np.array([0.1, -0.2, 0.3]), _remembering(0.95)[0, :40] ** 3
    assert _twins(change, change, coloured).adds_bias()
    assert _twins(change, change, coloured).scales()
    assert not _twins(change, 2 * change, coloured).adds_bias()
    assert not _twins(change, change[::-1], coloured).adds_bias()
    assert _twins(change, 0 * change, coloured).ignores_bias()
    assert not _twins(change, 1e-3 * change, coloured).ignores_bias()


@pytest.mark.quick
def test_twins_of_a_model_that_no_seed_repeats_show_nothing() -> None:
    change = np.array([0.1, -0.2, 0.3])
    loose = _twins(change, change, _white(40)[0], again=_white(40, seed=9)[0])
    assert [loose.seeded, loose.adds_bias(), loose.scales(), loose.ignores_bias()] == [False] * 4


@pytest.mark.quick
def test_two_vectors_are_never_shown_with_the_same_digits_where_they_differ() -> None:
    assert told_apart(np.array([1.0, 2.0]), np.array([1.00004, 2.0])) == ("[1.00000 2.00000]", "[1.00004 2.00000]")
    assert told_apart(np.array([1.0]), np.array([2.0])) == ("[1.000]", "[2.000]")
