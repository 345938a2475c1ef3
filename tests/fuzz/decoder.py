"""The decoder of the wire under a coverage-guided fuzzer: ``python -m tests.fuzz.decoder [--seconds 300]`` (needs `atheris`).

Ends with the fuzzer's own report where a frame brings the decoder to anything but a frame or a `WireError`, or to memory
beyond the caps: 256 MB in all, for frames of at most 4 KB.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from grader.sandbox import arrays, wire

NONCE = bytes(range(16))
FRAME = wire.pack(
    NONCE,
    {"fields": {"names": ["a", "é"], "deep": [[1, 2.5, None, True]], "error": None}},
    {"a": np.arange(6.0).reshape(2, 3), "b": np.array([True]), "c": np.zeros((0, 3), np.int32)},
)
_MEMORY_MB = 256


def decoded(data: bytes) -> wire.Frame | None:
    """What a reader of the line makes of these bytes; None where they end too soon."""
    incoming, rest = wire.Incoming(), memoryview(data)
    while incoming.wanted:
        chunk = bytes(rest[: min(incoming.wanted, 7 + len(data) // 3)])
        if not chunk:
            return None
        incoming.feed(chunk)
        rest = rest[len(chunk) :]
    return incoming.finish()[1]


def check_decoder(data: bytes) -> None:
    """Anything but a frame that can be said again, or a WireError, raises."""
    try:
        frame = decoded(data)
    except wire.WireError:
        return
    if frame is not None:
        assert decoded(wire.pack(NONCE, frame.fields, frame.arrays)) is not None


def framed(data: bytes) -> bytes:
    """The bytes as text and arrays behind a header that fits them: a fuzzer seldom finds lengths that agree."""
    text, _, body = data.partition(b"\0\0\0\0")
    return wire.HEADER.pack(len(text), len(body), NONCE) + text + body


def _one(data: bytes) -> None:
    check_decoder(data[1:] if data[:1] < b"\x40" else framed(data[1:]))


def _words(path: Path) -> Path:
    """What a mutation may put in: the names and signs of a frame."""
    words = ["fields", "arrays", *arrays.DTYPES, "null", "true", "NaN", "1e400", "-0", "[[", "]]", "{}", ",", ":", "\\\\ud800", "2147483647"]
    path.write_text("".join(f'"{word}"\n' for word in words), encoding="utf-8")
    return path


def _seeds(folder: Path) -> Path:
    text = FRAME[wire.HEADER.size :].partition(b"\0")[0]
    body = FRAME[wire.HEADER.size + len(text) :]
    for number, seed in enumerate((b"\0" + FRAME, b"A" + text + b"\0\0\0\0" + body, b"A" + text)):
        (folder / f"seed{number}").write_bytes(seed)
    return folder


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.decoder", description=__doc__)
    parser.add_argument("--seconds", type=int, default=300)
    options = parser.parse_args()
    try:
        import atheris
    except ImportError:
        sys.exit("this needs the fuzzer: pip install atheris")
    for function in (wire.unpack, wire.pack, *vars(wire.Incoming).values(), *vars(wire).values()):
        if getattr(function, "__module__", "") == wire.__name__ and hasattr(function, "__code__"):
            atheris.instrument_func(function)
    scratch = Path(tempfile.mkdtemp(prefix="imugrade-fuzz-"))
    folder = _seeds(scratch)
    words = _words(scratch.with_name(f"{scratch.name}.dict"))
    limits = [f"-max_total_time={options.seconds}", f"-rss_limit_mb={_MEMORY_MB}", "-max_len=4096", "-timeout=5", f"-dict={words}"]
    atheris.Setup([sys.argv[0], *limits, "-print_final_stats=1", str(folder)], _one)
    atheris.Fuzz()  # ends the process


if __name__ == "__main__":
    main()
