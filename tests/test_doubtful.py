"""The doubtful cases of an evening: each graded as it is handed in, then listed at the desk with its reason, and ticked."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
from markupsafe import escape

from grader.base.errors import GraderError
from grader.course import classroom, submissions
from grader.course.grade_request import GradeRequest
from grader.desk.overviews import queue
from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.rubric import Rubric
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.labs.imu.student import Student
from tests.corpus.pieces import edit, tidy, verbatim
from tests.corpus.writing import write
from tests.desk import Desk, desk_over, words
from tests.examples import FOLDER
from tests.fake_results import Nobody

FAILS = "# the sandbox fails over this one\n"
UNITS = (
    ("'Acceleration (m/s²)'", "'Acceleration'"),
    ("'Time (s)'", "'Time'"),
    ("'Angular Velocity (rad/s)'", "'Angular Velocity'"),
)


def nearly() -> dict[str, str]:
    """Six points lost by an id as an address, three by labels without units, and half of three by a state that is handed out."""
    address = (
        ("model.sensor_adr[accel_sensor_id]", "accel_sensor_id"),
        ("model.sensor_adr[gyro_sensor_id]", "gyro_sensor_id"),
    )
    files = edit(verbatim(), "imu_reader.py", *address, *UNITS)
    return edit(files, "filters.py", ("return self.value.copy()", "return self.value"))


def undrawn() -> dict[str, str]:
    """The sheet's code without that of its first plot."""
    files, called = verbatim(), "plot_imu_data(imu_data)\n"
    source = files["imu_reader.py"]
    without = source[: source.index("def plot_imu_data")] + source[source.rindex(called) + len(called) :]
    return {**files, "imu_reader.py": without}


@contextmanager
def stumbling(by: Rubric, bundle: Traces) -> Iterator[Marker]:
    """A marker whose sandbox fails over one submission."""
    really = Student.filter

    def fails(student: Student, *args: object, **named: object) -> object:
        if FAILS.encode() in student.files.get("filters.py", b""):
            raise GraderError("the sandbox did not answer")
        return really(student, *args, **named)  # type: ignore[arg-type]

    Student.filter = fails  # type: ignore[method-assign, assignment]
    try:
        with classroom.guarded_marker(by, bundle, None, trusted=True) as marker:
            yield marker
    finally:
        Student.filter = really  # type: ignore[method-assign]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class of seven: one of each case, a sound one and two that are the same, graded as `grade` does."""
    students, made = tmp_path_factory.mktemp("class"), tmp_path_factory.mktemp("graded") / "out"
    pictures = {
        name: (FOLDER / "s01-sheet-verbatim" / name).read_bytes() for name in ("imu_data.png", "filtered_imu.png")
    }
    ours = edit(tidy(), "filters.py", ("class LowPassFilter:", f"{FAILS}class LowPassFilter:"))
    folders = {
        "nearly": nearly(),
        "ours": ours,
        "undrawn": {**undrawn(), **pictures},
        "png": pictures,
        "other": {"kinematics.py": "import numpy as np\n\n\ndef forward(q):\n    return np.eye(4)\n"},
        "sound": tidy(),
        **dict.fromkeys(("twin1", "twin2"), edit(tidy(), "filters.py", ("Filter a noisy", "Filter another noisy"))),
    }
    for name, files in folders.items():
        write(files, students / name)
    order = GradeRequest((students,), made, rubric.load(LAB), bundles.shipped(), jobs=1, trusted=True)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(classroom, "opener", lambda order: partial(stumbling, order.rubric, order.traces))
        classroom.grade_class(order, submissions.find(order), Nobody())
    return made


@pytest.fixture
def desk(out: Path) -> Iterator[Desk]:
    with desk_over(out) as opened:
        yield opened


def listed(desk: Desk, kind: str) -> list[tuple[str, str, str]]:
    """What stands on the page of one kind, open or done: who, why, and what a form sends to mark it as reviewed."""
    found = desk.book.on_thread(lambda: queue(desk.book))
    return [(each.id, each.reason.sentence, each.key) for each in found if each.reason.kind == kind]


CASES = {
    "boundary": ("nearly", "0.5 below 90, and 1.5 points were lost on partial checks: ", "Near a grade boundary"),
    "not-judged": ("ours", "The grader failed on these checks, so their points are open: ", "Grader failed"),
    "picture": (
        "undrawn",
        "imu_data.png was handed in, and plot_imu_data does not draw it. ",
        "Plot that could not be judged",
    ),
    "empty": ("png", "", "Empty"),
    "nothing": ("other", "The submission has no points. ", "No points"),
}


@pytest.mark.parametrize("kind", CASES)
def test_a_doubtful_case_is_listed_with_its_reason_and_ticked(desk: Desk, kind: str) -> None:
    who, why, title = CASES[kind]
    ((id_, sentence, key),) = listed(desk, kind)
    assert (id_, sentence[: len(why)]) == (who, why)
    page = desk.get(f"/?kind={kind}").text
    assert f"{title} 1" in words(page)
    assert escape(sentence) in page
    assert re.findall(r'name="look" value="([^"]*)"', page) == [key]
    assert title in words(desk.get(f"/submission/{who}").text)
    assert desk.post("/reviewed", {"look": key, "done": "yes"}, "Ann").status == 303
    assert f"{title} 1" not in words(desk.get("/").text)
    assert "Reviewed by Ann" in desk.get(f"/?kind={kind}").text
    desk.post("/reviewed", {"look": key, "done": "no"})
    assert f"{title} 1" in words(desk.get("/").text)


def test_a_fault_of_ours_takes_no_point_and_the_sound_one_is_not_listed(desk: Desk) -> None:
    final_grades = desk.book.on_thread(desk.book.final_grades)
    assert (final_grades["ours"].final, final_grades["nearly"].final, final_grades["sound"].final) == (
        None,
        89.5,
        100.0,
    )
    found = desk.book.on_thread(lambda: queue(desk.book))
    assert [each.reason.kind for each in found if each.id == "sound"] == []


def test_pictures_without_any_code_are_shown_to_whoever_looks(desk: Desk) -> None:
    page = desk.get("/submission/png").text
    addresses = re.findall(r'src="(/submission/png/picture/[^"]*)"', page)
    sent = {desk.get(address).data for address in addresses}
    assert sent == {
        (FOLDER / "s01-sheet-verbatim" / name).read_bytes() for name in ("imu_data.png", "filtered_imu.png")
    }
