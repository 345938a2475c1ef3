"""The files of a class, written beside the process that keeps the record."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from grader import __version__
from grader.base.errors import RequestError
from grader.course import publishing
from grader.course.publishing import Publisher, publish_all
from grader.course.record import Key, Store
from grader.engine.chart_data import Chart, Curve, Evidence, Panel, packed
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from tests.fake_results import result

MANY = 120
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


def write_beside(out: Path, store: Store) -> bool:
    """Write all in processes of their own; whether there were any."""
    with Publisher(out, store, LAB, processes=2) as publisher:
        for final_grade in store.final_grades().values():
            publisher.put(final_grade)
    return publisher._writers is not None


def files(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in out.glob("submissions/*/*")}


def test_many_files_are_the_same_whoever_writes_them(store: Store, tmp_path: Path) -> None:
    final_grades, beside, here = store.final_grades().values(), tmp_path / "beside", tmp_path / "here"
    assert write_beside(beside, store)
    kept = {each.id: store.page_digest(each.id) for each in final_grades}
    store.keep_page_digests(dict.fromkeys(kept, ""))
    publish_all(here, final_grades, store, LAB)
    assert len(files(here)) == 2 * MANY
    assert files(beside) == files(here)
    assert kept == {each.id: store.page_digest(each.id) for each in final_grades}


def test_where_a_writer_is_killed_its_files_are_written_all_the_same(
    store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = publishing._writers

    def short_lived(processes: int) -> ProcessPoolExecutor:
        executor = start(processes)
        for pid in executor._processes:
            os.kill(pid, signal.SIGKILL)
        return executor

    monkeypatch.setattr(publishing, "_writers", short_lived)
    publish_all(tmp_path / "here", store.final_grades().values(), store, LAB)
    store.keep_page_digests(dict.fromkeys(store.present(), ""))
    assert write_beside(tmp_path / "beside", store)
    assert files(tmp_path / "beside") == files(tmp_path / "here")


def test_what_the_disk_refuses_a_writer_is_told_in_one_line(store: Store, tmp_path: Path) -> None:
    (tmp_path / "submissions").write_text("a file where the folder is to be")
    with pytest.raises(RequestError, match=r"submissions.*cannot write"):
        write_beside(tmp_path, store)
