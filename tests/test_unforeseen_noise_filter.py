"""Noise models and filters that no list foresaw lose what a careful marker said before, each fault once, with a true word."""

from __future__ import annotations

import numpy as np
import pytest

from grader.engine.results import CheckResult, CriterionResult
from grader.intake import Submission
from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array, distinct_texts
from grader.labs.imu.noise_model.reads import Reads
from tests.corpus.cases import Case, of
from tests.recordings import Marking

FAULTY, SOUND = (
    [case for case in of(part) if case.criterion in ("noise_model", "filtering")]
    for part in ("unforeseen", "unforeseen sound")
)


def _marked(player: Marking, sample: Case) -> CriterionResult:
    content = {name: str(text).encode() for name, text in sample.files.items()}
    return player.mark(Submission("s", "s", content, (), "ready", ""), only=sample.criterion).criteria[0]


def _lost(criterion: CriterionResult) -> dict[str, CheckResult]:
    return {c.id: c for c in criterion.checks if c.points != c.max_points}


@pytest.mark.parametrize("sample", SOUND, ids=lambda sample: sample.name)
def test_a_sound_one_in_a_style_of_its_own_loses_nothing(sample: Case, player: Marking) -> None:
    criterion = _marked(player, sample)
    assert {name: check.message for name, check in _lost(criterion).items()} == {}
    assert [m for check in criterion.checks for m in check.misconceptions] == []


@pytest.mark.parametrize("sample", FAULTY, ids=lambda sample: sample.name)
def test_a_faulty_one_loses_what_the_marker_said_and_is_told_why(sample: Case, player: Marking) -> None:
    criterion = _marked(player, sample)
    lost = _lost(criterion)
    names = {mistake for check in lost.values() for mistake in check.misconceptions}
    assert lost
    assert set(lost) <= set(sample.loses)
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


def _reads(noise: Array) -> Reads:
    return Reads(BIAS + noise, TRUTH, STD, BIAS)


@pytest.mark.quick
@pytest.mark.parametrize("cut", [1.0, 2.0, 2.5, 2.8])
def test_a_normal_law_that_is_cut_off_is_told_and_its_moments_are_those_of_the_formula(cut: float) -> None:
    unit = np.random.default_rng(2).standard_normal((2, 400_000))
    kept = unit[1][np.abs(unit[1]) < cut]
    for values, moments in zip((np.clip(unit[0], -cut, cut), kept), st.limited_moments(cut), strict=True):
        assert (values.std(), np.abs(values).mean()) == pytest.approx(moments, rel=0.01)
        assert _reads(STD * values[: 6 * st.READS].reshape(2, st.READS, 3)).clipped


@pytest.mark.quick
def test_two_vectors_are_never_shown_with_the_same_digits_where_they_differ() -> None:
    assert distinct_texts(np.array([1.0, 2.0]), np.array([1.00004, 2.0])) == ("[1.00000 2.00000]", "[1.00004 2.00000]")
    assert distinct_texts(np.array([1.0]), np.array([2.0])) == ("[1.000]", "[2.000]")
