"""Find time and both sensors in whatever a student's `simulate_and_collect` returned."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from grader.engine.findings import StudentError
from grader.labs.imu.returned import ACCELERATION_NAME, RATE_NAME, Array, Arrays, Node, numbers, shape_in_words

_FEWEST = 3  # rows of which the last one is said to be alone
KEYS = ("time", "acceleration", "angular_velocity")
SENSORS, SENSOR_UNITS = KEYS[1:], ("m/s²", "rad/s")


@dataclass(frozen=True)
class Collection:
    """The return value of a student's `simulate_and_collect`, in short a recording.

    Attributes
    ----------
    time : (n,) ndarray or None; acceleration, angular_velocity : (n, 3) ndarray or None; None for a series that was not found
    keys : the submission's own name for each series that was found
    extras : the other returned values that hold numbers, by the submission's own names
    oddities : how names and shapes differ from the lab sheet's: pairs of a fault's id and a sentence
    changed : names of model fields, such as "opt.timestep", that the call left changed
    error : the exception that the function raised; None if it raised none
    first_step : the run, to simulate it again: arrays by name for its start, number of steps and later changes of its state, as the
        student's process reports them (not proven) or the grader assumes them; empty without a plausible report
    absent : the sensor whose rows were not found although those of the other sensor were; its rows are NaN; "" if none
    last_alone : whether only the last row was filled; all rows then have its numbers
    unfilled : whether rows with nothing but NaN were returned; they are zeros here, as in an array of `np.zeros`
    departs : the sheet's names of parameters that the function has by other names or in other places; "global …" where it reads a
        global variable in place of the parameter
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
        """The rows of the accelerometer and of the gyroscope, in the order of `SENSORS`; None for a missing sensor."""
        return self.acceleration, self.angular_velocity

    @cached_property
    def filled_rows(self) -> int:
        """Number of rows that all found sensors (one or both) have, up to the last nonzero one: code did not fill the rest."""
        both = zip(SENSORS, self.sensors, strict=True)
        sensors = [rows for key, rows in both if rows is not None and key != self.absent]
        n = min(map(len, sensors))
        some = np.any([np.any(rows[:n] != 0, axis=1) for rows in sensors], axis=0)
        return int(np.flatnonzero(some)[-1]) + 1 if some.any() else 0

    def with_gap(self) -> Collection:
        """Return the recording, with rows of NaN if exactly one sensor is missing, so that the other one can still be judged."""
        accel, gyro = self.acceleration, self.angular_velocity
        if accel is None and gyro is not None:
            return replace(self, acceleration=np.full_like(gyro, np.nan), absent=KEYS[1])
        if gyro is None and accel is not None:
            return replace(self, angular_velocity=np.full_like(accel, np.nan), absent=KEYS[2])
        return self

    def with_zeros_for_empty_rows(self) -> Collection:
        """Return the recording with zeros in rows of only NaN, so that an unfilled array of NaN is judged like one of zeros."""
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
        """Return the recording cut to the rows from `first` to before `end` (None: the end), as to drop rows of an earlier run."""
        time, accel, gyro = (None if each is None else each[first:end] for each in (self.time, *self.sensors))
        return replace(self, time=time, acceleration=accel, angular_velocity=gyro)


def as_collection(node: Node | None, arrays: Arrays) -> Collection:
    """Return time and both sensors from whatever `simulate_and_collect` returned, found by names, similar names, or shapes.

    `node` describes the returned value, whose numbers are in `arrays`. A series that is not found is None.
    """
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
    """Flatten a returned dictionary of dictionaries: an inner entry keeps its key, or gets both joined where two would be equal."""
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
    """Return the series in one array (n, 7) of time and both sensors, or (n, 6) of both sensors; empty for any other value."""
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
    """Return the sensor of which a returned key such as `ax` or `gyro_z` names one axis; None if it names no axis."""
    return next((key for key, pattern in _COLUMN_NAMES.items() if pattern.fullmatch(name)), None)


def _columns(key: str, extras: Mapping[str, Array]) -> Array | None:
    """Return a sensor (n, 3) whose axes were recorded one by one, such as `ax`, `ay`, `az`; None without three of equal length."""
    named = [name for name in extras if column_named(name) == key]
    columns = [np.ravel(extras[name]) for name in named]
    alike = len({len(column) for column in columns}) == 1
    return np.column_stack(columns) if len(columns) == 3 and alike else None


def _own_keys(series: Mapping[str, Array]) -> dict[str, str]:
    """Return the submission's own name for each of the lab sheet's three keys that was found, guessed by name and shape."""
    keys = {key: key for key in KEYS if key in series}
    free = [name for name in series if name not in keys]
    alike = {
        "time": lambda n: re.match(r"t(ime|imes|s|_|$)|stamp|zeit", n, re.IGNORECASE) is not None,
        "acceleration": lambda n: ACCELERATION_NAME.search(n) is not None,
        "angular_velocity": lambda n: RATE_NAME.search(n) is not None and ACCELERATION_NAME.search(n) is None,
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


def _upright(found: dict[str, Array], oddities: list[tuple[str, str]]) -> dict[str, Array]:
    """Return the series with time as (n,) and sensors as (n, 3), without unusable ones; note other shapes in `oddities`."""
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
        elif value.ndim == 1 and "time" in found and value.size == 3 * found["time"].size:
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
