"""Gradescope: `submission_metadata.yml` and a folder `submission_<id>` each. Keys keep the colon of Ruby's symbols."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from grader.intake.downloads import Download
from grader.intake.found import Found, Shape
from grader.intake.names import original
from grader.people.standing import HandIn, Person
from grader.stamps import stamp

TITLE = "Gradescope export"
METADATA = "submission_metadata.yml"
MAX_METADATA = 64_000_000
_NOT_OURS = f"{METADATA} does not name it, so whose it is cannot be told"
_NO_FILES = f"{METADATA} names it, and it has no folder"


def read(download: Download) -> Shape | None:
    """The submissions of an export, groups as one; None if it is none."""
    data = download.read(METADATA, MAX_METADATA) if METADATA in download.top else None
    if data is None:
        return None
    try:
        # CSafeLoader where PyYAML has it: the results in the file make it long, and this one is twenty times as fast
        records = yaml.load(data, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError):
        return None
    if not isinstance(records, dict):
        return None
    told = {str(folder): record if isinstance(record, dict) else {} for folder, record in records.items()}
    left = [(name, _NOT_OURS) for name in download.top if name not in told and name != METADATA]
    left += [(folder, _NO_FILES) for folder in told if folder not in download.top]
    return Shape(TITLE, tuple(_found(download, f, told[f]) for f in told if f in download.top), tuple(left))


def _found(download: Download, folder: str, record: Mapping[str, Any]) -> Found:
    submitters = record.get(":submitters")
    people = (
        tuple(_person(each) for each in submitters if isinstance(each, dict)) if isinstance(submitters, list) else ()
    )
    submitted = stamp(record.get(":created_at"))
    number = folder.rpartition("_")[2]
    keys = sorted(person.sid or person.email or person.name for person in people)
    first = min(people, key=lambda person: person.sid or person.email or person.name, default=Person(original(folder)))
    return Found(
        f"gradescope:{keys or folder}",
        "_".join(filter(None, (first.name, first.sid))),
        "; ".join(person.name for person in people) or original(folder),
        download.path,
        ((download.place(folder), ""),),
        HandIn(people, submitted, number=number if number.isdecimal() else ""),
        (submitted, int(number[:18]) if number.isdecimal() else 0, folder),
    )


def _person(record: Mapping[str, Any]) -> Person:
    name, sid, email = (original(str(record.get(key) or ""))[:500] for key in (":name", ":sid", ":email"))
    return Person(name or email or sid, sid=sid, email=email)
