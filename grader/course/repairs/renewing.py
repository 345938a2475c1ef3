"""Repairs after a regrade: repaired copies count again, and suggested repairs are applied where the rubric says so."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.record.repair_log import LoggedRepair, of_these_files, repaired_sha256, sha256_of
from grader.course.record.store import Store
from grader.course.repairs.making import Grading, RepairRequest, files_handed_in, repaired, validated_repair
from grader.course.repairs.suggestions import suggest
from grader.engine.results import AUTOMATIC, Result
from grader.people.final_grade import FinalGrade
from grader.report.causes import stops

BY_ITSELF = "Applied automatically: with this edit of one place the code runs."


def renew(store: Store, ids: Iterable[str], grading: Grading) -> Iterator[tuple[str, Result | str]]:
    """Make repairs in force count again after a regrade of the original files; `grading` grades copies without a stored result.

    Yields
    ------
    The id of a submission with the result of its repaired copy, or with a line on why a repair does not count, such as that the
    student has changed the file. A submission with several repairs may give both.
    """
    by_id: dict[str, list[LoggedRepair]] = {}
    for each in store.repairs_in_force():
        by_id.setdefault(each.id, []).append(each)
    if not by_id:
        return
    final_grades = store.final_grades()
    for id_ in sorted(by_id.keys() & set(ids) & final_grades.keys()):
        for found in _renew_one(store, final_grades[id_], by_id[id_], grading):
            yield id_, found


def apply_suggested(store: Store, ids: Iterable[str], grading: Grading) -> Iterator[tuple[str, Result]]:
    """Find, apply and store repairs of submissions that do not run, for ``repairs: {apply: suggested}`` in the rubric.

    A file that already has a repair, in force or taken back, is left alone. `grading` grades the edited copies.

    Yields
    ------
    The id of each submission that was repaired, and its result; nothing for those without a suggested repair.
    """
    decided: dict[str, set[tuple[str, str]]] = {}
    for each in store.repairs():
        decided.setdefault(each.id, set()).add(each.is_for)
    final_grades = store.final_grades()
    for id_ in sorted(set(ids) & final_grades.keys()):
        final_grade = final_grades[id_]
        if final_grade.result.repairs or not stops(final_grade.result, grading.rubric.lab):
            continue
        with suppress(RequestError):  # the submission stays as it is if the repair cannot be recorded
            made = _search_and_apply(store, final_grade, decided.get(id_, set()), grading)
            if made is not None:
                yield id_, made


def _search_and_apply(
    store: Store, final_grade: FinalGrade, already_repaired: set[tuple[str, str]], grading: Grading
) -> Result | None:
    """Search once for a repair of a submission, apply it, and store it with its result.

    `already_repaired` holds (file, digest) of each file with a repair, in force or taken back. None if a repair was searched for
    before, none is found, or its file is among these.
    """
    handed_in = files_handed_in(store, final_grade)
    if not store.is_first_search(grading.key(final_grade.id, handed_in.sha256)):
        return None
    found = suggest(handed_in, final_grade.result, grading.rubric.lab, grading.mark)
    if found is None or (found.file, sha256_of(handed_in.files[found.file])) in already_repaired:
        return None
    request = RepairRequest(final_grade.id, found.file, found.content, None, grading.rubric.repairs.deduct, BY_ITSELF)
    made = validated_repair(request, final_grade, handed_in.files, handed_in, AUTOMATIC)
    result = repaired(handed_in, final_grade, [made], grading, store)
    store.keep_repair(made)
    store.keep(grading.key(final_grade.id, repaired_sha256(handed_in, [made])), result)
    return result


def _renew_one(
    store: Store, final_grade: FinalGrade, repairs: Sequence[LoggedRepair], grading: Grading
) -> Iterator[Result | str]:
    """Yield a line for each repair whose file the student changed, then the result with all others, or why they do not count."""
    name = printable(final_grade.id, 80)
    try:
        handed_in = files_handed_in(store, final_grade)
        current = of_these_files(repairs, handed_in)
        for each in [each for each in repairs if each not in current]:
            yield (
                f"{name}: the repair of {printable(each.file, 80)} by {printable(each.author, 80)} does not count: the student "
                f"handed in another version of the file. Repair it again, or run `imugrade repair OUT {name} --undo`"
            )
        if not current:
            return
        key = grading.key(final_grade.id, repaired_sha256(handed_in, current))
        result = store.recall(key) or store.remark(key, grading.rubric)
        if result is None:
            result = repaired(handed_in, final_grade, current, grading, store)
            store.keep(key, result)
    except RequestError as problem:
        yield f"{name}: its repairs do not count: {problem}"
    else:
        yield result
