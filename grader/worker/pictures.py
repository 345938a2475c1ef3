"""Decode a submitted picture inside the sandbox, where a hostile file does no harm: its size, amount of ink and a preview."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np

_MAX_PIXELS = 40_000_000
_THUMBNAIL = 160
_PREVIEW = 640
_COLOURS = 256
_MANY = 65_536  # colours of a photograph; a figure has 20,000, as a JPEG 35,000
# Number of background colours, and the step in which colours are rounded before they are counted.
_GROUNDS, _SHADES = 4, 16


def decode(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Decode the picture in ``arrays["bytes"]``. A file that cannot be decoded is answered with the reason, and raises nothing.

    Returns
    -------
    fields : dict
        ``readable`` and, if so, ``size_px``, ``colours`` (the number of distinct colours of a 160-pixel thumbnail) and ``ink`` (the
        share of its pixels that have none of the four commonest colours, the background); otherwise ``reason``, an error's type.
    arrays : dict
        If readable, a reduced picture: ``preview`` (h, w) with indices into ``palette`` (256, 3).
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
                few = preview.quantize(_COLOURS, _reduction(preview))
    except Exception as error:  # any broken file, any codec
        return {"readable": False, "reason": type(error).__name__}, {}
    pixels = np.asarray(small).reshape(-1, 3)
    colours, shades = (np.unique(each, axis=0, return_counts=True)[1] for each in (pixels, pixels // _SHADES))
    flat = np.sort(shades)[-_GROUNDS:].sum() / len(pixels)
    palette = np.zeros((_COLOURS, 3), dtype=np.uint8)
    known = np.array(few.getpalette()[: 3 * _COLOURS], dtype=np.uint8).reshape(-1, 3)
    palette[: len(known)] = known
    facts = {"readable": True, "size_px": size, "colours": len(colours), "ink": float(1 - flat)}
    return facts, {"preview": np.asarray(few, dtype=np.uint8), "palette": palette}


def _reduction(picture: Any) -> Any:
    """Return Pillow's method to reduce colours: one that keeps thin curves, or a fast one for pictures of very many colours."""
    from PIL import Image

    return Image.Quantize.MEDIANCUT if picture.getcolors(_MANY) is None else Image.Quantize.MAXCOVERAGE


def _on_white(picture: Any, longest: int) -> Any:
    """Return the picture with at most `longest` pixels a side, on a white background, which transparent pixels show."""
    from PIL import Image

    small = picture.convert("RGBA")
    small.thumbnail((longest, longest))
    return Image.alpha_composite(Image.new("RGBA", small.size, "white"), small).convert("RGB")
