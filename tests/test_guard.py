"""The guard of the benchmark tells a figure that got worse from one that did not."""

from __future__ import annotations

import pytest

from tests.benchmarks import guard

BEFORE = {"floor": 0.9, "plain": 0.25, "markers": 1.9, "memory": 190.0, "first": 0.4, "verdict": 2.4, "help": 0.13}


def test_the_same_figures_are_held() -> None:
    assert guard.held(BEFORE, BEFORE)[1]
    assert "worse" not in guard.held(BEFORE, {})[0]


@pytest.mark.parametrize("name", guard.FIGURES)
def test_each_figure_that_got_worse_is_told(name: str) -> None:
    worse = 0.8 if guard.FIGURES[name].more else 1.2
    told, good = guard.held({**BEFORE, name: BEFORE[name] * worse}, BEFORE)
    assert not good
    assert [guard.FIGURES[name].said in line for line in told.splitlines() if "worse than before" in line] == [True]
    assert guard.held({**BEFORE, name: BEFORE[name] / worse}, BEFORE)[1]


def test_a_target_that_is_missed_is_told_and_fails_nothing_by_itself() -> None:
    told, good = guard.held({**BEFORE, "floor": 1.1}, {**BEFORE, "floor": 1.1})
    assert good
    assert told.count("misses its target") == 1


def test_recorded_figures_are_read_back(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(guard, "LAST", tmp_path / "last.json")
    assert guard.read() == {}
    guard.keep(BEFORE, "a machine", "2026-11-22")
    assert guard.read() == BEFORE
