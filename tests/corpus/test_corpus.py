"""The corpus is complete and says what it means."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
import yaml

from tests.corpus import unforeseen_plots, unforeseen_reader_collect
from tests.corpus.broken import ALL, BROKEN, Broken
from tests.corpus.faulty import FAULTY, LOOKALIKES, PAIRS, Faulty, Pair
from tests.corpus.pieces import edit
from tests.corpus.sound import SOUND, WRAPPED

MISTAKES = Path(__file__).resolve().parents[2] / "grader" / "labs" / "imu" / "faults.yaml"
EXTENSIONS = "extensions"


def known_ids() -> dict[str, set[str]]:
    table = yaml.safe_load(MISTAKES.read_text(encoding="utf-8"))
    return {group: {id_ for id_, row in rows.items() if "explanation" in row} for group, rows in table.items()}


def test_every_mistake_of_the_five_criteria_has_a_submission_that_makes_it() -> None:
    made = {m for fault in FAULTY for m in (fault.mistake, *fault.also)}
    made |= {m for sample in unforeseen_reader_collect.FAULTY for m in (sample.mistake, *sample.also)}
    made |= {m for sample in unforeseen_plots.FAULTY for m in sample.names}
    wanted = {mistake for group, ids in known_ids().items() if group != EXTENSIONS for mistake in ids}
    assert wanted - made == set()


def test_every_id_in_the_corpus_is_a_known_mistake() -> None:
    known = set().union(*known_ids().values())
    used = {m for fault in (*FAULTY, *LOOKALIKES) for m in (fault.mistake, *fault.also, *fault.never)}
    used |= {mistake for pair in PAIRS for mistake, _ in pair.faults} | {m for broken in BROKEN for m in broken.names}
    assert used - known - {""} == set()


def test_a_fault_is_never_named_by_an_id_that_it_also_excludes() -> None:
    assert [f.name for f in (*FAULTY, *LOOKALIKES) if {f.mistake, *f.also} & set(f.never)] == []


def test_names_are_unique() -> None:
    cases: list[Faulty | Pair | Broken] = [*FAULTY, *LOOKALIKES, *PAIRS, *BROKEN]
    names = Counter([*SOUND, *(case.name for case in cases)])
    assert [name for name, count in names.items() if count > 1] == []


def test_no_two_samples_are_the_same() -> None:
    cases: list[Faulty | Pair] = [*FAULTY, *LOOKALIKES, *PAIRS]
    contents = Counter(tuple(sorted((k, str(v)) for k, v in case.files.items())) for case in cases)
    assert max(contents.values()) == 1
    wrapped_again = {name for name in SOUND if name in WRAPPED}
    plain = [
        tuple(sorted((k, str(v)) for k, v in files.items()))
        for name, files in SOUND.items()
        if name not in wrapped_again
    ]
    assert len(set(plain)) == len(plain)


def test_criteria_are_the_five_of_the_sheet() -> None:
    named = {f.criterion for f in (*FAULTY, *LOOKALIKES)} | {c for pair in PAIRS for _, c in pair.faults}
    assert named - {""} == set(ALL)


def test_an_edit_that_does_not_apply_once_is_refused() -> None:
    with pytest.raises(ValueError, match="holds 2 of 'a'"):
        edit({"f": "aa"}, "f", ("a", "b"))
    with pytest.raises(ValueError, match="overlaps"):
        edit({"f": "abc"}, "f", ("ab", "x"), ("bc", "y"))
