"""What a report shows beside its words: charts of what the student's code answered, and the submission's fingerprint.

Charts decide nothing and are no part of `result.json`. They travel with a `Result` and are recorded beside it.
"""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Role = Literal[
    "x", "y", "z", "true-x", "true-y", "true-z", "own", "wanted", "model", "raw", "bars", "drawn", "not-seen"
]
"""How a curve is set: an axis, the truth beneath it, the student's own, the sheet's, a law, an input, bars, as it was drawn, or as
it was drawn where nobody sees it."""


@dataclass(frozen=True)
class Curve:
    """Points of one curve. `name` may be the student's; `colour` (``#rrggbb``) is theirs in what they drew, else empty."""

    name: str
    role: Role
    x: tuple[float, ...]
    y: tuple[float, ...]
    colour: str = ""


@dataclass(frozen=True)
class Panel:
    """Curves over one pair of axes, both logarithmic with `log`; `spread` is the smallest range of y that is shown."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    log: bool = False
    spread: float = 0.0


@dataclass(frozen=True)
class Chart:
    """Panels below one heading, with the sentence that says what they show; stands with the criterion `part`.

    `png` is a picture in their place, in base 64.
    """

    part: str
    title: str
    caption: str
    panels: tuple[Panel, ...] = ()
    png: str = ""


@dataclass(frozen=True)
class Evidence:
    """Of one submission: its charts, packed, and hashes of its code (see `fingerprint`).

    `figures` are the charts of each part as they stand in a page, where somebody has drawn them already; they are on no record.
    """

    charts: bytes = b""
    fingerprint: tuple[int, ...] = ()
    figures: Mapping[str, str] = field(default_factory=dict)


def packed(charts: tuple[Chart, ...]) -> bytes:
    """For the record and the way to it: JSON, compressed; points in single precision, finer than any pixel."""
    text = json.dumps(charts, default=_plain, separators=(",", ":"), allow_nan=False)
    return zlib.compress(text.encode(), 1) if charts else b""


def unpacked(record: bytes) -> tuple[Chart, ...]:
    """The inverse of `packed`."""
    return tuple(_chart(chart) for chart in json.loads(zlib.decompress(record))) if record else ()


def _chart(record: Mapping[str, Any]) -> Chart:
    return Chart(**{**record, "panels": tuple(_panel(panel) for panel in record["panels"])})


def _panel(record: Mapping[str, Any]) -> Panel:
    return Panel(**{**record, "curves": tuple(_curve(curve) for curve in record["curves"])})


def _curve(record: Mapping[str, Any]) -> Curve:
    return Curve(**{**record, "x": _numbers(record["x"]), "y": _numbers(record["y"])})


def _plain(value: object) -> dict[str, Any]:
    fields = vars(value)
    return {**fields, "x": _encoded(value.x), "y": _encoded(value.y)} if isinstance(value, Curve) else fields


def _encoded(numbers: tuple[float, ...]) -> str:
    return base64.b64encode(struct.pack(f"<{len(numbers)}f", *numbers)).decode()


def _numbers(text: str) -> tuple[float, ...]:
    content = base64.b64decode(text)
    return struct.unpack(f"<{len(content) // 4}f", content)
