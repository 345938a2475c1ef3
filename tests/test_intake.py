"""What was handed in is found, bounded and never trusted."""

from __future__ import annotations

import io
import os
import socket
import stat
import struct
import tarfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.intake import Submission, archives, file_budget, folders, names, read_submission
from grader.labs.imu.lab import LAB
from grader.platforms import classes
from grader.platforms.classes import read_class

HANDED_IN = {"imu_reader.py": b"import numpy\n", "noisy_imu.py": b"# noise\n", "filters.py": b"# filter\n"}
POSIX = pytest.mark.skipif(os.name != "posix", reason="needs links, pipes and byte names of POSIX")

Files = Mapping[str, bytes]
Pack = Callable[[Path, Files], Path]


def below(folder: str, files: Files = HANDED_IN) -> dict[str, bytes]:
    return {f"{folder}/{name}": data for name, data in files.items()}


def as_folder(root: Path, files: Files) -> Path:
    folder = root / "alice"
    folder.mkdir()
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def zipped(files: Files) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return buffer.getvalue()


def tarred(files: Files, mode: str = "w:gz") -> bytes:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode=mode) as archive:  # type: ignore[call-overload]
        for name, data in files.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
    return buffer.getvalue()


def saved(root: Path, name: str, data: bytes) -> Path:
    (root / name).write_bytes(data)
    return root / name


def as_zip(root: Path, files: Files) -> Path:
    return saved(root, "alice.zip", zipped(files))


def as_tgz(root: Path, files: Files) -> Path:
    return saved(root, "alice.tar.gz", tarred(files))


def as_tar(root: Path, files: Files) -> Path:
    return saved(root, "alice.tar", tarred(files, "w"))


EVERY_WAY = pytest.mark.parametrize("pack", [as_folder, as_zip, as_tgz, as_tar])
ARCHIVED = pytest.mark.parametrize("pack", [as_zip, as_tgz, as_tar])


def read_zip(root: Path, build: Callable[[zipfile.ZipFile], None]) -> Submission:
    with zipfile.ZipFile(root / "alice.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in HANDED_IN.items():
            archive.writestr(name, data)
        build(archive)
    return read_submission(root / "alice.zip", LAB.files)


def read_tar(root: Path, *extra: tarfile.TarInfo) -> Submission:
    with tarfile.open(root / "alice.tar.gz", "w:gz") as archive:
        for info in extra:
            archive.addfile(info)
        for name, data in HANDED_IN.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
    return read_submission(root / "alice.tar.gz", LAB.files)


# ---- where the lab's files are ----


@EVERY_WAY
@pytest.mark.parametrize("folder", [".", "lab", "a/b/c/d"])
def test_the_labs_folder_is_found_up_to_four_levels_down(tmp_path: Path, pack: Pack, folder: str) -> None:
    submission = read_submission(pack(tmp_path, below(folder)), LAB.files)
    assert (submission.status, submission.id, submission.name) == ("ready", "alice", "alice")
    assert submission.files == HANDED_IN
    assert submission.notes == (("The lab's files were found in a/b/c/d.",) if folder == "a/b/c/d" else ())


@EVERY_WAY
def test_five_levels_down_nothing_is_found(tmp_path: Path, pack: Pack) -> None:
    submission = read_submission(pack(tmp_path, below("a/b/c/d/e")), LAB.files)
    assert (submission.status, submission.files) == (
        "empty",
        {f"a/b/c/d/e/{name}": text for name, text in HANDED_IN.items()},
    )
    assert submission.notes == (
        "No .py or .ipynb file was found up to 4 folders down.",
        "There is code further down, in a/b/c/d/e; hand in that folder itself.",
    )


def test_a_folder_and_its_archives_have_one_hash_and_other_bytes_another(tmp_path: Path) -> None:
    hashes = {
        read_submission(pack(tmp_path, HANDED_IN), LAB.files).sha256 for pack in (as_folder, as_zip, as_tgz, as_tar)
    }
    assert len(hashes) == 1
    os.utime(tmp_path / "alice" / "filters.py", (0, 0))
    hashes.add(read_submission(tmp_path / "alice", LAB.files).sha256)
    assert len(hashes) == 1
    hashes.add(read_submission(as_zip(tmp_path, {**HANDED_IN, "filters.py": b"#"}), LAB.files).sha256)
    hashes.add(read_submission(as_zip(tmp_path, {**HANDED_IN, "filters.pyfilter": b""}), LAB.files).sha256)
    assert len(hashes) == 3


@EVERY_WAY
def test_an_empty_submission_is_empty(tmp_path: Path, pack: Pack) -> None:
    assert read_submission(pack(tmp_path, {}), LAB.files).status == "empty"
    assert read_submission(saved(tmp_path, "x.zip", zipped({"essay.txt": b"x"})), LAB.files).status == "empty"


@EVERY_WAY
def test_what_lies_beside_the_labs_folder_comes_with_it_by_its_path_there(tmp_path: Path, pack: Pack) -> None:
    beside = {"config.py": b"DT = 0.002", "tools/io.py": b"", "imu_data.png": b"\x89PNG", "run.ipynb": b"{}"}
    above = {"hw/filters.py/x.py": b"", "config.py": b"above", "settings.toml": b"", "old/try.ipynb": b"{}"}
    files = {**below("hw/src"), **below("hw", beside), **above, "hw/__init__.py": b"raise SystemExit"}
    submission = read_submission(pack(tmp_path, files), LAB.files)
    assert submission.files == {**HANDED_IN, **beside, "settings.toml": b""}
    assert submission.origin("config.py") == "hw/config.py"
    assert submission.origin("settings.toml") == "settings.toml"
    assert submission.origin("imu_reader.py") == "hw/src/imu_reader.py"


def test_of_files_with_one_name_the_nearest_to_the_lab_is_taken(tmp_path: Path) -> None:
    three = {"far.py": b"3", "near.py": b"3", "here.py": b"3"}
    two = {"hw/near.py": b"2", "hw/here.py": b"2"}
    submission = read_submission(
        as_zip(tmp_path, {**three, **two, "hw/src/here.py": b"1", **below("hw/src")}), LAB.files
    )
    assert submission.files == {**HANDED_IN, "far.py": b"3", "near.py": b"2", "here.py": b"1"}


def test_the_labs_files_in_several_folders_are_one_submission(tmp_path: Path) -> None:
    files = {
        "step2/imu_reader.py": b"2",
        "step5/noisy_imu.py": b"5",
        "step6/filters.py": b"6",
        "step6/b/filters.py": b"b",
    }
    submission = read_submission(as_zip(tmp_path, files), LAB.files)
    assert submission.files == {
        "imu_reader.py": b"2",
        "step5/noisy_imu.py": b"5",
        "step6/filters.py": b"6",
    }
    assert submission.notes == (
        "More than one folder holds the lab's files: step2 was graded, not step6/b.",
        "The lab's files were found in step2; looked at with them: step5/noisy_imu.py, step6/filters.py.",
    )


def test_of_two_folders_the_shallower_one_is_taken_and_the_other_named(tmp_path: Path) -> None:
    submission = read_submission(as_zip(tmp_path, {"new/filters.py": b"new", **below("old/lab")}), LAB.files)
    assert submission.files == {"filters.py": b"new"}
    assert submission.notes == ("More than one folder holds the lab's files: new was graded, not old/lab.",)


def test_of_two_folders_side_by_side_the_more_complete_one_is_taken(tmp_path: Path) -> None:
    submission = read_submission(
        as_zip(tmp_path, {"a/filters.py": b"a", **dict.fromkeys(("a/1.py", "a/2.py", "a/3.py"), b""), **below("b")}),
        LAB.files,
    )
    assert submission.files == HANDED_IN
    assert submission.notes == ("More than one folder holds the lab's files: b was graded, not a.",)


@EVERY_WAY
def test_what_tools_leave_behind_is_dropped_without_a_word(tmp_path: Path, pack: Pack) -> None:
    litter = [
        "__MACOSX/._filters.py",
        ".git/config",
        "lab/__pycache__/filters.py",
        ".venv/lib/x.py",
        "node_modules/x.py",
        "lab/.ipynb_checkpoints/lab-checkpoint.ipynb",
        "lab/.DS_Store",
        "lab/Thumbs.db",
    ]
    submission = read_submission(pack(tmp_path, {**dict.fromkeys(litter, b"x"), **below("lab")}), LAB.files)
    assert (submission.files, submission.notes) == (HANDED_IN, ())


# ---- archives in archives ----


def nested(times: int) -> bytes:
    data = zipped(below("lab"))
    for n in range(1, times):
        data = zipped({f"inner{n}.zip": data})
    return data


@pytest.mark.parametrize("times", [1, 2])
def test_an_archive_alone_in_a_folder_is_opened_twice_at_most(tmp_path: Path, times: int) -> None:
    submission = read_submission(as_folder(tmp_path, {"Homework/lab.zip": nested(times), ".DS_Store": b"x"}), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes[0] == "The submission is in Homework/lab.zip, which was opened."
    assert len(submission.notes) == times


def test_a_third_archive_is_not_opened(tmp_path: Path) -> None:
    submission = read_submission(as_folder(tmp_path, {"lab.zip": nested(3)}), LAB.files)
    assert submission.status == "unreadable"
    assert submission.notes == ("inner1.zip is an archive in an archive in an archive; hand in the files.",)


def test_one_of_two_archives_is_not_picked(tmp_path: Path) -> None:
    submission = read_submission(as_folder(tmp_path, {"lab.zip": nested(1), "old.zip": nested(1)}), LAB.files)
    assert (submission.status, submission.notes) == (
        "empty",
        (
            "No .py or .ipynb file was found up to 4 folders down.",
            "Not opened, because an archive must be alone in its folder: lab.zip, old.zip.",
        ),
    )


def test_an_archive_of_another_kind_is_unreadable(tmp_path: Path) -> None:
    submission = read_submission(as_folder(tmp_path, {"lab.rar": b"Rar!"}), LAB.files)
    assert submission.status == "unreadable"
    assert submission.notes == (
        "lab.rar is an archive of a kind that is not opened; hand in a .zip, or ask whoever marks to unpack it.",
    )
    alone = read_submission(saved(tmp_path, "bob.7z", b"7z"), LAB.files)
    assert (alone.status, alone.notes) == (
        "unreadable",
        ("bob.7z is an archive of a kind that is not opened; hand in a .zip, or ask whoever marks to unpack it.",),
    )
    renamed = read_submission(saved(tmp_path, "eve.zip", b"Rar!\x1a\x07\x01\0" * 9), LAB.files)
    assert renamed.notes[0].startswith("eve.zip is an archive of a kind that is not opened; hand in a .zip")


# ---- names that lead elsewhere ----


@ARCHIVED
@pytest.mark.parametrize("name", ["../evil.py", "/etc/evil.py", "a/../../evil.py", "C:/evil.py", "c:evil.py"])
def test_a_path_out_of_the_archive_is_not_read(tmp_path: Path, pack: Pack, name: str) -> None:
    submission = read_submission(pack(tmp_path, {name: b"evil", **HANDED_IN}), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == (f"Not read, because the path leads out of the archive or names a drive: {name}.",)
    assert len(list(tmp_path.iterdir())) == 1


def test_a_path_with_a_nul_is_not_cut_there(tmp_path: Path) -> None:
    data = zipped({"filters.py_x": b"evil", **HANDED_IN}).replace(b"filters.py_x", b"filters.py\0x")
    submission = read_submission(saved(tmp_path, "alice.zip", data), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == (
        "Not read, because the path leads out of the archive or names a drive: filters.py\\x00x.",
    )


def test_backslashes_of_windows_tools_separate_folders(tmp_path: Path) -> None:
    def packed(system: int) -> Submission:
        with zipfile.ZipFile(tmp_path / "alice.zip", "w") as archive:
            for name, data in HANDED_IN.items():
                info = zipfile.ZipInfo("x")
                info.filename, info.create_system = f"lab\\{name}", system
                archive.writestr(info, data)
        return read_submission(tmp_path / "alice.zip", LAB.files)

    assert packed(0).files == HANDED_IN
    assert packed(3).status == "empty"


def test_names_that_differ_in_case_alone_are_one(tmp_path: Path) -> None:
    submission = read_submission(as_zip(tmp_path, {"Filters.py": b"other", **HANDED_IN}), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == (
        "Not read, because another name differs from it in upper and lower case only: Filters.py.",
    )


@ARCHIVED
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_of_a_name_that_stands_twice_the_last_one_counts(tmp_path: Path, pack: Pack) -> None:
    submission = read_submission(pack(tmp_path, {**HANDED_IN, "./filters.py": b"last"}), LAB.files)
    assert submission.files == {**HANDED_IN, "filters.py": b"last"}
    assert submission.notes == (
        "Not read, because the name stands twice in the archive, and the last one counts: filters.py.",
    )


@POSIX
def test_names_that_are_not_utf8_do_no_harm(tmp_path: Path) -> None:
    folder = os.fsencode(as_folder(tmp_path, {}))
    os.mkdir(folder + b"/Mar\xeda")
    for name, data in HANDED_IN.items():
        with open(folder + b"/Mar\xeda/" + name.encode(), "wb") as stream:
            stream.write(data)
    with open(folder + b"/Mar\xeda/r\xe9sum\xe9.txt", "wb"):
        pass
    submission = read_submission(tmp_path / "alice", LAB.files)
    assert submission.files == {"r_sum_.txt": b"", **HANDED_IN}
    os.rename(folder, folder + b"\xff")
    (entry,) = read_class([tmp_path], LAB.files).entries
    assert (entry.id, entry.name) == ("alice_", "alice\ufffd")
    assert entry.read().files == submission.files


@ARCHIVED
@pytest.mark.parametrize("name", ["d/" * 16 + "x.py", "x" * 256 + ".py", "é" * 128 + ".py", "/".join(["y" * 200] * 6)])
def test_a_path_too_long_or_too_deep_is_left_out(tmp_path: Path, pack: Pack, name: str) -> None:
    submission = read_submission(pack(tmp_path, {name: b"x", **HANDED_IN}), LAB.files)
    assert submission.files == HANDED_IN
    assert len(submission.notes) == 1
    assert submission.notes[0].startswith("Not read, because the path is too long or too deep: ")
    assert len(submission.notes[0]) < 250


def test_records_that_take_quadratic_time_are_bounded_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MAX_HEADER_WORK", 3 * 1000**2)
    extra = []
    for n in range(4):
        info = tarfile.TarInfo(f"{n}.csv")
        info.pax_headers = {"comment": "x" * 985}  # with its length and name 1,000 bytes
        extra.append(info)
    submission = read_tar(tmp_path, *extra)
    assert submission.notes[-1] == "alice.tar.gz was read in part: its names and attributes are too long."
    monkeypatch.undo()
    assert read_submission(tmp_path / "alice.tar.gz", LAB.files).notes == ()


# ---- links and devices ----


@POSIX
def test_links_pipes_and_sockets_of_a_folder_are_not_opened(tmp_path: Path) -> None:
    (tmp_path / "secret").mkdir()
    secret = saved(tmp_path / "secret", "solution.py", b"secret")
    folder = as_folder(tmp_path, HANDED_IN)
    (folder / "a.py").symlink_to(secret)
    (folder / "b").symlink_to(secret.parent)
    (folder / "c.py").symlink_to(folder / "c.py")
    os.mkfifo(folder / "pipe.py")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(os.path.relpath(folder / "socket"))
        submission = read_submission(folder, LAB.files)
    assert submission.files == HANDED_IN
    assert sorted(submission.notes) == [
        "Not read, because devices, pipes and sockets are never opened: pipe.py, socket.",
        "Not read, because links are never followed: a.py, b, c.py.",
    ]


@POSIX
def test_a_link_in_the_place_of_a_listed_file_is_not_followed(tmp_path: Path) -> None:
    secret = saved(tmp_path, "secret.py", b"secret")
    (tmp_path / "link.py").symlink_to(secret)
    with pytest.raises(OSError, match="symbolic"):
        folders._read(str(tmp_path / "link.py"))


def test_a_file_that_may_not_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = as_folder(tmp_path, {**HANDED_IN, "locked.csv": b"x"})
    opened = os.open

    def refusing(path: str, flags: int) -> int:  # root, as whom tests may run, is refused nothing
        if path.endswith("locked.csv"):
            raise PermissionError(13, "Permission denied")
        return opened(path, flags)

    monkeypatch.setattr(os, "open", refusing)
    assert read_submission(folder, LAB.files).notes == (
        "Not read, because the system refused it (Permission denied): locked.csv.",
    )


def test_links_and_devices_of_a_zip_are_not_read(tmp_path: Path) -> None:
    def build(archive: zipfile.ZipFile) -> None:
        for name, kind in (("link.py", stat.S_IFLNK), ("pipe.py", stat.S_IFIFO), ("folder", stat.S_IFDIR)):
            info = zipfile.ZipInfo(name)
            info.create_system, info.external_attr = 3, (kind | 0o777) << 16
            archive.writestr(info, "/etc/passwd")

    submission = read_zip(tmp_path, build)
    assert submission.files == HANDED_IN
    assert submission.notes == (
        "Not read, because links are never followed: link.py.",
        "Not read, because devices, pipes and sockets are never opened: pipe.py.",
    )


def test_links_and_devices_of_a_tar_are_not_read(tmp_path: Path) -> None:
    kinds = {
        "soft.py": tarfile.SYMTYPE,
        "hard.py": tarfile.LNKTYPE,
        "pipe.py": tarfile.FIFOTYPE,
        "disk.py": tarfile.BLKTYPE,
        "tty.py": tarfile.CHRTYPE,
    }
    extra = []
    for name, kind in kinds.items():
        info = tarfile.TarInfo(name)
        info.type, info.linkname = kind, "/etc/passwd"
        extra.append(info)
    submission = read_tar(tmp_path, *extra)
    assert submission.files == HANDED_IN
    assert submission.notes == (
        "Not read, because links are never followed: soft.py, hard.py.",
        "Not read, because devices, pipes and sockets are never opened: pipe.py, disk.py, tty.py.",
    )


def test_a_file_over_the_limit_is_left_out(tmp_path: Path) -> None:
    folder = as_folder(tmp_path, HANDED_IN)
    with open(folder / "video.mp4", "wb") as stream:
        stream.truncate(file_budget.MAX_FILE + 1)
    submission = read_submission(folder, LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == ("Not read, because the file is larger than 16 MB: video.mp4.",)


# ---- bounds ----


@EVERY_WAY
def test_data_never_crowds_out_code(tmp_path: Path, pack: Pack, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_budget, "MAX_FILES", 5)
    monkeypatch.setattr(file_budget, "Room", lambda files=5, bytes=1000: SimpleNamespace(files=files, bytes=bytes))
    data = {f"data/{n:02}.csv": b"x" for n in range(20)}
    submission = read_submission(pack(tmp_path, {**data, **HANDED_IN}), LAB.files)
    assert len(submission.files) == 5 + 3
    assert submission.files.items() >= HANDED_IN.items()
    assert submission.notes == (
        "Not read, because the submission holds more than 2,000 files or 64 MB:"
        " data/05.csv, data/06.csv, data/07.csv and 12 more.",
    )


@EVERY_WAY
@pytest.mark.parametrize("folder", ["", "lab/"])
def test_other_code_never_crowds_out_the_required_files(tmp_path: Path, pack: Pack, folder: str) -> None:
    other = {f"{folder}m{n:04}.py": b"x = 1\n" for n in range(3_000)}
    required = {f"{folder}{name}": content for name, content in HANDED_IN.items()}
    submission = read_submission(pack(tmp_path, {**other, **required}), LAB.files)
    assert submission.files.items() >= HANDED_IN.items()
    assert len(submission.files) == len(HANDED_IN) + 1_000


def test_the_limits_are_the_promised_ones() -> None:
    rooms = file_budget.FileBudget()._room.values()
    assert sum(room.files for room in rooms) == 2_000
    assert sum(room.bytes for room in rooms) == 64 * file_budget.MB
    assert file_budget.MAX_FILE == 16 * file_budget.MB


def overlapping(times: int) -> bytes:
    """A zip whose entries all point at the same megabyte of compressed zeros: little data that claims to be much."""
    data = zipped({"zeros.bin": bytes(file_budget.MB)})
    start, end = data.index(b"PK\1\2"), data.index(b"PK\5\6")
    listing = data[start:end] * times
    return data[:start] + listing + struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, times, times, len(listing), start, 0)


def test_a_bomb_costs_no_more_than_the_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MAX_UNPACKED", 20 * file_budget.MB)
    found = archives.gather_archive(io.BytesIO(overlapping(2_000)), "bomb.zip")
    assert len(found.left.get(file_budget.TWICE, [])) + 1 <= 20
    # Pythons that see the overlap refuse each entry; others unpack until the limit.
    assert len(found.left.get(file_budget.DAMAGED, [])) >= 1_999 or found.remarks == [
        "bomb.zip was read in part: it unpacks to more than 20 MB."
    ]
    assert found.broken


def test_a_file_that_claims_to_be_small_is_cut_off(tmp_path: Path) -> None:
    data = bytearray(zipped({"zeros.bin": bytes(file_budget.MAX_FILE + file_budget.MB), **HANDED_IN}))
    central = data.index(b"PK\1\2")
    data[central + 24 : central + 28] = struct.pack("<L", 10)
    submission = read_submission(saved(tmp_path, "alice.zip", bytes(data)), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == ("Not read, because the file is damaged in the archive: zeros.bin.",)


def test_a_table_of_contents_of_any_claimed_size_is_not_read_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archives, "MAX_DIRECTORY", 100_000)
    many = {f"{n}": b"" for n in range(3_000)}
    submission = read_submission(as_zip(tmp_path, {**many, **HANDED_IN}), LAB.files)
    assert submission.status == "unreadable"
    assert submission.notes == ("alice.zip is not a readable zip or tar archive; make it again.",)


def test_a_sparse_file_of_a_tar_is_not_filled_with_zeros(tmp_path: Path) -> None:
    info = tarfile.TarInfo("huge.py")
    info.pax_headers = {"GNU.sparse.major": "0", "GNU.sparse.size": "1000", "GNU.sparse.map": "0,0"}
    with tarfile.open(tmp_path / "alice.tar", "w", format=tarfile.PAX_FORMAT) as archive:
        archive.addfile(info)
        for name, data in HANDED_IN.items():
            plain = tarfile.TarInfo(name)
            plain.size = len(data)
            archive.addfile(plain, io.BytesIO(data))
    submission = read_submission(tmp_path / "alice.tar", LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == ("Not read, because the file is stored with gaps: huge.py.",)


# ---- damage ----


def test_an_encrypted_zip_is_unreadable(tmp_path: Path) -> None:
    data = bytearray(zipped(HANDED_IN))
    for magic, flags in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
        at = data.find(magic)
        while at >= 0:
            data[at + flags] |= 1
            at = data.find(magic, at + 1)
    submission = read_submission(saved(tmp_path, "alice.zip", bytes(data)), LAB.files)
    assert submission.status == "unreadable"
    assert submission.notes == (
        "No .py or .ipynb file was found up to 4 folders down.",
        "Not read, because the file is encrypted: imu_reader.py, noisy_imu.py, filters.py.",
    )


def test_a_file_with_a_wrong_checksum_is_named_and_the_others_count(tmp_path: Path) -> None:
    data = bytearray(zipped(HANDED_IN))
    data[data.index(b"imu_reader.py") + len("imu_reader.py") + 2] ^= 0xFF
    submission = read_submission(saved(tmp_path, "alice.zip", bytes(data)), LAB.files)
    assert (submission.status, sorted(submission.files)) == ("ready", ["filters.py", "noisy_imu.py"])
    assert submission.notes == ("Not read, because the file is damaged in the archive: imu_reader.py.",)


@pytest.mark.parametrize("kept", [0, 1, 2, 30, 0.5, 0.9])
def test_a_truncated_zip_is_unreadable(tmp_path: Path, kept: float) -> None:
    data = zipped(HANDED_IN)
    cut = data[: int(kept if kept >= 1 else len(data) * kept)]
    submission = read_submission(saved(tmp_path, "alice.zip", cut), LAB.files)
    assert submission.status == "unreadable"
    assert submission.notes == ("alice.zip is not a readable zip or tar archive; make it again.",)


def test_what_comes_before_the_end_of_a_truncated_tar_counts(tmp_path: Path) -> None:
    noise = os.urandom(200_000)
    data = tarred({**HANDED_IN, "noise.bin": noise})
    submission = read_submission(saved(tmp_path, "alice.tar.gz", data[: len(data) // 2]), LAB.files)
    assert submission.files == HANDED_IN
    assert submission.notes == ("alice.tar.gz is damaged; the files before the damage were read.",)


@POSIX
def test_what_is_neither_file_nor_folder_is_unreadable(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.zip")
    submission = read_submission(tmp_path / "pipe.zip", LAB.files)
    assert submission.notes == ("pipe.zip is neither a file nor a folder; hand in a folder or a .zip of it.",)


@pytest.mark.parametrize("name", ["none", "a\0b", "no/such/place.zip"])
def test_a_path_to_nothing_is_a_wrong_request(tmp_path: Path, name: str) -> None:
    with pytest.raises(RequestError, match=r"there is no such file or folder; check the path$"):
        read_submission(tmp_path / name, LAB.files)
    with pytest.raises(RequestError, match=r"there is no such file or folder; check the path$"):
        read_class([tmp_path / name], LAB.files)


SEEDS = [zipped(below("lab")), tarred(below("lab")), tarred(HANDED_IN, "w"), nested(2)]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.binary(max_size=600)
    | st.builds(
        lambda seed, edits, cut: bytes_with(SEEDS[seed], edits)[: cut or None],
        st.integers(0, 3),
        st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 255)), max_size=6),
        st.integers(0, 2000),
    ),
    st.sampled_from(["x.zip", "x.tar.gz", "x.tar"]),
)
def test_any_bytes_are_a_submission(tmp_path: Path, data: bytes, name: str) -> None:
    submission = read_submission(saved(tmp_path, name, data), LAB.files)
    assert submission.status in {"ready", "empty", "unreadable"}
    assert (submission.status == "ready") == bool(submission.files)
    assert submission.files or submission.notes
    for path in submission.files:
        path.encode()
        assert ".." not in path.split("/")
        assert not path.startswith("/")


def bytes_with(data: bytes, edits: list[tuple[int, int]]) -> bytes:
    changed = bytearray(data)
    for at, value in edits:
        changed[at % len(changed)] = value
    return bytes(changed)


# ---- a class ----


def make_class(root: Path) -> Path:
    room = root / "class"
    for student in ("bob", "Alice", "empty"):
        (room / student).mkdir(parents=True)
    as_folder(room / "bob", HANDED_IN)
    saved(room / "Alice", "filters.py", b"")
    saved(room, "carol.zip", zipped(HANDED_IN))
    saved(room, "dave.tar.gz", tarred(HANDED_IN))
    return room


def test_a_class_is_found_in_the_order_of_its_names(tmp_path: Path) -> None:
    room = make_class(tmp_path)
    found = read_class([room], LAB.files)
    assert [entry.name for entry in found.entries] == ["Alice", "bob", "carol", "dave", "empty"]
    assert [entry.id for entry in found.entries] == ["Alice", "bob", "carol", "dave", "empty"]
    assert [entry.read().status for entry in found.entries] == ["ready", "ready", "ready", "ready", "empty"]
    assert found.leftovers == ()


def test_a_submission_that_calls_itself_graded_is_graded_all_the_same(tmp_path: Path) -> None:
    room = make_class(tmp_path)
    saved(room / "bob", "results.sqlite", b"")
    (room / "frank" / "lab").mkdir(parents=True)
    saved(room / "frank" / "lab", "work.ipynb", b"{}")
    saved(room / "frank", "results.sqlite", b"")
    assert {"bob", "frank"} <= {entry.name for entry in read_class([room], LAB.files).entries}


def test_loose_files_are_listed_as_left_over(tmp_path: Path) -> None:
    room = make_class(tmp_path)
    saved(room, "grades.csv", b"")
    assert read_class([room], LAB.files).leftovers == (
        f"{room / 'grades.csv'}: not a folder, a .zip or a .tar.gz, so whose it is cannot be told",
    )
    assert read_class([room / "grades.csv"], LAB.files).entries == ()


@POSIX
def test_a_link_in_a_class_is_left_over(tmp_path: Path) -> None:
    room = make_class(tmp_path)
    (room / "mallory").symlink_to(room / "bob")
    found = read_class([room], LAB.files)
    assert len(found.entries) == 5
    assert found.leftovers == (f"{room / 'mallory'}: links are never followed",)


@pytest.mark.parametrize(
    "files",
    [
        HANDED_IN,
        {"filters.py": b""},
        {"lab.ipynb": b"{}"},
        {"main.py": b"", "helpers/tools.py": b"", "data/x.csv": b""},
    ],
)
def test_one_submission_is_told_from_a_class(tmp_path: Path, files: Files) -> None:
    folder = as_folder(tmp_path, files)
    assert [(entry.name, entry.path) for entry in read_class([folder], LAB.files).entries] == [("alice", folder)]


def test_the_working_folder_has_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(as_folder(tmp_path, HANDED_IN))
    assert read_submission(Path(), LAB.files).name == "alice"
    assert classes.read_class([Path(".")], LAB.files).entries[0].name == "alice"


# ---- ids ----


@pytest.mark.parametrize(
    ("name", "safe"),
    [
        ("Müller, Jörg (2)", "Müller__Jörg__2_"),
        ("../../etc/passwd", "_.._etc_passwd"),
        ("", "submission"),
        ("aux", "_aux"),
        ("a\0b\x1b\u202e\udcff", "a_b___"),
        ("x" * 200, "x" * 80),
    ],
)
def test_an_id_is_a_folder_name_everywhere(name: str, safe: str) -> None:
    assert names.safe_id(name) == safe


@given(
    st.lists(
        st.text(max_size=90) | st.sampled_from(["a", "A", "a-2", "A-2", "a ", "a_", "ß", "ss", "aux"]), max_size=12
    )
)
def test_no_two_names_share_an_id(given_names: list[str]) -> None:
    ids = names.distinct_ids(given_names)
    assert len({names.folded(id) for id in ids}) == len(ids) == len(given_names)
    for id in ids:
        assert 0 < len(id) <= 80
        assert len(id.encode()) <= 255
        assert not id.startswith(".")
        assert all(char.isalnum() or char in "-_." for char in id)


# ---- programs that are called otherwise, notebooks that are none ----


@EVERY_WAY
def test_a_text_is_added_to_a_programs_name_and_it_is_a_program(tmp_path: Path, pack: Pack) -> None:
    submission = read_submission(pack(tmp_path, {"filters.py.txt": b"x = 1\n", "log.txt": b"42\n"}), LAB.files)
    assert submission.files == {"filters.py": b"x = 1\n", "log.txt": b"42\n"}
    assert submission.notes == ("Taken for programs although they are called texts: filters.py.txt.",)


@pytest.mark.parametrize("content", [b'{"cells": [', b"[1, 2]", b"", b"[" * 100_000])
def test_a_notebook_that_nobody_can_open_is_nothing_to_mark_unless_there_is_code(
    tmp_path: Path, content: bytes
) -> None:
    files = {"lab.ipynb": content, "imu_data.png": b"a picture"}
    submission = read_submission(as_folder(tmp_path, files), LAB.files)
    assert (submission.status, submission.files) == ("empty", files)
    assert submission.notes == (
        "No program could be read: lab.ipynb is no notebook, or was cut off on the way; hand it in again.",
    )
    (tmp_path / "more").mkdir()
    assert (
        read_submission(as_folder(tmp_path / "more", {**files, "filters.py": b"x = 1\n"}), LAB.files).status == "ready"
    )
