"""One entry of the handbook each: a mistake, a check, a criterion. The pages and `imugrade explain` print the same text."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from functools import lru_cache

from grader.engine.mistakes import Mistake, catalogue
from grader.engine.rubric import CheckWeight, Criterion, Extension, Rubric, load
from grader.engine.written import Check, checks_of
from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.labs.imu.lab import LAB
from grader.report.words import number

GROUPS = {**{part.id: part.title for part in LAB.parts}, "extensions": "Extensions", "any": "Anywhere"}


@lru_cache(maxsize=1)
def checks() -> Mapping[str, Check]:
    """Every check by id."""
    return checks_of(LAB)


@lru_cache(maxsize=1)
def rubric() -> Rubric:
    """The rubric that this installation ships."""
    return load(LAB)


def explain(id_: str) -> str:
    """The entry of a mistake, a check, or a criterion or extension.

    Raises
    ------
    RequestError
        If nothing has that id; names the nearest that there is.
    """
    shipped = rubric()
    parts = {part.id: part for part in shipped.parts}
    weights = {weight.id: weight for weight in shipped.checks}
    if id_ in catalogue(LAB):
        return mistake(catalogue(LAB)[id_])
    if id_ in parts:
        return part(parts[id_])
    if id_ in weights:
        return check(weights[id_])
    known = [*catalogue(LAB), *parts, *weights]
    near = difflib.get_close_matches(id_, known, 1)
    guess = f"did you mean {near[0]}?" if near else "`imugrade explain` lists all"
    raise RequestError(f"{printable(id_)}: no mistake, check or criterion is called that; {guess}")


def listing() -> str:
    """Every id in a line: the mistakes by group, then the checks by criterion."""
    lines = []
    for group, title in GROUPS.items():
        lines += ["", f"Mistakes: {title}", ""]
        lines += [f"  {entry.id:<28} {entry.title}" for entry in catalogue(LAB).values() if entry.group == group]
    for each in rubric().parts:
        lines += ["", f"Checks: {each.title}", ""] if each.checks else []
        lines += [f"  {weight.id:<44} {_title(weight.id)}" for weight in each.checks]
    return "\n".join([*lines[1:], "", "imugrade explain ID tells more of one.", ""])


def mistake(entry: Mistake, *, level: int = 1) -> str:
    """What it is, why it is wrong, how it looks and how it is mended; Markdown."""
    head = "#" * level
    read = f"\nRead: {LAB.label}, Step {entry.step}.\n" if entry.step is not None else ""
    again = (
        f"\nAgain: `imugrade check --only {entry.group}`\n" if entry.group in GROUPS and _is_part(entry.group) else ""
    )
    return (
        f"{head} {entry.id}\n\n{_sentence(entry.title)}\n\n{entry.explanation.strip()}\n\n"
        f"Wrong:\n\n{_code(entry.wrong)}\n\nRight:\n\n{_code(entry.right)}\n\nTry: {entry.hint.strip()}\n"
        f"{_deductions(entry)}{read}{again}"
    )


def _deductions(entry: Mistake) -> str:
    """What a fault costs where the rubric sets no deduction for it."""
    worth = {weight.id: weight.max_points for weight in rubric().checks}
    shares = {_full(name, entry): share for name, share in entry.deducts.items()}
    costs = [f"{number(share * worth[name])} points of `{name}`" for name, share in shares.items()]
    taken = ", ".join(f"`{_full(name, entry)}`" for name in entry.takes)
    return f"\nDeducts: {' or '.join(costs)}{f'; all of {taken}' if taken else ''}.\n" if costs else ""


def _full(name: str, entry: Mistake) -> str:
    return name if "." in name else f"{entry.group}.{name}"


def _is_part(group: str) -> bool:
    return group not in ("extensions", "any")


def _sentence(text: str) -> str:
    text = text.strip().rstrip(".")
    return f"{text[:1].upper()}{text[1:]}."


def _code(lines: str) -> str:
    return f"```python\n{lines.strip()}\n```"


def check(weight: CheckWeight, *, level: int = 1) -> str:
    """What a check asks for, its points and the step of the sheet; Markdown."""
    known = checks().get(weight.id)
    step = f" Read: {LAB.label}, Step {known.lab_step}." if known else ""
    again = f"imugrade check --only {weight.id.partition('.')[0]}"
    return (
        f"{'#' * level} {weight.id}\n\n{_title(weight.id)}.\n\n"
        f"Worth {number(weight.max_points)} points.{step}\n\nAgain: `{again}`\n"
    )


def _title(check_id: str) -> str:
    known = checks().get(check_id)
    return known.title if known else check_id


def part(each: Criterion | Extension, *, level: int = 1) -> str:
    """A criterion or an extension with the table of its checks; Markdown."""
    worth = f"{number(each.points)} points." if each.points else "No points: it is reported beside them."
    where = f" In `{each.file}`." if isinstance(each, Extension) else ""
    rows = [f"| `{w.id.partition('.')[2]}` | {number(w.max_points)} | {_title(w.id)} |" for w in each.checks]
    table = "\n".join(["| Check | Points | Asks |", "| --- | ---: | --- |", *rows])
    return f"{'#' * level} {each.title} (`{each.id}`)\n\n{worth}{where}\n" + (f"\n{table}\n" if rows else "")
