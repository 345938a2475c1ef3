"""Chart data of a report (curves of what student code returned), and the code fingerprint that finds similar submissions.

Both belong to a `Result` and are recorded beside it. They do not affect the grade and are not part of `result.json`.
"""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Role = Literal[
    "x", "y", "z", "true-x", "true-y", "true-z", "own", "wanted", "model", "raw", "bars", "drawn", "not-seen"
]
"""Drawing style of a curve. ``x``, ``y``, ``z``: an axis; ``true-…``: the ground truth below it; ``own``: the student's;
``wanted``: the sheet's; ``model``: a law; ``raw``: an input; ``bars``: bars; ``drawn``: as in the student's figure;
``not-seen``: the same, but not visible there."""


@dataclass(frozen=True)
class Curve:
    """One curve of a chart: name in the legend, drawing style `role` (see `Role`), the student's `colour`, "" for the style's."""

    name: str
    role: Role
    x: tuple[float, ...]
    y: tuple[float, ...]
    colour: str = ""


@dataclass(frozen=True)
class Panel:
    """Curves on one pair of axes. `log` makes both axes logarithmic; without it, the y axis spans at least `spread`."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    log: bool = False
    spread: float = 0.0


@dataclass(frozen=True)
class Chart:
    """A chart of a report: panels with a title and a caption, shown with the criterion whose id is `part`.

    `png` is a picture (base64) that is shown in place of panels, such as one that was handed in; "" if there are panels.
    """

    part: str
    title: str
    caption: str
    panels: tuple[Panel, ...] = ()
    png: str = ""


@dataclass(frozen=True)
class Evidence:
    """Evidence that a result carries beside its grade: packed charts for reports, and code hashes to find similar submissions."""

    charts: bytes = b""
    fingerprint: tuple[int, ...] = ()


def packed(charts: tuple[Chart, ...]) -> bytes:
    """Return charts as compressed JSON to record or send; b"" for no charts. Points have single precision, finer than a pixel."""
    text = json.dumps(charts, default=_plain, separators=(",", ":"), allow_nan=False)
    return zlib.compress(text.encode(), 1) if charts else b""


def unpacked(record: bytes) -> tuple[Chart, ...]:
    """Return the charts from the bytes that `packed` made; () from b""."""
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
