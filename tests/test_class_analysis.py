from __future__ import annotations

import io
import keyword
import tokenize
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.fingerprint import fingerprint, of_the_sheet
from grader.engine.results import CriterionResult, Result
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.report.items import ItemAnalysis, items
from grader.report.similarity import pairs
from tests.examples import FOLDER
from tests.fake_results import check


def files(name: str) -> dict[str, bytes]:
    return dict(read_submission(FOLDER / name, LAB.files).files)


def renamed(source: str) -> str:
    """Another name for every variable and function, comments and docstrings dropped, indentation by tabs."""
    out = []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        text = token.string
        if token.type == tokenize.NAME and not keyword.iskeyword(text) and out[-1:] != ["."]:
            text = "v_" + text[::-1]
        if token.type == tokenize.STRING:
            text = '"other"'
        if token.type == tokenize.INDENT:
            text = "\t"
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            out.append(text)
    return " ".join(out).replace(" . ", ".")


# --- fingerprints ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"[" * 100_000, b'{"cells": 3}', b"'''", b"x" * 500_000])
def test_whatever_is_handed_in_has_a_fingerprint(content: bytes) -> None:
    assert fingerprint({"a.ipynb": content, "b.py": content, "c.txt": content}) in ((), fingerprint({"b.py": content}))


# --- who is alike ---------------------------------------------------------------------------------------------------


def test_a_disguised_copy_is_found_and_people_who_handed_in_the_sheet_are_not() -> None:
    original = files("s04-object-oriented")
    copy = {path: renamed(content.decode()).encode() for path, content in original.items() if path.endswith(".py")}
    sheet = fingerprint(files("s01-sheet-verbatim"))
    assert of_the_sheet(LAB) >= set(sheet) > set()
    prints = {f"sheet{i}": sheet for i in range(5)} | {"one": fingerprint(original), "other": fingerprint(copy)}
    (found,) = pairs(prints, of_the_sheet(LAB))
    assert (found.first, found.second) == ("one", "other")
    assert found.share == 1.0
    assert found.lines == pytest.approx(found.common * 6.5 / 9, abs=0.5)


def test_what_half_of_the_class_has_is_a_handout() -> None:
    handout = tuple(range(100))
    prints = {str(i): handout for i in range(20)}
    assert pairs(prints) == []
    prints |= {"a": (*handout, *range(1000, 1060)), "b": (*handout, *range(1000, 1060))}
    assert [(p.first, p.second, p.common, p.share) for p in pairs(prints)] == [("a", "b", 60, 1.0)]


# --- item analysis --------------------------------------------------------------------------------------------------


def marked(first: float, second: float, third: float) -> Result:
    checks = tuple(
        check("failed", points, id=f"filtering.{name}", max_points=10.0)
        for name, points in (("a", first), ("b", second), ("c", third))
    )
    return Result("x", "graded", (CriterionResult("filtering", "Filtering", 30.0, checks),))


def test_difficulty_and_discrimination_are_those_worked_out_by_hand() -> None:
    scores = [(10, 8, 6), (10, 6, 4), (5, 5, 5), (0, 2, 4), (0, 0, 2)] * 2
    found = items(marked(*row) for row in scores)
    table = np.array(scores, float)
    for column, item in enumerate(found):
        rest = table.sum(axis=1) - table[:, column]
        assert item.difficulty == pytest.approx(table[:, column].mean() / 10)
        assert item.discrimination == pytest.approx(np.corrcoef(table[:, column], rest)[0, 1])
        assert item.losers == int((table[:, column] < 10).sum())
    assert [item.id for item in found] == ["filtering.a", "filtering.b", "filtering.c"]


def test_a_check_that_good_submissions_lose_is_doubtful() -> None:
    good, weak = [marked(0, 10, 10)] * 20, [marked(10, 0, 0)] * 20
    found = {item.id: item for item in items([*good, *weak])}
    assert found["filtering.a"].discrimination == pytest.approx(-1)
    assert found["filtering.a"].doubtful
    assert not replace(found["filtering.a"], judged=29).doubtful
    assert not ItemAnalysis("x", "x", 40, 1, 0.9, None).doubtful
