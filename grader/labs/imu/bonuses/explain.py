"""Hypotheses on the faults of the extensions, and the four criteria that they make."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grader.engine.charging import Part
from grader.engine.hypothesis import Reason
from grader.labs.imu.bonuses import allan, liveplot, tilting
from grader.labs.imu.bonuses.measure import (
    RIDES,
    Allan,
    Imus,
    Live,
    Tilt,
    World,
    measure_allan,
    measure_imus,
    measure_live,
    measure_tilt,
)
from grader.labs.imu.compare import same
from grader.labs.imu.lab import LAB

UPDATES = 4
"""Changes of the curves in one second of simulation; a plot that is redrawn less often is not called live."""
SPAN = 0.4
"""Least share of the simulated time between the first and the last change of the curves."""

# ---- the complementary filter ----


def _is_pair(facts: Tilt) -> bool:
    """Return whether two values came, though not finite ones."""
    pairs = ("a tuple of 2 (a number, a number)", "a list of 2 (a number, a number)", "an array of shape (2,)")
    return not facts.odd or facts.odd.startswith(pairs)


def has_no_angles(facts: Tilt) -> bool:
    return not np.isfinite(facts.level).all()


def _responds(holds: Callable[[tilting.Response], bool]) -> Callable[[Tilt], bool]:
    return lambda f: f.response is not None and not has_no_angles(f) and holds(f.response)


_LEVEL = "returns_roll_and_pitch"
_TILT_REASONS: tuple[Reason[Tilt], ...] = (
    Reason(_LEVEL, 1, "not-finite", lambda f: has_no_angles(f) and _is_pair(f)),
    Reason(_LEVEL, 2, "wrong-return-type", has_no_angles),
    *(
        Reason(check, 3 + cost, name, _responds(holds))
        for check in (_LEVEL, "settles_at_tilt", *RIDES)
        for cost, (name, holds) in enumerate(tilting.FAULTS.items())
    ),
)
TILT: Part[Tilt] = Part(LAB, "complementary_filter", measure_tilt, _TILT_REASONS, only_names=True)

# ---- the Allan deviation ----


def _shows(holds: Callable[[list[allan.Record], float], bool]) -> Callable[[Allan], bool]:
    return lambda f: f.meant is None and holds(f.records, f.rate)


def is_variance(facts: Allan) -> bool:
    """Return whether the square roots of all curves are Allan deviations."""
    roots = [(taus, np.sqrt(np.abs(curve)), samples) for taus, curve, samples in facts.records]
    return allan.unit_of_times(roots, facts.rate) is not None


_ALLAN_REASONS: tuple[Reason[Allan], ...] = (
    Reason("returns_times_and_deviations", 1, "wrong-return-type", lambda f: f.odd is None),
    Reason("returns_times_and_deviations", 2, "not-finite", lambda _: True),
    Reason("averaging_times", 1, "tau-wrong", lambda f: f.meant is not None and not f.meant[0]),
    Reason("matches_definition", 1, "returns-variance", is_variance),
    *(
        Reason(check, 2 + cost, name, _shows(holds))
        for check in ("matches_definition", "shows_kinds_of_noise")
        for cost, (name, holds) in enumerate(allan.FAULTS.items())
    ),
)
ALLAN: Part[Allan] = Part(LAB, "allan_variance", measure_allan, _ALLAN_REASONS, only_names=True)

# ---- all IMUs ----


def is_no_dictionary(facts: Imus) -> bool:
    return any(not w.got.calls or not (w.got.calls[0] or w.got.shape.startswith("a dictionary")) for w in facts.worlds)


def _repeats_one(world: World) -> bool:
    first, *others = world.read.values() if world.read else [np.zeros(0)]
    return bool(others) and all(same(rows, first, 1e-9) for rows in others)


_IMU_REASONS: tuple[Reason[Imus], ...] = (
    Reason("finds_every_place", 1, "wrong-return-type", is_no_dictionary),
    Reason("finds_every_place", 2, "imu-missing", lambda _: True),
    Reason("matches_truth", 1, "same-imu-repeated", lambda f: any(map(_repeats_one, f.worlds))),
)
IMUS: Part[Imus] = Part(LAB, "multiple_imus", measure_imus, _IMU_REASONS, only_names=True)

# ---- a plot that grows ----


def shows_once(facts: Live) -> bool:
    return len(facts.run.events) <= 2 and liveplot.updates(facts.run.events) < UPDATES


_LIVE_REASONS: tuple[Reason[Live], ...] = (Reason("grows_while_stepping", 1, "plot-not-live", shows_once),)
LIVE: Part[Live] = Part(LAB, "realtime_visualization", measure_live, _LIVE_REASONS, only_names=True)
