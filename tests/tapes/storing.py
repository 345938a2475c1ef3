"""A file holds all tapes, and what the answers depend on, so that a stale tape is refused; the arrays lie in packs beside it.

Submissions of the corpus differ from each other in a few lines and draw from seeded generators, so nine arrays in ten are there
already, and most of what is recorded anew is what was recorded before. A pack never changes: what is new goes into one of its own,
so that a repository grows by little. All are LZMA over a JSON head and, in a pack, the arrays' bytes.
"""

from __future__ import annotations

import hashlib
import json
import lzma
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from grader.engine.lab_box import HARNESS
from grader.labs.imu.lab import LAB
from grader.sandbox.wire import Frame
from tests.scoreboard import Case, as_written
from tests.tapes import Played, StaleError, Tape

FILE = Path(__file__).parent / "corpus.tape"
_IN_THE_BOX = ("module level", "nothing")
"""Loading is what the first is about, as of what is recast, and demos take their time; the second has a test of its own."""
_LENGTH = 8
_PRESET = 6


def harness_sha256() -> str:
    """Of what runs in the box: another harness answers otherwise."""
    digest = hashlib.sha256()
    for folder in (HARNESS, LAB.folder / "box"):
        for source in sorted(folder.rglob("*.py")):
            digest.update(source.relative_to(folder).as_posix().encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()


def store(tapes: Mapping[str, Tape], file: Path = FILE) -> None:
    """Write all tapes, by case, and a pack of the arrays that none of the packs holds which stay."""
    arrays: dict[str, np.ndarray] = {}
    cases = {
        name: {key: _plain(played, arrays) for key, played in tape.answers.items()} for name, tape in tapes.items()
    }
    packs = {path: pack for path in _packs(file) if _of_use(pack := _unpacked(path), arrays)}
    fresh = {name: array for name, array in arrays.items() if all(name not in pack for pack in packs.values())}
    names = [path.name for path in packs] + ([_pack(fresh, file)] if fresh else [])
    rung = next(iter(tapes.values())).rung
    head = json.dumps({"harness": harness_sha256(), "rung": rung, "packs": names, "cases": cases}).encode()
    file.write_bytes(lzma.compress(head, preset=_PRESET))
    for path in _packs(file):
        if path.name not in names:
            path.unlink()


def _packs(file: Path) -> list[Path]:
    return sorted(file.parent.glob(f"{file.stem}-*.pack"))


def _of_use(pack: Mapping[str, np.ndarray], arrays: Mapping[str, np.ndarray]) -> bool:
    """Whether a pack stays: at least half of it is wanted."""
    return 2 * _size(pack[name] for name in pack if name in arrays) >= _size(pack.values())


def _size(arrays: Iterable[np.ndarray]) -> int:
    return sum(array.nbytes for array in arrays)


def _pack(arrays: Mapping[str, np.ndarray], file: Path) -> str:
    """Write a pack of these arrays; its name."""
    shapes = {name: [array.dtype.str, array.shape] for name, array in arrays.items()}
    head = json.dumps(shapes).encode()
    body = b"".join(np.ascontiguousarray(array).tobytes() for array in arrays.values())
    name = f"{file.stem}-{hashlib.sha256(head).hexdigest()[:12]}.pack"
    file.with_name(name).write_bytes(lzma.compress(len(head).to_bytes(_LENGTH, "little") + head + body, preset=_PRESET))
    return name


def _unpacked(path: Path) -> dict[str, np.ndarray]:
    data = lzma.decompress(path.read_bytes())
    end = _LENGTH + int.from_bytes(data[:_LENGTH], "little")
    return dict(_cut(json.loads(data[_LENGTH:end]), memoryview(data)[end:]))


def _plain(played: Played, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    if played.frame is None:
        return asdict(played)
    named = {name: _kept(array, arrays) for name, array in played.frame.arrays.items()}
    return {"cpu_s": round(played.cpu_s, 4), "fields": played.frame.fields, "arrays": named}


def _kept(array: np.ndarray, arrays: dict[str, np.ndarray]) -> str:
    digest = hashlib.sha256(f"{array.dtype.str}{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    name = digest.hexdigest()[:20]
    arrays.setdefault(name, array)
    return name


@cache
def taped() -> tuple[Case, ...]:
    """The cases that are judged from tapes."""
    return tuple(case for case in as_written() if case.part not in _IN_THE_BOX)


class Shelf:
    """All tapes of a file; each is made when it is asked for."""

    def __init__(self, file: Path = FILE) -> None:
        head = json.loads(lzma.decompress(file.read_bytes()))
        if head["harness"] != harness_sha256():
            raise StaleError("the harness has changed since the tapes were recorded; run python -m tests.tapes")
        self.rung: str = head["rung"]
        self._cases: dict[str, Any] = head["cases"]
        packs = (_unpacked(file.with_name(name)) for name in head["packs"])
        self._arrays = {name: array for pack in packs for name, array in pack.items()}

    def __getitem__(self, case: str) -> Tape:
        if case not in self._cases:
            raise StaleError(f"{case} has no tape; run python -m tests.tapes")
        return Tape(self.rung, {key: self._played(row) for key, row in self._cases[case].items()})

    def _played(self, row: Mapping[str, Any]) -> Played:
        if "failure" in row:
            kind, message, cpu_s, wall_s = row["failure"]
            return Played(row["cpu_s"], failure=(kind, message, cpu_s, wall_s), place=row["place"])
        arrays = {name: self._arrays[kept] for name, kept in row["arrays"].items()}
        return Played(row["cpu_s"], Frame(row["fields"], arrays))


def _cut(shapes: Mapping[str, Any], body: memoryview) -> Iterator[tuple[str, np.ndarray]]:
    start = 0
    for name, (kind, shape) in shapes.items():
        count = int(np.prod(shape, dtype=np.int64))
        array = np.frombuffer(body, dtype=kind, count=count, offset=start).reshape(shape)
        start += array.nbytes
        yield name, array


@cache
def shelf() -> Shelf:
    """The tapes of the repository."""
    return Shelf()
