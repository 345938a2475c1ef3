"""Rubric what-if: preview the class under other points, deductions or late rules before saving them."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import yaml
from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.course import regrade
from grader.desk.asking import Ask
from grader.desk.classbook import Classbook, now
from grader.desk.overviews import framed
from grader.engine import rubric as rubrics
from grader.engine.rubric import Rubric
from grader.people.final_grade import FinalGrade
from grader.report import overview, words

_SHOWN = 50
_HEAD = "# Made at the review desk on {when} from {source}, which holds the reasons.\n"


@dataclass(frozen=True)
class Move:
    """A submission whose grade would change."""

    final_grade: FinalGrade
    before: float | None
    after: float | None

    @property
    def by(self) -> float:
        return round((self.after or 0.0) - (self.before or 0.0), 2)


@dataclass(frozen=True)
class Outlook:
    """The changes, largest first, and both distributions."""

    moves: tuple[Move, ...]
    more: int
    of: int
    means: tuple[str, str]
    bars: tuple[list[overview.Bar], list[overview.Bar]]


def show(book: Classbook, ask: Ask) -> Response:
    return _page(book, ask, told=ask.text("told"))


def save(book: Classbook, ask: Ask) -> Response:
    """Write the changed rubric into OUT; with `do=mark`, regrade the class by it."""
    changed, text = _changed(book, ask)
    target = book.out / f"rubric-{now()[:19].replace(':', '')}.yaml"
    write_whole(target, text)
    told = f"Saved as {target}"
    if ask.text("do") == "mark":
        book.mark_by(replace(changed, source=str(target)))
        told += ", and the class is regraded by it"
    return RedirectResponse(f"/what-if?told={quote(told)}", 303)


def _page(book: Classbook, ask: Ask, told: str) -> Response:
    final_grades = book.final_grades()
    base = book.rubric
    problem, outlook, changed = "", None, base
    try:
        changed, _ = _changed(book, ask)
        if changed.sha256 != base.sha256:
            outlook = _outlook(final_grades, regrade.under(final_grades, changed))
    except RequestError as error:
        problem = str(error)
    made = Counter(id_ for each in final_grades.values() for id_ in each.result.misconceptions)
    digests = {str(each.result.provenance.get("rubric_sha256")) for each in final_grades.values()}
    return framed(
        book,
        ask,
        "what_if.html.j2",
        rubric=base,
        shown={part.id: part for part in changed.criteria},
        titles={c.id: c.title for s in final_grades.values() for part in s.result.criteria for c in part.checks},
        given=lambda name, value: ask.text(name) or value,
        mistakes=[(id_, words.misconception(id_), count) for id_, count in made.most_common()],
        prices=base.mistakes,
        outlook=outlook,
        problem=problem,
        other=digests != {base.sha256},
        told=told,
        query=ask.query,
    )


def _changed(book: Classbook, ask: Ask) -> tuple[Rubric, str]:
    """Return the changed rubric and its text.

    Raises
    ------
    RubricError
        With every problem of the changed rubric.
    """
    base = book.rubric
    data: dict[str, Any] = yaml.safe_load(base.text)
    fields = {name: values[0].strip() for name, values in {**ask.query, **ask.form}.items() if values[0].strip()}
    for part in [*data["criteria"], *data["extensions"]]:
        if f"points:{part['id']}" in fields:
            part["points"] = _number(fields[f"points:{part['id']}"])
        for name in part.get("checks") or {}:
            key = f"weight:{part['id']}.{name}"
            if key in fields:
                part["checks"][name] = _number(fields[key])
    if "cap" in fields and isinstance(data.get("extra_credit"), dict):
        data["extra_credit"]["cap"] = _number(fields["cap"])
    priced = {name.removeprefix("price:"): _number(text) for name, text in fields.items() if name.startswith("price:")}
    if priced:
        data["mistakes"] = {**(data.get("mistakes") or {}), **priced}
    model = data.get("model") or {}
    if model.get("path"):
        model["path"] = str(((base.folder or Path()) / model["path"]).absolute())
    body = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=120)
    text = _HEAD.format(when=now(), source=base.source) + body
    own = base.own_checks
    return rubrics.parse(book.lab, text.encode(), source="what was entered", folder=Path(), own=own), text


def _number(text: str) -> float | int | str:
    """Return the number in a text, or the text itself for the rubric reader to refuse."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return text
    return int(value) if value.is_integer() else value


def _outlook(before: Mapping[str, FinalGrade], after: Mapping[str, FinalGrade]) -> Outlook:
    moves = [
        Move(each, before[id_].final, each.final) for id_, each in after.items() if before[id_].final != each.final
    ]
    moves.sort(key=lambda move: (-abs(move.by), move.final_grade.id))
    top = max((each.result.max_score for side in (before, after) for each in side.values()), default=100.0)
    scores = [[each.final for each in side.values() if each.final is not None] for side in (before, after)]
    means = [words.number(round(statistics.fmean(side), 1)) if side else "–" for side in scores]
    return Outlook(
        tuple(moves[:_SHOWN]),
        max(0, len(moves) - _SHOWN),
        len(after),
        (means[0], means[1]),
        (overview.bars(scores[0], top), overview.bars(scores[1], top)),
    )
