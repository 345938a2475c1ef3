"""A question to the code that was handed in, as one record. What it asks is what it is known by: equal questions are one."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Generic, TypeVar

import numpy as np

from grader.sandbox.wire import Frame

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Question(Generic[T]):
    """What is asked, and the record that the answer becomes.

    Attributes
    ----------
    op : which handler of the worker code runs it, and which of the lab's rules its answer must obey
    about : the name that it is asked about, wherever the submission defines it
    becomes : makes the record of an answer that obeys the rule
    fields, arrays : what the handler is given
    """

    op: str
    about: str
    becomes: Callable[[Frame], T]
    fields: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """The same for two questions that ask the same."""
        return key_of(self.op, {"": self.about, **self.fields}, self.arrays)


_SORTED = json.JSONEncoder(sort_keys=True)
_LONG = 1000


def key_of(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """A digest of all that is asked: every field, and the type, shape and numbers of every array."""
    short = {name: _digested(value) if _is_long(value) else value for name, value in fields.items()}
    digest = hashlib.sha256(_SORTED.encode([op, short]).encode("utf-8", "surrogatepass"))
    for name, array in sorted(arrays.items()):
        whole = np.ascontiguousarray(array)
        digest.update(f"\0{name}\0{whole.dtype.str}\0{whole.shape}\0".encode())
        digest.update(whole.tobytes())
    return f"{op} {digest.hexdigest()}"


def _is_long(value: object) -> bool:
    return isinstance(value, str) and len(value) > _LONG


@lru_cache(maxsize=64)
def _digested(text: str) -> dict[str, str]:
    """What stands for a long text, no text itself: nearly every question has the model, which is the longest part of it by far."""
    return {"sha256": hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()}
