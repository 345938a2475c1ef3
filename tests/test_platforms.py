"""One record a platform, from which everything that lists platforms is made; a new one is forgotten nowhere."""

from __future__ import annotations

import pkgutil
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from docs import generated
from grader import cli, platforms
from grader.base.errors import GraderError
from grader.course.record.store import Key, Store
from grader.intake.downloads import Download
from grader.labs.imu.lab import LAB
from grader.people.final_grade import HandIn, Person
from grader.platforms import job, registry
from grader.platforms.classes import read_class
from grader.platforms.found import Found, Shape
from grader.platforms.platform import Help, Platform
from tests import classes
from tests.documents import site
from tests.fake_results import result
from tests.hostile import outputs

ROOT = Path(__file__).resolve().parent.parent


# --- the records --------------------------------------------------------------------------------------------------------


def test_every_module_that_ends_in_a_record_is_listed() -> None:
    modules = (f"grader.platforms.{each.name}" for each in pkgutil.iter_modules(platforms.__path__))
    assert {name for name in modules if hasattr(import_module(name), "PLATFORM")} == {
        module for module, _ in registry.LISTED.values()
    }


def test_what_a_platform_does_has_documentation() -> None:
    for name in registry.LISTED:
        each = registry.platform(name)
        assert each.name == name
        assert bool(each.help.respond) == (each.respond is not None), name
        assert bool(each.help.read[1] and each.help.read[2]) == (each.read is not None), name
        writes = each.fill is not None or each.write is not None
        assert bool(each.help.grades) == bool(each.gradebook) == writes, name


def test_the_tests_have_a_look_a_template_and_a_download_for_every_platform_that_needs_one() -> None:
    assert set(outputs.WRITERS) - set(outputs.LOOKS) == set()
    assert set(outputs.TEMPLATES) == set(registry.names("fill"))
    assert {name.partition("_")[0] for name in classes.SHAPES} == {registry.FOLDERS, *registry.names("read")}


def test_the_page_on_adding_a_platform_names_every_field() -> None:
    page = site()["contributors/platform.md"]
    assert [field.name for field in fields(Platform) if f"`{field.name}`" not in page] == []


def test_a_kit_is_written_for_the_platforms_that_tell_of_one() -> None:
    group: Any = cli.command()
    options = {option for each in group.commands["kit"].params for option in each.opts if option.startswith("--")}
    told = {
        f"--{each.name}"
        for each in registry.platforms("respond")
        if f"imugrade kit --{each.name} " in each.help.respond
    }
    assert options & {f"--{name}" for name in registry.LISTED} == told


# --- one that is new ----------------------------------------------------------------------------------------------------


def _read(download: Download) -> Shape | None:
    if "made-up.txt" not in download.top:
        return None
    found = Found("u", "uma", "Uma", download.path, ((download.place("work"), ""),), HandIn((Person("Uma"),)))
    return Shape("Made-up download", (found,))


PLATFORM = Platform(
    name="made-up",
    title="Made-up Campus",
    help=Help("Told of jobs.", ("*Take all*", "`made-up.txt`", "told of downloads"), "told of grades."),
    respond=lambda result, handed: "",
    read=_read,
    write=lambda final_grades, absent, missing: f"made up: {', '.join(final_grades)}\n".encode(),
    gradebook="campus.csv",
)


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line of the registry for a platform that this module describes as a new one would be."""
    monkeypatch.setitem(registry.LISTED, "made-up", (__name__, ("respond", "read", "write")))


@pytest.mark.usefixtures("made_up")
def test_the_documentation_describes_a_new_platform() -> None:
    assert "| `made-up` | Made-up Campus | working folder | standard output |" in generated.ci_platforms()
    assert "## Made-up Campus\n\nTold of jobs." in generated.ci_platforms()
    assert "| Made-up Campus, *Take all* | `made-up.txt` | told of downloads |" in generated.downloads()
    assert "- **Made-up Campus**: told of grades." in generated.gradebooks()


@pytest.mark.usefixtures("made_up")
def test_a_class_is_read_from_a_new_platform_grades_go_to_it_and_a_job_knows_it(tmp_path: Path) -> None:
    (tmp_path / "in" / "work").mkdir(parents=True)
    (tmp_path / "in" / "made-up.txt").touch()
    with Store(tmp_path) as store:
        store.keep(Key("alice", "s", "r", "t", "0"), result())
    for shape in (None, "made-up"):
        (entry,) = read_class([tmp_path / "in"], LAB.files, shape).entries
        assert entry.name == "Uma"
    assert cli.main(["export", str(tmp_path), "--format", "made-up"]) == 0
    assert job.named("made-up") is PLATFORM
    assert (tmp_path / "campus.csv").read_text() == "made up: alice\n"


@pytest.mark.usefixtures("made_up")
def test_a_line_that_promises_what_the_record_does_not_do_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module(__name__), "PLATFORM", replace(PLATFORM, respond=None, write=None))
    with pytest.raises(GraderError, match="its line in the registry"):
        job.named("made-up")
