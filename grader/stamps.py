"""Points in time as text: ISO 8601 with an offset from UTC. Without one nobody knows when it was, so it counts as unknown."""

from __future__ import annotations

from datetime import datetime, timezone


def read_stamp(value: object) -> datetime | None:
    """A point in time from text or what a YAML reader made of it; None if it is none, or has no offset."""
    text = str(value).strip()
    if text.endswith(("Z", "z")):  # Python 3.10 does not take it
        text = f"{text[:-1]}+00:00"
    try:
        when = value if isinstance(value, datetime) else datetime.fromisoformat(text)
        return when.astimezone(timezone.utc) if when.tzinfo else None
    except (ValueError, OverflowError):
        return None


def stamp(value: object) -> str:
    """The same in UTC as text, so that it sorts as time does; "" if it is none."""
    when = read_stamp(value)
    return when.isoformat(timespec="seconds") if when else ""
