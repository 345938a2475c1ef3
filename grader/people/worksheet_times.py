"""Read the times in Moodle's grading worksheet: the month by its name, by the clock of the site, without an offset."""

from __future__ import annotations

import re

_TIME = re.compile(
    r"(?:[^\W\d_]+,? )?(\d{1,2})\.? (?:de )?([^\W\d_]{3,})\.?(?: de)?,? (\d{4}),?\D* (\d{1,2}):(\d\d)(?: ?([AaPp])\.?[Mm]\.?)?"
)
_MONTHS = (
    ("jan", "ene"), ("feb", "fév"), ("mar", "mär"), ("apr", "avr", "abr"), ("may", "mai"), ("jun", "juin"),
    ("jul", "juil"), ("aug", "aoû", "ago"), ("sep",), ("oct", "okt"), ("nov",), ("dec", "dez", "déc", "dic"),
)  # fmt: skip
"""How the names of the months begin in English, German, French and Spanish."""
LATE = re.compile(r"\b(late|verspätet|en retard|con retraso)\b", re.IGNORECASE)
"""Words by which the column `Status` of a worksheet marks a late submission, in four languages."""


def local_time(text: str) -> str:
    """Return a time of a Moodle worksheet, ``Friday, 20 November 2026, 11:03 PM``, as ``2026-11-20T23:03``; "" for other text."""
    found = _TIME.fullmatch(text.strip())
    if found is None:
        return ""
    day, name, year, hour, minute, half = found.groups()
    month = next((n for n, starts in enumerate(_MONTHS, 1) if name.casefold().startswith(starts)), 0)
    hours = int(hour) % 12 + 12 * (half in "Pp") if half else int(hour)
    return f"{year}-{month:02}-{int(day):02}T{hours:02}:{minute}" if month else ""
