"""Another lab is graded, reported and exported by the same engine, with no line of it changed."""

from __future__ import annotations

import json
import pickle
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path

import pytest

from grader.base.errors import GraderError
from grader.engine import rubric
from grader.engine.faults import catalogue
from grader.engine.grader import Marker
from grader.engine.results import Result, from_dict, to_dict
from grader.intake.submission import Submission
from grader.people.final_grade import FinalGrade
from grader.platforms.gradebook import gradebook
from grader.platforms.junit import junit
from grader.report.pages import index_page, report_page
from tests.labs.toy.lab import LAB

SOUND = {
    "convert.py": b"def to_celsius(fahrenheit):\n    return (fahrenheit - 32) / 1.8\n",
    "average.py": b"from convert import to_celsius\n\ndef mean_celsius(fahrenheit):\n    return to_celsius(fahrenheit).mean()\n",
}
FORGETFUL = {**SOUND, "convert.py": b"def to_celsius(fahrenheit):\n    return fahrenheit / 1.8\n"}


@pytest.fixture(scope="module")
def marker() -> Iterator[Marker]:
    chosen = rubric.load(LAB)
    with Marker(chosen, LAB.truth(None, chosen.settings)) as opened:
        yield opened


def graded(marker: Marker, files: dict[str, bytes]) -> Result:
    return marker.mark(Submission("ann", "ann", files, (), "ready", "0" * 64))


@pytest.mark.plain
def test_a_sound_submission_gets_all_points(marker: Marker) -> None:
    result = graded(marker, SOUND)
    assert (result.status, result.score, result.max_score) == ("graded", 10.0, 10.0)
    packages = result.provenance.keys()
    assert {"python", "numpy"} < packages
    assert "mujoco" not in packages


def test_one_fault_costs_once_and_is_reported_and_exported_under_the_labs_own_name(marker: Marker) -> None:
    """Who averages with a wrong conversion averages right: a sound stand-in takes its place."""
    result = graded(marker, FORGETFUL)
    assert [criterion.points for criterion in result.criteria] == [0.0, 4.0]
    assert result.misconceptions == ("no-offset",)
    assert from_dict(json.loads(json.dumps(to_dict(result)))) == result
    final_grade = FinalGrade("ann", result)
    page = report_page(final_grade)
    assert "Lab 0 · Temperatures" in page
    assert "Lab 0, Step 1" in page
    assert "Lab 04-01" not in page + index_page({"ann": final_grade}) + junit(result, datetime.now(timezone.utc))
    assert "conversion" in gradebook({"ann": final_grade}).splitlines()[0]


def test_an_exception_is_told_by_this_labs_own_catalogue(marker: Marker) -> None:
    """Another lab has a name for an index beyond the end; this one has none."""
    files = {**SOUND, "convert.py": b"def to_celsius(fahrenheit):\n    return fahrenheit[len(fahrenheit)]\n"}
    result = graded(marker, files)
    (lost,) = result.criteria[0].checks
    assert (result.status, lost.outcome, lost.misconceptions) == ("graded", "error", ("raises",))


def test_a_catalogue_without_what_the_engine_finds_out_is_refused_by_name(tmp_path: Path) -> None:
    text = (LAB.folder / "faults.yaml").read_text(encoding="utf-8")
    (tmp_path / "faults.yaml").write_text(text.replace("  raises:", "  stumbles:"), encoding="utf-8")
    lab = replace(LAB)
    lab.__dict__["folder"] = tmp_path
    with pytest.raises(GraderError, match=r"faults\.yaml of Lab 0 lacks raises"):
        catalogue(lab)


def test_it_travels_by_its_name() -> None:
    assert pickle.loads(pickle.dumps(LAB)) is LAB


def test_its_rubric_has_its_own_parts_and_keys_alone() -> None:
    text = (LAB.folder / "rubric.yaml").read_bytes()
    with pytest.raises(rubric.RubricError, match="sensor_access"):
        rubric.parse(LAB, text.replace(b"id: conversion", b"id: sensor_access"))
    with pytest.raises(rubric.RubricError, match="unknown key 'model' in the rubric"):
        rubric.parse(LAB, text + b"model: {path: humanoid.xml}\n")
