"""Mangling: bytes, JSON values and arrays that are almost right."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np

_ODD: list[Any] = [
    None, True, False, 0, -1, 1, 7, 10**39, -(10**18), 1e300, -1e-300, 0.5, "", "x", "a0", "a1", "saved", "dict", "x" * 3000, [], {}, [[]],
    [1, 2], {"kind": "array", "key": "a0"}, {"kind": "none"}, [["time", {"kind": "array", "key": "a0"}]],
]  # fmt: skip


def mangled_bytes(data: bytes, chance: random.Random) -> bytes:
    """The bytes with one to eight changes: flipped, cut out, doubled, exchanged."""
    out = bytearray(data)
    for _ in range(chance.randint(1, 8)):
        if not out:
            break
        at = chance.randrange(len(out))
        length = chance.choice((1, 1, 2, 4, 16, 64))
        kind = chance.randrange(5)
        if kind == 0:
            out[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del out[at : at + length]
        elif kind == 2:
            out[at:at] = out[at : at + length]
        elif kind == 3:
            out[at : at + length] = chance.randbytes(length)
        else:
            out[at : at + 4] = chance.choice((b"\xff\xff\xff\xff", bytes(4), b"\xff\xff\xff\x7f", b"\x00\x00\x00\x80"))
    return bytes(out)


def mangled_value(value: Any, chance: random.Random) -> Any:
    """A JSON value with one change somewhere in it; the original is left alone."""
    if isinstance(value, dict) and value and chance.random() < 0.85:
        key = chance.choice(sorted(value))
        if chance.random() < 0.1:
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: mangled_value(value[key], chance)}
    if isinstance(value, list) and value and chance.random() < 0.85:
        at, act = chance.randrange(len(value)), chance.random()
        if act < 0.1:
            return value[:at] + value[at + 1 :]
        if act < 0.2:
            return value[: at + 1] + value[at:]
        return [*value[:at], mangled_value(value[at], chance), *value[at + 1 :]]
    return chance.choice(_ODD)


def mangled_array(array: np.ndarray, chance: random.Random) -> np.ndarray:
    """An array with one change: of its values, its shape or its type."""
    changes: list[Callable[[], np.ndarray]] = [
        lambda: array[: len(array) // 2] if array.ndim else array,
        lambda: np.concatenate([array, array]) if array.ndim else array,
        lambda: array[:0] if array.ndim else array,
        lambda: array[:1] if array.ndim else array,
        lambda: array.T,
        array.ravel,
        lambda: array[..., None],
        lambda: array[None],
        lambda: np.zeros_like(array),
        lambda: np.ones_like(array),
        lambda: np.full_like(array, np.nan),
        lambda: np.full_like(array, np.inf),
        lambda: np.full_like(array, -1e308),
        lambda: array * 1e200,
        lambda: array * 1e-300,
        lambda: _one(array, np.nan, chance),
        lambda: _one(array, np.inf, chance),
        lambda: _one(array, 1e308, chance),
        lambda: array.astype(np.int64) if np.isfinite(array).all() and np.abs(array).max(initial=0) < 1e15 else array,
        lambda: array.astype(np.complex128),
        lambda: np.array(0.5),
        lambda: np.zeros((0, 3)),
        lambda: np.zeros((2, 3, 4, 5)),
        lambda: np.random.default_rng(chance.randrange(99)).normal(size=array.shape),
        lambda: array[::-1] if array.ndim else array,
    ]
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(chance.choice(changes)())


def _one(array: np.ndarray, value: float, chance: random.Random) -> np.ndarray:
    out = np.array(array, dtype=np.float64)
    if out.size:
        out.flat[chance.randrange(out.size)] = value
    return out
