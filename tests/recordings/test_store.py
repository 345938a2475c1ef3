"""What makes a recording another one, and what makes a file of one worthless."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.engine.rubric import Limits
from grader.intake import Submission
from grader.sandbox.wire import Frame
from tests.recordings import store
from tests.recordings.answers import Answer, Recording

pytestmark = pytest.mark.quick
LIMITS = Limits(10.0, 120.0)
SUBMISSION = Submission("s", "s", {"filters.py": b"x = 1\n"}, (), "ready", "")
KEY, OTHER = "a" * 64, "b" * 64


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(store, "FOLDER", tmp_path / "recordings")
    return tmp_path / "recordings"


def recording() -> Recording:
    arrays = {"a0": np.arange(6.0).reshape(2, 3), "a1": np.zeros((0, 3)), "a2": np.arange(4, dtype=np.uint8)}
    failed = Answer(1.5, failure=("TimedOut", "no answer", 1.5, 4.5), place="somewhere")
    return Recording(
        "full", {"1": Answer(0.25, Frame({"n": 1}, arrays)), "2": failed, "3": Answer(0.5, Frame({}, arrays))}
    )


# --- keys -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", store.worker_files(), ids=lambda path: f"{path.parent.name}/{path.name}")
def test_a_comment_in_the_worker_means_the_same_and_a_statement_does_not(path: Path) -> None:
    source = path.read_text("utf-8")
    lines = source.replace("\n", "  # a comment\n", 1) if source.startswith('"""') and '"""\n' in source else source
    assert store.meaning(f"# a comment\n\n{lines}\n\n# a comment\n") == store.meaning(source)
    assert store.meaning(f"{source}\nnew = 1\n") != store.meaning(source)


def test_docstrings_mean_nothing_and_other_texts_do() -> None:
    plain = 'class A:\n    x = "1"\n    def f(self):\n        return "2"\n'
    told = '"""1"""\nclass A:\n    """2"""\n    x = "1"\n    """3"""\n    def f(self):\n        """4"""\n        return "2"\n'
    assert store.meaning(told) == store.meaning(plain)
    assert store.meaning(plain.replace('return "2"', 'return "3"')) != store.meaning(plain)


@pytest.mark.parametrize(
    ("submission", "only", "limits"),
    [
        (replace(SUBMISSION, files={"filters.py": b"x = 2\n"}), None, LIMITS),
        (replace(SUBMISSION, files={"other.py": b"x = 1\n"}), None, LIMITS),
        (replace(SUBMISSION, above={"filters.py": 1}), None, LIMITS),
        (SUBMISSION, "filtering", LIMITS),
        (SUBMISSION, None, Limits(1.0, 120.0)),
    ],
)
def test_what_changes_an_answer_changes_the_key(submission: Submission, only: str | None, limits: Limits) -> None:
    assert store.key(submission, only, limits) != store.key(SUBMISSION, None, LIMITS)


@pytest.mark.parametrize("part", ["_machine", "worker_code"])
def test_other_versions_and_other_worker_code_change_the_key(part: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before = store.key(SUBMISSION, None, LIMITS)
    monkeypatch.setattr(store, part, lambda: "another")
    assert store.key(SUBMISSION, None, LIMITS) != before


def test_the_name_of_a_submission_changes_no_answer() -> None:
    named = replace(SUBMISSION, id="t", name="t", notes=("a note",))
    assert store.key(named, None, LIMITS) == store.key(SUBMISSION, None, LIMITS)


# --- files ------------------------------------------------------------------------------------------------------------


def test_what_was_written_is_read_again() -> None:
    store.write(KEY, recording())
    read, known = store.read(KEY), recording()
    assert (read.isolation_level, read.new, list(read.answers)) == ("full", False, ["1", "2", "3"])
    assert read.answers["2"] == known.answers["2"]
    for history in ("1", "3"):
        got, wanted = read.answers[history], known.answers[history]
        assert got.frame is not None
        assert wanted.frame is not None
        assert (got.cpu_s, got.frame.fields, list(got.frame.arrays)) == (
            wanted.cpu_s,
            wanted.frame.fields,
            ["a0", "a1", "a2"],
        )
        for name, array in wanted.frame.arrays.items():
            np.testing.assert_array_equal(got.frame.arrays[name], array, strict=True)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:-1],
        lambda data: data[:20],
        lambda data: data[:-3] + b"abc",
        lambda data: b"0" * len(data),
    ],
)
def test_a_damaged_file_is_as_good_as_none(damage: Callable[[bytes], bytes]) -> None:
    store.write(KEY, recording())
    path = store.path_of(KEY)
    path.write_bytes(damage(path.read_bytes()))
    assert store.read(KEY) == Recording()


def test_a_file_of_another_case_is_as_good_as_none() -> None:
    store.write(OTHER, recording())
    os.replace(store.path_of(OTHER), store.path_of(KEY))
    assert store.read(KEY) == Recording()
    assert store.read(OTHER) == Recording()


def test_a_file_is_replaced_in_one_step_and_nothing_else_is_left(folder: Path) -> None:
    store.write(KEY, Recording("full"))
    store.write(KEY, recording())
    assert [path.name for path in folder.iterdir()] == [store.path_of(KEY).name]
    assert len(store.read(KEY).answers) == 3


def test_what_was_not_read_for_the_longest_time_makes_room(folder: Path) -> None:
    for age, key in ((30, KEY), (20, OTHER), (10, "c" * 64)):
        store.write(key, recording())
        os.utime(store.path_of(key), (1e9 - age, 1e9 - age))
    store.read(KEY)
    size = store.path_of(KEY).stat().st_size
    store.tidy_up(5 * size // 2)
    assert {path.name for path in folder.iterdir()} == {store.path_of(KEY).name, store.path_of("c" * 64).name}
