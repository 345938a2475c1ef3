"""Decoding a handed-in picture, inside the box: size, how much is on it, how it looks, or why it cannot be read."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np

_MAX_PIXELS = 40_000_000
_THUMBNAIL = 160
_PREVIEW = 640
_COLOURS = 64


def decode(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Decode one picture given as bytes.

    Returns
    -------
    fields : dict
        ``readable`` and, if so, ``size_px``, ``colours`` (distinct ones on a 160-pixel thumbnail) and ``ink`` (the share of its
        pixels that are not of the commonest colour); otherwise ``reason``.
    arrays : dict
        If readable, ``preview`` (h, w) with indices into ``palette`` (64, 3): the picture in few pixels and colours.
    """
    from PIL import Image

    del fields
    Image.MAX_IMAGE_PIXELS = _MAX_PIXELS
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(arrays["bytes"].tobytes())) as picture:
                size = [int(n) for n in picture.size]
                picture.draft("RGB", (_PREVIEW, _PREVIEW))
                preview = _on_white(picture, _PREVIEW)
                small = preview.copy()
                small.thumbnail((_THUMBNAIL, _THUMBNAIL))
                few = preview.quantize(_COLOURS)
    except Exception as error:  # any broken file, any codec
        return {"readable": False, "reason": type(error).__name__}, {}
    pixels = np.asarray(small).reshape(-1, 3)
    _, counts = np.unique(pixels, axis=0, return_counts=True)
    palette = np.zeros((_COLOURS, 3), dtype=np.uint8)
    known = np.array(few.getpalette()[: 3 * _COLOURS], dtype=np.uint8).reshape(-1, 3)
    palette[: len(known)] = known
    facts = {"readable": True, "size_px": size, "colours": len(counts), "ink": float(1 - counts.max() / len(pixels))}
    return facts, {"preview": np.asarray(few, dtype=np.uint8), "palette": palette}


def _on_white(picture: Any, longest: int) -> Any:
    """As a reader sees it, of a few pixels: what is transparent shows the page."""
    from PIL import Image

    small = picture.convert("RGBA")
    small.thumbnail((longest, longest))
    return Image.alpha_composite(Image.new("RGBA", small.size, "white"), small).convert("RGB")
