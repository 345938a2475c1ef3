"""Code fingerprint: hashes that find similar code in a class, whatever its names, layout and comments.

References
----------
Schleimer, S., Wilkerson, D. S., Aiken, A. (2003). Winnowing: local algorithms for document fingerprinting. SIGMOD, 76-85.
"""

from __future__ import annotations

import functools
import json
import keyword
import re
import zlib
from collections.abc import Iterator, Mapping, Set

import numpy as np

from grader.engine.lab import Lab

GRAM, WINDOW = 20, 12
"""Lengths in tokens. A run of GRAM + WINDOW - 1 = 31 equal tokens (about three lines) always yields a common hash, a run of
fewer than GRAM = 20 never."""
_MOST_BYTES = 400_000
_TOKEN = re.compile(
    r"#[^\n]*|[rRbBfFuU]{0,2}(?:\"\"\".*?(?:\"\"\"|\Z)|'''.*?(?:'''|\Z)|\"(?:\\.|[^\"\\\n])*\"?|'(?:\\.|[^'\\\n])*'?)"
    r"|\.?\w+|[^\w\s]",
    re.DOTALL,
)
"""An unterminated string matches too; otherwise each quotation mark in it would be tried as the start of another string."""


def fingerprint(files: Mapping[str, bytes]) -> tuple[int, ...]:
    """Return sorted hashes of sequences of tokens in a submission's code (path -> content); similar submissions share many."""
    found: set[int] = set()
    for source in _sources(files):
        found |= _winnowed(source)
    return tuple(sorted(found))


@functools.cache
def of_the_sheet(lab: Lab) -> frozenset[int]:
    """Return the hashes of the code in the lab sheet and the starter files, so that a comparison of submissions ignores them."""
    given = [lab.folder / "sheet.txt", *sorted((lab.folder / "starter").glob("*.py.txt"))]
    return frozenset(fingerprint({f"{path.name}.py": path.read_bytes() for path in given}))


def _sources(files: Mapping[str, bytes]) -> Iterator[str]:
    """Yield the source text of programs and notebooks. A file that would exceed 400 kB in all is left out, to bound the time."""
    left = _MOST_BYTES
    for path in sorted(files):
        content = files[path]
        if path.endswith((".py", ".ipynb")) and len(content) <= left:
            left -= len(content)
            text = content.decode("utf-8", "replace")
            yield cells(text) if path.endswith(".ipynb") else text


def cells(text: str) -> str:
    """Return the source of a notebook's code cells, one after the other; "" if the text is no notebook."""
    try:
        sources = [cell["source"] for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
        return "\n".join("".join(source) for source in sources)
    except (ValueError, KeyError, TypeError, RecursionError):
        return ""  # not a notebook


def _winnowed(source: str) -> set[int]:
    """Return few hashes of a text: the smallest of each window of WINDOW grams (GRAM tokens in a row); none for fewer tokens."""
    hashes = _hashes([_normalized(token) for token in _TOKEN.findall(source) if not token.startswith("#")])
    if not len(hashes):
        return set()
    width = min(WINDOW, len(hashes))
    return set(np.lib.stride_tricks.sliding_window_view(hashes, width).min(axis=1).tolist())


def lines_with(source: str, wanted: Set[int]) -> set[int]:
    """Return the numbers, from 1, of the lines that runs of `GRAM` tokens with a hash in `wanted` span, to mark similar code."""
    tokens = [found for found in _TOKEN.finditer(source) if not found[0].startswith("#")]
    hashes = _hashes([_normalized(found[0]) for found in tokens])
    starts = np.cumsum([0, *(len(line) + 1 for line in source.split("\n"))])
    first = np.searchsorted(starts, [found.start() for found in tokens], "right")
    last = np.searchsorted(starts, [found.end() - 1 for found in tokens], "right")
    places = [k for k, value in enumerate(hashes.tolist()) if value in wanted]
    return {line for k in places for line in range(int(first[k]), int(last[k + GRAM - 1]) + 1)}


def _hashes(tokens: list[str]) -> np.ndarray[tuple[int], np.dtype[np.uint64]]:
    """Return the hash of each gram (run of GRAM neighbouring tokens), in order; none if there are fewer tokens."""
    if len(tokens) < GRAM:
        return np.empty(0, dtype=np.uint64)
    codes = np.array([zlib.crc32(token.encode("utf-8", "replace")) for token in tokens], dtype=np.uint64)
    powers = np.array([pow(6364136223846793005, k, 2**64) for k in range(GRAM)], dtype=np.uint64)
    hashes: np.ndarray[tuple[int], np.dtype[np.uint64]]
    hashes = np.lib.stride_tricks.sliding_window_view(codes, GRAM) @ powers >> np.uint64(32)
    return hashes


def _normalized(token: str) -> str:
    """Return a token with all names and all strings made equal, so that renaming hides nothing; other tokens are unchanged."""
    if '"' in token or "'" in token:
        return "'"
    return "n" if token.isidentifier() and not keyword.iskeyword(token) else token
