"""Tests of the review desk: access, review queue, decisions, and the files in OUT that follow them."""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlencode

import pytest
from markupsafe import escape

from grader.course.record.submission_archive import LARGEST, pack, unpack
from grader.desk import app, rubric_what_if
from grader.desk.overviews import queue
from grader.desk.regrade_requests import read_in
from grader.desk.similarity_groups import similarity_groups
from grader.engine import rubric
from grader.engine.findings import NEEDS_REVIEW, Where
from grader.engine.fingerprint import fingerprint, lines_with, of_the_sheet
from grader.labs.imu.lab import LAB
from grader.people.final_grade import BONUS, TOTAL, HandIn, Lateness, Person
from grader.report.similarity import Pair
from tests.class_commands import in_process
from tests.desk import FILTER, PNG, RUBRIC, Desk, Student, desk_over, make_class, words

ADDRESS, TITLES, PLOT = "sensor_access.follows_address", "visualization.titles", "visualization.comparison_plot"
MISTAKE = {"got": "x", "misconceptions": ("sensor-id-as-address",)}
STUDENTS = (
    Student("ada", files={"filters.py": FILTER, "imu_data.png": PNG}),
    Student("bob", {ADDRESS: 0.0}, {ADDRESS: MISTAKE}, hand_in=HandIn((Person("Bob Bird", email="bob@x.edu"),))),
    Student("cyd", {ADDRESS: 0.5, TITLES: 0.0}, {ADDRESS: MISTAKE}),
)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return make_class(tmp_path / "out", STUDENTS)


@pytest.fixture
def desk(out: Path) -> Iterator[Desk]:
    with desk_over(out) as opened:
        yield opened


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """One that nobody changes anything at."""
    with desk_over(make_class(tmp_path_factory.mktemp("still"), STUDENTS)) as opened:
        yield opened


def row(out: Path, id_: str) -> dict[str, str]:
    with open(out / "gradebook.csv", newline="") as stream:
        return next(row for row in csv.DictReader(stream) if row["id"] == id_)


def give(desk: Desk, id_: str, target: str, points: object, comment: str = "seen", **more: object):  # type: ignore[no-untyped-def]
    seen = more.pop("seen", desk.book.on_thread(desk.book.store.last_adjustment))
    who = str(more.pop("who", ""))
    fields = {"target": target, "points": points, "comment": comment, "seen": seen, **more}
    answer = desk.post(f"/submission/{id_}/override", fields, who)
    desk.book.settled()
    return answer


# ---- a submission's page ----


def test_a_submissions_page_leads_to_its_neighbours(still: Desk) -> None:
    page = still.get("/submission/bob").text
    links = {way: address for address, way in re.findall(r'<a href="([^"]+)"[^>]* rel="(prev|next)"', page)}
    places = {way: address.partition("?")[0] for way, address in links.items()}
    assert places == {"prev": "/submission/ada", "next": "/submission/cyd"}


# ---- who may come in ----


def test_the_first_address_gives_a_cookie_that_no_script_reads_and_no_other_site_sends(still: Desk) -> None:
    answer = still.raw("GET", still.keys.first_address.removeprefix(still.origin))
    assert (answer.status, answer.headers["location"]) == (303, "/")
    name, _, rest = answer.headers["set-cookie"].partition("=")
    assert name == still.keys.cookie_name
    assert rest.split("; ")[1:] == ["HttpOnly", "Path=/", "SameSite=strict"]
    assert still.keys.token not in answer.headers["set-cookie"]
    assert still.get("/").status == 200


OURS = {"Cookie": "imugrade-desk-{port}={cookie}"}
ALL_OURS = OURS | {"Origin": "http://127.0.0.1:{port}"}


@pytest.mark.parametrize(
    ("call", "headers", "status"),
    [
        *((f"GET {path}", {}, 403) for path in ("/", "/submission/ada", "/static/desk.css", "/enter", "/enter?token=x", "/enter?token=")),
        *(("GET /", {"Cookie": own}, 403) for own in ("", "x", "imugrade-desk-{port}=x", "imugrade-desk-{port}={token}", '"\x7f', "a@b=1", "a=" + "b" * 9000)),
        *(("GET /", OURS | {"Host": host}, (400, 421)) for host in ("evil.example", "127.0.0.1", "127.0.0.1:1", "[::1]", "")),
        *((f"GET {path}", OURS, 405) for path in ("/reviewed", "/submission/ada/override", "/groups/take-back", "/who")),
        ("POST /submission/ada/override", OURS, 403),
        *(
            ("POST /submission/ada/override", OURS | {"Origin": origin}, 403)
            for origin in ("null", "http://evil.example", "http://127.0.0.1:1", "https://127.0.0.1")
        ),
        ("GET /", OURS, 200),
        ("POST /submission/ada/override", ALL_OURS, 400),
    ],
)  # fmt: skip
def test_nobody_but_our_own_pages_with_their_cookie_learns_or_changes_something(
    still: Desk, call: str, headers: dict[str, str], status: object
) -> None:
    method, path = call.split()
    given = {name: text.format(**vars(still.keys)) for name, text in headers.items()}
    body = b"target=nothing&points=1&comment=x" if method == "POST" else None
    answer = still.raw(method, path, body, **given)
    assert answer.status in (status if isinstance(status, tuple) else (status,))
    assert answer.status in (200, 400) or b"ada" not in answer.data
    assert still.book.on_thread(still.book.store.history) == []


def test_every_answer_forbids_scripts_that_are_not_ours(still: Desk) -> None:
    own = [still.get(path) for path in ("/", "/submission/ada/picture/1", "/nowhere")]
    for answer in (*own, still.raw("GET", "/")):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert answer.headers["x-content-type-options"] == "nosniff"


def test_a_form_larger_than_ours_is_not_read(still: Desk) -> None:
    assert still.post("/regrade-requests", {"text": "x" * 2_100_000}).status == 413
    assert still.post("/regrade-requests", [("id", k) for k in range(6000)]).status == 400


# ---- points by hand ----


def test_points_of_a_person_reach_the_published_files_and_beneath_others_are_refused(desk: Desk, out: Path) -> None:
    before = (out / "submissions" / "bob" / "result.json").read_bytes()
    heading = re.compile(r"· \S+ automatic")  # beside a grade that differs
    assert not heading.search(words(desk.get("/submission/bob").text))
    assert give(desk, "bob", ADDRESS, "4,5", "Shown <i>later</i>").status == 303
    assert row(out, "bob")["final"] == "98.5"
    assert heading.search(words(desk.get("/submission/bob").text))
    give(desk, "bob", BONUS, "2")
    assert row(out, "bob")["final"] == "100.5"
    give(desk, "bob", "filtering", "10")
    assert row(out, "bob")["final"] == "90.5"
    assert (
        "The override of filtering of Bob Bird replaces" in give(desk, "bob", "filtering.follows_recursion", "5").text
    )
    give(desk, "bob", TOTAL, "50")
    assert row(out, "bob")["final"] == "52"
    assert "The override of total of Bob Bird replaces" in give(desk, "bob", "filtering", "5").text
    assert (out / "submissions" / "bob" / "result.json").read_bytes() == before
    report = (out / "submissions" / "bob" / "report.html").read_text()
    assert "Shown &lt;i&gt;later&lt;/i&gt;" in report
    assert "4.5 / 6" in words(report)


def test_undo_brings_back_the_override_before_with_its_comment_and_history_keeps_all(desk: Desk, out: Path) -> None:
    give(desk, "bob", ADDRESS, "4", "first")
    give(desk, "bob", ADDRESS, "5", "second")
    give(desk, "bob", ADDRESS, "", "a comment alone")
    assert row(out, "bob")["final"] == "99"
    assert "a comment alone" in (out / "submissions" / "bob" / "report.html").read_text()
    give(desk, "bob", ADDRESS, "", "", do="undo")
    assert row(out, "bob")["final"] == "98"
    history = desk.book.on_thread(desk.book.store.history)
    assert [each.comment for _, each in history] == ["first", "second", "a comment alone", "first"]
    give(desk, "bob", ADDRESS, "", "", do="undo")
    page = words(desk.get("/submission/bob").text)
    assert page.count(f"{ADDRESS} 4") == 2
    give(desk, "bob", ADDRESS, "", "", do="withdraw")
    assert row(out, "bob")["total"] == "94"
    assert give(desk, "bob", ADDRESS, "", "", do="undo").status == 400


@pytest.mark.parametrize(
    ("target", "points", "comment", "field", "line"),
    [
        (ADDRESS, "7", "kept <b>", "points", "Points must be a number from 0 to 6 with at most two decimals, not 7."),
        ("nothing", "1", "x", "", "there is no criterion nothing"),
        (ADDRESS, "1", "x" * 2001, "comment", "Say why in a comment of at most 2000 characters."),
    ],
)
def test_an_override_that_is_refused_is_not_recorded_and_keeps_what_was_typed(
    still: Desk, target: str, points: str, comment: str, field: str, line: str
) -> None:
    answer = give(still, "bob", target, points, comment)
    assert (answer.status, line in words(answer.text)) == (400, True)
    assert still.book.on_thread(still.book.store.history) == []
    if field:
        form = answer.text.partition(f'id="override-{ADDRESS.replace(".", "-")}"')[2].partition("</form>")[0]
        assert "<details open>" in form
        assert f'value="{points}"' in form
        assert f'aria-invalid="true" aria-describedby="error-{field}"' in form
        assert f'<span class="error" id="error-{field}">{line}</span>' in form
        assert f"{escape(comment)}</textarea>" in form
        assert answer.text.count('class="error"') == 1


# ---- export ----


def test_grades_and_reports_are_downloaded_from_the_class_page(desk: Desk, out: Path) -> None:
    assert 'action="/export"' in desk.get("/class").text
    give(desk, "bob", ADDRESS, "4")
    answer = desk.post("/export", {"format": "csv", "do": "grades"})
    assert (answer.status, answer.headers["content-disposition"]) == (200, 'attachment; filename="marks.csv"')
    assert {row["submission"]: row["final"] for row in csv.DictReader(answer.text.splitlines())}["bob"] == "98"
    answer = desk.post("/export", {"do": "feedback", "format": "canvas"})
    assert (answer.status, answer.headers["content-type"]) == (200, "application/zip")


def test_of_two_at_once_the_later_one_is_told_and_nothing_is_overwritten(desk: Desk, out: Path) -> None:
    assert give(desk, "bob", ADDRESS, "4", seen=0, who="Zoe").status == 303
    assert give(desk, "bob", ADDRESS, "3", seen=1, who="Eve").status == 303
    draft = {"draft": "/submission/bob#a", "fields": '[["points", "5"]]'}
    desk.post("/draft", draft, "Ann")
    late = give(desk, "bob", ADDRESS, "5", seen=0, who="Ann", draft=draft["draft"])
    assert late.status == 409
    assert desk.book.on_thread(lambda: desk.book.store.drafts("Ann")) == {draft["draft"]: draft["fields"]}
    assert "Eve changed something" in words(late.text)
    assert '<a href="/submission/bob">Open the page again</a>' in late.text
    assert row(out, "bob")["final"] == "97"
    assert give(desk, "ada", BONUS, "1", seen=0, who="Ann").status == 303  # somebody else's marks are no matter
    group = "/groups/fault/sensor-id-as-address"
    late = desk.post(group, {"id": "bob", "target": ADDRESS, "points": "5", "comment": "misled", "seen": 0})
    assert f'<a href="{group}">Open the page again</a>' in late.text


# ---- what needs a look ----


NEEDY = (
    Student("open", {ADDRESS: None}, status="incomplete"),
    Student("void", status="empty", notes=("No .py or .ipynb file was found.",), files={"imu_data.png": PNG}),
    Student("torn", status="unreadable", notes=("It is no archive.",)),
    Student("odd", {ADDRESS: 0.0}, {ADDRESS: {"not_understood": True}}),
    Student("sly", {ADDRESS: 0.0}, {ADDRESS: {"misconceptions": ("tampering",)}}),
    Student("late", hand_in=HandIn(late=Lateness("", None))),
    Student("drew", notes=(f"imu_data.png was handed in: {NEEDS_REVIEW} for it",)),
    Student("edge", {TITLES: 0.5, "sensor_access.leaves_simulation_alone": 0.0, "visualization.two_labelled_panels": 0.0,
                     "visualization.saves_image": 0.0, "visualization.axis_labels_with_units": 0.0}),
    Student("slow", dict.fromkeys([c.id for c in rubric.load(LAB).checks], 0.0), {c.id: {"outcome": "timeout"} for c in rubric.load(LAB).checks}),
    Student("twin1", prints=tuple(range(60))), Student("twin2", prints=tuple(range(60))), Student("twin3", prints=tuple(range(60))),
    Student("ghost"), Student("sound"),
)  # fmt: skip


def test_every_reason_is_told_with_its_sentence_and_can_be_ticked(tmp_path: Path) -> None:
    notices = {"leftover": ["notes.txt <is> nobody's"], "unknown": ["ghost"]}
    with desk_over(make_class(tmp_path / "out", NEEDY, notices)) as desk:
        page = words(desk.get("/").text)
        for title in ("Grader failed", "Unreadable", "Empty", "Does not run", "Unclear answer", "Tampering", "Not assigned",
                      "Not in the roster", "Unknown lateness", "Similar code", "Plot that could not be judged", "Near a grade boundary", "No points"):  # fmt: skip
            assert f"{title} 1" in page, title
        assert "sound" not in words(desk.get("/").text.partition("<main")[2])  # the header lists everybody
        assert "notes.txt &lt;is&gt; nobody" in page
        assert "0.5 below 90, and 0.5 points were lost on partial checks" in page
        only = words(desk.get("/?kind=alike").text)
        assert "twin1 l 100 , twin2 100 , twin3 100" in only
        assert "No .py" not in only
        assert "/submission/void/picture/" in desk.get("/submission/void").text
        twins = next(each for each in desk.book.on_thread(lambda: queue(desk.book)) if each.others)
        desk.post("/reviewed", {"look": twins.key, "done": "yes"})
        assert desk.get(twins.together).status == 200
        desk.post("/reviewed", {"look": twins.key, "done": "no"})
        key = next(each for each in desk.book.on_thread(lambda: queue(desk.book)) if each.id == "void").key
        assert desk.post("/reviewed", {"look": key, "done": "yes"}, "Ann").status == 303
        (review,) = desk.book.on_thread(desk.book.store.reviews).values()
        assert (review.id, review.author, review.at[:2]) == ("void", "Ann", "20")
        page = words(desk.get("/").text)
        assert "Empty 1" not in page
        assert "Reviewed by Ann" in page
        desk.post("/reviewed", {"look": key, "done": "no"})
        assert "Empty 1" in words(desk.get("/").text)
        assert desk.post("/reviewed", {"look": "empty/0/void", "done": "yes"}).status == 400
        assert desk.post("/reviewed", [("look", key), ("look", "gone"), ("done", "yes")]).status == 400
        assert desk.get("/find?who=void").headers["location"] == "/submission/void"


def main(page: str) -> str:
    return words(page.partition("<main")[2])


def test_reviewing_an_empty_hand_in_says_on_its_button_that_it_gives_0_and_before_and_after_too(tmp_path: Path) -> None:
    nothing = Student("void", dict.fromkeys([c.id for c in RUBRIC.checks], 0.0), status="empty")
    with desk_over(out := make_class(tmp_path / "out", [nothing])) as desk:
        assert row(out, "void")["total"] == ""
        give(desk, "void", "filtering", "", "a comment alone")
        before = main(desk.get("/?kind=empty").text)
        assert "The grade is blank until you give 0 points here or override the total. Give 0 points : Empty" in before
        assert "Mark as reviewed" not in before
        assert "Give 0 points : Empty" in main(desk.get("/submission/void").text)
        key = next(each for each in desk.book.on_thread(lambda: queue(desk.book)) if each.id == "void").key
        desk.post("/reviewed", {"look": key, "done": "yes"})
        desk.book.settled()
        assert row(out, "void")["total"] == "0"
        assert "counts as 0 points Reopen, leave blank" in main(desk.get("/").text)
        desk.post("/reviewed", {"look": key, "done": "no"})
        desk.book.settled()
        assert row(out, "void")["total"] == ""


def test_a_total_says_before_what_it_leaves_out_and_lateness_is_not_asked_for_again(tmp_path: Path) -> None:
    late = HandIn(late=Lateness("2026-11-20T23:00+00:00", 90_000, 2, 20.0))
    students = (Student("ada", hand_in=late), Student("bob", hand_in=HandIn(late=Lateness("", None), marked_late=True)))
    with desk_over(out := make_class(tmp_path / "out", students)) as desk:
        assert "A total is final: nothing automatic is added to it or deducted from it (here: late −20)" in words(
            desk.get("/submission/ada").text
        )
        give(desk, "ada", TOTAL, "74")
        assert row(out, "ada")["final"] == "74"
        assert "final 74 = total 74 (set by prof); a total is final" in words(desk.get("/submission/ada").text)
        assert "nothing is deducted again" in main(desk.get("/").text)
        give(desk, "bob", TOTAL, "80")
        assert "Unknown lateness" not in main(desk.get("/").text)


def test_an_override_above_a_maximum_that_moved_is_named_in_preview_queue_class_and_form(desk: Desk) -> None:
    give(desk, "bob", "filtering", "19")
    line = "Bob Bird: the override of filtering with 19 is above its maximum, which is now 10"
    entered = {"points:filtering": "10", "points:visualization": "35"}
    assert line in main(desk.get(f"/what-if?{urlencode(entered)}").text)
    assert desk.post("/what-if", {**entered, "do": "mark"}).status == 303
    assert "Above the maximum 1" in main(desk.get("/").text)
    assert line in main(desk.get("/").text)
    assert line in main(desk.get("/class").text)
    assert "above the maximum of 10" in main(desk.get("/submission/bob").text)


def test_a_late_policy_without_times_is_in_the_queue_and_on_the_class_page(tmp_path: Path) -> None:
    with desk_over(make_class(tmp_path / "out", STUDENTS)) as desk:
        due = {"late:due": "2026-11-20T23:00+00:00", "late:per_day": "10%"}
        desk.post("/what-if", {**due, "do": "mark"})
        for path in ("/", "/class", "/export"):
            assert "late policy deducts nothing from 3 of 3 hand-ins" in main(desk.get(path).text), path


# ---- groups ----


def test_one_decision_stands_for_all_of_a_group_is_shown_as_one_and_taken_back_as_one(desk: Desk, out: Path) -> None:
    give(desk, "cyd", "visualization", "20")
    page = words(desk.get("/groups").text)
    assert "2 sensor id as address" in page
    wish = [("target", ADDRESS), ("points", "6"), ("comment", "misled"), ("seen", 9)]
    fields = [*(("id", id_) for id_ in ("bob", "cyd", "ada")), *wish]
    assert desk.post("/groups/fault/sensor-id-as-address", fields).status == 303
    desk.book.settled()
    assert [row(out, id_)["final"] for id_ in ("ada", "bob", "cyd")] == ["100", "100", "100"]
    assert "(one decision for a group)" in words(desk.get("/submission/bob").text)
    give(desk, "cyd", ADDRESS, "4", "but not this one")
    assert "in effect for 1" in words(desk.get("/groups").text)
    assert desk.post("/groups/take-back", {"number": 1}).status == 303
    desk.book.settled()
    assert [row(out, id_)["final"] for id_ in ("bob", "cyd")] == ["94", "98"]
    assert "undone" in words(desk.get("/groups").text)
    assert desk.post("/groups/take-back", {"number": 1}).status == 400
    comment_alone = [
        ("id", "bob"),
        ("id", "cyd"),
        ("target", "filtering"),
        ("points", ""),
        ("comment", "come and see me"),
        ("seen", 9),
    ]
    assert desk.post("/groups/fault/sensor-id-as-address", comment_alone).status == 303
    assert "come and see me" in words(desk.get("/submission/bob").text)


# ---- alike ----


def test_a_ring_of_twelve_copies_is_one_line_and_a_chain_is_its_pairs() -> None:
    ids = [f"s{k:02}" for k in range(12)]
    ring = [Pair(one, other, 60, 1.0) for k, one in enumerate(ids) for other in ids[k + 1 :]]
    (group,) = similarity_groups(ring)
    assert group.ids == tuple(ids)
    chain = [Pair("a", "b", 60, 0.9), Pair("b", "c", 40, 0.6)]
    assert [each.ids for each in similarity_groups(chain)] == [("a", "b"), ("b", "c")]
    assert [each.ids for each in similarity_groups([*chain, Pair("a", "c", 40, 0.6)])] == [("a", "b", "c")]


OWN = "".join(
    f"def part_{k}(a, b):\n    total_{k} = a * {k}.5 + b[{k}:{k + 3}].sum() - {k}\n    return total_{k} ** {k}\n"
    for k in range(30)
)
RENAMED = OWN.replace("total_", "t").replace("part_", "step_")


def test_shared_lines_stand_side_by_side_and_the_sheet_is_never_among_them(tmp_path: Path) -> None:
    sheet = (LAB.folder / "sheet.txt").read_text()[:6000]
    starter = (LAB.folder / "starter" / "filters.py.txt").read_text()
    one = {"filters.py": f"{sheet}\n{starter}\n{OWN}".encode()}
    notebook = json.dumps({"cells": [{"cell_type": "code", "source": [RENAMED]}]})
    other = {"lab.ipynb": notebook.encode()}
    students = [Student(f"n{k}", prints=fingerprint({"a.py": f"x = {k}\n".encode() * 3})) for k in range(4)]
    students += [Student(id_, files=each, prints=fingerprint(each)) for id_, each in (("one", one), ("other", other))]
    with desk_over(make_class(tmp_path / "out", students)) as desk:
        assert "2 submissions" in words(desk.get("/similar").text)
        page = desk.get("/similar/one/other").text
        assert page.count('class="both"') > 150
        assert "lab.ipynb" in page
        shared = desk.book.on_thread(lambda: desk.book.shared("one", "other"))
    assert shared
    assert not shared & of_the_sheet(LAB)
    text = one["filters.py"].decode()
    first_own = text[: text.index(OWN)].count("\n") + 1
    assert min(lines_with(text, shared)) >= first_own - 3


# ---- regrade requests ----


def test_a_request_is_shown_at_its_check_and_its_answer_reaches_the_student(desk: Desk, out: Path) -> None:
    text = '{"student": "bob@x.edu", "check": "%s", "text": "My <script>ids</script> are right."}' % ADDRESS  # noqa: UP031
    assert "message=1" in desk.post("/regrade-requests", {"text": text}).headers["location"]
    assert "message=0" in desk.post("/regrade-requests", {"text": text}).headers["location"]  # dropped in twice is one
    assert "Request 1" in words(desk.get("/").text)
    page = desk.get("/submission/bob").text
    assert "My &lt;script&gt;ids&lt;/script&gt; are right." in page
    assert page.rindex("My &lt;script&gt;") > page.index(f'id="override-{ADDRESS.replace(".", "-")}"')
    assert give(desk, "bob", ADDRESS, "6", "You are right.", answers=1).status == 303
    assert "You are right." in (out / "submissions" / "bob" / "report.html").read_text()
    assert row(out, "bob")["final"] == "100"
    assert "Request 1" not in words(desk.get("/").text)
    assert "Answered by prof" in words(desk.get("/regrade-requests").text)


def test_regrade_requests_of_a_folder_or_a_table_are_read_whole_or_not_at_all(desk: Desk, tmp_path: Path) -> None:
    folder, head = tmp_path / "requests", "name;check;appeal\nBob Bird;;Please look\n"
    folder.mkdir()
    (folder / "a.json").write_text(json.dumps({"submission": "bob", "check": ADDRESS, "text": "Please look"}))
    (folder / "b.json").write_text(json.dumps({"submission": "zed", "check": "", "text": "And mine"}))
    (folder / "notes.docx").write_bytes(b"PK")
    answer = desk.post("/regrade-requests", {"text": f"{head}nobody;;x\nada;no.such;x\n"})
    assert answer.status == 400
    assert "line 3: no student nobody" in words(answer.text)
    assert "line 4: there is no check no.such" in words(answer.text)
    answer = desk.post("/regrade-requests", {"text": head + "ada;;x\n" * 2000})
    assert (answer.status, "2001 requests at once; give at most 2000" in words(answer.text)) == (400, True)
    assert desk.book.on_thread(desk.book.store.regrade_requests) == []
    (folder / "b.json").write_text(json.dumps({"submission": "ada", "check": "", "text": "And mine"}))
    assert read_in(desk.book, folder) == ["2 regrade requests added"]
    assert read_in(desk.book, folder) == ["0 regrade requests added, 2 already on record"]
    desk.post("/regrade-requests", {"text": f"{head}ada;;\n"})
    found = desk.book.on_thread(desk.book.store.regrade_requests)
    told = [(each.id, each.about, each.text) for each in found]
    assert told == [("bob", ADDRESS, "Please look"), ("ada", "", "And mine"), ("bob", "", "Please look")]


def test_a_request_without_a_student_keeps_the_others_and_gets_its_student_on_the_page(tmp_path: Path) -> None:
    twins = [Student(id_, hand_in=HandIn((Person("Li Wei"),))) for id_ in ("w1", "w2")]
    (folder := tmp_path / "requests").mkdir()
    (folder / "bob.txt").write_text("From bob")
    (folder / "mail 17.txt").write_text("Whose is this?")
    (folder / "li wei.txt").write_text("From one of two")
    (folder / "x.csv").write_bytes(b"\xff\xfe")
    (folder / "y.json").write_text('{"student": "Li Wei", "check": "filtering", "text": "My filter"}')
    with desk_over(make_class(tmp_path / "out", [*STUDENTS, *twins])) as desk:
        lines = read_in(desk.book, folder)
        assert lines[0] == "1 regrade request added"
        assert "x.csv: is not UTF-8" in lines[1]
        assert "li wei is ambiguous: it may mean" in lines[2]
        assert "w1" in lines[2]
        assert "w2" in lines[2]
        assert "no student mail 17" in lines[3]
        assert "Whose is this?" in desk.get("/regrade-requests").text
        assert desk.post("/regrade-requests", {"text": "Whose is this?", "who": "ada"}).status == 303
        assert "no student mail 17" not in desk.get("/regrade-requests").text
        found = desk.book.on_thread(desk.book.store.regrade_requests)
        assert [(each.id, each.text) for each in found] == [("bob", "From bob"), ("ada", "Whose is this?")]
        assert '<input type="hidden" name="about" value="filtering">' in desk.get("/regrade-requests").text
        again = read_in(desk.book, folder)  # as the next start of the desk does
        assert any("no student mail 17 (ada has a request with this text on record)" in line for line in again)
        table = "Name,Student ID,Comment,Request\nLi Wei,w1,see below,Mine\n"  # the surest name of a column counts
        assert desk.post("/regrade-requests", {"text": table}).status == 303
        last = desk.book.on_thread(desk.book.store.regrade_requests)[-1]
        assert (last.id, last.text) == ("w1", "Mine")
        ambiguous = desk.post("/regrade-requests", {"text": "Hello", "who": "Li Wei"})
        assert "is ambiguous: it may mean" in words(ambiguous.text)


def test_half_a_character_in_a_request_is_written_out_in_a_file_and_in_the_form(desk: Desk, tmp_path: Path) -> None:
    half = '{"student": "%s", "text": "Half \\ud83d", "check": "%s"}'
    (tmp_path / "a.json").write_text(half % ("bob", ""))
    (tmp_path / "b.json").write_text(half % ("bob", "\\udc00"))
    assert read_in(desk.book, tmp_path)[0] == "1 regrade request added"
    assert desk.post("/regrade-requests", {"text": half % ("ada", "")}).status == 303
    assert desk.post("/regrade-requests", {"text": half % ("\\udfff", "")}).status == 400
    found = desk.book.on_thread(desk.book.store.regrade_requests)
    assert [(each.id, each.text) for each in found] == [("bob", "Half \\ud83d"), ("ada", "Half \\ud83d")]
    assert desk.get("/regrade-requests").status == 200


def test_times_at_the_desk_are_those_of_the_class(desk: Desk) -> None:
    give(desk, "bob", ADDRESS, "4")
    assert re.search(r"\d\d:\d\d UTC by prof", words(desk.get("/submission/bob").text))
    desk.post("/what-if", {"late:due": "2026-11-20T23:00+01:00", "late:tz": "Asia/Kolkata", "do": "mark"})
    assert re.search(r"\d\d:\d\d UTC\+05:30 by prof", words(desk.get("/submission/bob").text))
    group = {"id": "bob", "target": ADDRESS, "points": "5", "comment": "misled", "seen": 9}
    desk.post("/groups/fault/sensor-id-as-address", group)
    assert re.search(r"prof, \S+ \d\d:\d\d UTC\+05:30, for 1", words(desk.get("/groups").text))


# ---- what would it cost ----


def test_a_rubric_is_previewed_saved_and_marks_the_class_only_when_it_is_asked_to(
    desk: Desk, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rubric_what_if, "now", lambda: "2026-11-20T10:00:01+00:00")
    page = words(desk.get(f"/what-if?weight:{ADDRESS}=14").text)
    assert "2 of 3 final grades change; mean of graded 96.7 → 94.7" in page
    assert row(out, "bob")["total"] == "94"
    saved = desk.post("/what-if", {f"weight:{ADDRESS}": "14", "do": "save"})
    assert saved.status == 303
    kept = words(desk.get(saved.headers["location"]).text)  # with the values that were entered
    assert "No grade has changed. 2 of 3 final grades change" in kept
    assert "Save and regrade the class: 2 grades change" in kept
    (file,) = out.glob("rubric-*.yaml")
    assert {each.id: each.max_points for each in rubric.load(LAB, file).checks}[ADDRESS] == 10.0
    assert row(out, "bob")["total"] == "94"
    assert "2 of 3 final grades change" in words(desk.get("/what-if?price:sensor-id-as-address=1").text)
    monkeypatch.setattr(rubric_what_if, "now", lambda: "2026-11-20T10:00:02+00:00")
    desk.post("/what-if", {"price:sensor-id-as-address": "1", "do": "mark"})
    assert len([*out.glob("rubric-*.yaml")]) == 2
    assert [row(out, id_)["total"] for id_ in ("bob", "cyd")] == ["99", "98"]
    assert "99 / 100" in words(desk.get("/submission/bob").text)
    desk.book.settled()
    for id_, total in (("ada", 100), ("bob", 99), ("cyd", 98)):
        assert f"{total} / 100" in words((out / "submissions" / id_ / "report.html").read_text())


def test_of_two_who_regrade_the_class_at_once_the_later_one_is_told_and_the_first_rubric_stays(
    desk: Desk, out: Path
) -> None:
    with desk_over(out, "Eve") as other:
        pages = [each.get(f"/what-if?weight:{ADDRESS}={weight}").text for each, weight in ((desk, 14), (other, 28))]
        forms = [dict(re.findall(r'<input type="hidden" name="([^"]+)" value="([^"]*)"', page)) for page in pages]
        assert desk.post("/what-if", {**forms[0], "do": "mark"}).status == 303
        for late in (
            other.get(f"/what-if?{urlencode(forms[1])}"),
            *(each.post("/what-if", {**forms[1], "do": "mark"}) for each in (other, desk)),
        ):
            assert late.status == 409
            assert "Somebody has regraded the class by another rubric since you opened the page" in words(late.text)
            assert '<a href="/what-if">Open the page again</a>' in late.text
        for each in (desk, other):
            page = each.get("/what-if").text
            assert re.search(f'name="weight:{ADDRESS}"[^>]* value="14"', page)
            assert "another rubric than" not in page


def test_a_desk_with_a_rubric_of_its_own_starts_from_that_until_it_regrades_the_class(desk: Desk, out: Path) -> None:
    desk.post("/what-if", {f"weight:{ADDRESS}": "14", "do": "save"})
    (file,) = out.glob("rubric-*.yaml")
    with desk_over(out, rubric=file) as other:
        page = other.get("/what-if").text
        assert "The class was graded with another rubric" in page
        assert re.search(f'name="weight:{ADDRESS}"[^>]* value="14"', page)
        form = dict(re.findall(r'type="hidden" name="(seen)" value="([^"]*)"', page))
        assert other.post("/what-if", {**form, f"weight:{ADDRESS}": "15", "do": "mark"}).status == 303
        page = other.get("/what-if").text
        assert re.search(f'name="weight:{ADDRESS}"[^>]* value="15"', page)
        assert "another rubric than" not in page


# ---- files as they were handed in ----


@pytest.mark.parametrize(("file", "place"), [("filters.py", 9), ("noisy_imu.py", 9), ("filters.py", None)])
def test_what_does_not_run_costs_what_the_grade_lost(tmp_path: Path, file: str, place: int | None) -> None:
    """Also on hidden scenarios, where a check has no place."""
    parses = {"misconceptions": ("does-not-import",), "got": "SyntaxError", "where": Where(file, 3)}
    stops = {"got": "a program that stops before it is drawn: NameError", "where": place and Where("filters.py", place)}
    checks = [check.id for check in RUBRIC.checks if check.id.startswith("filtering.")]
    says = {checks[0]: parses, **{id_: {"outcome": "skipped"} for id_ in checks[1:]}, PLOT: stops}
    ann = Student("ann", {**dict.fromkeys(checks, 0.0), PLOT: 0.5}, says)
    with desk_over(make_class(tmp_path / "out", [ann])) as desk:
        assert row(desk.book.out, "ann")["total"] == "78"
        assert f"{file}, line 3: SyntaxError. Costs 22 points." in words(desk.get("/").text)


def test_the_file_of_the_first_lost_check_is_shown_first(tmp_path: Path) -> None:
    says = {"got": "TypeError at filters.py, line 2", "where": Where("filters.py", 2)}
    files = {"a.py": b"x = 1\n", "filters.py": FILTER, "z.py": b"y = 1\n"}
    with desk_over(make_class(tmp_path / "out", [Student("ann", {ADDRESS: 0.0}, {ADDRESS: says}, files)])) as desk:
        page = words(desk.get("/submission/ann").text)
    assert "filters.py a.py z.py filters.py Edit" in page


def test_what_is_kept_is_bounded_and_says_what_it_left_out() -> None:
    files = {"a.py": b"x", "big.bin": bytes(LARGEST + 1), **{f"n{k}.txt": b"y" for k in range(500)}}
    kept = unpack(pack(files))
    assert kept.files["a.py"] == b"x"
    assert len(kept.files) == 200
    assert len(kept.others) + kept.more == len(files) - 200
    assert sum(map(len, unpack(pack({f"{k}.py": bytes(900_000) for k in range(9)})).files.values())) <= 4_000_000


# ---- hostile text ----


NASTY = "<script>alert(1)</script>\x1b[31m\u202e{{ 7 * 7 }}"
HOSTILE_FILES = {
    "filters.py": b"<script>alert(1)</script>\nx = '</code></li></ol>'\n\x1b[31mred\x00\x07\n\xff\xfe\n"
    + b"y" * 5000
    + b"\n"
    + "\u202e# rtl\n".encode(),
    "<img src=x onerror=alert(2)>.py": b"pass\n",
    "huge.py": b"a = 1\n" * 100_000,
    "one-line.py": b"'" * 300_000,
    "nested.py": b"(" * 60_000,
    "page.html": b"<script>alert(3)</script>",
    "not-a-picture.png": b"<svg onload=alert(4)>",
    "bomb.png": PNG[:16] + b"\x00\x0f\xff\xff\x00\x0f\xff\xff" + PNG[24:],
    "real.png": PNG,
    "broken.ipynb": b'{"cells": [{"cell_type": "code", "source": [1]}]}',
    "deep.ipynb": b"[" * 100_000,
}


def test_nothing_of_a_hostile_submission_leaves_its_quotation_marks(tmp_path: Path) -> None:
    says = {ADDRESS: {"got": NASTY, "hint": NASTY}}
    out = make_class(
        tmp_path / "out", [Student("evil", {ADDRESS: 0.0}, says, HOSTILE_FILES, name=NASTY, notes=(NASTY,))]
    )
    with desk_over(out) as desk:
        give(desk, "evil", ADDRESS, "1", NASTY, who="%3Cscript%3E")
        desk.post("/regrade-requests", {"text": NASTY, "who": "evil"})
        for path in (*(path for path in app.PAGES if "{" not in path and path != "/find"), "/submission/evil"):
            page = desk.get(path)
            assert page.status == 200, path
            assert "<script>alert" not in page.text
            assert "<img src=x" not in page.text
            assert not {"\x1b", "\u202e", "\x00", "\x07"} & set(page.text)
        text = desk.get("/submission/evil").text
        assert "{{ 7 * 7 }}" in text
        assert len(text) < 3_000_000
        assert "and 98501 more lines" in words(text)
        places = list(desk.book.on_thread(lambda: desk.book.kept(desk.book.final_grades()["evil"]).files))
        served = {name: desk.get(f"/submission/evil/picture/{place}") for place, name in enumerate(places)}
        assert [name for name, answer in served.items() if answer.status == 200] == ["real.png"]
        assert served["real.png"].headers["content-type"] == "image/png"
        assert desk.get("/submission/evil/picture/99").status == 400
        assert "its header says 1048575 × 1048575 pixels" in text


@pytest.mark.parametrize(
    "path",
    ["/submission/nobody", "/groups/fault/none", "/similar/ada/ada", "/similar/ada/zed", "/submission/..%2f..%2fetc"],
)
def test_what_is_not_there_is_said_in_one_line(still: Desk, path: str) -> None:
    answer = still.get(path)
    assert answer.status in (400, 404)
    assert "does not exist" in words(answer.text)


# ---- the command ----


def test_without_the_extra_the_command_says_how_to_install_it(
    out: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.startswith("grader.desk.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delattr("grader.desk.serving", raising=False)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    told = "imugrade: review needs uvicorn, which comes with: pip install 'imugrade[desk]'\n"
    assert in_process(capsys)("review", out) == (2, "", told)


def test_the_command_adjusts_what_the_desk_does(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = in_process(capsys)
    for wish, told in {
        f"bob --criterion {ADDRESS} --points 5 --comment x": f"bob {ADDRESS} 5, final 99\n",
        "bob --criterion bonus --points 2 --comment x": "bob bonus 2, final 101\n",
        "bob --criterion filtering --comment neat": "bob filtering comment, final 101\n",
        "bob --criterion bonus --undo": "bob bonus withdrawn, final 99\n",
        f"--having sensor-id-as-address --criterion {ADDRESS} --points 6 --comment misled": (
            f"bob {ADDRESS} 6, final 100\ncyd {ADDRESS} 6, final 99\n"
        ),
        "--take-back 1": f"bob {ADDRESS} 5, final 99\ncyd {ADDRESS} withdrawn, final 96\n",
    }.items():
        assert run("adjust", out, *wish.split()) == (0, told, "")
    assert "(decision 1: fault: sensor id as address)" in run("adjust", out)[1]
    none = run("adjust", out, *f"--having nothing --criterion {ADDRESS} --points 1".split())
    assert "no two submissions have this in common" in none[2]


def test_what_if_edits_the_late_policy(tmp_path: Path) -> None:
    late = HandIn(submitted="2026-11-21T12:00:00+00:00")
    out = make_class(tmp_path / "out", (Student("ada", hand_in=late), Student("bob")))
    given = {"late:due": "2026-11-20T23:00+00:00", "late:per_day": "10%"}
    with desk_over(out) as desk:
        assert "1 of 2 final grades change" in words(desk.get(f"/what-if?{urlencode(given)}").text)
        for wish, final in ((given, "90"), (dict.fromkeys(given, ""), None)):
            assert desk.post("/what-if", {**wish, "do": "mark"}).status == 303
            desk.book.settled()
            assert (row(out, "ada")["total"], row(out, "ada").get("final")) == ("100", final)
            assert (" − late 10" in words((out / "submissions/ada/report.html").read_text())) == bool(final)
            assert f'name="late:due" size="24" value="{wish["late:due"][:10]}' in desk.get("/what-if").text
        assert "due must be a date and time" in words(desk.get("/what-if?late:due=tomorrow").text)
