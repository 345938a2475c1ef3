"""The worker's answers as frozen dataclasses of plain arrays, the form that the checks work with.

Everything in here was said by the sandbox and is believed of nobody: a record holds what a student's function returned, in a
form that can be compared, and what was odd about its form.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.engine.figures import Figure, figures_of
from grader.engine.findings import GraderText, StudentError
from grader.labs.imu.visualization.visibility import Patience, looked_at
from grader.sandbox.wire import Frame

Array = NDArray[np.float64]
Node = Mapping[str, Any]
Arrays = Mapping[str, Array]


def numbers(node: Node | None, arrays: Arrays) -> Array | None:
    """Return the numbers of a reported value (a node of the reply) as one array; None without any or if rows differ."""
    if node is None:
        return None
    if "key" in node:
        return arrays[node["key"]]
    if node["kind"] in ("tuple", "list"):
        parts = [numbers(item, arrays) for item in node["items"]]
        known = [part for part in parts if part is not None]
        if parts and len(known) == len(parts) and len({part.shape for part in known}) == 1:
            return np.array(known)
    return None


def shape_in_words(node: Node | None, arrays: Arrays) -> str:
    """Describe a value for a student: ``a tuple of (array (3,), array (2,))``."""
    if node is None:
        return "nothing"
    kind = node["kind"]
    if kind == "none":
        return "None"
    if kind == "number":
        return "a number"
    if kind == "text":
        return "a string"
    if kind == "too_large":
        return "an array of more than 600,000 numbers"
    if "key" in node:
        return f"{'a list' if kind == 'list' else 'an array'} of shape {arrays[node['key']].shape}"
    if kind in ("tuple", "list"):
        inner = [shape_in_words(item, arrays) for item in node["items"][:4]]
        return f"a {kind} of {len(node['items'])}" + (f" ({', '.join(inner)})" if inner else "")
    if kind in ("dict", "object"):
        names = ", ".join(repr(name) for name, _ in node["items"][:6]) or "nothing"
        return f"{'a dictionary' if kind == 'dict' else 'an object'} with {names}"
    return f"a value of type {node.get('type', '?')}"


def if_nothing(got: str) -> str:
    """Return the hint for a function that returned None; "" for any other value."""
    return _NOTHING_RETURNED if got.removeprefix("got ").startswith("None") else ""


_NOTHING_RETURNED = GraderText(
    "The function returns None: it is still to be written, or a return statement is missing."
)


# --- readings ------------------------------------------------------------------------------------------------------------

_ACCELERATION_NAME = re.compile(r"acc|specific|force|linear", re.IGNORECASE)
_RATE_NAME = re.compile(r"gyr|ang|omega|rate|rot", re.IGNORECASE)


@dataclass(frozen=True)
class Reading:
    """One call of a student's reader: its two vectors, as far as they can be found, and what is odd about their form.

    `whole` is whether each vector that there is has three numbers.
    """

    accel: Array | None
    gyro: Array | None
    oddity: str | None
    whole: bool = True


def as_reading(node: Node | None, arrays: Arrays) -> Reading:
    """Find acceleration and angular velocity in whatever a reader returned: a pair, an array of six, or named items."""
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
    """Return acceleration and angular velocity in a returned value of any form; None if it holds neither."""
    if node is None:
        return None
    if node["kind"] in ("dict", "object"):
        named = [(name, numbers(item, arrays)) for name, item in node["items"]]
        accel = next((v for n, v in named if _ACCELERATION_NAME.search(n)), None)
        gyro = next((v for n, v in named if _RATE_NAME.search(n) and not _ACCELERATION_NAME.search(n)), None)
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
    """Return the first three components, with NaN for missing ones, as a vector to compare."""
    out = np.full(3, np.nan)
    if vector is not None:
        out[: min(3, vector.size)] = vector[:3]
    return out


@dataclass(frozen=True)
class Readings:
    """The calls of a reader on one scenario.

    Attributes
    ----------
    accel, gyro : (p, k, 3) ndarray, per pair of sensors and state; NaN where nothing usable came
    later_accel, later_gyro : (p, 3) ndarray, the first state's readings looked at again after the simulation moved on
    oddities : what was odd about the form, in words, each once
    whole : whether each vector that came has three numbers
    disturbance : (calls, 4) ndarray, largest change of time, qpos, qvel, sensordata while reading
    error : what the reader raised, if it did
    departs : the sheet's names of the parameters by which it could not be called as the sheet does
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


# --- a collected time series ---------------------------------------------------------------------------------------------

_FEWEST = 3  # rows of which the last one is said to be alone
KEYS = ("time", "acceleration", "angular_velocity")
SENSORS, SENSOR_UNITS = KEYS[1:], ("m/s²", "rad/s")


@dataclass(frozen=True)
class Collection:
    """The return value of `simulate_and_collect`.

    Attributes
    ----------
    time : (n,) ndarray or None; acceleration, angular_velocity : (n, 3) ndarray or None
    keys : the submission's own name for each of the three
    extras : everything else with numbers in it, by the submission's own names
    oddities : what was odd about names and shapes, as ids of faults with a sentence
    changed : names of model fields that differ afterwards
    first_step : what the sandbox says of the state before the first step: a hint, to be run again before it is believed
    absent : the sensor whose rows could not be found while the other's were; its rows are NaN
    last_alone : whether only the last row was filled; all rows then have its numbers
    unfilled : whether rows without any number were returned; zeros stand in their place, as in an array of `np.zeros`
    departs : as of `Readings`
    """

    time: Array | None
    acceleration: Array | None
    angular_velocity: Array | None
    keys: Mapping[str, str] = field(default_factory=dict)
    extras: Mapping[str, Array] = field(default_factory=dict)
    oddities: tuple[tuple[str, str], ...] = ()
    changed: tuple[str, ...] = ()
    error: StudentError | None = None
    first_step: Mapping[str, Array] = field(default_factory=dict)
    absent: str = ""
    last_alone: bool = False
    unfilled: bool = False
    departs: tuple[str, ...] = ()

    @property
    def sensors(self) -> tuple[Array | None, Array | None]:
        """The rows of the accelerometer and of the gyroscope, in the order of `SENSORS`."""
        return self.acceleration, self.angular_velocity

    @cached_property
    def filled_rows(self) -> int:
        """The number of rows up to the last one that is not zero: arrays that were allocated and not filled end in zeros."""
        both = zip(SENSORS, self.sensors, strict=True)
        sensors = [rows for key, rows in both if rows is not None and key != self.absent]
        n = min(map(len, sensors))
        some = np.any([np.any(rows[:n] != 0, axis=1) for rows in sensors], axis=0)
        return int(np.flatnonzero(some)[-1]) + 1 if some.any() else 0

    def with_gap(self) -> Collection:
        """Return the recording with rows of NaN for a missing sensor if the other one has rows: those identify the run."""
        accel, gyro = self.acceleration, self.angular_velocity
        if accel is None and gyro is not None:
            return replace(self, acceleration=np.full_like(gyro, np.nan), absent=KEYS[1])
        if gyro is None and accel is not None:
            return replace(self, angular_velocity=np.full_like(accel, np.nan), absent=KEYS[2])
        return self

    def with_zeros_for_empty_rows(self) -> Collection:
        """Return the recording with zeros in rows of NaN alone, so that an array of NaN is judged like one of zeros."""
        there = [rows for rows in self.sensors if rows is not None]
        n = min(map(len, there), default=0)
        empty = np.all([np.isnan(rows[:n]).all(axis=1) for rows in there], axis=0) if n else np.zeros(0, bool)
        if not empty.any():
            return self
        time, accel, gyro = (None if each is None else each.copy() for each in (self.time, *self.sensors))
        for rows in (accel, gyro):
            if rows is not None:
                rows[:n][empty] = 0.0
        if time is not None:
            stamps = time[:n]
            stamps[empty[: len(stamps)] & np.isnan(stamps)] = 0.0
        return replace(self, time=time, acceleration=accel, angular_velocity=gyro, unfilled=True)

    def with_last_for_all(self) -> Collection:
        """Return the recording with every row equal to the last one if only that row was filled; otherwise unchanged.

        The diagnosis then recognises the run by this row, and `last_alone` records that it was the only one.
        """
        if any(rows is None or len(rows) < _FEWEST or rows[:-1].any() or not rows[-1].any() for rows in self.sensors):
            return self
        accel, gyro = (np.repeat(rows[-1:], len(rows), axis=0) for rows in self.sensors if rows is not None)
        return replace(self, acceleration=accel, angular_velocity=gyro, last_alone=True)

    def rows(self, first: int, end: int | None = None) -> Collection:
        """Return the recording's rows from `first` up to `end`."""
        time, acceleration, angular_velocity = (
            None if array is None else array[first:end]
            for array in (self.time, self.acceleration, self.angular_velocity)
        )
        return replace(self, time=time, acceleration=acceleration, angular_velocity=angular_velocity)


def as_collection(node: Node | None, arrays: Arrays) -> Collection:
    """Find time and both sensors in whatever a recorder returned: by their names, else by similar names, else by their shapes."""
    if node is None or node["kind"] == "none":
        return _nothing_collected("got None")
    oddities: list[tuple[str, str]] = []
    members: dict[str, Array | None]
    if node["kind"] == "dict":
        members = _members(node, arrays)
        nested = [name for name, item in node["items"] if item["kind"] in ("dict", "object")]
        if nested and not {name for name, _ in node["items"]}.difference(nested) >= set(KEYS):
            told = ", ".join(repr(name) for name in nested[:3])
            oddities.append(("wrong-return-type", f"got the keys inside {told}, not in the dictionary itself"))
    elif node["kind"] == "object":
        members = _members(node, arrays)
        oddities.append(("wrong-return-type", f"got an object of type {node['type']}, not a dictionary"))
    elif node["kind"] in ("tuple", "list") and "items" in node:
        members = {str(i): numbers(item, arrays) for i, item in enumerate(node["items"])}
        oddities.append(("wrong-return-type", f"got {shape_in_words(node, arrays)}, not a dictionary"))
    elif members := _side_by_side(node, arrays):
        oddities.append(("wrong-return-type", f"got {shape_in_words(node, arrays)}, not a dictionary"))
    else:
        return _nothing_collected(f"got {shape_in_words(node, arrays)}, not a dictionary")
    numeric = {name: value for name, value in members.items() if value is not None}
    keys = _own_keys(numeric)
    series = {name: value for name, value in numeric.items() if value.size}
    extras = {name: value for name, value in series.items() if name not in keys.values()}
    if not oddities and any(keys.get(key, key if key in members else "") != key for key in KEYS):
        oddities.append(
            ("wrong-keys", f"got the keys {', '.join(repr(name) for name in list(members)[:8]) or '(none)'}")
        )
    found = _upright({key: series[own] for key, own in keys.items() if own in series}, oddities)
    found |= {key: columns for key in SENSORS if key not in found and (columns := _columns(key, extras)) is not None}
    time, acceleration, angular_velocity = (found.get(key) for key in KEYS)
    return Collection(time, acceleration, angular_velocity, keys, extras, tuple(oddities))


def _members(node: Node, arrays: Arrays) -> dict[str, Array | None]:
    """Flatten a dictionary of dictionaries: an inner entry keeps its own key, or gets both keys where two would be the same."""
    members: dict[str, Array | None] = {}
    for name, item in node["items"]:
        if item["kind"] in ("dict", "object"):
            for n, value in _members(item, arrays).items():
                both = f"{name}_{n}"
                members[both if column_named(both) or n in members else n] = value
        else:
            members[name] = numbers(item, arrays)
    return members


def _side_by_side(node: Node, arrays: Arrays) -> dict[str, Array | None]:
    """Return the series in an array (n, 7) of time and both sensors or (n, 6) of both sensors; empty for any other array."""
    whole = numbers(node, arrays)
    if whole is None or whole.ndim != 2 or whole.shape[1] not in (6, 7):
        return {}
    time, rows = whole[:, :-6], whole[:, -6:]
    found: dict[str, Array | None] = {"acceleration": rows[:, :3], "angular_velocity": rows[:, 3:]}
    return found | ({"time": time[:, 0]} if time.size else {})


def _nothing_collected(got: str) -> Collection:
    return Collection(None, None, None, oddities=(("wrong-return-type", got),))


_COLUMN_NAMES = {
    "acceleration": re.compile(
        r"(?:lin(?:ear)?_?)?a(?:cc(?:el(?:eration|erometer)?)?)?[_ .]?([xyz012])", re.IGNORECASE
    ),
    "angular_velocity": re.compile(
        r"(?:g|gyr|gyro(?:scope)?|w|omega|ang(?:ular)?_?(?:vel(?:ocity)?)?)[_ .]?([xyz012])|(roll|pitch|yaw)(?:_?rate)?",
        re.IGNORECASE,
    ),
}


def column_named(name: str) -> str | None:
    """Return the sensor of which a dictionary key such as `ax` or `gyro_z` names one axis; None if it names no axis."""
    return next((key for key, pattern in _COLUMN_NAMES.items() if pattern.fullmatch(name)), None)


def _columns(key: str, extras: Mapping[str, Array]) -> Array | None:
    """Return a sensor (n, 3) whose axes were recorded separately, such as `ax`, `ay`, `az`; None if there are no three of them."""
    named = [name for name in extras if column_named(name) == key]
    columns = [np.ravel(extras[name]) for name in named]
    alike = len({len(column) for column in columns}) == 1
    return np.column_stack(columns) if len(columns) == 3 and alike else None


def _own_keys(series: Mapping[str, Array]) -> dict[str, str]:
    """Return the submission's own name for each of the sheet's three keys, guessed by name and shape."""
    keys = {key: key for key in KEYS if key in series}
    free = [name for name in series if name not in keys]
    alike = {
        "time": lambda n: re.match(r"t(ime|imes|s|_|$)|stamp|zeit", n, re.IGNORECASE) is not None,
        "acceleration": lambda n: _ACCELERATION_NAME.search(n) is not None,
        "angular_velocity": lambda n: _RATE_NAME.search(n) is not None and _ACCELERATION_NAME.search(n) is None,
    }
    whole = [name for name in free if not (column_named(name) and series[name].ndim == 1)]
    for key in KEYS:
        likeliest = sorted(whole, key=lambda name: series[name].ndim, reverse=key != "time")
        guess = next((n for n in likeliest if key not in keys and n in free and alike[key](n)), None)
        if guess is not None:
            keys[key] = guess
            free.remove(guess)
    for key in KEYS:
        wanted = 1 if key == "time" else 2
        guess = next((n for n in free if key not in keys and np.squeeze(series[n]).ndim == wanted), None)
        if guess is not None:
            keys[key] = guess
            free.remove(guess)
    return {key: keys[key] for key in KEYS if key in keys}


def _length(found: Mapping[str, Array]) -> int:
    return found["time"].size if "time" in found else 0


def _upright(found: dict[str, Array], oddities: list[tuple[str, str]]) -> dict[str, Array]:
    """Return the series with time as (n,) and sensors as (n, 3); add what had another form to `oddities`."""
    out: dict[str, Array] = {}
    for key, value in found.items():
        if key == "time":
            flat = np.ravel(value) if value.ndim == 1 or 1 in value.shape else None
            if flat is None or value.ndim != 1:
                oddities.append(("wrong-return-type", f"'time' has shape {value.shape}"))
            if flat is not None:
                out[key] = flat
        elif value.ndim == 2 and value.shape[1] == 3:
            out[key] = value
        elif value.ndim == 1 and value.size == 3 * _length(found):
            oddities.append(("wrong-return-type", f"'{key}' has shape {value.shape}: all components in one row"))
            out[key] = value.reshape(-1, 3)
        elif value.ndim == 2 and value.shape[0] == 3:
            oddities.append(("arrays-transposed", f"'{key}' has shape {value.shape}"))
            out[key] = value.T
        elif value.ndim == 2 and value.shape[1] == 6 and not found.keys() >= set(KEYS):
            oddities.append(("wrong-return-type", f"'{key}' has shape {value.shape}: both sensors side by side"))
            out |= {"acceleration": value[:, :3], "angular_velocity": value[:, 3:]}
        elif value.ndim == 3 and value.shape[1:] in ((3, 1), (1, 3)):
            oddities.append(("wrong-return-type", f"'{key}' has shape {value.shape}"))
            out[key] = value.reshape(-1, 3)
        else:
            oddities.append(("wrong-return-type", f"'{key}' has shape {value.shape}"))
    return out


# --- noise, filter, drawing ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class NoiseRun:
    """Many reads of one `NoisyIMU`: ``accel``, ``gyro`` (states, reads, 3), NaN where a read was not two vectors of three.

    ``odd`` says in words what came in place of two such vectors, if anything did; ``departs`` as of `Readings`.
    """

    accel: Array
    gyro: Array
    disturbance: Array
    odd: str | None
    error: StudentError | None
    departs: tuple[str, ...] = ()


@dataclass(frozen=True)
class FilterRun:
    """One filter over one signal.

    Attributes
    ----------
    output : (n, 3) ndarray, fewer rows where it raised, rows of NaN where no vector came; None where nothing came
    odd : what came in place of the first missing vector
    input_changed : whether a measurement or the initial value was written into
    output_changed : whether the first output is another one after the last update
    departs : as of `Readings`
    """

    output: Array | None
    odd: str | None
    error: StudentError | None
    input_changed: bool = False
    output_changed: bool = False
    departs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """The figures that were drawn while a function or a file of the submission ran.

    Attributes
    ----------
    figures : each with the facts that the sandbox reports of its axes and curves
    departs : as of `Readings`
    given : the series of `KEYS` that the submission's own recorder gave to the plot; None without it, or if they are not six
        series that can be told apart
    """

    figures: tuple[Figure, ...]
    error: StudentError | None = None
    departs: tuple[str, ...] = ()
    given: Mapping[str, Array] | None = None


def drawing_of(frame: Frame) -> Drawing:
    """Return the figures, the exception and the departures that a reply of the worker reports."""
    patience = Patience()
    figures = tuple(looked_at(figure, patience) for figure in figures_of(frame))
    fields, given = frame.fields, _series_of(frame.fields.get("given"), frame.arrays)
    return Drawing(figures, StudentError.of(fields.get("error")), tuple(fields.get("departs", ())), given)


def _series_of(node: Node | None, arrays: Arrays) -> Mapping[str, Array] | None:
    """Return time and both sensors in what a recorder returned; None unless all seven columns are finite, change and differ."""
    own = as_collection(node, arrays)
    if own.time is None or own.acceleration is None or own.angular_velocity is None:
        return None
    if not len(own.time) == len(own.acceleration) == len(own.angular_velocity) > 1:
        return None
    columns = np.column_stack([own.time, own.acceleration, own.angular_velocity])
    told_apart = np.isfinite(columns).all() and np.ptp(columns, axis=0).all() and len(np.unique(columns, axis=1).T) == 7
    return dict(zip(KEYS, (own.time, own.acceleration, own.angular_velocity), strict=True)) if told_apart else None
