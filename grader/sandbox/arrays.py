"""Arrays of a message between grader and sandbox: little-endian bytes with name, dtype and shape, checked on arrival."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

MAX_DIMENSIONS = 8
MAX_LENGTH = 1 << 31
ALIGNMENT = 16  # every array starts at a multiple, so that what frombuffer makes of it is aligned

DTYPES: dict[str, np.dtype[Any]] = {
    "float64": np.dtype("<f8"),
    "float32": np.dtype("<f4"),
    "int64": np.dtype("<i8"),
    "int32": np.dtype("<i4"),
    "uint8": np.dtype("u1"),
    "bool": np.dtype("?"),
    "complex128": np.dtype("<c16"),
}


def _padded(size: int) -> int:
    return -(-size // ALIGNMENT) * ALIGNMENT


def pack(arrays: Mapping[str, np.ndarray], most: int) -> tuple[list[list[Any]], list[bytes]]:
    """Return a description of each array (name, dtype, shape) for a message's JSON, and each one's bytes, which follow the JSON.

    Raise ValueError if one of the arrays has a dtype or shape that cannot be sent, or alone more than `most` bytes.
    """
    layout: list[list[Any]] = []
    chunks: list[bytes] = []
    for name, value in arrays.items():
        array = np.asarray(value)
        dtype = DTYPES.get(array.dtype.name)
        if dtype is None or array.ndim > MAX_DIMENSIONS:
            raise ValueError(f"array {name!r} of {array.dtype} with {array.ndim} dimensions cannot be sent")
        if array.nbytes > most:
            raise ValueError(f"array {name!r} has {array.nbytes} bytes, at most {most} are allowed")
        chunks.append(array.astype(dtype, copy=False).tobytes().ljust(_padded(array.nbytes), b"\0"))
        layout.append([name, array.dtype.name, list(array.shape)])
    return layout, chunks


def unpack(layout: Any, body: memoryview, most: int) -> dict[str, np.ndarray]:
    """Return the arrays of a message, by name: `layout` is the description that `pack` returned, and `body` holds their bytes.

    Raise ValueError if the number of arrays exceeds `most`, or if `pack` could not have written `layout` and `body`.
    """
    if not isinstance(layout, list) or len(layout) > most:
        raise ValueError(f"the arrays are not a list of at most {most}")
    arrays: dict[str, np.ndarray] = {}
    offset = 0
    for entry in layout:
        name, dtype, shape = _described(entry)
        if name in arrays:
            raise ValueError(f"array {name!r} comes twice")
        size = math.prod(shape) * dtype.itemsize  # python integers: no overflow to hide behind
        if offset + _padded(size) > len(body):
            raise ValueError(f"array {name!r} is larger than what was sent")
        arrays[name] = _rebuilt(body[offset : offset + size], dtype, shape)
        offset += _padded(size)
    if offset != len(body):
        raise ValueError("there are bytes that belong to no array")
    return arrays


def _described(entry: Any) -> tuple[str, np.dtype[Any], tuple[int, ...]]:
    if not isinstance(entry, list) or len(entry) != 3:
        raise ValueError("an array is described by name, dtype and shape")
    name, kind, shape = entry
    if not isinstance(name, str) or not isinstance(kind, str) or kind not in DTYPES:
        raise ValueError("an array has a name and one of the known dtypes")
    if not isinstance(shape, list) or len(shape) > MAX_DIMENSIONS:
        raise ValueError(f"array {name!r} does not have a shape of at most {MAX_DIMENSIONS} lengths")
    if not all(type(length) is int and 0 <= length < MAX_LENGTH for length in shape):
        raise ValueError(f"array {name!r} has an impossible shape")
    return name, DTYPES[kind], tuple(shape)


def _rebuilt(data: memoryview, dtype: np.dtype[Any], shape: tuple[int, ...]) -> np.ndarray:
    if dtype.kind == "b" and bool(np.any(np.frombuffer(data, np.uint8) > 1)):
        raise ValueError("a truth value is neither 0 nor 1")
    try:
        return np.frombuffer(data, dtype).reshape(shape)
    except (ValueError, OverflowError) as error:  # e.g. (0, 2**31 - 1, 2**31 - 1, 2**31 - 1)
        raise ValueError(f"an array cannot have the shape {shape}: {error}") from None
