"""Frames: everything that fits comes back as it was, everything else is refused with one error."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from grader.sandbox import arrays, wire
from grader.sandbox.wire import Frame, WireError
from tests.budgets import memory_within

NONCE = bytes(range(16))

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
scalars = st.none() | st.booleans() | st.integers(-(10**30), 10**30) | st.floats(allow_nan=False, allow_infinity=False)
values = st.recursive(
    scalars | texts, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3), max_leaves=8
)
some_arrays = st.sampled_from(sorted(arrays.DTYPES)).flatmap(
    lambda name: hnp.arrays(arrays.DTYPES[name], hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4))
)


def sent(data: bytes, piece: int = 1 << 20) -> tuple[bytes, Frame]:
    incoming = wire.Incoming()
    while data:
        size = min(piece, incoming.wanted)
        if not size:
            raise WireError("more bytes than a frame")
        incoming.feed(data[:size])
        data = data[size:]
    return incoming.finish()


def frame_of(text: bytes, body: bytes = b"") -> bytes:
    return wire.HEADER.pack(len(text), len(body), NONCE) + text + body


@given(st.dictionaries(texts, values, max_size=4), st.dictionaries(texts, some_arrays, max_size=3), st.integers(1, 40))
def test_a_frame_comes_back_as_it_was_sent_in_whatever_pieces(
    fields: dict[str, Any], arrays: dict[str, np.ndarray], piece: int
) -> None:
    nonce, frame = sent(wire.pack(NONCE, fields, arrays), piece)
    assert nonce == NONCE
    assert frame.fields == fields
    assert list(frame.arrays) == list(arrays)
    for name, array in arrays.items():
        assert frame.arrays[name].dtype == array.dtype
        np.testing.assert_array_equal(frame.arrays[name], array, strict=True)


@pytest.mark.parametrize(
    "text",
    [
        "NaN", "Infinity", "-Infinity", "1e400", "9" * 5000, "[" * 100_000, "[" * 40 + "]" * 40, '{"a": 1, "a": 2}', '"\\ud800"',
        '{"\\udfff": 1}', "1, ", "'x'",
    ],
)  # fmt: skip
def test_json_that_would_hurt_later_is_refused(text: str) -> None:
    with pytest.raises(WireError):
        sent(frame_of(b'{"fields": {"x": ' + text.encode() + b'}, "arrays": []}'))


@pytest.mark.parametrize("text", [b"\xff\xfe", b"[]", b"{}", b'{"fields": [], "arrays": []}', b'{"fields": {}}', b""])
def test_text_that_is_no_frame_is_refused(text: bytes) -> None:
    with pytest.raises(WireError):
        sent(frame_of(text))


@pytest.mark.parametrize(
    ("layout", "body"),
    [
        ([["x", "object", [1]]], bytes(16)),
        ([["x", "<f8", [1]]], bytes(16)),
        ([["x", "float64", [-1]]], b""),
        ([["x", "float64", [True]]], bytes(16)),
        ([["x", "float64", [1.0]]], bytes(16)),
        ([["x", "float64", [2**62, 4]]], b""),
        ([["x", "float64", [0, 2**31 - 1, 2**31 - 1, 2**31 - 1]]], b""),
        ([["x", "float64", [1] * 9]], bytes(16)),
        ([["x", "float64", [3]]], bytes(16)),
        ([["x", "float64", [1]]], bytes(32)),
        ([["x", "uint8", [1]], ["x", "uint8", [1]]], bytes(32)),
        ([["x", "bool", [1]]], b"\x02" + bytes(15)),
        ([["x", "float64"]], b""),
        ([[1, "float64", [0]]], b""),
        ([["x", ["float64"], [0]]], b""),
        ({"x": 1}, b""),
        ([], bytes(16)),
        ([["x", "uint8", [0]]] * 2000, b""),
    ],
)
def test_arrays_that_are_not_what_they_say_are_refused(layout: Any, body: bytes) -> None:
    with pytest.raises(WireError):
        sent(frame_of(json.dumps({"fields": {}, "arrays": layout}).encode(), body))


@pytest.mark.parametrize("sizes", [(0xFFFFFFFF, 0), (0, 0xFFFFFFFF), ((1 << 20) + 1, 0), (0, (32 << 20) + 1)])
def test_a_header_that_announces_too_much_is_refused_before_anything_is_allocated(sizes: tuple[int, int]) -> None:
    with memory_within(1), pytest.raises(WireError, match="are allowed"):
        wire.Incoming().feed(struct.pack("<II16s", *sizes, NONCE))


@pytest.mark.parametrize(
    ("fields", "arrays"),
    [
        ({"x": float("nan")}, {}),
        ({"x": object()}, {}),
        ({"x": "\ud800"}, {}),
        ({"x": "a" * (1 << 20)}, {}),
        ({}, {"x": np.array([object()])}),
        ({}, {"x": np.zeros(2, "float16")}),
        ({}, {"x": np.zeros((1,) * 9)}),
        ({}, {"x": np.zeros((32 << 20) + 1, np.uint8)}),
        ({}, {"x": np.zeros(20 << 20, np.uint8), "y": np.zeros(20 << 20, np.uint8)}),
    ],
)
def test_what_does_not_fit_is_refused_by_the_sender(fields: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    with pytest.raises(WireError):
        wire.pack(NONCE, fields, arrays)


def test_an_incomplete_frame_is_not_finished() -> None:
    incoming = wire.Incoming()
    incoming.feed(b"\0" * 10)
    assert incoming.wanted == wire.HEADER.size - 10
    with pytest.raises(WireError, match="incomplete"):
        incoming.finish()
