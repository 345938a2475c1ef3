"""Read values that student code returned, as the worker reports them: their numbers, and their form in words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.engine.findings import GraderText

Array = NDArray[np.float64]
Node = Mapping[str, Any]
Arrays = Mapping[str, Array]

ACCELERATION_NAME = re.compile(r"acc|specific|force|linear", re.IGNORECASE)
RATE_NAME = re.compile(r"gyr|ang|omega|rate|rot", re.IGNORECASE)
"""Patterns by which the name of a value, a key or a column tells that it holds an acceleration or an angular velocity."""


def numbers(node: Node | None, arrays: Arrays) -> Array | None:
    """Return as one array from `arrays` what `node` describes: an array, a number, a list or tuple of equal shapes; else None."""
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
    """Describe in words a returned value (None: nothing), such as ``a tuple of 2 (an array of shape (3,), a number)``."""
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
    """Return a hint for a function that returned None; "" if `got`, a returned value described in words, is another value."""
    return _NOTHING_RETURNED if got.removeprefix("got ").startswith("None") else ""


_NOTHING_RETURNED = GraderText(
    "The function returns None: it is still to be written, or a return statement is missing."
)
