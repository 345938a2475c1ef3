"""Points in time as text: ISO 8601 with an offset from UTC. Without one nobody knows when it was, so it counts as unknown."""

from __future__ import annotations

import re
from datetime import datetime, timezone

_FORM = re.compile(r"(\d{4}-\d\d-\d\d)[Tt ]+(\d\d:\d\d(?::\d\d)?)(?:\.\d+)? *(?:([+-]\d\d):?(\d\d)|[Zz])", re.ASCII)


def read_stamp(value: object) -> datetime | None:
    """A point in time from text or what a YAML reader made of it, to the second; None if it is none, or has no offset."""
    if isinstance(value, datetime):
        return value.astimezone(timezone.utc).replace(microsecond=0) if value.tzinfo else None
    found = _FORM.fullmatch(str(value).strip())
    if found is None:
        return None
    try:
        when = datetime.fromisoformat(f"{found[1]}T{found[2]}{found[3] or '+00'}:{found[4] or '00'}")
        return when.astimezone(timezone.utc)
    except (ValueError, OverflowError):
        return None


def stamp(value: object) -> str:
    """The same in UTC as text, so that it sorts as time does; "" if it is none."""
    when = read_stamp(value)
    return when.isoformat(timespec="seconds") if when else ""
