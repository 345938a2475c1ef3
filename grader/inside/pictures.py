"""Decoding a handed-in picture, inside the box: size, how much is on it, or why it cannot be read."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np

_MAX_PIXELS = 40_000_000
_THUMBNAIL = 160


def decode(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Decode one picture given as bytes.

    Returns
    -------
    fields : dict
        ``readable`` and, if so, ``size_px``, ``colours`` (distinct ones on a 160-pixel thumbnail) and ``ink`` (the share of its
        pixels that are not of the commonest colour); otherwise ``reason``.
    """
    from PIL import Image

    del fields
    Image.MAX_IMAGE_PIXELS = _MAX_PIXELS
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(arrays["bytes"].tobytes())) as picture:
                size = [int(n) for n in picture.size]
                picture.draft("RGB", (_THUMBNAIL * 4, _THUMBNAIL * 4))
                small = picture.convert("RGB")
                small.thumbnail((_THUMBNAIL, _THUMBNAIL))
    except Exception as error:  # any broken file, any codec
        return {"readable": False, "reason": type(error).__name__}, {}
    pixels = np.asarray(small).reshape(-1, 3)
    _, counts = np.unique(pixels, axis=0, return_counts=True)
    return {"readable": True, "size_px": size, "colours": len(counts), "ink": float(1 - counts.max() / len(pixels))}, {}
