"""Read the student's noisy IMU many times in a simulation that does not move."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable
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
    """Build one `NoisyIMU` of the student's and read it many times in each state, to measure its noise and its biases.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML text), ``accel_id``, ``gyro_id``, ``reads`` (per state),
        ``accel_noise_std``, ``gyro_noise_std``
    arrays : ``qpos`` (s, nq), ``qvel`` (s, nv), the states; ``accel_bias`` (3,), ``gyro_bias`` (3,) if biases are given

    Returns
    -------
    arrays ``accel``, ``gyro`` (s, reads, 3), NaN for a read without two vectors; ``odd``: the first value that is no pair of
    vectors as on the lab sheet, or not finite; ``disturbance`` (s, 4): largest change of time, qpos, qvel and sensordata by the
    first read in each state
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": [], "done": 0}
    readings = np.full((len(arrays["qpos"]), fields["reads"], 6), np.nan)
    disturbance: list[list[float]] = []
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        put_in_state(model, data, arrays["qpos"][0], arrays["qvel"][0])
        build = _imu_builder(fields, model, data, answer)
        _, read = build(arrays)
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
    """Build several `NoisyIMU`s from the same seed, and read each a few times in its own state.

    The instances differ in state, biases or noise; as they share the seed, only such a difference can change their values.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML text), ``accel_id``, ``gyro_id``, ``accel_noise_std``,
        ``gyro_noise_std``, ``reads`` (of each instance), ``twins`` (for each instance, a dict of standard deviations
        that replace the two above), ``states`` (for each instance, the row of its state in ``qpos`` and ``qvel``)
    arrays : ``qpos`` (s, nq), ``qvel`` (s, nv); ``biases`` (twins, 2, 3), without which each instance draws its own

    Returns
    -------
    arrays ``accel``, ``gyro`` (twins, reads, 3), NaN for a read without two vectors, and from the first exception on
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": []}
    readings = np.full((len(fields["twins"]), fields["reads"], 6), np.nan)
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        put_in_state(model, data, arrays["qpos"][0], arrays["qvel"][0])
        build = _imu_builder(fields, model, data, answer)
        given = [{"accel_bias": accel, "gyro_bias": gyro} for accel, gyro in arrays.get("biases", ())] or [{}] * len(
            readings
        )
        for rows, stds, state, biases in zip(readings, fields["twins"], fields["states"], given, strict=True):
            still = _FrozenSimulation(fields, model, data, arrays["qpos"][state], arrays["qvel"][state])
            _restart_generators()
            _, read = build(biases, **stds)
            for row in rows:
                _store(read(), row, answer, packer)
                still.changes()
                still.restore(row)
    return answer, packer.arrays | {"accel": readings[:, :, :3], "gyro": readings[:, :, 3:]}


def _restart_generators(owner: Any = None, seed: int = 1234) -> None:
    """Give all random generators one state: the global ones, and those in `owner` and in the submission's modules and classes.

    Any seed works as long as the instances that are compared share it. `owner` is an instance; None: no further generators.
    """
    repeatability.seed(seed)
    modules = list(submission.STATE.modules.values())
    classes = [
        m
        for module in modules
        for m in vars(module).values()
        if isinstance(m, type) and m.__module__ == module.__name__
    ]
    members = list(getattr(owner, "__dict__", {}).values())
    for value in [
        value for each in (*modules, *classes, *members, owner) for value in getattr(each, "__dict__", {}).values()
    ]:
        if isinstance(value, np.random.Generator):
            value.bit_generator.state = type(value.bit_generator)(seed).state
        elif isinstance(value, np.random.RandomState | random.Random):
            value.seed(seed)


class _FrozenSimulation:
    """Simulation that is put back into one state after each read, so that all reads of a noisy IMU have the same true values.

    If a read writes to the sensor data, the following reads are not affected. If a read steps or resets the simulation, which the
    check leaves_simulation_alone deducts, the change of the sensors is subtracted from its row.
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
        """Return what the read changed: time, qpos, qvel and sensordata; note whether it moved the simulation, for `restore`."""
        found = changes_of(self._before, state_of(self._data))
        self._moved = any(found[:3])
        return found

    def restore(self, row: np.ndarray) -> None:
        """Restore the state before the read that returned this row, and remove the effect of a moved simulation from the row."""
        if self._moved:
            row -= (self._sensordata - self._clean)[self._columns]
            put_in_state(self._model, self._data, self._qpos, self._qvel)
        self._sensordata[:] = self._clean


def _imu_builder(
    fields: dict[str, Any], model: Any, data: Any, answer: dict[str, Any]
) -> Callable[..., tuple[Any, Callable[[], Any]]]:
    """Return a function that builds a `NoisyIMU` from biases and standard deviations, and returns it with its read function.

    Names of parameters and methods that differ from the lab sheet's are added to ``answer["departs"]``.
    """
    kind = submission.find("NoisyIMU", fields["path"])
    way = plan_call(kind, calls.NOISY)
    answer["departs"] = list(way.departs)
    own_globals.provide_ids({"accel": fields["accel_id"], "gyro": fields["gyro_id"]})
    names = ("accel_id", "gyro_id", "accel_noise_std", "gyro_noise_std")
    given = {"model": model, "data": data, **{name: fields[name] for name in names}}

    def build(arrays: dict[str, Any], **stds: float) -> tuple[Any, Callable[[], Any]]:
        biases = {name: arrays[name].copy() for name in ("accel_bias", "gyro_bias") if name in arrays}
        imu = way(kind, given | stds | biases)
        read, another = calls.method_of(imu, "read", 0)
        reading = plan_call(read, calls.READ)
        answer["departs"] = [*dict.fromkeys([*answer["departs"], *another, *reading.departs])]
        if reading.as_promised:
            return imu, read
        return imu, lambda: reading(read, given | calls.reading_arguments(fields, model, data))

    return build


def _store(reading: Any, row: np.ndarray, answer: dict[str, Any], packer: Packer) -> None:
    """Write both vectors of one read into a row, NaN if there are none; keep the first read of another form as `odd`."""
    as_asked = not isinstance(reading, dict)
    try:
        try:
            accel, gyro = reading if as_asked else reading.values()
        except (TypeError, ValueError):
            as_asked = False
            accel, gyro = _two_vectors(reading)
        row[:3] = accel if _is_vector(accel) else numbers(accel).reshape(3)
        row[3:] = gyro if _is_vector(gyro) else numbers(gyro).reshape(3)
    except (TypeError, ValueError):
        row[:] = np.nan
    if answer["odd"] is None and not (as_asked and all(map(isfinite, row.tolist()))):
        answer["odd"] = packer.node(reading)


def _two_vectors(reading: Any) -> Iterable[Any]:
    """Find both vectors in a reading of another form: six numbers, or two vectors among other values, by name or in order."""
    parts = parts_of(reading)
    if len(parts) == 6:
        return np.reshape(numbers([part for _, part in parts]), (2, 3))
    return [vector for _, vector in sorted(vectors_in(parts)[:2], key=lambda named: bool(_RATE.search(named[0])))]


def _is_vector(value: Any) -> bool:
    return type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (3,)


def default_bias(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Build many `NoisyIMU`s, give them no biases, and read each a few times in one state, to find the biases that they draw.

    The first read of each instance follows its construction. The others follow when all are built, so that an instance that changes
    another one is found. If the field ``one_draw`` is set, all random generators start from one seed before each read: the noise is
    then equal in all reads, and only biases differ.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML text), ``accel_id``, ``gyro_id``, ``accel_noise_std``,
        ``gyro_noise_std``, ``instances`` (their number), ``reads`` (of each instance), ``one_draw``
    arrays : ``qpos`` (s, nq), ``qvel`` (s, nv), the state in the first row

    Returns
    -------
    arrays ``accel``, ``gyro`` (instances, reads, 3).
    """
    packer = Packer()
    answer: dict[str, Any] = {"odd": None, "departs": [], "done": 0}
    readings = np.full((fields["instances"], fields["reads"], 6), np.nan)
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        still = _FrozenSimulation(fields, model, data, arrays["qpos"][0], arrays["qvel"][0])
        build = _imu_builder(fields, model, data, answer)
        built: list[tuple[Any, Callable[[], Any]]] = []

        def read_again(number: int) -> Any:
            imu, read = built[number]
            if fields["one_draw"]:
                _restart_generators(imu)
            return read()

        for number, rows in enumerate(readings):
            if fields["one_draw"]:  # or all instances are built after the same draws
                _restart_generators(seed=number)
            built.append(build({}))
            _store(read_again(number), rows[0], answer, packer)
            still.changes()
            still.restore(rows[0])
        for number, rows in enumerate(readings):
            for row in rows[1:]:
                _store(read_again(number), row, answer, packer)
                still.restore(row)
            answer["done"] += 1
    return answer, packer.arrays | {"accel": readings[:, :, :3], "gyro": readings[:, :, 3:]}
