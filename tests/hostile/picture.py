"""PNGs written chunk by chunk: what attacks hand in, and a picture of a plot that no code draws."""

from __future__ import annotations

import struct
import zlib

import numpy as np

END = (b"IEND", b"")


def png(*chunks: tuple[bytes, bytes]) -> bytes:
    made = (struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks)
    return b"\x89PNG\r\n\x1a\n" + b"".join(made)


def head(width: int, height: int, kind: int = 2) -> tuple[bytes, bytes]:
    return b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)


def canned_picture(width: int = 640, height: int = 480) -> bytes:
    """Six curves on white."""
    pixels = np.full((height, width, 3), 255, np.uint8)
    x = np.arange(width)
    for number in range(6):
        y = (height // 7) * (number + 1) + (20 * np.sin(x / (10 + 5 * number))).astype(int)
        pixels[y, x] = (40 * number, 100, 255 - 40 * number)
        pixels[y + 1, x] = (40 * number, 100, 255 - 40 * number)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    return png(head(width, height), (b"IDAT", zlib.compress(rows)), END)
