"""Explain faults, checks and criteria in Markdown, for `imugrade explain`, the students' guide and the documentation."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.engine.check_catalog import Check, checks_of
from grader.engine.faults import FaultRow, catalogue
from grader.engine.lab import Lab
from grader.engine.rubric import CheckWeight, Criterion, Extension, Rubric, load
from grader.engine.rubric_nodes import did_you_mean
from grader.report.words import counted_points, number


def explain(lab: Lab, id_: str) -> str:
    """Return, in Markdown, the explanation of the fault, check, criterion or extension that has the id.

    Raises
    ------
    RequestError
        If nothing has that id; the message names the closest one.
    """
    shipped = _rubric(lab)
    parts = {part.id: part for part in shipped.parts}
    weights = {weight.id: weight for weight in shipped.checks}
    if id_ in catalogue(lab):
        return fault(lab, catalogue(lab)[id_])
    if id_ in parts:
        return criterion(lab, parts[id_])
    if id_ in weights:
        return check(lab, weights[id_])
    guess = did_you_mean(id_, [*catalogue(lab), *parts, *weights], "`imugrade explain` lists all of them")
    raise RequestError(f"{printable(id_)}: no fault, check or criterion has this id; {guess}")


def listing(lab: Lab) -> str:
    """Return the list of `imugrade explain`: the ids of faults, then those of checks, each on a line with its title."""
    lines = []
    for group, title in groups(lab).items():
        lines += ["", f"Faults: {title}", ""]
        lines += [f"  {entry.id:<28} {entry.title}" for entry in catalogue(lab).values() if entry.group == group]
    for each in _rubric(lab).parts:
        lines += ["", f"Checks: {each.title}", ""] if each.checks else []
        lines += [f"  {weight.id:<44} {_title(lab, weight.id)}" for weight in each.checks]
    return "\n".join([*lines[1:], "", "imugrade explain ID explains one of them.", ""])


def groups(lab: Lab) -> dict[str, str]:
    """Return the headings under which `imugrade explain`, the guide and the documentation list faults, by `FaultRow.group`.

    A group is a criterion's id, "extensions", or "any" for faults that any file can have, such as a syntax error. "checks" has no
    heading: its rows are texts for checks without a known fault.
    """
    return {**{part.id: part.title for part in lab.parts}, "extensions": "Extensions", "any": "Any file"}


def fault(lab: Lab, entry: FaultRow, *, level: int = 1) -> str:
    """Return a fault's explanation in Markdown, under a heading of `level`: what it is, wrong and right code, hint, deduction."""
    read = f"\nRead: {lab.label}, Step {entry.step}.\n" if entry.step is not None else ""
    rerun = f"\nRerun: `imugrade check --only {entry.group}`\n" if entry.group in {p.id for p in lab.parts} else ""
    return (
        f"{'#' * level} {entry.id}\n\n{_sentence(entry.title)}\n\n{entry.explanation.strip()}\n\n"
        f"Wrong:\n\n{_code(entry.wrong)}\n\nRight:\n\n{_code(entry.right)}\n\nTry: {entry.hint.strip()}\n"
        f"{_deductions(lab, entry)}{read}{rerun}"
    )


def _deductions(lab: Lab, entry: FaultRow) -> str:
    """Return what a fault deducts under the shipped rubric, as a line; "" if it deducts nothing.

    A fault that can occur in several criteria deducts in one of them only, so their points are joined by "or".
    """
    worth = {weight.id: weight.max_points for weight in _rubric(lab).checks}
    shares = {_full(name, entry): share for name, share in entry.deducts.items() if share}
    points: dict[str, list[str]] = {}
    for name, share in shares.items():
        points.setdefault(name.partition(".")[0], []).append(f"{counted_points(share * worth[name])} of `{name}`")
    return f"\nDeducts: {' or '.join(' and '.join(each) for each in points.values())}.\n" if points else ""


def _full(name: str, entry: FaultRow) -> str:
    return name if "." in name else f"{entry.group}.{name}"


def check(lab: Lab, weight: CheckWeight, *, level: int = 1) -> str:
    """Return the explanation of a check in Markdown under a heading of `level`: what it tests, its points, the lab sheet's step."""
    known = _checks(lab).get(weight.id)
    step = f" Read: {lab.label}, Step {known.lab_step}." if known else ""
    return (
        f"{'#' * level} {weight.id}\n\n{_title(lab, weight.id)}.\n\nWorth {counted_points(weight.max_points)}.{step}\n\n"
        f"Rerun: `imugrade check --only {weight.id.partition('.')[0]}`\n"
    )


def criterion(lab: Lab, part: Criterion | Extension, *, level: int = 1) -> str:
    """Return the points of a criterion or an extension in Markdown under a heading of `level`, with the table of its checks."""
    worth = f"{counted_points(part.points)}." if part.points else "No points: reported beside the score."
    where = f" File: `{part.file}`." if isinstance(part, Extension) else ""
    rows = [f"| `{w.id.partition('.')[2]}` | {number(w.max_points)} | {_title(lab, w.id)} |" for w in part.checks]
    table = "\n".join(["| Check | Points | Tests |", "| --- | ---: | --- |", *rows])
    return f"{'#' * level} {part.title} (`{part.id}`)\n\n{worth}{where}\n" + (f"\n{table}\n" if rows else "")


@lru_cache(maxsize=1)
def _rubric(lab: Lab) -> Rubric:
    return load(lab)


@lru_cache(maxsize=1)
def _checks(lab: Lab) -> Mapping[str, Check]:
    return checks_of(lab)


def _title(lab: Lab, check_id: str) -> str:
    known = _checks(lab).get(check_id)
    return known.title if known else check_id


def _sentence(text: str) -> str:
    text = text.strip().rstrip(".")
    return f"{text[:1].upper()}{text[1:]}."


def _code(lines: str) -> str:
    return f"```python\n{lines.strip()}\n```"
