"""Charts of handed-in pictures that no code draws: made of the pixels that were judged, without a byte of the file itself."""

from __future__ import annotations

import base64
import io

from grader.engine.chart_data import Chart
from grader.engine.figures import Picture


def chart(name: str, picture: Picture | None) -> Chart | None:
    """Return a chart of `picture`, the decoded handed-in file `name`; None without a picture, as for an unreadable file."""
    if picture is None:
        return None
    width, height = picture.size_px
    return Chart(
        "visualization",
        f"{name} as it was handed in",
        f"{width} × {height} pixels, shown here with fewer. It counts only if no code of the submission draws it.",
        png=_png(picture),
    )


def _png(picture: Picture) -> str:
    """Return a picture's reduced pixels as PNG in base64, to be part of the page."""
    from PIL import Image  # noqa: PLC0415 - few submissions need it

    image = Image.fromarray(picture.preview)
    image.putpalette(picture.palette.tobytes())
    stream = io.BytesIO()
    image.save(stream, format="PNG", optimize=True)
    return base64.b64encode(stream.getvalue()).decode()
