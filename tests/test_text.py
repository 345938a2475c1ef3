"""Tests that text from submissions is safe to show."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.base.text import csv_cell, decimal, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, ümläut, 漢字, naïve m/s²", "plain, ümläut, 漢字, naïve m/s²"),
        ("\x1b[31mred\x1b[0m", "\\x1b[31mred\\x1b[0m"),
        ("a\nb\tc\rd", "a\\x0ab\\x09c\\x0dd"),
        ("\x9b2J", "\\x9b2J"),
        ("evil\u202egnp.py", "evil\\u202egnp.py"),
        ("zero\u200bwidth\ufeff", "zero\\u200bwidth\\ufeff"),
        ("\udcff", "\\udcff"),
        ("\U000e0041tag", "\\U000e0041tag"),
        ("\ufffe\uffff", "\\ufffe\\uffff"),
        ("\u2028\u2029", "\\u2028\\u2029"),
        ("👩\u200d🔬", "👩\u200d🔬"),
    ],
)
def test_what_a_terminal_would_obey_or_hide_is_written_out(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_line_ends_and_tabs_stay_only_if_asked_for() -> None:
    assert printable("a\r\nb\rc\n\td\x07", newlines=True) == "a\nb\nc\n\td\\x07"


def test_a_long_text_ends_in_an_ellipsis_at_the_limit() -> None:
    assert printable("x" * 11, 10) == "x" * 9 + "…"
    assert printable("x" * 10, 10) == "x" * 10
    assert printable("abc", 1) == "…"
    assert printable("abc", 0) == ""


@given(st.text(alphabet=st.characters(exclude_categories=[])), st.integers(0, 50), st.booleans())
def test_no_text_brings_a_control_through_or_exceeds_the_limit(text: str, limit: int, newlines: bool) -> None:
    shown = printable(text, limit, newlines=newlines)
    assert len(shown) <= limit
    shown.encode()
    assert not any(unicodedata.category(c) in {"Cc", "Cs"} for c in shown.replace("\n", "").replace("\t", ""))
    assert newlines or not set("\n\t") & set(shown)


def test_no_cell_is_a_formula_and_other_cells_stay_as_they_are() -> None:
    for text in ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", "＝1"):
        assert csv_cell(text) == "'" + text
    for text in ("", "alice", "1-2", " =1", "'=1", "O'Neill"):
        assert csv_cell(text) == text


NOT_NUMBERS = (
    "1_0",
    "٣",
    "１",
    "nan",
    "inf",
    "0x10",
    "1e400",
    "9" * 400,
    "1" * 100_000 + "x",
    "1,000.5",
    "",
    "--1",
    "1 0",
)


@pytest.mark.parametrize("text", NOT_NUMBERS)
def test_a_number_in_a_form_has_digits_a_point_or_a_comma_and_a_sign(text: str) -> None:
    assert decimal(text) is None
    assert [decimal(f" {given} ") for given in ("2.5", "2,5", "+2.50", ".5", "5.", "-1e-1")] == [
        2.5,
        2.5,
        2.5,
        0.5,
        5.0,
        -0.1,
    ]
