"""Find the installed labs by id, and choose the one that a command is about.

A lab is a package of its own that registers the module of its `LAB` as an entry point of the group ``imugrade.labs``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.metadata import entry_points

from grader.base.errors import GraderError, RequestError
from grader.base.text import printable
from grader.engine.lab import Lab, lab_of

VARIABLE = "IMUGRADE_LAB"
"""Environment variable with the id of the lab."""
GROUP = "imugrade.labs"
DEFAULT = "imu"
_SHIPPED: Mapping[str, str] = {DEFAULT: "grader.labs.imu.lab"}
"""Module of each lab in this package: to search what is installed takes a tenth of the start of `imugrade check`."""


def chosen_lab(on_record: str = "") -> Lab:
    """Return the lab of a command: the one that the variable `IMUGRADE_LAB` names, else the graded class's, else the shipped one.

    `on_record` is the id of the lab in a class's record; "" without a class.

    Raises
    ------
    RequestError
        If no such lab is installed, or if `IMUGRADE_LAB` names another lab than the record.
    """
    asked = os.environ.get(VARIABLE, "")
    if asked and on_record and asked != on_record:
        raise RequestError(
            f"{VARIABLE}={printable(asked)}: this folder holds grades of the lab {printable(on_record)}; "
            "unset the variable or use another folder"
        )
    return lab_named(asked or on_record or DEFAULT)


def lab_named(id_: str) -> Lab:
    """Return the installed lab with this id.

    Raises
    ------
    RequestError
        If no lab with this id is installed.
    GraderError
        If the installed lab's own `id` differs: a class stores that `id`, and would not find the lab again.
    """
    modules = _SHIPPED if id_ in _SHIPPED else {each.name: each.value for each in entry_points(group=GROUP)}
    if id_ not in modules:
        known = ", ".join(sorted({*_SHIPPED, *modules}))
        raise RequestError(f"no lab {printable(id_)!r} is installed here; choose {known} in {VARIABLE}")
    lab = lab_of(modules[id_])
    if lab.id != id_:
        raise GraderError(f"{modules[id_]} is registered as the lab {printable(id_)}; its id is {printable(lab.id)}")
    return lab
