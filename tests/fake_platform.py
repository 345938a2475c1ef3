"""A fake platform, listed as a new one would be."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from grader.engine.results import Result
from grader.intake.downloads import Download
from grader.people.final_grade import HandIn, Person
from grader.platforms import registry
from grader.platforms.found import Found, Shape
from grader.platforms.platform import Help, Platform, ResultContext


def _respond(result: Result, handed: ResultContext) -> str:
    return f"made up: {result.score:g} in {handed.lab.id}\n"


def _read(download: Download) -> Shape | None:
    if "made-up.txt" not in download.top:
        return None
    found = Found("u", "uma", "Uma", download.path, ((download.place("work"), ""),), HandIn((Person("Uma"),)))
    return Shape("Made-up download", (found,))


PLATFORM = Platform(
    name="made-up",
    title="Made-up Campus",
    help=Help("Told of jobs.", ("*Take all*", "`made-up.txt`", "told of downloads"), "told of grades."),
    respond=_respond,
    read=_read,
    write=lambda final_grades, absent: f"made up: {', '.join(final_grades)}\n".encode(),
    gradebook="campus.csv",
)


@contextmanager
def listed(*does: registry.Deed) -> Iterator[None]:
    """A line of the registry for it, as long as a test lasts."""
    registry.LISTED["made-up"] = registry.Listed("tests.fake_platform", does)
    yield
    del registry.LISTED["made-up"]
