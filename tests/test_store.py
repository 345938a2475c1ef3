from __future__ import annotations

import dataclasses
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from grader import cli
from grader.base.errors import RequestError
from grader.course.record.database import FILE_NAME
from grader.course.record.store import Key, Store
from grader.engine import rubric
from grader.labs.imu.lab import LAB
from tests.fake_results import check, lost, result

KEY = Key("alice", "s" * 64, "r" * 64, "t" * 64, "0.1.0")


def test_a_result_comes_back_as_it_was_kept_and_the_present_one_is_that_last_kept_or_recalled(tmp_path: Path) -> None:
    first = result(check(), lost(), name="Älice \ud800", notes=("<b>",))
    second, other = result(lost()), dataclasses.replace(KEY, submission_sha256="z" * 64)
    with Store(tmp_path) as store:
        store.keep(KEY, first)
    with Store(tmp_path) as store:
        store.keep(other, second)
        assert store.present() == {"alice": second}
        assert store.recall(KEY) == first
        assert store.present() == {"alice": first}


def test_an_incomplete_result_is_present_but_not_recalled_so_it_is_graded_again(tmp_path: Path) -> None:
    unjudged = result(check("not_judged", None), status="incomplete")
    with Store(tmp_path) as store:
        store.keep(KEY, unjudged)
        assert (store.recall(KEY), store.present()) == (None, {"alice": unjudged})
        assert not store.has(KEY, rubric.load(LAB))


def test_a_record_that_cannot_be_written_is_read_as_it_lies_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Store(tmp_path) as store:
        store.keep(KEY, result())
    before = {entry.name: entry.stat().st_mtime_ns for entry in tmp_path.iterdir()}
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)  # root may write anywhere
    with Store.existing(tmp_path) as archived:
        assert archived.present() == {"alice": result()}
        with pytest.raises(RequestError, match=r"results.sqlite: attempt to write a readonly database"):
            archived.keep(KEY, result(lost()))
    assert {entry.name: entry.stat().st_mtime_ns for entry in tmp_path.iterdir()} == before


def test_what_was_kept_last_before_a_kill_is_not_left_out_where_nothing_can_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = (
        "import os, sys, pathlib; from tests.test_store import KEY, Store, result\n"
        "store = Store(pathlib.Path(sys.argv[1])); store.keep(KEY, result()); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=True, cwd=Path(__file__).parents[1])
    assert (tmp_path / f"{FILE_NAME}-wal").stat().st_size
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    with Store.existing(tmp_path) as archived:
        assert archived.present() == {"alice": result()}


def test_a_damaged_record_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_bytes(b"no database at all" * 100)
    with pytest.raises(RequestError, match=r"file is not a database; free or repair it"):
        Store(tmp_path)
    assert (tmp_path / FILE_NAME).read_bytes() == b"no database at all" * 100


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE results SET record = '{}'",
        "UPDATE results SET record = 'no JSON'",
        "UPDATE results SET charts = 'x', fingerprint = x'00'",
        "INSERT INTO hand_ins VALUES ('alice', '[]')",
        "INSERT INTO adjustments VALUES (1, 'alice', 'c', 1.0, '', '', '', 'no JSON', 0, 0)",
        "DROP TABLE class",
    ],
)
def test_a_record_of_foreign_contents_is_refused_in_one_line(
    change: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Store(tmp_path) as store:
        store.keep(KEY, result(lost()))
        store._db.execute(change)
    wish = ["alice", "--criterion", "sensor_access", "--points", "3", "--comment", "x"]
    for command in (["adjust", str(tmp_path), *wish], ["export", str(tmp_path), "-f", "csv"]):
        if "charts" in change and command[0] == "export":
            continue  # neither is looked at
        assert cli.main(command) == 2, command
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"imugrade: {tmp_path}/results.sqlite: ")


def test_a_record_of_another_layout_is_refused_with_both_numbers(tmp_path: Path) -> None:
    Store(tmp_path).close()
    newer = sqlite3.connect(tmp_path / FILE_NAME)
    newer.execute("PRAGMA user_version = 7")
    newer.close()
    with pytest.raises(RequestError, match=r"another version of imugrade \(layout 7, this one reads 4\)"):
        Store(tmp_path)
