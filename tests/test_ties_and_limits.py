"""Ties, limits and refusals: of two that fit none is taken, what is refused uses nothing up, and one worse check outweighs a gain."""

from __future__ import annotations

import ast
import threading
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path, PurePosixPath
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from packaging.requirements import Requirement

from grader.base.errors import Crashed, RequestError
from grader.course.publishing.contradictions import Contradiction
from grader.course.regrading.groups import decisions, groups
from grader.desk import drafts, regrade_requests, review_queue
from grader.desk.similarity_groups import SimilarityGroup
from grader.engine.check_catalog import Check
from grader.engine.check_runner import CheckRun, Judgement
from grader.engine.feedback import Feedback
from grader.engine.grader import Marker
from grader.engine.rubric import LatePolicy
from grader.intake.downloads import Download
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.labs.imu.worker import noise, simulation
from grader.people.final_grade import Adjustment, FinalGrade, HandIn, Lateness, Person, untimed
from grader.people.late_policy import judged
from grader.platforms import canvas
from grader.platforms.found import AMBIGUOUS, at_least_half
from grader.sandbox.exchange import Deadline, DeadlineError
from grader.sandbox.packages import Installed, for_students
from grader.worker import environment, faults, fuzzy_names, notebooks, packages, saved, virtual_time
from grader.worker.drawing import Preview
from tests.corpus.special import png
from tests.corpus.writing import notebook, write
from tests.fake_results import check, lost, result, submission

PIXELS = np.random.default_rng(1).integers(0, 255, (48, 60, 3), dtype=np.uint8)
PICTURE = png(60, 48, b"".join(b"\0" + row.tobytes() for row in PIXELS))
DUE = datetime(2026, 11, 20, 12, tzinfo=timezone.utc)


@pytest.mark.parametrize(("day", "refused", "used"), [(22, False, 2), (27, False, 3), (28, True, 0)])
def test_a_refused_hand_in_uses_up_no_grace_days(day: int, refused: bool, used: int) -> None:
    policy = LatePolicy(DUE, grace_minutes=0, per_day=10.0, cut_off_days=7)
    late = judged(HandIn((Person("Ann"),), submitted=f"2026-11-{day}T12:00+00:00", grace_days=3), policy, ()).late
    assert late is not None
    assert (late.refused, late.grace_days) == (refused, used)


def test_a_hand_in_of_the_hour_that_clocks_repeat_is_a_day_late() -> None:
    due = datetime.fromisoformat("2026-10-25T02:45+02:00")
    policy = LatePolicy(due, grace_minutes=0, per_day=10.0, cut_off_days=7, tz="Europe/Berlin")
    late = judged(HandIn((Person("Ann"),), submitted="2026-10-25T02:15+01:00"), policy, ()).late
    assert late is not None
    assert (late.seconds, late.days) == (1800, 1)


def test_a_canvas_name_whose_two_readings_both_agree_with_the_roster_is_ambiguous(tmp_path: Path) -> None:
    name = "a_1_2_3_filters.py"  # A's attachment 2 of "3_filters.py", or A 1's attachment 3 of "filters.py"
    both = canvas.read(Download(tmp_path, "", {name: False}, known={"1": "A", "2": "A 1"}))
    one = canvas.read(Download(tmp_path, "", {name: False}, known={"1": "B", "2": "A 1"}))
    assert both is not None
    assert one is not None
    assert (both.found, both.left) == ((), ((name, AMBIGUOUS),))
    assert [each.sources for each in one.found] == [((name, "filters.py"),)]


def test_the_newest_attachment_is_told_by_all_of_its_digits(tmp_path: Path) -> None:
    names = ["li_7_123456_filters.py", "li_7_123455_filters.py"]
    shape = canvas.read(Download(tmp_path, "", dict.fromkeys(names, False)))
    assert shape is not None
    assert [each.sources for each in shape.found] == [((names[0], "filters.py"),)]


@pytest.mark.parametrize(
    ("answers", "enough"), [([True, False], True), ([True, False, False], False), ([], False)], ids=str
)
def test_half_of_the_names_make_a_download_and_nothing_makes_none(answers: list[bool], enough: bool) -> None:
    assert at_least_half(answers) is enough


def test_a_late_mark_beside_a_time_vouches_for_those_without_both() -> None:
    late, other = HandIn(submitted="2026-11-21T12:00+00:00", marked_late=True), HandIn()
    for hand_in, unknown in (
        (late, []),
        (replace(late, marked_late=False), ["b"]),
        (replace(late, submitted=""), ["a"]),
    ):
        assert untimed([FinalGrade("a", result(), hand_in), FinalGrade("b", result(), other)]) == unknown


def _queue(
    *final_grades: FinalGrade, groups: Sequence[SimilarityGroup] = (), contradictions: Sequence[Contradiction] = ()
) -> list[str]:
    by_id = {each.id: each for each in final_grades}
    items = review_queue.items(by_id, groups, {}, (), {}, contradictions, (), LAB, None)
    return [" ".join([item.reason.kind, *item.ids]) for item in items]


@pytest.mark.parametrize(("points", "queued"), [(4.0, []), (5.0, ["boundary a"]), (5.5, ["boundary a"])])
def test_a_grade_on_a_boundary_is_not_below_it(points: float, queued: list[str]) -> None:
    full = check(id="sensor_access.matches_truth", points=14.0, max_points=14.0)
    assert _queue(FinalGrade("a", result(check("partial", points), full))) == queued


def test_times_that_nobody_knows_are_in_the_queue_once() -> None:
    unknown = Contradiction("unknown lateness", "", "two times are unknown", stops_export=False)
    marked = HandIn(marked_late=True, late=Lateness("", None))
    assert _queue(FinalGrade("a", result()), contradictions=[unknown]) == ["lateness "]
    assert _queue(FinalGrade("a", result(), marked), contradictions=[unknown]) == ["lateness a"]


def test_similar_code_of_some_who_have_the_same_files_is_not_listed_again() -> None:
    three = [replace(result(name=id_), provenance={"submission_sha256": "1"}) for id_ in "abc"]
    alike = SimilarityGroup(("a", "b"), (0.9, 0.9), (9, 9))
    assert _queue(*(FinalGrade(each.submission, each) for each in three), groups=[alike]) == ["same-files a b c"]


def test_the_largest_group_is_first_and_nobody_is_in_it_whose_code_did_not_run() -> None:
    faults = {"a": ("rare", "usual"), "b": ("rare", "usual"), "c": ("usual",), "d": ("usual",)}
    found = {id_: FinalGrade(id_, result(lost(misconceptions=names))) for id_, names in faults.items()}
    found["d"] = FinalGrade("d", replace(found["d"].result, status="empty"))
    assert [(each.key, each.ids) for each in groups(found)] == [
        ("usual", ("a", "b", "c")), ("rare", ("a", "b")), ("sensor_access.follows_address", ("a", "b", "c"))
    ]  # fmt: skip


def test_the_latest_decision_on_a_group_is_listed_first() -> None:
    made = [("a", Adjustment("filtering", 1.0, "", "Ann", "", decision=number)) for number in (1, 1, 2)]
    store: Any = SimpleNamespace(history=lambda: made, decisions=lambda: {1: "first", 2: "second"})
    assert [(each.what, each.made) for each in decisions(store, {})] == [("second", 1), ("first", 2)]


@pytest.mark.parametrize(("fields", "kept"), [("[]", []), ("", []), ('[["points", "6"]]', ["ann /a#points"])])
def test_a_form_without_a_field_is_no_draft(fields: str, kept: list[str]) -> None:
    drafts_of = {"ann /a#points"}
    store = SimpleNamespace(
        drop_draft=lambda who, form: drafts_of.discard(f"{who} {form}"),
        keep_draft=lambda who, form, text: drafts_of.add(f"{who} {form}"),
    )
    form: Any = SimpleNamespace(author="ann", text={"draft": "/a#points", "fields": fields}.__getitem__)
    drafts.keep(SimpleNamespace(store=store), form)  # type: ignore[arg-type] # as far as it is used
    assert sorted(drafts_of) == kept


def test_a_regrade_request_has_the_longest_length_at_most() -> None:
    assert [each.text for each in regrade_requests.read("x" * regrade_requests.LONGEST, "ann", "")] == ["x" * 8000]
    with pytest.raises(RequestError, match="is longer than 8000 characters"):
        list(regrade_requests.read("x" * (regrade_requests.LONGEST + 1), "ann", ""))


@pytest.mark.parametrize(
    ("own", "taken"),
    [
        (["LowpassFilter"], ["LowpassFilter"]),
        (["LowpassFilter", "LowpassFilter"], ["LowpassFilter"]),
        (["LowpassFilter", "Low_Pass_Filter"], []),
        (["LowPassFilter", "LowpassFilter"], []),
    ],
)
def test_of_two_names_that_are_nearly_the_wanted_one_none_is_taken(own: list[str], taken: list[str]) -> None:
    nodes = ast.parse("\n".join(f"class {name}: ..." for name in own)).body
    assert list(fuzzy_names.misspelled(nodes, ["LowPassFilter"])) == [("LowPassFilter", name) for name in taken]


def test_as_many_picture_files_are_read_as_the_limit_says(tmp_path: Path) -> None:
    names = [f"{number:02}.png" for number in range(saved._MOST_READ + 2)]
    for name in names:
        (tmp_path / name).write_bytes(b"no picture")
    known: dict[str, bytes | None] = {}
    saved.match_files_to_figures([], str(tmp_path), known)
    assert [*known] == names[:24]


@pytest.mark.parametrize(("second", "first"), [("a.png", "overwritten"), ("more/a.png", "saved")])
def test_a_figure_is_overwritten_by_a_later_one_in_the_same_file_alone(second: str, first: str, tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    drawn = []
    for place in (tmp_path / "a.png", tmp_path / second):
        place.write_bytes(b"the same picture")
        drawn.append(saved.RecordedFigure({"event": "saved", "path": "a.png"}, None, place.read_bytes(), str(place)))
    saved.match_files_to_figures(drawn, str(tmp_path), {})
    assert [each.facts["event"] for each in drawn] == [first, "saved"]


def test_of_two_cells_that_write_a_file_the_later_one_counts() -> None:
    book = notebook(*(f"%%writefile filters.py\nx = {n}" for n in range(2)))
    assert notebooks.files_written(book.encode()) == {"filters.py": "x = 1\n"}


def test_of_four_vectors_the_first_two_are_the_reading() -> None:
    vectors = {name: np.full(3, n) for n, name in enumerate(("gyro", "accel", "accel_true", "gyro_true"))}
    assert [vector[0] for vector in noise._two_vectors(vectors)] == [1, 0]


def test_a_package_that_the_grader_needs_is_shown_if_one_copy_was_asked_for() -> None:
    copies = [Installed("rich", "1", True, ()), Installed("rich", "2", False, ())]
    assert for_students([Installed("imugrade", "0", False, (Requirement("rich"),)), *copies]) == copies


@pytest.mark.parametrize(("handed_in", "there"), [({}, "ours"), ({"robot.xml": "own"}, "own")], ids=["none", "own"])
def test_a_model_where_the_sheet_loads_it_is_the_students_if_there_is_one(
    handed_in: dict[str, str], there: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulation, "mujoco", SimpleNamespace(MjModel=SimpleNamespace(from_xml_path=None)))
    monkeypatch.setattr(environment, "_INSTEAD", {})
    write(handed_in, tmp_path)
    simulation._place_model(PurePosixPath(tmp_path / "robot.xml"), "robot.xml", "ours")
    assert (tmp_path / "robot.xml").read_text() == there


def test_a_thread_that_ended_is_joined_at_once_however_often(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("start", "join"):
        monkeypatch.setattr(threading.Thread, name, getattr(threading.Thread, name))
    clock = virtual_time.Clock()
    clock.add("main")
    clock.enter("main")
    virtual_time._replace_threads(clock)
    thread = threading.Thread(target=clock.advance, args=(1.0,))
    thread.start()
    for _ in range(2):
        thread.join(5.0)
    assert clock.passed_s == 1.0


@pytest.mark.parametrize(("code", "nothing"), [(b"class Game: ...", True), (b"class ComplementaryFilter: ...", False)])
def test_code_that_earns_nothing_is_of_this_lab_by_the_name_of_an_extension_too(code: bytes, nothing: bool) -> None:
    marker: Any = SimpleNamespace(_lab=LAB)
    graded = replace(result(check("error", 0.0, keeps=0.0)), extensions=())
    handed_in = replace(submission("x"), files={"own.py": code})
    assert Marker._has_nothing_to_grade(marker, handed_in, graded) is nothing


@pytest.mark.parametrize(("before", "event"), [({}, "saved"), ({"a.png": PICTURE}, "shown")], ids=["new", "handed in"])
def test_a_picture_that_lay_there_before_shows_no_figure(
    before: dict[str, bytes | None], event: str, tmp_path: Path
) -> None:
    (tmp_path / "a.png").write_bytes(PICTURE)
    drawn = [saved.RecordedFigure({"event": "shown"}, Preview(PIXELS, (60.0, 48.0), 100.0))]
    saved.match_files_to_figures(drawn, str(tmp_path), dict(before))
    assert drawn[0].facts["event"] == event


def test_a_fault_is_told_at_the_innermost_line_of_the_students_code() -> None:
    names: dict[str, Any] = {}
    exec(
        compile("def inner():\n    raise LookupError\ndef outer():\n    inner()\n", faults.own_name("lab.py"), "exec"),
        names,
    )
    with pytest.raises(LookupError) as caught:
        names["outer"]()
    assert (faults.describe(caught.value)["file"], faults.describe(caught.value)["line"]) == ("lab.py", 2)


@pytest.mark.parametrize(
    ("line", "package"), [("from lab4 import imu_reader", {"lab4"}), ("from skimage import filters", set())]
)
def test_a_module_that_libraries_have_too_makes_no_package(line: str, package: set[str]) -> None:
    assert packages.imported_packages([line], ["imu_reader.py", "filters.py"], ["filters"]) == package


def test_time_in_which_the_grader_itself_stood_still_is_not_the_codes() -> None:
    times = iter([0.0, 0.1, 600.0, *np.arange(600.1, 700.0, 0.1)])
    deadline = Deadline(lambda: 0.0, lambda: next(times), cpu_s=10.0, wall_s=30.0)
    with pytest.raises(DeadlineError):
        list(iter(deadline.nap, None))
    assert 629.5 < next(times) < 630.5


class _Student:
    """Stands for the session about a submission: keeps what it is told to replace or to remember."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.broken: set[str] = set()
        self.remembered: list[dict[Any, Any]] = []

    def account_to(self, part: str) -> None: ...

    def replace_broken(self, names: Sequence[str]) -> None:
        self.broken |= set(names)

    @contextmanager
    def beside(self, standins: Collection[str]) -> Iterator[dict[Any, Any]]:
        yield {}

    def remember(self, answers: dict[Any, Any]) -> None:
        self.remembered.append(answers)


def _run() -> CheckRun:
    return CheckRun(LAB, _Student(), bundles.shipped(), None)  # type: ignore[arg-type] # as far as it is used


def _judged(**keeps: float) -> dict[str, Judgement]:
    checks = [Check(f"noise_model.{name}", name, 5) for name in keeps]
    outcomes = ("failed" if kept == 0 else "partial" if kept < 1 else "passed" for kept in keeps.values())
    texts = (Feedback(outcome, kept) for outcome, kept in zip(outcomes, keeps.values(), strict=True))  # type: ignore[arg-type]
    return {check.id: Judgement(check, text, "", 0.0) for check, text in zip(checks, texts, strict=True)}


@pytest.mark.parametrize(
    ("again", "counts"), [({"a": 1.0, "b": 1.0}, True), ({"a": 1.0, "b": 0.9}, False), ({"a": 0.0, "b": 1.0}, False)]
)
def test_a_second_run_beside_other_stand_ins_counts_if_a_check_gets_better_and_none_worse(
    again: dict[str, float], counts: bool
) -> None:
    run = _run()
    run.judgements = first = _judged(a=0.0, b=1.0)
    second = _judged(**again)
    with run.rerun_beside((), "noise_model"):
        run.judgements = dict(second)
    assert run.judgements == (second if counts else first)
    assert run.student.remembered == ([{}] if counts else [])  # type: ignore[attr-defined]


def test_a_check_that_ends_the_same_way_in_a_second_run_tells_it_again() -> None:
    run, ends, waits = _run(), *(Check(f"noise_model.{name}", name, 5) for name in ("noise_size", "read_is_fresh"))
    run.end(ends, Crashed("it ended"), 0.0)
    run.end(waits, Crashed("it ended"), 0.0)
    with run.rerun_beside((), "noise_model"):
        run.end(ends, Crashed("it ended"), 0.0)
        run.end(waits, None, 0.0)
    assert [each.feedback and each.feedback.outcome for each in run.judgements.values()] == ["crashed", "passed"]


def test_a_part_with_a_check_that_the_grader_could_not_judge_is_replaced_for_the_parts_that_follow() -> None:
    run = _run()
    run.end(Check("sensor_access.matches_truth", "title", 2), ZeroDivisionError("a fault of ours"), 0.0)
    run.begin(Check("noise_model.noise_size", "title", 5))
    assert run.student.broken == {"get_imu_readings"}
