"""YAML nodes to values: what is read as it is meant, and what is told with its line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import yaml

from grader.base.text import printable
from grader.engine.rubric_nodes import Reader, RubricError, _syntax_problem, refuse

pytestmark = pytest.mark.quick


def _read(value: str, read: Callable[[Reader, Any], Any]) -> tuple[Any, list[str]]:
    """What is made of the value of a key in the third line, and what is told of it."""
    reader = Reader("rubric.yaml")
    node = reader.compose(f"# one\n# two\nkey: {value}\n".encode()).value[0][1]
    made = read(reader, node)
    assert all(line == 3 for line, _ in reader.problems)
    return made, [problem for _, problem in reader.problems]


@pytest.mark.parametrize(
    ("written", "text", "problems"),
    [
        ("Filtering", "Filtering", []),
        ("a" * 201, "", ["it must be one line of at most 200 printable characters; shorten it"]),
        ('"a\\nb"', "", ["it must be one line of at most 200 printable characters; shorten it"]),
        ("3", "", ["it must be text, not '3'; write it in quotes"]),
        ("'  '", "", ["it must be text, not '  '; write it in quotes"]),
        ("[a]", "", ["it must be text, not a list or a mapping; write it in quotes"]),
    ],
)
def test_text_is_one_printable_line(written: str, text: str, problems: list[str]) -> None:
    assert _read(written, lambda reader, node: reader.text(node, "it")) == (text, problems)


@pytest.mark.parametrize(
    ("written", "number"),
    [("0", 0.0), ("-0", 0.0), ("1000", 1000.0), ("+5", 5.0), ("5.", 5.0), (".5", 0.5), ("1e2", 100.0), ("1E-2", 0.01), ("012", 12.0)],
)  # fmt: skip
def test_a_plain_decimal_number_is_read(written: str, number: float) -> None:
    assert _read(written, lambda reader, node: reader.number(node, "it")) == (number, [])


@pytest.mark.parametrize(
    "written", ["-0.01", "1000.01", "'5'", ".inf", ".nan", "1_0", "0x10", "5 points", ".", "five", "~"]
)
def test_no_other_number_is(written: str) -> None:
    told = [f"it must be a number from 0 to 1000, not '{written.strip(chr(39))}'; correct it"]
    assert _read(written, lambda reader, node: reader.number(node, "it")) == (None, told)


@pytest.mark.parametrize(("written", "sound"), [("0.1", True), ("2.5", True), ("0.09", False), ("2.6", False)])
def test_a_number_keeps_within_its_bounds(written: str, sound: bool) -> None:
    number, told = _read(written, lambda reader, node: reader.number(node, "it", low=0.1, high=2.5))
    assert (number is not None, bool(told)) == (sound, not sound)
    assert told in ([], [f"it must be a number from 0.1 to 2.5, not '{written}'; correct it"])


@pytest.mark.parametrize(
    ("written", "points", "problems"),
    [
        ("7.5", 7.5, []),
        ("0.07", 0.07, []),
        ("7.125", 7.125, ["it must have at most two decimals, not '7.125'; round it"]),
        ("50%", 10.0, []),
        ("0 %", 0.0, []),
        ("100%", 20.0, []),
        ("33.333%", 6.67, []),
        *(
            (wrong, None, [f"it must be a number of points or a percentage from 0 % to 100 %, not '{wrong}'"])
            for wrong in ("100.1%", "-1%", "1_0%", "ten%")
        ),
    ],
)
def test_points_may_be_a_share_of_all(written: str, points: float | None, problems: list[str]) -> None:
    assert _read(written, lambda reader, node: reader.share(node, "it", 20.0)) == (points, problems)


def test_a_misspelt_key_is_not_missing_as_well() -> None:
    reader = Reader("rubric.yaml")
    found = reader.fields(
        reader.compose(b"titel: 1\nmore: 2\nnothing-like-it: 3\n"), "it", ("title", "points"), ("more",)
    )
    assert {name: node.value for name, node in found.items()} == {"more": "2"}
    assert reader.problems == [
        (1, "unknown key 'titel' in it (did you mean title?); correct or remove it"),
        (3, "unknown key 'nothing-like-it' in it; correct or remove it"),
        (1, "it has no key `points`; add it"),
    ]


def test_records_come_in_the_order_of_their_ids_each_once() -> None:
    reader = Reader("rubric.yaml")
    root = reader.compose(
        b"- {id: second}\n- {id: first}\n- {id: first}\n- {id: 3}\n- {id: forth}\n- {id: zzz}\n- {}\n"
    )
    found = reader.records(root, "part", ("first", "second", "third", "fourth"), ("id",), ())
    assert [(name, item.start_mark.line, list(keys)) for name, (item, keys) in found.items()] == [
        ("first", 1, ["id"]),
        ("second", 0, ["id"]),
        ("fourth", 4, ["id"]),
    ]
    ids = "the ids are first, second, third, fourth"
    assert reader.problems == [
        (3, "the part first appears twice (first on line 2); remove one"),
        (4, "an id must be text, not '3'; write it in quotes"),
        (5, f"unknown part 'forth' (did you mean fourth?); {ids}"),
        (6, f"unknown part 'zzz'; {ids}"),
        (7, "this part has no key `id`; add it"),
        (1, "the part third is missing; add it"),
    ]


def _refused(data: bytes) -> list[str]:
    try:
        Reader("r").compose(data)
    except RubricError as refusal:
        return str(refusal).splitlines()
    return []


def test_a_file_may_be_as_large_and_as_deep_and_say_as_much_as_the_limits_allow() -> None:
    assert _refused(b"a: 1\n" + b"#" * 999_995) == []
    assert _refused(b"a: 1\n" + b"#" * 999_996) == [
        "r:1: the file is larger than 1 MB; start again from the shipped rubric.yaml"
    ]
    assert _refused(b"\n" + b"[" * 10 + b"]" * 10) == []
    assert _refused(b"\n" + b"[" * 11 + b"]" * 11) == [
        "r:2: this is nested too deeply; see the shipped rubric.yaml for the layout"
    ]
    assert _refused(b"[[]]\n---\n") == ["r:2: YAML cannot be read here: expected a single document in the stream, but found another"
                                        " document; correct the line or the one before"]  # fmt: skip


def test_a_mark_of_the_byte_order_is_no_text() -> None:
    reader = Reader("r")
    assert [key.value for key, _ in reader.compose(b"\xef\xbb\xbfa: 1\n").value] == ["a"]


@pytest.mark.parametrize(("count", "last"), [(50, "r:50: wrong"), (51, "r: and 1 more problems; correct these first")])
def test_fifty_problems_are_told_in_the_order_of_their_lines(count: int, last: str) -> None:
    with pytest.raises(RubricError) as refusal:
        refuse("r", [(n, "wrong") for n in range(count, 0, -1)])
    lines = str(refusal.value).splitlines()
    assert (lines[0], lines[49], lines[-1]) == ("r:1: wrong", "r:50: wrong", last)


def test_what_yaml_says_is_told_as_it_can_be_shown_and_cut_and_without_a_word_or_a_place_it_is_line_one() -> None:
    mark = yaml.Mark("rubric.yaml", 0, 4, 0, None, None)
    line, told = _syntax_problem(yaml.MarkedYAMLError("while it read", None, "odd\x1b" + "s" * 200, mark))
    shown = printable("while it read, odd\x1b" + "s" * 200, 150)
    assert (line, told) == (5, f"YAML cannot be read here: {shown}; correct the line or the one before")
    line, told = _syntax_problem(yaml.MarkedYAMLError())
    assert (line, told) == (1, "YAML cannot be read here: this is not YAML; correct the line or the one before")
