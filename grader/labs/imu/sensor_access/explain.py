"""Diagnosis of a reader (`get_imu_readings`): the hypothesis that explains each sensor's readings, and the known faults.

Accelerometer and gyroscope are explained separately. A hypothesis has to predict every number that was returned for every IMU.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine import hypothesis
from grader.engine.charging import Judge
from grader.engine.findings import Skipped
from grader.engine.hypothesis import Reason
from grader.engine.traces import Traces
from grader.labs.imu.compare import BOTH, NO_CHANGE, SHEETS_NOISE, Array, same_where_known
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import CALL_REASONS, departures
from grader.labs.imu.sensor_access import measure as facts_of
from grader.labs.imu.sensor_access.hypotheses import (
    PLACES,
    Hypothesis,
    agrees,
    fixed_places,
    one_fault,
    two_faults,
    value_changes,
)
from grader.labs.imu.sensor_access.measure import ATOL, Facts, Visit
from grader.labs.imu.student import Student

VALUES, PLACE, FORM, COPY, ALONE = facts_of.CHECKS[1], facts_of.CHECKS[2], facts_of.CHECKS[0], *facts_of.CHECKS[3:]
_MOST = 0.5
"""Smallest share of right numbers of the other IMUs for a reader that alters only some of them."""
_ONE_ALTERED = (0.75, 0.5)
"""Shares of the reading: a wrong acceleration shows in the sheet's own trial, which expects [0, 0, -9.81] at rest."""
_ALIKE = 0.5
"""Smallest correlation of two visits to the same states for a reading that depends on the state. A reader of the sensors has 1, one
that smooths over calls nearly 1; 78 random numbers reach 0.5 once in 250,000."""
_FEWEST_VALUES = 4
"""Fewest different numbers in the readings of the robot's IMU that show a sensor. Signs, comparisons and orders have three."""

# ---- the explanation of each sensor


@dataclass(frozen=True)
class Explained:
    """Facts about a student's `get_imu_readings`, with the hypothesis that explains each of its two sensors.

    A hypothesis is None if none fits, or if several that fit disagree on the fault.
    """

    facts: Facts
    sensors: tuple[Hypothesis | None, ...] = (None, None)

    @property
    def stopped(self) -> Mapping[str, Exception]:
        return self.facts.stopped

    @classmethod
    def of(cls, facts: Facts) -> Explained:
        return cls(facts, tuple(_explain(facts, sensor) for sensor in BOTH))

    @property
    def places(self) -> list[str]:
        """Ids of address faults, or else `hard-coded-address` if another IMU's ids change nothing or raise errors like KeyError."""
        known = _named_places([each for each in self.sensors if each])
        raised = any(v.error.type in _NOT_FOUND for v in self.facts.others if v.error)
        return known or ["hard-coded-address"] * (self._ids_are_ignored or raised)

    @property
    def _ids_are_ignored(self) -> bool:
        return any(_is_ignored(self.facts.torso, v, i) for v in self.facts.visits[1:] for i in BOTH)

    @property
    def values(self) -> list[str]:
        return [value for each in self.sensors if each for value in each.values]

    def meant(self, visit: Visit, sensor: int) -> Array:
        """Return the true values (k, 3) at the address that the code reads for a sensor (0 accelerometer, 1 gyroscope) of an IMU.

        `visit` holds the readings of that IMU. If no hypothesis explains the sensor, the right address is taken.
        """
        known = self.sensors[sensor]
        return visit.scene.true(sensor) if known is None else visit.scene.at(known.start(visit.scene, sensor))

    @property
    def wrong_on_torso(self) -> list[int]:
        """The sensors (0 accelerometer, 1 gyroscope) of the robot's own IMU with values that are wrong, missing or unexplained."""
        return [i for i in BOTH if (known := self.sensors[i]) is None or known.values or self.lacks_numbers(i)]

    @property
    def share_altered(self) -> float:
        """Share of `matches_truth` points that wrong values cost: 0.75 if only acceleration is wrong, 0.5 if only angular velocity.

        It is 1 if both sensors of the robot's own IMU are wrong, if only other IMUs are, or if the code removes gravity.
        """
        whole = len(self.wrong_on_torso) != 1 or "gravity-removed" in self.values
        return 1.0 if whole else _ONE_ALTERED[self.wrong_on_torso[0]]

    @property
    def share_misplaced(self) -> float:
        """Share of `follows_address` points lost: half for each sensor at a wrong address, all if none is computed from the ids."""
        faults = {fault for each in self.sensors if each for fault in each.place}
        computed = faults - {"hard-coded-address", "wrong-fixed-address"}
        if not computed or self._ids_are_ignored:
            return 1.0
        return sum(bool(each and each.place) for each in self.sensors) / len(BOTH)

    def altered(self) -> tuple[Visit, int] | None:
        """Return the first altered, missing or unexplained readings, and 0 (accelerometer) or 1 (gyroscope), to show; or None.

        The robot's own IMU comes first. Other IMUs follow if half of their numbers for the sensor are right; else see `misplaced`.
        """
        wrong = self.wrong_on_torso
        others = ((v, i) for v in self.facts.visits[1:] for i in BOTH if self._partly_right(i) and not self._fits(v, i))
        return (self.facts.torso, wrong[0]) if wrong else next(others, None)

    def misplaced(self) -> tuple[Visit, int] | None:
        """Return readings from a wrong address, with 0 for the accelerometer or 1 for the gyroscope, for the message; or None."""
        torso, others = self.facts.torso, self.facts.visits[1:]
        places = [i for i in BOTH if (known := self.sensors[i]) and known.place]
        first = ((v, i) for v in self.facts.visits for i in places if _rightness([v], i) < 1)
        same = ((v, i) for v in others for i in BOTH if self.sensors[i] is None and _is_ignored(torso, v, i))
        off = (
            (v, i) for v in others for i in BOTH if self.sensors[i] and not (self._fits(v, i) or self._partly_right(i))
        )
        return next(itertools.chain(first, same, off), None)

    def _fits(self, visit: Visit, sensor: int) -> bool:
        known = self.sensors[sensor]
        return known is not None and agrees(visit.got[sensor], known.predict(visit.scene, sensor))

    def _partly_right(self, sensor: int) -> bool:
        """Return whether at least half of the numbers of the other IMUs are right, so that the rest is altered, not misplaced."""
        return _rightness(self.facts.visits[1:], sensor) >= _MOST

    def lacks_numbers(self, sensor: int) -> bool:
        """Return whether accelerometer (0) or gyroscope (1) came without finite numbers, and no wrong address explains it."""
        known, got = self.sensors[sensor], self.facts.torso.got[sensor]
        return not np.isfinite(got).all() and not (known and known.place)

    def near(self, visit: Visit) -> bool:
        """Return whether an IMU's readings (`visit`) are off by at most a real sensor's noise, which halves the deduction."""
        pairs = zip(visit.got, (self.meant(visit, i) for i in BOTH), SHEETS_NOISE, strict=True)
        return all(bool(np.abs(got - there).max() <= little) for got, there, little in pairs)


_NOT_FOUND = ("KeyError", "ValueError", "IndexError")


def _explain(facts: Facts, sensor: int) -> Hypothesis | None:
    """Return the cheapest hypothesis for a sensor that predicts all IMUs, else one that predicts the robot's own; None without."""
    everywhere = (*one_fault(), *two_faults(), *fixed_places(facts.torso, sensor))
    return explained(everywhere, sensor, facts.visits) or explained(one_fault(), sensor, [facts.torso])


def explained(known: Iterable[Hypothesis], sensor: int, visits: Sequence[Visit]) -> Hypothesis | None:
    return hypothesis.explain(known, (sensor, visits))


def _named_places(found: Sequence[Hypothesis]) -> list[str]:
    names = [fault for each in found for fault in each.place]
    exchanged = names.count("same-sensor-twice") == len(BOTH)
    return list(dict.fromkeys("swapped-sensors" if exchanged and n == "same-sensor-twice" else n for n in names))


def _rightness(visits: Sequence[Visit], sensor: int) -> float:
    """Return the share of a sensor's returned numbers that are the true ones; 0 if nothing was returned."""
    right = [np.abs(visit.got[sensor] - visit.scene.true(sensor)) <= ATOL for visit in visits]
    return float(np.mean(np.concatenate(right))) if right else 0.0


def _is_ignored(torso: Visit, other: Visit, sensor: int) -> bool:
    """Return whether the sensor ids are ignored: those of another IMU, with other true values, give the same readings."""
    if torso.scene.sensordata is not other.scene.sensordata or not np.ptp(torso.got[sensor], axis=0).any():
        return False
    differ = np.abs(torso.scene.true(sensor) - other.scene.true(sensor)).max() > ATOL
    return bool(differ) and same_where_known(other.got[sensor], torso.got[sensor], ATOL)


# ---- readings that do not depend on the state


def measured(student: Student, truth: Traces) -> Explained:
    """Measure `get_imu_readings`; return the facts with the hypotheses that explain them.

    Constant or random numbers could pass `follows_address`, `reading_is_a_copy` and `leaves_simulation_alone`. These are skipped if
    readings never change, unless the code changes qpos (as by a reset) or hypotheses without `cached-reading` explain both sensors.
    They are also skipped if readings change and a sensor is unexplained, and the readings do not follow the simulator's state, have
    no finite number, or take fewer than four values, as signs do.
    """
    facts = facts_of.measure(student, truth)
    if facts.stopped:
        return Explained(facts)
    found = Explained.of(facts)
    known = None not in found.sensors
    if np.ptp(np.nan_to_num([*facts.torso.got, *facts.again.got]), axis=1).any():
        why = "" if known else _by_chance(replace(facts, reverse=facts_of.in_reverse(student, truth)))
    else:  # a reader that resets the simulation shows how it disturbs it
        resets = facts.disturbance[1] > NO_CHANGE
        why = "" if resets or (known and "cached-reading" not in found.values) else _CONSTANT
    return replace(found, facts=facts_of.with_stops(facts, Skipped(why), PLACE, COPY, ALONE)) if why else found


_CONSTANT = "a reading of the simulation: the function returns the same numbers in every state"


def _by_chance(facts: Facts) -> str:
    """Say why readings that no hypothesis predicts cannot be judged; "" if they depend on the simulator's state.

    Another process visits the states in reverse order. What follows them is more like the first visit by state than by call; a
    counter and seeded random numbers are the same by call.
    """
    if not np.isfinite(facts.torso.got).any():
        return "a reading with numbers"
    if len(np.unique(facts.torso.got)) < _FEWEST_VALUES:
        return "a reading of the simulation: the function returns only a few different numbers, such as signs"
    assert facts.reverse is not None
    if max(_rightness([facts.torso], sensor) for sensor in BOTH) >= _MOST:
        return ""
    alike = _likeness(np.array(facts.torso.got), np.array(facts.again.got)) >= _ALIKE
    visits = [np.array(each) for each in zip(facts.torso.got, facts.again.got, facts.reverse, strict=True)]
    follows = any(
        _likeness(one, again) >= _ALIKE and _likeness(one, back) > _likeness(one, back[::-1])
        for one, again, back in visits
    )
    if alike and follows:
        return ""
    return "a reading of the simulation: the function returns other numbers when the same state comes again"


def _likeness(first: Array, again: Array) -> float:
    """Return the correlation of two visits (…, k, 3) to the same states, to see whether readings depend on the state.

    Each channel is taken about its mean in units of its spread. It is 0 if no number is finite or all readings are constant.
    """
    known = np.isfinite(first) & np.isfinite(again)
    if not known.any():
        return 0.0
    spread = np.maximum(np.nanstd(first, axis=-2, keepdims=True), 1e-12)
    a, b = ((visit - np.nanmean(visit, axis=-2, keepdims=True)) / spread for visit in (first, again))
    size = float(np.sqrt((a[known] ** 2).sum() * (b[known] ** 2).sum()))
    return float((a[known] * b[known]).sum()) / size if size else 0.0


# ---- the reasons


_NAMED_VALUES = dict.fromkeys(name for name, _ in value_changes())
_NAMED_PLACES = dict.fromkeys(("swapped-sensors", "wrong-fixed-address", *(name for name, _ in PLACES if name)))


def _lacks_numbers(found: Explained) -> bool:
    return any(map(found.lacks_numbers, BOTH))


REASONS: tuple[Reason[Explained], ...] = (
    Reason(VALUES, 1, "wrong-length", lambda e: not e.facts.whole and (_lacks_numbers(e) or None in e.sensors)),
    Reason(VALUES, 1, "wrong-return-type", lambda e: _lacks_numbers(e) and bool(e.facts.odd) and e.facts.whole),
    Reason(VALUES, 1, "not-finite", lambda e: _lacks_numbers(e) and not e.facts.odd),
    *(Reason(VALUES, 2, told, lambda e, t=told: t in e.values, beside=True) for told in _NAMED_VALUES),  # type: ignore[misc]
    *(Reason(PLACE, 1, told, lambda e, t=told: t in e.places, beside=True) for told in _NAMED_PLACES),  # type: ignore[misc]
    Reason(FORM, 1, "sensor-id-as-address", lambda e: not e.facts.whole and "sensor-id-as-address" in e.places),
    Reason(FORM, 2, "wrong-length", lambda e: not e.facts.whole),
    Reason(FORM, 3, "wrong-return-type", lambda _: True),
    *CALL_REASONS,
    Reason(COPY, 1, "view-not-copy", lambda _: True),
    Reason(ALONE, 1, "disturbs-simulation", lambda _: True),
)


def _departs(found: Explained) -> Sequence[str]:
    """Return the parameters by which the calls differ from the lab sheet's; none if ids are ignored, which is a fault by itself."""
    ignores = PLACE in found.stopped or found.misplaced() is not None
    return () if ignores else found.facts.departs


JUDGE: Judge[Explained] = Judge(LAB, "sensor_access", measured, REASONS, departures("get_imu_readings", _departs))
