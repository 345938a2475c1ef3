"""The files of each submission, written from the record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from grader import __version__
from grader.base.errors import RequestError
from grader.course.publishing import publish_all
from grader.course.record import Key, Store
from grader.engine.chart_data import Chart, Curve, Evidence, Panel, packed
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from tests.fake_results import result

MANY = 3
LINE = Curve("x", "x", (0.0, 1.0, 2.0), (0.0, 1.0, 4.0))
CHARTS = packed((Chart("sensor_access", "What it reads", "", (Panel("", "s", "m", (LINE,)),)),))


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "out") as opened:
        for number in range(MANY):
            id_ = f"s{number:03}"
            keep(opened, FinalGrade(id_, replace(result(), submission=id_)))
        yield opened


def keep(store: Store, final_grade: FinalGrade, charts: bytes = CHARTS) -> None:
    own = replace(final_grade.result, evidence=Evidence(charts))
    store.keep(Key(final_grade.id, final_grade.id, "rubric", "traces", __version__), own)


def files(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in out.glob("submissions/*/*")}


def test_files_that_are_current_are_left_and_changed_ones_are_written_again(store: Store, tmp_path: Path) -> None:
    final_grades = store.final_grades().values()
    publish_all(tmp_path, final_grades, store, LAB)
    whole = files(tmp_path)
    assert len(whole) == 2 * MANY
    times = {path: path.stat().st_mtime_ns for path in tmp_path.glob("submissions/*/*")}
    changed, missing = tmp_path / "submissions/s000/report.html", tmp_path / "submissions/s001/result.json"
    changed.write_text("another page")
    missing.unlink()
    publish_all(tmp_path, final_grades, store, LAB)
    assert files(tmp_path) == whole
    of_others = {path for path in times if path.parent.name == "s002"}
    assert {path: path.stat().st_mtime_ns for path in of_others} == {path: times[path] for path in of_others}


def test_what_the_disk_refuses_is_told_in_one_line(store: Store, tmp_path: Path) -> None:
    (tmp_path / "submissions").write_text("a file where the folder is to be")
    with pytest.raises(RequestError, match=r"submissions.*cannot write"):
        publish_all(tmp_path, store.final_grades().values(), store, LAB)
