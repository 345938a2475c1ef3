"""What platforms give is recognised by its shape, taken apart to the last file, and nothing of it is dropped in silence."""

from __future__ import annotations

import pickle
import subprocess
import zipfile
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.labs.imu.lab import LAB
from grader.people.final_grade import Person
from grader.platforms.classes import Intake, read_class
from tests import classes
from tests.corpus.writing import as_bytes, write, zipped

FILTERS = {"filters.py": b"alpha = 0.1\n"}
STUDENTS = classes.a_class(7, [{"imu_reader.py": "a = 1\n", "filters.py": "b = 2\n"}, {"filters.py": "c = 3\n"}])


def files_of(found: Intake) -> dict[str, dict[str, bytes]]:
    return {entry.id: dict(entry.read().files) for entry in found.entries}


# ---- every shape ----


TITLES = {
    "folders": None,
    "canvas": "Canvas submissions",
    **dict.fromkeys(("moodle", "moodle_flat", "moodle_unzipped"), "Moodle submissions"),
    "gradescope": "Gradescope export",
    "classroom50": "Classroom 50 clones",
    "git": "git clones",
}


@pytest.mark.parametrize("shape", classes.SHAPES)
def test_every_student_of_every_shape_is_found_with_their_own_files(shape: str, tmp_path: Path) -> None:
    path = classes.SHAPES[shape](STUDENTS, tmp_path / "in")
    found = read_class([path], LAB.files)
    assert found.leftovers == ()
    assert found.notices == ((f"{path}: {TITLES[shape]}, 7 submissions",) if TITLES[shape] else ())
    assert len(found.entries) == len({entry.id for entry in found.entries}) == len(STUDENTS)
    assert pickle.loads(pickle.dumps(found.entries)) == found.entries
    handed_in = sorted(sorted((n, as_bytes(c)) for n, c in s.files.items()) for s in STUDENTS)  # type: ignore[arg-type]
    own = sorted(sorted((n, d) for n, d in files.items() if n != "result.json") for files in files_of(found).values())
    assert own == handed_in
    if path.is_file():
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / "unpacked")
        unpacked = read_class([tmp_path / "unpacked"], LAB.files)
        for part in ("id", "name", "hand_in"):
            assert [getattr(e, part) for e in unpacked.entries] == [getattr(e, part) for e in found.entries]
        assert [e.read().sha256 for e in unpacked.entries] == [e.read().sha256 for e in found.entries]


def test_a_shape_can_be_forced_and_one_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    path = classes.moodle(STUDENTS, tmp_path / "in")
    assert len(read_class([path], LAB.files, "moodle").entries) == 7
    with pytest.raises(RequestError) as refusal:
        read_class([path], LAB.files, "canvas")
    assert str(refusal.value) == f"--from canvas: {path} does not have that shape; leave --from out"


def test_a_zip_of_folders_is_one_submission_unless_it_is_forced_to_be_a_class(tmp_path: Path) -> None:
    members = {"alice/filters.py": "a", "bob/filters.py": "b", "carol.zip": zipped(FILTERS), "notes.txt": "?"}
    path = write(members, tmp_path / "class", "zip")
    assert [entry.id for entry in read_class([path], LAB.files).entries] == ["class"]
    found = read_class([path], LAB.files, "folders")
    assert files_of(found) == {"alice": {"filters.py": b"a"}, "bob": {"filters.py": b"b"}, "carol": FILTERS}
    assert found.leftovers == (f"{path}/notes.txt: not a folder, a .zip or a .tar.gz, so whose it is cannot be told",)


def test_a_students_own_archive_is_never_taken_for_a_download(tmp_path: Path) -> None:
    """Else a student could hand in under other people's names."""
    room = tmp_path / "class"
    write({"Alice_12_assignsubmission_file_filters.py": "a", "imu_reader.py": "b"}, room / "mallory", "zip")
    write(FILTERS, room / "bob", "zip")
    assert [entry.id for entry in read_class([room], LAB.files).entries] == ["bob", "mallory"]


def test_names_that_lead_out_of_a_download_are_listed_and_not_followed(tmp_path: Path) -> None:
    members = {"A_1_assignsubmission_file_/filters.py": "a", "../B_2_assignsubmission_file_/filters.py": "b"}
    path = write(members, tmp_path / "m", "zip")
    found = read_class([path], LAB.files)
    assert [entry.id for entry in found.entries] == ["A_1"]
    assert found.leftovers == (
        f"{path}/../B_2_assignsubmission_file_/filters.py: the path leads out of the archive or names a drive",
    )


ODD = ("readme.md", "lab.zip", "submission_metadata.yml", "scores.csv", "text.html", "1_2_3_4", "_1_2_x", "anon_1_2_x")
NAMES = st.one_of(
    st.sampled_from(ODD),
    st.from_regex(r"[a-zé]{0,3}_?(LATE_)?\d{1,2}_\d{1,2}_(filters|a)(-1)?\.(py|txt)", fullmatch=True),
    st.from_regex(r"[A-Z][a-z ]{0,4}_\d{1,2}_assign(submission|feedback)_(file|onlinetext)(_|_x\.py|)", fullmatch=True),
    st.from_regex(r"(submission_\d|rob-[a-z])", fullmatch=True),
)


@pytest.mark.slow
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sets(NAMES, min_size=1, max_size=6),
    st.sampled_from(["", "/filters.py", "/.git/HEAD"]),
    st.sampled_from(["latest", "best"]),
)
def test_whatever_lies_in_a_download_is_somebodys_or_is_listed(
    tmp_path: Path, names: set[str], below: str, attempts: str
) -> None:
    members: dict[str, bytes | str] = {name + below * (i % 2): "x" for i, name in enumerate(sorted(names))}
    found = read_class([write(members, tmp_path / "d", "zip")], LAB.files, attempts=attempts)
    places = [place for entry in found.entries for place in {place for place, _ in entry.sources}]
    listed = {line.removeprefix(f"{tmp_path}/d.zip/").rpartition(": ")[0] for line in found.leftovers}
    known = {"submission_metadata.yml", "scores.csv"}  # the platform's own
    if found.notices:
        assert {name.split("/")[0] for name in members} <= {p.split("/")[0] for p in (*places, *listed)} | known
        assert len(places) == len(set(places))
    for entry in found.entries:
        assert entry.read().status in {"ready", "empty", "unreadable"}


# ---- Canvas ----


def canvas(tmp_path: Path, *names: str) -> Intake:
    return read_class([write({name: f"# {name}\n" for name in names}, tmp_path / "c", "zip")], LAB.files)


def test_canvas_names_give_who_late_and_where_feedback_goes(tmp_path: Path) -> None:
    names = ("doejane_LATE_101_9001_imu_reader.py", "doejane_LATE_101_9002_filters.py", "li2_102_9003_filters.py")
    jane, li = canvas(tmp_path, *names).entries
    assert (jane.id, jane.name) == ("doejane_101", "doejane")
    assert jane.hand_in.people == (Person("doejane", "101", "canvas"),)
    assert jane.hand_in.marked_late
    assert jane.hand_in.reply == "doejane_LATE_101_9002_"
    assert set(jane.read().files) == {"imu_reader.py", "filters.py"}
    assert (li.id, li.hand_in.marked_late, li.hand_in.people[0].key) == ("li2_102", False, "102")
    (one_late,) = canvas(tmp_path, "li_102_9001_filters.py", "li_LATE_102_9002_imu_reader.py").entries
    assert one_late.hand_in.marked_late
    anonymous = canvas(tmp_path, "anon_b4Xk_9001_filters.py", "anon_c5Yl_9002_filters.py").entries
    assert [entry.hand_in.people[0].key for entry in anonymous] == ["", ""]


def test_a_file_that_was_handed_in_again_is_the_newer_one_under_its_own_name(tmp_path: Path) -> None:
    found = canvas(tmp_path, "a_1_10_filters.py", "a_1_12_filters-1.py", "a_1_11_lab-04-01.ipynb", "a_1_13_data-2.csv")
    assert dict(found.entries[0].read().files) == {
        "filters.py": b"# a_1_12_filters-1.py\n",
        "lab-04-01.ipynb": b"# a_1_11_lab-04-01.ipynb\n",
        "data-2.csv": b"# a_1_13_data-2.csv\n",
        "data.csv": b"# a_1_13_data-2.csv\n",
    }
    assert found.leftovers == (
        f"{tmp_path}/c.zip/a_1_10_filters.py: an older file of the same name and student; the newer one is graded",
    )


@pytest.mark.parametrize("name", ["imu_reader.py", "noisy_imu.py", "filters.py", "imu_data.png", "filtered_imu.png"])
def test_the_number_that_canvas_gives_a_resubmission_is_taken_off_every_file(tmp_path: Path, name: str) -> None:
    stem, suffix = name.split(".")
    found = canvas(tmp_path, "a_1_10_filters.py", f"a_1_12_{stem}-1.{suffix}", f"a_1_13_{stem}-2.{suffix}")
    assert found.entries[0].read().files[name] == f"# a_1_13_{stem}-2.{suffix}\n".encode()


ROSTER = {"101": "Doe, Jane", "666": "zzz_101_5", "678": "12345", "55": "Roe, Bob"}
DOUBTFUL = "its name can mean several people; give --roster with the platform's numbers, and it is who stands there"
LIE = "Jane Doe_12_assignsubmission_file_x_9_assignsubmission_file_filters.py"
CANVAS, MOODLE = "li_102_9003_filters.py", "B_9_assignsubmission_file_filters.py"


@pytest.mark.parametrize(
    ("beside", "name", "known", "who"),
    [
        (CANVAS, "12345_678_901_filters.py", {}, "678"),
        (CANVAS, "zzz_101_5_666_901_filters.py", {}, None),
        (CANVAS, "zzz_101_5_666_901_filters.py", ROSTER, "666"),
        (CANVAS, "doejane_101_901_04_01_filters.py", {}, None),
        (CANVAS, "doejane_101_901_04_01_filters.py", ROSTER, "101"),
        (CANVAS, "a_7_55_text.html", {}, "7"),
        (MOODLE, LIE, {}, None),
        (MOODLE, LIE, {"12": "Jane Doe"}, "12"),
        (MOODLE, LIE, {"12": "Jane Doe", "9": "B"}, None),
    ],
)
def test_a_name_with_numbers_in_it_is_who_the_roster_knows_or_nobody(
    beside: str, name: str, known: dict[str, str], who: str | None, tmp_path: Path
) -> None:
    path = write({name: "# 1\n", beside: "# 2\n"}, tmp_path / "c", "zip")
    found = read_class([path], LAB.files, known=known)
    keys = [entry.hand_in.people[0].key for entry in found.entries]
    assert sorted(keys) == sorted([beside.split("_")[1], *filter(None, [who])])
    assert found.leftovers == (() if who else (f"{path}/{name}: {DOUBTFUL}",))


def test_of_a_file_that_begins_with_numbers_another_of_the_same_student_leaves_no_doubt(tmp_path: Path) -> None:
    found = canvas(tmp_path, "doejane_101_9001_04_01_notes.py", "doejane_101_9002_filters.py")
    assert [set(entry.read().files) for entry in found.entries] == [{"04_01_notes.py", "filters.py"}]


# ---- Moodle ----


def test_moodle_online_text_and_feedback_stand_beside_the_files(tmp_path: Path) -> None:
    members = {
        "Jane Doe_12_assignsubmission_file/filters.py": "f",
        "Jane Doe_12_assignsubmission_onlinetext/onlinetext.html": "<p>hello</p>",
        "Jane Doe_12_assignfeedback_file/old.html": "x",
        "Only Text_13_assignsubmission_onlinetext/onlinetext.html": "<p>see attachment</p>",
    }  # fmt: skip
    found = read_class([write(members, tmp_path / "m", "zip")], LAB.files)
    jane, text = found.entries
    assert (jane.id, jane.name) == ("Jane_Doe_12", "Jane Doe")
    assert jane.hand_in.people == (Person("Jane Doe", "12", "moodle"),)
    assert jane.hand_in.reply == "Jane Doe_12_assignsubmission_file/"
    assert set(jane.read().files) == {"filters.py", "onlinetext.html"}
    assert (text.id, text.read().status) == ("Only_Text_13", "empty")
    assert found.leftovers == (
        f"{tmp_path}/m.zip/Jane Doe_12_assignfeedback_file: feedback, not handed in by the student",
    )


@pytest.mark.parametrize(
    "shape", sorted(classes.SHAPES.keys() - {"folders", "gradescope", "classroom50"})
)  # these tell times
def test_of_two_downloads_that_tell_no_time_the_one_given_last_is_graded(shape: str, tmp_path: Path) -> None:
    before, now = (classes.a_class(1, [{"filters.py": f"# {at}\n"}]) for at in (1, 2))
    paths = [classes.SHAPES[shape](each, tmp_path / str(at) / "in") for at, each in enumerate((before, now))]
    assert [*files_of(read_class(paths, LAB.files)).values()] == [{"filters.py": b"# 2\n"}]


# ---- Gradescope ----


def export(tmp_path: Path, records: object, *folders: str) -> Intake:
    members = {f"{folder}/filters.py": f"# {folder}\n" for folder in folders}
    text = records if isinstance(records, str) else yaml.safe_dump(records)
    return read_class([write({**members, "submission_metadata.yml": text}, tmp_path / "g", "zip")], LAB.files)


def submitter(name: str, sid: str, email: str = "") -> dict[str, str]:
    return {":name": name, ":sid": sid, ":email": email or f"{sid}@example.edu"}


def test_people_of_one_name_without_a_number_are_told_apart_by_their_addresses(tmp_path: Path) -> None:
    own = {f"submission_{at}": {":submitters": [submitter("Ann Lee", "", f"ann{at}@x.edu")]} for at in (1, 2)}
    assert len(export(tmp_path, own, *own).entries) == 2


def test_a_group_is_one_submission_of_all_its_people_in_any_order(tmp_path: Path) -> None:
    both = [submitter("Bob Roe", "s2"), submitter("Ann Lee", "s1")]
    records = {
        "submission_12": {":submitters": both, ":created_at": "2026-11-20 13:00:00.5 -08:00"},
        "submission_7": {":submitters": both[::-1], ":created_at": "2026-11-21 13:00:00.5 -08:00"},
    }
    found = export(tmp_path, records, "submission_12", "submission_7")
    (group,) = found.entries
    assert (group.id, group.name) == ("Ann_Lee_s1", "Ann Lee; Bob Roe")
    assert [person.sid for person in group.hand_in.people] == ["s1", "s2"]
    assert (group.hand_in.submitted, group.hand_in.number) == ("2026-11-21T21:00:00+00:00", "7")
    assert found.leftovers == (f"{tmp_path}/g.zip/submission_12: an earlier attempt; the latest one is graded",)


@pytest.mark.parametrize("text", ["{", "- a", "!!python/object/apply:os.system ['true']", "\0", ""])
def test_metadata_that_cannot_be_read_is_no_export(text: str, tmp_path: Path) -> None:
    found = export(tmp_path, text, "submission_1")
    assert (found.notices, [entry.id for entry in found.entries]) == ((), ["g"])


# ---- clones ----


def test_work_on_another_branch_of_a_clone_is_named(tmp_path: Path) -> None:
    packed = f"{'0' * 40} refs/remotes/origin/main\n{'1' * 40} refs/remotes/origin/dev\n"
    refs = {".git/HEAD": "ref: refs/heads/main\n", ".git/packed-refs": packed, ".git/refs/heads/main": "0" * 40}
    write({"README.md": "# Lab\n", **refs, ".git/refs/heads/ann/filters": "2" * 40}, tmp_path / "lab-ann", "folder")
    (entry,) = read_class([tmp_path], LAB.files).entries
    said = (
        "The checked-out branch main of this git clone has no files of the lab. Its other branches: ann/filters, dev."
    )
    assert (entry.read().status, entry.read().notes[-1]) == ("empty", said)


def test_a_branch_with_the_files_is_named_without_reading_the_settings_of_the_clone(tmp_path: Path) -> None:
    clone, ran = tmp_path / "class" / "lab-ann", tmp_path / "ran"
    write({"README.md": "# Lab\n"}, clone, "folder")
    for branch, name in (("main", "README.md"), ("dev", "lab/Filters.py"), ("notes", "notes.txt")):
        write({name: "x = 1\n"}, clone, "folder")
        for command in (
            ["init", "-q", "-b", "main"],
            ["checkout", "-q", "-B", branch],
            ["add", name],
            ["commit", "-qm", name],
        ):
            who = ["-c", "user.name=Ann", "-c", "user.email=ann@example.edu"]
            subprocess.run(["git", *who, *command], cwd=clone, check=True, capture_output=True)
        if branch == "dev":
            subprocess.run(["git", "checkout", "-q", "main"], cwd=clone, check=True)
    subprocess.run(["git", "checkout", "-q", "main"], cwd=clone, check=True)
    subprocess.run(["git", "config", "core.fsmonitor", f"touch {ran}"], cwd=clone, check=True)
    (entry,) = read_class([tmp_path / "class"], LAB.files).entries
    said = "The checked-out branch main of this git clone has no files of the lab. dev has them: check it out, and grade again."
    assert (entry.read().notes[-1], ran.exists()) == (said, False)


def test_the_times_and_names_of_classroom_50_go_to_the_right_clone(tmp_path: Path) -> None:
    rows = [
        "username,first_name,last_name,email,section,score,max_score,datetime,submission_tag,submitted_by,review_url,late,override",
        "a,Al,Short,al@example.edu,1,,,2026-11-20T21:00:00Z,submit/x,,,false,",
        "anna-a,Anna,Long,anna@example.edu,2,,,2026-11-21T21:00:00Z,submit/y,,,true,",
    ]
    (tmp_path / "scores.csv").write_text("\n".join(rows) + "\n")
    for name in ("rob-lab4-a", "rob-lab4-anna-a", "rob-lab4-new"):
        classes._clone(tmp_path / name, {"filters.py": "x"})
    found = {entry.id: entry.hand_in for entry in read_class([tmp_path], LAB.files).entries}
    assert found["rob-lab4-a"].people == (Person("Al Short", "a", "git", email="al@example.edu", section="1"),)
    assert found["rob-lab4-anna-a"].people[0].name == "Anna Long"
    assert found["rob-lab4-anna-a"].submitted == "2026-11-21T21:00:00+00:00"
    assert (found["rob-lab4-a"].marked_late, found["rob-lab4-anna-a"].marked_late) == (False, True)
    assert found["rob-lab4-new"].people[0].name == "rob-lab4-new"
