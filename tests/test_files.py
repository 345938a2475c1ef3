"""Tests of file writing: a file is complete or absent, and a device is never replaced."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

import pytest

from grader.base.errors import RequestError
from grader.base.files import write_whole


def test_a_file_takes_the_place_of_the_one_before_and_of_a_link_to_another(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("other")
    (tmp_path / "link").symlink_to("other")
    for name in ("new", "new", "link"):
        write_whole(tmp_path / name, "ü")
        assert (tmp_path / name).read_bytes() == "ü".encode()
        assert not (tmp_path / name).is_symlink()
    assert (tmp_path / "other").read_text() == "other"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "new", "other"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without pipes in folders")
def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    os.mkfifo(pipe := tmp_path / "pipe")
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    write_whole(pipe, "through it")
    reader.join(10)
    assert read == ["through it"]
    assert pipe.is_fifo()


@pytest.mark.skipif(sys.platform == "win32", reason="a system without /dev")
def test_standard_output_is_written_to_by_its_name(capfd: pytest.CaptureFixture[str]) -> None:
    before = os.lstat("/dev/stdout")
    write_whole(Path("/dev/stdout"), "told")
    assert capfd.readouterr().out == "told"
    assert os.lstat("/dev/stdout").st_ino == before.st_ino


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RequestError, match="cannot write it"):
        write_whole(tmp_path / "file" / "result.json", "")
