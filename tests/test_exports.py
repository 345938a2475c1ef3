"""Tests of exports: a platform reads the intended grades, and its own content of the file stays the same byte for byte."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.course.record.store import Key, Store
from grader.people.final_grade import Adjustment, FinalGrade, HandIn, Lateness, Person, points_by_check
from grader.platforms import canvas, moodle, registry
from grader.platforms.filled import Filled
from grader.platforms.gradescope import COLUMNS, gradescope_csv
from grader.platforms.platform import Template
from grader.platforms.sheet import read_sheet
from tests import classes
from tests.class_commands import column, commands, in_process, rubric_with
from tests.fake_results import check, result

FORMATS = registry.names("fill", "write")


def final_grade(id_: str, *people: Person, points: float = 87.5, **more: object) -> FinalGrade:
    made = result(check(points=points, max_points=100.0))
    return FinalGrade(id_, made, HandIn(people, **more))  # type: ignore[arg-type]


def class_of(*final_grades: FinalGrade) -> dict[str, FinalGrade]:
    return {each.id: each for each in final_grades}


JANE = Person('Doe, Jane "JD"', "101", "canvas", sid="s1")
HEAD = "Student,ID,SIS User ID,SIS Login ID,Section,Lab 03 (4700),Lab 04-01 (4711),Final Score\n"
POINTS = "    Points Possible,,,,,50.0,100.0,(read only)\n"


def canvas_file(*rows: str) -> bytes:
    return (HEAD + POINTS + "".join(f"{row}\n" for row in rows)).encode()


# ---- in at one end, out at the other ----


CLASS = classes.a_class(3, [{"filters.py": "# 1\n"}, {"filters.py": "# 0.5\n"}])


@pytest.mark.parametrize("shape", classes.SHAPES)
def test_a_class_in_each_shape_gets_the_same_marks_and_its_reports_back(
    shape: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = commands(monkeypatch, capsys)
    path, out = classes.SHAPES[shape](CLASS, tmp_path / "in"), tmp_path / "out"
    assert run("grade", path, "-o", out)[0] == 0
    assert classes.marks_from(shape, CLASS, out, run) == {"s00000": 100.0, "s00001": 97.0, "s00002": 100.0}
    assert run("export", out, "-f", "csv", "--feedback", tmp_path / "reports.zip")[0] == 0
    reports = (tmp_path / "reports.zip").read_bytes()
    pages = {page.read_bytes() for page in out.glob("submissions/*/report.html")}
    assert len(pages) == len(CLASS)
    if shape == "canvas":
        taken = classes.canvas_feedback(reports)
        with zipfile.ZipFile(path) as archive:
            handed_in = {tuple(t for t in name.split("_") if t.isdigit())[:2] for name in archive.namelist()}
        assert set(taken) <= handed_in
        assert ({user for user, _ in taken}, set(taken.values())) == ({s.canvas for s in CLASS}, pages)
    elif shape.startswith("moodle"):
        taken_by_number = classes.moodle_feedback(reports)
        assert (set(taken_by_number), set(taken_by_number.values())) == ({s.moodle for s in CLASS}, pages)
    else:
        assert len(
            [n for n in zipfile.ZipFile(io.BytesIO(reports)).namelist() if n.startswith("send-yourself/")]
        ) == len(CLASS)


# ---- Canvas ----


def last_cells(filled: Filled) -> list[str]:
    return [line.split(",")[-1] for line in filled.data.decode().splitlines()[2:]]


def unmatched(filled: Filled) -> list[str]:
    return [name for _, name in filled.unmatched]


def test_canvas_gets_the_student_columns_verbatim_and_the_one_assignment() -> None:
    jane, test = '"Doe, Jane ""JD""",101,s1,jd,"Tue, 10:00",40,,40', '"Student, Test",9,,f00,A,,,'
    template = canvas_file(jane, "Müller,102,s2,m,A,41,12.0,41", test)
    filled = canvas.fill(Template(template, "t.csv", "Lab 04-01"), class_of(final_grade("jd_101", JANE)))
    assert filled.data.decode() == (
        "Student,ID,SIS User ID,SIS Login ID,Section,Lab 04-01 (4711)\n"
        "    Points Possible,,,,,100.0\n"
        '"Doe, Jane ""JD""",101,s1,jd,"Tue, 10:00",87.5\n'
        "Müller,102,s2,m,A,12.0\n"
        '"Student, Test",9,,f00,A,\n'
    )
    assert (filled.grades, unmatched(filled)) == (1, ["Müller"])  # nobody misses Canvas's own student


REFUSED = {
    "name the assignment with --column; columns found: Lab 03 (4700), Lab 04-01 (4711)": (canvas_file(), None),
    "the assignment is out of 50, and the rubric out of 100; add --scale to have the points scaled, or make them equal on the "
    "platform or in rubric.yaml": (canvas_file("D,101,s1,jd,A,,,"), "4700"),
    "the assignment is out of 0, and the rubric out of 100; add --scale to have the points scaled, or make them equal on the "
    "platform or in rubric.yaml": (
        f"{HEAD}    Manual Posting,,,,,,,\n{POINTS}D,101,s1,jd,A,,,".replace("100.0", "0").encode(),
        "4711",
    ),
    "Canvas imports no column with a title such as Final Points lab (9); rename the assignment in Canvas": (
        b"Student,ID,Section,Final Points lab (9)\nD,101,A,\n",
        None,
    ),
    "is not a Canvas gradebook; export one in Canvas with Grades > Export": (b"a,b\n", None),
    "is not CSV here; export the file again": (b'Student,"x\nID', None),
}


@pytest.mark.parametrize("line", REFUSED)
def test_a_gradebook_that_cannot_be_filled_is_refused_in_one_line(line: str) -> None:
    template, column = REFUSED[line]
    with pytest.raises(RequestError, match=rf"^t\.csv(:1)?: {re.escape(line)}$"):
        canvas.fill(Template(template, "t.csv", column), class_of(final_grade("x", JANE)))


def test_who_is_excused_or_not_judged_keeps_what_the_gradebook_has() -> None:
    unjudged = result(check("not_judged", None, max_points=100.0), status="incomplete")
    open_ = FinalGrade("li", unjudged, HandIn((Person("Li", "102", "canvas"),)))
    for excused in ("EX", "ex"):
        template = canvas_file(f"Doe,101,,,A,,{excused},", "Li,102,,,A,,7,")
        filled = canvas.fill(Template(template, "t.csv", "4711"), class_of(final_grade("jd", JANE), open_))
        assert last_cells(filled) == [excused, "7"]
    assert (filled.kept, unmatched(filled)) == (["Doe"], [])


def test_two_students_of_one_name_never_get_each_others_marks() -> None:
    """One of two handed in; the other's row has another number, and so stays as it is."""
    twins = canvas_file('"Doe, Jane",103,s3,x,A,,,', '"Doe, Jane",101,s1,y,A,,,')
    everyone = class_of(final_grade("doejane_101", Person("doejane", "101", "canvas")))
    filled = canvas.fill(Template(twins, "t", "4711"), everyone)
    assert last_cells(filled) == ["", "87.5"]
    by_name = class_of(final_grade("a", Person("Jane Doe")))
    filled = canvas.fill(Template(twins, "t", "4711"), by_name)
    assert filled.grades == 0
    assert filled.without_row(by_name["a"]) == [Person("Jane Doe")]
    assert unmatched(filled) == ["Doe, Jane", "Doe, Jane"]


def test_semicolons_names_in_two_columns_and_a_gradebook_without_a_last_newline() -> None:
    text = 'LastName;FirstName;ID;SIS Login ID;Section;Lab (1)\n    Points Possible;;;;;"100,0"\nDoe;Jane;7;x;A;'
    for file, grade in ((text, "87,5"), (text.replace(";", ","), '"87,5"')):
        filled = canvas.fill(Template(file.encode(), "t.csv"), class_of(final_grade("a", Person("Jane Doe"))))
        assert filled.data.decode() == file + grade


# ---- Moodle ----


def worksheet(*rows: str) -> bytes:
    head = 'Identifier,"Full name","Email address",Status,Group,Grade,"Maximum Grade","Grade can be changed","Last modified (grade)","Feedback comments"'
    return b"\xef\xbb\xbf" + "".join(f"{row}\r\n" for row in (head, *rows)).encode()


MOODLE = Person("Jürgen Müßig", "12", "moodle")
PLAIN = final_grade("a", MOODLE)
LATE = final_grade("a", MOODLE, late=Lateness("2026-11-20T23:59+01:00", 90_000, 2, 20.0))
SEEN = Adjustment("sensor_access", 90.0, "seen", "me", "now", points_by_check(LATE.result.criteria[0]))


@pytest.mark.parametrize(
    ("final_grade", "before", "after"),
    [
        (PLAIN, ("", ""), ("87.5", '"Marks: Sensor access 87.5 / 100; final 87.5 = score 87.5"')),
        (PLAIN, ("", '"Come to my office"'), ("87.5", '"Come to my office"')),
        (replace(LATE, adjustments=(SEEN,)), ("87.5", '"Marks: old"'), ("70", '"Marks: Sensor access 90 / 100 (overridden); final 70 = score 90 (with overrides) − late 20"')),
    ],
)  # fmt: skip
def test_a_worksheet_gets_the_grade_and_a_comment_unless_a_teachers_is_there_and_keeps_every_other_byte(
    final_grade: FinalGrade, before: tuple[str, str], after: tuple[str, str]
) -> None:
    row = '"Participant 12","Jürgen Müßig", j@example.edu ,"Submitted, late",,{},100.00,Yes,-,{}'
    other = '"Participant 13","=1+1 ""X""",x@example.edu,-,"",55.00,100.00,Yes,"Friday, 1",""'
    filled = moodle.fill(Template(worksheet(row.format(*before), other), "w.csv"), class_of(final_grade))
    assert filled.data == worksheet(row.format(*after), other)


def test_a_row_of_a_worksheet_is_found_by_its_id_number_or_its_user_name() -> None:
    text = "Identifier,ID number,Username,Grade\nParticipant 12,4711,jd,\n"
    for name in ("4711", "jd"):
        filled = moodle.fill(Template(text.encode(), "w.csv"), class_of(final_grade(name, Person(name, name))))
        assert filled.grades == 1


def test_a_team_is_found_by_its_group_and_a_site_in_another_language_by_its_column() -> None:
    team = class_of(final_grade("Team_Red_4", Person("Team Red", "4", "moodle")))
    rows = ['"Participant 12",J,,,"Team Red",,100,Yes,-,', '"Participant 4",K,,,"Team Blue",,100,Yes,-,']
    filled = moodle.fill(Template(worksheet(*rows), "w.csv"), team)
    assert [line.split(",")[5] for line in filled.data.decode().splitlines()[1:2]] == ["87.5"]
    german = 'ID;"Vollständiger Name";Bewertung;Bestwertung;Gruppe\nTeilnehmer/in12;"Jürgen Müßig";;100,00;\n'
    filled = moodle.fill(Template(german.encode(), "w.csv", "Bewertung"), class_of(final_grade("a", MOODLE)))
    assert filled.data.decode() == german.replace('";;', '";87,5;')
    with pytest.raises(RequestError, match=r"^w.csv: has no column Grade; download the grading worksheet, or name the"):
        moodle.fill(Template(german.encode(), "w.csv"), team)


# ---- Gradescope, and CSV in general ----


def test_every_member_of_a_group_has_a_row_with_the_groups_points() -> None:
    people = (
        Person("Lee, Ann", sid="s1", email="ann@example.edu", section="B"),
        Person("Jane Doe"),
        Person('=CMD("x")', sid="s2"),
        Person("Martin King, Jr."),
    )
    when = "2026-11-20T21:00:00+00:00"
    group = final_grade("g", *people, number="77", submitted=when, late=Lateness("x", 3725, 1, 8.0))
    rows = list(csv.reader(io.StringIO(gradescope_csv(class_of(group)))))
    shared = ["79.5", "100", "Graded", "77", when, "01:02:05", "", ""]
    assert rows == [
        list(COLUMNS),
        ["Ann", "Lee", "s1", "ann@example.edu", "B", *shared],
        ["Jane", "Doe", "", "", "", *shared],
        ["", '\'=CMD("x")', "s2", "", "", *shared],
        ["Martin", "King, Jr.", "", "", "", *shared],
    ]


CELLS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0\r"), max_size=5)


@given(
    st.lists(st.lists(CELLS, min_size=2, max_size=4), min_size=1, max_size=4),
    st.sampled_from(",;\t"),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
)
def test_any_table_is_taken_apart_and_put_together_again_without_a_change(
    table: list[list[str]], delimiter: str, end: str, marked: bool
) -> None:
    """But for a bare carriage return, which Python's writer leaves without quotes and no reader can place."""
    table = [["Student", "ID", "Name", "Section"], *table]
    text, quoting = io.StringIO(), csv.QUOTE_ALL if marked else csv.QUOTE_MINIMAL
    csv.writer(text, delimiter=delimiter, lineterminator=end, quoting=quoting).writerows(table)
    data = (b"\xef\xbb\xbf" if marked else b"") + text.getvalue().encode()
    sheet = read_sheet(data, "t.csv")
    assert sheet.data() == data
    assert [[row.value(i) for i in range(len(row.cells))] for row in sheet.rows] == table


# ---- the command ----


def test_an_export_that_makes_no_sense_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Store(tmp_path) as store:
        store.keep(Key("alice", "s", "r", "t", "0"), result())
    export = ("export", tmp_path, "-f")
    unknown = f"imugrade: --format excel: unknown value; choose {', '.join(FORMATS)}\n"
    assert in_process(capsys)(*export, "excel") == (2, "", unknown)
    missing = "imugrade: --format canvas needs --template with the file that it exports\n"
    assert in_process(capsys)(*export, "canvas") == (2, "", missing)


# ---- relative paths, in a class large enough that its pages are written by several processes ----

MANY = 50
"""Students of the class; most handed in nothing that can be graded: their pages are written all the same."""
BESIDE_PYTHON = Path(os.__file__).parent
"""Where the processes of the grader start: nothing may be left there."""


def imugrade(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grader", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def files_outside(folder: Path, out: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if not path.is_relative_to(out)}


def test_a_large_class_is_graded_regraded_and_exported_by_relative_paths(tmp_path: Path) -> None:
    """By the README's command with the shipped rubric, then with another one."""
    (tmp_path / "download").mkdir()
    kinds = [classes.filters_alone(1.0), classes.filters_alone(0.5), *[{"notes.txt": "Not yet."}] * 23]
    classes.moodle(classes.a_class(MANY, kinds), tmp_path / "download").rename(tmp_path / "moodle.zip")
    rubric_with(tmp_path / "rub.yaml", ("follows_recursion: 6", "follows_recursion: 9"))
    before, beside = files_outside(tmp_path, tmp_path / "out"), set(BESIDE_PYTHON.iterdir())
    for arguments in ((), ("--rubric", "rub.yaml", "--change")):
        done = imugrade(tmp_path, "grade", "moodle.zip", "-o", "out", *arguments)
        assert done.returncode == 0, done.stderr
        assert "out/index.html" in done.stdout
        assert str(tmp_path) not in done.stdout
    assert files_outside(tmp_path, tmp_path / "out") == before
    assert set(BESIDE_PYTHON.iterdir()) == beside

    records = tmp_path.glob("out/submissions/*/result.json")
    published = {path.parent.name: json.loads(path.read_text())["score"] for path in records}
    scores = {id_: float(total or 0) for id_, total in column(tmp_path / "out" / "gradebook.csv", "total").items()}
    assert len(published) == MANY
    assert published == pytest.approx(scores)
    export = ("export", "out", "--format", "csv", "-o", "marks.csv", "--feedback")
    exported = imugrade(tmp_path, *export, "reports.zip")
    assert exported.returncode == 0, exported.stderr
    sent = classes.moodle_feedback((tmp_path / "reports.zip").read_bytes())
    assert sorted(sent.values()) == sorted(path.read_bytes() for path in tmp_path.glob("out/submissions/*/report.html"))

    report = sorted(tmp_path.glob("out/submissions/*/report.html"))[4]
    report.write_bytes(report.read_bytes().replace(b"</body>", b"<p>old</p></body>"))
    refused = imugrade(tmp_path, *export, "new.zip")
    assert refused.returncode == 2
    assert f"1 of {MANY} reports do not match the record ({report.parent.name})" in refused.stderr
    assert not (tmp_path / "new.zip").exists()
