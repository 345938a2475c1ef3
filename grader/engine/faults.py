"""Fault table of a lab (``faults.yaml``): the deductions and texts of each fault that the grader can recognize.

`imugrade explain` reads it too and has to start fast, so this module imports nothing slow.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from grader.base.errors import GraderError
from grader.engine.findings import StudentError
from grader.engine.lab import Lab


@dataclass(frozen=True)
class FaultRow:
    """One entry of a lab's fault table (``faults.yaml``): deductions and texts of a fault, or of a check if no fault is known.

    Attributes
    ----------
    id, group : key of the entry, and of the table's section: a criterion, ``extensions``, ``any`` (criterion) or ``checks``
    title, hint : what the student's code does, and what to do next
    explanation, wrong, right : text, wrong and right code for `imugrade explain`; rubrics and reports name no fault without a text
    step : step of the lab sheet that shows the right code; None if none does
    deducts : share of points that each broken check loses, by the check's short name; 0 for a check that only shows the fault
    formerly : ids of faults that this entry replaces; a rubric that names one is refused with this entry's id
    expected, got : templates for the numbers of a `Deviation`; without them those of the check are used
    raised : rules by which `shown_by` finds this fault in an exception; empty if no exception shows it
    """

    id: str
    group: str
    hint: str
    title: str = ""
    explanation: str = ""
    step: int | None = None
    wrong: str = ""
    right: str = ""
    raised: Mapping[str, Any] = field(default_factory=dict)
    expected: str = ""
    got: str = ""
    deducts: Mapping[str, float] = field(default_factory=dict)
    formerly: tuple[str, ...] = ()

    def shown_by(self, error: StudentError) -> bool:
        """Return whether an exception of the student's code shows this fault, by the rules in `raised`; False without rules.

        All rules given must hold: the exception's type is in ``types``, the missing name in ``names``, and the pattern ``line`` is
        found in the source line. The message plays no part: it differs between versions of Python and of the libraries.
        """
        if error.type not in self.raised.get("types", ()) or error.name not in self.raised.get("names", (error.name,)):
            return False
        return re.search(self.raised.get("line", ""), error.text or "") is not None


NEEDED = (
    "file-missing", "name-missing", "does-not-import", "missing-package", "raises", "never-returns", "kills-its-process",
    "tampering",
)  # fmt: skip
"""Ids of the faults that the engine itself finds in any lab; each lab's table must have a row for them."""


@functools.cache
def rows(lab: Lab) -> Mapping[str, FaultRow]:
    """Return the entries of a lab's fault table by id: one for each fault, and one for each check, used if no fault is known.

    Raises
    ------
    GraderError
        If an entry is missing for a fault that the engine itself finds (`NEEDED`).
    """
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (lab.folder / "faults.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    found = {key: FaultRow(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}
    if missing := [id_ for id_ in NEEDED if id_ not in found]:
        raise GraderError(f"faults.yaml of {lab.label} lacks {', '.join(missing)}")
    return found


@functools.cache
def catalogue(lab: Lab) -> Mapping[str, FaultRow]:
    """Return by id the faults that have an explanation, so that rubrics, reports and `imugrade explain` can name them."""
    return {id_: row for id_, row in rows(lab).items() if row.explanation}
