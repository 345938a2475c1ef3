"""Points in time as text: ISO 8601 with an offset from UTC. Without an offset the time zone is unknown, and so is the time."""

from __future__ import annotations

import re
from datetime import datetime, timezone, tzinfo

_FORM = re.compile(r"(\d{4}-\d\d-\d\d)[Tt ]+(\d\d:\d\d(?::\d\d)?)(?:\.\d+)? *([Zz]|([+-]\d\d):?(\d\d))?", re.ASCII)


def read_stamp(value: object, zone: tzinfo | None = None) -> datetime | None:
    """Parse a date and time, from text or from the `datetime` that a YAML reader made of it; return it in UTC and whole seconds.

    Return None if the value is no date and time, or lacks an offset from UTC. With `zone`, a text without an offset is taken as a
    time of that zone; a `datetime` without one still gives None.
    """
    try:
        if isinstance(value, datetime):
            return value.astimezone(timezone.utc).replace(microsecond=0) if value.tzinfo else None
        found = _FORM.fullmatch(str(value).strip())
        if found is None:
            return None
        local = datetime.fromisoformat(f"{found[1]}T{found[2]}")
        if found[3] is None:
            return None if zone is None else local.replace(tzinfo=zone).astimezone(timezone.utc)
        if found[3] in "Zz":
            return local.replace(tzinfo=timezone.utc)
        return datetime.fromisoformat(f"{found[1]}T{found[2]}{found[4]}:{found[5]}").astimezone(timezone.utc)
    except (ValueError, OverflowError):
        return None


def now() -> str:
    """Return the present time as ISO 8601 text in UTC and whole seconds, as records and reports keep times."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")


def stamp(value: object) -> str:
    """Return a date and time (text or `datetime`) as sortable ISO 8601 text in UTC; "" if invalid or without an offset from UTC."""
    when = read_stamp(value)
    return when.isoformat(timespec="seconds") if when else ""
