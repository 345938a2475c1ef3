"""Marks cases of the corpus from their tapes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from grader.engine import rubric
from grader.engine.marking import Marker
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.scoreboard import Case, Verdict, graded_by
from tests.tapes import PlayingBox
from tests.tapes.storing import shelf


@cache
def generous() -> rubric.Rubric:
    """The shipped rubric, and points for the extensions: so their partial credit shows, too. No verdict reads charts."""
    return rubric.parse(
        replace(LAB, charts=lambda student, truth: ()),
        rubric.shipped(LAB).read_bytes() + b"\nextra_credit:\n  each: 10\n",
    )


class Player:
    """A marker whose box is a tape."""

    def __init__(self) -> None:
        self._box = PlayingBox(shelf().rung)
        self.marker = Marker(generous(), bundles.shipped(), box=self._box)  # type: ignore[arg-type] # speaks as a box does

    def insert(self, case: Case) -> Marker:
        """The marker with the tape of this case in."""
        self._box.tape = shelf()[case.id]
        return self.marker

    def verdict(self, case: Case) -> Verdict:
        return graded_by(self.insert(case), case)


@cache
def player() -> Player:
    """The process's one player."""
    return Player()
