"""The sandbox worker's replies as frozen dataclasses of plain arrays, the form in which the checks compare them with the truth.

The worker runs beside student code, so nothing in a reply is trusted: an answer holds what the student's function returned, and in
words how the form of the returned value differs from the lab sheet's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from grader.engine.figures import Figure, figures_of
from grader.engine.findings import StudentError
from grader.labs.imu.collection import KEYS, as_collection
from grader.labs.imu.returned import ACCELERATION_NAME, RATE_NAME, Array, Arrays, Node, numbers, shape_in_words
from grader.labs.imu.visualization.visibility import Patience, looked_at
from grader.sandbox.wire import Frame

# --- readings ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reading:
    """The two vectors in one value that a student's `get_imu_readings` returned; a vector is None if it was not found.

    `oddity` says how the value's form differs from the lab sheet's, None if it does not; `whole` is whether each vector found has
    three numbers.
    """

    accel: Array | None
    gyro: Array | None
    oddity: str | None
    whole: bool = True


def as_reading(node: Node | None, arrays: Arrays) -> Reading:
    """Return acceleration and angular velocity from whatever `get_imu_readings` returned: a pair, an array of six, named items.

    `node` describes the returned value, whose numbers are in `arrays`. A vector that is not found is None.
    """
    parts = _pair(node, arrays)
    if parts is None:
        return Reading(None, None, shape_in_words(node, arrays))
    accel, gyro = (None if part is None else np.ravel(part) for part in parts)
    right_form = node is not None and (node["kind"] in ("tuple", "list") or "key" in node)
    six = numbers(node, arrays)
    right_form = right_form and not (six is not None and six.ndim == 1)
    right_shape = all(part is not None and part.size == 3 == part.shape[-1] for part in parts)  # a row can hold it
    right_count = node is not None and ("items" not in node or len(node["items"]) == 2)
    odd = None if right_form and right_shape and right_count else shape_in_words(node, arrays)
    whole = all(part is None or part.size == 3 for part in (accel, gyro))
    return Reading(accel, gyro, odd, whole)


def _pair(node: Node | None, arrays: Arrays) -> tuple[Array | None, Array | None] | None:
    """Return acceleration and angular velocity in a returned value of any form, None for a missing one; None if it has neither."""
    if node is None:
        return None
    if node["kind"] in ("dict", "object"):
        named = [(name, numbers(item, arrays)) for name, item in node["items"]]
        accel = next((v for n, v in named if ACCELERATION_NAME.search(n)), None)
        gyro = next((v for n, v in named if RATE_NAME.search(n) and not ACCELERATION_NAME.search(n)), None)
        return None if accel is None and gyro is None else (accel, gyro)
    whole = numbers(node, arrays)
    if whole is not None and whole.shape == (6,):
        return whole[:3], whole[3:]
    if whole is not None and whole.shape == (3,):
        return whole, None  # the sheet's first
    if whole is not None and "key" in node:
        return (whole[0], whole[1]) if whole.ndim == 2 and len(whole) == 2 else None
    items = node.get("items", ())
    if len(items) < 2:
        return None
    first, second = numbers(items[0], arrays), numbers(items[1], arrays)
    return None if first is None and second is None else (first, second)


def three(vector: Array | None) -> Array:
    """Return the first three numbers of a vector, NaN for missing ones or no vector, so that any answer can be compared."""
    out = np.full(3, np.nan)
    if vector is not None:
        out[: min(3, vector.size)] = vector[:3]
    return out


@dataclass(frozen=True)
class Readings:
    """Values that a student's `get_imu_readings` returned for p pairs of sensors in k states of the simulator.

    Attributes
    ----------
    accel, gyro : (p, k, 3) ndarray; NaN where no vector was returned
    later_accel, later_gyro : (p, 3) ndarray, the arrays returned for the first state, looked at again after the simulation moved on
    oddities : how the form of the returned values differs from the lab sheet's, in words, each once
    whole : whether each returned vector has three numbers
    disturbance : (calls, 4) ndarray, largest change of time, qpos, qvel, sensordata while reading
    error : the exception that the reader raised; None if it raised none
    departs : the sheet's names of parameters that the function has by other names or in other places; "name for …" where it takes a
        sensor's name in place of its id, "global …" where it reads a global variable in place of the parameter
    """

    accel: Array
    gyro: Array
    later_accel: Array
    later_gyro: Array
    oddities: tuple[str, ...]
    disturbance: Array
    error: StudentError | None
    departs: tuple[str, ...] = ()
    whole: bool = True


# --- noise, filter, drawing ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NoiseRun:
    """Values of many reads of a student's `NoisyIMU`: ``accel`` and ``gyro``, NaN where a read was not two vectors of three.

    Both are (k, reads, 3), for k states of one instance or for k instances. ``odd`` says in words what came in place of two
    vectors; None if nothing did. ``disturbance`` (k, 4) is the change of time, qpos, qvel and sensordata by the first read in each
    state, without rows for several instances; ``error`` is what was raised, or None; ``departs`` is as in `FilterRun`.
    """

    accel: Array
    gyro: Array
    disturbance: Array
    odd: str | None
    error: StudentError | None
    departs: tuple[str, ...] = ()


@dataclass(frozen=True)
class FilterRun:
    """Values that a student's `LowPassFilter` returned for one signal of n measurements.

    Attributes
    ----------
    output : (n, 3) ndarray, fewer rows if the filter raised, NaN rows where it returned no vector; None if it raised at once
    odd : in words, what the filter returned in place of the first missing vector; None if none is missing
    input_changed : whether the filter wrote into a measurement or into the initial value
    output_changed : whether the array of the first output has other numbers after the last update
    departs : the sheet's names of parameters that the class has by other names or in other places; "method …" for a method with
        another name, "global …" where it reads a global variable in place of the parameter
    """

    output: Array | None
    odd: str | None
    error: StudentError | None
    input_changed: bool = False
    output_changed: bool = False
    departs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """The matplotlib figures that were drawn while a function or a file of the submission ran.

    Attributes
    ----------
    figures : the figures, each with what the sandbox reports of its axes and curves
    departs : the sheet's names of parameters that the function has by other names or in other places; "global …" where it reads a
        global variable in place of the parameter
    given : time and both sensors as the submission's own `simulate_and_collect` gave them to its plot; None if that did not run, or
        if the seven columns (time, and three axes of each sensor) are not all finite, changing and different
    """

    figures: tuple[Figure, ...]
    error: StudentError | None = None
    departs: tuple[str, ...] = ()
    given: Mapping[str, Array] | None = None


def drawing_of(frame: Frame) -> Drawing:
    """Return what a reply of the sandbox worker reports of drawing: figures, an exception, and the other fields of `Drawing`."""
    patience = Patience()
    figures = tuple(looked_at(figure, patience) for figure in figures_of(frame))
    fields, given = frame.fields, _series_of(frame.fields.get("given"), frame.arrays)
    return Drawing(figures, StudentError.of(fields.get("error")), tuple(fields.get("departs", ())), given)


def _series_of(node: Node | None, arrays: Arrays) -> Mapping[str, Array] | None:
    """Return time and both sensors in a returned recording, to find them in its plot; None if its columns are too alike."""
    own = as_collection(node, arrays)
    if own.time is None or own.acceleration is None or own.angular_velocity is None:
        return None
    if not len(own.time) == len(own.acceleration) == len(own.angular_velocity) > 1:
        return None
    columns = np.column_stack([own.time, own.acceleration, own.angular_velocity])
    told_apart = np.isfinite(columns).all() and np.ptp(columns, axis=0).all() and len(np.unique(columns, axis=1).T) == 7
    return dict(zip(KEYS, (own.time, own.acceleration, own.angular_velocity), strict=True)) if told_apart else None
