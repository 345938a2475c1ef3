"""What was handed in is found, bounded and never trusted."""

from __future__ import annotations

import io
import os
import random
import re
import socket
import stat
import struct
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grader.intake import Submission, archives, file_budget, folders, names, read_submission
from grader.labs.imu.lab import LAB
from grader.platforms.classes import read_class
from tests.corpus.writing import Link, tarred, write, zipped
from tests.fuzz.mangling import mangled_bytes

Files = Mapping[str, bytes]
HANDED_IN = {"imu_reader.py": b"import numpy\n", "noisy_imu.py": b"# noise\n", "filters.py": b"# filter\n"}
POSIX = pytest.mark.skipif(os.name != "posix", reason="needs links, pipes and byte names of POSIX")
ANY_WAY = "folder zip tar.gz tar"
ARCHIVED = "zip tar.gz tar"


def below(folder: str, files: Files = HANDED_IN) -> dict[str, bytes]:
    return {f"{folder}/{name}": data for name, data in files.items()}


def read(root: Path, files: Files, way: str = "folder") -> Submission:
    return read_submission(write(files, root / "alice", way), LAB.files)


def nested(times: int) -> bytes:
    data = zipped(below("lab"))
    for n in range(1, times):
        data = zipped({f"inner{n}.zip": data})
    return data


def backslashes(system: int) -> bytes:
    """A zip archive as a tool of this system writes it whose paths have backslashes; 0 is Windows, 3 is POSIX."""
    made = re.sub(rb"(?s)(?<=PK\x01\x02\x14).", bytes([system]), zipped(below("lab")))
    return made.replace(b"lab/", b"lab\\")


def header(name: str, **fields: object) -> bytes:
    """An entry of a tar archive that has no content."""
    info = tarfile.TarInfo(name)
    for field, value in fields.items():
        setattr(info, field, value)
    return info.tobuf()


def devices() -> bytes:
    """A zip archive with a link, a pipe and a folder beside the lab's files."""
    buffer = io.BytesIO(zipped({**HANDED_IN, "link.py": Link("/etc/passwd")}))
    with zipfile.ZipFile(buffer, "a") as archive:
        for name, kind in (("pipe.py", stat.S_IFIFO), ("folder", stat.S_IFDIR)):
            info = zipfile.ZipInfo(name)
            info.create_system, info.external_attr = 3, (kind | 0o777) << 16
            archive.writestr(info, "x")
    return buffer.getvalue()


# ---- what is found, by how it was packed ("file": these bytes), with the notes; or the status where nothing is ----

NONE = "No .py or .ipynb file was found up to 4 folders down."
NO_ARCHIVE = "alice.zip is not a readable zip or tar archive; make it again."
FOREIGN = "is an archive of a kind that is not opened; hand in a .zip, or ask whoever marks to unpack it."
ELSEWHERE = "Not read, because the path leads out of the archive or names a drive: "
LINKS = "Not read, because links are never followed: "
CAPITALS = "Read under a name in small letters, as Python needs it: "
POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:%064d\nsize 1290\n" % 1
DEVICES = "Not read, because devices, pipes and sockets are never opened: "
PLAIN, ZEROS = zipped(HANDED_IN), zipped({"zeros.bin": bytes(70_001), **HANDED_IN})
LITTER = (
    "__MACOSX/._filters.py .git/config lab/__pycache__/filters.py .venv/lib/x.py node_modules/x.py "
    "lab/.ipynb_checkpoints/lab-checkpoint.ipynb lab/.DS_Store lab/Thumbs.db"
)
NEAR = {"hw/near.py": b"2", "hw/here.py": b"2", "hw/src/here.py": b"1"}
HOLLOW = {"imu_reader.py": b"x", "filters.py": b"\n", "settings.py": b"", "lab.ipynb": b"[1, 2]"}
STEPS = {"step2/imu_reader.py": b"2", "step5/noisy_imu.py": b"5", "step6/filters.py": b"6", "step6/b/filters.py": b"b"}
TAR_KINDS = (tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.FIFOTYPE, tarfile.BLKTYPE, tarfile.CHRTYPE)
TAR_DEVICES = b"".join(
    header(f"{name}.py", type=kind, linkname="/etc/passwd")
    for name, kind in zip(("soft", "hard", "pipe", "disk", "tty"), TAR_KINDS, strict=True)
)
GAPS = {"GNU.sparse.major": "0", "GNU.sparse.size": "1000", "GNU.sparse.map": "0,0"}

FOUND: dict[str, tuple[str, Files, Files | str, tuple[str, ...]]] = {
    "at the top": (ANY_WAY, HANDED_IN, HANDED_IN, ()),
    "four folders down": (ANY_WAY, below("a/b/c/d"), HANDED_IN, ("The lab's files were found in a/b/c/d.",)),
    "five folders down": (
        ANY_WAY, below("a/b/c/d/e"), "empty",
        (NONE, "There is code further down, in a/b/c/d/e; hand in that folder itself."),
    ),
    "nothing": (ANY_WAY, {}, "empty", (NONE,)),
    "the nearest of one name": (
        "zip", {"far.py": b"3", "near.py": b"3", "here.py": b"3", **NEAR, **below("hw/src")},
        {**HANDED_IN, "far.py": b"3", "near.py": b"2", "here.py": b"1"},
        ("The lab's files were found in hw/src; looked at with them: far.py, hw/near.py.",
         "Not looked at, because the lab's files are in hw/src: here.py, hw/here.py, near.py."),
    ),
    "the lab's files in several folders": (
        "zip", STEPS, {"imu_reader.py": b"2", "step5/noisy_imu.py": b"5", "step6/filters.py": b"6"},
        ("More than one folder holds the lab's files: step2 was graded, not step6/b.",
         "The lab's files were found in step2; looked at with them: step5/noisy_imu.py, step6/filters.py."),
    ),
    "the shallower of two folders": (
        "zip", {"new/filters.py": b"new", **below("old/lab")}, {"filters.py": b"new"},
        ("More than one folder holds the lab's files: new was graded, not old/lab.",),
    ),
    "the more complete of two folders": (
        "zip", {"a/filters.py": b"a", **dict.fromkeys(("a/1.py", "a/2.py", "a/3.py"), b""), **below("b")}, HANDED_IN,
        ("More than one folder holds the lab's files: b was graded, not a.",),
    ),
    "what tools leave behind": (ANY_WAY, {**dict.fromkeys(LITTER.split(), b"x"), **below("lab")}, HANDED_IN, ()),
    "a program that is called a text": (
        ANY_WAY, {"filters.py.txt": b"x = 1\n", "log.txt": b"42\n"}, {"filters.py": b"x = 1\n", "log.txt": b"42\n"},
        ("Taken for programs although they are called texts: filters.py.txt.",),
    ),
    "an archive in an archive": (
        "folder", {"Homework/lab.zip": nested(2), ".DS_Store": b"x"}, HANDED_IN,
        ("The submission is in Homework/lab.zip, which was opened.", "The submission is in inner1.zip, which was opened."),
    ),
    "one archive more": (
        "folder", {"lab.zip": nested(3)}, "unreadable",
        ("inner1.zip is an archive in an archive in an archive; hand in the files.",),
    ),
    "two archives": (
        "folder", {"lab.zip": nested(1), "old.zip": nested(1)}, "empty",
        (NONE, "Not opened, because an archive must be alone in its folder: lab.zip, old.zip."),
    ),
    "a foreign archive in a folder": ("folder", {"lab.rar": b"Rar!"}, "unreadable", (f"lab.rar {FOREIGN}",)),
    "a foreign archive": ("file", {"bob.7z": b"7z"}, "unreadable", (f"bob.7z {FOREIGN}",)),
    "a renamed archive": ("file", {"eve.zip": b"Rar!\x1a\x07\x01\0" * 9}, "unreadable", (f"eve.zip {FOREIGN}",)),
    **{
        f"the path {name}": (ARCHIVED, {name: b"evil", **HANDED_IN}, HANDED_IN, (f"{ELSEWHERE}{name}.",))
        for name in ("../evil.py", "/etc/evil.py", "a/../../evil.py", "C:/evil.py", "c:evil.py")
    },
    "a path with a NUL": (
        "file", {"alice.zip": zipped({"filters.py_x": b"evil", **HANDED_IN}).replace(b".py_x", b".py\0x")}, HANDED_IN,
        (f"{ELSEWHERE}filters.py\\x00x.",),
    ),
    "backslashes of Windows": ("file", {"alice.zip": backslashes(0)}, HANDED_IN, ()),
    "backslashes of POSIX": ("file", {"alice.zip": backslashes(3)}, HANDED_IN, ()),
    "a backslash that leads out of the archive": (
        "file", {"alice.zip": zipped({**HANDED_IN, "..\\out.py": b"A = 1"})}, HANDED_IN, (f"{ELSEWHERE}../out.py.",),
    ),
    "names that differ in case alone": (
        ARCHIVED, {"Filters.py": b"other", **HANDED_IN}, HANDED_IN,
        ("Not read, because another name differs from it in upper and lower case only: Filters.py.",),
    ),
    "a name that stands twice": (
        ARCHIVED, {**HANDED_IN, "./filters.py": b"last"}, {**HANDED_IN, "filters.py": b"last"},
        ("Not read, because the name stands twice in the archive, and the last one counts: filters.py.",),
    ),
    "links and devices of a zip": (
        "file", {"alice.zip": devices()}, HANDED_IN,
        (f"{LINKS}link.py.", f"{DEVICES}pipe.py."),
    ),
    "links and devices of a tar": (
        "file", {"alice.tar": TAR_DEVICES + tarred(HANDED_IN, "tar")}, HANDED_IN,
        (f"{LINKS}soft.py, hard.py.", f"{DEVICES}pipe.py, disk.py, tty.py."),
    ),
    "a tar's file with gaps": (
        "file", {"alice.tar": header("huge.py", pax_headers=GAPS) + tarred(HANDED_IN, "tar")}, HANDED_IN,
        ("Not read, because the file is stored with gaps: huge.py.",),
    ),
    "a file over the limit": (
        ANY_WAY, {"video.mp4": bytes(file_budget.MAX_FILE + 1), **HANDED_IN}, HANDED_IN,
        ("Not read, because the file is larger than 16 MB: video.mp4.",),
    ),
    "a file that claims to be smaller than it is": (
        "file", {"alice.zip": ZEROS.replace(struct.pack("<L", 70_001), struct.pack("<L", 10))}, HANDED_IN,
        ("Not read, because the file is damaged in the archive: zeros.bin.",),
    ),
    "an encrypted zip": (
        "file", {"alice.zip": PLAIN.replace(b"\x14\0\0\0\x08\0", b"\x14\0\1\0\x08\0")}, "unreadable",
        (NONE, "Not read, because the file is encrypted: imu_reader.py, noisy_imu.py, filters.py."),
    ),
    "a damaged file": (
        "file", {"alice.zip": re.sub(rb"(?s)(?<=imu_reader.py).", b"\xff", PLAIN, count=1)},
        {name: data for name, data in HANDED_IN.items() if name != "imu_reader.py"},
        ("Not read, because the file is damaged in the archive: imu_reader.py.",),
    ),
    **{
        f"the first {kept} bytes of a zip": ("file", {"alice.zip": PLAIN[:kept]}, "unreadable", (NO_ARCHIVE,))
        for kept in (0, 1, 2, 30, len(PLAIN) // 2, len(PLAIN) * 9 // 10)
    },
    "the first half of a tar": (
        "file", {"alice.tar.gz": tarred({**HANDED_IN, "noise.bin": os.urandom(200_000)})[:100_000]}, HANDED_IN,
        ("alice.tar.gz is damaged; the files before the damage were read.",),
    ),
    **{
        f"no notebook {number}": (
            "folder", {"lab.ipynb": content, "imu_data.png": b"a picture"}, "empty",
            ("No program could be read: lab.ipynb is no notebook, or was cut off on the way; hand it in again.",),
        )
        for number, content in enumerate((b'{"cells": [', b"[1, 2]", b"", b"[" * 100_000))
    },
    "a notebook with a merge conflict": (
        "folder", {"lab.ipynb": b'{"cells": [\n<<<<<<< HEAD\n{},\n=======\n>>>>>>> main\n]}'}, "empty",
        ("No program could be read: lab.ipynb has an unresolved merge conflict in line 2; resolve it and hand it in again.",),
    ),
    "an empty required file, an empty helper, and no notebook": (
        "folder", HOLLOW, HOLLOW, ("filters.py is empty: save it, check its size and hand it in again.",),
    ),
    **{
        f"{what} in place of a file": (
            "folder", {"filters.py": content, "imu_reader.py": b"x"}, {"imu_reader.py": b"x"}, (f"Not read, because {why}: filters.py.",),
        )
        for what, content, why in (
            ("a Git LFS pointer", POINTER, "it is a Git LFS pointer and not the file (run `git lfs push --all origin` where the"
             " file is, or stop tracking it with LFS and commit it again)"),
            ("a web page", b"\n<!DOCTYPE html><title>Log in</title>", "it is a web page, such as a login page saved in place of the file"
             " (download the file again)"),
            ("null bytes", bytes(4096), "it holds null bytes only, as an interrupted sync leaves it (copy the file again)"),
        )
    },
    "a file that iCloud had not downloaded": (
        "folder", {".filters.py.icloud": b"bplist00\xd3", "imu_reader.py": b"x"}, {"imu_reader.py": b"x"},
        ("Not read, because iCloud had not downloaded the file (open it once in Finder, then hand in again): .filters.py.icloud.",),
    ),
    "suffixes in capitals": (
        ANY_WAY, {"filters.PY": b"x", "LAB.IPYNB": b"{}"}, {"filters.py": b"x", "lab.ipynb": b"{}"},
        (f"{CAPITALS}LAB.IPYNB, filters.PY.",),
    ),
    "an archive and its files in capitals": (
        "file", {"LAB4.ZIP": zipped({name.upper(): data for name, data in HANDED_IN.items()})}, HANDED_IN,
        (f"{CAPITALS}FILTERS.PY, IMU_READER.PY, NOISY_IMU.PY.",),
    ),
    "a name in the code page of Western Windows": (
        "file", {"alice.zip": zipped(below("MXller/lab")).replace(b"MXller", "Müller".encode("cp437"))}, HANDED_IN,
        ("The lab's files were found in Müller/lab.",),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("way", "case"), [(way, case) for case, row in FOUND.items() for way in row[0].split()])
def test_what_was_handed_in_is_found(tmp_path: Path, way: str, case: str) -> None:
    _, files, kept, notes = FOUND[case]
    submission = read(tmp_path, files, way)
    assert submission.notes == notes
    if isinstance(kept, str):
        assert submission.status == kept
        assert kept == "unreadable" or submission.files == files
    else:
        assert (submission.status, submission.files) == ("ready" if kept else "empty", kept)
    assert way == "file" or (submission.id, submission.name) == ("alice", "alice")
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("way", ANY_WAY.split())
def test_what_lies_beside_the_labs_folder_comes_with_it_by_its_path_there(tmp_path: Path, way: str) -> None:
    beside = {"config.py": b"DT = 0.002", "tools/io.py": b"", "imu_data.png": b"\x89PNG", "run.ipynb": b"{}"}
    above = {"hw/filters.py/x.py": b"", "config.py": b"above", "settings.toml": b"", "old/try.ipynb": b"{}"}
    files = {**below("hw/src"), **below("hw", beside), **above, "hw/__init__.py": b"raise SystemExit"}
    submission = read(tmp_path, files, way)
    assert submission.files == {**HANDED_IN, **beside, "settings.toml": b""}
    assert submission.origin("config.py") == "hw/config.py"
    assert submission.origin("settings.toml") == "settings.toml"
    assert submission.origin("imu_reader.py") == "hw/src/imu_reader.py"


def test_a_folder_and_its_archives_have_one_hash_and_other_bytes_another(tmp_path: Path) -> None:
    hashes = {read(tmp_path, HANDED_IN, way).sha256 for way in ANY_WAY.split()}
    os.utime(tmp_path / "alice" / "filters.py", (0, 0))
    hashes.add(read_submission(tmp_path / "alice", LAB.files).sha256)
    assert len(hashes) == 1
    hashes.add(read(tmp_path, {**HANDED_IN, "filters.py": b"#"}, "zip").sha256)
    hashes.add(read(tmp_path, {**HANDED_IN, "filters.pyfilter": b""}, "zip").sha256)
    assert len(hashes) == 3


@pytest.mark.parametrize("way", ARCHIVED.split())
@pytest.mark.parametrize("name", ["d/" * 16 + "x.py", "x" * 256 + ".py", "é" * 128 + ".py", "/".join(["y" * 200] * 6)])
def test_a_path_too_long_or_too_deep_is_left_out(tmp_path: Path, way: str, name: str) -> None:
    submission = read(tmp_path, {name: b"x", **HANDED_IN}, way)
    assert submission.files == HANDED_IN
    (note,) = submission.notes
    assert note.startswith("Not read, because the path is too long or too deep: ")
    assert len(note) < 250


@POSIX
def test_names_that_are_not_utf8_do_no_harm(tmp_path: Path) -> None:
    write(
        {os.fsdecode(b"Mar\xeda/" + name): b"x" for name in (b"filters.py", b"r\xe9sum\xe9.txt")},
        tmp_path / "alice\udcff",
    )
    (entry,) = read_class([tmp_path], LAB.files).entries
    assert (entry.id, entry.name) == ("alice_", "alice\ufffd")
    assert entry.read().files == {"r_sum_.txt": b"x", "filters.py": b"x"}


# ---- links, pipes and what may not be read ----


@POSIX
def test_links_pipes_and_sockets_of_a_folder_are_not_opened(tmp_path: Path) -> None:
    secret = write({"solution.py": b"secret"}, tmp_path / "secret")
    folder = write(
        {**HANDED_IN, "a.py": Link(f"{secret}/solution.py"), "b": Link(str(secret)), "c.py": Link("c.py")},
        tmp_path / "alice",
    )
    os.mkfifo(folder / "pipe.py")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(os.path.relpath(folder / "socket"))
        submission = read_submission(folder, LAB.files)
    assert submission.files == HANDED_IN
    assert sorted(submission.notes) == [f"{DEVICES}pipe.py, socket.", f"{LINKS}a.py, b, c.py."]
    with pytest.raises(OSError, match="symbolic"):  # one that comes after the listing
        folders._read(str(folder / "a.py"))
    os.rename(folder / "pipe.py", tmp_path / "pipe.zip")
    assert read_submission(tmp_path / "pipe.zip", LAB.files).notes == (
        "pipe.zip is neither a file nor a folder; hand in a folder or a .zip of it.",
    )


def test_a_file_that_may_not_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = os.open

    def refusing(path: str, flags: int) -> int:  # root, as whom tests may run, is refused nothing
        if path.endswith("locked.csv"):
            raise PermissionError(13, "Permission denied")
        return opened(path, flags)

    folder = write({**HANDED_IN, "locked.csv": b"x"}, tmp_path / "alice")
    monkeypatch.setattr(os, "open", refusing)
    assert read_submission(folder, LAB.files).notes == (
        "Not read, because the system refused it (Permission denied): locked.csv.",
    )


# ---- bounds ----


@pytest.mark.parametrize("folder", ["", "lab/"])
@pytest.mark.parametrize("way", ANY_WAY.split())
def test_data_never_crowds_out_code_nor_other_code_the_required_files(
    tmp_path: Path, way: str, folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(file_budget, "MAX_FILES", 5)
    monkeypatch.setattr(file_budget, "Room", lambda files=5, bytes=1000: SimpleNamespace(files=files, bytes=bytes))
    others = [(f"data/{n:02}.csv", f"a{n:02}.py") for n in range(20)]
    files = {**{name: b"x" for pair in others for name in pair}, **HANDED_IN}
    submission = read(tmp_path, {f"{folder}{name}": data for name, data in files.items()}, way)
    assert submission.files == {**{name: b"x" for pair in others[:5] for name in pair}, **HANDED_IN}
    (note,) = submission.notes
    assert note.startswith("Not read, because the submission holds more than 2,000 files or 64 MB: ")
    assert note.endswith(" and 27 more.")


def test_the_limits_are_the_promised_ones() -> None:
    rooms = file_budget.FileBudget()._room.values()
    assert sum(room.files for room in rooms) == 2_000
    assert sum(room.bytes for room in rooms) == 64 * file_budget.MB
    assert file_budget.MAX_FILE == 16 * file_budget.MB


def test_a_bomb_costs_no_more_than_the_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A zip whose entries all point at the same megabyte of compressed zeros: little data that claims to be much."""
    monkeypatch.setattr(archives, "MAX_UNPACKED", 20 * file_budget.MB)
    data, times = zipped({"zeros.bin": bytes(file_budget.MB)}), 2_000
    start, end = data.index(b"PK\1\2"), data.index(b"PK\5\6")
    listing = data[start:end] * times
    bomb = data[:start] + listing + struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, times, times, len(listing), start, 0)
    found = archives.gather_archive(io.BytesIO(bomb), "bomb.zip")
    assert len(found.left.get(file_budget.TWICE, [])) + 1 <= 20
    # Pythons that see the overlap refuse each entry; others unpack until the limit.
    assert len(found.left.get(file_budget.DAMAGED, [])) >= 1_999 or found.remarks == [
        "bomb.zip was read in part: it unpacks to more than 20 MB."
    ]
    assert found.broken


def test_a_table_of_contents_that_is_too_long_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "MAX_DIRECTORY", 100_000)
    submission = read(tmp_path, {**{f"{n}": b"" for n in range(3_000)}, **HANDED_IN}, "zip")
    assert (submission.status, submission.notes) == ("unreadable", (NO_ARCHIVE,))


def test_records_that_take_quadratic_time_are_bounded_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    extra = header("x.csv", pax_headers={"comment": "x" * 985}) * 4  # with its length and name 1,000 bytes
    files = {"alice.tar": extra + tarred(HANDED_IN, "tar")}
    assert read(tmp_path, files, "file").notes == (
        "Not read, because the name stands twice in the archive, and the last one counts: x.csv, x.csv, x.csv.",
    )
    monkeypatch.setattr(archives, "MAX_HEADER_WORK", 3 * 1000**2)
    assert "alice.tar was read in part: its names and attributes are too long." in read(tmp_path, files, "file").notes


SEEDS = [zipped(below("lab")), tarred(below("lab")), tarred({**HANDED_IN, "l": Link("/etc/passwd")}, "tar"), nested(2)]


@pytest.mark.slow
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.binary(max_size=600)
    | st.builds(lambda seed, n: mangled_bytes(seed, random.Random(n)), st.sampled_from(SEEDS), st.integers(0, 2**32)),
    st.sampled_from(["x.zip", "x.tar.gz", "x.tar"]),
)
def test_any_bytes_are_a_submission(tmp_path: Path, data: bytes, name: str) -> None:
    submission = read(tmp_path, {name: data}, "file")
    assert submission.status in {"ready", "empty", "unreadable"}
    assert (submission.status == "ready") == bool(submission.files)
    assert submission.files or submission.notes
    for path in submission.files:
        path.encode()
        assert ".." not in path.split("/")
        assert not path.startswith("/")


# ---- a class ----


def test_a_class_is_found_in_the_order_of_its_names_and_what_is_nobodys_is_listed(tmp_path: Path) -> None:
    graded = {"bob/results.sqlite": b"", "Alice/results.sqlite": b""}  # call themselves graded; are graded all the same
    files = {"Alice/lab/filters.py": b"", "empty/": b"", "carol.ZIP": PLAIN, "dave.tar.gz": tarred(HANDED_IN)}
    room = write({**below("bob"), **files, **graded, "grades.csv": b""}, tmp_path / "class")
    links = [f"{room / 'mallory'}: links are never followed"] if os.name == "posix" else []
    if links:
        write({"mallory": Link(f"{room}/bob")}, room)
    found = read_class([room], LAB.files)
    assert [entry.name for entry in found.entries] == ["Alice", "bob", "carol", "dave", "empty"]
    assert [entry.id for entry in found.entries] == [entry.name for entry in found.entries]
    assert [entry.read().status for entry in found.entries] == ["ready", "ready", "ready", "ready", "empty"]
    told = f"{room / 'grades.csv'}: not a folder, a .zip or a .tar.gz, so whose it is cannot be told"
    assert list(found.leftovers) == [told, *links]
    assert read_class([room / "grades.csv"], LAB.files).entries == ()


@pytest.mark.parametrize(
    "names",
    [
        *("imu_reader.py noisy_imu.py filters.py", "IMU_READER.PY FILTERS.PY", "filters.py", "lab.ipynb"),
        "main.py helpers/tools.py data/x.csv",
    ],
)
def test_one_submission_is_told_from_a_class(tmp_path: Path, names: str) -> None:
    folder = write(dict.fromkeys(names.split(), b""), tmp_path / "alice")
    assert [(entry.name, entry.path) for entry in read_class([folder], LAB.files).entries] == [("alice", folder)]


def test_the_working_folder_has_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(write(HANDED_IN, tmp_path / "alice"))
    assert read_submission(Path(), LAB.files).name == "alice"
    assert read_class([Path(".")], LAB.files).entries[0].name == "alice"


# ---- ids ----


@pytest.mark.parametrize(
    ("name", "safe"),
    [
        ("../../etc/passwd", "_.._etc_passwd"),
        ("", "submission"),
        ("aux", "_aux"),
        ("x" * 200, "x" * 80),
        ("ü\0b\x1b\u202e\udcff", "ü_b___"),
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
