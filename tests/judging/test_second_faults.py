"""Two faults of one part: the second gives no points back, whichever of them is named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from tests.judging import test_check_noise_model as noise
from tests.judging import test_check_sensor_access as reading
from tests.judging.fake_students import Check, FakeStudent, kept
from tests.judging.test_useless_parts import FILTER_CHECKS, recursive

pytestmark = pytest.mark.quick
Sound = noise.Sound

LOUD = {"noise": lambda s, which: 10 * Sound.noise(s, which)}
IN_ONE_ROW = {"read": lambda s: np.concatenate([s.one(0), s.one(1)])[None]}
WITH_ONE_MORE = {"read": lambda s, data: (s.one(0), s.one(1))}
ONE_TWICE = {"read": lambda s: (s.one(0),) * 2}
BESIDE = {"one": lambda s, which: Sound.one(s, which) + (0.5, 0.05)[which]}
REDRAWN = {"one": lambda s, which: Sound.one(s, which) + s.rng.normal(0, (0.1, 0.01)[which], 3)}
NOISE: Mapping[str, Sequence[type]] = {
    "loud, and one sensor twice": (noise.of(**LOUD), noise.of(**ONE_TWICE), noise.of(**LOUD, **ONE_TWICE)),
    "loud, and redrawn": (noise.of(**LOUD), noise.of(**REDRAWN), noise.of(**LOUD, **REDRAWN)),
    "loud, and off centre": (noise.of(**LOUD), noise.of(**BESIDE), noise.of(**LOUD, **BESIDE)),
    "loud, and another form": (noise.of(**LOUD), noise.of(**IN_ONE_ROW), noise.of(**LOUD, **IN_ONE_ROW)),
    "loud, and another parameter": (noise.of(**LOUD), noise.of(**WITH_ONE_MORE), noise.of(**LOUD, **WITH_ONE_MORE)),
}


def _two_ids(model: Any, data: Any, a: int, g: int) -> Any:
    return reading.sound(model, data, a, a)


READERS: Mapping[str, Sequence[reading.Reader]] = {
    "fixed ids, and one sensor twice": (
        lambda m, d, a, g: reading.sound(m, d, 2, 4),
        _two_ids,
        lambda m, d, a, g: _two_ids(m, d, 2, 4),
    ),
}


def _beside_alpha(self: Any, measurement: Any) -> Any:
    """The recursion with a step that is a little larger for large differences, which no row of the table knows."""
    gap = measurement - self.y
    return self.y + self.alpha * (gap + gap * np.abs(gap))


def _without_default(kind: type) -> type:
    return type(
        "LowPassFilter",
        (kind,),
        {"__init__": lambda s, alpha, initial_value=None: kind.__init__(s, alpha, initial_value)},
    )


def _with_one_more(kind: type) -> type:
    return type("LowPassFilter", (kind,), {"update": lambda s, measurement, data: kind.update(s, measurement)})


ODD = recursive(_beside_alpha)
FILTERS: Mapping[str, Sequence[type]] = {
    "an unknown recursion, and no default of alpha": (ODD, _without_default(recursive()), _without_default(ODD)),
    "an unknown recursion, and another parameter": (ODD, _with_one_more(recursive()), _with_one_more(ODD)),
}
PARTS: Mapping[str, tuple[Sequence[Check], Mapping[str, Sequence[Any]]]] = {
    "NoisyIMU": (noise.CHECKS, NOISE),
    "get_imu_readings": (reading.CHECKS, READERS),
    "LowPassFilter": (FILTER_CHECKS, FILTERS),
}


@pytest.mark.parametrize(("part", "name"), [(part, name) for part, (_, rows) in PARTS.items() for name in rows])
def test_a_second_fault_gives_nothing_back(part: str, name: str) -> None:
    checks, rows = PARTS[part]
    one, other, both = (sum(kept(FakeStudent(**{part: made}), checks).values()) for made in rows[name])
    assert max(one, other) < 20
    assert both < max(one, other), (one, other, both)
    assert both <= min(one, other), (one, other, both)
