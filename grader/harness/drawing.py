"""Saving a figure at the least cost: what raises still raises, and no pixel is made that nobody looks at.

A figure of thin lines, texts and markers in panels that do not overlap hides no curve, so its pixels tell nothing. It is
examined in place of being drawn: its ticks are placed, its curves converted, its mathematics parsed. Any other figure is
drawn as matplotlib does it, and looked at. Where a submission reads pictures back, each is drawn as it asks.

A layout that leaves room for texts moves panels and hides nothing, either; it waits until the figure has to be drawn.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from .seeing import LARGEST_DPI, PREVIEW_DPI, as_it_was, must_be_honest, place

_THIN, _SMALL_MARKER = 5.0, 12.0  # points
_HEADING = 30.0  # points
_FEW_ENTRIES = 8  # of a legend
_SHORT_SIDE = 60.0  # pixels of a picture that nobody looks at
_LONG_SIDE = 4000.0  # pixels of a picture that the submission reads back
_SCALES = ("linear", "log", "symlog", "asinh", "logit")
_READS_BACK = re.compile(
    rb"\bimread\b|\bImage\.open\b|\bbuffer_rgba\b|\bprint_to_buffer\b|\btostring_\w+\b|\bgetsize\b|\bst_size\b|\bgetbuffer\b"
)


def reads_pictures_back(sources: Iterable[bytes]) -> bool:
    """Whether a submission may look at a picture that it drew: its pixels, or how large the file is."""
    return any(_READS_BACK.search(source) for source in sources)


def nothing_covers(figure: Any) -> bool:
    """Whether no pixel needs to be looked at, and no artist needs to be drawn to know whether it can be.

    Only what is known to be harmless counts: matplotlib's own panels, lines, texts, legends, ticks and scales.
    """
    try:
        with as_it_was():
            panels = list(figure.get_axes())
            must_be_honest(figure)
            return (
                {*figure.get_children()} <= {figure.patch, *figure.texts, *panels}
                and not figure.canvas.callbacks.callbacks.get("draw_event")
                and all(_is_bare(text) for text in figure.texts)
                and all(_is_bare_panel(axes) for axes in panels)
                and not _overlap(panels)
            )
    except Exception:  # artists of the student's own making
        return False


def _is_bare_panel(axes: Any) -> bool:
    """Whether a panel holds thin lines, texts and a legend, drawn as usual."""
    from matplotlib.axes import Axes

    titles, axis = (axes.title, axes._left_title, axes._right_title), (axes.xaxis, axes.yaxis)
    legend, lines, spines = axes.get_legend(), list(axes.lines), list(axes.spines.values())
    known = {axes.patch, *lines, *spines, *titles, *axis, *axes.texts, *([legend] if legend else [])}
    must_be_honest(axes, *known)
    # One tick is made by asking where there is none yet; those that follow are made alike.
    grid = [tick.gridline for each in axis for tick in each.majorTicks]
    strokes = [*lines, *spines, *grid]
    return (
        type(axes) is Axes
        and axes.get_axes_locator() is None
        and {*axes.get_children()} <= known
        and all(_is_bare(text) for text in (*axes.texts, *titles, *(legend.get_texts() if legend else [])))
        and (legend is None or len(legend.get_texts()) <= _FEW_ENTRIES)
        and all(_is_bare_axis(each) for each in axis)
        and all(_is_thin(stroke) for stroke in strokes)
        and all(_is_bare_line(line, axes) for line in lines)
    )


def _is_bare_axis(axis: Any) -> bool:
    """Whether scale and ticks are matplotlib's own."""
    placing = (
        axis.get_major_locator(),
        axis.get_minor_locator(),
        axis.get_major_formatter(),
        axis.get_minor_formatter(),
    )
    return axis.get_scale() in _SCALES and all(type(each).__module__.startswith("matplotlib.") for each in placing)


def _is_bare_line(line: Any, axes: Any) -> bool:
    """Whether a curve is in the panel's own coordinates or a single stroke, with small markers at every point or at none."""
    own = line.get_transform() is axes.transData or len(line.get_xdata()) <= 2  # `axhline`, `axvline`
    return bool(own and line.get_markevery() is None and line.get_markersize() <= _SMALL_MARKER)


def _is_bare(text: Any) -> bool:
    """Whether a text is no larger than a heading and has neither box nor arrow."""
    alone = text.get_bbox_patch() is None and getattr(text, "arrow_patch", None) is None
    return bool(alone and text.get_fontsize() <= _HEADING and not text.get_path_effects())


def _is_thin(stroke: Any) -> bool:
    usual = stroke.get_agg_filter() is None and stroke.get_clip_path() is None and not stroke.get_path_effects()
    return bool(usual and stroke.get_linewidth() <= _THIN)


def _overlap(panels: list[Any]) -> bool:
    """Whether two panels lie over each other; the second of twins has no background and hides nothing."""
    boxes = [place(axes) for axes in panels if axes.get_visible() and axes.patch.get_visible()]
    return any(
        min(a.x1, b.x1) > max(a.x0, b.x0) and min(a.y1, b.y1) > max(a.y0, b.y0)
        for i, a in enumerate(boxes)
        for b in boxes[:i]
    )


# --- saving --------------------------------------------------------------------------------------------------------------


def save(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> bool:
    """Save a figure, and tell whether it is bare: then no pixel of it has to be looked at.

    Raises what drawing it would have raised.
    """
    figure, bare = canvas.figure, nothing_covers(canvas.figure)
    _dots(asked, figure.dpi)
    if bare:
        _examine(figure)
        dots = min(figure.dpi, _SHORT_SIDE / min(figure.get_size_inches()))
        with _undrawn(figure):
            really(canvas, target, dots, **options | _whole(figure, options))
    else:
        lay_out(figure)
        # the figure's own dpi is cheapest, as its texts have been measured at it already
        really(canvas, target, figure.dpi if figure.dpi <= LARGEST_DPI else PREVIEW_DPI, **options)
    canvas.draw_idle = _draw_nothing  # pyplot asks for a redraw at full size that nobody would see
    return bare


@contextlib.contextmanager
def _undrawn(figure: Any) -> Iterator[None]:
    figure.draw = _draw_nothing
    try:
        yield
    finally:
        vars(figure).pop("draw", None)


def _draw_nothing(*args: Any, **kwargs: Any) -> None:
    """Stands in for drawing a figure that has been examined, or saved."""


def _whole(figure: Any, options: dict[str, Any]) -> dict[str, Any]:
    """The whole figure as the part that is saved, where a margin around what is drawn would have to be measured."""
    from matplotlib.transforms import Bbox

    if options.get("bbox_inches") not in (None, "tight"):
        return {}
    return {"bbox_inches": Bbox.from_bounds(0, 0, *figure.get_size_inches())}


def _examine(figure: Any) -> None:
    if not figure.get_visible():
        return
    texts = list(figure.texts)
    for axes in figure.get_axes():
        if axes.get_visible():
            axes.apply_aspect()
            texts += _texts(axes)
            for line in axes.lines:
                if line.get_visible():
                    line.get_path()  # converts units, and finds x and y of different lengths
    for text in texts:
        if text.get_visible() and ("$" in text.get_text() or text.get_usetex()):
            text.get_window_extent()  # parses mathematics


def _texts(axes: Any) -> list[Any]:
    """The texts of a panel, those of its ticks put in place by their locators and formatters."""
    texts, legend = [*axes.texts, axes.title, axes._left_title, axes._right_title], axes.get_legend()
    if legend is not None and legend.get_visible():
        texts += [legend.get_title(), *legend.get_texts()]
    for axis in (axes.xaxis, axes.yaxis):
        if axes.axison and axis.get_visible():
            texts.append(axis.label)
            if any("$" in label for label in _tick_labels(axis)):
                texts += axis.get_ticklabels(which="both")
    return texts


def _tick_labels(axis: Any) -> list[str]:
    """What an axis says at its ticks, by its locators and formatters; no tick is made for it."""
    major = axis.get_major_formatter().format_ticks(axis.get_majorticklocs())
    minor = axis.get_minor_formatter().format_ticks(axis.get_minorticklocs())
    return [*major, axis.get_major_formatter().get_offset(), *minor]


_WAITING: WeakKeyDictionary[Any, dict[str, Any]] = WeakKeyDictionary()


def laying_out_late(really: Callable[..., None]) -> Callable[..., None]:
    """A `Figure.tight_layout` that waits where nothing on the figure can cover a curve."""

    def tight_layout(self: Any, *, pad: float = 1.08, h_pad: Any = None, w_pad: Any = None, rect: Any = None) -> None:
        margins = {"pad": pad, "h_pad": h_pad, "w_pad": w_pad, "rect": rect}
        if nothing_covers(self):
            _WAITING[self] = margins
        else:
            really(self, **margins)

    return tight_layout


def lay_out(figure: Any) -> None:
    """Make up for a layout that waits."""
    from matplotlib.layout_engine import TightLayoutEngine

    margins = _WAITING.pop(figure, None)
    if margins is not None:
        TightLayoutEngine(**margins).execute(figure)


def save_as_asked(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> bool:
    """`save` for a submission that reads its pictures back: drawn in full, as long as that is a picture of a usual size."""
    figure = canvas.figure
    dots = min(_dots(asked, figure.dpi), _LONG_SIDE / max(figure.get_size_inches()))
    really(canvas, target, dots, **options)
    return nothing_covers(figure)


def save_blank(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> bool:
    """`save` for bare pixels, a frame of a film mostly: as many bytes as they are, and nothing drawn."""
    del really, options
    content = blank(canvas.figure, asked)
    target.write(content) if hasattr(target, "write") else Path(target).write_bytes(content)
    return nothing_covers(canvas.figure)


def blank(figure: Any, asked: Any) -> bytes:
    """As many bytes as bare pixels of the figure take with this `dpi` of `savefig`."""
    dots = _dots(asked, figure.dpi)
    width, height = (int(size * dots) for size in figure.get_size_inches())
    return bytes(4 * width * height)


def _dots(asked: Any, own: float) -> float:
    """What `dpi` of `savefig` means; ValueError where it means nothing."""
    dots = own if asked is None or asked == "figure" else float(asked)
    if not np.isfinite(dots) or dots <= 0:
        raise ValueError("dpi must be positive")
    return dots
