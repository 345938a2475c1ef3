"""Archive of submitted files in the class database, with limits on size and number, for review and repairs."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from grader.engine.fingerprint import cells
from grader.intake.names import has_suffix, is_code

LARGEST = 1_000_000
"""Bytes of one file. The longest honest program has a twentieth of it, and a picture a tenth."""
TOGETHER = 4_000_000
MOST = 200
_PACKED = (".png", ".jpg", ".jpeg", ".webp", ".gif")
"""Compressed picture formats, which are stored as they are: compressing them again takes longer than all other files."""
PNG = b"\x89PNG\r\n\x1a\n"
_WIDEST = 5000  # pixels; a browser decodes a picture completely
_HEAD = struct.Struct("<I")


@dataclass(frozen=True)
class Kept:
    """Submitted files from the database: `files` by path, the sizes of `others` left out, and how many `more` went unlisted."""

    files: Mapping[str, bytes]
    others: Mapping[str, int]
    more: int = 0


NOTHING_KEPT = Kept({}, {})


def pack(files: Mapping[str, bytes]) -> bytes:
    """Pack submitted files for the database, code first, then small files; keep only path and size of those beyond the limits."""
    chosen: dict[str, bytes] = {}
    left = TOGETHER
    for path, content in sorted(files.items(), key=lambda item: (not is_code(item[0]), len(item[1]), item[0])):
        if len(content) <= min(LARGEST, left) and len(chosen) < MOST:
            chosen[path] = content
            left -= len(content)
    chosen = dict(sorted(chosen.items(), key=lambda item: has_suffix(item[0], _PACKED)))
    others = sorted((path, len(content)) for path, content in files.items() if path not in chosen)
    sizes = [(path, len(content)) for path, content in chosen.items()]
    head = json.dumps({"files": sizes, "others": others[:MOST], "more": max(0, len(others) - MOST)}).encode()
    plain = (content for path, content in chosen.items() if not has_suffix(path, _PACKED))
    as_they_are = (content for path, content in chosen.items() if has_suffix(path, _PACKED))
    return b"".join((zlib.compress(b"".join((_HEAD.pack(len(head)), head, *plain)), 1), *as_they_are))


def unpack(record: bytes) -> Kept:
    """Return the files that `pack` packed; none for empty bytes. Damage outside pictures raises an error, such as zlib.error."""
    if not record:
        return NOTHING_KEPT
    stream = zlib.decompressobj()
    data = stream.decompress(record) + stream.unused_data
    if not stream.eof:
        raise ValueError("it ends too early")
    (length,) = _HEAD.unpack_from(data)
    head = json.loads(data[_HEAD.size : _HEAD.size + length])
    return Kept(dict(_cut(data, _HEAD.size + length, head["files"])), dict(head["others"]), head["more"])


def _cut(data: bytes, start: int, sizes: list[tuple[str, int]]) -> Iterator[tuple[str, bytes]]:
    for path, size in sizes:
        yield path, data[start : start + size]
        start += size


def source(path: str, content: bytes) -> str:
    """Return the text of a submitted file to show or search, with plain newlines; for a notebook, the code of its cells."""
    text = content.decode("utf-8", "replace").removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    return cells(text) if path.lower().endswith(".ipynb") else text


def unshowable(content: bytes) -> str:
    """Return why the review desk does not show a picture: no PNG, or larger than a browser should open; "" if the desk shows it."""
    if not content.startswith(PNG) or content[12:16] != b"IHDR":
        return "it is not a PNG"
    width, height = (int.from_bytes(content[start : start + 4], "big") for start in (16, 20))
    if not (0 < width <= _WIDEST and 0 < height <= _WIDEST):
        return f"its header says {width} × {height} pixels"
    return ""
