"""Diagnosis of a reader (`get_imu_readings`): hypotheses on the address that it reads, and on what it does to the values.

Accelerometer and gyroscope are explained separately. A hypothesis has to predict every number that was returned for every IMU.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grader.engine import hypothesis
from grader.engine.charging import Judge
from grader.engine.findings import Skipped
from grader.engine.hypothesis import Reason
from grader.engine.traces import Traces
from grader.labs.imu.compare import BOTH, NO_CHANGE, SHEETS_NOISE, Array, same_where_known, triple
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import CALL_REASONS, departures
from grader.labs.imu.sensor_access import measure as facts_of
from grader.labs.imu.sensor_access.measure import ATOL, Facts, Scene, Visit
from grader.labs.imu.student import Student

VALUES, PLACE, FORM, COPY, ALONE = facts_of.CHECKS[1], facts_of.CHECKS[2], facts_of.CHECKS[0], *facts_of.CHECKS[3:]
_G = 9.81
_DECIMALS = range(5)
"""Numbers of decimals to which a reader may round; a finer rounding stays below `ATOL`."""
_MOST = 0.5
"""Smallest share of right numbers of the other IMUs for a reader that alters only some of them."""
_ONE_ALTERED = (0.75, 0.5)
"""Shares of the reading: a wrong acceleration shows in the sheet's own trial, which expects [0, 0, -9.81] at rest."""
_ALIKE = 0.5
"""Smallest correlation of two visits to the same states for a reading that depends on the state. A reader of the sensors has 1, one
that smooths over calls nearly 1; 78 random numbers reach 0.5 once in 250,000."""
_FEWEST_VALUES = 4
"""Fewest different numbers in the readings of the robot's IMU that show a sensor. Signs, comparisons and orders have three."""

Place = Callable[[Scene, int], int]
Change = Callable[[Scene, Array], Array]


@dataclass(frozen=True)
class Hypothesis:
    """A guess at what `get_imu_readings` does with one sensor: a fault of the address in sensordata, of the values, both or none.

    Attributes
    ----------
    cost : how implausible the guess is; the cheapest one that fits is the explanation
    place, values : ids of the faults of the address, and of the values
    start : function of a scene and a sensor (0 accelerometer, 1 gyroscope) that returns the address that is read
    change : function that returns the readings that the fault makes of the values at that address
    """

    cost: int
    place: tuple[str, ...]
    values: tuple[str, ...]
    start: Place
    change: Change

    @property
    def cause(self) -> tuple[tuple[str, ...], ...]:
        return self.place, self.values

    def predict(self, scene: Scene, sensor: int) -> Array:
        """Return the readings (states, 3) that this hypothesis predicts for a sensor of a scene's IMU."""
        return self.change(scene, scene.at(self.start(scene, sensor)))

    def fits(self, seen: Seen) -> bool:
        """Return whether this hypothesis predicts every reading of a sensor in given visits (`seen`: the sensor, the visits).

        A changed value predicted as zero throughout, or as no number, proves nothing and does not fit: many faults give zeros.
        """
        sensor, visits = seen
        first = self.predict(visits[0].scene, sensor)
        tells = np.isfinite(first).any() and (not self.values or first.any())
        return bool(tells) and all(_agree(visit.got[sensor], self.predict(visit.scene, sensor)) for visit in visits)


def _agree(got: Array, wanted: Array) -> bool:
    """Return whether all returned numbers are the predicted ones; numbers from beyond the end of sensordata must be missing."""
    return same_where_known(got, wanted, ATOL) or not (np.isfinite(got).any() or np.isfinite(wanted).all())


Seen = tuple[int, Sequence[Visit]]
"""A sensor, and the visits that a hypothesis has to explain."""


# ---- places


def _fixed(start: int) -> Place:
    return lambda _scene, _sensor: start


_PLACES: tuple[tuple[str, Place], ...] = (
    ("", Scene.own),
    ("sensor-id-as-address", lambda scene, sensor: scene.pair[sensor]),
    ("sensor-id-as-address", lambda scene, sensor: 3 * scene.pair[sensor]),
    ("same-sensor-twice", lambda scene, sensor: scene.own(1 - sensor)),
    ("hard-coded-address", lambda scene, sensor: scene.own(0) + 3 if sensor else -1),
    ("off-by-one-address", lambda scene, sensor: scene.own(sensor) - 1),
    ("off-by-one-address", lambda scene, sensor: scene.own(sensor) + 1),
    ("end-of-sensor", lambda scene, sensor: scene.own(sensor) + 3),  # the sizes up to and with the sensor, added up
)


def _fixed_places(torso: Visit, sensor: int) -> Iterator[Hypothesis]:
    """Yield a hypothesis for each address in sensordata that holds the returned numbers in every state, the ids ignored."""
    data, got = torso.scene.sensordata, torso.got[sensor]
    for start in range(data.shape[1] - 2):
        if np.abs(data[:, start : start + 3] - got).max() <= ATOL:
            right = start == torso.scene.own(sensor)
            fault = "hard-coded-address" if right else "wrong-fixed-address"
            yield Hypothesis(3, (fault,), (), _fixed(start), _unchanged)


# ---- values


def _unchanged(_scene: Scene, x: Array) -> Array:
    return x


def _of_numbers(change: Callable[[Array], Array]) -> Change:
    return lambda _scene, x: change(x)


def _rotation(turning: str, frame: str, by_name: bool) -> Change:
    """Return a change that rotates values into or out of the frame of a sensor's site or body; `by_name`: always the torso's."""

    def change(scene: Scene, x: Array) -> Array:
        return np.asarray(np.einsum(turning, getattr(scene.torso if by_name else scene, frame), x))

    return change


def _body_quantity(name: str, first: int, up: float, by_name: bool) -> Change:
    """Return a change that puts another quantity of the simulator, of the sensor's or the torso's body, in place of the values."""

    def change(scene: Scene, _x: Array) -> Array:
        return np.asarray(triple(getattr(scene.torso if by_name else scene, name), first) + np.array([0, 0, up]))

    return change


def _changes() -> Iterator[tuple[str, Change]]:
    """Yield the id and the effect of all known faults that change a sensor's values, such as a flipped sign."""
    for signs in itertools.product((1.0, -1.0), repeat=3):
        yield "sign-flipped", _of_numbers(lambda x, s=signs: x * np.array(s))  # type: ignore[misc]
    for order in itertools.permutations(range(3)):
        yield "axes-permuted", _of_numbers(lambda x, o=order: x[:, list(o)])  # type: ignore[misc]
    for decimals in _DECIMALS:
        yield "precision-lost", _of_numbers(lambda x, d=decimals: x.round(d))  # type: ignore[misc]
    yield "precision-lost", _of_numbers(np.trunc)
    yield "precision-lost", _of_numbers(lambda x: x.astype(np.float16).astype(np.float64))
    yield "cached-reading", _of_numbers(lambda x: np.broadcast_to(x[:1], x.shape))
    for shift in _G * np.concatenate([np.eye(3), -np.eye(3)]):
        yield "gravity-removed", _of_numbers(lambda x, s=shift: x + s)  # type: ignore[misc]
    for sign in (_G, -_G):
        yield "gravity-removed", lambda scene, x, s=sign: x + s * scene.world_from_site[:, 2]  # type: ignore[misc]
    gravity = [factor for g in (_G, 9.80665, 9.8) for factor in (1 / g, g)]
    for factor in (*gravity, 100.0, 1000.0, 1 / 0.3048, 180 / np.pi, np.pi / 180, 60 / (2 * np.pi), 1 / (2 * np.pi)):
        yield "wrong-units", _of_numbers(lambda x, k=factor: k * x)  # type: ignore[misc]
    frames = ("world_from_site", "world_from_body")
    for turning, frame, by_name in itertools.product(("kij,kj->ki", "kji,kj->ki"), frames, (False, True)):
        yield "world-frame", _rotation(turning, frame, by_name)
    for name, first, by_name in itertools.product(("qvel", "qacc", "cvel", "cacc"), (0, 3), (False, True)):
        for up in (0.0, _G, -_G) if name == "qacc" else (0.0,):
            yield "not-the-sensor", _body_quantity(name, first, up, by_name)


@functools.cache
def _hypotheses() -> tuple[Hypothesis, ...]:
    changes = list(_changes())
    rounded = [(v, _then_rounded(change, d)) for v, change in changes if v != "precision-lost" for d in _DECIMALS]
    return (
        *(Hypothesis(bool(place), _ids(place), (), start, _unchanged) for place, start in _PLACES),
        *(
            Hypothesis(1 + bool(p), _ids(p), (v,), start, change)
            for (p, start), (v, change) in itertools.product(_PLACES, changes)
        ),
        *(Hypothesis(2, (), (value, "precision-lost"), Scene.own, change) for value, change in rounded),
    )


@functools.cache
def _two_faults() -> tuple[Hypothesis, ...]:
    """Return hypotheses of two faults at once, of the address or of the values, for a reader that no single fault explains."""
    places = [(fault, start) for fault, start in _PLACES if fault in _SHIFTED]
    changes = [(fault, change) for fault, change in _changes() if fault in _COMBINED]
    return (
        *(
            Hypothesis(2, (fault, "off-by-one-address"), (), _shifted(start, by), _unchanged)
            for (fault, start), by in itertools.product(places, (-1, 1))
        ),
        *(
            Hypothesis(2, (fault, "same-sensor-twice"), (), _of_the_other(start), _unchanged)
            for fault, start in places
            if fault != "same-sensor-twice"
        ),
        *(
            Hypothesis(3, (), tuple(sorted({one, other})), Scene.own, _one_after_another(first, then))
            for (one, first), (other, then) in itertools.product(changes, repeat=2)
        ),
    )


def _shifted(start: Place, by: int) -> Place:
    return lambda scene, sensor: start(scene, sensor) + by


def _of_the_other(start: Place) -> Place:
    return lambda scene, sensor: start(scene, 1 - sensor)


def _one_after_another(first: Change, then: Change) -> Change:
    return lambda scene, x: then(scene, first(scene, x))


_SHIFTED = ("sensor-id-as-address", "same-sensor-twice", "end-of-sensor")
_COMBINED = ("sign-flipped", "gravity-removed", "wrong-units", "axes-permuted")


def _ids(*faults: str) -> tuple[str, ...]:
    return tuple(filter(None, faults))


def _then_rounded(change: Change, decimals: int) -> Change:
    return lambda scene, x: change(scene, x).round(decimals)


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
        """The faults (ids) of the addresses read: those of the hypotheses, else `hard-coded-address` if other IMUs show it."""
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
        """Return a scene's true values (k, 3) at the address that is read for a sensor, at the right address if that is unknown."""
        known = self.sensors[sensor]
        return visit.scene.true(sensor) if known is None else visit.scene.at(known.start(visit.scene, sensor))

    @property
    def wrong_on_torso(self) -> list[int]:
        """The sensors (0 accelerometer, 1 gyroscope) of the robot's own IMU whose numbers are not those at the address read."""
        return [i for i in BOTH if (known := self.sensors[i]) is None or known.values or self.lacks_numbers(i)]

    @property
    def share_altered(self) -> float:
        """Share of `matches_truth`'s points that altered values cost: all, or a part if only one sensor is and gravity is kept."""
        whole = len(self.wrong_on_torso) != 1 or "gravity-removed" in self.values
        return 1.0 if whole else _ONE_ALTERED[self.wrong_on_torso[0]]

    @property
    def share_misplaced(self) -> float:
        """Share of `follows_address`'s points that wrong addresses cost: half for each sensor so read, all if ids are ignored."""
        faults = {fault for each in self.sensors if each for fault in each.place}
        computed = faults - {"hard-coded-address", "wrong-fixed-address"}
        if not computed or self._ids_are_ignored:
            return 1.0
        return sum(bool(each and each.place) for each in self.sensors) / len(BOTH)

    def altered(self) -> tuple[Visit, int] | None:
        """Return where values are altered, to show it: readings in a scene, and a sensor; None if no values are altered.

        The robot's own IMU comes first, then other IMUs of which most numbers are right.
        """
        wrong = self.wrong_on_torso
        others = ((v, i) for v in self.facts.visits[1:] for i in BOTH if self._partly_right(i) and not self._fits(v, i))
        return (self.facts.torso, wrong[0]) if wrong else next(others, None)

    def misplaced(self) -> tuple[Visit, int] | None:
        """Return where a wrong address is read, to show it: readings in a scene, and a sensor; None if all addresses are right."""
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
        return known is not None and _agree(visit.got[sensor], known.predict(visit.scene, sensor))

    def _partly_right(self, sensor: int) -> bool:
        """Return whether at least half of the numbers of the other IMUs are right, so that the rest is altered, not misplaced."""
        return _rightness(self.facts.visits[1:], sensor) >= _MOST

    def lacks_numbers(self, sensor: int) -> bool:
        """Return whether too few finite numbers were returned for a sensor, and no wrong address explains it."""
        known, got = self.sensors[sensor], self.facts.torso.got[sensor]
        return not np.isfinite(got).all() and not (known and known.place)

    def near(self, visit: Visit) -> bool:
        """Return whether both sensors' values in a visit are off by less than a real sensor's noise, for which half is deducted."""
        pairs = zip(visit.got, (self.meant(visit, i) for i in BOTH), SHEETS_NOISE, strict=True)
        return all(bool(np.abs(got - there).max() <= little) for got, there, little in pairs)


_NOT_FOUND = ("KeyError", "ValueError", "IndexError")


def _explain(facts: Facts, sensor: int) -> Hypothesis | None:
    """Return the cheapest hypothesis for a sensor that predicts all IMUs, else one that predicts the robot's own; None without."""
    everywhere = (*_hypotheses(), *_two_faults(), *_fixed_places(facts.torso, sensor))
    return explained(everywhere, sensor, facts.visits) or explained(_hypotheses(), sensor, [facts.torso])


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
    """Return what was measured of `get_imu_readings`, explained; skip three checks if readings do not depend on the state.

    These are the checks that the address is followed, that a reading is a copy, and that the simulation is left alone.
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


_NAMED_VALUES = dict.fromkeys(name for name, _ in _changes())
_NAMED_PLACES = dict.fromkeys(("swapped-sensors", "wrong-fixed-address", *(name for name, _ in _PLACES if name)))


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
