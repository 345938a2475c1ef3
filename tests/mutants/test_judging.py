"""Where mutants of the judging stand, and that they are put there; `python -m tests.mutants --judging` runs them."""

from __future__ import annotations

import os

import pytest

from grader.labs.imu import recordings
from grader.labs.imu.diagnosis import noise
from grader.labs.imu.sensor_access import explain
from tests.mutants import judging
from tests.mutants.operators import Mutant
from tests.mutants.reach import remembering
from tests.recordings.marker import recorded_corpus, verdict

FILE = "grader/labs/imu/recordings.py"
SOURCE = (judging.ROOT / FILE).read_text("utf-8")


def _at(line: str) -> Mutant:
    """A mutant of the line that begins like this."""
    number = next(i for i, text in enumerate(SOURCE.splitlines(), 1) if text.strip().startswith(line))
    return Mutant(FILE, "", "", number, "", SOURCE)


@pytest.mark.parametrize(
    ("line", "function", "names"),
    [
        ("_LEAN =", None, ["_LEAN"]),
        ("return bool(np.abs(leaning", "one_row_follows", []),
        ("def one_row_follows", None, []),
    ],
)
def test_a_mutant_knows_whether_it_stands_in_the_body_of_a_function(
    line: str, function: str | None, names: list[str]
) -> None:
    assert judging.function_of(_at(line)) == function
    assert judging.names_of(_at(line)) == names


def test_a_statement_with_a_body_ends_where_that_begins() -> None:
    lines = judging.statement(_at("def one_row_follows"))
    assert SOURCE.splitlines()[lines.stop - 1].strip().startswith(('"""', "return", "leaning"))


def test_a_function_becomes_the_mutant_where_it_stands_for_whoever_has_it() -> None:
    line = "return bool(np.abs(leaning"
    mutant = Mutant(FILE, "", "", _at(line).line, "", SOURCE.replace(line, "return None and bool(np.abs(leaning"))
    function = recordings.one_row_follows
    child = os.fork()
    if not child:
        before = function.__code__
        there = judging.put_in_place(mutant)
        os._exit(0 if there and function.__code__ != before and recordings.one_row_follows is function else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_what_runs_when_a_module_is_loaded_is_not_put_in_place() -> None:
    assert not judging.put_in_place(_at("_LEAN ="))


def test_a_mutant_that_makes_another_number_of_functions_when_loaded_is_not_put_in_place() -> None:
    file = noise.__name__.replace(".", "/") + ".py"
    source = (judging.ROOT / file).read_text("utf-8")
    made = "return lambda seen: all(predicts("
    mutant = Mutant(
        file, "", "", source[: source.index(made)].count("\n") + 1, "", source.replace(made, "return all((")
    )
    child = os.fork()
    if not child:
        os._exit(judging.put_in_place(mutant))
    assert os.waitpid(child, 0)[1] == 0


def test_what_a_function_remembers_is_found_to_be_forgotten() -> None:
    assert explain._hypotheses in remembering(["grader/labs/imu/sensor_access/explain.py"])
    assert not remembering(["grader/labs/imu/diagnosis/noise.py"])


def test_what_is_imported_anew_judges_a_case_as_before() -> None:
    cases = [case for case in recorded_corpus() if case.id == "faulty/weights-exchanged"]
    verdict(cases[0])  # recorded
    child = os.fork()
    if not child:
        judging._change(_at("_LEAN ="))
        os._exit(len(cases) != 1 or judging._fails_on_a_case(cases))
    assert os.waitpid(child, 0)[1] == 0
