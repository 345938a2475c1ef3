"""Frames: the messages between the grader and a sandbox, in both directions.

A frame is a header (two sizes and a nonce), strict JSON, and raw little-endian arrays. Sizes are checked against caps before
anything is allocated, and shapes and dtypes are rebuilt and checked (`arrays`): nothing is unpickled, nothing that the other side
says about itself is believed. The module is pure, so that both sides use the same code.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

HEADER = struct.Struct("<II16s")
NONCE_BYTES = 16
MAX_DEPTH = 32
MAX_INTEGER_DIGITS = 40


@dataclass(frozen=True)
class Caps:
    """Limits of a frame (message), so that no side runs out of memory: bytes of JSON, bytes of arrays, and number of arrays."""

    text: int
    body: int
    arrays: int


ANSWER = Caps(1 << 20, 32 << 20, 1024)
QUESTION = Caps(16 << 20, 64 << 20, 4096)
"""A question may hold a whole answer again (a recording, to be plotted) and what the grader adds; or 2,064 files of a submission,
each under a path of 1,000 characters, with 24 MB in all."""


class WireError(ValueError):
    """Exception: received bytes are no frame (message of the protocol), or values do not fit into one."""


@dataclass(frozen=True, eq=False)
class Frame:
    """One message between the grader and a worker: plain data and arrays.

    Attributes
    ----------
    fields
        JSON values: no NaN, no infinity, no object deeper than `MAX_DEPTH`.
    arrays
        Read-only arrays of the dtypes of `arrays.DTYPES`, at most `arrays.MAX_DIMENSIONS` dimensions each.
    """

    fields: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, np.ndarray] = field(default_factory=dict)


@cache
def _arrays() -> ModuleType:
    """Return the module `arrays`, imported with the first frame only: NumPy takes long, and the zygote warms up meanwhile."""
    from . import arrays  # noqa: PLC0415

    return arrays


def pack(
    nonce: bytes,
    fields: Mapping[str, Any],
    arrays: Mapping[str, np.ndarray],
    caps: Caps = ANSWER,
    errors: str = "strict",
) -> bytes:
    """Return the bytes of a frame (message). `nonce`, 16 bytes, tells which request it belongs to: an answer repeats the request's.

    `errors` says what becomes of lone surrogates, as for `str.encode`. Raise WireError if a value is no JSON, an array's dtype is
    not in `DTYPES` of the module `arrays`, or the frame is larger than `caps` allow.
    """
    try:
        layout, chunks = _arrays().pack(arrays, caps.body)
    except ValueError as error:
        raise WireError(str(error)) from None
    try:
        text = json.dumps({"fields": dict(fields), "arrays": layout}, allow_nan=False, ensure_ascii=False)
        payload = text.encode("utf-8", errors)
    except (TypeError, ValueError, RecursionError) as error:
        raise WireError(f"the fields are no strict JSON: {error}") from None
    body = b"".join(chunks)
    _check_sizes(len(payload), len(body), caps)
    return HEADER.pack(len(payload), len(body), nonce) + payload + body


def unpack(text: bytes | bytearray, body: bytes | bytearray, caps: Caps = ANSWER) -> Frame:
    """Return the frame (message) that consists of `text`, its JSON, and `body`, the bytes of its arrays.

    Raise WireError if `text` is not a frame's JSON (strict, within `MAX_DEPTH` and `MAX_INTEGER_DIGITS`), if it does not describe
    `body`, or if there are more arrays than `caps` allow. The sizes in bytes are checked by `Incoming`, from the header.
    """
    message = _parse(bytes(text))
    if not isinstance(message, dict) or set(message) != {"fields", "arrays"}:
        raise WireError("a frame holds fields and arrays, and nothing else")
    fields, layout = message["fields"], message["arrays"]
    if not isinstance(fields, dict):
        raise WireError("the fields are not an object")
    try:
        return Frame(fields, _arrays().unpack(layout, memoryview(body).toreadonly(), caps.arrays))
    except ValueError as error:
        raise WireError(str(error)) from None


class Incoming:
    """Receiver of one frame (message), whose bytes arrive in pieces; the header is enough to refuse a frame larger than `caps`."""

    def __init__(self, caps: Caps = ANSWER) -> None:
        self._caps = caps
        self._data = bytearray()
        self._sizes: tuple[int, int] | None = None
        self._total = HEADER.size

    @property
    def wanted(self) -> int:
        """Bytes to receive next: what is missing of the header, then of the rest; 0 if all have come or the header was refused."""
        return self._total - len(self._data)

    def feed(self, chunk: bytes) -> None:
        """Add bytes; raise WireError if they are more than `wanted`, or the header announces a frame larger than `caps` allow."""
        if len(chunk) > self.wanted:
            raise WireError("more bytes than the frame announced")
        self._data += chunk
        if self._sizes is None and not self.wanted:
            text_bytes, body_bytes, _ = HEADER.unpack(self._data)
            _check_sizes(text_bytes, body_bytes, self._caps)
            self._sizes = text_bytes, body_bytes
            self._total += text_bytes + body_bytes

    def finish(self) -> tuple[bytes, Frame]:
        """Return the nonce (which request is answered) and the frame; raise WireError if bytes are missing or are no frame."""
        if self._sizes is None or self.wanted:
            raise WireError("the frame is incomplete")
        start, stop = HEADER.size, HEADER.size + self._sizes[0]
        nonce = bytes(self._data[start - NONCE_BYTES : start])
        return nonce, unpack(self._data[start:stop], self._data[stop:], self._caps)


def _check_sizes(text_bytes: int, body_bytes: int, caps: Caps) -> None:
    if text_bytes > caps.text:
        raise WireError(f"{text_bytes} bytes of JSON, at most {caps.text} are allowed")
    if body_bytes > caps.body:
        raise WireError(f"{body_bytes} bytes of arrays, at most {caps.body} are allowed")


# JSON -----------------------------------------------------------------------------------------------------------------


def _parse(text: bytes) -> Any:
    try:
        value = json.loads(
            text.decode("utf-8"),
            object_pairs_hook=_distinct,
            parse_constant=_refuse_constant,
            parse_float=_finite,
            parse_int=_short_integer,
        )
    except (ValueError, RecursionError) as error:
        raise WireError(f"not strict JSON: {str(error)[:200]}") from None
    _check_depth(value)
    if b"\\u" in text:  # nothing else can write half of a character
        _check_texts(value)
    return value


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) != len(pairs):
        raise WireError("a key comes twice")
    return result


def _refuse_constant(name: str) -> float:
    raise WireError(f"{name} is not JSON")


def _finite(digits: str) -> float:
    """Parse a number of a JSON text; raise WireError if it is so large that it would become infinity."""
    number = float(digits)
    if not math.isfinite(number):
        raise WireError("a number is too large")  # 1e400 would silently become infinity
    return number


def _short_integer(digits: str) -> int:
    if len(digits) > MAX_INTEGER_DIGITS:
        raise WireError(f"an integer has {len(digits)} digits")
    return int(digits)


def _check_depth(value: Any) -> None:
    """Raise WireError if a value is nested deeper than `MAX_DEPTH`: `json` accepts it, and later code would fail."""
    layer = [value]
    for _ in range(MAX_DEPTH):
        layer = [
            child
            for item in layer
            if isinstance(item, list | dict)
            for child in (item if isinstance(item, list) else item.values())
        ]
        if not layer:
            return
    raise WireError(f"nested deeper than {MAX_DEPTH}")


def _check_texts(value: Any) -> None:
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        raise WireError("a string holds a lone surrogate") from None
