"""Draw a figure as a small picture, fast, so that the grader sees which curves are visible; errors are those of a full drawing.

matplotlib itself draws each artist that may be a curve or cover one. Other artists are not drawn but examined, so that what would
raise in a full drawing raises here, too: ticks are located, their labels formatted, mathematical text parsed. If a submission reads
its saved pictures back, they are drawn in full.

`tight_layout` moves panels and hides nothing, so it is skipped.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

_SIDE = 500.0  # pixels of the longer side of a small picture: the sheet's figure at 50 dots per inch
_FEWEST_DOTS, _MOST_DOTS = 12.0, 100.0  # dots per inch; with fewer, texts have no size
_MOST_PIXELS = 4e6  # pixels of the small picture of a very long or very large figure
_LONG_SIDE = 4000.0  # pixels of the longer side of a picture that the submission reads back
_HEADING, _SMALL_PRINT = 30.0, 20.0  # largest font size, in points, of a title and of other text that need not be drawn
_THIN, _SHORT = 2.5, 12.0  # points of a grid line's width and of a tick's length
_FEW_ENTRIES, _FEW_TICKS = 8, 40
_FEW_LETTERS = 120
_GREEK = (
    r"\\(?:alpha|beta|[gG]amma|[dD]elta|(?:var)?epsilon|zeta|eta|[tT]heta|iota|kappa|[lL]ambda|mu|nu|[xX]i|[pP]i|rho|[sS]igma|"
    r"tau|[uU]psilon|[pP]hi|chi|[pP]si|[oO]mega)(?![a-zA-Z])"
)
_SCRIPT = rf"(?:[a-zA-Z0-9]|\{{[a-zA-Z0-9]+\}}|{_GREEK})"
_PLAIN_MATHEMATICS = re.compile(
    rf"[^$\\\n]*(?:\$(?:[ /]*(?:[a-zA-Z0-9]|{_GREEK})(?:_{_SCRIPT})?(?:\^{_SCRIPT})?)+\$[^$\\\n]*)+"
)
"""Letters and numbers with an index and a power. They are always valid, so the millisecond of parsing is saved."""
_READS_BACK = re.compile(
    rb"\bimread\b|\bImage\.open\b|\bbuffer_rgba\b|\bprint_to_buffer\b|\btostring_\w+\b|\bgetsize\b|\bst_size\b|\bgetbuffer\b"
)


@dataclass(frozen=True)
class Preview:
    """Small picture of a figure, to find visible curves: pixels (h, w, 3), exact (w, h) to place curves in it, and its dpi."""

    pixels: np.ndarray
    extent: tuple[float, float]
    dots: float


def reads_pictures_back(sources: Iterable[bytes]) -> bool:
    """Return whether source files may read a picture that they drew (pixels, file size): pictures must then be drawn in full."""
    return any(_READS_BACK.search(source) for source in sources)


# --- the small picture ---------------------------------------------------------------------------------------------------------


def draw_preview(figure: Any) -> Preview:
    """Return a figure as a small picture, drawn now; raise what drawing it in full would raise, such as an invalid formula."""
    from matplotlib.backends.backend_agg import RendererAgg

    before, dots, canvas = figure.dpi, _preview_dpi(figure), figure.canvas
    width, height = (max(1, int(size * dots)) for size in figure.get_size_inches())
    canvas.draw_idle = _draw_nothing  # pyplot asks for a redraw at full size that nobody would see
    figure.dpi = dots
    try:
        renderer: Any = RendererAgg(width, height, dots)  # type: ignore[no-untyped-call]
        _draw_small(figure, renderer)
        return _pixels_of(figure, renderer, dots)
    finally:
        figure.dpi = before


def _preview_dpi(figure: Any) -> float:
    """Return the dots per inch of the small picture: its longer side has 500 pixels, unless texts or memory need more or fewer."""
    width, height = figure.get_size_inches()
    fewest = min(_FEWEST_DOTS, np.sqrt(_MOST_PIXELS / (width * height)))
    return float(min(_MOST_DOTS, max(_SIDE / max(width, height), fewest)))


def _pixels_of(figure: Any, renderer: Any, dots: float) -> Preview:
    """Return a renderer's pixels as a small picture over white; `dots` are its dots per inch. A very long picture is thinned."""
    drawn = np.asarray(renderer.buffer_rgba())
    pixels = drawn[:, :, :3]
    if drawn[:, :, 3].min() < 255:
        opacity = drawn[:, :, 3:] / 255.0
        pixels = pixels * opacity + 255 * (1 - opacity)
    step = -(-max(pixels.shape) // int(_SIDE))  # above 1 for a figure like a ribbon
    width, height = (float(size * dots / step) for size in figure.get_size_inches())
    return Preview(np.array(np.rint(pixels[::step, ::step]), np.uint8), (width, height), dots / step)


def _draw_small(figure: Any, renderer: Any) -> None:
    """Draw a figure without snapping lines and markers to whole pixels, which would make a small marker vanish."""
    from matplotlib import rcParams

    before = rcParams["path.snap"]
    rcParams["path.snap"] = False
    try:
        _draw_figure(figure, renderer)
    finally:
        rcParams["path.snap"] = before


def _draw_figure(figure: Any, renderer: Any) -> None:
    """Draw a figure or subfigure with all its artists, but its panels (axes) by `_draw_panel`, which leaves some out."""
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

    if not figure.get_visible():
        return
    figure.patch.draw(renderer)
    rest = [artist for artist in figure.get_children() if artist is not figure.patch]
    for artist in sorted(rest, key=_zorder):
        if isinstance(artist, SubFigure):
            _draw_figure(artist, renderer)
        elif type(artist) is Axes:
            _draw_panel(artist, renderer)
        else:
            artist.draw(renderer)


def _draw_panel(axes: Any, renderer: Any) -> None:
    """Draw a panel as `Axes.draw` does, but without ordinary titles, axes, ticks and legends, which take time and hide no curve."""
    from matplotlib.axes import Axes

    if not axes.get_visible():
        return
    axes.get_xlim()  # scales what was not scaled yet
    locator = axes.get_axes_locator()
    axes.apply_aspect(locator(axes, renderer) if locator else None)
    framed = axes.axison and axes.get_frame_on()
    out = {axes.patch, *_undrawn_artists(axes)} | set(() if framed else axes.spines.values())
    if not axes.axison:
        out |= {axes.xaxis, axes.yaxis}
    if framed:
        axes.patch.draw(renderer)
    for artist in sorted((artist for artist in axes.get_children() if artist not in out), key=_zorder):
        if type(artist) is Axes:
            _draw_panel(artist, renderer)
        else:
            artist.draw(renderer)


def _zorder(artist: Any) -> float:
    return float(artist.get_zorder())


def _undrawn_artists(axes: Any) -> Iterator[Any]:
    """Yield a panel's artists too small to hide a curve, which need not be drawn; raise what drawing one would raise."""
    for title in (axes.title, axes._left_title, axes._right_title):
        if _is_small(title, _HEADING):
            _parse_mathematics(title)
            yield title
    for axis in (axes.xaxis, axes.yaxis):
        if axes.axison and axis.get_visible() and _is_ordinary_axis(axis):
            _parse_mathematics(axis.label)
            yield axis
    legend = axes.get_legend()
    if legend is not None and _is_ordinary_legend(legend):
        for text in (legend.get_title(), *legend.get_texts()):
            _parse_mathematics(text)
        yield legend


def _is_ordinary_axis(axis: Any) -> bool:
    """Return whether an axis has few, thin ticks with plain labels, which hide no curve; raise what formatting them raises."""
    ticks = [*axis.majorTicks, *axis.minorTicks]  # matplotlib makes one if there is none; all are alike
    places, said = _tick_labels(axis)
    mathematics = any("$" in text for text in said)
    thin = all(tick.gridline.get_linewidth() <= _THIN for tick in ticks)
    short = all(tick.tick1line.get_markersize() <= _SHORT for tick in ticks)
    small = all(_is_small(text, _SMALL_PRINT) for tick in ticks for text in (tick.label1, tick.label2))
    brief = sum(map(len, said)) <= 10 * _FEW_LETTERS
    return (
        thin
        and short
        and small
        and brief
        and places <= _FEW_TICKS
        and not mathematics
        and _is_small(axis.label, _HEADING)
    )


def _tick_labels(axis: Any) -> tuple[int, list[str]]:
    """Return the number of an axis's ticks and their labels, without Tick objects, which are slow; raise what formatters raise."""
    places, between = axis.get_majorticklocs(), axis.get_minorticklocs()
    said = [*axis.get_major_formatter().format_ticks(places), axis.get_major_formatter().get_offset()]
    said += axis.get_minor_formatter().format_ticks(between)
    drawn_between = any(tick.gridline.get_visible() for tick in axis.minorTicks)
    return len(places) + (len(between) if drawn_between else 0), [str(text) for text in said]  # of a box plot: numbers


def _is_ordinary_legend(legend: Any) -> bool:
    texts = [legend.get_title(), *legend.get_texts()]
    compact = (
        legend.borderpad <= 2 and legend.handlelength <= 6 and legend.markerscale <= 3 and legend.labelspacing <= 3
    )
    return bool(compact and len(texts) <= _FEW_ENTRIES + 1 and all(_is_small(text, _SMALL_PRINT) for text in texts))


def _is_small(text: Any, size: float) -> bool:
    """Return whether a text is short, without a frame, and at most `size` points high, so that it hides no curve."""
    bare = text.get_bbox_patch() is None and not text.get_path_effects()
    return bool(bare and text.get_fontsize() <= size and len(text.get_text()) <= _FEW_LETTERS)


def _parse_mathematics(text: Any) -> None:
    """Parse the mathematics in a visible text, if there is any, so that an invalid formula raises as in a full drawing."""
    said = text.get_text()
    if text.get_visible() and ("$" in said or text.get_usetex()) and not _PLAIN_MATHEMATICS.fullmatch(said):
        text.get_window_extent()  # parses mathematics


# --- saving --------------------------------------------------------------------------------------------------------------


def save(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> Preview:
    """Save a canvas's figure to `target` as a small picture, which is returned; raise what saving the figure in full would raise.

    `really` is matplotlib's `print_figure`, `asked` the submission's `dpi` (None for the default), `options` its other arguments.
    """
    figure = canvas.figure
    drawn: list[Any] = []
    _dpi(asked, figure.dpi)
    dots = _preview_dpi(figure)
    canvas.draw_idle = _draw_nothing

    def draw(renderer: Any) -> None:
        drawn[:] = [renderer]
        _draw_small(figure, renderer)
        _send_draw_event(figure, renderer)

    figure.draw = draw
    try:
        really(canvas, target, dots, **options | _whole_figure_bbox(figure, options))
    finally:
        vars(figure).pop("draw", None)
    seen = (
        _pixels_of(figure, drawn[0], dots)
        if drawn and _holds_whole_figure(figure, drawn[0], dots)
        else draw_preview(figure)
    )
    return _crop_to_saved_part(seen, options.get("bbox_inches"))


def _crop_to_saved_part(seen: Preview, part: Any) -> Preview:
    """Return the picture with white outside of `part`, the rectangle in inches that is saved; unchanged for any other `part`."""
    from matplotlib.transforms import BboxBase

    if isinstance(part, BboxBase):
        left, right = (max(0, round(x * seen.dots)) for x in (part.x0, part.x1))
        top, bottom = (max(0, round(seen.extent[1] - y * seen.dots)) for y in (part.y1, part.y0))
        kept = seen.pixels[top:bottom, left:right].copy()
        seen.pixels[:] = 255
        seen.pixels[top:bottom, left:right] = kept
    return seen


def _holds_whole_figure(figure: Any, renderer: Any, dots: float) -> bool:
    """Return whether a renderer has the pixels of the whole figure, so that it need not be drawn again; PDF and SVG have none."""
    try:
        shape = np.asarray(renderer.buffer_rgba()).shape[:2]
    except (AttributeError, ValueError):  # of a PDF, an SVG
        return False
    return shape == tuple(max(1, int(size * dots)) for size in figure.get_size_inches()[::-1])


def _send_draw_event(figure: Any, renderer: Any) -> None:
    """Call the functions that the submission connected to ``draw_event``, as a full drawing does."""
    from matplotlib.backend_bases import DrawEvent

    if figure.canvas.callbacks.callbacks.get("draw_event"):
        figure.canvas.callbacks.process("draw_event", DrawEvent("draw_event", figure.canvas, renderer))


def _draw_nothing(*args: Any, **kwargs: Any) -> None:
    """Stand in for `canvas.draw_idle` during a small drawing: nobody would see its redraw at full size."""


def _whole_figure_bbox(figure: Any, options: dict[str, Any]) -> dict[str, Any]:
    """Return the option that saves the whole figure where "tight" is asked for, whose margin is slow to measure; {} otherwise."""
    from matplotlib import rcParams
    from matplotlib.transforms import Bbox

    if options.get("bbox_inches") != "tight" and not (
        options.get("bbox_inches") is None and rcParams["savefig.bbox"] == "tight"
    ):
        return {}
    for axes in figure.get_axes():
        axes.apply_aspect()  # from here on its place is fixed
    return {"bbox_inches": Bbox.from_bounds(0, 0, *figure.get_size_inches())}


def tight_layout(self: Any, *, pad: float = 1.08, h_pad: Any = None, w_pad: Any = None, rect: Any = None) -> None:
    """Stand in for `Figure.tight_layout`: accept its arguments and do nothing: it is slow, moves panels and hides nothing."""


def save_as_asked(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> None:
    """Save a figure in full by matplotlib's own method `really`, for a submission that reads its pictures back.

    The parameters are those of `save`. A very large picture gets fewer dots per inch than `asked`, as saving it would take minutes.
    """
    figure = canvas.figure
    dots = min(_dpi(asked, figure.dpi), _LONG_SIDE / max(figure.get_size_inches()))
    really(canvas, target, dots, **options)


def save_blank(really: Callable[..., Any], canvas: Any, target: Any, asked: Any, options: dict[str, Any]) -> None:
    """Save raw pixels, such as a frame of a film, all with value 0, because nobody looks at them and drawing is slow.

    The parameters are those of `save`; `really` and `options` are not used.
    """
    del really, options
    content = blank(canvas.figure, asked)
    target.write(content) if hasattr(target, "write") else Path(target).write_bytes(content)


def blank(figure: Any, asked: Any) -> bytes:
    """Return as many bytes of value 0 as the figure's raw pixels take at the dpi `asked`, for film frames: nobody looks at them."""
    dots = _dpi(asked, figure.dpi)
    width, height = (int(size * dots) for size in figure.get_size_inches())
    return bytes(4 * width * height)


def _dpi(asked: Any, own: float) -> float:
    """Return the dots per inch that the `dpi` of `savefig` means, `own` for None or "figure"; ValueError if not positive."""
    dots = own if asked is None or asked == "figure" else float(asked)
    if not np.isfinite(dots) or dots <= 0:
        raise ValueError("dpi must be positive")
    return dots
