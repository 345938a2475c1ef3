"""The figures of a run beside their targets and those of the runs before, which `last.json` keeps. Looked at before a release."""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LAST = Path(__file__).with_name("last.json")
KEPT = 10
"""Runs on record: the oldest makes room."""


@dataclass(frozen=True)
class Figure:
    """One figure that is watched: what it is, and the bound that it keeps; a larger one is better where `more`."""

    said: str
    target: float
    more: bool = False

    def misses(self, value: float, bound: float, room: float = 0.0) -> bool:
        """Whether a value is on the wrong side of a bound, by more than `room`."""
        return value < bound - room if self.more else value > bound + room


FIGURES = {
    "floor": Figure("CPU of a further submission, of the floor", 1.0),
    "plain": Figure("the same, of plain pytest", 0.25),
    "sheet": Figure("CPU of the sheet's own layout, of its floor", 1.3),
    "faulty": Figure("CPU of a faulty submission, of a sound one", 2.0),
    "markers": Figure("submissions of two markers on two cores by the clock, of one on one", 1.9, more=True),
    "memory": Figure("private MB of a marker with its zygote", 250.0),
}


@dataclass(frozen=True)
class Seen:
    """What the rounds of one run say of a figure: their median, and how far a round was from it."""

    median: float
    spread: float

    @classmethod
    def of(cls, rounds: Sequence[float]) -> Seen:
        median = statistics.median(rounds)
        return cls(median, max(abs(each - median) for each in rounds))


def held(now: Mapping[str, Seen], last: Mapping[str, float]) -> tuple[str, bool]:
    """A table of the figures, and whether none is worse than the last one by more than its own spread."""
    lines, good = ["| watched | now | ± | target | last | |", "| --- | ---: | ---: | ---: | ---: | --- |"], True
    for name, figure in FIGURES.items():
        seen, before = now[name], last.get(name)
        missed = "misses its target" if figure.misses(seen.median, figure.target) else ""
        worse = before is not None and figure.misses(seen.median, before, seen.spread)
        good = good and not worse
        remarks = ", ".join(remark for remark in (missed, "worse than before" if worse else "") if remark)
        bound = f"{'at least' if figure.more else 'at most'} {figure.target:g}"
        told = "-" if before is None else f"{before:.3g}"
        lines.append(f"| {figure.said} | {seen.median:.3g} | {seen.spread:.2g} | {bound} | {told} | {remarks} |")
    return "\n".join(lines), good


def read() -> dict[str, float]:
    """The last recorded figures, none if there are none."""
    runs = _runs()
    return dict(runs[-1]["figures"]) if runs else {}


def keep(now: Mapping[str, Seen], machine: str, date: str) -> None:
    """Record the figures as the last ones."""
    figures = {name: float(f"{seen.median:.3g}") for name, seen in now.items()}
    runs = [*_runs(), {"machine": machine, "date": date, "figures": figures}][-KEPT:]
    LAST.write_text(json.dumps({"runs": runs}, indent=1) + "\n", encoding="utf-8")


def _runs() -> list[dict[str, Any]]:
    return list(json.loads(LAST.read_text(encoding="utf-8"))["runs"]) if LAST.is_file() else []
