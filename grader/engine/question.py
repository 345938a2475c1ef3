"""Question to the code of a submission. Its key is a digest of its content, so that equal questions are asked once."""

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
    """A question that the sandbox answers by running student code, and how the answer is converted.

    Attributes
    ----------
    op : name of the operation; selects its handler in the sandbox and the `replies.Rule` that the reply must obey
    about : the lab's function or class whose code is to run, in whichever file the submission defines it
    becomes : converts a reply that obeys the rule into the answer
    fields, arrays : input of the operation's handler
    """

    op: str
    about: str
    becomes: Callable[[Frame], T]
    fields: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Digest of the question, equal for equal questions, by which a session finds an earlier answer."""
        return key_of(self.op, {"": self.about, **self.fields}, self.arrays)


_SORTED = json.JSONEncoder(sort_keys=True)
_LONG = 1000


def key_of(op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """Return a digest that equal questions share: of the operation, the fields, and the type, shape and numbers of the arrays."""
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
    """Return the digest that replaces a long text in a key; cached, because nearly all questions repeat the lab's model."""
    return {"sha256": hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()}
