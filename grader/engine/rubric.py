"""Rubric: criteria, checks and their points, extensions and limits, read from `rubric.yaml` and validated.

All problems of a file are reported together, each with its line. The file is read as YAML nodes, not as values: nodes have line
numbers, keep duplicate keys apart and build no objects.
"""

from __future__ import annotations

import hashlib
import json
import os.path
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path

from grader.base.errors import RequestError
from grader.base.package_data import beside
from grader.base.text import printable
from grader.engine import rubric_sections as sections
from grader.engine.check_catalog import checks_of
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import MAX_BYTES, NodeReader, RubricError, did_you_mean, guess_at, refuse
from grader.engine.rubric_records import CheckWeight, Criterion, Extension, LatePolicy, Limits, OwnChecks, Rubric

__all__ = [
    "CARRIED", "CheckWeight", "Criterion", "Extension", "LatePolicy", "Limits", "OwnChecks", "Rubric", "RubricError",
    "load", "match_checks", "own_checks", "parse", "shipped",
]  # fmt: skip

_OPTIONAL = ("extra_credit", "late", "faults", "repairs")
CARRIED = "own_checks"
_MOST_OWN_BYTES = 1_000_000


def shipped(lab: Lab) -> Path:
    """Return the path of the shipped rubric: in the lab's folder of an installed package, else at the top of the source tree."""
    built = lab.folder / "rubric.yaml"
    return built if built.is_file() else beside("grader", "").parent / "rubric.yaml"


def load(lab: Lab, path: Path | None = None) -> Rubric:
    """Read and validate the rubric of a lab from a file; None takes the shipped one.

    Raises
    ------
    RubricError
        If it cannot be read or has problems; the message names all of them.
    """
    source = "rubric.yaml" if path is None else printable(str(path), 500)
    file = shipped(lab) if path is None else path
    if not os.path.isfile(file):  # False for any invalid path; opening a named pipe would block
        raise RubricError(f"{source}: there is no such file; give the path of a rubric.yaml")
    try:
        with open(file, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise RubricError(f"{source}: cannot be read ({error.strerror}); check its permissions") from error
    return parse(lab, data, source=source, folder=file.parent)


def parse(
    lab: Lab, data: bytes, *, source: str = "rubric.yaml", folder: Path | None = None, own: OwnChecks | None = None
) -> Rubric:
    """Return the rubric of a lab that the bytes of a file hold, after validating it.

    Parameters
    ----------
    source : name of the file in messages
    folder : the folder that relative paths in the file start from; None is the working folder
    own : the instructor's own checks; None reads them from `folder`, if there is one

    Raises
    ------
    RubricError
        If there are problems; the message names all of them.
    """
    reader = NodeReader(source)
    root = reader.compose(data)
    keys = reader.fields(root, "the rubric", ("criteria", "extensions", "limits"), (*lab.settings, *_OPTIONAL))
    criteria = sections.read_criteria(reader, keys.get("criteria"), [part.id for part in lab.parts])
    each, cap = sections.read_extra_credit(reader, keys.get("extra_credit"))
    extensions = sections.read_extensions(reader, keys.get("extensions"), [bonus.id for bonus in lab.bonuses], each)
    worth = round(sum(extension.points for extension in extensions), 2)
    limits = sections.read_limits(reader, keys.get("limits"))
    settings = {key: read(reader, keys.get(key), folder or Path()) for key, read in lab.settings.items()}
    late = sections.read_late(reader, keys.get("late"), sum(criterion.points for criterion in criteria))
    faults = sections.read_faults(reader, keys.get("faults"), lab)
    repairs = sections.read_repairs(reader, keys.get("repairs"))
    if own is None:
        own = () if folder is None else own_checks(lab, folder)
    if reader.problems and not own:  # report the problems that `match_checks` would find with them
        whole = [part for part in (*criteria, *extensions) if part.checks]
        named = {part.id for part in whole}
        known = {check.id: check.title for check in checks_of(lab).values() if check.criterion in named}
        reader.problems += _unmatched(whole, known)
    reader.stop_on_problems()
    granted = (worth if cap is None else cap) if worth else None
    written = [hashlib.sha256(repr(own).encode()).hexdigest()] if own else []  # none: no effect on the digest
    priced = [faults] if faults else []
    digest = _digest(criteria, extensions, limits, *settings.values(), granted, *priced, *written)
    asked = _digest(limits, *settings.values(), *written)
    text = data.decode("utf-8", "surrogateescape")
    return Rubric(
        lab, criteria, extensions, limits, settings, digest, asked, source, granted, late, faults, own, text, folder,
        repairs,
    )  # fmt: skip


def own_checks(lab: Lab, folder: Path) -> OwnChecks:
    """Return name and content of each file with the instructor's own checks; () if there are none.

    `folder` holds the rubric, and the files lie in its subfolder ``checks``. If `folder` is the lab's own, as in the wheel that
    students install, they lie in ``own_checks``.

    Raises
    ------
    RubricError
        If they are too large or cannot be read.
    """
    place = folder / (CARRIED if folder == lab.folder else "checks")
    try:
        own = tuple((path.name, path.read_bytes()) for path in sorted(place.glob("*.py")) if path.is_file())
    except OSError as error:
        raise RubricError(f"{printable(str(place), 500)}: cannot be read ({error.strerror})") from error
    if sum(len(content) for _, content in own) > _MOST_OWN_BYTES:
        raise RubricError(f"{printable(str(place), 500)}: more than {_MOST_OWN_BYTES:,} bytes of checks")
    return own


def know_part(rubric: Rubric, only: str | None) -> None:
    """Refuse the value of `--only` if it is no criterion or extension of the rubric; None (all of them) is accepted.

    Raises
    ------
    RequestError
        The message suggests the nearest name, or lists the known ones.
    """
    known = [part.id for part in rubric.parts]
    if only is None or only in known:
        return
    guess = did_you_mean(only, known, f"there are {', '.join(known)}")
    raise RequestError(f"--only {printable(only)}: the rubric has no such criterion; {guess}")


def match_checks(rubric: Rubric, known: Mapping[str, str]) -> None:
    """Verify that the rubric lists the existing checks (`known`: id and title), no more and no fewer.

    Raises
    ------
    RubricError
        One line for each check that only the rubric lists or that the rubric lacks.
    """
    problems = _unmatched(rubric.parts, known)
    if problems:
        refuse(rubric.source, problems)


def _unmatched(parts: Sequence[Criterion], known: Mapping[str, str]) -> list[tuple[int, str]]:
    """Return (line, problem) for each check that `parts` list but that is not in `known`, and for each that they lack."""
    listed = {check.id: check for part in parts for check in part.checks}
    problems = [
        (check.line, f"there is no check {id_}{guess_at(id_, known)}; correct the name or remove the line")
        for id_, check in listed.items()
        if id_ not in known
    ]
    lines = {part.id: part.line for part in parts}
    for check_id in sorted(known.keys() - listed.keys()):
        part, _, name = check_id.partition(".")
        what = f"the check {check_id} ({printable(known[check_id], 100)}) has no weight under {part}"
        problems.append((lines.get(part, 1), f"{what}; add the line `{name}: WEIGHT` to its checks"))
    return problems


def _digest(*meaning: object) -> str:
    """Return the SHA-256 of these values as JSON, without line numbers, so that a rubric's layout does not change it."""
    plain = [_without_lines(part) for part in meaning]
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def _without_lines(value: object) -> object:
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _without_lines(getattr(value, f.name)) for f in fields(value) if f.compare and f.name != "line"}
    if isinstance(value, tuple):
        return [_without_lines(item) for item in value]
    return value.name if isinstance(value, Path) else value
