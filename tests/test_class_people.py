"""People of a class and their dates: every identifier counts, groups and those without a submission stand in every file, doubt is told."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from tests.class_commands import Run, cells, column, commands, graded, hand_in, late_policy, rubric_with
from tests.classes import a_class, canvas_feedback, gradescope, moodle_feedback
from tests.corpus.writing import zipped
from tests.desk import desk_over, words

GITHUB_ROSTER = '"identifier","github_username","github_id","name"\n"s1001","jdoe-gh","9001","Jane Doe"\n"s1002","rroe42","9002",""\n"s1003","","",""\n'
"""What GitHub Classroom downloads as `classroom_roster.csv`."""
STOPPED = "imugrade: grades contradict each other (see above); add --anyway to write the file. Nothing was written\n"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    return commands(monkeypatch, capsys)


def test_the_roster_of_github_classroom_is_taken_as_it_is_downloaded(run: Run) -> None:
    for name in ("lab04-jdoe-gh", "lab04-rroe42"):
        hand_in(Path("class"), **{name: 1})
        Path("class", name, ".git").mkdir()
        Path("class", name, ".git", "HEAD").write_text("ref: refs/heads/main\n")
    err = graded(run, roster=GITHUB_ROSTER)
    assert "in the roster, no submission: s1003\n" in err
    assert "the same files were handed in by: lab04-jdoe-gh; lab04-rroe42\n" in err
    assert cells("out/gradebook.csv", "id", "name", "status") == [
        ("lab04-jdoe-gh", "Jane Doe", "graded"),
        ("lab04-rroe42", "lab04-rroe42", "graded"),
        ("s1003", "s1003", "no submission"),
    ]
    with desk_over(Path("out").absolute()) as desk:
        assert '<option value="s1003">' in desk.get("/").text, "Find suggests people of the roster"
    for word in ("s1001", "jdoe-gh", "9001", "Jane Doe", "Doe, Jane", "JANE DOE"):
        assert "1 on record" in run("grade", "class", "-o", "out", "--only", word)[1]
        assert run("adjust", "out", word, "--criterion", "filtering", "--comment", word)[0] == 0
    for more, out, grade in (
        ((), "2 grades, 1 blank", ""),
        (("--missing", "0"), "2 grades, 1 without a submission: 0", "0"),
    ):
        assert run("export", "out", "-f", "gradescope", "-o", "marks.csv", *more)[:2] == (0, f"marks.csv  {out}\n")
        assert cells("marks.csv", "SID", "Total Score", "Status") == [
            ("s1001", "100", "Graded"),
            ("s1002", "100", "Graded"),
            ("s1003", grade, "Missing"),
        ]


PAIR = "id,sis user id,login,name,email,group\n5038,S5038,ann1,Ann Lee,ann@example.edu,1\n5039,S5039,bob1,Bob Roe,bob@example.edu,1\n"
HEAD = "Student,ID,SIS User ID,SIS Login ID,Section,Lab (1)\n    Points Possible,,,,,100\n"


def canvas_download(**kept: float) -> None:
    """One file for each, by `<name>_<user id>`."""
    files = {f"{who}_{900 + at}_filters.py": f"# {share}\n".encode() for at, (who, share) in enumerate(kept.items())}
    Path("canvas.zip").write_bytes(zipped(files))


def test_a_partner_is_graded_in_every_platforms_file(run: Run) -> None:
    canvas_download(leeann_101=1)
    graded(run, folder="canvas.zip", roster=PAIR)
    Path("canvas.csv").write_text(HEAD + '"Lee, Ann",101,S5038,ann1,A,\n"Roe, Bob",102,S5039,bob1,A,\n')
    code, _, err = run("export", "out", "-f", "canvas", "--template", "canvas.csv", "-o", "filled.csv")
    assert (code, err) == (0, "imugrade: graded: 2\n")
    assert cells("filled.csv", "Lab (1)") == [("100",)] * 3
    assert "1 on record" in run("grade", "canvas.zip", "-o", "out", "--only", "ANN@example.edu")[1]
    with desk_over(Path("out").absolute()) as desk:
        assert '<option value="canvas" selected>' in desk.get("/export").text
    Path("moodle.csv").write_text(
        "Identifier,Full name,Email address,Grade,Maximum grade,Grade can be changed\n"
        "Participant 7,Ann Lee,ann@example.edu,,100,Yes\nParticipant 8,Bob Roe,bob@example.edu,,100,Yes\n"
    )
    assert run("export", "out", "-f", "moodle", "--template", "moodle.csv", "-o", "filled.csv")[0] == 0
    assert cells("filled.csv", "Grade") == [("100",)] * 2
    assert run("export", "out", "-f", "gradescope", "-o", "filled.csv")[::2] == (0, "imugrade: graded: 2\n")
    assert cells("filled.csv", "SID", "Total Score") == [("S5038", "100"), ("S5039", "100")]
    assert run("export", "out", "-f", "csv", "-o", "marks.csv", "--feedback", "reports.zip")[::2] == (
        0,
        "imugrade: graded: 2\nimugrade: the platform cannot place these reports; send them from send-yourself in the zip: Bob Roe\n",
    )
    with zipfile.ZipFile("reports.zip") as archive:
        assert sorted(archive.namelist()) == ["leeann_101_900_report.html", "send-yourself/Bob-Roe-S5039/report.html"]
    assert cells("marks.csv", "id", "name", "submission", "final") == [
        ("S5038", "Ann Lee", "leeann_101", "100"),
        ("S5039", "Bob Roe", "leeann_101", "100"),
    ]


@pytest.mark.parametrize(
    "roster", ["Student,ID,group\nAnn Lee,101,1\nBob Roe,102,1\n", "id,name,group\n101,Ann Lee,1\n102,Bob Roe,1\n"]
)
def test_canvas_takes_the_report_of_a_partner_of_an_assignment_of_groups(run: Run, roster: str) -> None:
    canvas_download(leeann_101=1)
    graded(run, folder="canvas.zip", roster=roster)
    _, _, err = run("export", "out", "-f", "csv", "--feedback", "reports.zip")
    assert "Canvas takes a partner's report only in an assignment of groups: Bob Roe\n" in err
    assert set(canvas_feedback(Path("reports.zip").read_bytes())) == {("101", "900"), ("102", "900")}


def test_every_person_has_one_identifier_of_the_same_kind_and_a_partner_gets_the_report(run: Run) -> None:
    hand_in(Path("class"), s5038=1)
    graded(run, roster="sid,id,name\ns5038,5038,Ann Lee\ns5040,5040,Cy Moe\n")
    for form, column_ in (("csv", "id"), ("gradescope", "SID")):
        assert run("export", "out", "-f", form, "-o", "marks.csv")[0] == 0
        assert cells("marks.csv", column_) == [("s5038",), ("s5040",)]
    Path("moodle.zip").write_bytes(zipped({"Ann Lee_7_assignsubmission_file/filters.py": b"# 1\n"}))
    team = "Identifier,Full name,Group\nParticipant 7,Ann Lee,1\nParticipant 8,Bob Roe,1\n"
    Path("team.csv").write_text(team)
    assert run("grade", "moodle.zip", "-o", "pair", "--roster", "team.csv")[0] == 0
    assert run("export", "pair", "-f", "csv", "--feedback", "reports.zip")[0] == 0
    assert set(moodle_feedback(Path("reports.zip").read_bytes())) == {"7", "8"}


def test_a_number_with_and_without_its_letter_is_one_person_of_a_name(run: Run) -> None:
    canvas_download(leeann_101=1)
    graded(run, folder="canvas.zip", roster="id,name,group\n5038,Ann Lee,1\n5039,Bob Roe,1\n")
    Path("canvas.csv").write_text(HEAD + '"Lee, Ann",101,S5038,,A,\n"Roe, Bob",102,S5039,,A,\n')
    code, _, err = run("export", "out", "-f", "canvas", "--template", "canvas.csv", "-o", "filled.csv")
    assert (code, err) == (0, "imugrade: graded: 2\n")
    Path("canvas.csv").write_text(HEAD + '"Lee, Ann",101,S5038,,A,\n"Roe, Bob",102,S6000,,A,\n')
    code, _, err = run("export", "out", "-f", "canvas", "--template", "canvas.csv", "-o", "filled.csv")
    assert (code, err) == (
        2,
        "imugrade: graded: 1\n"
        "imugrade: unmatched, left as they are: 1 (Roe, Bob: not leeann_101 (Bob Roe, 5039): numbers S6000 and 5039)\n"
        f"imugrade: Bob Roe: graded, and not in the file\n{STOPPED}",
    )
    refill = ("export", "out", "-f", "canvas", "--template", "canvas.csv", "-o", "again.csv")
    assert not Path("again.csv").exists()
    assert run(*refill, "--anyway", "--missing", "0")[0] == 0  # a row that may mean somebody who handed in gets no 0
    assert cells("again.csv", "Lab (1)") == [("100",), ("100",), ("",)]


def test_people_of_one_name_are_told_apart_by_their_ids_wherever_one_is_named(run: Run) -> None:
    hand_in(Path("class"), ann1=1, ann2=None, ann3=None)
    roster = "id,name\nann1,Ann Lee\nann2,Ann Lee\nann3,Ann Lee\nann4,Ann Lee\nann5,Ann Lee\ncy,Cy Moe\n"
    err = graded(run, roster=roster)
    assert "in the roster, no submission: Ann Lee (ann4); Ann Lee (ann5); Cy Moe\n" in err
    assert "no gradable files (review what was handed in): ann2; ann3\n" in err
    assert "the same files" not in err
    names = [
        ("ann1", "Ann Lee", "graded"),
        ("ann2", "Ann Lee", "empty"),
        ("ann3", "Ann Lee", "empty"),
        ("ann4", "Ann Lee (ann4)", "no submission"),
        ("ann5", "Ann Lee (ann5)", "no submission"),
        ("cy", "Cy Moe", "no submission"),
    ]
    assert cells("out/gradebook.csv", "id", "name", "status") == names
    err = run("export", "out", "-f", "csv", "-o", "marks.csv")[2]
    assert cells("marks.csv", "id", "name", "status") == names
    why = "empty or unreadable; give points in the review desk, or --unreadable 0"
    assert (
        f"imugrade: blank: 5 (Ann Lee (ann2): {why}; Ann Lee (ann3): {why}; Ann Lee (ann4): no submission;"
        " Ann Lee (ann5): no submission; Cy Moe: no submission)\n" in err
    )


def test_who_handed_in_nothing_or_an_empty_folder_stands_in_every_file(run: Run) -> None:
    hand_in(Path("class"), ann=1, bob=None)
    Path("roster.csv").write_text("id,name,section\nann,Ann Lee,A\nbob,Bob Roe,A\ncy,Cy Moe,B\n")
    code, out, _ = run("grade", "class", "-o", "out", "--roster", "roster.csv")
    assert (code, "\n2 graded · of these 1 empty · mean of graded 100.0\n" in out) == (0, True)
    assert "2 bob empty\n" in out  # no 0, as the grade is blank
    assert cells("out/gradebook.csv", "name", "section", "total", "status") == [
        ("Ann Lee", "A", "100", "graded"),
        ("Bob Roe", "A", "", "empty"),
        ("Cy Moe", "B", "", "no submission"),
    ]
    assert "Cy Moe B – – – – – – no submission" in words(Path("out/index.html").read_text(encoding="utf-8"))
    with desk_over(Path("out").absolute()) as desk:
        page = words(desk.get("/class?find=Cy").text)
        assert "Bob Roe bob A – – – – – – empty 1 Cy Moe cy B – – – – – – no submission" in page
        assert "no submission (1)" in page
    Path("canvas.csv").write_text(HEAD + '"Lee, Ann",101,ann,,A,\n')  # no row wants the grade that bob has not
    assert run("export", "out", "-f", "canvas", "--template", "canvas.csv", "-o", "filled.csv")[0] == 0
    for more, empty in ((), ""), (("--unreadable", "0"), "0"):
        assert run("export", "out", "-f", "csv", "-o", "marks.csv", *more)[0] == 0
        assert cells("marks.csv", "section", "final") == [("A", "100"), ("A", empty), ("B", "")]


def test_the_beginning_of_several_ids_is_ambiguous(run: Run) -> None:
    hand_in(Path("class"), jane_1=1, jane_2=0)
    graded(run)
    assert run("grade", "class", "-o", "out", "--only", "jane")[::2] == (
        2,
        "imugrade: jane is ambiguous: it may mean jane_1, jane_2; give the id\n",
    )


def test_a_contradiction_with_the_roster_is_told_with_its_row(run: Run) -> None:
    canvas_download(doejane_101=1)
    err = graded(run, folder="canvas.zip", roster="name,canvas_user_id,sid\nJane Doe,103,s3\n")
    assert "imugrade: roster.csv:2: Jane Doe not doejane_101 (doejane): canvas number 103 and 101\n" in err


def test_a_person_without_a_submission_can_be_given_points_that_stand_in_every_file(run: Run) -> None:
    hand_in(Path("class"), ann=1)
    graded(run, roster="id,name\nann,Ann Lee\ns5,Bob Roe\n")
    oral = ("--criterion", "total", "--points", 61, "--comment", "oral exam")
    assert run("adjust", "out", "bob roe", *oral)[:2] == (0, "s5 total 61, final 61\n")
    assert "s5" in run("adjust", "out")[1]
    assert cells("out/gradebook.csv", "id", "name", "final") == [("ann", "Ann Lee", "100"), ("s5", "Bob Roe", "61")]
    assert "final 61 = total 61 (set by" in words(Path("out/submissions/s5/report.html").read_text(encoding="utf-8"))
    told = graded(run)
    assert not any(line in told for line in ("no gradable files", "not in this download"))
    assert run("export", "out", "-f", "csv", "-o", "marks.csv")[1] == "marks.csv  2 grades\n"
    for table in ("marks.csv", "out/gradebook.csv"):
        assert cells(table, "id", "filtering", "final", "status")[1] == ("s5", "", "61", "no submission")
    assert run("adjust", "out", "s5", "--criterion", "total", "--withdraw", "--comment", "was Bo")[0] == 0
    assert cells("out/gradebook.csv", "id", "status") == [("ann", "graded"), ("s5", "no submission")]
    told = graded(run, roster="id,name,email\nann,Ann Lee,\ns5,Bob Roe,bob@x.edu\n")  # absent, as before the points
    assert "imugrade: in the roster, no submission: Bob Roe\n" in told


def test_points_without_a_submission_are_no_zeros_in_the_criteria_and_no_submission(run: Run) -> None:
    hand_in(Path("class"), ann=1)
    graded(run, roster="id,name,email\nann,Ann Lee,\ns5,Bob Roe,\n,Li,a+b@x.edu\n,Wei,a_b@x.edu\n")
    for target, points in (("filtering", 12), ("bonus", 1)):
        assert run("adjust", "out", "s5", "--criterion", target, "--points", points, "--comment", "oral")[0] == 0
    counted, cells_of = "1 submission, 1 without a submission, graded by hand", "– – – – 12 – 13"
    index = words(Path("out/index.html").read_text(encoding="utf-8"))
    assert f"<h1>{counted}</h1>" in Path("out/index.html").read_text(encoding="utf-8")
    assert f"Bob Roe {cells_of} no submission" in index
    with desk_over(Path("out")) as desk:
        assert all(counted in words(desk.get(page).text) for page in ("/", "/class"))
        page = words(desk.get("/submission/s5").text)
        assert "Filtering 12 / 20" in page
        assert "Sensor access – / 20" in page
        assert ", automatic" not in page
        assert {each.name for each in desk.book.on_thread(desk.book.absent).values()} == {"Li", "Wei"}  # alike ids
    assert "· automatic" not in words(Path("out/submissions/s5/report.html").read_text(encoding="utf-8"))


BOTH = "Bob Roe has two grades, 61 without a submission (s5), and 94 for bob_roe; withdraw the points of s5"


def test_points_without_a_submission_and_a_later_hand_in_stop_the_export_until_one_is_withdrawn(run: Run) -> None:
    hand_in(Path("class"), ann=1)
    graded(run, roster="id,name\nann,Ann Lee\ns5,Bob Roe\n")
    oral = ("adjust", "out", "s5", "--criterion", "total", "--comment", "oral exam")
    assert run(*oral, "--points", 61)[0] == 0
    hand_in(Path("class"), bob_roe=0)
    assert f"imugrade: {BOTH}\n" in graded(run)
    assert cells("out/gradebook.csv", "id", "final") == [("ann", "100"), ("bob_roe", "94"), ("s5", "61")]
    code, _, err = run("export", "out", "-f", "csv", "-o", "marks.csv")
    assert (code, f"{BOTH}\n" in err) == (2, True)
    with desk_over(Path("out")) as desk:
        assert f"Two grades Bob Roe (s5) l 61 {BOTH}" in words(desk.get("/").text)
    assert run(*oral, "--withdraw")[0] == 0
    assert run("export", "out", "-f", "csv", "-o", "marks.csv")[:2] == (0, "marks.csv  2 grades\n")


def test_the_desk_gives_points_to_a_person_without_a_submission_and_withdraws_them(run: Run) -> None:
    hand_in(Path("class"), ann=1)
    graded(run, roster="id,name\nann,Ann Lee\ns5,Bob Roe\n")
    with desk_over(Path("out")) as desk:
        for page in ("/", "/class"):
            assert '<a href="/submission/s5">Bob Roe</a>' in desk.get(page).text
        assert "No submission. Points that you give here" in words(desk.get("/submission/s5").text)
        assert desk.get("/find?who=s5").headers["location"] == "/submission/s5"
        assert desk.book.on_thread(desk.book.store.present).keys() == {"ann"}  # looking records nothing
        oral = {"target": "total", "points": 61, "comment": "oral exam", "seen": 0}
        assert desk.post("/submission/s5/override", oral).status == 303
        desk.book.settled()
        assert cells("out/gradebook.csv", "id", "final") == [("ann", "100"), ("s5", "61")]
        assert "No submission Bob Roe" not in words(desk.get("/").text)
        assert "another rubric" not in words(desk.get("/what-if").text)
        assert "Bob Roe s5 – – – – – – 61 no submission, adjusted" in words(desk.get("/class").text)
        assert desk.post("/submission/s5/override", {"target": "total", "do": "withdraw", "seen": 1}).status == 303
        desk.book.settled()
        assert "Bob Roe s5 – – – – – – no submission" in words(desk.get("/class").text)
        assert desk.post("/what-if", {"late:per_day": "10%", "do": "mark"}).status == 303
        assert desk.book.trouble == ""
    assert cells("out/gradebook.csv", "id", "status") == [("ann", "graded"), ("s5", "no submission")]
    assert (
        "61" not in words(Path("out/submissions/s5/report.html").read_text(encoding="utf-8")).partition("oral exam")[0]
    )


def test_a_number_that_lost_its_zeros_in_a_spreadsheet_gets_that_hint(run: Run) -> None:
    hand_in(Path("class"), **{"00501": 1})
    err = graded(run, roster="id,name\n501,Ann Lee\n502,Bob Roe\n")
    assert (
        "roster.csv:2: Ann Lee has 501, and a submission 00501: a spreadsheet drops zeros at the start; format" in err
    )
    assert "roster.csv:3" not in err


def test_a_person_who_stands_twice_in_the_roster_with_other_facts_is_told_with_both_rows(run: Run) -> None:
    hand_in(Path("class"), ann=1)
    rows = ("ann,Ann Lee,A,2026-11-20T12:00Z", "bob,Bob Roe,A,", "ann,Ann Lee,B,2026-11-24T12:00Z", "bob,Bob Roe,A,")
    err = graded(run, roster="\n".join(["id,name,section,due", *rows]))
    assert (
        "imugrade: roster.csv:2 and roster.csv:4: Ann Lee stands twice, with another due, section; the later date"
        in err
    )
    assert cells("out/gradebook.csv", "name", "section") == [("Ann Lee", "A"), ("Bob Roe", "A")]


def test_the_class_page_sorts_names_by_their_letters_without_accents(run: Run) -> None:
    hand_in(Path("class"), a=1, b=1)
    graded(run, roster="id,name\na,Zoë W\nb,Łukasz A\nc,Ødegård X\nd,Max Y\n")
    page = words(Path("out/index.html").read_text(encoding="utf-8")).partition("Status Łukasz")[2]
    assert sorted(("Zoë", "Max", "Ødegård"), key=page.index) == ["Max", "Ødegård", "Zoë"]


# ---- dates: time zones by name, grace days, and times that contradict each other ----

LOCAL = "2026-10-24T20:00"
"""The clocks in Berlin go back by an hour in the night that follows."""
IN_BERLIN = f"due: {LOCAL}, tz: Europe/Berlin"
CAME = "id,name,submitted\nann,Ann A,2026-10-25T19:30+01:00\nbob,Bob B,2026-10-25T20:30+01:00\ncy,Cy C,2026-10-24T20:30+02:00\n"


def deducted(run: Run, late: str, roster: str = CAME) -> dict[str, str]:
    """The points that a late policy takes off, as the gradebook has them."""
    hand_in(Path("class"), ann="1", bob="1.0", cy="1.00")
    rubric_with(Path("rub.yaml"), late_policy(late))
    assert graded(run, "--rubric", "rub.yaml", roster=roster) == ""
    return column(Path("out/gradebook.csv"), "late_deduction")


@pytest.mark.parametrize(
    ("due", "ann"), [(IN_BERLIN, "10"), (f"due: {LOCAL}+02:00, tz: Europe/Berlin", "10"), (f"due: {LOCAL}+02:00", "20")]
)
def test_days_are_counted_by_the_clock_of_the_time_zone_and_have_24_hours_without_one(
    run: Run, due: str, ann: str
) -> None:
    assert deducted(run, due) == {"ann": ann, "bob": "20", "cy": "10"}


def test_a_cut_off_is_by_the_clock_as_well(run: Run) -> None:
    deducted(run, f"{IN_BERLIN}, cut_off_days: 1")
    assert column(Path("out/gradebook.csv"), "late") == {"ann": "1", "bob": "refused", "cy": "1"}


def test_grace_days_of_a_student_are_taken_off_the_days_that_count(run: Run) -> None:
    head, *rows = CAME.splitlines()
    roster = "\n".join([f"{head},grace_days", f"{rows[0]},2", f"{rows[1]},1", f"{rows[2]},"])
    assert deducted(run, IN_BERLIN, roster) == {"ann": "0", "bob": "10", "cy": "10"}
    assert column(Path("out/gradebook.csv"), "grace_days_used") == {"ann": "1", "bob": "1", "cy": "0"}
    Path("roster.csv").write_text(roster.replace(",2\n", ",two\n"))
    refused = run("grade", "class", "-o", "out", "--roster", "roster.csv")
    assert refused[::2] == (2, "imugrade: roster.csv:2: grace days must be a whole number, not two\n")


def test_the_time_of_the_platform_goes_before_that_of_the_roster(run: Run) -> None:
    path = gradescope(a_class(3, [{"filters.py": "# 1\n"}]), Path())
    roster = "sid,submitted\ns00000,2026-11-21T09:00Z\ns00001,2026-11-20T21:00Z\ns00002,2026-11-20T09:00Z\n"
    err = graded(run, folder=path, roster=roster)
    assert (
        "imugrade: Jürgen_Müßig_s00000: submitted 2026-11-20T21:00:00+00:00 by the platform, which counts, "
        "and 2026-11-21T09:00:00+00:00 by the roster\n"
    ) in err
    assert "s00001: submitted" not in err
    assert set(column(Path("out/gradebook.csv"), "submitted").values()) == {"2026-11-20T21:00:00+00:00"}


WORKSHEET = (
    'Identifier,"Full name",Status,"Last modified (submission)","Last modified (grade)"\n'
    '"Participant 7","Ann A","Submitted for grading - Late","Sonntag, 25. Oktober 2026, 19:30",-\n'
    '"Participant 8","Bob B","Submitted for grading","Saturday, 24 October 2026, 7:59 PM",-\n'
    '"Participant 9","Cy C","No submission",-,-\n'
)


def test_the_times_of_moodles_worksheet_are_read_and_shown_by_the_clock_of_the_class(run: Run) -> None:
    files = {f"{who}_assignsubmission_file/filters.py": f"# {who[-1]}e-9\n".encode() for who in ("Ann A_7", "Bob B_8")}
    Path("moodle.zip").write_bytes(zipped(files))
    rubric_with(Path("rub.yaml"), late_policy(IN_BERLIN))
    graded(run, "--rubric", "rub.yaml", folder="moodle.zip", roster=WORKSHEET)
    assert cells("out/gradebook.csv", "name", "submitted", "late_deduction") == [
        ("Ann A", "2026-10-25T19:30:00+01:00", "10"),
        ("Bob B", "2026-10-24T19:59:00+02:00", "0"),
        ("Cy C", "", ""),
    ]
    report = words(next(Path("out").glob("submissions/Ann*/report.html")).read_text(encoding="utf-8"))
    assert "due 2026-10-24 20:00 UTC+02:00; handed in 2026-10-25 19:30 UTC+01:00" in report


def test_without_a_time_zone_the_worksheet_marks_who_is_late_and_the_gradebook_has_the_columns(run: Run) -> None:
    Path("moodle.zip").write_bytes(zipped({"Ann A_7_assignsubmission_file/filters.py": b"# 1\n"}))
    rubric_with(Path("rub.yaml"), late_policy(f"due: {LOCAL}+02:00"))
    err = graded(run, "--rubric", "rub.yaml", folder="moodle.zip", roster=WORKSHEET)
    assert "roster.csv: its times are not read, as they have no offset from UTC; add `tz` to the late policy\n" in err
    assert "deducts nothing from Ann_A_7, which the platform marks as late: their time is unknown" in err
    assert cells("out/gradebook.csv", "late", "late_deduction", "final")[0] == ("unknown", "0", "100")


def test_a_late_mark_vouches_for_those_without_one_and_a_roster_that_contradicts_it_is_told(run: Run) -> None:
    files = {"doejane_LATE_101_900_filters.py": b"# 1\n", "roe_102_901_filters.py": b"# 0\n"}
    Path("marked.zip").write_bytes(zipped(files))
    Path("plain.zip").write_bytes(zipped({name.replace("LATE_", ""): data for name, data in files.items()}))
    Path("roster.csv").write_text(
        "canvas_user_id,name,submitted\n101,Jane Doe,2026-10-24T18:00+02:00\n102,Roe,2026-10-24T18:00+02:00\n"
    )
    rubric_with(Path("rub.yaml"), late_policy(f"{IN_BERLIN}, due_dates: {{ROE: {LOCAL}, jim: {LOCAL}}}"))
    err = run("grade", "marked.zip", "-o", "marked", "--rubric", "rub.yaml")[2]
    assert (
        "the late policy deducts nothing from doejane_101, which the platform marks as late: their time is unknown (add"
        in err
    )
    assert "with a due date in the rubric, but no submission has this name: jim\n" in err
    assert "hand-ins: their time" not in err
    assert column(Path("marked/gradebook.csv"), "final")["doejane_101"] == "100"
    unknown = "the late policy deducts nothing from 2 of 2 hand-ins: their time"
    assert unknown in run("grade", "plain.zip", "-o", "plain", "--rubric", "rub.yaml")[2]
    code, _, err = run("grade", "marked.zip", "-o", "out", "--rubric", "rub.yaml", "--roster", "roster.csv")
    assert code == 0
    assert "imugrade: late on the platform, but in time by the roster and the late policy: doejane_101\n" in err
