"""Questions about the noisy IMU: many reads in a simulation that does not move."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from typing import Any

import numpy as np

from grader.worker import repeatability, submission
from grader.worker.calling import plan_call
from grader.worker.values import Packer, numbers

from . import calls, own_globals
from .questions import (
    Reply,
    changes_of,
    parts_of,
    put_in_state,
    reporting_errors,
    scene,
    state_of,
    vectors_in,
)

_RATE = re.compile(r"gyr|ang|omega|rate", re.IGNORECASE)


def noise(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Build one `NoisyIMU` and read it many times, in one state after the other.

    Parameters
    ----------
    fields : ``path``, ``model``, ``accel_id``, ``gyro_id``, ``reads`` (per state), ``accel_noise_std``, ``gyro_noise_std``
    arrays : ``qpos`` (s, nq), ``qvel`` (s, nv); ``accel_bias`` (3,), ``gyro_bias`` (3,) if biases are given

    Returns
    -------
    arrays ``accel``, ``gyro`` (s, reads, 3), NaN if a read did not return two vectors of three (``odd``: the first such value);
    ``disturbance`` (s, 4), as for `read`.
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": [], "done": 0}
    readings = np.full((len(arrays["qpos"]), fields["reads"], 6), np.nan)
    disturbance: list[list[float]] = []
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        put_in_state(model, data, arrays["qpos"][0], arrays["qvel"][0])
        build = _imu_builder(fields, model, data, answer)
        read = build(arrays)
        for state in range(len(readings)):
            still = _FrozenSimulation(fields, model, data, arrays["qpos"][state], arrays["qvel"][state])
            for index, row in enumerate(readings[state]):
                _store(read(), row, answer, packer)
                if index == 0:
                    disturbance.append(still.changes())
                still.restore(row)
                answer["done"] += 1
    return answer, packer.arrays | {
        "accel": readings[:, :, :3],
        "gyro": readings[:, :, 3:],
        "disturbance": np.array(disturbance).reshape(-1, 4),
    }


def noise_twins(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Build several `NoisyIMU`s that differ in one thing, each from the same seed, and read each a few times in one state.

    All of them are in one question, so that an error or an endless loop costs its time once.

    Parameters
    ----------
    fields : ``path``, ``model``, ``accel_id``, ``gyro_id``, ``reads``; ``twins``: the two standard deviations of each;
        ``states``: the row of the state of each
    arrays : ``qpos`` (s, nq), ``qvel`` (s, nv), ``biases`` (twins, 2, 3)

    Returns
    -------
    arrays ``accel``, ``gyro`` (twins, reads, 3).
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": []}
    readings = np.full((len(fields["twins"]), fields["reads"], 6), np.nan)
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        put_in_state(model, data, arrays["qpos"][0], arrays["qvel"][0])
        build = _imu_builder(fields, model, data, answer)
        generators = [(generator, _state(generator)) for generator in _generators()]
        twins = zip(readings, fields["twins"], fields["states"], arrays["biases"], strict=True)
        for rows, stds, state, (accel, gyro) in twins:
            still = _FrozenSimulation(fields, model, data, arrays["qpos"][state], arrays["qvel"][state])
            repeatability.seed(_SEED)
            for generator, began in generators:
                _rewind(generator, began)
            read = build({"accel_bias": accel, "gyro_bias": gyro}, **stds)
            for row in rows:
                _store(read(), row, answer, packer)
                still.changes()
                still.restore(row)
    return answer, packer.arrays | {"accel": readings[:, :, :3], "gyro": readings[:, :, 3:]}


_SEED = 1234
"""Seed of all instances; any value works as long as they share it."""


def _generators() -> Iterator[Any]:
    """Yield the random generators in the submission's modules and classes, which `seed` does not reach."""
    for module in list(submission.STATE.modules.values()):
        owned = [m for m in vars(module).values() if isinstance(m, type) and m.__module__ == module.__name__]
        for value in [value for owner in (module, *owned) for value in vars(owner).values()]:
            if isinstance(value, np.random.Generator | np.random.RandomState | random.Random):
                yield value


def _state(generator: Any) -> Any:
    if isinstance(generator, np.random.Generator):
        return generator.bit_generator.state
    return generator.getstate() if isinstance(generator, random.Random) else generator.get_state()


def _rewind(generator: Any, state: Any) -> None:
    if isinstance(generator, np.random.Generator):
        generator.bit_generator.state = state
    elif isinstance(generator, random.Random):
        generator.setstate(state)
    else:
        generator.set_state(state)


class _FrozenSimulation:
    """Simulation that is put back into one state after each read.

    If a read writes to the sensor data, the following reads are not affected. If a read steps or resets the simulation, which
    leaves_simulation_alone deducts, the change of the sensors is subtracted from its row.
    """

    def __init__(self, fields: dict[str, Any], model: Any, data: Any, qpos: Any, qvel: Any) -> None:
        self._model, self._data, self._qpos, self._qvel = model, data, qpos, qvel
        addresses = [int(model.sensor_adr[fields[name]]) for name in ("accel_id", "gyro_id")]
        self._columns = [address + axis for address in addresses for axis in range(3)]
        put_in_state(model, data, qpos, qvel)
        self._before, self._sensordata = state_of(data), data.sensordata
        self._clean = self._sensordata.copy()
        self._moved = False

    def changes(self) -> list[float]:
        """Return the changes by the first read, and note whether it moved the simulation: then `again` restores it."""
        found = changes_of(self._before, state_of(self._data))
        self._moved = any(found[:3])
        return found

    def restore(self, row: np.ndarray) -> None:
        """Restore the state before the read that returned this row, and remove the effect of the change from the row."""
        if self._moved:
            row -= (self._sensordata - self._clean)[self._columns]
            put_in_state(self._model, self._data, self._qpos, self._qvel)
        self._sensordata[:] = self._clean


def _imu_builder(fields: dict[str, Any], model: Any, data: Any, answer: dict[str, Any]) -> Callable[..., Any]:
    """Return a function that builds a `NoisyIMU` from biases and standard deviations, and returns its read function."""
    kind = submission.find("NoisyIMU", fields["path"])
    way = plan_call(kind, calls.NOISY)
    answer["departs"] = list(way.departs)
    own_globals.provide_ids({"accel": fields["accel_id"], "gyro": fields["gyro_id"]})
    names = ("accel_id", "gyro_id", "accel_noise_std", "gyro_noise_std")
    given = {"model": model, "data": data, **{name: fields[name] for name in names}}

    def build(arrays: dict[str, Any], **stds: float) -> Any:
        biases = {name: arrays[name].copy() for name in ("accel_bias", "gyro_bias") if name in arrays}
        read = way(kind, given | stds | biases).read
        reading = plan_call(read, calls.READ)
        if reading.as_promised:
            return read
        answer["departs"] = [*dict.fromkeys([*answer["departs"], *reading.departs])]
        return lambda: reading(read, given | calls.reading_arguments(fields, model, data))

    return build


def _store(reading: Any, row: np.ndarray, answer: dict[str, Any], packer: Packer) -> None:
    """Write a reading into a row; note the first one of another form, and find the two vectors in it."""
    as_asked = not isinstance(reading, dict)
    try:
        try:
            accel, gyro = reading if as_asked else reading.values()
        except (TypeError, ValueError):
            as_asked = False
            accel, gyro = _two_vectors(reading)
        row[:3] = accel if _is_vector(accel) else np.reshape(accel, 3)
        row[3:] = gyro if _is_vector(gyro) else np.reshape(gyro, 3)
    except (TypeError, ValueError):
        row[:] = np.nan
    if answer["odd"] is None and not (as_asked and all(map(isfinite, row.tolist()))):
        answer["odd"] = packer.node(reading)


def _two_vectors(reading: Any) -> Iterable[Any]:
    """Return both vectors of another form: six numbers in a row, or two vectors among other values, named or in order."""
    parts = parts_of(reading)
    if len(parts) == 6:
        return np.reshape(numbers([part for _, part in parts]), (2, 3))
    return [vector for _, vector in sorted(vectors_in(parts)[:2], key=lambda named: bool(_RATE.search(named[0])))]


def _is_vector(value: Any) -> bool:
    return type(value) is np.ndarray and value.shape == (3,)


def default_bias(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Build many `NoisyIMU`s without biases, and read each a few times in one state.

    The first read of each follows its construction. The others follow when all are built, so that an instance that changes another
    one is found.

    Returns
    -------
    arrays ``accel``, ``gyro`` (instances, reads, 3).
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": [], "done": 0}
    readings = np.full((fields["instances"], fields["reads"], 6), np.nan)
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        still = _FrozenSimulation(fields, model, data, arrays["qpos"][0], arrays["qvel"][0])
        build, reads = _imu_builder(fields, model, data, answer), []
        for rows in readings:
            reads.append(build({}))
            _store(reads[-1](), rows[0], answer, packer)
            still.changes()
            still.restore(rows[0])
        for read, rows in zip(reads, readings, strict=True):
            for row in rows[1:]:
                _store(read(), row, answer, packer)
                still.restore(row)
            answer["done"] += 1
    return answer, packer.arrays | {"accel": readings[:, :, :3], "gyro": readings[:, :, 3:]}
