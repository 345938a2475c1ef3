"""Rubric what-if: preview the class under other points, deductions or late rules before saving them."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlencode

import yaml
from starlette.responses import RedirectResponse, Response

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.base.stamps import now
from grader.base.text import decimal
from grader.course.publishing.contradictions import contradictions
from grader.course.record.decisions import OvertakenError
from grader.course.record.repair_log import sha256_of
from grader.course.regrading import regrade
from grader.desk.classbook import Classbook
from grader.desk.overviews import framed
from grader.desk.web_requests import WebRequest
from grader.engine import rubric as rubrics
from grader.engine.rubric import Rubric
from grader.engine.rubric_nodes import LARGEST
from grader.engine.rubric_sections import LATE_KEYS
from grader.people.final_grade import FinalGrade, GradeChange, grade_changes, graded
from grader.report import overview, words

_SHOWN = 50
_NOT_VALUES = ("do", "message", "seen")
"""Fields of the form that are no values of a rubric."""
_LATE = "late:"
"""Prefix of the fields of the late policy."""
_HEAD = "# Made at the review desk on {when} from {source}, which holds the reasons.\n"


@dataclass(frozen=True)
class RubricPreview:
    """Effect of a changed rubric on a class: changed grades, largest change first; mean and histogram before and after.

    `more` changes are not listed, `of` counts the submissions. `above` are lines on grades that would be above their maximum.
    """

    changes: tuple[GradeChange, ...]
    more: int
    of: int
    means: tuple[str, str]
    above: tuple[str, ...]
    bars: tuple[list[overview.HistogramBar], list[overview.HistogramBar]]


def show(book: Classbook, web_request: WebRequest) -> Response:
    _refuse_overtaken(book, web_request)
    return _page(book, web_request, message=web_request.text("message"))


def save(book: Classbook, web_request: WebRequest) -> Response:
    """Write the changed rubric as a file in the output folder, for `--rubric`; with `do=mark`, also regrade the class by it.

    If a value is wrong, nothing is written, and the page shows the errors.

    OvertakenError if the class has got another rubric since the page was loaded.
    """
    _refuse_overtaken(book, web_request)
    try:
        changed, text = _changed(book.rubric, _entered(web_request))
    except RequestError:
        return _page(book, web_request, "", 400)
    target = book.out / f"rubric-{now()[:19].replace(':', '')}.yaml"
    write_whole(target, text)
    message = f"Saved as {target}"
    if web_request.text("do") == "mark":
        book.mark_by(replace(changed, source=str(target)))
        return RedirectResponse(f"/what-if?message={quote(f'{message}, and the class is regraded by it')}", 303)
    entered = {**_entered(web_request), "message": f"{message}. No grade has changed."}
    return RedirectResponse(f"/what-if?{urlencode(entered)}", 303)


def _page(book: Classbook, web_request: WebRequest, message: str, code: int = 200) -> Response:
    """Return the page with the form, its errors, and the preview of changed scores if the entered values differ."""
    final_grades = book.final_grades()
    base = book.rubric
    problem, preview, changed = "", None, base
    typed = _entered(web_request)
    errors = _errors(typed)
    try:
        changed, _ = _changed(base, typed)
        if (changed.sha256, changed.late) != (base.sha256, base.late):
            preview = _preview(final_grades, regrade.regraded(final_grades, changed))
    except RequestError as error:
        problem = "" if errors else _without_places(str(error))
    made = Counter(id_ for each in final_grades.values() for id_ in each.result.misconceptions)
    digests = {
        str(each.result.provenance.get("rubric_sha256")) for each in final_grades.values() if not each.has_no_submission
    }
    return framed(
        book,
        web_request,
        "what_if.html.j2",
        code,
        rubric=base,
        shown={part.id: part for part in changed.criteria},
        titles={c.id: c.title for s in final_grades.values() for part in s.result.criteria for c in part.checks},
        given=lambda name, value: typed.get(name) or ("" if name.startswith(_LATE) and name in typed else value),
        late=_late_fields(base),
        errors=errors,
        faults=[(id_, words.fault_in_words(id_), count) for id_, count in made.most_common()],
        prices=base.faults,
        preview=preview,
        problem=problem,
        other=digests != {base.sha256},
        message=message,
        typed=typed,
        seen=_shown(book),
    )


def _entered(web_request: WebRequest) -> dict[str, str]:
    """Return the values typed into the form by name of field, which `_changed` puts into the rubric."""
    given = {**web_request.query, **web_request.form}
    return {name: values[0].strip() for name, values in given.items() if name not in _NOT_VALUES}


def _shown(book: Classbook) -> str:
    """Return a digest of the rubrics behind a page (its starting point and the class's), to notice a change by somebody else."""
    settings = book.store.settings()
    return sha256_of(f"{book.rubric.text}\0{settings.rubric if settings else ''}".encode("utf-8", "surrogateescape"))


def _refuse_overtaken(book: Classbook, web_request: WebRequest) -> None:
    """Raise OvertakenError if the class has got another rubric since the page was loaded.

    The form holds all values of a rubric, so it would undo that change.
    """
    if web_request.text("seen") not in ("", _shown(book)):
        raise OvertakenError("Somebody has regraded the class by another rubric since you opened the page")


def _changed(base: Rubric, entered: Mapping[str, str]) -> tuple[Rubric, str]:
    """Return the rubric with the entered values, and its text for a file; RubricError with every problem of it."""
    data: dict[str, Any] = yaml.safe_load(base.text)
    _change_late(data, entered)
    fields = {name: _number(text) for name, text in entered.items() if text}
    for part in [*data["criteria"], *data["extensions"]]:
        weights = part.get("checks") or {}
        weights |= {name: fields.get(f"weight:{part['id']}.{name}", weight) for name, weight in weights.items()}
        if f"points:{part['id']}" in fields:
            part["points"] = fields[f"points:{part['id']}"]
    if "cap" in fields and isinstance(data.get("extra_credit"), dict):
        data["extra_credit"]["cap"] = fields["cap"]
    if priced := {name.removeprefix("price:"): value for name, value in fields.items() if name.startswith("price:")}:
        data["faults"] = {**(data.get("faults") or {}), **priced}
    model = data.get("model") or {}
    if model.get("path"):
        model["path"] = str(((base.folder or Path()) / model["path"]).absolute())
    body = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=120)
    text = _HEAD.format(when=now(), source=base.source) + body
    own = base.own_checks
    return rubrics.parse(base.lab, text.encode(), source="what was entered", folder=Path(), own=own), text


def _late_fields(rubric: Rubric) -> list[tuple[str, str, str]]:
    """Return name, label and present value of each field of the late policy, for the form."""
    policy: Mapping[str, Any] = yaml.safe_load(rubric.text).get("late") or {}
    return [(_LATE + name, label, _in_a_field(policy.get(name))) for name, label in LATE_KEYS.items() if label]


def _in_a_field(value: object) -> str:
    return "" if value is None else value.isoformat(timespec="minutes") if isinstance(value, datetime) else str(value)


def _change_late(data: dict[str, Any], entered: Mapping[str, str]) -> None:
    """Change the late policy in a rubric's data to what was entered; an empty due date removes the policy."""
    fields = {name: _number(entered[_LATE + name]) for name in LATE_KEYS if _LATE + name in entered}
    policy = {name: value for name, value in {**(data.pop("late", None) or {}), **fields}.items() if value != ""}
    if policy.get("due"):
        data["late"] = policy


def _errors(entered: Mapping[str, str]) -> dict[str, str]:
    """Return what is wrong with each number field, to show it there; parsing the rubric finds errors of the late policy."""
    numbers = {name: _number(text) for name, text in entered.items() if text and not name.startswith(_LATE)}
    wrong = [name for name, value in numbers.items() if isinstance(value, str) or not 0 <= value <= LARGEST]
    return dict.fromkeys(wrong, f"Enter a number from 0 to {LARGEST:g}.")


def _without_places(problem: str) -> str:
    """Return the problems of an entered rubric without line numbers, which the form has not, and with faults in words."""
    message = re.sub(r"^what was entered(:\d+)?: ", "", problem, flags=re.MULTILINE)
    return re.sub(r"\b[a-z]+(-[a-z]+)+\b", lambda found: words.fault_in_words(found[0]), message)


def _number(text: str) -> float | int | str:
    """Return the number in a text, or the text itself, which parsing the rubric then refuses with a message."""
    value = decimal(text)
    if value is None:
        return text
    return int(value) if value.is_integer() else value


def _preview(before: Mapping[str, FinalGrade], after: Mapping[str, FinalGrade]) -> RubricPreview:
    """Return the changed scores, the largest change first, with means and distributions before and after."""
    changes = grade_changes(before, after)
    top = max((each.result.max_score for side in (before, after) for each in side.values()), default=100.0)
    scores = [graded(side.values()) for side in (before, after)]
    means = [words.number(round(statistics.fmean(side), 1)) if side else "–" for side in scores]
    return RubricPreview(
        tuple(changes[:_SHOWN]),
        max(0, len(changes) - _SHOWN),
        len(after),
        (means[0], means[1]),
        tuple(each.text for each in contradictions(after, None) if each.kind == "above maximum"),
        (overview.bars(scores[0], top), overview.bars(scores[1], top)),
    )
