from __future__ import annotations

from pathlib import Path

import pytest

from tests.benchmarks import guard
from tests.benchmarks.guard import Seen

BEFORE = {  # as they are kept, to three digits
    name: float(f"{(1.1 if figure.more else 0.9) * figure.target:.3g}") for name, figure in guard.FIGURES.items()
}
SPREAD = 0.1


def run(**others: float) -> dict[str, Seen]:
    """A run as good as the one before, but for some figures."""
    return {name: Seen(value, SPREAD * value) for name, value in {**BEFORE, **others}.items()}


def test_a_run_as_good_as_the_last_one_is_good_and_so_is_the_first() -> None:
    assert guard.held(run(), BEFORE)[1]
    assert "worse" not in guard.held(run(), {})[0]


@pytest.mark.parametrize("name", guard.FIGURES)
def test_a_figure_that_is_worse_by_more_than_its_spread_is_told_and_fails(name: str) -> None:
    worse = 0.8 if guard.FIGURES[name].more else 1.2
    told, good = guard.held(run(**{name: BEFORE[name] * worse}), BEFORE)
    assert not good
    assert [guard.FIGURES[name].said in line for line in told.splitlines() if "worse than before" in line] == [True]
    assert guard.held(run(**{name: BEFORE[name] / worse}), BEFORE)[1]
    within = 0.95 if guard.FIGURES[name].more else 1.05
    assert guard.held(run(**{name: BEFORE[name] * within}), BEFORE)[1]


def test_a_missed_target_is_told_and_fails_nothing_that_was_not_better_before() -> None:
    told, good = guard.held(run(floor=1.1), {**BEFORE, "floor": 1.1})
    assert "misses its target" in told
    assert good


def test_a_spread_is_the_round_that_is_furthest_from_the_median() -> None:
    assert Seen.of([1.0, 1.25, 2.0]) == Seen(1.25, 0.75)


def test_the_last_runs_are_kept_and_the_oldest_makes_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guard, "LAST", tmp_path / "last.json")
    assert guard.read() == {}
    for number in range(guard.KEPT + 2):
        guard.keep(run(memory=100.0 + number), "a machine", "2026-11-22")
    assert guard.read() == {**BEFORE, "memory": 111.0}
    assert guard.LAST.read_text(encoding="utf-8").count("a machine") == guard.KEPT
