"""The figures of a run beside their targets and those of the run before, which `last.json` keeps. Looked at before a release."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

LAST = Path(__file__).with_name("last.json")
ROOM = 0.1
"""By so much a figure may be worse than the last one: medians of one machine's runs differ by up to 7 %."""


@dataclass(frozen=True)
class Figure:
    """One figure that is watched: what it is, and the bound that it keeps; a larger one is better where `more`."""

    said: str
    target: float
    more: bool = False

    def misses(self, value: float, bound: float, room: float = 0.0) -> bool:
        """Whether a value is on the wrong side of a bound, by more than a share of it."""
        return value < bound * (1 - room) if self.more else value > bound * (1 + room)


FIGURES = {
    "floor": Figure("CPU of a further submission, of the floor", 1.0),
    "plain": Figure("the same, of plain pytest", 0.30),
    "markers": Figure("submissions of two markers by the clock, of one", 1.8, more=True),
    "memory": Figure("private MB of a marker with its zygote", 250.0),
    "first": Figure("first line of a cold check, of the bare imports", 1.5),
    "verdict": Figure("its verdict, of the bare imports", 2.5),
    "help": Figure("seconds of `imugrade --help`", 0.15),
}


def held(now: Mapping[str, float], last: Mapping[str, float]) -> tuple[str, bool]:
    """A table of the figures, and whether none is worse than the last one."""
    lines, good = ["| watched | now | target | last | |", "| --- | ---: | ---: | ---: | --- |"], True
    for name, figure in FIGURES.items():
        before, bound = last.get(name), f"{'at least' if figure.more else 'at most'} {figure.target:g}"
        missed = "misses its target" if figure.misses(now[name], figure.target) else ""
        worse = before is not None and figure.misses(now[name], before, ROOM)
        good = good and not worse
        remarks = ", ".join(remark for remark in (missed, "worse than before" if worse else "") if remark)
        told = "-" if before is None else f"{before:.3g}"
        lines.append(f"| {figure.said} | {now[name]:.3g} | {bound} | {told} | {remarks} |")
    return "\n".join(lines), good


def read() -> dict[str, float]:
    """The last recorded figures, none if there are none."""
    return dict(json.loads(LAST.read_text(encoding="utf-8"))["figures"]) if LAST.is_file() else {}


def keep(now: Mapping[str, float], machine: str, date: str) -> None:
    """Record the figures as the last ones."""
    rounded = {name: float(f"{value:.3g}") for name, value in now.items()}
    LAST.write_text(
        json.dumps({"machine": machine, "date": date, "figures": rounded}, indent=1) + "\n", encoding="utf-8"
    )
