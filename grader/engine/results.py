"""Records of a graded submission's result, and their conversion to and from `result.json`.

Points are rounded once per check, to two decimals. A criterion's points are the sum of those of its checks, the score is the sum of
those of the criteria. A check that could not be judged has no points (None) and makes the result ``incomplete``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import msgspec

from grader.engine.chart_data import Evidence
from grader.engine.findings import Where

SCHEMA = "imugrade/result/v1"

Outcome = Literal["passed", "partial", "failed", "error", "timeout", "crashed", "skipped", "not_judged"]
Status = Literal["graded", "incomplete", "empty", "unreadable"]


@dataclass(frozen=True)
class Deducted:
    """Deduction of one fault at a check: the fault's id, the share of the check's points, and the text about it for the report."""

    fault: str
    share: float
    hint: str
    said: str = ""
    expected: str = ""
    got: str = ""


@dataclass(frozen=True)
class CheckResult:
    """Result of one check.

    Attributes
    ----------
    points : None if the grader could not judge
    said, expected, got : the message: one sentence, or the expected and the actual value, which may have more lines
    where : the place in the student's files that the message is about; None if there is none
    hint, lab_step : what the student can do next ("" for none); the lab sheet's step about the task (None: no single step)
    misconceptions : ids of the faults that the check shows
    keeps : share of the points that is earned, from which the module `marks` computes `points`; None if the grader could not judge
    not_understood : True if the grader could not interpret the student's answer: a person has to review it
    deducted : each fault that lost points of the check, for the report; () if no `charging.Judge`, which finds faults, judged it
    fault : the grader's exception that kept the check from being judged, with its place in the grader; else ""
    """

    id: str
    title: str
    outcome: Outcome
    points: float | None
    max_points: float
    said: str = ""
    expected: str = ""
    got: str = ""
    where: Where | None = None
    hint: str = ""
    lab_step: int | None = None
    misconceptions: tuple[str, ...] = ()
    duration_s: float = 0.0
    keeps: float | None = field(default=None, compare=False, repr=False)
    not_understood: bool = False
    deducted: tuple[Deducted, ...] = field(default=(), compare=False, repr=False)
    fault: str = ""

    @property
    def message(self) -> str:
        """The whole message for students: the sentence, or the expected and the actual value."""
        return message_of(self.said, self.expected, self.got)

    def with_message(self, sentence: str) -> CheckResult:
        """Return a copy with this sentence as message and no place in a file, for a check that was not reached; `hint` stays."""
        return replace(self, said=sentence, expected="", got="", where=None)


def message_of(said: str, expected: str, got: str) -> str:
    """Return the message as one text: the sentence, then ``Expected  …``, then ``Got       …``; what is "" is left out."""
    labelled = [f"{label:10}{text}" for label, text in (("Expected", expected), ("Got", got)) if text]
    return "\n".join([*([said] if said else []), *(text.replace("\n", "\n" + 10 * " ") for text in labelled)])


def _total(points: tuple[float | None, ...]) -> float:
    """Return the sum of the points that are not None, rounded to hundredths like all points, against binary rounding errors."""
    return round(sum((p for p in points if p is not None), 0.0), 2)


@dataclass(frozen=True)
class CriterionResult:
    id: str
    title: str
    max_points: float
    checks: tuple[CheckResult, ...]

    @cached_property
    def points(self) -> float:
        return _total(tuple(check.points for check in self.checks))


@dataclass(frozen=True)
class ExtensionResult:
    id: str
    attempted: bool
    max_points: float
    checks: tuple[CheckResult, ...] = ()

    @cached_property
    def points(self) -> float:
        return _total(tuple(check.points for check in self.checks))


@dataclass(frozen=True)
class LabName:
    """Name of a lab for pages: its label and its title, ``Lab 04-01`` and ``Reading IMU data in MuJoCo``."""

    label: str = ""
    title: str = ""


AUTOMATIC = "imugrade"
"""Author of a repair that `grade` applied by itself, as the rubric asks."""


@dataclass(frozen=True)
class Repair:
    """A patch to a submitted file, so that it can be graded: a unified diff, and the points deducted for it.

    `at` is the time at which it was made, as ISO 8601 text, `score_before` the score of the submission as it was handed in.
    """

    file: str
    diff: str
    deduction: float
    author: str
    at: str
    comment: str
    score_before: float


class Unrepaired(NamedTuple):
    """How a check ended before any repair: the share of its points that it kept (None: not judged), and its faults.

    From these `Repair.score_before`, the score of the files as handed in, is computed again if the rubric's points change.
    """

    keeps: float | None
    misconceptions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """Result of grading one submission.

    Attributes
    ----------
    provenance : versions and digests that the result depends on
    extra_credit_cap : None if extensions earn nothing, as on the lab sheet; else the most that they add to the score
    repairs : the patches; if there are any, `criteria` and `extensions` are the results of the repaired copy
    unrepaired : how each check of the criteria ended before the repairs, by id
    evidence : charts, and hashes of the code that find similar submissions; no part of the recorded result
    asked_sha256 : digest of the rubric's limits and settings and the instructor's own checks; if a rubric has another digest, its
        points cannot be computed from this result: the student's code has to run again
    cpu_s : CPU time of this grading, by the grader and the student's code; it is not recorded
    """

    submission: str
    status: Status
    criteria: tuple[CriterionResult, ...]
    extensions: tuple[ExtensionResult, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    duration_s: float = 0.0
    extra_credit_cap: float | None = None
    lab: LabName = LabName()
    repairs: tuple[Repair, ...] = ()
    unrepaired: Mapping[str, Unrepaired] = field(default_factory=dict, compare=False, repr=False)
    evidence: Evidence = field(default=Evidence(), compare=False, repr=False)
    asked_sha256: str = field(default="", compare=False, repr=False)
    cpu_s: float = field(default=0.0, compare=False, repr=False)

    @property
    def parts(self) -> tuple[CriterionResult | ExtensionResult, ...]:
        """The results of the criteria, then those of the extensions."""
        return (*self.criteria, *self.extensions)

    @property
    def extra_credit(self) -> float:
        """Points that the extensions earn together, at most the rubric's cap; 0 if the rubric grants no extra credit."""
        if self.extra_credit_cap is None:
            return 0.0
        return min(self.extra_credit_cap, _total(tuple(extension.points for extension in self.extensions)))

    @property
    def total(self) -> float:
        """Score plus extra credit, as exported to a gradebook."""
        return _total((self.score, self.extra_credit))

    @cached_property
    def score(self) -> float:
        """Points of the criteria, minus the deductions for repairs; repairs never make the score lower than it was without them."""
        points = _total(tuple(criterion.points for criterion in self.criteria))
        if not self.repairs:
            return points
        deducted = sum(repair.deduction for repair in self.repairs)
        return round(max(points - deducted, self.repairs[0].score_before), 2)

    @cached_property
    def repair_deduction(self) -> float:
        """Points by which the repairs lower the score below the sum of the criteria's points; 0 without repairs."""
        return round(_total(tuple(criterion.points for criterion in self.criteria)) - self.score, 2)

    @property
    def max_score(self) -> float:
        return _total(tuple(criterion.max_points for criterion in self.criteria))

    @property
    def misconceptions(self) -> tuple[str, ...]:
        """Ids of the faults found, each once, in the order of the checks."""
        return tuple(dict.fromkeys(m for part in self.parts for check in part.checks for m in check.misconceptions))


def to_dict(result: Result) -> dict[str, Any]:
    """Return the data of `result.json`, in the documented order, before `to_json` removes what students must not see."""

    def part(value: CriterionResult | ExtensionResult) -> dict[str, Any]:
        head: dict[str, Any] = {"id": value.id}
        head |= {"title": value.title} if isinstance(value, CriterionResult) else {"attempted": value.attempted}
        return {**head, "points": value.points, "max_points": value.max_points, "checks": [*map(_row, value.checks)]}

    cap = result.extra_credit_cap
    return {
        "schema": SCHEMA,
        "lab": asdict(result.lab),
        "submission": result.submission,
        "status": result.status,
        "score": result.score,
        "max_score": result.max_score,
        "criteria": [part(criterion) for criterion in result.criteria],
        "extensions": [part(extension) for extension in result.extensions],
        **({} if cap is None else {"extra_credit": {"points": result.extra_credit, "cap": cap}}),
        **({"repairs": [asdict(repair) for repair in result.repairs]} if result.repairs else {}),
        "misconceptions": list(result.misconceptions),
        "notes": list(result.notes),
        "provenance": dict(result.provenance),
        "duration_s": result.duration_s,
    }


def shown_provenance(result: Result) -> dict[str, Any]:
    """Return `provenance` for students: without the digest of hidden traces, by which anybody could test a guessed secret."""
    left_out = ("no_submission", *(("traces_sha256", "hidden") if result.provenance.get("hidden") else ()))
    return {key: value for key, value in result.provenance.items() if key not in left_out}


def _row(check: CheckResult) -> dict[str, Any]:
    """Return the result of a check as `result.json` has it."""
    return {
        "id": check.id,
        "title": check.title,
        "outcome": check.outcome,
        "points": check.points,
        "max_points": check.max_points,
        "message": check.message,
        "expected": check.expected,
        "got": check.got,
        "where": asdict(check.where) if check.where else None,
        "hint": check.hint,
        "lab_step": check.lab_step,
        "misconceptions": list(check.misconceptions),
        "duration_s": check.duration_s,
        **({"not_understood": True} if check.not_understood else {}),
        **({"fault": check.fault} if check.fault else {}),
    }


def to_record(result: Result) -> dict[str, Any]:
    """Return the data to record in a class's database: that of `result.json`, and what is needed to mark the result again."""
    checks = [check for part in result.parts for check in part.checks]
    deducted = {check.id: [asdict(each) for each in check.deducted] for check in checks if check.deducted}
    keeps = {check.id: check.keeps for check in checks}
    record = {**to_dict(result), "asked_sha256": result.asked_sha256, "keeps": keeps, "deducted": deducted}
    if result.repairs:
        record["unrepaired"] = dict(result.unrepaired)
    return record


def to_json(result: Result) -> str:
    """Return the text of `result.json` for students: UTF-8, fields in the documented order, nothing that reveals hidden data."""
    told = {**to_dict(result), "provenance": shown_provenance(result)}
    if result.provenance.get("hidden"):  # code could choose at which line of ours an answer is not understood
        for row in (row for part in (*told["criteria"], *told["extensions"]) for row in part["checks"]):
            row.pop("fault", None)
    text = json.dumps(told, indent=2, ensure_ascii=False, allow_nan=False)
    shown = _UNSEEN.sub(lambda found: json.dumps(found.group())[1:-1], text)
    return shown.encode("utf-8", "replace").decode("utf-8") + "\n"


_UNSEEN = re.compile(
    "[\x7f-\x9f\xad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\U000e0000-\U000e0fff]"
)
"""Invisible control characters that a terminal or an editor obeys; written as JSON escapes, which are read back unchanged."""


def from_dict(record: Mapping[str, Any]) -> Result:
    """Return the result from the data of ``result.json`` or of `to_record`; attributes that the data lacks get their defaults.

    Raises
    ------
    ValueError, KeyError, TypeError, AttributeError
        If the schema is not this version's `SCHEMA` (ValueError), or a field that is needed is missing or of another type.
    """
    if record.get("schema") != SCHEMA:
        raise ValueError(f"not an {SCHEMA} record: schema is {record.get('schema')!r}")
    keeps, deducted = record.get("keeps", {}), record.get("deducted", {})

    def check(row: Mapping[str, Any]) -> dict[str, Any]:
        # in old records without `expected` and `got` the message is a sentence
        said = "" if row.get("expected") or row.get("got") else row["message"]
        return {**row, "said": said, "keeps": keeps.get(row["id"]), "deducted": deducted.get(row["id"], ())}

    parts = {
        name: [{**part, "checks": [*map(check, part["checks"])]} for part in record[name]]
        for name in ("criteria", "extensions")
    }
    cap = record.get("extra_credit", {}).get("cap")
    try:
        return msgspec.convert({**record, **parts, "extra_credit_cap": cap}, Result)
    except msgspec.ValidationError as problem:
        raise ValueError(str(problem)) from None
