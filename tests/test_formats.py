from __future__ import annotations

import csv
import io
from dataclasses import replace

from grader.engine.results import Result
from grader.people.final_grade import FinalGrade
from grader.platforms.gradebook import gradebook
from tests.fake_results import check, lost, result


def book(results: dict[str, Result]) -> str:
    return gradebook({id_: FinalGrade(id_, each) for id_, each in results.items()})


def rows(results: dict[str, Result]) -> list[list[str]]:
    return list(csv.reader(io.StringIO(book(results))))


def test_the_gradebook_has_a_row_a_submission_and_a_column_a_criterion() -> None:
    assert book({"alice": result(), "bob": result(check(points=3.33), name="Bob")}) == (
        "id,name,sensor_access,total,status\nalice,alice,20,20,graded\nbob,Bob,3.33,3.33,graded\n"
    )


def test_what_was_not_judged_is_blank_and_never_a_zero() -> None:
    assert rows({"a": result(lost(), check("not_judged", None), status="incomplete")})[1] == [
        "a",
        "alice",
        "",
        "",
        "incomplete",
    ]


def test_a_name_cannot_become_a_formula_or_another_row() -> None:
    table = rows({"x": result(name='=HYPERLINK("http://x")'), "y": result(name="a\nb,c")})
    assert table[1][1] == '\'=HYPERLINK("http://x")'
    assert table[2][1] == "a\nb,c"
    assert [len(row) for row in table] == [5, 5, 5]


def test_extra_credit_has_a_column_where_the_rubric_gives_it_and_goes_into_the_total() -> None:
    plain, granted = result(), replace(result(name="Bob"), extra_credit_cap=10.0)
    extension = replace(granted.extensions[0], max_points=5.0, checks=(check(points=4.5, max_points=5.0),))
    assert book({"alice": plain, "bob": replace(granted, extensions=(extension,))}) == (
        "id,name,sensor_access,extra_credit,total,status\nalice,alice,20,0,20,graded\nbob,Bob,20,4.5,24.5,graded\n"
    )
