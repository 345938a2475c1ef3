"""What can be seen of a figure, and whether matplotlib itself is asked: facts are taken from artists that say what they draw.

A curve that is drawn in no colour, outside the window or behind a sheet is in the figure and not in the picture. And whoever
wants to be praised for a label can as well teach `get_ylabel` to return one; so the classes are asked as they were before any
of the student's code ran, and an artist that answers for itself is not asked at all.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np

PREVIEW_DPI = 50
LARGEST_DPI = 120  # a picture of more dots an inch is not drawn, and not looked at
_SMALLEST = 0.03  # of the figure's width or height: less than that is no panel
_SMALLEST_FONT = 3.0
_FAINT = 0.02
_NEAR = 0.04  # difference of two colours, each channel 0 to 1, that nobody sees
_IN_WINDOW = 0.02  # share of a curve's points: who zooms in still shows some
_OWN_COLOUR = 3  # pixels in a curve's colour that make it seen
_NOTHING = ("None", "none", "", " ", None)
_ASKED = frozenset(
    [
        "get_alpha",
        "get_axes",
        "get_children",
        "get_clip_box",
        "get_clip_on",
        "get_color",
        "get_data",
        "get_edgecolor",
        "get_facecolor",
        "get_fontsize",
        "get_label",
        "get_legend",
        "get_legend_handles_labels",
        "get_lines",
        "get_linestyle",
        "get_linewidth",
        "get_marker",
        "get_markersize",
        "get_offsets",
        "get_position",
        "get_segments",
        "get_shared_x_axes",
        "get_size_inches",
        "get_subplotspec",
        "get_text",
        "get_texts",
        "get_title",
        "get_visible",
        "get_window_extent",
        "get_xdata",
        "get_xlabel",
        "get_xlim",
        "get_ydata",
        "get_ylabel",
        "get_ylim",
        "lines",
        "collections",
        "axes",
        "texts",
        "xy",
        "legends",
        "legend_handles",
        "draw",
        "__class__",
        "__getattribute__",
        "__getattr__",
    ]
)


class LyingArtistError(ValueError):
    """An artist whose class or who itself answers in place of matplotlib."""


# --- matplotlib as it was ------------------------------------------------------------------------------------------------

_CLASSES: dict[type, dict[str, Any]] = {}


def remember_classes() -> None:
    """Note every class of artists, axes and canvases with what it holds, before any of the student's code runs."""
    from matplotlib.artist import Artist
    from matplotlib.backend_bases import FigureCanvasBase
    from matplotlib.transforms import TransformNode

    waiting: list[type] = [Artist, FigureCanvasBase, TransformNode]
    while waiting:
        kind = waiting.pop()
        if kind not in _CLASSES:
            remember(kind)
            waiting += kind.__subclasses__()


def remember(*kinds: type) -> None:
    """Note what these classes hold now: the harness has put functions of its own into them."""
    _CLASSES.update((kind, dict(vars(kind))) for kind in kinds)


@contextlib.contextmanager
def as_it_was() -> Iterator[None]:
    """Put every class back to what it was, for as long as facts are taken."""
    changed: list[tuple[type, str, Any]] = []
    for kind, members in _CLASSES.items():
        now = vars(kind)
        names = [name for name, value in members.items() if now.get(name) is not value and not name.startswith("__")]
        changed += [(kind, name, now.get(name)) for name in names]
    try:
        for kind, name, _ in changed:
            setattr(kind, name, _CLASSES[kind][name])
        yield
    finally:
        for kind, name, value in changed:
            setattr(kind, name, value)


def must_be_honest(*artists: Any) -> None:
    """Raise LyingArtistError where an artist, or a class of the student's, overrides what is asked of it."""
    for artist in artists:
        strange = [kind for kind in type(artist).__mro__ if kind not in _CLASSES and kind.__module__ != "builtins"]
        own = [name for kind in strange if not _generated(kind) for name in vars(kind) if name in _ASKED]
        own += [name for name, value in vars(artist).items() if name in _ASKED and callable(value)]
        if own:
            raise LyingArtistError(f"{type(artist).__name__} answers for itself: {own[0]}"[:200])


def _generated(kind: type) -> bool:
    """Whether matplotlib makes the class itself, or inherits it from elsewhere."""
    return kind.__module__.startswith(("matplotlib.", "mpl_toolkits.")) and "<locals>" not in kind.__qualname__


# --- what is in the picture ----------------------------------------------------------------------------------------------


def pixels(canvas: Any) -> np.ndarray | None:
    """The picture (h, w, 3), 0 to 255, small: as it was drawn last if that was all of the figure, else drawn anew."""
    figure = canvas.figure
    buffer: np.ndarray | None
    try:
        buffer = np.asarray(canvas.renderer.buffer_rgba())
        width, height = figure.get_size_inches()
        if abs(buffer.shape[1] / buffer.shape[0] - width / height) > 0.02 or buffer.shape[1] > LARGEST_DPI * width + 2:
            raise ValueError("a part of the figure, or one of another size")
        if not buffer[:, :, 3].any():
            raise ValueError("a renderer that has measured texts, and drawn nothing yet")
    except (AttributeError, ValueError, ZeroDivisionError):
        buffer = _drawn(figure)
    if buffer is None:
        return None
    step = max(1, round(buffer.shape[1] / figure.get_size_inches()[0] / PREVIEW_DPI))
    return buffer[::step, ::step, :3]


def _drawn(figure: Any) -> np.ndarray | None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    before, dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = PREVIEW_DPI
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
        return np.array(canvas.buffer_rgba())
    except Exception:  # whatever artists of the student's own making raise
        return None
    finally:
        figure.dpi = dpi
        figure.set_canvas(before)


def place(axes: Any) -> Any:
    """Where a panel lies, in parts of the whole figure; its own position counts from its part of the figure."""
    return axes.bbox.transformed(axes.get_figure().canvas.figure.transFigure.inverted())


def panel_is_visible(axes: Any) -> bool:
    """Whether a panel has a size and lies in the figure, most of it."""
    box = place(axes)
    width, height = abs(box.x1 - box.x0), abs(box.y1 - box.y0)
    inside_x = min(max(box.x0, box.x1), 1.0) - max(min(box.x0, box.x1), 0.0)
    inside_y = min(max(box.y0, box.y1), 1.0) - max(min(box.y0, box.y1), 0.0)
    large = min(width, height) >= _SMALLEST
    return bool(axes.get_visible() and large and inside_x > width / 2 and inside_y > height / 2)


def line_is_visible(line: Any, axes: Any, x: np.ndarray, y: np.ndarray) -> bool:
    """Whether a line has a stroke or markers, a colour, and points in the window."""
    stroke = line.get_linestyle() not in _NOTHING and float(line.get_linewidth()) > 0.05
    marks = line.get_marker() not in _NOTHING and float(line.get_markersize()) > 0.05
    return (stroke or marks) and artist_is_visible(line, axes, line.get_color(), x, y)


def artist_is_visible(artist: Any, axes: Any, colour: Any, x: np.ndarray, y: np.ndarray) -> bool:
    """Whether an artist is switched on, not see-through, not of the background's colour, not clipped away."""
    alpha = artist.get_alpha()
    see_through = alpha is not None and np.ndim(alpha) == 0 and float(alpha) <= _FAINT
    return bool(
        artist.get_visible()
        and not see_through
        and _differs(colour, axes)
        and _in_window(axes, x, y)
        and not _clipped(artist, axes)
    )


def _differs(colour: Any, axes: Any) -> bool:
    from matplotlib.colors import to_rgba

    try:
        drawn, behind = np.array(to_rgba(colour)), _ground(axes)
    except (ValueError, TypeError):
        return True
    return bool(drawn[3] > _FAINT and drawn[3] * np.abs(drawn[:3] - behind).max() > min(_NEAR, drawn[3] / 10))


def _ground(axes: Any) -> np.ndarray:
    """The colour behind a panel's curves: its own, as far as that is opaque, over the figure's, over white paper."""
    from matplotlib.colors import to_rgba

    part, colour = axes.get_figure(), np.ones(3)
    for layer in (part.canvas.figure, part, axes):
        *own, opacity = to_rgba(layer.get_facecolor())
        colour = opacity * np.array(own) + (1 - opacity) * colour
    return colour


def _in_window(axes: Any, x: np.ndarray, y: np.ndarray) -> bool:
    n = min(len(x), len(y))
    known = np.isfinite(x[:n]) & np.isfinite(y[:n])
    if not known.any():
        return True  # nothing to be seen, and nothing hidden
    (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    shown = known & (x[:n] >= left) & (x[:n] <= right) & (y[:n] >= low) & (y[:n] <= high)
    return bool(shown.sum() > _IN_WINDOW * known.sum())


def _clipped(artist: Any, axes: Any) -> bool:
    box = artist.get_clip_box()
    if box is None or not artist.get_clip_on():
        return False
    left, right = max(box.x0, axes.bbox.x0), min(box.x1, axes.bbox.x1)
    low, high = max(box.y0, axes.bbox.y0), min(box.y1, axes.bbox.y1)
    return bool(right - left < axes.bbox.width / 4 or high - low < axes.bbox.height / 4)


def any_colour_shows(axes: Any, colours: list[Any], picture: np.ndarray) -> bool:
    """Whether the panel's part of the picture holds pixels in the colour of at least one of the curves, outside the legend."""
    from matplotlib.colors import to_rgb

    box, (height, width) = place(axes), picture.shape[:2]
    rows = slice(max(int((1 - box.y1) * height) + 2, 0), max(int((1 - box.y0) * height) - 1, 0))  # within the frame
    columns = slice(max(int(box.x0 * width) + 2, 0), max(int(box.x1 * width) - 1, 0))
    behind = _ground(axes)
    counts = (
        np.abs(picture - np.round(255 * behind).astype(np.int16)).max(axis=2) > 255 * _NEAR
    )  # background says nothing
    counts &= _outside_legend(axes, height, width)
    part = picture[rows, columns][counts[rows, columns]] / 255
    return any(_holds(part, behind, np.array(to_rgb(colour))) for colour in colours)


def _outside_legend(axes: Any, height: int, width: int) -> np.ndarray:
    outside = np.ones((height, width), bool)
    legend = axes.get_legend()
    if legend is None:
        return outside
    try:
        box = legend.get_window_extent().transformed(axes.get_figure().canvas.figure.transFigure.inverted())
    except Exception:  # a legend that was never laid out
        return outside
    outside[max(int((1 - box.y1) * height) - 1, 0) : max(int((1 - box.y0) * height) + 2, 0),
            max(int(box.x0 * width) - 1, 0) : max(int(box.x1 * width) + 2, 0)] = False  # fmt: skip
    return outside


def _holds(part: np.ndarray, behind: np.ndarray, colour: np.ndarray) -> bool:
    """Whether some pixels are on the way from the background's colour to the curve's, far enough to be told apart from it."""
    way = colour - behind
    length = float(way @ way)
    if length < 1e-6:
        return False
    share = (part - behind) @ way / length
    beside = np.abs(part - behind - share[:, None] * way).max(axis=1)
    return int(np.count_nonzero((share > 0.15) & (share < 1.2) & (beside < 0.03 + 0.15 * share))) >= _OWN_COLOUR


def words(text: Any, behind: Any) -> str:
    """What a text says, if it can be read: switched on, large enough, in a colour that is not the background's."""
    from matplotlib.colors import to_rgba

    if text is None or not text.get_visible() or float(text.get_fontsize()) < _SMALLEST_FONT:
        return ""
    alpha = text.get_alpha()
    try:
        drawn, ground = np.array(to_rgba(text.get_color())), np.array(to_rgba(behind))
    except (ValueError, TypeError):
        return str(text.get_text())[:200]
    strength = float(drawn[3]) * (1.0 if alpha is None else float(alpha))
    lost = ground[3] > 0.5 and np.abs(drawn[:3] - ground[:3]).max() <= _NEAR
    return "" if strength <= 0.05 or lost else str(text.get_text())[:200]
