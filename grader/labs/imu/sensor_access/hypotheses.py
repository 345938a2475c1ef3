"""Hypotheses on a reader (`get_imu_readings`): the address in sensordata that it reads, and what it does to the values there."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from grader.labs.imu.compare import Array, same_where_known, triple
from grader.labs.imu.sensor_access.measure import ATOL, Scene, Visit

_G = 9.81
_DECIMALS = range(5)
"""Numbers of decimals to which a reader may round; a finer rounding stays below `ATOL`."""

Place = Callable[[Scene, int], int]
Change = Callable[[Scene, Array], Array]


@dataclass(frozen=True)
class Hypothesis:
    """A guess at what `get_imu_readings` does with one sensor: a fault of the address in sensordata, of the values, both or none.

    Attributes
    ----------
    cost : how implausible the guess is; the cheapest one that fits is the explanation
    place, values : ids of the faults of the address, and of the values; empty without a fault
    start : function of a `Scene` (an IMU in some states) and a sensor (0 accelerometer, 1 gyroscope) that returns the address read
    change : function of the scene and the values (states, 3) at that address that returns the readings made of these values
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

        False if it predicts only NaN for the first visit, or, with a fault of the values, only zeros: many faults predict these.
        """
        sensor, visits = seen
        first = self.predict(visits[0].scene, sensor)
        tells = np.isfinite(first).any() and (not self.values or first.any())
        return bool(tells) and all(agrees(visit.got[sensor], self.predict(visit.scene, sensor)) for visit in visits)


def agrees(got: Array, wanted: Array) -> bool:
    """Return whether all returned numbers are the predicted ones; if none were returned, whether a predicted one is NaN.

    NaN is predicted for an address beyond the ends of sensordata.
    """
    return same_where_known(got, wanted, ATOL) or not (np.isfinite(got).any() or np.isfinite(wanted).all())


Seen = tuple[int, Sequence[Visit]]
"""A sensor, and the visits that a hypothesis has to explain."""


# ---- places


def _fixed(start: int) -> Place:
    return lambda _scene, _sensor: start


PLACES: tuple[tuple[str, Place], ...] = (
    ("", Scene.own),
    ("sensor-id-as-address", lambda scene, sensor: scene.pair[sensor]),
    ("sensor-id-as-address", lambda scene, sensor: 3 * scene.pair[sensor]),
    ("same-sensor-twice", lambda scene, sensor: scene.own(1 - sensor)),
    ("hard-coded-address", lambda scene, sensor: scene.own(0) + 3 if sensor else -1),
    ("off-by-one-address", lambda scene, sensor: scene.own(sensor) - 1),
    ("off-by-one-address", lambda scene, sensor: scene.own(sensor) + 1),
    ("end-of-sensor", lambda scene, sensor: scene.own(sensor) + 3),  # the sizes up to and with the sensor, added up
)
"""Known addresses that readers use: the id of the fault ("" for the right address), and the address in a scene for a sensor."""


def fixed_places(torso: Visit, sensor: int) -> Iterator[Hypothesis]:
    """Yield a hypothesis for each constant address in sensordata that explains all readings of a sensor of the IMU `torso`."""
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


def value_changes() -> Iterator[tuple[str, Change]]:
    """Yield each known fault that changes a sensor's values, such as a flipped sign: its id, and a function that applies it."""
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
def one_fault() -> tuple[Hypothesis, ...]:
    """Return hypotheses that `get_imu_readings` is right, reads a wrong address, changes the values (as by a wrong sign), or both.

    Values from the right address may be changed in one way and then rounded.
    """
    changes = list(value_changes())
    rounded = [(v, _then_rounded(change, d)) for v, change in changes if v != "precision-lost" for d in _DECIMALS]
    return (
        *(Hypothesis(bool(place), _ids(place), (), start, _unchanged) for place, start in PLACES),
        *(
            Hypothesis(1 + bool(p), _ids(p), (v,), start, change)
            for (p, start), (v, change) in itertools.product(PLACES, changes)
        ),
        *(Hypothesis(2, (), (value, "precision-lost"), Scene.own, change) for value, change in rounded),
    )


@functools.cache
def two_faults() -> tuple[Hypothesis, ...]:
    """Return hypotheses of two faults at once, both in the address that is read or both in what is done to the values there."""
    places = [(fault, start) for fault, start in PLACES if fault in _SHIFTED]
    changes = [(fault, change) for fault, change in value_changes() if fault in _COMBINED]
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
