"""The corpus is complete and says what it means."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
import yaml

from tests.corpus.cases import CRITERIA, ORIGINS, Case, every, of
from tests.corpus.patches import patched
from tests.corpus.pieces import edit

MISTAKES = Path(__file__).resolve().parents[2] / "grader" / "labs" / "imu" / "faults.yaml"
EXTENSIONS = "extensions"
ONE_FAULT = (*of("faulty"), *of("lookalikes"))


def known_ids() -> dict[str, set[str]]:
    table = yaml.safe_load(MISTAKES.read_text(encoding="utf-8"))
    return {group: {id_ for id_, row in rows.items() if "explanation" in row} for group, rows in table.items()}


def test_every_mistake_of_the_five_criteria_has_a_submission_that_makes_it() -> None:
    made = {id_ for case in (*of("faulty"), *of("unforeseen")) for id_ in (case.fault, *case.also)}
    made |= {id_ for case in of("unforeseen") if case.criterion == "visualization" for id_ in case.names}
    wanted = {mistake for group, ids in known_ids().items() if group != EXTENSIONS for mistake in ids}
    assert wanted - made == set()


def test_every_id_in_the_corpus_is_a_known_mistake() -> None:
    known = set().union(*known_ids().values())
    used = {id_ for case in every() for id_ in (case.fault, *case.also, *case.never, *case.names, *(case.faults or ()))}
    assert used - known - {""} == set()


def test_a_fault_is_never_named_by_an_id_that_it_also_excludes() -> None:
    assert [case.name for case in ONE_FAULT if {case.fault, *case.also} & set(case.never)] == []


def test_names_are_unique() -> None:
    names = Counter(case.name for part in ("sound", "faulty", "lookalikes", "pairs", "broken") for case in of(part))
    names += Counter(case.id for part in ("module level", "nothing", "extensions", "repairable") for case in of(part))
    assert [name for name, count in names.items() if count > 1] == []


def content(case: Case) -> tuple[str, ...]:
    return tuple(sorted(f"{name}\0{text!r}" for name, text in case.files.items()))


def test_no_two_samples_are_the_same() -> None:
    assert max(Counter(content(case) for case in (*ONE_FAULT, *of("pairs"))).values()) == 1
    plain = [content(case) for case in of("sound") if case.as_ == "folder"]
    assert len(set(plain)) == len(plain)


def test_criteria_are_the_five_of_the_sheet() -> None:
    named = {case.criterion for case in ONE_FAULT} | {c for pair in of("pairs") for c in (pair.faults or {}).values()}
    assert named - {""} == set(CRITERIA)


def test_a_case_comes_from_a_place_that_is_described() -> None:
    assert {case.origin for case in every()} == {"", *ORIGINS}


def test_an_edit_that_does_not_apply_once_is_refused() -> None:
    with pytest.raises(ValueError, match="holds 2 of 'a'"):
        edit({"f": "aa"}, "f", ("a", "b"))
    with pytest.raises(ValueError, match="overlaps"):
        edit({"f": "abc"}, "f", ("ab", "x"), ("bc", "y"))


def test_a_patch_takes_the_place_of_lines_that_are_there_once() -> None:
    text = "one\n\ntwo\nthree\n"
    assert patched(text, "-two\n+2\n") == "one\n\n2\nthree\n"
    assert patched(text, "@@\n one\n\n+and\n@@\n three\n+four\n") == "one\n\nand\ntwo\nthree\nfour\n"
    assert patched("a", "-a\n+b\n") == "b"


@pytest.mark.parametrize(
    ("patch", "why"),
    [
        ("-b\n", "there 2 times"),
        ("-d\n", "there 0 times"),
        ("-a\n b\n@@\n-b\n-c\n", "overlaps"),
        ("b\n", "a line of a patch begins with"),
    ],
)
def test_a_patch_that_does_not_apply_once_is_refused(patch: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        patched("a\nb\nc\nb\n", patch)
