"""A picture of a plot that no code draws: six curves on white, as a PNG."""

from __future__ import annotations

import struct
import zlib

import numpy as np


def canned_picture(width: int = 640, height: int = 480) -> bytes:
    pixels = np.full((height, width, 3), 255, np.uint8)
    x = np.arange(width)
    for number in range(6):
        y = (height // 7) * (number + 1) + (20 * np.sin(x / (10 + 5 * number))).astype(int)
        pixels[y, x] = (40 * number, 100, 255 - 40 * number)
        pixels[y + 1, x] = (40 * number, 100, 255 - 40 * number)
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
