"""A fake platform, listed as a new one would be: `python -m tests.fake_platform` prints what knows it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path

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


def who_knows_it() -> dict[str, object]:
    """What lists platforms, and what a test finds missing. All of it is imported after the platform is listed."""
    from docs import generated
    from grader import cli
    from tests import test_platforms
    from tests.hostile import outputs

    return {
        **{
            command: _printed(lambda command=command: cli.main([command, "--help"]))
            for command in ("ci", "export", "grade")
        },
        "platforms": generated.ci_platforms(),
        "classes": f"{generated.downloads()}\n{generated.gradebooks()}",
        "commands": generated.commands(),
        "writers": sorted(outputs.WRITERS),
        "unread": sorted(test_platforms.unread()),
        "unnamed in the README": test_platforms.unnamed(
            (Path(__file__).parent.parent / "README.md").read_text("utf-8")
        ),
    }


def _printed(run: Callable[[], object]) -> str:
    with redirect_stdout(StringIO()) as out:
        run()
    return " ".join(out.getvalue().split())


if __name__ == "__main__":
    with listed("respond", "read", "write"):
        print(json.dumps(who_knows_it()))
