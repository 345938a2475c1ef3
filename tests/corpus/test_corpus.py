"""The corpus is complete and says what it means."""

from __future__ import annotations

import pickle
from collections import Counter
from pathlib import Path

import pytest
import yaml

from grader.labs.imu.lab import LAB
from tests.corpus.cases import CRITERIA, ORIGINS, every, of, patched
from tests.corpus.pieces import edit

MISTAKES = Path(__file__).resolve().parents[2] / "grader" / "labs" / "imu" / "faults.yaml"
ONE_FAULT = (*of("faulty"), *of("lookalikes"))


def known_ids() -> dict[str, set[str]]:
    table = yaml.safe_load(MISTAKES.read_text(encoding="utf-8"))
    return {group: {id_ for id_, row in rows.items() if "explanation" in row} for group, rows in table.items()}


def test_every_fault_has_a_submission_with_it() -> None:
    made = {id_ for case in (*of("faulty"), *of("unforeseen"), *of("extensions")) for id_ in (case.fault, *case.also)}
    made |= {id_ for case in of("unforeseen") if case.criterion == "visualization" for id_ in case.names}
    assert set().union(*known_ids().values()) - made == set()
    assert {case.only for case in of("extensions") if case.loses} == {bonus.id for bonus in LAB.bonuses}


def test_a_row_speaks_of_known_faults_criteria_and_origins_and_names_no_fault_that_it_excludes() -> None:
    known = set().union(*known_ids().values())
    used = {id_ for case in every() for id_ in (case.fault, *case.also, *case.never, *case.names, *(case.faults or ()))}
    assert used - known - {""} == set()
    named = {case.criterion for case in ONE_FAULT} | {c for pair in of("pairs") for c in (pair.faults or {}).values()}
    assert named - {""} == set(CRITERIA)
    assert {case.origin for case in every()} == {"", *ORIGINS}
    assert [case.name for case in ONE_FAULT if {case.fault, *case.also} & set(case.never)] == []


def test_no_two_samples_have_the_same_name_or_the_same_files() -> None:
    names = Counter(case.name for part in ("sound", "faulty", "lookalikes", "pairs", "broken") for case in of(part))
    names += Counter(case.id for part in ("module level", "nothing", "extensions", "repairable") for case in of(part))
    assert [name for name, count in names.items() if count > 1] == []
    plain = [case for case in of("sound") if case.as_ == "folder"]
    for group in ((*ONE_FAULT, *of("pairs")), plain):
        contents = Counter(repr(sorted(case.files.items())) for case in group)
        assert max(contents.values()) == 1


def test_a_case_can_be_handed_to_another_process() -> None:
    assert pickle.dumps([*every()])


def test_what_an_edit_or_a_patch_replaces_is_there_exactly_once() -> None:
    text = "one\n\ntwo\nthree\n"
    assert patched(text, "-two\n+2\n") == "one\n\n2\nthree\n"
    assert patched(text, "@@\n one\n\n+and\n@@\n three\n+four\n") == "one\n\nand\ntwo\nthree\nfour\n"
    for patch, why in {
        "-b\n": "there 2 times",
        "-d\n": "there 0 times",
        "b\n": "a line of a patch begins with",
    }.items():
        with pytest.raises(ValueError, match=why):
            patched("a\nb\nc\nb\n", patch)
    with pytest.raises(ValueError, match="holds 2 of 'a'"):
        edit({"f": "aa"}, "f", ("a", "b"))
