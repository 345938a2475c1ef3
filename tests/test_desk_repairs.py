"""Repairs at the review desk: code that does not run comes first, is edited, previewed and saved; no student code runs in the desk."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grader.course.markers.pool import Pool
from grader.course.record.store import Store
from grader.course.run.class_grading import settings_on_record
from grader.desk import repair_jobs
from grader.desk.editing import as_bytes, editable
from grader.labs.imu.lab import LAB
from tests.class_commands import CHECK, column, commands, result_by_comment
from tests.desk import Desk, desk_over, words

STOPS, FIXED = "stops", "# 1"
SENTENCE = "filters.py, line 1: NameError: name &#39;x&#39; is not defined. Costs 6 points."


@contextmanager
def waiting_marker(rubric: Any, traces: Any, seen: Path) -> Iterator[Any]:
    """A made-up marker that writes down which process it is in, and waits as long as it is asked to."""

    def mark(submission: Any, cpu_s: float | None = None) -> Any:
        with open(seen, "a", encoding="ascii") as file:
            file.write(f"{os.getpid()}\n")
        while seen.with_name("wait").exists():
            time.sleep(0.01)
        return result_by_comment(submission, rubric, traces)

    yield SimpleNamespace(mark=mark)


@contextmanager
def pool_here(open_marker: partial[Any], *_: object) -> Iterator[Any]:
    """Stands in for the pool of one marker process, which takes half a second to start, where the process is not asked about."""

    def run(submissions: Iterator[Any], cpu_s: float | None = None) -> Iterator[tuple[Any, Any]]:
        for each in submissions:
            yield each, result_by_comment(each, *open_marker.args[:2])

    yield SimpleNamespace(run=run)


@pytest.fixture
def out(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Path:
    for id_, content in {"ada": STOPS, "bob": STOPS, "cyd": "# 0.5", "dan": STOPS}.items():
        (tmp_path / "class" / id_).mkdir(parents=True)
        (tmp_path / "class" / id_ / "filters.py").write_bytes(content.encode() + (b"\r\n" if id_ == "dan" else b"\n"))
        (tmp_path / "class" / id_ / "imu_reader.py").write_text(f"# {id_}\n")
    assert commands(monkeypatch, capsys)("grade", tmp_path / "class", "-o", tmp_path / "out")[0] == 0
    return tmp_path / "out"


@pytest.fixture
def desk(out: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    monkeypatch.setattr(repair_jobs, "Pool", pool_here)
    with desk_over(out) as opened:
        yield opened


def fields(page: str) -> dict[str, str]:
    """The hidden fields of the editor's form, and its text."""
    form = page.partition('class="editor"')[2].partition("</form>")[0]
    found = dict(re.findall(r'<input type="hidden" name="(\w+)" value="([^"]*)"', form))
    return {**found, "text": re.search(r'name="text"[^>]*>\n(.*?)</textarea>', form, re.DOTALL)[1]}  # type: ignore[index]


def ended(desk: Desk, address: str) -> str:
    """The page of a job when it has ended."""
    for _ in range(100):
        page = desk.get(address).text
        if "data-reload" not in page:
            return page
    raise AssertionError("the job does not end")


def sent(desk: Desk, id_: str, **form: object) -> str:
    """The page after a form, when the job has ended."""
    answer = desk.post(f"/submission/{id_}/repair", form)
    if answer.status != 303:
        return answer.text
    page = ended(desk, answer.headers["location"])
    desk.book.settled()
    return page


def previewed(desk: Desk, id_: str = "ada", text: str = f"{FIXED}\n") -> str:
    form = fields(desk.get(f"/submission/{id_}?edit=filters.py").text)
    return sent(desk, id_, **{**form, "text": text.replace("\n", "\r\n"), "do": "preview"})


def saved(desk: Desk, page: str, id_: str = "ada", **more: object) -> str:
    form = {**fields(page), "deduct": "5", "comment": "x was never set", "do": "save", **more}
    return sent(desk, id_, **form)


def test_what_does_not_run_is_first_in_the_queue_and_opens_in_the_editor_at_its_line(desk: Desk) -> None:
    page = desk.get("/").text
    first = page.partition('<ul class="queue">')[2].partition("</li>")[0]
    assert "Does not run" in first
    assert SENTENCE in first
    assert '<a href="/submission/ada?edit=filters.py#edit">Repair' in first
    assert "cyd" not in page.partition("<main")[2]
    page = desk.get("/submission/ada?edit=filters.py").text
    assert fields(page)["text"] == "stops\n"
    assert re.search(r'<li id="file-\d-1" class="named">1</li>', page)
    assert "Edit imu_reader.py" in words(page)
    assert 'class="editor"' not in desk.get("/submission/ada?edit=nothing.py").text


def test_a_preview_records_nothing_and_a_saved_repair_is_the_commands_and_is_undone(desk: Desk, out: Path) -> None:
    before = (out / "gradebook.csv").read_bytes()
    preview = previewed(desk)
    for told in ("Filtering of 20 14 20 +6", "Sensor access of 20 20 20", "Sum of 100 94 100 +6", "-stops +# 1"):
        assert told in words(preview)
    assert (out / "gradebook.csv").read_bytes() == before
    page = saved(desk, preview)
    assert "ada: filters.py repaired, 94 points before, 95 points now" in words(page)
    assert column(out / "gradebook.csv", "total")["ada"] == "95"
    (repair,) = json.loads((out / "submissions/ada/result.json").read_text())["repairs"]
    assert {key: repair[key] for key in ("file", "deduction", "author", "comment", "score_before")} == {
        "file": "filters.py", "deduction": 5.0, "author": "prof", "comment": "x was never set", "score_before": 94.0,
    }  # fmt: skip
    assert "x was never set" in (out / "submissions/ada/report.html").read_text()
    assert "/submission/ada?edit" not in desk.get("/").text
    assert "<code># 1</code>" in re.sub(r"<(?!/?code)[^>]*>", "", page)
    assert 'value="undo"' in page
    assert "ada: repair of filters.py taken back, 94 points now" in words(
        sent(desk, "ada", file="", do="undo", repairs=1)
    )
    assert column(out / "gradebook.csv", "total")["ada"] == "94"
    assert SENTENCE in desk.get("/").text


def test_of_two_at_once_nobody_takes_back_a_repair_that_only_the_other_has_seen(desk: Desk, out: Path) -> None:
    once = dict(
        re.findall(r'name="(file|repairs)" value="([^"]*)">', saved(desk, previewed(desk)).partition("Undoing it")[2])
    )
    saved(desk, previewed(desk, text=f"{FIXED}\n\n"), deduct="2")
    late = sent(desk, "ada", **once, do="undo")
    assert "Somebody has saved or undone a repair since you opened the page" in words(late)
    assert len(json.loads((out / "submissions/ada/result.json").read_text())["repairs"]) == 2


def test_after_a_change_of_the_rubric_a_preview_is_by_the_new_one(desk: Desk) -> None:
    for weight, told in (("6", "Filtering of 20 14 17 +3"), ("9", "Filtering of 20 12.18 16.09 +3.91")):
        desk.post("/what-if", {f"weight:{CHECK}": weight, "do": "mark"})
        assert told in words(previewed(desk, text="# 0.5\n"))


def test_the_same_repair_is_offered_to_the_same_file_with_the_same_error(desk: Desk, out: Path) -> None:
    page = previewed(desk)
    assert re.findall(r'name="also" value="(\w+)"', page) == ["bob"]  # dan's bytes differ
    told = words(saved(desk, page, also="bob"))
    assert "bob: filters.py repaired, 94 points before, 95 points now" in told
    assert column(out / "gradebook.csv", "total") == {"ada": "95", "bob": "95", "cyd": "97", "dan": "94"}


def test_an_error_stands_beside_its_field_and_what_was_typed_stays(desk: Desk, out: Path) -> None:
    preview, points = previewed(desk), "Enter points from 0 to 100, with at most two decimals."
    for name, typed, said in (
        ("deduct", "x", points),
        ("deduct", "101", points),
        ("deduct", "nan", points),
        ("deduct", "٣", points),
        ("deduct", "1_0", points),
        ("comment", "", "Say what you changed. The student reads this."),
        ("comment", "x" * 2001, "At most 2000 characters."),
    ):
        page = saved(desk, preview, **{"comment": "kept <b>", "deduct": "3", name: typed})
        assert f'<span class="error" id="error-{name}">{said}</span>' in page
        assert f'aria-invalid="true" aria-describedby="error-{name}"' in page
        assert fields(page)["text"] == "# 1\n"
        assert ("kept &lt;b&gt;" in page) == (name != "comment")
        assert ('value="3"' in page) == (name != "deduct")
        assert column(out / "gradebook.csv", "total")["ada"] == "94"


def test_an_unchanged_file_and_a_worse_one_are_not_saved(desk: Desk) -> None:
    assert "Nothing in the file has changed." in previewed(desk, text="stops\n")
    assert "The form does not say what to do. Nothing was saved" in saved(desk, previewed(desk), do="")
    for text, repaired in (("# 0.25\n", "earns 95.5 points"), ("# nothing\n", "could not be graded")):
        page = previewed(desk, "cyd", text)
        assert (
            f"cyd earns 97 points as it was handed in, and {repaired} with this repair. This edit cannot be saved."
            in words(page)
        )
        assert 'value="save"' not in page


def test_of_two_people_the_slower_one_is_told(desk: Desk, out: Path) -> None:
    first, second = previewed(desk), previewed(desk, text="# 0.9\n")
    saved(desk, first)
    assert "Somebody has repaired filters.py since you opened it" in saved(desk, second)
    assert column(out / "gradebook.csv", "total")["ada"] == "95"


def test_a_text_that_was_not_previewed_is_refused_with_all_that_was_typed(desk: Desk, out: Path) -> None:
    page = saved(desk, previewed(desk), text="# 0.9\n", comment="kept")
    assert "Not saved: the text has changed since the preview." in words(page)
    assert fields(page)["text"] == "# 0.9\n"
    assert fields(page)["comment"] == "kept"
    assert 'class="compared"' not in page  # the grades of another text
    assert column(out / "gradebook.csv", "total")["ada"] == "94"


def test_a_second_repair_names_the_deduction_of_the_first_one_in_the_form_and_in_the_sum(desk: Desk) -> None:
    saved(desk, previewed(desk, text="# 0.9\n"), deduct="1")
    page = words(previewed(desk))
    for told in (
        "Sum of 100 99.4 100",
        "Deduction of the repairs before −1 −1",
        "Score of 100 98.4 99",
        "points from 99, in which the repairs before deduct 1",
    ):
        assert told in page


def test_a_repair_of_other_files_than_those_handed_in_is_said_not_to_count(
    desk: Desk, out: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    saved(desk, previewed(desk))
    (out.parent / "class" / "ada" / "filters.py").write_text("# 0.25\n")
    run = commands(monkeypatch, capsys)
    run("grade", out.parent / "class", "-o", out)
    said = "no longer counts: the student handed in other files since"
    for path in ("/", "/submission/ada"):
        assert f"The repair of filters.py by prof (−5 points) {said}" in words(desk.get(path).text)
    assert f"({said}" in run("repair", out, "--list")[1]


def test_the_desk_answers_while_another_process_makes_a_preview_and_says_what_is_going_on(
    desk: Desk, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(repair_jobs, "Pool", Pool)
    made = settings_on_record(LAB, out, None)
    opener = partial(waiting_marker, made.rubric, made.traces, out.parent / "seen")
    desk.book.jobs.close()
    desk.book.jobs = repair_jobs.RepairJobs(lambda: replace(made, open_marker=opener))
    wait = out.parent / "wait"
    wait.touch()
    form = fields(desk.get("/submission/ada?edit=filters.py").text)
    address = desk.post("/submission/ada/repair", {**form, "text": "# 1\n", "do": "preview"}).headers["location"]
    while "Grading the edited copy in the sandbox" not in (page := desk.get(address).text):
        pass
    assert "data-reload" in page
    assert fields(page)["text"] == "# 1\n"
    assert desk.get("/class").status == 200
    wait.unlink()
    assert "Sum of 100" in words(ended(desk, address))
    assert str(os.getpid()) not in (out.parent / "seen").read_text().split()


def test_a_class_of_a_secret_is_not_graded_without_it(desk: Desk, out: Path) -> None:
    with Store.existing(out) as store:
        store.keep_settings(replace(store.settings(), hidden=True))  # type: ignore[type-var]
    for page in (desk.get("/").text, desk.get("/submission/ada?edit=filters.py").text, previewed(desk)):
        assert "graded on hidden scenarios; set IMUGRADE_SEED" in words(page)


@pytest.mark.parametrize(
    "content",
    [b"", b"a", b"a\n", b"\na\n\n", b"a\r\nb\r\n", b"a\nb\r\nc\rd", "\ufeffa = 'ä'\r\n".encode(), b"a\x0cb\n"],
)
def test_a_browser_changes_no_byte_of_a_file_that_nobody_edited(content: bytes) -> None:
    text = editable("a.py", content).text
    assert as_bytes(content, text) == content
    assert as_bytes(content, text.replace("\n", "\r\n")) == content


@pytest.mark.parametrize(
    ("path", "content", "why"),
    [
        ("lab.ipynb", b"{}", "only .py files"),
        ("a.py", b"#" * 200_001, "larger than 200 kB"),
        ("a.py", b"a\x00b", "control characters"),
    ],
)
def test_what_a_browser_cannot_keep_is_not_edited_in_it(path: str, content: bytes, why: str) -> None:
    assert why in editable(path, content).why
