"""Other robots for hidden scenarios: all that the sheet says stays true of them, and no push is like another."""

from __future__ import annotations

import copy
import itertools

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from reference import worlds
from reference.imu_reader import PUSH, simulate_and_collect
from reference.lab_variants import lab_variant
from reference.scene import LAB_PAIR, generator, roll
from reference.variants import FRICTION, MASSES, SPRINGS, TIMESTEPS

SECRETS = 5
"""The fewest of these that draw every time step."""
STANDING = [0.0, 0.0, -9.81]


@pytest.fixture(scope="module")
def texts() -> list[str]:
    return [lab_variant(worlds.lab(), generator("hidden", f"secret {number}", "lab")) for number in range(SECRETS)]


@pytest.fixture(scope="module")
def robots(texts: list[str]) -> list[mujoco.MjModel]:
    return [mujoco.MjModel.from_xml_string(text) for text in texts]


@pytest.fixture(scope="module")
def public() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(worlds.lab())


@pytest.fixture(scope="module")
def standing(robots: list[mujoco.MjModel], public: mujoco.MjModel) -> list[mujoco.MjModel]:
    """The variants, and the lab's own robot at each time step."""
    own = [copy.copy(public) for _ in TIMESTEPS]
    for model, factor in zip(own, TIMESTEPS, strict=True):
        model.opt.timestep *= factor
    return [*own, *robots]


def test_every_robot_stands_by_itself_and_reads_gravity_from_the_first_step_on(standing: list[mujoco.MjModel]) -> None:
    for model in standing:
        trace = roll(model, mujoco.MjData(model), round(5.0 / model.opt.timestep), LAB_PAIR)
        assert np.abs(trace["acceleration"] - STANDING).max() < 0.1
        assert np.ptp(trace["acceleration"], axis=0).max() < 1e-3
        assert np.abs(trace["angular_velocity"]).max() < 1e-4


def test_every_robot_sways_after_the_push_and_stays_up_and_settles(standing: list[mujoco.MjModel]) -> None:
    for model in standing:
        data = mujoco.MjData(model)
        push = simulate_and_collect(model, data, duration_seconds=5.0)
        assert np.abs(push["angular_velocity"][:, 1]).max() > 0.3
        assert np.ptp(push["acceleration"][:, 0]) > 1.0
        assert (push["acceleration"].std(axis=0) > 0.05).all()
        assert (push["angular_velocity"].std(axis=0) > 0.005).all()
        np.testing.assert_allclose(push["acceleration"][-100:].mean(axis=0), STANDING, atol=0.1)
        assert data.qpos[2] == pytest.approx(model.qpos0[2], abs=5e-3)


def test_no_push_is_like_the_public_one_or_like_another(texts: list[str]) -> None:
    """Distance of two recordings of the push, in units of each channel's spread, minimized over shifts and stretches in time."""
    stamps = np.arange(0.02, 1.0, 0.02)
    moves = [stretch * stamps + shift for stretch in np.linspace(0.8, 1.25, 19) for shift in np.linspace(-0.1, 0.1, 21)]
    pushes = [_push_of(text) for text in (worlds.lab(), *texts)]
    for one, other in itertools.permutations(pushes, 2):
        own = _channels_at(one, stamps)
        spread = own.std(axis=1, keepdims=True)
        apart = [np.sqrt(np.mean(((_channels_at(other, move) - own) / spread) ** 2)) for move in moves]
        assert min(apart) > 0.05


def _push_of(xml: str) -> NDArray[np.float64]:
    """The push in a model (n, 7): stamps, acceleration, angular velocity, for as long as the latest of the stamps asks for."""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qvel[0] = PUSH
    trace = roll(model, data, round(1.45 / model.opt.timestep), LAB_PAIR)
    return np.column_stack([trace["time"], trace["acceleration"], trace["angular_velocity"]])


def _channels_at(series: NDArray[np.float64], stamps: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([np.interp(stamps, series[:, 0], channel) for channel in series[:, 1:].T])


def test_the_sensors_are_those_of_the_lab_and_more_in_another_order(
    robots: list[mujoco.MjModel], public: mujoco.MjModel
) -> None:
    known = {public.sensor(i).name: int(public.sensor_dim[i]) for i in range(public.nsensor)}
    for model in robots:
        found = {model.sensor(i).name: int(model.sensor_dim[i]) for i in range(model.nsensor)}
        assert found.items() > known.items()
        assert {1, 3, 4} <= set(found.values())
        addresses = worlds.imu_addresses(model)
        assert addresses.isdisjoint(worlds.LAB_ADDRESSES)
        for place in worlds.LAB_PLACES:
            accel, gyro = (model.sensor(f"{place}_{kind}") for kind in ("accelerometer", "gyroscope"))
            assert accel.id != accel.adr[0]
            assert gyro.id != gyro.adr[0]
            assert gyro.adr[0] != accel.adr[0] + 3
    assert len({tuple(model.sensor_adr) for model in robots}) == len(robots)


def test_masses_springs_dampers_friction_and_time_steps_are_others(
    robots: list[mujoco.MjModel], public: mujoco.MjModel
) -> None:
    heavy = public.body_mass > 0
    sprung = public.jnt_stiffness > 0
    for model in robots:
        masses = model.body_mass[heavy] / public.body_mass[heavy]
        assert masses.min() > MASSES[0] - 1e-6
        assert masses.max() < MASSES[1] + 1e-6
        springs = model.jnt_stiffness[sprung] / public.jnt_stiffness[sprung]
        assert springs.min() > SPRINGS[0] ** 1.5 - 1e-6
        assert springs.max() < SPRINGS[1] ** 1.5 + 1e-6
        assert FRICTION[0] ** 1.5 < model.geom("floor").friction[0] < FRICTION[1] ** 1.5
        assert min(masses.std(), springs.std(), np.abs(model.dof_damping - public.dof_damping).max()) > 0.05
    steps = {round(float(model.opt.timestep / public.opt.timestep), 6) for model in robots}
    assert steps == set(TIMESTEPS)
