"""Tapes are stored so that recording them anew adds to a repository what is new in them, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grader.sandbox.wire import Frame
from tests.tapes import Played, Tape
from tests.tapes.storing import Shelf, store

pytestmark = pytest.mark.quick


def taped(*series: np.ndarray) -> dict[str, Tape]:
    answers = {f"question {n}": Played(0.25, Frame({"n": n}, {"a0": each})) for n, each in enumerate(series)}
    return {"a case": Tape("full", answers)}


def packs(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.pack")}


def test_what_was_stored_is_read_again(tmp_path: Path) -> None:
    failed = Played(1.5, failure=("TimedOut", "no answer", 1.5, 4.5), place="somewhere")
    tapes = taped(np.arange(6.0).reshape(2, 3), np.zeros((0, 3)), np.arange(4, dtype=np.uint8))
    tapes["a case"].answers["the last"] = failed
    store(tapes, tmp_path / "some.tape")
    read = Shelf(tmp_path / "some.tape")["a case"]
    assert read.answers.pop("the last") == failed
    for key, played in read.answers.items():
        known = tapes["a case"].answers[key]
        assert known.frame is not None
        assert played.frame is not None
        assert (played.frame.fields, played.cpu_s) == (known.frame.fields, known.cpu_s)
        np.testing.assert_array_equal(played.frame.arrays["a0"], known.frame.arrays["a0"], strict=True)


def test_what_is_there_already_is_not_written_again(tmp_path: Path) -> None:
    file = tmp_path / "some.tape"
    store(taped(np.arange(9.0)), file)
    before = packs(tmp_path)
    store(taped(np.arange(9.0), np.arange(9.0)), file)
    assert packs(tmp_path) == before
    store(taped(np.arange(9.0), np.arange(5.0)), file)
    after = packs(tmp_path)
    assert len(after) == 2
    assert before.items() <= after.items()
    assert len(Shelf(file)["a case"].answers) == 2


def test_a_pack_of_which_less_than_half_is_wanted_makes_room(tmp_path: Path) -> None:
    file = tmp_path / "some.tape"
    store(taped(np.arange(9.0), np.arange(90.0)), file)
    before = packs(tmp_path)
    store(taped(np.arange(9.0)), file)
    assert packs(tmp_path).keys().isdisjoint(before)
    read = Shelf(file)["a case"].answers["question 0"].frame
    assert read is not None
    np.testing.assert_array_equal(read.arrays["a0"], np.arange(9.0))


def test_packs_of_other_tapes_are_left_alone(tmp_path: Path) -> None:
    store(taped(np.arange(3.0)), tmp_path / "other.tape")
    store(taped(np.arange(4.0)), tmp_path / "some.tape")
    store(taped(np.arange(5.0)), tmp_path / "some.tape")
    assert sorted(name.split("-")[0] for name in packs(tmp_path)) == ["other", "some"]
