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
    return Recording("full", {"1": Answer(0.25, Frame({"n": 1}, arrays)), "2": failed})


# --- keys -------------------------------------------------------------------------------------------------------------


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


# --- files ------------------------------------------------------------------------------------------------------------


def test_what_was_written_is_read_again() -> None:
    store.write(KEY, recording())
    read, known = store.read(KEY), recording()
    assert (read.isolation_level, read.new, list(read.answers)) == ("full", False, ["1", "2"])
    assert read.answers["2"] == known.answers["2"]
    got, wanted = read.answers["1"].frame, known.answers["1"].frame
    assert got is not None
    assert wanted is not None
    assert (read.answers["1"].cpu_s, got.fields, list(got.arrays)) == (0.25, {"n": 1}, ["a0", "a1", "a2"])
    for name, array in wanted.arrays.items():
        np.testing.assert_array_equal(got.arrays[name], array, strict=True)


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda data: data[:-3] + b"abc"])
def test_a_file_that_is_damaged_or_of_something_else_is_as_good_as_none(damage: Callable[[bytes], bytes]) -> None:
    store.write(KEY, recording())
    content = store.path_of(KEY).read_bytes()
    store.path_of(OTHER).write_bytes(content)
    store.path_of(KEY).write_bytes(damage(content))
    assert store.read(KEY) == store.read(OTHER) == Recording()


def test_what_was_not_read_for_the_longest_time_makes_room(folder: Path) -> None:
    for age, key in ((30, KEY), (20, OTHER), (10, "c" * 64)):
        store.write(key, recording())
        os.utime(store.path_of(key), (1e9 - age, 1e9 - age))
    store.read(KEY)
    size = store.path_of(KEY).stat().st_size
    store.tidy_up(5 * size // 2)
    assert {path.name for path in folder.iterdir()} == {store.path_of(KEY).name, store.path_of("c" * 64).name}
