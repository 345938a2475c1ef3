"""Where mutants of the judging stand, and that they are put there; `python -m tests.mutants --judging` runs them."""

from __future__ import annotations

from grader.labs.imu.data_collection import measure
from tests.mutants import judging
from tests.mutants.operators import Mutant
from tests.mutants.reach import in_a_fork
from tests.recordings.marker import recorded_corpus, verdict

FILE = "grader/labs/imu/data_collection/measure.py"
SOURCE = (judging.ROOT / FILE).read_text("utf-8")


def _at(line: str) -> Mutant:
    """A mutant of the line that begins like this."""
    number = next(i for i, text in enumerate(SOURCE.splitlines(), 1) if text.strip().startswith(line))
    return Mutant(FILE, "", "", number, "", SOURCE)


def test_a_function_becomes_the_mutant_where_it_stands_for_whoever_has_it() -> None:
    line = "return series.acceleration is not None"
    mutant = Mutant(FILE, "", "", _at(line).line, "", SOURCE.replace(line, "return series.acceleration is None"))
    function = measure.complete

    def replaced() -> bool:
        before = function.__code__
        return judging.put_in_place(mutant) and function.__code__ != before and measure.complete is function

    assert in_a_fork(replaced)


def test_what_is_imported_anew_judges_a_case_as_before() -> None:
    (case,) = (case for case in recorded_corpus() if case.id == "faulty/weights-exchanged")
    verdict(case)  # recorded

    def fails() -> bool:
        judging._change(_at("_LEAN ="))
        return judging._fails_on_a_case([case])

    assert not in_a_fork(fails)
