"""Find which figure each picture file holds when the code has run, whichever call wrote the file.

A file with the bytes that saving a figure wrote holds that figure. Any other picture, such as one that Pillow or `imsave` made from
the canvas or a buffer, is compared with the figures: it holds the most similar one.
"""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .drawing import Preview

PICTURES = (".png", ".jpg", ".jpeg", ".svg", ".pdf", ".webp", ".tif", ".tiff", ".gif")
_MOST_FILES = 200
_MOST_READ = 24  # most picture files that are read
_LARGEST = 8_000_000  # bytes of the largest file that is read
_GRID = (60, 48)  # cells in which two pictures are compared
_MIN_CORRELATION = 0.7
"""Smallest correlation of a picture with the figure that it shows, cell by cell. Each of thirty random figures has at least 0.82
with its own full canvas and at most 0.55 with the canvas of another."""


@dataclass
class RecordedFigure:
    """A figure as it was saved or shown: its description, small picture, and the bytes and path of the file if saving wrote one."""

    facts: dict[str, Any]
    seen: Preview | None
    written: bytes | None = None
    place: str | None = None


def written_pictures(folder: str) -> list[str]:
    """Return the picture files that a submission wrote below the scratch folder, as relative paths; no links, no empty files."""
    found = []
    for above, _, names in os.walk(folder):
        for path in (Path(above, name) for name in names if os.path.splitext(name)[1].lower() in PICTURES):
            if path.is_file() and not path.is_symlink() and path.stat().st_size:
                found.append(path.relative_to(folder))
    return [path.as_posix()[:300] for path in sorted(found)[:_MOST_FILES]]


def content_of(target: Any) -> tuple[bytes | None, str | None]:
    """Return what `savefig` wrote to a file or buffer: its bytes (None if unreadable), and its path (None for a buffer)."""
    if isinstance(target, str | os.PathLike):
        place = os.path.abspath(os.fspath(target))
        return _read(place if os.path.exists(place) else f"{place}.png"), place
    try:
        return bytes(target.getvalue())[:_LARGEST], None
    except Exception:  # a file that is still open, or whatever the student wrote
        return None, None


def match_files_to_figures(drawn: list[RecordedFigure], folder: str, known: dict[str, bytes | None]) -> None:
    """Correct the ``event`` of each recorded figure by the picture files that `folder` holds now, after the code has run.

    A figure that a picture file shows is "saved", whichever call wrote the file. One whose file now holds another picture is
    "overwritten"; one saved to a buffer that reached no file is "forgotten".

    Parameters
    ----------
    drawn : the figures, in the order of their recording
    known : the picture files below `folder` that were there before, with their content; updated to the present ones
    """
    files = {name: _read(os.path.join(folder, name)) for name in written_pictures(folder)[:_MOST_READ]}
    held = {content for content in files.values() if content is not None}
    written = {one.written for one in drawn if one.written is not None}
    others = [
        (name, content) for name, content in files.items() if content not in written and known.get(name) != content
    ]
    for number, one in enumerate(drawn):
        if one.facts["event"] == "saved" and one.written is not None:
            again = one.place is not None and any(later.place == one.place for later in drawn[number + 1 :])
            if again or (one.written not in held and (one.place is None or _read(one.place) != one.written)):
                one.facts["event"] = "overwritten" if one.place else "forgotten"
    for name, content in others:
        _match_picture(name, content, drawn)
    known.clear()
    known.update(files)


def _read(path: str) -> bytes | None:
    try:
        return Path(path).read_bytes() if os.path.getsize(path) <= _LARGEST else None
    except OSError:
        return None


def _match_picture(name: str, content: bytes | None, drawn: list[RecordedFigure]) -> None:
    """Find the figure that a picture file shows, by likeness, and record the figure as saved there; do nothing if none is alike."""
    from PIL import Image

    if name.lower().endswith((".svg", ".pdf")) or content is None:
        return
    try:
        with Image.open(io.BytesIO(content)) as picture:
            size = [int(n) for n in picture.size]
            cells = _cells(picture)
    except Exception:  # any broken file, any codec
        return
    likeness = [(_correlation(cells, one.seen), number) for number, one in enumerate(drawn) if one.seen is not None]
    best, number = max(likeness, default=(0.0, -1))
    if best >= _MIN_CORRELATION:
        drawn[number].facts.update(event="saved", path=name, size_px=size, format=name.rpartition(".")[2].lower()[:10])


def _cells(picture: Any) -> np.ndarray:
    """Return the colours of a picture on white, averaged over a coarse grid, so that pictures of any size can be compared."""
    from PIL import Image

    small = picture.convert("RGBA").resize(_GRID, Image.Resampling.BOX)
    flat = Image.alpha_composite(Image.new("RGBA", small.size, "white"), small).convert("RGB")
    return np.asarray(flat, dtype=float)


def _correlation(cells: np.ndarray, seen: Preview) -> float:
    """Return how alike a picture, as `cells`, and a figure's small picture are: the correlation of their grids, at most 1."""
    from PIL import Image

    its = _cells(Image.fromarray(seen.pixels))
    a, b = (np.abs(each - np.median(each, axis=(0, 1))).ravel() for each in (cells, its))
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b / max(np.sqrt((a @ a) * (b @ b)), 1e-9))
