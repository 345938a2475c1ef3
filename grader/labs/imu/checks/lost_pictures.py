"""Pictures that a plot should be in and is not: overwritten, unreadable, empty, never saved, or handed in and drawn by no code."""

from __future__ import annotations

from typing import NoReturn

from grader.base.text import printable
from grader.engine.findings import CheckFailed, Ours
from grader.labs.imu.answers import Drawing
from grader.labs.imu.checks import handed_in
from grader.labs.imu.checks.plot_runs import Plot, has_curves, sensors_in_words

SAVE_LAST = Ours(
    "Call savefig last, before plt.show() and plt.close(): what is drawn after savefig is not in the picture (Step 4)."
)


def some_overwritten(drawn: list[Plot]) -> None:
    """Charge what a figure showed that is in no file at the end: it is lost to the reader."""
    still_shown, gone = (
        {channel for plot in drawn if plot.figure.event == event for channel in plot.drawn}
        for event in ("saved", "overwritten")
    )
    if gone - still_shown:
        path = next(plot.figure.path for plot in drawn if plot.figure.event == "overwritten")
        missing = sensors_in_words({sensor for sensor, _ in gone - still_shown})
        raise CheckFailed(
            "a file of its own for each figure",
            f"{printable(path or handed_in.PICTURE, 60)}, saved again, without the {missing}",
            mistakes=["picture-overwritten"],
        )


def none_saved(drawing: Drawing) -> NoReturn:
    """Charge that no file shows the curves, and say what became of them."""
    events = {figure.event for figure in drawing.figures if has_curves(figure)}
    broken = next((picture for picture in drawing.strange if picture.reason), None)
    if events & {"overwritten", "forgotten"} and broken is not None:
        hint = Ours(
            "Let savefig write the file, with a name that ends in .png. Do not change the file afterwards (Step 4)."
        )
        got = f"{printable(broken.path, 60)}, a file that no program can open"
        raise CheckFailed("a picture that can be read", got, hint=hint)
    if "overwritten" in events:
        hint = Ours("Save the figure last. Write nothing else to the same file afterwards (Step 4).")
        got = "a file that was overwritten with something else"
        raise CheckFailed(
            f"a picture of the curves, {handed_in.PICTURE}", got, mistakes=["picture-overwritten"], hint=hint
        )
    empty = [figure for figure in drawing.figures if figure.is_saved]
    if empty:
        last = SAVE_LAST if any(figure.finished is not None for figure in empty) else ""
        got = "a picture that was saved from an empty figure"
        raise CheckFailed("a picture of the curves", got, mistakes=["blank-image"], hint=last)
    drawn = "a figure that is drawn but not saved" if events else "no figure"
    if "forgotten" in events:
        drawn = "a figure that is saved to memory, but not written to a file"
    raise CheckFailed(f"a saved picture, {handed_in.PICTURE}", drawn, mistakes=["plot-not-saved"])
