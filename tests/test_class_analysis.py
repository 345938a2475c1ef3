from __future__ import annotations

import io
import json
import keyword
import re
import tokenize
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.fingerprint import fingerprint, of_the_sheet
from grader.engine.results import CriterionResult, Result
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.report.items import Item, items
from grader.report.pages import index_page
from grader.report.similarity import FEWEST, pairs
from tests.examples import FOLDER
from tests.made_up import check
from tests.made_up import result as made_up


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


def test_the_sheets_own_code_leaves_nothing_to_compare() -> None:
    assert of_the_sheet(LAB)
    assert set(fingerprint(files("s01-sheet-verbatim"))) <= of_the_sheet(LAB)


def test_names_strings_comments_and_layout_do_not_count() -> None:
    source = files("s04-object-oriented")["imu_reader.py"].decode()
    before = fingerprint({"a.py": source.encode()})
    assert len(before) > 20
    assert fingerprint({"b.py": renamed(source).encode()}) == before


def test_a_notebook_counts_by_its_code_cells() -> None:
    source = files("s04-object-oriented")["imu_reader.py"].decode()
    cells = [
        {"cell_type": "markdown", "source": ["# words"]},
        {"cell_type": "code", "source": source.splitlines(keepends=True)},
    ]
    assert fingerprint({"a.ipynb": json.dumps({"cells": cells}).encode()}) == fingerprint({"a.py": source.encode()})


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"[" * 100_000, b'{"cells": 3}', b"'''", b"x" * 500_000])
def test_whatever_is_handed_in_has_a_fingerprint(content: bytes) -> None:
    assert fingerprint({"a.ipynb": content, "b.py": content, "c.txt": content}) in ((), fingerprint({"b.py": content}))


def test_a_copied_stretch_leaves_common_hashes_wherever_it_stands() -> None:
    source = files("s04-object-oriented")["imu_reader.py"].decode()
    stretch = "\n".join(source.splitlines()[20:60])
    other = files("s02-vectorised")["filters.py"].decode()
    common = set(fingerprint({"a.py": (other + "\n" + stretch).encode()})) & set(fingerprint({"b.py": source.encode()}))
    assert len(common) >= 10


# --- who is alike ---------------------------------------------------------------------------------------------------


def test_a_disguised_copy_is_found_and_people_who_handed_in_the_sheet_are_not() -> None:
    original = files("s04-object-oriented")
    copy = {path: renamed(content.decode()).encode() for path, content in original.items() if path.endswith(".py")}
    sheet = fingerprint(files("s01-sheet-verbatim"))
    prints = {f"sheet{i}": sheet for i in range(5)} | {"one": fingerprint(original), "other": fingerprint(copy)}
    (found,) = pairs(prints, of_the_sheet(LAB))
    assert (found.first, found.second) == ("one", "other")
    assert found.share > 0.95
    assert found.lines == pytest.approx(found.common * 6.5 / 9, abs=0.5)


def test_what_half_of_the_class_has_is_a_handout() -> None:
    handout = tuple(range(100))
    prints = {str(i): handout for i in range(20)}
    assert pairs(prints) == []
    prints |= {"a": (*handout, *range(1000, 1060)), "b": (*handout, *range(1000, 1060))}
    assert [(p.first, p.second, p.common, p.share) for p in pairs(prints)] == [("a", "b", 60, 1.0)]


def test_a_few_common_lines_or_a_small_share_are_no_pair() -> None:
    few = {"a": tuple(range(FEWEST - 1)), "b": tuple(range(FEWEST - 1))}
    small = {"a": tuple(range(100)), "b": (*range(49), *range(200, 300))}
    assert pairs(few) == pairs(small) == pairs({}) == []


def test_the_class_page_names_the_pair() -> None:
    final_grades = {id_: FinalGrade(id_, made_up(name=id_)) for id_ in ("ann", "bob", "eve")}
    page = index_page(final_grades, {"ann": tuple(range(60)), "bob": tuple(range(60)), "eve": (1,), "gone": (2,)})
    assert re.search(r"ann</a></th><td><a href=[^>]*>bob</a></td><td[^>]*>100 %</td><td[^>]*>43</td>", page)
    assert "Alike beyond" not in index_page(final_grades)


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


def test_nine_submissions_or_equal_ones_tell_nothing_apart() -> None:
    assert [item.discrimination for item in items([marked(i, i, i) for i in range(9)])] == [None] * 3
    assert [item.discrimination for item in items([marked(5, 5, 5)] * 20)] == [None] * 3


def test_a_check_that_good_submissions_lose_is_doubtful() -> None:
    good, weak = [marked(0, 10, 10)] * 20, [marked(10, 0, 0)] * 20
    found = {item.id: item for item in items([*good, *weak])}
    assert found["filtering.a"].discrimination == pytest.approx(-1)
    assert found["filtering.a"].doubtful
    assert not replace(found["filtering.a"], judged=29).doubtful
    assert not Item("x", "x", 40, 1, 0.9, None).doubtful


def test_open_points_and_empty_hand_ins_are_left_out() -> None:
    opened = replace(made_up(check("not_judged", None), check(id="sensor_access.b")), status="incomplete")
    found = items([opened, made_up(status="empty"), made_up()])
    assert {item.id: item.judged for item in found} == {
        "sensor_access.follows_address": 1,
        "sensor_access.b": 1,
        "sensor_access.matches_truth": 1,
    }


def test_a_discrimination_needs_five_who_lost_points_and_has_its_bounds() -> None:
    """Fisher's z by hand: r = 0.5 with 28 submissions gives z = 0.5493, and 1.96 / 5 = 0.392 to each side."""
    item = Item("a", "A", 28, 5, 0.5, 0.5)
    assert item.bounds == (
        pytest.approx(0.1560, abs=1e-4),
        pytest.approx(0.7358, abs=1e-4),
    )  # both rounded to four digits
    assert Item("a", "A", 28, 4, 0.5, None).bounds is None
