"""The table of faults: what each deducts, and every word about it.

`imugrade explain` reads it, too, so nothing slow is imported here.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import yaml

from grader.base.errors import GraderError
from grader.engine.findings import Fault
from grader.engine.lab import Lab


@dataclass(frozen=True)
class Mistake:
    """One row of the table.

    Attributes
    ----------
    title, hint : what the code does, and what to do next
    explanation, wrong, right : for `imugrade explain`; a row without an explanation has no public name
    deducts : the share of its points that each check loses where this fault is found through it, by name
    formerly : ids of faults that are told by this row now; a rubric that names one is refused with this row's id
    takes : checks that have nothing to judge where this fault is found, and are lost with it
    expected, got : templates over the numbers of the deviation; those of the check where a row has none
    raised : the exceptions that show it, see `shown_by`; empty where none does
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
    takes: tuple[str, ...] = ()
    formerly: tuple[str, ...] = ()

    def shown_by(self, fault: Fault) -> bool:
        """Return whether an exception shows this mistake: of ``types``, about ``names``, in a line that ``calls`` a method.

        The text of the exception plays no part: it differs between versions of Python and of the libraries.
        """
        if fault.type not in self.raised.get("types", ()) or fault.name not in self.raised.get("names", (fault.name,)):
            return False
        calls = self.raised.get("calls")
        return calls is None or re.search(rf"\.{calls}\s*\(", fault.text or "") is not None


NEEDED = (
    "file-missing", "name-missing", "does-not-import", "missing-package", "raises", "never-returns", "kills-its-process",
    "tampering",
)  # fmt: skip
"""What the engine itself finds out, whatever the lab is: each catalogue has the words for it."""


@functools.cache
def rows(lab: Lab) -> Mapping[str, Mistake]:
    """Every row of a lab's table, by id: faults, and under the id of each check what it says where no fault is known.

    Raises
    ------
    GraderError
        If one is missing that the engine finds out by itself.
    """
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (lab.folder / "faults.yaml").read_text(encoding="utf-8")
    groups = yaml.load(text, Loader=loader)
    found = {key: Mistake(key, group, **entry) for group, entries in groups.items() for key, entry in entries.items()}
    if missing := [id_ for id_ in NEEDED if id_ not in found]:
        raise GraderError(f"faults.yaml of {lab.label} lacks {', '.join(missing)}")
    return found


@functools.cache
def catalogue(lab: Lab) -> Mapping[str, Mistake]:
    """The rows that have a public name and an explanation."""
    return {id_: row for id_, row in rows(lab).items() if row.explanation}
