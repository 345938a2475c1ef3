"""Measurement of the comparison plot (Step 6): the figures of raw and filtered data that the submission's files draw when run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from grader.base.text import printable
from grader.engine.figures import Figure
from grader.engine.findings import GraderText, StudentError
from grader.engine.load_report import not_handed_in
from grader.labs.imu.student import Student
from grader.labs.imu.visualization import comparing
from grader.labs.imu.visualization.pictures import COMPARISON, was_handed_in


@dataclass(frozen=True)
class Comparison:
    """Figures of raw and filtered data that the submission's files draw when run as scripts; `check_comparison_plot` judges them.

    Attributes
    ----------
    saved : the pairs of a raw and a filtered curve in each saved figure that has any, all drawn by one file
    drawn : whether any figure, saved or not, has such a pair
    meant : for a figure that is named as a comparison and has no such pair, its number of curves and what it shows; else (0, "")
    handed_in : whether the code saves no comparison and a picture under the lab sheet's name for it was handed in
    error : the first exception that stopped a file; None if none did
    clean : whether raw data without noise is accepted, because the noise model has lost points already
    """

    saved: tuple[Sequence[comparing.Compared], ...] = ()
    drawn: bool = False
    meant: tuple[int, str] = (0, "")
    handed_in: bool = False
    error: StudentError | None = None
    clean: bool = False

    @property
    def noisy(self) -> bool:
        """Return whether a saved raw curve has noise, or the attribute `clean` is set: a faulty noise model loses points once."""
        return self.clean or any(pair.noisy for pairs in self.saved for pair in pairs)

    @property
    def in_words(self) -> str:
        return "both curves, and no saved file that shows them" if self.drawn else self.meant[1] or "no figure of both"

    @property
    def stop_in_words(self) -> str:
        """The exception that stopped a file, with its line, for the message; "" if none did."""
        if self.error is None:
            return ""
        said = printable(f"{self.error.type}: {self.error.message}", 300) + not_handed_in(self.error)
        return f"{said} at {self.error.where}" if self.error.where else said


def measure(student: Student) -> Comparison:
    """Run the submission's files until one saves a noisy raw curve and its filtered one (`Comparison.noisy`); return its pairs.

    If none does, take the first file that saves pairs without noise, unless another figure of two or more curves is named as the
    comparison: in any plot of a robot that comes to rest, one channel is smoother than another. `saved` is empty without either.
    """
    drawn, meant = False, (0, "")
    error: StudentError | None = None
    clean: Comparison | None = None
    charged = _replace_failed_plot(student)
    for drawing in student.scripts():
        error = error or (drawing.error if drawing.error != charged else None)
        pairs = [(figure, _pairs_in(student, figure)) for figure in drawing.figures]
        if saved := tuple(pair for figure, pair in pairs if pair and figure.is_saved):
            _note_stopped(student, drawing.error)
            found = Comparison(saved, drawn=True, clean="NoisyIMU" in student.broken)
            if found.noisy:
                return found
            clean = clean or found
        drawn = drawn or any(pair for figure, pair in pairs if not figure.is_saved)
        meant = max(meant, *_meant_to_compare(figure for figure, pair in pairs if not pair))
    if clean is not None and meant[0] < 2:
        return clean
    return Comparison((), drawn, meant, was_handed_in(student, COMPARISON), error)


def _replace_failed_plot(student: Student) -> StudentError | None:
    """Replace a failed `plot_imu_data` by a sound one, so that scripts run on after its call. Return what it raised, or None."""
    drawing = student.stored_answer("plot")
    if drawing is None or drawing.error is not None:
        student.replace_broken(["plot_imu_data"])
    return None if drawing is None else drawing.error


def _note_stopped(student: Student, error: StudentError | None) -> None:
    """Add a note on a statement that raised `error` when a file was run and that was skipped, unless the same statement has a note.

    Nothing is noted without an error or its line, or for an attribute that is missing beside stand-ins: these sound functions,
    which the grader puts in the place of broken ones, lack what the submission has added to its own.
    """
    if error is None or not error.where or (error.type == "AttributeError" and student.broken):
        return
    if not any(note.startswith(f"{error.where} ") for note in student.notes):
        why = printable(error.type or error.message, 60)
        student.note(
            f"{error.where} was stopped when the file was run: {why}. The grader went on with the next line",
            GraderText("A statement was stopped when a file was run as a script. The grader went on with the next one"),
        )


def _pairs_in(student: Student, figure: Figure) -> Sequence[comparing.Compared]:
    """Return the pairs of a raw and a filtered curve in a figure; of a filter that has lost points already, its pairs by name."""
    found = comparing.comparisons(figure)
    return found or (comparing.named_comparisons(figure) if "LowPassFilter" in student.broken else [])


def _meant_to_compare(figures: Iterable[Figure]) -> list[tuple[int, str]]:
    """Return `in_words` of each figure that its file's name or its curves' names mark as a comparison, after (0, "") for none."""
    meant = (f for f in figures if f.file_name == COMPARISON or comparing.named_comparisons(f))
    return [(0, ""), *map(comparing.in_words, meant)]
