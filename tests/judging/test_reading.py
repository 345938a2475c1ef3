"""What a wrong reading is told as, by readers that do to the numbers of two models what students do."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import reading
from grader.labs.imu.diagnosis.reading import Scene, Two
from tests.judging.made import truth

pytestmark = pytest.mark.quick
SCENE, TORSO = Scene.of(truth()["reading_shuffled"]), Scene.of(truth()["reading_lab"], slice(0, 1))
"""Four IMUs whose sensors stand in no order, and the robot's own."""
Reader = Callable[[Scene], Two]
Change = Callable[[Array], Array]


def _at(scene: Scene, first: np.ndarray) -> Array:
    """Three numbers from each place on, none where there are none."""
    padded = np.pad(scene.sensordata, ((0, 0), (3, 99)), constant_values=np.nan)
    return np.array([padded[:, i + 3 : i + 6] for i in first])


def places(accel: Callable[[Scene], np.ndarray], gyro: Callable[[Scene], np.ndarray]) -> Reader:
    return lambda scene: (_at(scene, accel(scene)), _at(scene, gyro(scene)))


def own(sensor: int, shift: int = 0) -> Callable[[Scene], np.ndarray]:
    return lambda scene: scene.address[scene.pairs[:, sensor]] + shift


def identity(sensor: int, factor: int) -> Callable[[Scene], np.ndarray]:
    return lambda scene: factor * scene.pairs[:, sensor]


def values(accel: Change = np.array, gyro: Change = np.array) -> Reader:
    return lambda scene: (accel(scene.accel), gyro(scene.gyro))


def of_either(change: Change) -> list[Reader]:
    return [values(change), values(gyro=change), values(change, change)]


def times(factor: float) -> Change:
    return lambda x: factor * x


def plus(*shift: float) -> Change:
    return lambda x: x + np.array(shift)


def rounded(decimals: int) -> Change:
    return lambda x: np.asarray(np.round(x, decimals))


def then(reader: Reader, change: Change) -> Reader:
    """Another change of both sensors besides."""
    return lambda scene: tuple(map(change, reader(scene)))  # type: ignore[return-value]


def half(scene: Scene) -> Two:
    return scene.accel.astype(np.float16).astype(float), scene.gyro


def turned(accel: bool, gyro: bool, back: bool) -> Reader:
    def read(scene: Scene) -> Two:
        turn = np.swapaxes(scene.world_from_site, 2, 3) if back else scene.world_from_site
        a, g = ((turn @ x[..., None])[..., 0] for x in (scene.accel, scene.gyro))
        return a if accel else scene.accel, g if gyro else scene.gyro

    return read


def without_gravity(sign: float) -> Reader:
    return lambda s: (s.accel + 9.81 * sign * s.world_from_site[:, :, 2], s.gyro)


def state(accel: str = "", gyro: str = "", shift: float = 0.0) -> Reader:
    """Three numbers of a state, `qvel:3` those from the fourth on, in place of a sensor; `shift` is added to the third."""

    def three(scene: Scene, what: str, own: Array) -> Array:
        if not what:
            return own
        name, first = what.split(":")
        part = getattr(scene, name)[..., int(first) : int(first) + 3]
        return np.broadcast_to(part, own.shape)

    def read(scene: Scene) -> Two:
        a, g = three(scene, accel, scene.accel), three(scene, gyro, scene.gyro)
        return (a + np.array([0, 0, shift]) if accel else a), g

    return read


SIGNS = [np.array(signs) for signs in itertools.product((1.0, -1.0), repeat=3)][1:]
ORDERS = list(itertools.permutations(range(3)))[1:]
SHIFTS = [at for at in itertools.product((-1, 0, 1), repeat=2) if at != (0, 0)]
GRAVITIES = (9.81, 9.80665, 9.8)

READERS: dict[tuple[str, ...], list[Reader]] = {
    (): [values(), values(plus(5e-6, 0, 0)), then(values(), rounded(5))],
    ("sensor-id-as-address",): [
        *(places(identity(0, factor), identity(1, factor)) for factor in (1, 3)),
        *(places(identity(0, factor), own(1)) for factor in (1, 3)),
        *(places(own(0), identity(1, factor)) for factor in (1, 3)),
    ],
    ("swapped-sensors",): [places(own(1), own(0))],
    ("same-sensor-twice",): [places(own(sensor), own(sensor)) for sensor in (0, 1)],
    ("hard-coded-address",): [places(own(0), own(0, 3))],
    ("off-by-one-address",): [places(own(0, a), own(1, g)) for a, g in SHIFTS],
    ("sign-flipped",): [reader for signs in SIGNS for reader in of_either(lambda x, s=signs: x * s)],  # type: ignore[misc]
    ("axes-permuted",): [reader for order in ORDERS for reader in of_either(lambda x, o=order: x[..., o])],  # type: ignore[misc]
    ("precision-lost",): [
        *(reader for decimals in range(5) for reader in of_either(rounded(decimals))),
        *of_either(np.trunc),
        half,
    ],
    ("cached-reading",): of_either(lambda x: np.repeat(x[:, :1], x.shape[1], axis=1)),
    ("gravity-removed",): [
        *(values(plus(*shift)) for shift in 9.81 * np.concatenate([np.eye(3), -np.eye(3)])),
        without_gravity(1.0),
        without_gravity(-1.0),
    ],
    ("wrong-units",): [
        *(values(times(1 / gravity)) for gravity in GRAVITIES),
        *(values(times(gravity)) for gravity in GRAVITIES),
        *(values(times(factor)) for factor in (100, 1000, 1 / 0.3048)),
        *(values(gyro=change) for change in (np.degrees, np.radians, times(30 / np.pi), times(0.5 / np.pi))),
        *(values(gyro=times(factor)) for factor in (1000, 1 / 9.81)),
        *(values(times(1 / gravity), np.degrees) for gravity in GRAVITIES),
        values(np.degrees),
    ],
    ("world-frame",): [
        turned(accel, gyro, back)
        for accel, gyro in ((True, True), (True, False), (False, True))
        for back in (False, True)
    ],
    ("not-the-sensor",): [
        *(state(gyro=f"qvel:{first}") for first in (0, 3)),
        *(state(accel=f"{name}:{first}") for name in ("qvel", "qacc", "cacc") for first in (0, 3)),
        state(gyro="cvel:3"),
        *(state(f"cacc:{first}", f"cvel:{3 - first}") for first in (0, 3)),
        *(state(f"cvel:{first}", f"cvel:{3 - first}") for first in (0, 3)),
        *(state(f"{name}:0", "qvel:3") for name in ("qacc", "qvel")),
        *(state("qacc:0", gyro, shift) for gyro in ("", "qvel:3") for shift in (9.81, -9.81)),
    ],
    ("swapped-sensors", "sign-flipped"): [then(places(own(1), own(0)), np.negative)],
    ("off-by-one-address", "wrong-units"): [lambda s: (_at(s, own(0, 1)(s)) / 9.81, s.gyro)],
    ("sign-flipped", "precision-lost"): [then(values(np.negative), rounded(decimals)) for decimals in range(5)],
    ("wrong-units", "precision-lost"): [
        then(values(gyro=np.degrees), rounded(2)),
        then(values(times(100)), rounded(0)),
    ],
}


def test_a_scene_is_of_the_chosen_pairs_first_and_then_of_the_states() -> None:
    recorded = truth()["reading_shuffled"]
    chosen = Scene.of(recorded, slice(1, 3))
    assert np.array_equal(chosen.pairs, recorded["pairs"][1:3])
    assert np.array_equal(chosen.qvel, recorded["qvel"])
    assert np.array_equal(chosen.qacc, recorded["qacc"])
    for held, name in ((chosen.world_from_site, "site_xmat"), (chosen.cvel, "cvel"), (chosen.cacc, "cacc")):
        assert np.array_equal(held, np.array([recorded[name][:, 1], recorded[name][:, 2]]))


CASES = [
    pytest.param(told, reader, id=f"{' and '.join(told) or 'sound'} {number}")
    for told, readers in READERS.items()
    for number, reader in enumerate(readers)
]


@pytest.mark.parametrize(("told", "reader"), CASES)
def test_a_reading_is_told_as_what_was_done_and_is_foreseen_in_another_model(
    told: tuple[str, ...], reader: Reader
) -> None:
    found = reading.explain(*reader(SCENE), SCENE)
    assert found is not None
    assert found.told == told
    assert found.place_mistake in (*told[:1], None)
    assert reading.agrees(*reader(TORSO), found, TORSO)
    assert not reading.agrees(TORSO.accel + 1, TORSO.gyro, found, TORSO)
    assert not reading.agrees(TORSO.accel, TORSO.gyro + 1, found, TORSO)


STRANGE: list[Reader] = [
    values(np.sin),
    values(gyro=np.sin),
    values(plus(2e-5, 0, 0)),
    values(gyro=plus(2e-5, 0, 0)),
    values(lambda x: np.full_like(x, np.nan)),
    values(lambda x: x * np.nan, lambda x: x * np.nan),
    places(own(0, 2), own(1, 2)),
]


def nothing(x: Array) -> Array:
    return 0 * x


@pytest.mark.parametrize("reader", of_either(nothing))
def test_a_sensor_of_zeros_is_not_read_elsewhere_and_rounded(reader: Reader) -> None:
    """Whatever place has small numbers in it would explain them."""
    for scene in (SCENE, TORSO):
        found = reading.explain(*reader(scene), scene)
        assert found is None or found.place_mistake is None


@pytest.mark.parametrize("reader", STRANGE)
def test_what_nobody_foresaw_is_not_told_as_anything(reader: Reader) -> None:
    assert reading.explain(*reader(SCENE), SCENE) is None


def test_a_reading_that_two_mistakes_predict_is_told_as_neither() -> None:
    """The robot's sensors have ids that are a third of the address behind theirs."""
    assert reading.explain(*places(own(0, 1), own(1, 1))(TORSO), TORSO) is None


def test_a_loss_of_precision_is_not_told_twice() -> None:
    found = reading.explain(*values(rounded(1), rounded(3))(SCENE), SCENE)
    assert found is None or found.told == ("precision-lost",)


def test_numbers_that_came_as_none_are_left_out() -> None:
    accel, gyro = SCENE.accel.copy(), SCENE.gyro.copy()
    accel[0, 0] = gyro[1, 2] = np.nan
    found = reading.explain(accel, gyro, SCENE)
    assert found is not None
    assert found.told == ()


# --- treated in a way that has no name -----------------------------------------------------------------------------------

TREATMENTS: dict[str, Reader] = {
    "scaled and shifted": values(lambda x: 2 * x + 1),
    "one sensor is right": values(gyro=lambda x: 3 * x - [0, 1, 2]),
    "mixed": values(lambda x: x @ np.array([[1.0, 2, 3], [0, 1, 0], [5, 0, 1]])),
    "magnitudes": values(np.abs, lambda x: 0.5 * np.abs(x)),
    "directions": values(lambda x: x / np.linalg.norm(x, axis=-1, keepdims=True) * 2 + 1),
}


@pytest.mark.parametrize("name", TREATMENTS)
def test_what_is_done_alike_in_every_state_is_foreseen_elsewhere(name: str) -> None:
    reader = TREATMENTS[name]
    found = reading.treated(*reader(TORSO), TORSO)
    assert found is not None
    assert found.told == ()
    assert reading.agrees(*reader(SCENE), found, SCENE)
    assert not reading.agrees(*values()(SCENE), found, SCENE)


def test_of_numbers_without_a_sign_the_numbers_are_foreseen_and_not_their_magnitudes() -> None:
    positive = replace(TORSO, accel=np.abs(TORSO.accel), gyro=np.abs(TORSO.gyro))
    reader = values(times(2), times(3))
    found = reading.treated(*reader(positive), positive)
    assert found is not None
    assert reading.agrees(*reader(SCENE), found, SCENE)


@pytest.mark.parametrize(
    "reader",
    [
        values(np.sin),
        values(gyro=np.sin),
        values(lambda x: x + np.where(x == x.max(), 2e-5, 0)),
        values(lambda x: x * [1, 1, 0]),
        values(lambda x: x * [np.nan, 1, 1]),
        values(lambda x: np.where(x == x.max(), np.inf, x)),
    ],
)
def test_what_is_done_otherwise_in_some_state_is_no_treatment(reader: Reader) -> None:
    assert reading.treated(*reader(TORSO), TORSO) is None


# --- the same places whatever the ids are ------------------------------------------------------------------------------


def _fixed(accel: int, gyro: int) -> Reader:
    return places(lambda s: np.full(len(s.pairs), accel), lambda s: np.full(len(s.pairs), gyro))


LAST = TORSO.sensordata.shape[1] - 3
ACCEL, GYRO = (int(TORSO.address[sensor]) for sensor in TORSO.pairs[0])


@pytest.mark.parametrize(
    ("accel", "gyro"), [(20, 30), (ACCEL, 30), (20, GYRO), (LAST, GYRO), (ACCEL, LAST), (0, GYRO), (GYRO, ACCEL)]
)
def test_a_reader_of_two_other_places_is_told_as_one(accel: int, gyro: int) -> None:
    reader = _fixed(accel, gyro)
    found = reading.at_fixed_places(*reader(TORSO), TORSO)
    assert found is not None
    assert found.told == ("hard-coded-address",)
    assert reading.agrees(*reader(SCENE), found, SCENE)


@pytest.mark.parametrize(
    "reader",
    [
        values(),
        values(times(2)),
        values(gyro=times(2)),
        values(lambda x: x * np.nan, np.negative),
        values(np.negative, lambda x: x * np.nan),
        lambda s: (s.accel, np.tile([0.0, 1.0, 2.0], (1, len(s.sensordata), 1))),
    ],
)
def test_what_stands_where_it_should_or_nowhere_is_of_no_fixed_place(reader: Reader) -> None:
    at_rest = np.tile([0.0, 1.0, 2.0], (len(TORSO.sensordata), 1))
    rested = replace(TORSO, sensordata=np.hstack([TORSO.sensordata, at_rest]))
    assert reading.at_fixed_places(*reader(rested), rested) is None


@pytest.mark.parametrize(("off", "found"), [(0.9e-5, True), (-0.9e-5, True), (2e-5, False), (-2e-5, False)])
def test_a_copied_number_may_be_rounded(off: float, found: bool) -> None:
    accel, gyro = _fixed(20, 30)(TORSO)
    accel[0, 3, 1] += off
    assert (reading.at_fixed_places(accel, gyro, TORSO) is not None) is found


@pytest.mark.parametrize(("first", "known"), [(-1, 0), (0, 3), (LAST, 3), (LAST + 1, 2), (LAST + 3, 0), (LAST + 9, 0)])
def test_beyond_the_end_of_the_array_there_is_nothing(first: int, known: int) -> None:
    accel, _ = reading.always_reads(first, GYRO).predict(TORSO)
    assert np.isfinite(accel[0]).sum(axis=1).tolist() == [known] * len(TORSO.sensordata)
    assert np.array_equal(accel[0, :, :known], TORSO.sensordata[:, first : first + known])


@pytest.mark.parametrize(
    ("got", "found"),
    [
        (TORSO.sensordata[:, 1:4], True),
        (TORSO.accel[0], False),
        (TORSO.sensordata[:, 1:4] + 1e-3, False),
        (0 * TORSO.accel[0], False),
        (np.vstack([TORSO.sensordata[:-1, 1:4], TORSO.accel[0][-1:]]), False),
    ],
    ids=["another place", "its own", "no place", "no motion", "another place but once"],
)
def test_numbers_from_one_other_place_in_every_state_stand_there(got: Array, found: bool) -> None:
    assert int(TORSO.address[TORSO.pairs[0][0]]) != 1
    assert reading.stands_elsewhere(got, TORSO.accel[0], TORSO.sensordata) is found
