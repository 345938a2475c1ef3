"""Parameters by which a definition could not be called as the sheet calls it."""

from __future__ import annotations

from collections.abc import Sequence

from grader.engine.findings import Deviation, Size

_GLOBAL, _NAME = "global ", "name for "


def reads_global(departs: Sequence[str]) -> bool:
    """Return whether a student's definition reads a global in place of a parameter of the sheet."""
    return any(each.startswith(_GLOBAL) for each in departs)


def departure(name: str, departs: Sequence[str]) -> Deviation | None:
    """Describe how the definition of `name` differs from the sheet's; `departs` holds the sheet's names, none of the student's."""
    if not departs:
        return None
    read = [each.removeprefix(_GLOBAL) for each in departs if each.startswith(_GLOBAL)]
    shown = " and ".join(read) if read else ", ".join(each.removeprefix(_NAME) for each in departs)
    return Deviation({"name": name, "departs": shown}, size=Size(f"other parameters for {shown}"))
