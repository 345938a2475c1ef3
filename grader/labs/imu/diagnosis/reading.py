"""From a wrong reading to the mistake that predicts it: every mistake is tried on the truth, and the one that fits is named.

A reading can be wrong in two independent ways: it looks at the wrong *place* of ``sensordata``, or it alters the *values*.
Each candidate predicts what a reader with that mistake returns; place and value mistakes combine.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grader.engine import hypothesis
from grader.engine.traces import Scenario
from grader.labs.imu.compare import Array, same_where_known

ATOL = 1e-5
"""m/s², rad/s. A reader copies numbers: single precision keeps 1e-6 of 10 m/s², rounding to four decimals breaks 5e-5."""


@dataclass(frozen=True)
class Scene:
    """What the simulator holds while a reader is called with p pairs of sensors in k states.

    Attributes
    ----------
    accel, gyro : (p, k, 3) ndarray, the truth in m/s² and rad/s, site frame
    sensordata : (k, n) ndarray; address : (sensors,) first index of each sensor; pairs : (p, 2) sensor ids
    world_from_site : (p, k, 3, 3) ndarray; qvel, qacc : (k, nv) ndarray
    cvel, cacc : (p, k, 6) ndarray, velocity and acceleration of the accelerometer's body as MuJoCo keeps them: rotation, then
        translation, in the world's axes
    """

    accel: Array
    gyro: Array
    sensordata: Array
    address: np.ndarray
    pairs: np.ndarray
    world_from_site: Array
    qvel: Array
    qacc: Array
    cvel: Array
    cacc: Array

    @classmethod
    def of(cls, scenario: Scenario, pairs: slice = slice(None)) -> Scene:
        address, chosen, data = scenario["sensor_adr"], scenario["pairs"][pairs], scenario["sensordata"]
        accel, gyro = (np.array([data[:, address[i] : address[i] + 3] for i in column]) for column in chosen.T)
        turn, cvel, cacc = (scenario[key][:, pairs].swapaxes(0, 1) for key in ("site_xmat", "cvel", "cacc"))
        return cls(accel, gyro, data, address, chosen, turn, scenario["qvel"], scenario["qacc"], cvel, cacc)


Two = tuple[Array, Array]
Place = Callable[[Scene], Two]
Value = Callable[[Scene, Array, Array], Two]


@dataclass(frozen=True)
class _Returned:
    """What a reader returned in a scene: (p, k, 3) accelerations and angular velocities."""

    accel: Array
    gyro: Array
    scene: Scene

    @cached_property
    def at(self) -> Callable[[Place], Two]:
        """What stands at a place of the scene: a hundred hypotheses read at each of a few."""
        return functools.cache(lambda place: place(self.scene))


@dataclass(frozen=True)
class Explanation:
    """A hypothesis about a reader: the mistakes in it, and how to predict other scenes from it."""

    place_mistake: str | None
    value_mistakes: tuple[str, ...]
    place: Place
    value: Value

    def predict(self, scene: Scene) -> Two:
        return self.value(scene, *self.place(scene))

    def fits(self, seen: _Returned) -> bool:
        accel, gyro = self.value(seen.scene, *seen.at(self.place))
        if self.place_mistake and self.value_mistakes and not (accel.any() and gyro.any()):
            return False  # zeros are what becomes of any place
        return same_where_known(seen.accel, accel, ATOL) and same_where_known(seen.gyro, gyro, ATOL)

    @property
    def told(self) -> tuple[str, ...]:
        """The mistakes."""
        return (*((self.place_mistake,) if self.place_mistake else ()), *self.value_mistakes)

    @property
    def cost(self) -> int:
        return len(self.told)


def explain(accel: Array, gyro: Array, scene: Scene) -> Explanation | None:
    """The explanation of what a reader returned (p, k, 3), or None where nothing fits or several things do.

    The simplest wins: nothing wrong, then one mistake, then one of each kind.
    """
    return hypothesis.first_that_fits(_by_cost(), _Returned(accel, gyro, scene))


def treated(accel: Array, gyro: Array, scene: Scene) -> Explanation | None:
    """An explanation without a name: the right sensors, mixed, scaled or shifted in the same way in every state; or None.

    Their numbers, magnitudes or directions are. Four numbers an axis are fitted to a dozen states and more, which no other
    reading obeys by chance.
    """
    of_accel, of_gyro = _treatment(accel[0], scene.accel[0]), _treatment(gyro[0], scene.gyro[0])
    if of_accel is None or of_gyro is None:
        return None
    return Explanation(None, (), _at(0, 0), lambda _, a, g: (of_accel(a), of_gyro(g)))


def _treatment(got: Array, true: Array) -> Change | None:
    for part in (np.array, np.abs, _direction):
        fit = _affine(got, part(true))
        if fit is not None:
            return lambda x, part=part, fit=fit: part(x) @ fit[:3] + fit[3]  # type: ignore[misc]
    return None


def _direction(x: Array) -> Array:
    unit: Array = x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-300)
    return unit


def at_fixed_places(accel: Array, gyro: Array, scene: Scene) -> Explanation | None:
    """The explanation of a reader that, in every state, returns what stands at two other places of sensordata; or None.

    Whether it does so whatever the ids are, is seen with other ids.
    """
    got = (accel[0], gyro[0])
    starts = [_start(numbers, scene.sensordata) for numbers in got]
    if starts[0] is None or starts[1] is None:
        return None
    own = [int(scene.address[sensor]) for sensor in scene.pairs[0]]
    # Numbers that never move stand anywhere: they tell of a place only beside others that stand where they should not.
    elsewhere = [start != at and np.ptp(its, axis=0).any() for start, at, its in zip(starts, own, got, strict=True)]
    return always_reads(starts[0], starts[1]) if any(elsewhere) else None


def stands_elsewhere(got: Array, true: Array, sensordata: Array) -> bool:
    """Whether these numbers (k, 3) move, are not the true ones, and stand at one other place of sensordata in every state."""
    moves, off = np.ptp(got, axis=0).any(), np.abs(got - true).max() > ATOL
    return bool(moves and off) and _start(got, sensordata) is not None


def _start(got: Array, sensordata: Array) -> int | None:
    """The first place where these three numbers (k, 3) stand in every state."""
    if not np.isfinite(got).all():
        return None
    places = range(sensordata.shape[1] - 2)
    return next((i for i in places if np.abs(sensordata[:, i : i + 3] - got).max() <= ATOL), None)


def _affine(got: Array, true: Array) -> Array | None:
    """(4, 3) weights of the three axes and an offset that turn the truth (k, 3) into what came; None where none do."""
    if not np.isfinite(got).all() or not np.ptp(got, axis=0).all():
        return None
    columns = np.column_stack([true, np.ones(len(true))])
    weights: np.ndarray = np.linalg.lstsq(columns, got, rcond=None)[0]
    return weights if np.abs(columns @ weights - got).max() <= ATOL else None


def agrees(accel: Array, gyro: Array, explanation: Explanation, scene: Scene) -> bool:
    """Whether the same explanation predicts another scene, too."""
    return explanation.fits(_Returned(accel, gyro, scene))


@functools.cache
def _by_cost() -> tuple[tuple[Explanation, ...], ...]:
    return hypothesis.by_cost(_hypotheses())


def _hypotheses() -> Iterator[Explanation]:
    """Nothing wrong; a place, a value; both, or a value that is rounded besides."""
    values: list[tuple[tuple[str, ...], Value]] = [
        ((), _as_is),
        *(((name,), value) for name, value in _value_mistakes()),
    ]
    for (place_mistake, place), (names, value) in itertools.product(_PLACES, values):
        yield Explanation(place_mistake, names, place, value)
    for (names, value), decimals in itertools.product(values, _DECIMALS):
        if names != ("precision-lost",):
            yield Explanation(None, (*names, "precision-lost"), _at(0, 0), _rounded(value, decimals))


# --- places --------------------------------------------------------------------------------------------------------------


def slices(scene: Scene, accel_at: np.ndarray, gyro_at: np.ndarray) -> Two:
    """What ``sensordata[i:i+3]`` holds for each pair (p,); NaN where the slice runs out of the array."""

    accel, gyro = ([_three(scene.sensordata, int(first)) for first in places] for places in (accel_at, gyro_at))
    return np.array(accel), np.array(gyro)


def _three(rows: Array, first: int) -> Array:
    """Columns ``first:first+3`` of (k, n); NaN where they run out of it: a robot may have few joints and few sensors."""
    out = np.full((len(rows), 3), np.nan)
    part = rows[:, first : first + 3] if first >= 0 else rows[:, :0]
    out[:, : part.shape[1]] = part
    return out


def _at(accel_shift: int, gyro_shift: int) -> Place:
    def place(scene: Scene) -> Two:
        first, second = scene.address[scene.pairs.T]
        return slices(scene, first + accel_shift, second + gyro_shift)

    return place


def _ids_as_addresses(factor: int, *sensors: int) -> Place:
    """Of the accelerometer (0), the gyroscope (1) or both."""

    def place(scene: Scene) -> Two:
        first = scene.address[scene.pairs.T]
        for sensor in sensors:
            first[sensor] = factor * scene.pairs[:, sensor]
        return slices(scene, *first)

    return place


def _twice(sensor: int) -> Place:
    return lambda scene: slices(scene, *[scene.address[scene.pairs[:, sensor]]] * 2)


def _swapped(scene: Scene) -> Two:
    first, second = scene.address[scene.pairs.T]
    return slices(scene, second, first)


def _gyro_behind_accel(scene: Scene) -> Two:
    first = scene.address[scene.pairs[:, 0]]
    return slices(scene, first, first + 3)


_PLACES: list[tuple[str | None, Place]] = [
    (None, _at(0, 0)),
    *(
        ("sensor-id-as-address", _ids_as_addresses(factor, *which))
        for factor in (1, 3)
        for which in ((0, 1), (0,), (1,))
    ),
    ("swapped-sensors", _swapped),
    ("same-sensor-twice", _twice(0)),
    ("same-sensor-twice", _twice(1)),
    ("hard-coded-address", _gyro_behind_accel),
    *(("off-by-one-address", _at(a, g)) for a in (-1, 0, 1) for g in (-1, 0, 1) if (a, g) != (0, 0)),
]


def always_reads(accel_at: int, gyro_at: int) -> Explanation:
    """The explanation of a reader that looks at two fixed places, whatever ids it is given."""

    def place(scene: Scene) -> Two:
        return slices(scene, np.full(len(scene.pairs), accel_at), np.full(len(scene.pairs), gyro_at))

    return Explanation("hard-coded-address", (), place, _as_is)


# --- values --------------------------------------------------------------------------------------------------------------

_G = 9.81
_DECIMALS = range(5)
"""More of them are lost within the tolerance."""


def _as_is(scene: Scene, accel: Array, gyro: Array) -> Two:
    del scene
    return accel, gyro


Change = Callable[[Array], Array]


def alterations() -> Iterator[tuple[str, Change]]:
    """What readers do to the numbers (…, 3) of either sensor, by the name of the mistake."""
    for signs in itertools.product((1.0, -1.0), repeat=3):
        if -1.0 in signs:
            yield "sign-flipped", lambda x, s=signs: x * np.array(s)  # type: ignore[misc]
    for order in itertools.permutations(range(3)):
        if order != (0, 1, 2):
            yield "axes-permuted", lambda x, o=order: x[..., list(o)]  # type: ignore[misc]
    for decimals in _DECIMALS:
        yield "precision-lost", lambda x, d=decimals: x.round(d)  # type: ignore[misc]
    yield "precision-lost", np.trunc
    yield "precision-lost", lambda x: x.astype(np.float16).astype(np.float64)


def alterations_of_acceleration() -> Iterator[tuple[str, Change]]:
    """Yield (fault, change) for faults of accelerations alone: gravity removed, or wrong units."""
    for shift in _G * np.concatenate([np.eye(3), -np.eye(3)]):
        yield "gravity-removed", lambda x, s=shift: x + s  # type: ignore[misc]
    yield from _scalings(*(factor for g in (_G, 9.80665, 9.8) for factor in (1 / g, g)), 100.0, 1000.0, 1 / 0.3048)


def alterations_of_rate() -> Iterator[tuple[str, Change]]:
    """What they do to angular velocities alone."""
    yield from _scalings(180 / np.pi, np.pi / 180, 60 / (2 * np.pi), 1 / (2 * np.pi), 1000.0, 1 / _G)


def _scalings(*factors: float) -> Iterator[tuple[str, Change]]:
    for factor in factors:
        yield "wrong-units", lambda x, k=factor: k * x  # type: ignore[misc]


def _value_mistakes() -> Iterator[tuple[str, Value]]:
    for name, change in (*alterations(), ("cached-reading", _first_only)):
        yield name, lambda _, a, g, c=change: (c(a), g)  # type: ignore[misc]
        yield name, lambda _, a, g, c=change: (a, c(g))  # type: ignore[misc]
        yield name, lambda _, a, g, c=change: (c(a), c(g))  # type: ignore[misc]
    for name, change in alterations_of_acceleration():
        yield name, lambda _, a, g, c=change: (c(a), g)  # type: ignore[misc]
    for name, change in alterations_of_rate():
        yield name, lambda _, a, g, c=change: (a, c(g))  # type: ignore[misc]
    for gravity in (_G, 9.80665, 9.8):
        yield "wrong-units", lambda _, a, g, k=gravity: (a / k, np.degrees(g))  # type: ignore[misc]
    yield "wrong-units", lambda _, a, g: (np.degrees(a), g)  # with the sensors swapped
    yield "gravity-removed", _gravity_rotated_away(1.0)
    yield "gravity-removed", _gravity_rotated_away(-1.0)
    for turning in ("pkij,pkj->pki", "pkji,pkj->pki"):  # into the world's axes, or the wrong way round
        for sensors in ((True, True), (True, False), (False, True)):
            yield "world-frame", _turned(turning, *sensors)
    yield from _other_states()


def _rounded(value: Value, decimals: int) -> Value:
    """A value mistake, rounded on top of it."""

    def rounded(scene: Scene, accel: Array, gyro: Array) -> Two:
        a, g = value(scene, accel, gyro)
        return a.round(decimals), g.round(decimals)

    return rounded


def _first_only(x: Array) -> Array:
    """The first reading, given again in every state."""
    return np.broadcast_to(x[:, :1], x.shape)


def _turned(turning: str, accel_too: bool, gyro_too: bool) -> Value:
    def value(scene: Scene, accel: Array, gyro: Array) -> Two:
        def turn(x: Array) -> Array:
            turned: Array = np.einsum(turning, scene.world_from_site, x)
            return turned

        return (turn(accel) if accel_too else accel), (turn(gyro) if gyro_too else gyro)

    return value


def _gravity_rotated_away(sign: float) -> Value:
    """Gravity taken off in the sensor's own frame: what remains is the coordinate acceleration."""

    def value(scene: Scene, accel: Array, gyro: Array) -> Two:
        up = np.array([0.0, 0.0, sign * _G])
        return accel + np.einsum("pkji,j->pki", scene.world_from_site, up), gyro

    return value


def _body_states() -> list[Value]:
    """What MuJoCo keeps of the body that the IMU is on, either half of it."""
    rotation, translation = slice(0, 3), slice(3, 6)
    return [
        lambda s, _, g: (s.cacc[..., translation], g),
        lambda s, _, g: (s.cacc[..., rotation], g),
        lambda s, a, _: (a, s.cvel[..., translation]),
        lambda s, _, __: (s.cacc[..., translation], s.cvel[..., rotation]),
        lambda s, _, __: (s.cacc[..., rotation], s.cvel[..., translation]),
        lambda s, _, __: (s.cvel[..., translation], s.cvel[..., rotation]),
        lambda s, _, __: (s.cvel[..., rotation], s.cvel[..., translation]),
    ]


def _other_states() -> Iterator[tuple[str, Value]]:
    def spread(scene: Scene, part: Array) -> Array:
        return np.broadcast_to(part, (len(scene.pairs), *part.shape))

    for first in (0, 3):
        yield "not-the-sensor", lambda s, a, _, i=first: (a, spread(s, _three(s.qvel, i)))  # type: ignore[misc]
        yield "not-the-sensor", lambda s, _, g, i=first: (spread(s, _three(s.qvel, i)), g)  # type: ignore[misc]
        yield "not-the-sensor", lambda s, _, g, i=first: (spread(s, _three(s.qacc, i)), g)  # type: ignore[misc]
    yield from (("not-the-sensor", v) for v in _body_states())
    yield "not-the-sensor", lambda s, _, __: (spread(s, _three(s.qacc, 0)), spread(s, _three(s.qvel, 3)))
    yield "not-the-sensor", lambda s, _, __: (spread(s, _three(s.qvel, 0)), spread(s, _three(s.qvel, 3)))
    for gravity in (_G, -_G):
        shift = np.array([0.0, 0.0, gravity])
        yield "not-the-sensor", lambda s, _, g, d=shift: (spread(s, _three(s.qacc, 0) + d), g)  # type: ignore[misc]
        both: Value = lambda s, _, __, d=shift: (spread(s, _three(s.qacc, 0) + d), spread(s, _three(s.qvel, 3)))  # type: ignore[misc] # noqa: E731
        yield "not-the-sensor", both
