"""Faults of a reader, by facts that are built by hand: four sensors in one array, an IMU of two and another of two."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.faults import rows
from grader.engine.findings import Charge, Fault
from grader.labs.imu.compare import Array
from grader.labs.imu.lab import LAB
from grader.labs.imu.sensor_access import checks, explain
from grader.labs.imu.sensor_access.explain import PART, Explained
from grader.labs.imu.sensor_access.measure import Facts, Scene, Visit

pytestmark = pytest.mark.quick
_RNG = np.random.default_rng(3)
_DATA, _STATES = _RNG.normal(0, 4, (13, 14)), _RNG.normal(0, 4, (13, 9))
_ADDRESS = np.array([0, 1, 4, 7, 8, 11])
_TURN = np.linalg.qr(_RNG.normal(size=(13, 3, 3)))[0]
Read = Callable[[Scene, int], Array]


def _scene(*pair: int) -> Scene:
    return Scene(_DATA, _ADDRESS, (pair[0], pair[1]), _TURN, _STATES, _STATES + 1, _STATES[:, :6], _STATES[:, 3:])


def _right(scene: Scene, sensor: int) -> Array:
    return scene.true(sensor)


def _facts(read: Read = _right, fault: Fault | None = None) -> Facts:
    torso, other = (Visit(scene, (read(scene, 0), read(scene, 1))) for scene in (_scene(1, 2), _scene(5, 4)))
    now = np.array([torso.got[0][0], torso.got[1][0]])
    return Facts(torso, torso, (replace(other, fault=fault),), now, np.zeros(4))


def _charged(facts: Facts) -> dict[str, tuple[float, list[str]]]:
    """The share that each lost check keeps, with the faults that are named."""
    assert checks.PART is PART
    charges = PART.judge(Explained.of(facts), rows(LAB)).values()
    lost = [charge for charge in charges if isinstance(charge, Charge) and charge.found]
    return {charge.check.partition(".")[2]: (charge.keeps, [id_ for id_, _ in charge.found]) for charge in lost}


@pytest.mark.parametrize(
    ("read", "check", "named"),
    [
        (lambda s, i: s.true(i) * (-1 if i else 1 / 9.81), "matches_truth", ["sign-flipped", "wrong-units"]),
        (lambda s, i: np.sin(s.true(i)) if i else s.true(i), "matches_truth", ["sensor_access.matches_truth"]),
        (lambda s, i: s.true(i) * (np.nan if i else 1), "matches_truth", ["not-finite"]),
        (lambda s, i: s.true(1 - i), "follows_address", ["swapped-sensors"]),
        (lambda s, _: s.true(0), "follows_address", ["same-sensor-twice"]),
        (lambda s, i: s.at(3 * s.pair[i]), "follows_address", ["sensor-id-as-address"]),
        (lambda s, i: s.at(s.own(i) + 1) if i else s.at(s.pair[i]), "follows_address", ["sensor-id-as-address", "off-by-one-address"]),
        (lambda _, i: _DATA[:, 3 * i + 2 : 3 * i + 5], "follows_address", ["hard-coded-address"]),
    ],
)  # fmt: skip
def test_a_fault_is_charged_once_and_one_in_each_sensor_is_named_for_each(
    read: Read, check: str, named: list[str]
) -> None:
    assert _charged(_facts()) == {}
    assert _charged(_facts(read)) == {check: (0.0, named)}


def test_digits_that_are_lost_within_a_sensors_noise_cost_half() -> None:
    assert _charged(_facts(lambda s, i: s.true(i).round(3))) == {"matches_truth": (0.5, ["precision-lost"])}


@pytest.mark.parametrize(
    ("kind", "named"), [("KeyError", "hard-coded-address"), ("TypeError", "sensor_access.follows_address")]
)
def test_an_exception_in_another_model_is_charged_to_the_place(kind: str, named: str) -> None:
    fault = Fault(kind, "torso", "imu_reader.py", 12, "data.sensor('torso')")
    assert _charged(_facts(fault=fault)) == {"follows_address": (0.0, [named])}


@pytest.mark.parametrize(("reverse", "follows"), [(1, True), (-1, False)])
def test_readings_follow_the_states_and_not_the_number_of_the_call(reverse: int, follows: bool) -> None:
    facts = _facts(lambda s, i: np.sin(s.true(i)))
    back = facts.torso.got[0][::reverse], facts.torso.got[1][::reverse]
    assert (explain._by_chance(replace(facts, reverse=back)) == "") is follows
