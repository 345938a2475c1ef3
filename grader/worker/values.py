"""Convert what a student's function returned into plain nodes and float arrays, the form in which the grader receives it.

A node is a dictionary with a ``kind``: ``array``, ``number``, ``tuple``, ``list``, ``dict``, ``object``, ``text``, ``none``,
``other`` or ``too_large``. Numbers are sent as float64 arrays, named by ``key``.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from .faults import mask_addresses

MAX_ELEMENTS = 600_000
_MAX_ITEMS = 64
_MAX_DEPTH = 4
_SHORT = 16


_REAL = "fiu"
"""Kinds of NumPy types whose values are real numbers: floating point, and integers with and without a sign."""


def numbers(value: Any) -> np.ndarray:
    """Return an array, a sequence or a number as float64, with NaN for masked values; raise TypeError or ValueError for others.

    This is the only rule for what counts as numbers, whatever the lab asks. Complex numbers count if no imaginary part differs from
    zero, objects such as `Decimal` and `Fraction` if `float` accepts them. Text, booleans, dates and structured arrays do not.
    """
    if isinstance(value, list | tuple):
        return np.array(value if all(map(_is_plain, value)) else [numbers(part) for part in value], dtype=np.float64)
    array = np.asarray(value)
    kind = array.dtype.kind
    if kind == "O":
        array = np.array([_number(each) for each in array.ravel()], dtype=np.float64).reshape(array.shape)
    elif kind == "c" and not np.any(array.imag):
        array = array.real
    elif kind not in _REAL:
        raise TypeError(f"values of type {array.dtype} are no real numbers")
    real = np.array(array, dtype=np.float64)
    if isinstance(value, np.ma.MaskedArray):
        real[np.ma.getmaskarray(value)] = np.nan
    return real


def _is_plain(part: Any) -> bool:
    """Return whether NumPy converts a member of a sequence as `numbers` does, and much faster: a float or an array of reals."""
    return type(part) is float or (type(part) in (np.ndarray, np.float64) and part.dtype.kind in _REAL)


def _number(value: Any) -> float:
    """Return one member of an object array as a float, infinite if too large; raise TypeError if it is no real number."""
    if isinstance(value, str | bytes | bytearray | bool | np.bool_ | np.datetime64 | np.timedelta64):
        raise TypeError(f"a {type(value).__name__} is no real number")
    if isinstance(value, complex | np.complexfloating):
        if value.imag:
            raise TypeError("a number with an imaginary part is no real number")
        value = value.real
    try:
        return float(value)
    except OverflowError:  # an integer beyond the range of float64
        return math.inf if value > 0 else -math.inf


class Packer:
    """Packer of values that student code returned, into nodes (JSON objects with a ``kind``) and the `arrays` that nodes refer to.

    Arrays are called `prefix` and a number, so two packers whose arrays are sent in one message need different prefixes.
    """

    def __init__(self, prefix: str = "a") -> None:
        self.arrays: dict[str, np.ndarray] = {}
        self._prefix = prefix

    def keep(self, array: Any) -> str:
        key = f"{self._prefix}{len(self.arrays)}"
        self.arrays[key] = np.array(array, dtype=np.float64, order="C", copy=True)
        return key

    def node(self, value: Any, depth: int = 0) -> dict[str, Any]:
        """Describe a value as a node (dict with a ``kind``); put its numbers in `self.arrays`. Student code may run and raise.

        `depth` counts the containers around the value; at four, a container is described as an array or by its type alone.
        """
        if value is None:
            return {"kind": "none"}
        if isinstance(value, str):
            return {"kind": "text", "text": mask_addresses(str(value))[:200]}
        if isinstance(value, np.ndarray):
            return self._array(value, "array")
        if hasattr(type(value), "__float__") and not hasattr(type(value), "__len__"):
            try:
                return {"kind": "number", "key": self.keep(numbers(value))}
            except (TypeError, ValueError):
                return {"kind": "other", "type": type(value).__name__[:60]}
        if depth < _MAX_DEPTH:
            if isinstance(value, tuple | list):
                return self._sequence(value, depth)
            if hasattr(value, "keys") and hasattr(value, "__getitem__"):
                return self._mapping({key: value[key] for key in list(value.keys())[:_MAX_ITEMS]}, "dict", value, depth)
            if dataclasses.is_dataclass(value) or hasattr(value, "__dict__"):
                members = {k: v for k, v in vars(value).items() if not k.startswith("_")}
                if members:
                    return self._mapping(members, "object", value, depth)
        return self._other(value)

    def _array(self, value: np.ndarray, kind: str) -> dict[str, Any]:
        if value.size > MAX_ELEMENTS:
            return {"kind": "too_large", "shape": [int(n) for n in value.shape]}
        if value.dtype.names:
            return self._mapping({name: value[name] for name in value.dtype.names[:_MAX_ITEMS]}, "dict", value, 1)
        try:
            known = numbers(value)
        except (TypeError, ValueError):
            return {"kind": "other", "type": f"array of {value.dtype}"[:60]}
        return {"kind": kind, "key": self.keep(known), "dtype": str(value.dtype)[:20]}

    def _sequence(self, value: Any, depth: int) -> dict[str, Any]:
        kind = "tuple" if isinstance(value, tuple) else "list"
        if len(value) <= _SHORT:
            return {"kind": kind, "type": type(value).__name__[:60], "items": [self.node(v, depth + 1) for v in value]}
        if len(value) > MAX_ELEMENTS:
            return {"kind": "too_large", "shape": [len(value)]}
        try:
            return self._array(numbers(value), "list")
        except (TypeError, ValueError):
            return self._table(value, depth) or {"kind": "other", "type": f"{kind} of unequal rows"}

    def _table(self, rows: Any, depth: int) -> dict[str, Any] | None:
        """Return a list of rows as a node of columns if their keys or lengths are equal; None for any other rows."""
        first, kinds = rows[0], {type(row) for row in rows}
        if len(kinds) > 1 or not isinstance(first, dict | tuple | list):
            return None
        names = list(first) if isinstance(first, dict) else range(len(first))
        if len(names) > _SHORT or any(len(row) != len(names) for row in rows):
            return None
        try:
            columns = {name: [row[name] for row in rows] for name in names}
        except (KeyError, IndexError):
            return None
        return self._mapping(columns, "object", rows, depth)

    def _mapping(self, members: dict[Any, Any], kind: str, value: Any, depth: int) -> dict[str, Any]:
        items = [
            [mask_addresses(str(name))[:100], self.node(member, depth + 1)]
            for name, member in list(members.items())[:_MAX_ITEMS]
        ]
        return {"kind": kind, "type": type(value).__name__[:60], "items": items}

    def _other(self, value: Any) -> dict[str, Any]:
        name = type(value).__name__[:60]
        try:
            array = np.asarray(value)
        except Exception:  # __array__ is the student's code
            return {"kind": "other", "type": name}
        return {"kind": "other", "type": name} if array.dtype == object else self._array(array, "array")
