"""Tests of final grades: lateness, rosters and overrides are kept apart from the automatic result and never change it."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest

from grader.base.errors import RequestError
from grader.base.stamps import read_stamp, stamp
from grader.course.publishing.contradictions import contradictions
from grader.course.run.warnings import outdated
from grader.engine.results import Repair, Status
from grader.engine.rubric import LatePolicy
from grader.people import final_grade as grades
from grader.people import roster
from grader.people.final_grade import Adjustment, FinalGrade, HandIn, Lateness, Person, points_by_check
from grader.people.identity import Directory, PersonRow
from grader.people.late_policy import judged
from grader.platforms.gradebook import gradebook
from grader.report import adjusted
from tests.fake_results import check, lost, result

DUE = datetime(2026, 11, 20, 23, 0, tzinfo=timezone.utc)
POLICY = LatePolicy(DUE, grace_minutes=10, per_day=10.0, cut_off_days=3)


def handed_in(
    seconds: float, policy: LatePolicy | None = POLICY, due: datetime | None = None, **person: str
) -> Lateness | None:
    came = (DUE + timedelta(seconds=seconds)).isoformat()
    hand_in = HandIn((Person("Jane", **person),), came, due=due.isoformat() if due else "")
    return judged(hand_in, policy, ("jane_1",)).late


# ---- lateness ----


@pytest.mark.parametrize(
    ("seconds", "days", "refused"),
    [(601, 1, False), (86_400, 1, False), (86_401, 2, False), (3 * 86_400, 3, False), (3 * 86_400 + 1, 4, True)],
)
def test_days_begun_count_from_the_due_date_once_the_grace_is_over(seconds: int, days: int, refused: bool) -> None:
    assert handed_in(600) is None
    assert handed_in(seconds) == Lateness("2026-11-20T23:00+00:00", seconds, days, 10.0 * days, refused)


def test_without_a_policy_only_the_platforms_own_word_stands() -> None:
    assert handed_in(10**6, None) is None
    marked = HandIn(marked_late=True)
    assert judged(marked, None, ()).late == Lateness("", None)
    assert judged(judged(marked, replace(POLICY, due=DUE + timedelta(days=9)), ()), None, ()).late == Lateness("", None)


@pytest.mark.parametrize("who", ["jane_1", "JANE", "j@example.edu", "s1", "101"])
def test_an_extension_is_found_by_any_name_of_theirs_and_of_two_the_later_one_counts(who: str) -> None:
    policy = replace(POLICY, due_dates={"Jane": DUE + timedelta(days=1), who: DUE + timedelta(days=5)})
    person = {"email": "J@example.edu", "sid": "s1", "key": "101"}
    assert handed_in(4 * 86_400, policy, **person) is None
    assert handed_in(4 * 86_400, replace(POLICY, due_dates={"other": DUE + timedelta(days=5)}), **person) is not None


def test_a_date_of_the_roster_goes_before_every_other() -> None:
    policy = replace(POLICY, due_dates={"jane": DUE + timedelta(days=5)})
    assert handed_in(2 * 86_400, policy, DUE + timedelta(days=1)) == Lateness("2026-11-21T23:00+00:00", 86_400, 1, 10.0)


def test_lateness_takes_no_more_than_there_is_and_nothing_that_is_open() -> None:
    late = HandIn(late=Lateness("x", 90_000, 2, 30.0))
    assert (FinalGrade("a", result(), late).deduction, FinalGrade("a", result(), late).final) == (20.0, 0.0)
    refused = HandIn(late=Lateness("x", 900_000, 11, 0.0, refused=True))
    assert FinalGrade("a", result(), refused).final == 0.0
    still_open = FinalGrade("a", result(check("not_judged", None), status="incomplete"), late)
    assert (still_open.adjusted, still_open.deduction, still_open.final) == (None, 0.0, None)


# ---- points by hand ----


@pytest.mark.parametrize(("points", "shown"), [(None, "–"), (0.0, "0"), (3.0, "3")])
def test_a_page_shows_the_points_that_a_person_gives_for_what_is_not_judged(points: float | None, shown: str) -> None:
    open_ = result(check("not_judged", None), status="incomplete")
    given = [] if points is None else [Adjustment("sensor_access", points, "by hand", "me", "now")]
    assert adjusted.total(FinalGrade("a", open_, adjustments=tuple(given)))[0] == shown


def test_an_adjustment_is_out_of_date_when_a_check_beneath_it_moved_although_the_sum_is_the_same() -> None:
    first = result(lost(id="x.a"), check(id="x.b"))
    then = Adjustment("sensor_access", 11.0, "why", "me", "now", points_by_check(first.criteria[0]))
    assert FinalGrade("a", first, adjustments=(then,)).outdated() == []
    second = FinalGrade("a", result(check(id="x.a"), lost(id="x.b")), adjustments=(then,))
    assert second.outdated() == [then]
    assert list(outdated({"a": second})) == [
        "a: sensor_access was overridden with 11 when it had 6; the automatic points are now 6 / 12. Adjust it again or withdraw it"
    ]


@pytest.mark.parametrize("status", ["empty", "unreadable"])
def test_without_gradable_files_there_is_no_grade_until_a_person_gives_or_reviews_it(status: Status) -> None:
    empty = result(lost(), status=status)
    override = Adjustment("sensor_access", 5.0, "by e-mail", "me", "now")
    comment = Adjustment("sensor_access", None, "nothing here", "me", "now", alone=True)
    assert FinalGrade("a", empty, adjustments=(comment,)).final is None
    assert FinalGrade("a", empty, adjustments=(comment, override)).final == 5.0
    reviewed = FinalGrade("a", empty, reviewed=True)
    assert reviewed.final == 0.0
    others = FinalGrade("b", result()), FinalGrade("c", result(status="incomplete"))
    assert grades.graded([reviewed, *others]) == [20.0]  # figures of a class are of those that were graded


# ---- the gradebook ----


def test_the_gradebook_has_a_row_a_submission_and_a_column_a_criterion() -> None:
    granted = replace(result(name="a\nb,c"), extra_credit_cap=10.0)
    extension = replace(granted.extensions[0], max_points=5.0, checks=(check(points=4.5, max_points=5.0),))
    table = {
        "a": result(lost(), check("not_judged", None), status="incomplete"),
        "b": result(check(points=3.33), name='=HYPERLINK("http://x")'),
        "c": replace(granted, extensions=(extension,)),
    }
    assert gradebook({id_: FinalGrade(id_, each) for id_, each in table.items()}) == (
        "id,name,sensor_access,extra_credit,total,status\n"
        "a,alice,,0,,incomplete\n"
        'b,"\'=HYPERLINK(""http://x"")",3.33,0,3.33,graded\n'
        'c,"a\nb,c",20,4.5,24.5,graded\n'
    )


def test_what_stands_beside_has_columns_after_the_total() -> None:
    made = result()
    by_hand = Adjustment("sensor_access", 18.0, "why", "me", "now", points_by_check(made.criteria[0]))
    late = HandIn((Person("Müller, J.", section="=B"),), "2026-11-21T23:00:01+00:00", Lateness("x", 86_401, 2, 4.0))
    nothing = FinalGrade("c", replace(made, status="empty"), HandIn((Person("Z"),)))
    table = gradebook({"a": FinalGrade("a", made, late, (by_hand,)), "b": FinalGrade("b", made), "c": nothing})
    assert table == (
        "id,name,section,sensor_access,total,adjusted,submitted,late,late_deduction,final,status\n"
        'a,"Müller, J.",\'=B,20,20,18,2026-11-21T23:00:01+00:00,2,4,14,graded\n'
        "b,alice,,20,20,20,,unknown,0,20,graded\n"
        "c,Z,,,,,,unknown,,,empty\n"
    )


# ---- who is meant ----

DOE, ROE = Person("doejane", "101", "canvas"), Person("Roe, Bob", "102", "canvas", sid="s2", email="bob@example.edu")
TWINS = {"a": (Person("Tim Twin"),), "b": (Person("Twin, Tim"),)}
PEOPLE = Directory(
    {**TWINS, "doejane_101": (DOE,), "roe": (ROE,), "group": (Person("Ann", sid="s8"), Person("Cy", sid="s9"))}
)


@pytest.mark.parametrize(
    ("row", "id_"),
    [
        (PersonRow("canvas", "101"), "doejane_101"),
        (PersonRow(name="Jane Doe"), "doejane_101"),
        (PersonRow("canvas", "103", name="Doe, Jane"), None),
        (PersonRow("moodle", "101", name="Bob Roe"), "roe"),
        (PersonRow(numbers=("S2",)), "roe"),
        (PersonRow(numbers=("102",), name="Somebody Else"), None),
        (PersonRow(email="other@example.edu", name="Bob Roe"), None),
        (PersonRow(numbers=("s7",), name="Bob Roe"), None),
        (PersonRow(numbers=("group",)), "group"),
        (PersonRow(name="Tim Twin"), None),
    ],
)  # fmt: skip
def test_a_row_is_given_to_the_right_one_or_to_nobody(row: PersonRow, id_: str | None) -> None:
    match = PEOPLE.find(row)
    assert (match and match.id) == id_


# ---- the roster ----


def read(tmp_path: Path, text: str, encoding: str = "utf-8") -> list[roster.RosterRow]:
    (tmp_path / "r.csv").write_text(text, encoding, newline="")
    return list(roster.load(tmp_path / "r.csv").people)


def placed(tmp_path: Path, text: str) -> roster.RosterMatch:
    people = {"doejane_101": (DOE,), "lab4-user1": (Person("lab4-user1", "lab4-user1", "git"),)}
    return roster.place(read(tmp_path, text), {id_: HandIn(each) for id_, each in people.items()})


def names(found: roster.RosterMatch) -> tuple[str, ...]:
    return tuple(each.person.name for each in found.absent)


def test_a_roster_gives_names_sections_dates_and_tells_who_is_missing_on_either_side(tmp_path: Path) -> None:
    text = '\ufeffName,Email,Section,Due,Submitted\n"Doe, Jane",j@example.edu,B,2026-11-24T23:59+01:00,2026-11-21 10:00Z\nNobody,n@example.edu,A,,\n'
    found = placed(tmp_path, text)
    assert found.hand_ins["doejane_101"].people == (Person("Doe, Jane", "101", "canvas", "", "j@example.edu", "B"),)
    assert {id_: (row.due, row.submitted) for id_, row in found.rows.items()} == {
        "doejane_101": (read_stamp("2026-11-24T22:59Z"), "2026-11-21T10:00:00+00:00")
    }
    assert (names(found), found.unknown) == (("Nobody",), ("lab4-user1",))


def test_of_two_rows_of_one_name_the_one_with_the_number_is_meant_and_without_a_number_nobody(tmp_path: Path) -> None:
    text = "Name,ID,Email,Section,Due\nJane Doe,101,,B,\nJane Doe,999,,C,2026-11-24T23:59+01:00\n"
    for rows in (text, "\n".join(text.splitlines()[i] for i in (0, 2, 1))):
        found = placed(tmp_path, rows)
        assert found.hand_ins["doejane_101"].people[0].section == "B"
        assert (found.rows["doejane_101"].due, names(found), found.unknown) == (None, ("Jane Doe",), ("lab4-user1",))
    found = placed(tmp_path, "Name,ID,Section\nJane Doe,1,B\nJane Doe,2,C\n")
    assert found.hand_ins["doejane_101"].people == (DOE,)
    assert (names(found), found.unknown) == (("Jane Doe", "Jane Doe"), ("doejane_101", "lab4-user1"))


def test_what_platforms_export_is_a_roster_as_it_stands(tmp_path: Path) -> None:
    canvas = 'Student,ID,SIS User ID,SIS Login ID,Section,Lab (1)\n    Points Possible,,,,,100\n"Doe, Jane",101,s1,jd,"Tue, 10",\n'
    assert placed(tmp_path, canvas).hand_ins["doejane_101"].people == (
        Person("Doe, Jane", "101", "canvas", "s1", "", "Tue, 10", ("jd",)),
    )
    moodle = 'Identifier;"Full name";"Email address";Status;Grade\n"Participant 12";Jürgen Doe;j@example.edu;-;\n'
    assert read(tmp_path, moodle, "cp1252")[0].who == PersonRow("moodle", "12", (), "j@example.edu", "Jürgen Doe")
    gradescope = "First Name,Last Name,SID,Email,Sections\nJane,Doe,s1,j@example.edu,B\n"
    assert read(tmp_path, gradescope) == [
        roster.RosterRow(PersonRow("", "", ("s1",), "j@example.edu", "Jane Doe"), "B")
    ]


@pytest.mark.parametrize("dates", [("24", "26"), ("26", "24")])
def test_a_group_has_the_latest_due_date_and_time_of_its_members(dates: tuple[str, str], tmp_path: Path) -> None:
    rows = "".join(
        f"{name},2026-11-{day}T12:00Z,2026-11-{day}T10:00Z,T\n" for name, day in zip("JR", dates, strict=True)
    )
    group = HandIn((Person("J"), Person("R")))
    found = roster.place(read(tmp_path, f"name,due,submitted,group\n{rows}"), {"team": group})
    assert found.rows["team"].due == read_stamp("2026-11-26T12:00Z")
    assert found.rows["team"].submitted == "2026-11-26T10:00:00+00:00"


def test_a_clone_is_of_the_longest_whole_user_name_that_it_ends_in(tmp_path: Path) -> None:
    clone = {"lab4-jane-user1": HandIn((Person("lab4-jane-user1", "lab4-jane-user1", "git"),))}
    found = roster.place(read(tmp_path, "username,name\n1,Part\nuser1,Short\njane-user1,Long\n"), clone)
    assert (found.hand_ins["lab4-jane-user1"].people[0].name, names(found)) == ("Long", ("Part", "Short"))


def test_a_roster_that_cannot_be_used_is_one_line(tmp_path: Path) -> None:
    due = "due must be a date and time with its offset from UTC, like 2026-11-20T23:59+01:00"
    for text, line in (
        ("a,b\n", "r.csv:1: no column id, name or email; the first line has to name the columns"),
        ("name,due\nJane,tomorrow\n", f"r.csv:2: {due}"),
    ):
        with pytest.raises(RequestError, match=f"^{re.escape(f'{tmp_path}/{line}')}$"):
            read(tmp_path, text)


# ---- points in time ----


@pytest.mark.parametrize(
    ("text", "utc"),
    [
        ("2026-11-20T23:59+01:00", "2026-11-20T22:59:00+00:00"),
        ("2026-11-20 23:59:30.123456789 -0800", "2026-11-21T07:59:30+00:00"),
        ("2026-11-20T23:59", ""),
        ("2026-13-20T23:59Z", ""),
        ("0001-01-01T00:00+14:00", ""),
    ],
)
def test_a_time_without_an_offset_is_no_time(text: str, utc: str) -> None:
    assert stamp(text) == utc


def test_a_time_before_the_calendar_begins_is_no_time_in_yaml_either() -> None:
    assert stamp(datetime.fromisoformat("0001-01-01T00:00+14:00")) == ""


# ---- how a final grade came about ----


def test_one_line_says_how_a_final_grade_came_about_and_its_numbers_add_up() -> None:
    granted = replace(result(), extra_credit_cap=10.0)
    extension = replace(granted.extensions[0], max_points=5.0, checks=(check(points=4.5, max_points=5.0),))
    repair = Repair("filters.py", "", 2.0, "Eve", "now", "a colon", 10.0)
    repaired = replace(granted, extensions=(extension,), repairs=(repair,))
    bonus = Adjustment("bonus", 3.0, "an error in the sheet", "Eve", "now")
    override = Adjustment("sensor_access", 14.0, "shown", "Eve", "now")
    late = HandIn(late=Lateness("x", 90_000, 2, 10.0))
    composed = FinalGrade("a", repaired, late, (override, bonus))
    assert adjusted.explained(composed) == (
        "final 9.5 = score 14 (with overrides, repaired) + bonus 3 + extra credit 4.5 − repair 2 − late 10"
    )
    total = Adjustment("total", 17.0, "shown", "Eve", "now")
    assert adjusted.explained(replace(composed, adjustments=(total, bonus))) == (
        "final 20 = total 17 (set by Eve) + bonus 3; a total is final: lateness and repairs are not deducted, extra credit is not added"
    )
    assert "above the maximum of 20" in adjusted.explained(FinalGrade("a", result(), adjustments=(bonus,)))
    assert adjusted.explained(FinalGrade("a", result(check("not_judged", None), status="incomplete"))) == ""


def test_an_override_above_a_maximum_that_moved_is_a_contradiction_and_so_is_what_was_not_judged() -> None:
    halved = result(
        check(points=3.0, max_points=3.0), check(id="sensor_access.matches_truth", points=7.0, max_points=7.0)
    )
    override = Adjustment("sensor_access", 19.0, "shown", "Eve", "now")
    table = {
        "a": FinalGrade("a", halved, adjustments=(override,)),
        "b": FinalGrade("b", result(check("not_judged", None), status="incomplete")),
        "c": FinalGrade("c", result()),
        "d": FinalGrade("d", result(status="empty")),
    }
    assert [(each.id, each.kind, each.stops_export) for each in contradictions(table, None)] == [
        ("a", "above maximum", True),
        ("b", "not judged", True),
    ]
    assert "with 19 is above its maximum, which is now 10" in contradictions(table, None)[0].text
