"""What stands in place of a student's file, and names in the code pages of East Asian Windows."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest

from grader.intake import Submission, read_submission
from grader.labs.imu.lab import LAB

POINTER = (
    b"version https://git-lfs.github.com/spec/v1\n"
    b"oid sha256:0000000000000000000000000000000000000000000000000000000000000001\nsize 1290\n"
)


def read(folder: Path, **files: bytes) -> Submission:
    for name, content in {"imu_reader.py": b"x = 1\n", **files}.items():
        (folder / name).write_bytes(content)
    return read_submission(folder, LAB.files)


@pytest.mark.parametrize(
    ("name", "content", "note"),
    [
        ("filters.py", POINTER, "it is a Git LFS pointer and not the file (run `git lfs push --all origin`"),
        ("filters.py", b"\n<!DOCTYPE html><title>Log in</title>", "it is a web page, such as a login page"),
        ("filters.py", bytes(4096), "it holds null bytes only"),
        (".filters.py.icloud", b"bplist00\xd3", "iCloud had not downloaded the file"),
    ],
)
def test_a_placeholder_is_named_and_counts_as_missing(tmp_path: Path, name: str, content: bytes, note: str) -> None:
    submission = read(tmp_path, **{name: content})
    assert list(submission.files) == ["imu_reader.py"]
    assert [each.startswith(f"Not read, because {note}") for each in submission.notes] == [True]
    assert submission.notes[0].endswith(f"{name}.")


def test_an_empty_required_file_is_told_and_an_empty_helper_is_not(tmp_path: Path) -> None:
    submission = read(tmp_path, **{"filters.py": b"\n", "settings.py": b""})
    assert submission.notes == ("filters.py is empty: save it, check its size and hand it in again.",)
    assert set(submission.files) == {"imu_reader.py", "filters.py", "settings.py"}


def test_a_name_of_western_windows_keeps_its_letters(tmp_path: Path) -> None:
    raw = "Müller/filters.py".encode("cp437")
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("MXller/filters.py", "x = 1\n")
        archive.writestr("MXller/deeper/notes.txt", "x")
    (tmp_path / "lab.zip").write_bytes(buffer.getvalue().replace(b"MXller/", raw[:7]))
    assert read_submission(tmp_path / "lab.zip", LAB.files).folder == "Müller"
