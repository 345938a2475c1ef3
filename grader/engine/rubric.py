"""Rubric: criteria, checks and their points, extensions and limits, read from `rubric.yaml` and validated.

All problems of a file are reported together, each with its line. The file is read as YAML nodes, not as values: nodes have line
numbers, keep duplicate keys apart and build no objects.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import math
import os.path
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import datetime
from fractions import Fraction
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import yaml

from grader.base.errors import RequestError
from grader.base.package_data import beside
from grader.base.text import printable
from grader.engine.check_catalog import checks_of
from grader.engine.faults import catalogue, rows
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import LARGEST, MAX_BYTES, Reader, RubricError, guess_at, quote, refuse

__all__ = [
    "CARRIED",
    "CheckWeight",
    "Criterion",
    "Extension",
    "LatePolicy",
    "Limits",
    "OwnChecks",
    "RepairPolicy",
    "Rubric",
    "RubricError",
    "load",
    "match_checks",
    "own_checks",
    "parse",
    "shipped",
]

_OPTIONAL = ("extra_credit", "late", "mistakes", "repairs")
OwnChecks = tuple[tuple[str, bytes], ...]
"""Names and contents of the files in the folder ``checks`` beside a rubric. They are read once and run from this copy."""

CARRIED = "own_checks"
_MOST_OWN_BYTES = 1_000_000
_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
_FILE = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}\.py")


@dataclass(frozen=True)
class CheckWeight:
    """A check of a criterion or an extension. `id` is the full id (``filtering.passes_constant``), `line` its line in the file."""

    id: str
    weight: float
    max_points: float
    line: int


@dataclass(frozen=True)
class Criterion:
    """A part whose checks earn points."""

    id: str
    title: str
    points: float
    checks: tuple[CheckWeight, ...]
    line: int


@dataclass(frozen=True)
class Extension(Criterion):
    """An extension of the sheet, in a file of its own. With `points` 0 it is reported and earns nothing."""

    file: str


@dataclass(frozen=True)
class Limits:
    """CPU time in seconds for one call of the student's code, and for all calls of one submission."""

    call_cpu_s: float
    submission_cpu_s: float


@dataclass(frozen=True)
class LatePolicy:
    """Late policy. It changes the final grade, never the score.

    Attributes
    ----------
    due
        The due date, in UTC.
    grace_minutes
        A submission up to this late counts as on time; a later one is late from `due` on.
    per_day
        Points deducted for each day begun after `due`.
    cut_off_days
        A submission later than this many days is not accepted; None: each is accepted.
    extensions
        Other due dates for some submissions or people, by id, name or e-mail address.
    tz
        The time zone in which days are counted, for example "Europe/Berlin"; "" counts 24 hours as a day.
    """

    due: datetime
    grace_minutes: float
    per_day: float
    cut_off_days: float | None
    extensions: Mapping[str, datetime] = field(default_factory=dict)
    tz: str = ""


@dataclass(frozen=True)
class RepairPolicy:
    """Repair policy for files that do not run.

    Attributes
    ----------
    suggested
        Whether `grade` applies a suggested repair by itself; otherwise a person decides.
    deduct
        Points deducted for a repair that `grade` applies; the review desk proposes the same number.
    """

    suggested: bool = False
    deduct: float = 5.0


@dataclass(frozen=True)
class Rubric:
    """A valid rubric. `criteria` and `extensions` are in the sheet's order, not the file's.

    `settings` holds the values of the lab's own keys (`Lab.settings`). `extra_credit_cap` is the most points that all extensions
    together can earn in addition to the score; None if they earn nothing. `mistakes` holds the rubric's deductions by id of the
    mistake; they replace the share that a check loses. `sha256` is the digest of the content that marks depend on:
    comments, the order of the lines and the late policy do not change it. `asked_sha256` is the digest of the content that the
    questions depend on: recorded results can be marked again by a rubric with the same one. `own_checks` are the instructor's
    checks beside the file. `text` is the whole file, and relative paths in it start from `folder`.
    """

    lab: Lab
    criteria: tuple[Criterion, ...]
    extensions: tuple[Extension, ...]
    limits: Limits
    settings: Mapping[str, Any]
    sha256: str
    asked_sha256: str
    source: str
    extra_credit_cap: float | None
    late: LatePolicy | None
    mistakes: Mapping[str, float]
    own_checks: OwnChecks
    text: str = field(default="", repr=False)
    folder: Path | None = None
    repairs: RepairPolicy = RepairPolicy()

    @property
    def parts(self) -> tuple[Criterion, ...]:
        """The criteria, then the extensions."""
        return (*self.criteria, *self.extensions)

    @property
    def checks(self) -> tuple[CheckWeight, ...]:
        """The checks of the criteria, then those of the extensions."""
        return tuple(check for part in self.parts for check in part.checks)

    @property
    def max_score(self) -> float:
        return round(sum(criterion.points for criterion in self.criteria), 2)

    def check(self, check_id: str) -> CheckWeight:
        """Return the check with this id; raise KeyError if there is none."""
        return {check.id: check for check in self.checks}[check_id]


def shipped(lab: Lab) -> Path:
    """Return the path of the shipped rubric: in the lab's folder of a build, else at the top of the source tree."""
    built = lab.folder / "rubric.yaml"
    return built if built.is_file() else beside("grader", "").parent / "rubric.yaml"


def load(lab: Lab, path: Path | None = None) -> Rubric:
    """Read and validate a rubric.

    Parameters
    ----------
    lab
        The lab; the rubric must list its parts.
    path
        The file; None takes the shipped one.

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
    """Validate the bytes of a rubric.

    Parameters
    ----------
    lab
        The lab; the rubric must list its parts.
    data
        The file's bytes, UTF-8.
    source
        The file's name in messages.
    folder
        The folder that relative paths in it start from; None is the working folder.
    own
        The instructor's own checks; None reads them from `folder`.

    Raises
    ------
    RubricError
        If there are problems; the message names all of them.
    """
    reader = Reader(source)
    root = reader.compose(data)
    keys = reader.fields(root, "the rubric", ("criteria", "extensions", "limits"), (*lab.settings, *_OPTIONAL))
    criteria = _criteria(reader, keys.get("criteria"), [part.id for part in lab.parts])
    each, cap = _extra_credit(reader, keys.get("extra_credit"))
    extensions = _extensions(reader, keys.get("extensions"), [bonus.id for bonus in lab.bonuses], each)
    worth = round(sum(extension.points for extension in extensions), 2)
    limits = _limits(reader, keys.get("limits"))
    settings = {key: read(reader, keys.get(key), folder or Path()) for key, read in lab.settings.items()}
    late = _late(reader, keys.get("late"), sum(criterion.points for criterion in criteria))
    mistakes = _mistakes(reader, keys.get("mistakes"), lab)
    repairs = _repairs(reader, keys.get("repairs"))
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
    priced = [mistakes] if mistakes else []
    digest = _digest(criteria, extensions, limits, *settings.values(), granted, *priced, *written)
    asked = _digest(limits, *settings.values(), *written)
    text = data.decode("utf-8", "surrogateescape")
    return Rubric(
        lab, criteria, extensions, limits, settings, digest, asked, source, granted, late, mistakes, own, text, folder,
        repairs,
    )  # fmt: skip


def own_checks(lab: Lab, folder: Path) -> OwnChecks:
    """Read the instructor's own checks from the folder beside a rubric; in a kit they are in the lab's folder.

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
    """Refuse a criterion or extension that the rubric does not have.

    Raises
    ------
    RequestError
        The message suggests the nearest name, or lists the known ones.
    """
    known = [part.id for part in rubric.parts]
    if only is None or only in known:
        return
    near = difflib.get_close_matches(only, known, 1)
    guess = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
    raise RequestError(f"--only {printable(only)}: the rubric has no such criterion; {guess}")


def match_checks(rubric: Rubric, known: Mapping[str, str]) -> None:
    """Verify that the rubric lists the existing checks, no more and no fewer.

    Parameters
    ----------
    rubric
        A loaded rubric.
    known
        The existing checks: id and title.

    Raises
    ------
    RubricError
        One line for each check that only the rubric lists or that the rubric lacks.
    """
    problems = _unmatched(rubric.parts, known)
    if problems:
        refuse(rubric.source, problems)


def _unmatched(parts: Sequence[Criterion], known: Mapping[str, str]) -> list[tuple[int, str]]:
    """Return a problem, with its line, for each check that only the rubric lists or that the rubric lacks."""
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


def _criteria(reader: Reader, node: yaml.Node | None, ids: Sequence[str]) -> tuple[Criterion, ...]:
    """Return the criteria in the order of `ids`; report problems."""
    criteria = []
    for name, (item, keys) in reader.records(node, "criterion", ids, ("id", "title", "points", "checks"), ()).items():
        title = reader.text(keys.get("title"), f"the title of {name}")
        points = reader.points(keys.get("points"), f"the points of {name}")
        checks = _checks(reader, keys.get("checks"), name, points)
        criteria.append(Criterion(name, title, points or 0.0, checks, item.start_mark.line + 1))
    if node is not None and criteria and not reader.problems and not any(c.points for c in criteria):
        reader.say(node, "the criteria are worth 0 points together; give at least one of them points")
    return tuple(criteria)


def _extra_credit(reader: Reader, node: yaml.Node | None) -> tuple[float, float | None]:
    """Return the points of an extension that names none of its own, and the cap of all together (None: no cap)."""
    if node is None:
        return 0.0, None
    keys = reader.fields(node, "extra_credit", ("each",), ("cap",))
    each = reader.points(keys.get("each"), "each")
    return each or 0.0, reader.points(keys["cap"], "the cap of extra_credit") if "cap" in keys else None


def _extensions(reader: Reader, node: yaml.Node | None, ids: Sequence[str], each: float) -> tuple[Extension, ...]:
    """Return the extensions in the order of `ids`, each worth `each` points unless it names its own; report problems."""
    extensions = []
    for name, (item, keys) in reader.records(
        node, "extension", ids, ("id", "title", "file"), ("points", "checks")
    ).items():
        title = reader.text(keys.get("title"), f"the title of {name}")
        file = reader.text(keys.get("file"), f"the file of {name}", _FILE, "the name of a .py file")
        own = reader.points(keys["points"], f"the points of {name}") if "points" in keys else each
        points = own or 0.0
        checks = _extension_checks(reader, keys.get("checks"), name, points)
        if points and not checks:
            reader.say(item, f"{name} has points but no checks to earn them; set its points to 0")
        extensions.append(Extension(name, title, points, checks, item.start_mark.line + 1, file))
    return tuple(extensions)


def _extension_checks(reader: Reader, node: yaml.Node | None, part: str, points: float) -> tuple[CheckWeight, ...]:
    """Read the checks of an extension; it may have none: `checks: []`, `{}`, an empty value, or no such key."""
    nothing = node is None or not node.value or node.tag == "tag:yaml.org,2002:null"
    return () if nothing else _checks(reader, node, part, points)


def _checks(reader: Reader, node: yaml.Node | None, part: str, points: float | None) -> tuple[CheckWeight, ...]:
    """Return the checks of a criterion with their shares of its points; report problems."""
    if node is None:
        return ()
    if not isinstance(node, yaml.MappingNode) or not node.value:
        reader.say(node, f"the checks of {part} must be `name: weight` lines; list at least one")
        return ()
    ids, weights, lines = [], [], []
    before = len(reader.problems)
    for name, (key, value) in reader.pairs(node, f"the checks of {part}").items():
        if not _NAME.fullmatch(name):
            reader.say(key, f"{quote(key)} is not the name of a check; write only the part after `{part}.`")
        ids.append(f"{part}.{name}")
        weights.append(reader.number(value, f"the weight of {printable(name, 60)}") or 0.0)
        lines.append(key.start_mark.line + 1)
    if len(reader.problems) == before and not any(weights):
        reader.say(node, f"the weights of {part} sum to 0; give at least one check a weight")
    shares = _shares(points or 0.0, weights)
    return tuple(CheckWeight(*row) for row in zip(ids, weights, shares, lines, strict=True))


def _shares(points: float, weights: Sequence[float]) -> list[float]:
    """Divide points in proportion to the weights, in hundredths that sum to the points (largest remainder; ties: first)."""
    decimals = [Fraction(str(weight)) for weight in weights]
    total = sum(decimals)
    if not total:
        return [0.0] * len(weights)
    hundredths = round(points * 100)
    exact = [hundredths * weight / total for weight in decimals]
    parts = [math.floor(share) for share in exact]
    by_remainder = sorted(range(len(parts)), key=lambda i: parts[i] - exact[i])
    for i in by_remainder[: hundredths - sum(parts)]:
        parts[i] += 1
    return [part / 100 for part in parts]


def _limits(reader: Reader, node: yaml.Node | None) -> Limits:
    keys = reader.fields(node, "limits", ("call_cpu_s", "submission_cpu_s"))
    call = reader.number(keys.get("call_cpu_s"), "call_cpu_s", low=0.1)
    submission = reader.number(keys.get("submission_cpu_s"), "submission_cpu_s", low=0.1, high=100 * LARGEST)
    if call is not None and submission is not None and submission < call:
        reader.say(keys["submission_cpu_s"], "submission_cpu_s is less than call_cpu_s; make it at least as large")
    return Limits(call or 0.0, submission or 0.0)


def _late(reader: Reader, node: yaml.Node | None, of: float) -> LatePolicy | None:
    """Return the late policy; None if the rubric has none; report problems."""
    if node is None:
        return None
    optional = ("grace_minutes", "per_day", "cut_off_days", "extensions", "tz")
    keys = reader.fields(node, "late", ("due",), optional)
    zone = _zone(reader, keys.get("tz"))
    due = reader.stamp(keys.get("due"), "due", zone)
    grace = reader.number(keys.get("grace_minutes"), "grace_minutes", high=100 * LARGEST)
    cut_off = reader.number(keys.get("cut_off_days"), "cut_off_days")
    per_day = reader.share(keys.get("per_day"), "per_day", of)
    listed = keys.get("extensions")
    extensions: dict[str, datetime] = {}
    if isinstance(listed, yaml.MappingNode):
        for who, (_, value) in reader.pairs(listed, "extensions").items():
            until = reader.stamp(value, f"the extension of {printable(who, 60)}", zone)
            extensions |= {who: until} if until else {}
    elif listed is not None:
        reader.say(listed, "extensions must be `who: date` lines; who is an id, a name or an e-mail address")
    if due is None:
        return None
    return LatePolicy(due, grace or 0.0, per_day or 0.0, cut_off, extensions, str(zone or ""))


def _zone(reader: Reader, node: yaml.Node | None) -> ZoneInfo | None:
    """Return the time zone of a late policy; None without one or with an unknown name."""
    name = reader.text(node, "tz")
    if node is None or not name:
        return None
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        reader.say(node, f"there is no time zone {quote(node)}; name one like Europe/Berlin")
        return None


def _mistakes(reader: Reader, node: yaml.Node | None, lab: Lab) -> dict[str, float]:
    """Return the points that the rubric deducts for a mistake, by the mistake's id."""
    if node is None:
        return {}
    if not isinstance(node, yaml.MappingNode):
        reader.say(node, "mistakes must be `name: points` lines; `imugrade explain` lists the names")
        return {}
    known = catalogue(lab)
    deductions: dict[str, float] = {}
    for name, (key, value) in reader.pairs(node, "mistakes").items():
        if now := next((id_ for id_, row in rows(lab).items() if name in row.formerly), None):
            reader.say(key, f"the fault {quote(key)} is no longer told apart: {now} deducts for it")
        elif name not in known:
            reader.say(key, f"there is no fault {quote(key)}{guess_at(name, known)}; `imugrade explain` lists them")
        deductions[name] = reader.points(value, f"the deduction for {printable(name, 60)}") or 0.0
    return deductions


_APPLY = {"suggested": True, "none": False}


def _repairs(reader: Reader, node: yaml.Node | None) -> RepairPolicy:
    """Return the repair policy: whether suggested repairs are applied, and the deduction for a repair."""
    if node is None:
        return RepairPolicy()
    keys = reader.fields(node, "repairs", ("apply", "deduct"), ())
    apply = reader.text(keys.get("apply"), "apply")
    if "apply" in keys and apply not in _APPLY:
        reader.say(keys["apply"], f"apply must be suggested or none, not {quote(keys['apply'])}")
    deduct = reader.points(keys.get("deduct"), "deduct")
    return RepairPolicy(_APPLY.get(apply, False), deduct or 0.0)


def _digest(*meaning: object) -> str:
    """Return the SHA-256 of these values as JSON; line numbers are left out."""
    plain = [_without_lines(part) for part in meaning]
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def _without_lines(value: object) -> object:
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _without_lines(getattr(value, f.name)) for f in fields(value) if f.compare and f.name != "line"}
    if isinstance(value, tuple):
        return [_without_lines(item) for item in value]
    return value.name if isinstance(value, Path) else value
