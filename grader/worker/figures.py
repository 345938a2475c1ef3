"""Extract plain data (facts) from a live matplotlib figure at the moment when it is saved or shown. Nothing is judged here.

The facts are panels with labels, titles, legends and texts, and every curve with its data and colour.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from . import artist_facts, faults
from .joining import MAX_PIECE, end_to_end, is_chain, joined
from .values import Packer

_MAX_AXES = 16
_MAX_CURVES = 48
_MAX_CURVES_IN_ALL = 200
_MAX_POINTS = 6000
# Artists of a panel that are looked at: six curves of the lab's 1,500 samples, drawn by a call for each point.
_MAX_PIECES = 20_000
_MAX_TEXTS = 40
_MAX_INKS = 8


def facts_of(figure: Any, packer: Packer) -> dict[str, Any]:
    """Return the facts of a figure that the grader judges (panels, texts, curves) as plain data; `packer` takes their arrays.

    Raise OverriddenArtistError if student code overrides a method of an artist (curve, text) that the grader reads.
    """
    artist_facts.reject_overrides(figure, *figure.legends)
    axes, behind = list(figure.get_axes())[:_MAX_AXES], figure.get_facecolor()
    artists = [text for part in (figure, *_subfigures(figure)) for text in part.texts]
    artist_facts.reject_overrides(*artists)
    texts = [words for text in artists if (words := artist_facts.readable_text(text, behind))]
    return {
        "title": artist_facts.readable_text(getattr(figure, "_suptitle", None), behind),
        "xlabel": artist_facts.readable_text(getattr(figure, "_supxlabel", None), behind),
        "ylabel": artist_facts.readable_text(getattr(figure, "_supylabel", None), behind),
        "texts": texts[:_MAX_TEXTS],
        "legends": [_legend(legend, behind) for legend in figure.legends[:4]],
        "axes": [_axes(one, packer) for one in axes],
    }


def _subfigures(figure: Any) -> Iterator[Any]:
    """Yield all subfigures of a figure, nested ones included, as their texts count, too."""
    for part in figure.subfigs:
        yield part
        yield from _subfigures(part)


def _axes(axes: Any, packer: Packer) -> dict[str, Any]:
    from matplotlib.ticker import ScalarFormatter

    legend, behind = axes.get_legend(), axes.get_figure().get_facecolor()
    titles = (axes.title, axes._left_title, axes._right_title)
    labels = (axes.xaxis.label, axes.yaxis.label)
    artist_facts.reject_overrides(
        axes, axes.xaxis, axes.yaxis, *titles, *labels, *axes.texts, *([legend] if legend else [])
    )
    box, part = artist_facts.place(axes), _subfigure_texts(axes, behind)
    xlabel, ylabel = (
        artist_facts.readable_text(axis.label, behind) if axes.axison and axis.get_visible() else ""
        for axis in (axes.xaxis, axes.yaxis)
    )
    return {
        "visible": bool(axes.get_visible()),
        "position": [round(_bounded(v), 4) for v in (box.x0, box.y0, box.x1, box.y1)],
        "xlabel": xlabel or part["xlabel"],
        "ylabel": ylabel or part["ylabel"],
        "title": next(
            (words for title in titles if (words := artist_facts.readable_text(title, behind)).strip()), part["title"]
        ),
        "legend": _legends(axes, behind),
        "texts": [
            _text_with_place(text)
            for text in axes.texts[:_MAX_TEXTS]
            if artist_facts.readable_text(text, axes.get_facecolor())
        ],
        "curves": _curves(axes, packer),
        "own_height": not axes.get_autoscaley_on(),
        "own_ticks": type(axes.xaxis.get_major_formatter()) is not ScalarFormatter,
        "x_limits": [_bounded(v) for v in axes.get_xlim()],
        "y_limits": [_bounded(v) for v in axes.get_ylim()],
        "scales": [axes.get_xscale(), axes.get_yscale()] if axes.name == "rectilinear" else ["", ""],
    }


def _subfigure_texts(axes: Any, behind: Any) -> dict[str, str]:
    """Return the title and axis labels of the subfigure around a panel, so far as they can be read on the background `behind`.

    Each is "" for a panel of the figure itself, whose texts are reported once.
    """
    part = axes.get_figure()
    whole = part is part.canvas.figure
    artists = {name: None if whole else getattr(part, f"_sup{name}", None) for name in ("title", "xlabel", "ylabel")}
    artist_facts.reject_overrides(part, *(artist for artist in artists.values() if artist is not None))
    return {name: artist_facts.readable_text(artist, behind) for name, artist in artists.items()}


def _legends(axes: Any, behind: Any) -> list[dict[str, Any]] | None:
    """Return the entries of the legends of a panel and of the subfigure that holds it; None if no legend is visible."""
    own, part = axes.get_legend(), axes.get_figure()
    around = [] if part is part.canvas.figure else list(part.legends[:4])
    artist_facts.reject_overrides(*around)
    entries = [_legend(legend, behind) for legend in around if legend.get_visible()]
    if own is not None and own.get_visible():
        entries.insert(0, _legend(own, axes.get_facecolor()))
    return [entry for legend in entries for entry in legend] if entries else None


def _curves(axes: Any, packer: Packer) -> list[dict[str, Any]]:
    room = min(_MAX_CURVES, _MAX_CURVES_IN_ALL - len(packer.arrays) // 2)
    lines = joined(axes.get_lines()[:_MAX_PIECES], _points_on, _style_of_line)
    curves = [_line(pieces, packer) for pieces in lines[: max(room, 0)]]
    others = (
        (pieces[0], drawn)
        for pieces in joined((*axes.collections, *axes.patches)[:_MAX_PIECES], _points_in, _style_of_points)
        for drawn in _curves_drawn_by(pieces)
    )
    for artist, (x, y, colour) in itertools.islice(others, max(room - len(curves), 0)):
        curves.append(_curve(artist, x, y, colour, packer) | _ink_of(artist, colour))
    return curves


def _points_on(line: Any) -> int:
    return int(np.size(np.asarray(line.get_xdata())))


def _style_of_line(line: Any) -> tuple[str, ...]:
    """Return what distinguishes a line for a reader (colour, line style, marker, width); pieces of one style are one curve."""
    return _colour(line.get_color()), str(line.get_linestyle()), str(line.get_marker()), _stroke(line)


def _points_in(artist: Any) -> int:
    """Return the number of scattered points; for any other artist a number so large that it is not joined to others."""
    from matplotlib.collections import PathCollection

    return int(np.shape(artist.get_offsets())[0]) if isinstance(artist, PathCollection) else MAX_PIECE + 1


def _style_of_points(points: Any) -> tuple[str, str]:
    """Return what distinguishes scattered points for a reader (colour and size); pieces of one style are one curve."""
    return _colour(_face(points)), _masked_text(points.get_sizes()[:1])


def _curves_drawn_by(pieces: list[Any]) -> Iterator[tuple[np.ndarray, np.ndarray, Any]]:
    """Yield x, y and colour of each curve in artists that are no lines: line collections, stairs, scatters joined from `pieces`."""
    from matplotlib.collections import Collection, LineCollection
    from matplotlib.patches import StepPatch

    artist = pieces[0]
    if isinstance(artist, Collection | StepPatch):
        artist_facts.reject_overrides(*pieces)
    if isinstance(artist, LineCollection):
        segments, colours = list(artist.get_segments()), list(_plain_floats(artist.get_edgecolor()))
        if is_chain(segments):
            segments, colours = [end_to_end(segments)], colours[:1]
        for segment, colour in zip(segments, itertools.cycle(colours), strict=False):
            if len(segment) > MAX_PIECE:  # not a mark, as `vlines` makes them
                yield segment[:, 0], segment[:, 1], colour
    elif isinstance(artist, StepPatch):
        values, edges, _ = artist.get_data()
        yield _plain_floats(edges)[:-1], _plain_floats(values), artist.get_edgecolor()
    elif isinstance(artist, Collection):
        offsets = np.concatenate([_plain_floats(piece.get_offsets()).reshape(-1, 2) for piece in pieces])
        if len(offsets) > 2:
            yield offsets[:, 0], offsets[:, 1], _face(artist)


def _plain_floats(values: Any) -> np.ndarray:
    """Return an artist's numbers as floats, with NaN for masked ones, which are not drawn."""
    filled: np.ndarray = np.ma.asarray(values, dtype=float).filled(np.nan)
    return filled


_FARTHEST = 1e12
_NOTHING = ("None", "none", "", " ", None)


def _line(pieces: list[Any], packer: Packer) -> dict[str, Any]:
    artist_facts.reject_overrides(*pieces)
    line, (x, y) = pieces[0], _points_of(pieces[0])
    if len(pieces) > 1:
        x, y = end_to_end(np.column_stack(_points_of(piece)) for piece in pieces).T
    stroke, marks = line.get_linestyle() not in _NOTHING, line.get_marker() not in _NOTHING
    inks = [line.get_color()] if stroke else []
    if marks:
        inks += [line.get_markerfacecolor(), line.get_markeredgecolor()]
    widths = [line.get_linewidth()] if stroke else []
    if marks:
        widths.append(line.get_markersize())
    return _curve(line, x, y, line.get_color(), packer) | {
        "kind": "line" if stroke or marks else "nothing",
        "style": str(line.get_linestyle())[:8],
        "marker": str(line.get_marker())[:8],
        "stroke": _stroke(line),
        "inks": _inks(inks),
        "width": _bounded(min(widths, default=0.0)),
    }


def _points_of(line: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of a line as they are drawn, dates and category names as numbers, so that they can be compared."""
    return _plain_floats(line.get_xdata(orig=False)), _plain_floats(line.get_ydata(orig=False))


def _stroke(line: Any) -> str:
    """Return as text what distinguishes lines of one colour (dashes, width, opacity), to match curves with legend samples."""
    dashes = getattr(line, "_unscaled_dash_pattern", None)  # matplotlib has no getter for it
    return _masked_text((dashes, line.get_linewidth(), line.get_alpha()))


def _curve(artist: Any, x: Any, y: Any, colour: Any, packer: Packer) -> dict[str, Any]:
    n = min(len(x), len(y))
    step = max(1, -(-n // _MAX_POINTS))
    return {
        "label": _masked_text(str(artist.get_label())),
        "colour": _colour(colour),
        "kind": "points",
        "n": int(n),
        "x": packer.keep(x[:n:step]),
        "y": packer.keep(y[:n:step]),
        "style": "",
        "marker": "",
        "stroke": "",
        "alpha": _opacity(artist),
    }


def _bounded(value: Any) -> float:
    """Return a coordinate as a finite, bounded number, which JSON can hold: an unstable filter makes infinite axis limits."""
    return float(np.clip(np.nan_to_num(float(value)), -_FARTHEST, _FARTHEST))


def _opacity(artist: Any) -> float:
    alpha = artist.get_alpha() if artist.get_visible() else 0.0
    return 1.0 if alpha is None or np.ndim(alpha) else float(alpha)


def _ink_of(artist: Any, colour: Any) -> dict[str, Any]:
    """Return the colours and the width in which a collection's points or lines are drawn, to find its curve in the picture."""
    from matplotlib.collections import Collection, LineCollection

    if isinstance(artist, Collection) and not isinstance(artist, LineCollection):
        sizes = artist.get_sizes() if hasattr(artist, "get_sizes") else ()
        inks = [*artist.get_facecolor()[:_MAX_POINTS], *artist.get_edgecolor()[:1]]
        return {"inks": _inks(inks), "width": float(np.sqrt(np.median(sizes))) if len(sizes) else 6.0}
    shades = (
        artist.get_edgecolor() if isinstance(artist, LineCollection) and is_chain(artist.get_segments()) else [colour]
    )
    return {"inks": _inks(shades), "width": _bounded(np.max(artist.get_linewidth(), initial=0.0))}


def _inks(colours: Iterable[Any]) -> list[str]:
    """Return each colour once, as hex with its opacity; an empty list if there are too many to tell which one is meant."""
    from matplotlib.colors import to_hex

    inks: dict[str, None] = {}
    for colour in colours:
        try:
            inks[str(to_hex(colour, keep_alpha=True))] = None
        except (ValueError, TypeError):
            continue  # “none”
    return list(inks) if len(inks) <= _MAX_INKS else []


def _face(collection: Any) -> Any:
    colours = collection.get_facecolor()
    return colours[0] if len(colours) else (collection.get_edgecolor()[0] if len(collection.get_edgecolor()) else "k")


def _colour(colour: Any) -> str:
    from matplotlib.colors import to_hex

    try:
        return str(to_hex(colour))
    except (ValueError, TypeError):
        return "?"


def _legend(legend: Any, behind: Any) -> list[dict[str, Any]]:
    """Return the entries of a legend on a background: text, and colour and stroke of the sample, which tell the curve meant."""
    handles = getattr(legend, "legend_handles", None) or getattr(legend, "legendHandles", [])
    pairs = list(zip(legend.get_texts()[:_MAX_CURVES], handles, strict=False))
    artist_facts.reject_overrides(*(artist for pair in pairs for artist in pair))
    return [_entry(text, handle, behind) for text, handle in pairs]


def _entry(text: Any, handle: Any, behind: Any) -> dict[str, Any]:
    line = hasattr(handle, "get_linestyle") and hasattr(handle, "get_color")
    colour = (
        handle.get_color() if line else (_face(handle) if hasattr(handle, "get_offsets") else handle.get_facecolor())
    )
    return {
        "text": artist_facts.readable_text(text, behind),
        "colour": _colour(colour),
        "style": str(handle.get_linestyle())[:8] if line else "",
        "marker": str(handle.get_marker())[:8] if line and hasattr(handle, "get_marker") else "",
        "stroke": _stroke(handle) if line else "",
    }


def _text_with_place(text: Any) -> dict[str, Any]:
    """Return a text with its colour and place, as it may name a curve; for an annotation the place of the point it explains."""
    from matplotlib.text import Annotation

    where = text.xy if isinstance(text, Annotation) else text.get_position()  # an annotation may stand beside its point
    x, y = (float(v) if isinstance(v, int | float | np.number) else float("nan") for v in where)
    return {
        "text": _masked_text(text.get_text()),
        "place": [_bounded(x), _bounded(y)],
        "colour": _colour(text.get_color()),
    }


def _masked_text(text: object) -> str:
    """Return at most 200 characters of a text, with memory addresses masked, so that a regrade gives equal facts."""
    return faults.mask_addresses(str(text))[:200]
