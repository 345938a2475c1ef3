"""Tests of `imugrade calibrate`: the sample, the marks that people type, the comparison, the proposal, and the page of the desk."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
import yaml

from grader.course.calibration import calibrating, sample
from grader.course.calibration.comparison import ComparedCell, agreement, by_fault, compare, differing
from grader.course.calibration.marks import Mark, Marks
from grader.course.calibration.proposal import propose
from grader.course.record.store import Store
from grader.course.regrading.regrade import regraded
from grader.engine import rubric
from grader.engine.results import Result
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from tests.class_commands import Run, in_process
from tests.desk import FILTER, PNG, RUBRIC, Desk, Student, desk_over, make_class, result_of, words

ADDRESS, SIZE, TITLES = "sensor_access.follows_address", "noise_model.noise_size", "visualization.titles"
NAMED = {"got": "the data of another sensor", "hint": "Use sensor_adr", "misconceptions": ("sensor-id-as-address",)}
VARIANCE = {"misconceptions": ("std-taken-as-variance",)}


def wrong(id_: str, **more: object) -> Student:
    """A reader that takes an id for an address: 6 of 20 points."""
    return Student(id_, {ADDRESS: 0.0}, {ADDRESS: NAMED}, {"imu_reader.py": FILTER, "imu_data.png": PNG}, **more)  # type: ignore[arg-type]


CLASS = (
    *(Student(f"sound-{i}", files={"imu_reader.py": FILTER}) for i in range(6)),
    *(wrong(f"wrong-{i}") for i in range(6)),
    Student("size", {SIZE: 0.0}, {SIZE: VARIANCE}),
    Student("untitled", {TITLES: 0.0}),
    Student("open", {TITLES: None}, status="incomplete"),
    Student("void", dict.fromkeys((c.id for c in RUBRIC.checks), 0.0), status="empty"),
)  # fmt: skip


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return make_class(tmp_path / "out", CLASS)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return in_process(capsys)


def results() -> dict[str, Result]:
    return {each.id: result_of(each) for each in CLASS}


def typed(path: Path, *rows: str, head: str = "id,criterion,points,comment") -> Path:
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return path


def everybody(points: float, path: Path, ids: int = 6) -> Path:
    """The marks of somebody who gives so many points where an id is taken for an address, and full points elsewhere."""
    rows = [f"wrong-{i},sensor_access,{points},no address" for i in range(ids)]
    return typed(path, *rows, *(f"sound-{i},sensor_access,20," for i in range(6)))


# ---- the sample ----


def test_a_sample_is_the_same_each_time_has_a_quarter_of_sound_work_and_shows_every_fault() -> None:
    ids = sample.draw(results(), 6)
    assert ids == sample.draw(dict(reversed(results().items())), 6)
    assert {"size", "untitled"} < set(ids)
    assert sorted(re.sub(r"-\d", "", id_) for id_ in ids) == ["size", "sound", "sound", "untitled", "wrong", "wrong"]
    assert set(sample.draw(results(), 99)) == results().keys() - {"open", "void"}


def test_the_marking_page_shows_code_pictures_and_fields_and_nothing_that_we_think_of_it(
    out: Path, run: Run, tmp_path: Path
) -> None:
    code, said, _ = run("calibrate", out, "--sample", 99, "-o", tmp_path / "sample")
    assert (code, said.splitlines()[0]) == (
        0,
        "14 submissions to mark: open marking.html in a browser, or fill in marks-blank.csv",
    )
    page = (tmp_path / "sample" / "marking.html").read_text(encoding="utf-8")
    read = words(page.partition("<body")[2].partition("<script")[0])
    assert "1 class LowPassFilter:" in read
    assert "return x # &lt;b&gt;bold&lt;/b&gt;" in read
    assert "data:image/png;base64," in page
    assert page.count('type="number"') == 14 * 5
    told = ("wrong-", "sound-", "sensor-id", "sensor id as", "another sensor", "sensor_adr", "failed", "passed")
    assert [word for word in told if word in read] == []
    assert "://" not in page


# ---- marks ----


def test_marks_may_come_from_any_spreadsheet_and_blank_fields_are_not_compared(out: Path, tmp_path: Path) -> None:
    file = tmp_path / "marks.csv"
    file.write_bytes(
        'Comment;Points;Criterion;ID\r\n"\'=wrong";13,5;filtering;size\r\n;;noise_model;size\r\n'.encode("utf-16")
    )
    with Store.existing(out) as store:
        found = calibrating.read(store, file)
    assert found.cells == {("size", "filtering"): Mark(13.5, 13.5, 13.5, "=wrong")}


BAD = {
    "size,noise_model,21,": ":2: points 21: enter a number from 0 to 20, or leave it blank",
    "size,noise_model,many,": ":2: points many: enter a number from 0 to 20, or leave it blank",
    "nobody,noise_model,2,": ":2: no submission nobody in this class; give an id, a name or an address",
    "size,noise,2,": ":2: no criterion noise; the criteria are sensor_access, data_collection, visualization, noise_model, filtering",
    "size,noise_model,2,\nsize,noise_model,3,": ":3: a second mark for size in noise_model; remove one of the two rows",
    "size,noise_model,,": ": no row has points; fill in the column points",
    "void,filtering,3,": "the marks are all about submissions that are repaired or not graded; mark others, or grade the class again",
}  # fmt: skip


@pytest.mark.parametrize("row", BAD)
def test_what_cannot_be_compared_is_said_in_one_line(row: str, out: Path, run: Run, tmp_path: Path) -> None:
    code, said, told = run("calibrate", out, "--marks", typed(tmp_path / "m.csv", row))
    assert (code, said) == (2, "")
    assert told.startswith("imugrade: ")
    assert told.endswith(f"{BAD[row]}\n")
    assert told.count("\n") == 1


def test_one_of_sample_and_marks_is_needed_and_a_table_needs_its_columns(out: Path, run: Run, tmp_path: Path) -> None:
    assert run("calibrate", out)[::2] == (
        2,
        "imugrade: calibrate: give --sample N to draw submissions, or --marks FILE to compare\n",
    )
    file = typed(tmp_path / "m.csv", "size,3", head="id,grade")
    assert run("calibrate", out, "--marks", file)[2].endswith(
        ":1: no column criterion, points; the columns are id, criterion, points, low, high, comment, rubric\n"
    )


# ---- comparison ----


def cells(*marks: Mapping[str, float | Mark]) -> list[ComparedCell]:
    """Compare marks of *Sensor access*."""
    made = [
        Marks("m", {(id_, "sensor_access"): m if isinstance(m, Mark) else Mark(m, m, m) for id_, m in each.items()})
        for each in marks
    ]
    return compare(results(), made)


def test_the_distance_is_from_the_mean_of_the_marks_and_a_range_of_one_marker_is_enough() -> None:
    found = agreement("", cells({"wrong-0": Mark(10, 8, 14), "sound-0": 20}, {"wrong-0": 12, "sound-0": 20}))
    assert (found.cells, found.apart, found.distance, found.difference) == (2, 1.0, 1.5, 1.5)
    assert found.outside == 0
    assert agreement("", cells({"wrong-0": Mark(10, 8, 13)})).outside == 1


def test_the_interval_is_students_t_over_the_submissions() -> None:
    found = agreement(
        "", cells({"wrong-0": 13, "wrong-1": 12, "wrong-2": 11})
    )  # distances 1, 2, 3: mean 2, deviation 1
    assert found.uncertainty == pytest.approx(4.3027 / 3**0.5, abs=1e-4)
    assert agreement("", cells({"wrong-0": 13, "wrong-1": 12})).uncertainty is None


def test_false_deductions_come_first_then_missed_faults_then_the_largest_difference() -> None:
    found = differing(
        cells({"wrong-0": 10, "wrong-1": 20, "wrong-2": 17, "sound-0": 19.5, "sound-1": 20, "wrong-3": 14})
    )
    told = [(cell.id, cell.kind) for cell in found]
    assert told == [
        ("wrong-1", "false deduction"),
        ("sound-0", "missed fault"),
        ("wrong-0", "too mild"),
        ("wrong-2", "too hard"),
    ]


def test_each_fault_that_is_named_where_we_differ_has_its_own_distance() -> None:
    marked = cells({"wrong-0": 10, "wrong-1": 14, "sound-0": 19.5})
    assert [(each.title, each.cells, each.distance) for each in by_fault(marked)] == [("sensor-id-as-address", 2, 2.0)]


# ---- proposal ----


def final_grades() -> dict[str, FinalGrade]:
    return {id_: FinalGrade(id_, result) for id_, result in results().items()}


def test_a_proposal_comes_closer_to_several_marks_says_whose_grade_changes_and_can_be_pasted() -> None:
    marked = cells({f"wrong-{i}": 17 for i in range(6)})
    found = propose(RUBRIC, marked, final_grades())
    assert found is not None
    block = yaml.safe_load("\n".join(found.block()))
    assert block == {"faults": {"sensor-id-as-address": 4}}  # between 6 and 3; the present value counts as two marks
    assert (found.before, found.after, found.unseen) == (3.0, 1.0, 1.0)
    assert list(found.moved) == [(f"wrong-{i}", 94.0, 96.0) for i in range(6)]
    pasted = rubric.parse(LAB, f"{RUBRIC.text}\n{yaml.safe_dump(block)}".encode())
    after = regraded(final_grades(), pasted)
    assert {after[f"wrong-{i}"].final for i in range(6)} == {96.0}
    assert after["sound-0"].final == 100


def test_three_marks_do_not_move_the_table_and_no_fault_becomes_free() -> None:
    assert propose(RUBRIC, cells({f"wrong-{i}": 20 for i in range(3)}), final_grades()) is None
    one = propose(RUBRIC, cells({"wrong-0": 15, **{f"sound-{i}": 20 for i in range(6)}}), final_grades())
    assert one is not None
    assert one.changes == ()
    free = propose(RUBRIC, cells({f"wrong-{i}": 20 for i in range(6)}), final_grades())
    assert free is not None
    assert [change.after >= 0.5 for change in free.changes] == [True]


def test_what_no_deduction_reaches_is_said() -> None:
    found = propose(RUBRIC, cells({f"sound-{i}": 10 for i in range(6)}), final_grades())
    assert found is not None
    assert found.sentences() == [
        "The present deductions fit: no change brings the marks nearer than 10.00.",
        "10.00 of it lies in cells where no fault is named. No deduction reaches them; read them one by one.",
    ]


def test_the_command_compares_two_people_and_changes_no_grade(out: Path, run: Run, tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    files = [everybody(17, tmp_path / "a.csv"), everybody(16, tmp_path / "b.csv")]
    code, said, told = run("calibrate", out, "--marks", files[0], "--marks", files[1], "-o", tmp_path / "pages")
    assert (code, told) == (0, "")
    assert "| Sensor access | 12 | 0.50 | 1.25 ± 0.83 | −1.25 | 6 |" in " ".join(said.split())
    assert (
        "6 final grades of the class would change.\nfaults:\n  sensor-id-as-address: 4 # 6 at present; 6 marks\n"
        in said
    )
    page = words((tmp_path / "pages" / "comparison.html").read_text(encoding="utf-8"))
    assert "Too hard: wrong-0, Sensor access We: 14 of 20 −6" in page
    assert "wrong-0 94 96" in page
    assert "Marker 2: 16 no address" in page
    assert {path: path.read_bytes() for path in before} == before


def test_marks_of_another_rubric_of_few_submissions_or_of_ungraded_work_are_compared_with_a_word(
    out: Path, run: Run, tmp_path: Path
) -> None:
    file = typed(
        tmp_path / "m.csv", "size,noise_model,14,abc", "open,filtering,20,abc", head="id,criterion,points,rubric"
    )
    said = run("calibrate", out, "--marks", file)[1].splitlines()
    assert said[:3] == [
        "m: marked under another rubric than the class has now; points are compared as they are",
        "not compared, as repaired or not graded: open",
        "no proposal: 1 submission with marks; mark 5 or more",
    ]


# ---- the review desk ----


@pytest.fixture
def desk(out: Path) -> Iterator[Desk]:
    with desk_over(out) as opened:
        yield opened


def test_two_people_mark_the_same_sample_at_the_desk_and_compare(desk: Desk, out: Path) -> None:
    first = re.findall(r'href="/calibrate\?id=([\w-]+)"', desk.get("/calibrate").text)
    assert len(set(first)) == 12
    id_ = first[0]
    page = words(desk.get(f"/calibrate?id={id_}").text.partition("<main")[2])
    assert [word for word in (id_, "sensor id", "another sensor", "failed", "passed") if word in page] == []
    assert (
        f'name="draft" value="/calibrate?id={id_}#marks"' in desk.get(f"/calibrate?id={id_}").text
    )  # kept until saved
    refused = desk.post("/calibrate", {"id": id_, "points:filtering": "21"})
    assert (refused.status, "points 21: enter a number from 0 to 20" in refused.text) == (400, True)
    saved = desk.post("/calibrate", {"id": id_, "points:filtering": "15", "comment:filtering": "=odd"})
    assert (saved.status, saved.headers["location"]) == (303, f"/calibrate?id={first[1]}")
    desk.post("/calibrate", {"id": id_, "points:filtering": "16,5"}, who="second")
    rows = list(csv.DictReader(io.StringIO((out / "calibration" / "marks-prof.csv").read_text(encoding="utf-8"))))
    assert len(rows) == 12 * 5
    assert [(row["id"], row["points"], row["comment"]) for row in rows if row["points"]] == [(id_, "15", "'=odd")]
    assert "Marker 2: 16.5 No sentence." in words(desk.get("/calibrate?compare=yes").text)
    everybody(17, out / "calibration" / "marks-third.csv")
    preview = re.findall(r'href="(/what-if\?price[^"]+)"', desk.get("/calibrate?compare=yes").text)
    assert "6 of 16 final grades change" in words(desk.get(preview[0].replace("&amp;", "&")).text)
    desk.post("/calibrate", {"id": first[1], "points:filtering": "19", "do": "full"})
    rows = list(csv.DictReader(io.StringIO((out / "calibration" / "marks-prof.csv").read_text(encoding="utf-8"))))
    assert [row["points"] for row in rows if row["id"] == first[1]] == ["20", "20", "20", "20", "19"]
    assert desk.post("/calibrate", {"id": "void", "points:filtering": "1"}).status == 400
