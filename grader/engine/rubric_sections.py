"""Read each section of a rubric into its records; a `NodeReader` collects the problems with their lines."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from datetime import datetime
from fractions import Fraction
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import yaml

from grader.base.text import printable
from grader.engine.faults import catalogue, rows
from grader.engine.lab import Lab
from grader.engine.rubric_nodes import LARGEST, NodeReader, guess_at, quote
from grader.engine.rubric_records import CheckWeight, Criterion, Extension, LatePolicy, Limits, RepairPolicy

_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
_FILE = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}\.py")


def read_criteria(reader: NodeReader, node: yaml.Node | None, ids: Sequence[str]) -> tuple[Criterion, ...]:
    """Return the criteria in the section `node`, in the order of `ids`; `reader` collects problems, such as 0 points in all."""
    criteria = []
    for name, (item, keys) in reader.records(node, "criterion", ids, ("id", "title", "points", "checks"), ()).items():
        title = reader.text(keys.get("title"), f"the title of {name}")
        points = reader.points(keys.get("points"), f"the points of {name}")
        checks = _checks(reader, keys.get("checks"), name, points)
        criteria.append(Criterion(name, title, points or 0.0, checks, item.start_mark.line + 1))
    if node is not None and criteria and not reader.problems and not any(c.points for c in criteria):
        reader.say(node, "the criteria are worth 0 points together; give at least one of them points")
    return tuple(criteria)


def read_extra_credit(reader: NodeReader, node: yaml.Node | None) -> tuple[float, float | None]:
    """Return the points of an extension without `points` of its own, and the most that all extensions add (None: all their points).

    0 and None stand for a missing or bad value; `reader` collects problems. Without the section `node`, extensions can still have
    `points` of their own.
    """
    if node is None:
        return 0.0, None
    keys = reader.fields(node, "extra_credit", ("each",), ("cap",))
    each = reader.points(keys.get("each"), "each")
    return each or 0.0, reader.points(keys["cap"], "the cap of extra_credit") if "cap" in keys else None


def read_extensions(
    reader: NodeReader, node: yaml.Node | None, ids: Sequence[str], each: float
) -> tuple[Extension, ...]:
    """Return the extensions, in the order of the lab's `ids`, worth `each` points if none are given; `reader` collects problems."""
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


def _extension_checks(reader: NodeReader, node: yaml.Node | None, part: str, points: float) -> tuple[CheckWeight, ...]:
    """Return the checks of an extension, which may have none: `checks: []`, `{}`, an empty value, or no such key."""
    nothing = node is None or not node.value or node.tag == "tag:yaml.org,2002:null"
    return () if nothing else _checks(reader, node, part, points)


def _checks(reader: NodeReader, node: yaml.Node | None, part: str, points: float | None) -> tuple[CheckWeight, ...]:
    """Read the checks of a criterion, each with its share of the criterion's `points`; () after a problem with the whole list."""
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
    shares = divided(points or 0.0, weights)
    return tuple(CheckWeight(*row) for row in zip(ids, weights, shares, lines, strict=True))


def divided(points: float, weights: Sequence[float]) -> list[float]:
    """Return the points of each check: `points` in proportion to the weights, in hundredths that sum to `points` exactly.

    Points are rounded down; the hundredths left go to the largest remainders, earlier checks first. All 0 if all weights are 0.
    """
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


def read_limits(reader: NodeReader, node: yaml.Node | None) -> Limits:
    """Return the limits of CPU time, 0 for a missing or bad one; `reader` collects problems, such as a call's above the total."""
    keys = reader.fields(node, "limits", ("call_cpu_s", "submission_cpu_s"))
    call = reader.number(keys.get("call_cpu_s"), "call_cpu_s", low=0.1)
    submission = reader.number(keys.get("submission_cpu_s"), "submission_cpu_s", low=0.1, high=100 * LARGEST)
    if call is not None and submission is not None and submission < call:
        reader.say(keys["submission_cpu_s"], "submission_cpu_s is less than call_cpu_s; make it at least as large")
    return Limits(call or 0.0, submission or 0.0)


LATE_KEYS: Mapping[str, str] = {
    "due": "Due, with the offset from UTC",
    "grace_minutes": "Minutes that do not count",
    "per_day": "Points or % for each day",
    "cut_off_days": "Days until nothing counts",
    "due_dates": "",
    "tz": "Time zone of the days",
}
"""Keys of the late policy; those that a form can show in one field have a label."""


def read_late(reader: NodeReader, node: yaml.Node | None, of: float) -> LatePolicy | None:
    """Return the late policy; None if the rubric has none or no valid due date. Percentages in it are of `of` points."""
    if node is None:
        return None
    keys = reader.fields(node, "late", ("due",), tuple(name for name in LATE_KEYS if name != "due"))
    zone = _read_zone(reader, keys.get("tz"))
    due = reader.stamp(keys.get("due"), "due", zone)
    grace = reader.number(keys.get("grace_minutes"), "grace_minutes", high=100 * LARGEST)
    cut_off = reader.number(keys.get("cut_off_days"), "cut_off_days")
    per_day = reader.share(keys.get("per_day"), "per_day", of)
    listed = keys.get("due_dates")
    due_dates: dict[str, datetime] = {}
    if isinstance(listed, yaml.MappingNode):
        for who, (_, value) in reader.pairs(listed, "due_dates").items():
            until = reader.stamp(value, f"the due date of {printable(who, 60)}", zone)
            due_dates |= {who: until} if until else {}
    elif listed is not None:
        reader.say(listed, "due_dates must be `who: date` lines; who is an id, a name or an e-mail address")
    if due is None:
        return None
    return LatePolicy(due, grace or 0.0, per_day or 0.0, cut_off, due_dates, str(zone or ""))


def _read_zone(reader: NodeReader, node: yaml.Node | None) -> ZoneInfo | None:
    """Return the time zone of a late policy; None if it names none, or an unknown one, which is a problem."""
    name = reader.text(node, "tz")
    if node is None or not name:
        return None
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        reader.say(node, f"there is no time zone {quote(node)}; name one like Europe/Berlin")
        return None


def read_faults(reader: NodeReader, node: yaml.Node | None, lab: Lab) -> dict[str, float]:
    """Return the points that the rubric deducts for each fault, by its id; report ids that the lab does not have to `reader`."""
    if node is None:
        return {}
    if not isinstance(node, yaml.MappingNode):
        reader.say(node, "faults must be `name: points` lines; `imugrade explain` lists the names")
        return {}
    known = catalogue(lab)
    deductions: dict[str, float] = {}
    for name, (key, value) in reader.pairs(node, "faults").items():
        if now := next((id_ for id_, row in rows(lab).items() if name in row.formerly), None):
            reader.say(key, f"the fault {quote(key)} is no longer told apart: {now} deducts for it")
        elif name not in known:
            reader.say(key, f"there is no fault {quote(key)}{guess_at(name, known)}; `imugrade explain` lists them")
        deductions[name] = reader.points(value, f"the deduction for {printable(name, 60)}") or 0.0
    return deductions


_APPLY = {"suggested": True, "none": False}


def read_repairs(reader: NodeReader, node: yaml.Node | None) -> RepairPolicy:
    """Return the repair policy: whether suggested repairs are applied, and the deduction; without a section `RepairPolicy()`."""
    if node is None:
        return RepairPolicy()
    keys = reader.fields(node, "repairs", ("apply", "deduct"), ())
    apply = reader.text(keys.get("apply"), "apply")
    if "apply" in keys and apply not in _APPLY:
        reader.say(keys["apply"], f"apply must be suggested or none, not {quote(keys['apply'])}")
    deduct = reader.points(keys.get("deduct"), "deduct")
    return RepairPolicy(_APPLY.get(apply, False), deduct or 0.0)
