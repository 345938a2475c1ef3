"""Repairs: patches on submitted files. The repaired copy is graded like any submission, minus a deduction.

The log keeps every repair, and the class database the result of the submission as it was handed in. The result that counts is that
of the repaired copy. A regrade grades that copy again while the student's file is the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from grader import __version__
from grader.base import stamps
from grader.base.errors import RequestError
from grader.base.text import printable
from grader.course.markers.pool import OpenMarker
from grader.course.publishing.out_files import publish_all, write_class
from grader.course.record.database import read
from grader.course.record.decisions import OvertakenError
from grader.course.record.patches import LARGEST, apply_patch, diff_of
from grader.course.record.repair_log import (
    MAX_COMMENT,
    LoggedRepair,
    apply_repairs,
    of_these_files,
    repaired_sha256,
    sha256_of,
)
from grader.course.record.store import Key, Store
from grader.course.record.submission_archive import unpack
from grader.course.repairs.suggestions import MarkCopy, Suggestion, suggest
from grader.engine.results import Repair, Result, Unrepaired
from grader.engine.rubric import Rubric
from grader.engine.rubric_nodes import guess_at
from grader.engine.traces import Traces
from grader.intake import Submission
from grader.intake.names import is_code
from grader.people.final_grade import FinalGrade
from grader.people.identity import PersonLookup
from grader.report import words

WHY_LAPSED = (
    "the student handed in other files since, or the repaired copy earns less; repair the present files, or undo it"
)
MOST = 20
"""Repairs of one submission that may be in force at once; each is a patch that a person wrote."""


@dataclass(frozen=True)
class RepairRequest:
    """A repair as a person asks for it: the whole new text of a file (`fixed`), or a unified diff on the file (`patch`).

    `seen_sha256` is the digest of the file that the author edited, to notice a repair by somebody else; "" skips the comparison.
    """

    id: str
    file: str
    fixed: bytes | None = None
    patch: str | None = None
    deduction: float = 0.0
    comment: str = ""
    seen_sha256: str = ""


@dataclass(frozen=True)
class Grading:
    """How repaired copies of a class are graded: rubric, traces (reference recordings), and `mark`, which grades in the sandbox."""

    rubric: Rubric
    traces: Traces
    mark: MarkCopy

    def key(self, id_: str, submission_sha256: str) -> Key:
        return Key(id_, submission_sha256, self.rubric.sha256, self.traces.sha256, __version__)


@dataclass(frozen=True)
class GradingSettings:
    """Settings to grade repaired copies by; `opened` opens a sandbox for it, `by` uses the caller's function, as on the desk."""

    rubric: Rubric
    traces: Traces
    open_marker: OpenMarker

    def by(self, mark: MarkCopy) -> Grading:
        return Grading(self.rubric, self.traces, mark)

    @contextmanager
    def opened(self) -> Iterator[Grading]:
        """Open a context with a `Grading` for repaired copies. Its sandbox starts with the first copy and is closed at the end."""
        with ExitStack() as stack:
            marker = cache(lambda: stack.enter_context(self.open_marker()))
            yield self.by(lambda submission, cpu_s=None: marker().mark(submission, cpu_s))


def record(out: Path, request: RepairRequest, author: str, grading: Grading) -> str:
    """Grade a copy with the repair in `request`; store repair and result; return the grades as a line. The caller writes the pages.

    Raises
    ------
    RequestError
        If the submission is not there, the request is not valid, the original was graded by other settings than `grading`, the copy
        cannot be graded or earns less than the original, or there are `MOST` repairs already.
    """
    with Store.existing(out) as store:
        final_grade = _final_grade(store, request.id)
        handed_in = files_handed_in(store, final_grade)
        before = of_these_files(store.repairs_in_force(final_grade.id), handed_in)
        made = validated_repair(request, final_grade, apply_repairs(handed_in.files, before), handed_in, author)
        result = repaired(handed_in, final_grade, [*before, made], grading, store)
        store.keep_repair(made)
        store.keep(grading.key(final_grade.id, repaired_sha256(handed_in, [*before, made])), result)
        after = store.final_grades()[final_grade.id]
    was = _final(final_grade)
    return f"{printable(final_grade.id, 80)}: {printable(made.file, 80)} repaired, {was} before, {_final(after)} now"


@dataclass(frozen=True)
class RepairPreview:
    """The results of a submission `before` and `after` a repair that is not stored, for a person to decide by.

    `problem` says why this repair could not be stored; "" if it could.
    """

    before: Result
    after: Result
    problem: str = ""


def preview(out: Path, request: RepairRequest, grading: Grading) -> RepairPreview:
    """Grade a submission with the repair in `request`, for a person to decide by. Nothing is stored.

    Raises
    ------
    RequestError
        If the submission is not there, the request is not valid, such as a patch that does not apply, or the original was not
        graded by the settings in `grading`.
    """
    with Store.existing(out) as store:
        final_grade = _final_grade(store, request.id)
        handed_in = files_handed_in(store, final_grade)
        before = of_these_files(store.repairs_in_force(final_grade.id), handed_in)
        complete = replace(request, comment=request.comment or "preview")
        made = validated_repair(complete, final_grade, apply_repairs(handed_in.files, before), handed_in, "")
        original = _original_result(final_grade, handed_in, grading, store)
        result = _graded(handed_in, original, [*before, made], grading)
        return RepairPreview(final_grade.result, result, _refusal(final_grade.id, result, original))


def suggestion(out: Path, who: str, grading: Grading) -> tuple[RepairPreview, Suggestion | None]:
    """Search for an edit that makes the code of `who` (id or person) run, after the repairs in force. Nothing is stored.

    Returns
    -------
    The results without and with the edit, before any deduction, and the suggestion. If no edit is found, both results are the
    same and the suggestion is None.
    """
    with Store.existing(out) as store:
        final_grade = _final_grade(store, who)
        handed_in = files_handed_in(store, final_grade)
        present = replace(final_grade.result, repairs=())  # the points before any deduction
        before = of_these_files(store.repairs_in_force(final_grade.id), handed_in)
    now = replace(handed_in, files=apply_repairs(handed_in.files, before))
    found = suggest(now, present, grading.rubric.lab, grading.mark)
    return RepairPreview(present, found.result if found else present), found


def suggested(out: Path, who: str, grading: Grading) -> Iterator[str]:
    """Yield lines on a repair suggested for `who` (id or person): points and diff, or that none was found. Nothing is stored."""
    grades, found = suggestion(out, who, grading)
    if found is None:
        yield f"{printable(who, 80)}: no repair to suggest"
        return
    yield (
        f"{printable(who, 80)}: {printable(found.file, 80)} as below earns {words.number(found.result.score)} points, "
        f"{words.number(grades.before.score)} as it is"
    )
    yield from (printable(line, 200) for line in found.diff.splitlines())


def validated_repair(
    request: RepairRequest, final_grade: FinalGrade, now: Mapping[str, bytes], handed_in: Submission, author: str
) -> LoggedRepair:
    """Return a request as a repair by `author` to store; RequestError if it is not valid.

    `handed_in` is the submission without repairs, `final_grade` its grade, `now` the files as repaired so far.
    """
    most = final_grade.result.max_score
    if request.file not in now:
        raise RequestError(
            f"repair: {printable(final_grade.id, 80)} has no file {printable(request.file, 120)}{guess_at(request.file, now)}"
        )
    if not 0 <= request.deduction <= most or round(request.deduction, 2) != request.deduction:
        raise RequestError(f"repair: --deduct takes points from 0 to {words.number(most)}, with two decimals at most")
    if not request.comment.strip() or len(request.comment) > MAX_COMMENT:
        raise RequestError(
            f"repair: give the reason with --comment, at most {MAX_COMMENT} characters; the student can read it"
        )
    if (request.fixed is None) == (request.patch is None):
        raise RequestError("repair: give the repaired file with --with, or a unified diff with --patch")
    content = now[request.file]
    if request.seen_sha256 not in ("", sha256_of(content)):
        raise OvertakenError(f"repair: another person has repaired {printable(request.file, 120)} since you opened it")
    fixed = apply_patch(content, request.patch) if request.patch is not None else request.fixed or b""
    if len(fixed) > LARGEST:
        raise RequestError(f"repair: the repaired file has more than {LARGEST} bytes")
    if fixed == content:
        raise RequestError(f"repair: nothing in {printable(request.file, 120)} changes")
    sha256, diff = sha256_of(handed_in.files[request.file]), diff_of(request.file, content, fixed)
    comment = request.comment.strip().encode("utf-8", "replace").decode()
    return LoggedRepair(0, final_grade.id, request.file, sha256, diff, request.deduction, comment, author, stamps.now())


def repaired(
    handed_in: Submission, final_grade: FinalGrade, repairs: Sequence[LoggedRepair], grading: Grading, store: Store
) -> Result:
    """Grade a submission with these repairs, and return the result of the copy, for the caller to store.

    Raises
    ------
    RequestError
        If the original was not graded by the settings in `grading`, the copy could not be graded or earns less than the original,
        or there are more than `MOST` repairs.
    """
    original = _original_result(final_grade, handed_in, grading, store)
    if len(repairs) > MOST:
        raise RequestError(
            f"repair: {printable(final_grade.id, 80)} has {MOST} repairs already; remove one with --undo"
        )
    made = _graded(handed_in, original, repairs, grading)
    if refusal := _refusal(final_grade.id, made, original):
        raise RequestError(f"repair: {refusal}; nothing was recorded")
    return made


def _original_result(final_grade: FinalGrade, handed_in: Submission, grading: Grading, store: Store) -> Result:
    """Return the stored result of the files as handed in, below which no repair may fall; RequestError if there is none."""
    original = store.result(grading.key(final_grade.id, handed_in.sha256))
    if original is None:
        raise RequestError(
            f"repair: {printable(final_grade.id, 80)} was graded with other settings or another version; run `imugrade grade` first"
        )
    return original


def _graded(handed_in: Submission, original: Result, repairs: Sequence[LoggedRepair], grading: Grading) -> Result:
    result = grading.mark(replace(handed_in, files=apply_repairs(handed_in.files, repairs)))
    return _with_repairs(result, original, repairs)


def _refusal(id_: str, made: Result, original: Result) -> str:
    """Return why a repaired copy does not count: it was not graded, or earns less than what was handed in; "" if it counts."""
    earned = round(sum(part.points for part in made.criteria), 2)
    if made.status == "graded" and earned >= original.score:
        return ""
    repaired = f"earns {words.number(earned)} points" if made.status == "graded" else "could not be graded"
    return f"{printable(id_, 80)} earns {words.number(original.score)} points as it was handed in, and {repaired} with this repair"


def _with_repairs(result: Result, original: Result, repairs: Sequence[LoggedRepair]) -> Result:
    """Return a copy's result under the original's name and digest, with repairs and original faults for the report."""
    checks = [check for criterion in original.criteria for check in criterion.checks]
    given = tuple(
        Repair(each.file, each.diff, each.deduction, each.author, each.at, each.comment, original.score)
        for each in repairs
    )
    return replace(
        result,
        submission=original.submission,
        provenance={**result.provenance, "submission_sha256": original.provenance["submission_sha256"]},
        repairs=given,
        unrepaired={check.id: Unrepaired(check.keeps, check.misconceptions) for check in checks},
    )


def _final_grade(store: Store, who: str) -> FinalGrade:
    final_grades = store.final_grades()
    id_ = PersonLookup({id_: each.hand_in.people for id_, each in final_grades.items() if each.hand_in.people}).by(who)
    if id_ not in final_grades:
        raise RequestError(f"repair: no submission {printable(who)}{guess_at(who, final_grades)}")
    return final_grades[id_]


def files_handed_in(store: Store, final_grade: FinalGrade) -> Submission:
    """Return a submission without repairs, as stored; RequestError if no file is, or one beyond the storage limits may be code."""
    sha256 = str(final_grade.result.provenance.get("submission_sha256", ""))
    kept = read(unpack, store.files(sha256))
    if not kept.files or kept.more or any(map(is_code, kept.others)):
        raise RequestError(
            f"repair: the record does not hold all files of {printable(final_grade.id, 80)}; grade the class again"
        )
    return Submission(final_grade.id, final_grade.result.submission, kept.files, (), "ready", sha256)


def publish(out: Path, who: str, grading: Grading) -> None:
    """Write the pages of `who` (id, name, e-mail or number) and the class; only `grading`'s lab is used, as for fault texts."""
    with Store.existing(out) as store:
        final_grades = store.final_grades()
        write_class(out, final_grades, store, grading.rubric.lab)
        publish_all(out, [_final_grade(store, who)], store, grading.rubric.lab)


def _final(final_grade: FinalGrade) -> str:
    return "open" if final_grade.final is None else f"{words.number(final_grade.final)} points"


def take_back(out: Path, who: str, file: str, author: str, grading: Grading) -> str:
    """Take back the last repair in force of `who` (id or person); with `file`, the last of that file. Return a line to show.

    `author` is who takes it back. `grading` grades the copy with the other repairs, if any. The caller writes the pages.

    Raises
    ------
    RequestError
        If there is no such repair, or there is no result without it to return to, as the class was graded by other settings.
    """
    with Store.existing(out) as store:
        final_grade = _final_grade(store, who)
        handed_in = files_handed_in(store, final_grade)
        made = of_these_files(store.repairs_in_force(final_grade.id), handed_in)
        old = [each for each in store.repairs_in_force(final_grade.id) if each not in made]
        last = next((each for each in reversed([*old, *made]) if file in ("", each.file)), None)
        if last is None:
            where = f" of {printable(file, 120)}" if file else ""
            raise RequestError(f"repair: {printable(final_grade.id, 80)} has no repair{where} to undo")
        rest = [each for each in made if each != last]
        key = grading.key(final_grade.id, handed_in.sha256)
        if rest:
            result = repaired(handed_in, final_grade, rest, grading, store)
            store.keep(grading.key(final_grade.id, repaired_sha256(handed_in, rest)), result)
        elif store.result(key) is not None:
            store.make_current(key)
        else:
            raise RequestError(
                f"repair: {printable(final_grade.id, 80)} was graded with other settings; run `imugrade grade` first"
            )
        store.undo_repair(last.number, author)
        after = store.final_grades()[final_grade.id]
    return f"{printable(final_grade.id, 80)}: repair of {printable(last.file, 80)} taken back, {_final(after)} now"


def lapsed(store: Store, final_grades: Mapping[str, FinalGrade]) -> list[LoggedRepair]:
    """Return repairs not taken back that no longer count: the student changed the files, or the copy earns less than they do."""
    counting = {
        (id_, each.file, each.diff) for id_, final_grade in final_grades.items() for each in final_grade.result.repairs
    }
    return [each for each in store.repairs_in_force() if (each.id, each.file, each.diff) not in counting]


def listing(out: Path) -> Iterator[str]:
    """Yield a line on every repair ever made, oldest first, then its diff; the line says if the repair does not count any more.

    Without any repair, one line says so.
    """
    with Store.existing(out) as store:
        without_effect = lapsed(store, store.final_grades())
        repairs = store.repairs()
        if not repairs:
            yield "no repairs on record"
        for each in repairs:
            undone = f" (taken back by {printable(each.undone_by, 80)} at {each.undone_at})" if each.undone_at else ""
            state = f" (no longer counts: {WHY_LAPSED})" if each in without_effect else undone
            yield (
                f"{printable(each.id, 80)} {printable(each.file, 80)} -{words.number(each.deduction)}  "
                f"{each.at} by {printable(each.author, 80)}: {printable(each.comment, MAX_COMMENT)}{state}"
            )
            yield from (f"    {printable(line, 200)}" for line in each.diff.splitlines()[2:])
