"""What a kilobyte may cost: ``python -m tests.fuzz.costs [--rounds 300] [--seed 0]`` looks for the worst that each reader can be given.

For each reader of a stranger's bytes, inputs are put together of the pieces that it looks for, and the dearest are changed
further, for time and for memory. The worst is then given twice as long: what takes more than in proportion is a finding (exit code
1). Time is CPU time; memory is what Python and NumPy hold at a time beyond the input.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import sys
import time
import tracemalloc
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from grader.base.errors import Malformed
from grader.base.text import printable
from grader.engine import fingerprint
from grader.intake.archives import gather_archive
from grader.intake.file_budget import Unreadable
from grader.labs.imu.lab import LAB
from grader.labs.imu.visualization import labels
from grader.sandbox import wire
from grader.worker import notebooks
from tests.corpus.pieces import tidy
from tests.corpus.writing import notebook, tarred, zipped
from tests.fuzz.decoder import NONCE, decoded

LENGTH = 40_000
_IN_PROPORTION = 3.0  # twice the input takes twice the time; half as much again is for the clock
_LEAST_S = 0.02  # below it the clock tells nothing


def _fingerprint(data: bytes) -> None:
    fingerprint.fingerprint({"filters.py": data})


def _labels(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    for read in (labels.unit_of, labels.claims, labels.axis_of, labels.has_time_unit, labels.in_milliseconds, labels.counts_samples, labels.says_raw, labels.says_smooth):  # fmt: skip
        read(text)


def _notebook(data: bytes) -> None:
    with suppress(ValueError, RecursionError):
        notebooks.code_cells(json.dumps({"cells": [{"cell_type": "code", "source": data.decode("utf-8", "replace")}]}).encode())


def _notebook_bytes(data: bytes) -> None:
    with suppress(ValueError, RecursionError):
        notebooks.code_cells(data)


def _frame(data: bytes) -> None:
    with suppress(wire.WireError):
        decoded(wire.HEADER.pack(len(data), 0, NONCE) + data)


def _reply(data: bytes) -> None:
    text = b'{"fields":{"error":null,"changed":[],"value":' + data + b'},"arrays":[]}'
    with suppress(wire.WireError, Malformed):
        frame = decoded(wire.HEADER.pack(len(text), 0, NONCE) + text)
        if frame is not None:
            LAB.checked("simulate", wire.Frame(frame.fields["fields"], frame.arrays), {}, {})


def _archive(data: bytes) -> None:
    with suppress(Unreadable):
        gather_archive(io.BytesIO(data), "hand-in")


def _attempted(data: bytes) -> None:
    for part in (*LAB.parts, *LAB.bonuses):
        part.attempted_in({"x.py": data})


def _printable(data: bytes) -> None:
    printable(data.decode("utf-8", "replace"), 10 * LENGTH, newlines=True)


_CODE = [b'"', b"'", b'\\"', b'"""', b"'''", b"\\", b"#", b"\n", b"f\"{", b"rb", b"(", b")", b" ", b"def ", b"class ", b"x", b"0x", b"1.", b"..", b"=", b"\t", b"@", b"lambda", b"\xc3\xa9", b"%%writefile ", b"if x:\n  "]  # fmt: skip
_TEXT = [b"m/s", b"meter", b"sec", b"rad", b"deg", b"per ", b"(", b")", b"[", b"\\frac{", b"}", b"^", b"2", b"\xc2\xb2", b"\xc2\xb0", b" ", b"a", b"in ", b"acc", b"gyro", b"x", b"-", b"$", b"_", b"metros por segundo", "метр".encode(), "加速度".encode(), b"raw ", b"filtered "]  # fmt: skip
_JSON = [b"[", b"]", b"{", b"}", b'"a":', b'"kind":"list",', b'"items":[', b'"key":"a0",', b"1", b"-", b"1e9", b",", b'"x"', b"null", b"true", b'"\\ud800"', b"\\u0000", b" "]  # fmt: skip
_CELLS = [b"%time ", b"%%bash\n", b"!ls ", b"\\\n", b"\n", b"x = (", b")", b"?", b"    ", b"%", b"await x", b'"""', b"if x:", b"z = !ls", b"%run a.py"]
_ARCHIVES = [zipped(tidy()), tarred(tidy(), "tar"), tarred(tidy(), "tar.gz"), b"PK\1\2", b"PK\3\4", b"PK\5\6" + bytes(18), bytes(512), b"\xff" * 8, b"\x1f\x8b\x08\0\0\0\0\0\0\3", b"L" * 100]  # fmt: skip


@dataclass(frozen=True)
class Reader:
    """What reads bytes, of what its inputs are made, and where it runs."""

    name: str
    read: Callable[[bytes], None]
    pieces: Sequence[bytes]
    where: str = "grader"


READERS = (
    Reader("archive", _archive, _ARCHIVES, "a process of its own"),
    Reader("code: its fingerprint", _fingerprint, _CODE),
    Reader("code: which parts are attempted", _attempted, _CODE),
    Reader("label of a plot", _labels, _TEXT),
    Reader("answer of the sandbox: its text", _frame, _JSON),
    Reader("answer of the sandbox: its rules", _reply, _JSON),
    Reader("text that is shown", _printable, _TEXT),
    Reader("notebook: its JSON", _notebook_bytes, [*_JSON, notebook("x = 1").encode()], "box"),
    Reader("notebook: its magics", _notebook, _CELLS, "box"),
)


def _made(chance: random.Random, pieces: Sequence[bytes]) -> list[bytes]:
    """A pattern that is repeated: that is what makes a reader look again."""
    return [chance.choice(pieces) for _ in range(chance.choice((1, 1, 2, 3, 5)))]


def _changed(pattern: list[bytes], chance: random.Random, pieces: Sequence[bytes]) -> list[bytes]:
    at = chance.randrange(len(pattern) + 1)
    return [*pattern[:at], chance.choice(pieces), *pattern[at + chance.choice((0, 1)) :]][:8]


def _input(pattern: Sequence[bytes], length: int) -> bytes:
    """The first piece once, as what opens often has an effect once, and then all of them again and again."""
    body = b"".join(pattern) or b"x"
    return (pattern[0] + body * (length // len(body) + 1))[:length] if pattern else body


def cpu_s(read: Callable[[bytes], None], data: bytes) -> float:
    before = time.process_time()
    read(data)
    return time.process_time() - before


def memory_bytes(read: Callable[[bytes], None], data: bytes) -> int:
    tracemalloc.start()
    try:
        read(data)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@dataclass(frozen=True)
class Worst:
    """Of one reader: CPU time and memory of a kilobyte, how time grows from once to twice the length, and the pattern."""

    ms: float
    kb: float
    growth: float
    pattern: bytes


def worst(reader: Reader, rounds: int, seed: int) -> Worst:
    chance = random.Random(f"{reader.name} {seed}")
    best, most = [b"x"], 0.0
    for number in range(rounds):
        pattern = _made(chance, reader.pieces) if number % 3 == 0 else _changed(best, chance, reader.pieces)
        took = cpu_s(reader.read, _input(pattern, LENGTH))
        if took > most:
            best, most = pattern, took
    once, twice = (min(cpu_s(reader.read, _input(best, n)) for _ in range(3)) for n in (LENGTH, 2 * LENGTH))
    held = max(memory_bytes(reader.read, _input(pattern, LENGTH)) for pattern in (best, [reader.pieces[0]], list(reader.pieces)[:8]))
    return Worst(once / LENGTH * 1e6, held / LENGTH, twice / max(once, 1e-9) if twice > _LEAST_S else 0.0, b"".join(best)[:40])


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.costs", description=__doc__)
    parser.add_argument("--rounds", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    print("| Reader | Runs in | CPU time for a kB | memory for a kB | twice as much takes | worst found |\n| --- | --- | ---: | ---: | ---: | --- |")
    bad = 0
    for reader in READERS:
        found = worst(reader, options.rounds, options.seed)
        bad += found.growth > _IN_PROPORTION
        growth = f"{found.growth:.1f} times" if found.growth else "too little to tell"
        print(f"| {reader.name} | {reader.where} | {found.ms:.3f} ms | {found.kb:.1f} kB | {growth} | `{found.pattern!r}` |", flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
