"""Mangling: bytes, JSON values and arrays that are almost right."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np

_ODD: list[Any] = [
    None, True, 0, -1, 7, 10**39, 1e300, "", "a0", "saved", "x" * 3000, [], {}, [1, 2], {"kind": "array", "key": "a0"},
    [["time", {"kind": "array", "key": "a0"}]],
]  # fmt: skip


def mangled_bytes(data: bytes, chance: random.Random) -> bytes:
    """The bytes with one to eight changes: a piece is cut out, doubled, or exchanged for noise or for an extreme number."""
    out = bytearray(data)
    for _ in range(chance.randint(1, 8)):
        begin = chance.randrange(len(out) + 1)
        piece = bytes(out[begin : begin + chance.choice((1, 1, 4, 64))])
        new = (b"", 2 * piece, chance.randbytes(len(piece)), b"\xff\xff\xff\xff", bytes(4), b"\xff\xff\xff\x7f")
        out[begin : begin + len(piece)] = chance.choice(new)
    return bytes(out)


def mangled_value(value: Any, chance: random.Random) -> Any:
    """A JSON value with one change somewhere in it; the original is left alone."""
    if isinstance(value, dict) and value and chance.random() < 0.85:
        key = chance.choice(sorted(value))
        if chance.random() < 0.1:
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: mangled_value(value[key], chance)}
    if isinstance(value, list) and value and chance.random() < 0.85:
        at = chance.randrange(len(value))
        new = [mangled_value(value[at], chance)] if chance.random() < 0.8 else chance.choice(([], value[at:]))
        return [*value[:at], *new, *value[at + 1 :]]
    return chance.choice(_ODD)


def _with_one(value: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda array: np.where(np.arange(array.size).reshape(array.shape) == array.size // 2, value, array)


_CHANGES: tuple[Callable[[np.ndarray], Any], ...] = (
    lambda array: array[: len(array) // 2] if array.ndim else array,
    lambda array: np.concatenate([array, array]) if array.ndim else array,
    lambda array: array.T,
    np.ravel,
    lambda array: array[..., None],
    np.zeros_like,
    lambda array: np.full(array.shape, np.nan),
    lambda array: np.full(array.shape, -1e308),
    lambda array: array * 1e200,
    _with_one(np.nan),
    _with_one(np.inf),
    lambda array: np.nan_to_num(array).clip(-1e9, 1e9).astype(np.int64),
    lambda array: array.astype(np.complex128),
    lambda array: np.zeros((0, 3)),
    lambda array: np.zeros((2, 3, 4, 5)),
    lambda array: np.random.default_rng(0).normal(size=array.shape),
)


def mangled_array(array: np.ndarray, chance: random.Random) -> np.ndarray:
    """An array with one change: of its values, its shape or its type."""
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(chance.choice(_CHANGES)(array))
