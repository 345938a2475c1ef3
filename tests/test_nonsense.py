"""A sweep over generated filters without memory: none earns more than the points for its form.

`pytest -m sweep` runs every combination; a fixed sample runs with the other tests.
"""

from __future__ import annotations

import itertools
import random

import pytest

from grader.engine.grader import Marker
from grader.intake import Submission
from tests.corpus import nothing
from tests.corpus.nothing import Nothing
from tests.corpus.writing import as_bytes

_WITHOUT_MEMORY = (
    "np.tanh({x})", "{x} * {x}", "np.clip({x}, -1, 1)", "np.round({x}, 3)", "np.round({x}, 1)", "np.abs({x})", "np.sign({x})", "{x} + 1",
    "-{x}", "0.3 * {x}", "{x}[::-1].copy()", "np.zeros(3)", "np.full(3, self.alpha)", "np.sin({x})", "np.exp(-{x} * {x})", "np.floor({x})",
    "np.full(3, {x}.mean())", "{x} * 0.99 ** self.n", "{x} * self.n", "np.random.normal(0, 1, 3)", "self.alpha * {x}", "np.sqrt(np.abs({x}))",
)  # fmt: skip
_HEAD = (
    "m = np.asarray(measurement, float); self.n = getattr(self, 'n', -1) + 1; "
    "first = self.first = getattr(self, 'first', m.copy()); return "
)


def filters() -> list[Nothing]:
    bodies = dict.fromkeys(each.format(x=x) for each, x in itertools.product(_WITHOUT_MEMORY, ("m", "first")))
    return [nothing._filter(body, f"{_HEAD}{body}") for body in bodies]


EVERY = filters()
SAMPLE = random.Random(42).sample(EVERY, 8)


def name_of(part: Nothing) -> str:
    return part.name


def earned(marker: Marker, part: Nothing) -> tuple[float, dict[str, float]]:
    files = {path: as_bytes(content) for path, content in part.files.items()}
    (criterion,) = marker.mark(Submission("s", "s", files, (), "ready", ""), only=part.criterion).criteria
    return criterion.points, {check.id: check.points for check in criterion.checks if check.points}


@pytest.mark.parametrize("part", SAMPLE, ids=name_of)
def test_a_sampled_part_that_does_nothing_earns_its_form_at_most(part: Nothing, marker: Marker) -> None:
    points, kept = earned(marker, part)
    assert points <= part.most, kept


@pytest.mark.sweep
@pytest.mark.parametrize("part", EVERY, ids=name_of)
def test_no_part_that_does_nothing_earns_more_than_its_form(part: Nothing, marker: Marker) -> None:
    points, kept = earned(marker, part)
    assert points <= part.most, kept
