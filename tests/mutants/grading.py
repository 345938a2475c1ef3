"""Handing mutants in: which files there are to mutate, what each is graded for, and which may survive."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml

import reference
from grader.engine.grader import Marker
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.mutants.operators import Mutant, mutants
from tests.sandboxes import opened

REFERENCE = Path(reference.__file__).parent
SHEET = LAB.files
EXTENSIONS = {part.home: part.id for part in LAB.bonuses}
FILES = (*SHEET, *EXTENSIONS)


@dataclass(frozen=True)
class Reasons:
    """Why mutants survive: patterns of keys, `*` standing for anything, and the functions that no check asks about."""

    patterns: frozenset[str]
    unjudged: dict[str, dict[str, str]]

    def of(self, mutant: Mutant) -> set[str]:
        """The patterns that explain a survivor."""
        return {pattern for pattern in self.patterns if _compiled(pattern).fullmatch(mutant.key)}


@cache  # thousands of mutants are held against a thousand patterns
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(".*".join(map(re.escape, pattern.split("*"))))


@cache
def reasons() -> Reasons:
    """What the file of reasons says."""
    said = yaml.safe_load(Path(__file__).with_name("equivalent.yaml").read_text(encoding="utf-8"))
    return Reasons(frozenset(key for group in said["equivalent"] for key in group["mutants"]), said["unjudged"])


def all_mutants(files: Sequence[str] = SHEET) -> list[Mutant]:
    """The mutants of these files of the reference, in the order of the code."""
    unjudged = reasons().unjudged
    return [
        m for file in files for m in mutants(file, (REFERENCE / file).read_text(), frozenset(unjudged.get(file, ())))
    ]


@cache
def _marker() -> Marker:
    return opened(bundles.shipped()).__enter__()


def lost(mutant: Mutant) -> tuple[str, ...]:
    """The checks that a mutant loses, beside the other files as they are; a check that is not judged is none."""
    files = {file: (REFERENCE / file).read_bytes() for file in SHEET}
    files[mutant.file] = mutant.source.encode()
    submission = Submission("mutant", "mutant", files, (), "ready", "")
    result = _marker().mark(submission, only=EXTENSIONS.get(mutant.file))
    checks = [check for part in (*result.criteria, *result.extensions) for check in part.checks]
    return tuple(check.id for check in checks if check.outcome not in ("passed", "not_judged"))


def grade_all(chosen: Sequence[Mutant], jobs: int) -> Iterator[tuple[Mutant, tuple[str, ...]]]:
    """Each mutant with the checks that it loses."""
    with ProcessPoolExecutor(jobs) as pool:
        yield from zip(chosen, pool.map(lost, chosen), strict=True)
