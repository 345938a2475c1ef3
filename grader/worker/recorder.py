"""Record the figures that a submission saves or shows: the facts (plain data) of each at that moment, before it changes."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from . import artist_facts, drawing, figures, saved
from .values import Packer

_MAX_FIGURES = 12
_QUICKLY = {"compress_level": 1, "compress_type": 3}  # runs of equal bytes alone: a picture that is read once
_RAW = ("raw", "rgba")


class Recorder:
    """Recorder of the figures that a submission saves, shows, closes or clears; `take` hands them over with each answer."""

    def __init__(self) -> None:
        self._drawn: list[saved.RecordedFigure] = []
        self._noted: dict[Any, bool] = {}
        """The figures so far, and whether there was anything on them."""
        self._packer = Packer()
        self._files: dict[str, bytes | None] = {}
        self._paused = False

    def take(self, folder: str, *, with_open: bool = True) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Return the figures recorded since the last `take`, and close all figures; those still open are recorded first.

        Without `with_open` they are closed unrecorded, for a caller that drops the result. The result is ({"figures": [one dict of
        panels, texts and curves for each]}, the arrays that these dicts name). Each dict's ``event`` says whether the figure is in
        a picture file below `folder` (see `match_files_to_figures`).
        """
        import matplotlib.pyplot as plt

        if with_open:
            for number in plt.get_fignums():
                self.note(plt.figure(number), event="open")
        self._paused = True
        plt.close("all")
        self._paused = False
        saved.match_files_to_figures(self._drawn, folder, self._files)
        arrays = self._packer.arrays
        arrays |= {one.facts["seen"]: one.seen.pixels for one in self._drawn if one.seen is not None}
        facts = [one.facts for one in self._drawn]
        self._drawn, self._noted, self._packer = [], {}, Packer()
        return {"figures": facts}, arrays

    def note(
        self,
        figure: Any,
        *,
        event: str,
        target: Any = None,
        dpi: Any = None,
        kind: str = "",
        seen: drawing.Preview | None = None,
    ) -> None:
        """Record a figure at an `event` such as "saved"; after twelve records, ignore all others until the next `take`.

        A figure that has a record gets one more only if it is saved now (but not as raw pixels, like a film's frames), or was empty
        then and is not now. `target`, `dpi` and `kind` (the format) are those of `savefig`; `seen` is the small picture that goes
        into the record, or None to draw it here.
        """
        filled = any(axes.has_data() for axes in figure.get_axes())
        known = figure in self._noted and self._noted[figure] >= filled  # one that was empty then may be drawn into now
        again = known and (event != "saved" or kind in _RAW)  # a film is many pictures of one figure
        if self._paused or len(self._drawn) >= _MAX_FIGURES or again:
            return
        self._noted[figure] = filled
        content, place = (None, None) if event != "saved" or kind in _RAW else saved.content_of(target)
        width, height = (float(x) for x in figure.get_size_inches())
        dots = float(figure.dpi if dpi is None or dpi == "figure" else dpi)
        facts: dict[str, Any] = {
            "event": event,
            "path": _name(target),
            "format": kind,
            "size_px": [round(width * dots), round(height * dots)],
        }
        drawn = self._with_artists(figure, facts, f"seen{len(self._drawn)}", seen)
        drawn.written, drawn.place = content, place
        self._drawn.append(drawn)

    def _with_artists(
        self, figure: Any, facts: dict[str, Any], name: str, seen: drawing.Preview | None
    ) -> saved.RecordedFigure:
        """Return a figure's record: `facts`, with those of its artists added, and its small picture, called `name` in them.

        If artists of the student's own raise, the facts name the error, and there is no picture.
        """
        try:
            with artist_facts.original_classes():
                seen = seen or drawing.draw_preview(figure)
                facts |= figures.facts_of(figure, self._packer)
            facts |= {"seen": name, "extent": list(seen.extent), "dots": seen.dots}
        except Exception as error:  # artists of the student's own making
            facts |= {"unreadable": type(error).__name__, "axes": []}
            seen = None
        return saved.RecordedFigure(facts, seen)


RECORDER = Recorder()


def watch(*, read_back: bool) -> None:
    """Record each figure saved, shown, closed or cleared from now on.

    Files that student code saves are made small, to save time, or in full if other code will `read_back` the files.
    """
    import matplotlib.pyplot as plt
    from matplotlib import rcParams
    from matplotlib.backend_bases import FigureCanvasBase
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    really_print = FigureCanvasBase.print_figure
    really_print_png: Callable[..., None] = FigureCanvasAgg.print_png

    def print_figure(self: Any, filename: Any, dpi: Any = None, *args: Any, **kwargs: Any) -> None:
        asked = rcParams["savefig.dpi"] if dpi is None else dpi
        options = dict(zip(("facecolor", "edgecolor", "orientation", "format"), args, strict=False)) | kwargs
        kind = _kind(filename, options)
        blank = drawing.save_blank if kind in _RAW else drawing.save
        save = drawing.save_as_asked if read_back else blank
        if kind == "png" and save is drawing.save:
            options = {"pil_kwargs": _QUICKLY} | options
        seen = save(really_print, self, filename, asked, options)
        RECORDER.note(self.figure, event="saved", target=filename, dpi=asked, kind=kind, seen=seen)

    @functools.wraps(really_print_png)  # matplotlib asks for its parameters
    def print_png(self: Any, filename: Any, **kwargs: Any) -> None:
        if self._is_saving:  # by `print_figure`
            really_print_png(self, filename, **kwargs)
        else:
            self.print_figure(filename, dpi="figure", format="png", **kwargs)

    really_close, really_clear = plt.close, Figure.clear

    def close(fig: Any = None) -> None:
        current = [plt.gcf()] if fig is None and plt.get_fignums() else [fig] if isinstance(fig, Figure) else []
        for figure in map(plt.figure, plt.get_fignums()) if fig == "all" else current:
            RECORDER.note(figure, event="closed")
        really_close(fig)

    def clear(self: Any, *args: Any, **kwargs: Any) -> Any:
        if self.get_axes():
            RECORDER.note(self, event="cleared")
        return really_clear(self, *args, **kwargs)

    def show(*args: Any, block: bool | None = None, **kwargs: Any) -> None:
        for number in plt.get_fignums():
            RECORDER.note(plt.figure(number), event="shown")
        if block is not False and not plt.isinteractive():
            plt.close("all")

    vars(plt).update(show=show, close=close)
    setattr(Figure, "clear", clear)  # noqa: B010
    if not read_back:
        setattr(Figure, "tight_layout", drawing.tight_layout)  # noqa: B010
    setattr(FigureCanvasBase, "print_figure", print_figure)  # noqa: B010 - a method is replaced on purpose
    setattr(FigureCanvasAgg, "print_png", print_png)  # noqa: B010
    setattr(Figure, "show", lambda self, *args, **kwargs: RECORDER.note(self, event="shown"))  # noqa: B010
    artist_facts.remember(Figure, FigureCanvasBase, FigureCanvasAgg)


def _name(target: Any) -> str | None:
    if isinstance(target, str | os.PathLike):
        return str(os.fspath(target))[:300]
    return None


def _kind(target: Any, kwargs: dict[str, Any]) -> str:
    if kwargs.get("format"):
        return str(kwargs["format"])[:10].lower()
    name = _name(target)
    return (Path(name).suffix[1:].lower() or "png")[:10] if name else "png"
