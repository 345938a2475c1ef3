"""Facts about the comparison plot: the figures of raw and filtered data that a submission's programs draw when they are run."""

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
    """Figures of raw and filtered data that the submission's programs draw.

    Attributes
    ----------
    saved : the pairs of curves in each saved figure of one program that has any
    drawn : whether any figure has such a pair
    meant : the number of curves of a figure that is meant to compare and has no such pair, and what they are in words
    handed_in : whether a picture of such a figure was handed in
    error : the exception that stopped a program
    clean : whether the noise model has lost points, so that no noise is asked for
    """

    saved: tuple[Sequence[comparing.Compared], ...] = ()
    drawn: bool = False
    meant: tuple[int, str] = (0, "")
    handed_in: bool = False
    error: StudentError | None = None
    clean: bool = False

    @property
    def noisy(self) -> bool:
        """Return whether noise is seen in a raw curve, or none is asked for."""
        return self.clean or any(pair.noisy for pairs in self.saved for pair in pairs)

    @property
    def in_words(self) -> str:
        return "both curves, and no saved file that shows them" if self.drawn else self.meant[1] or "no figure of both"

    @property
    def stop_in_words(self) -> str:
        """The exception that stopped a program, with its file and line; "" if none did."""
        if self.error is None:
            return ""
        said = printable(f"{self.error.type}: {self.error.message}", 300) + not_handed_in(self.error)
        return f"{said} at {self.error.where}" if self.error.where else said


def measure(student: Student) -> Comparison:
    """Run the submission's programs until one saves a figure of noisy and filtered data.

    A figure without noise counts only if no other figure is meant as the comparison: in any plot, one channel of a robot that comes
    to rest is smoother than another.
    """
    drawn, meant = False, (0, "")
    error: StudentError | None = None
    clean: Comparison | None = None
    charged = _past_the_plot(student)
    for drawing in student.scripts():
        error = error or (drawing.error if drawing.error != charged else None)
        pairs = [(figure, _compared(student, figure)) for figure in drawing.figures]
        if saved := tuple(pair for figure, pair in pairs if pair and figure.is_saved):
            _note_stopped(student, drawing.error)
            found = Comparison(saved, drawn=True, clean="NoisyIMU" in student.broken)
            if found.noisy:
                return found
            clean = clean or found
        drawn = drawn or any(pair for figure, pair in pairs if not figure.is_saved)
        meant = max(meant, *_meant(figure for figure, pair in pairs if not pair))
    if clean is not None and meant[0] < 2:
        return clean
    return Comparison((), drawn, meant, was_handed_in(student, COMPARISON), error)


def _past_the_plot(student: Student) -> StudentError | None:
    """Let scripts go on beside a stand-in where `plot_imu_data` does not end, which is charged. Return what it raised."""
    drawing = student.stored_answer("plot")
    if drawing is None or drawing.error is not None:
        student.replace_broken(["plot_imu_data"])
    return None if drawing is None else drawing.error


def _note_stopped(student: Student, error: StudentError | None) -> None:
    """Add a note on a statement that stopped in a program and was stepped over, unless the import has noted it.

    A stand-in has what the sheet gives it, and nothing of the submission's own: what misses that is no fault.
    """
    if error is None or not error.where or (error.type == "AttributeError" and student.broken):
        return
    if not any(note.startswith(f"{error.where} ") for note in student.notes):
        why = printable(error.type or error.message, 60)
        student.note(
            f"{error.where} was stopped when the file was run: {why}. The grader went on with the next line",
            GraderText("A statement was stopped when a file was run as a script. The grader went on with the next one"),
        )


def _compared(student: Student, figure: Figure) -> Sequence[comparing.Compared]:
    """Return the raw and filtered curves; those of a filter that has been charged already go by their names."""
    found = comparing.comparisons(figure)
    return found or (comparing.named_comparisons(figure) if "LowPassFilter" in student.broken else [])


def _meant(figures: Iterable[Figure]) -> list[tuple[int, str]]:
    """Return the curves of each figure that is meant to compare: its file's name says so, or the names of its curves."""
    meant = (f for f in figures if f.file_name == COMPARISON or comparing.named_comparisons(f))
    return [(0, ""), *map(comparing.in_words, meant)]
