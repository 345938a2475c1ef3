"""Points in time as text: ISO 8601 with an offset from UTC. Without one nobody knows when it was, so it counts as unknown."""

from __future__ import annotations

import re
from datetime import datetime, timezone, tzinfo

_FORM = re.compile(r"(\d{4}-\d\d-\d\d)[Tt ]+(\d\d:\d\d(?::\d\d)?)(?:\.\d+)? *([Zz]|([+-]\d\d):?(\d\d))?", re.ASCII)


def read_stamp(value: object, zone: tzinfo | None = None) -> datetime | None:
    """Parse a point in time, to UTC and the second, from text or from what a YAML reader made of it.

    Return None if the value is no point in time, or has no offset from UTC while no `zone` says which clock is meant.
    """
    if isinstance(value, datetime):
        return value.astimezone(timezone.utc).replace(microsecond=0) if value.tzinfo else None
    found = _FORM.fullmatch(str(value).strip())
    if found is None:
        return None
    try:
        local = datetime.fromisoformat(f"{found[1]}T{found[2]}")
        if found[3] is None:
            return None if zone is None else local.replace(tzinfo=zone).astimezone(timezone.utc)
        if found[3] in "Zz":
            return local.replace(tzinfo=timezone.utc)
        return datetime.fromisoformat(f"{found[1]}T{found[2]}{found[4]}:{found[5]}").astimezone(timezone.utc)
    except (ValueError, OverflowError):
        return None


def now() -> str:
    """Return the present time as ISO 8601 text in UTC, as `stamp` does."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def stamp(value: object) -> str:
    """Return a time as ISO 8601 text in UTC, which sorts by time; "" if the value is no time."""
    when = read_stamp(value)
    return when.isoformat(timespec="seconds") if when else ""
