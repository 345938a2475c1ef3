"""Handed-in pictures that no code draws: set anew from the pixels that were judged, no byte of the file itself."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from typing import Any

from grader.engine.evidence import Chart


def chart(name: str, facts: Mapping[str, Any] | None) -> Chart | None:
    """What the box made out of the picture `name`; None where it was not looked at or could not be read."""
    if facts is None or not facts["readable"]:
        return None
    width, height = facts["size_px"]
    return Chart(
        "visualization",
        f"{name} as it was handed in",
        f"{width} × {height} pixels, set here in fewer. It counts where no code of the submission draws it.",
        png=_png(facts["preview"], facts["palette"]),
    )


def _png(preview: Any, palette: Any) -> str:
    from PIL import Image  # noqa: PLC0415 - few submissions need it

    picture = Image.fromarray(preview)
    picture.putpalette(palette.tobytes())
    stream = io.BytesIO()
    picture.save(stream, format="PNG", optimize=True)
    return base64.b64encode(stream.getvalue()).decode()
