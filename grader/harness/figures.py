"""Facts taken off a live matplotlib figure at the moment when it is saved or shown.

Extract the facts, then judge the facts (elsewhere): axes with their labels, titles, legends and texts, every curve with its
data and colour, and what the call to `savefig` asked for; and the witness, pixels of what was drawn. They are not judged here.
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from . import drawing, saved, seeing
from .values import Packer

_MAX_FIGURES = 12
_MAX_TOLD = 16  # of them, those among them that are told of as they are at their end
_MAX_AXES = 16
_MAX_CURVES = 48
_MAX_CURVES_IN_ALL = 200
_MAX_POINTS = 6000
_MAX_TEXTS = 40
_MAX_INKS = 8
_QUICKLY = {"compress_level": 1, "compress_type": 3}  # runs of equal bytes alone: a picture that is read once
_RAW = ("raw", "rgba")
_ENDS = ("closed", "cleared", "open")
"""Events that a figure meets once. A live plot is shown at every step, and nobody knows which of them is its last."""


class Recorder:
    """What was saved and shown since the last `take`."""

    def __init__(self) -> None:
        self._drawn: list[saved.Drawn] = []
        self._noted: dict[Any, bool] = {}
        """The figures so far, and whether there was anything on them."""
        self._saved: dict[Any, tuple[frozenset[Any], list[saved.Drawn]]] = {}
        """What was on a figure when it was saved, and the files that it was saved to like that."""
        self._packer = Packer()
        self._files: dict[str, bytes | None] = {}
        self._deaf = False

    def take(self, folder: str, *, with_open: bool = True) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """The facts so far, those of figures that are still open and were never saved among them; then start anew.

        Returns
        -------
        ``figures``, ``pictures`` (names of all picture files) and ``strange`` (those that hold no figure, with the reason).
        """
        import matplotlib.pyplot as plt

        if with_open:
            for number in plt.get_fignums():
                self.note(plt.figure(number), event="open")
        self._deaf = True
        plt.close("all")
        self._deaf = False
        strange = saved.settle(self._drawn, folder, self._files)
        told, arrays = _told(self._drawn), self._packer.arrays
        arrays |= {one.facts["seen"]: one.seen.pixels for one in told if one.seen is not None}
        facts = [one.facts for one in told]
        self._drawn, self._noted, self._saved, self._packer = [], {}, {}, Packer()
        return {"figures": facts, "pictures": saved.written_pictures(folder), "strange": strange}, arrays

    def note(
        self,
        figure: Any,
        *,
        event: str,
        target: Any = None,
        dpi: Any = None,
        kind: str = "",
        seen: drawing.Seen | None = None,
    ) -> None:
        """Take the facts; `seen` where the figure was looked at already."""
        if event in _ENDS and not self._deaf:
            self._note_the_end(figure)
        filled = any(axes.has_data() for axes in figure.get_axes())
        known = figure in self._noted and self._noted[figure] >= filled  # one that was empty then may be drawn into now
        again = known and (event != "saved" or kind in _RAW)  # a film is many pictures of one figure
        if self._deaf or len(self._drawn) >= _MAX_FIGURES or again:
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
        drawn = self._described(figure, facts, f"seen{len(self._drawn)}", seen)
        drawn.written, drawn.place = content, place
        self._drawn.append(drawn)
        if event == "saved":
            self._remember(figure, drawn)

    def _described(self, figure: Any, facts: dict[str, Any], name: str, seen: drawing.Seen | None) -> saved.Drawn:
        """A figure with what is on it beside these facts; its pixels go by that name."""
        try:
            with seeing.as_it_was():
                seen = seen or drawing.look(figure)
                facts |= _figure(figure, self._packer)
            facts |= {"seen": name, "extent": list(seen.extent), "dots": seen.dots}
        except Exception as error:  # artists of the student's own making
            facts |= {"unreadable": type(error).__name__, "axes": []}
            seen = None
        return saved.Drawn(facts, seen)

    def _remember(self, figure: Any, drawn: saved.Drawn) -> None:
        """Keep what was on a figure when it was saved."""
        parts = _parts(figure)
        before, files = self._saved.get(figure, (frozenset(), []))
        self._saved[figure] = (parts, [*files, drawn] if before == parts else [drawn])

    def _note_the_end(self, figure: Any) -> None:
        """Take the facts of a figure that was saved, and on which there is more now."""
        parts, files = self._saved.pop(figure, (frozenset(), []))
        if files and parts < _parts(figure):
            finished = self._described(figure, {"event": "finished"}, f"end_of_{files[0].facts.get('seen')}", None)
            for one in files:
                one.finished = finished


def _told(drawn: list[saved.Drawn]) -> list[saved.Drawn]:
    """The figures, each followed by itself as it was at its end: the same file shows less."""
    room, told = _MAX_TOLD - len(drawn), []
    for one in drawn:
        told.append(one)
        if one.finished is not None and room:
            told.append(saved.Drawn(_of_file(one) | one.finished.facts, one.finished.seen))
            room -= 1
    return told


def _of_file(drawn: saved.Drawn) -> dict[str, Any]:
    return {name: drawn.facts[name] for name in ("path", "format", "size_px")}


def _parts(figure: Any) -> frozenset[Any]:
    """What is drawn and written on a figure, each by itself; nothing where the student's own artists do not tell."""
    try:
        return frozenset(_each_part(figure))
    except Exception:  # artists of the student's own making
        return frozenset()


def _each_part(figure: Any) -> Iterator[Any]:
    written = [*figure.texts]
    for axes in figure.get_axes()[:_MAX_AXES]:
        titles, labels = (axes.title, axes._left_title, axes._right_title), (axes.xaxis.label, axes.yaxis.label)
        written += [*titles, *labels, *axes.texts]
        yield from ((id(artist), "drawn") for artist in (*axes.lines, *axes.collections, *axes.patches))
        if axes.get_legend() is not None:
            yield id(axes), "legend"
    yield from ((id(legend), "legend") for legend in figure.legends)
    yield from ((id(text), text.get_text()) for text in written if text.get_text().strip())


RECORDER = Recorder()


def watch(*, read_back: bool) -> None:
    """Record every figure that is saved or shown from now on; where pictures are read back, save them as asked."""
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
    seeing.remember(Figure, FigureCanvasBase, FigureCanvasAgg)


def _name(target: Any) -> str | None:
    if isinstance(target, str | os.PathLike):
        return str(os.fspath(target))[:300]
    return None


def _kind(target: Any, kwargs: dict[str, Any]) -> str:
    if kwargs.get("format"):
        return str(kwargs["format"])[:10].lower()
    name = _name(target)
    return (Path(name).suffix[1:].lower() or "png")[:10] if name else "png"


def _figure(figure: Any, packer: Packer) -> dict[str, Any]:
    seeing.must_be_honest(figure, *figure.legends)
    axes, behind = list(figure.get_axes())[:_MAX_AXES], figure.get_facecolor()
    artists = [text for part in (figure, *_subfigures(figure)) for text in part.texts]
    seeing.must_be_honest(*artists)
    texts = [words for text in artists if (words := seeing.words(text, behind))]
    return {
        "title": seeing.words(getattr(figure, "_suptitle", None), behind),
        "xlabel": seeing.words(getattr(figure, "_supxlabel", None), behind),
        "ylabel": seeing.words(getattr(figure, "_supylabel", None), behind),
        "texts": texts[:_MAX_TEXTS],
        "legends": [_legend(legend, behind) for legend in figure.legends[:4]],
        "axes": [_axes(one, axes, packer) for one in axes],
    }


def _subfigures(figure: Any) -> Iterator[Any]:
    """The parts of a figure, and theirs."""
    for part in figure.subfigs:
        yield part
        yield from _subfigures(part)


def _axes(axes: Any, all_axes: list[Any], packer: Packer) -> dict[str, Any]:
    from matplotlib.ticker import ScalarFormatter

    legend, behind = axes.get_legend(), axes.get_figure().get_facecolor()
    titles = (axes.title, axes._left_title, axes._right_title)
    labels = (axes.xaxis.label, axes.yaxis.label)
    seeing.must_be_honest(axes, axes.xaxis, axes.yaxis, *titles, *labels, *axes.texts, *([legend] if legend else []))
    box, part = seeing.place(axes), _part_of_a_figure(axes, behind)
    xlabel, ylabel = (
        seeing.words(axis.label, behind) if axes.axison and axis.get_visible() else ""
        for axis in (axes.xaxis, axes.yaxis)
    )
    shared = axes.get_shared_x_axes()
    return {
        "visible": bool(axes.get_visible()),
        "position": [round(_bounded(v), 4) for v in (box.x0, box.y0, box.x1, box.y1)],
        "xlabel": xlabel or part["xlabel"],
        "ylabel": ylabel or part["ylabel"],
        "title": next((words for title in titles if (words := seeing.words(title, behind)).strip()), part["title"]),
        "legend": _legends(axes, behind),
        "texts": [_placed(text) for text in axes.texts[:_MAX_TEXTS] if seeing.words(text, axes.get_facecolor())],
        "curves": _curves(axes, packer),
        "images": len(axes.images),
        "shares_x_with": [i for i, other in enumerate(all_axes) if other is not axes and shared.joined(axes, other)],
        "own_ticks": type(axes.xaxis.get_major_formatter()) is not ScalarFormatter,
        "x_limits": [_bounded(v) for v in axes.get_xlim()],
        "y_limits": [_bounded(v) for v in axes.get_ylim()],
        "scales": [axes.get_xscale(), axes.get_yscale()] if axes.name == "rectilinear" else ["", ""],
    }


def _part_of_a_figure(axes: Any, behind: Any) -> dict[str, str]:
    """What a subfigure says of all its panels; the figure as a whole speaks for itself."""
    part = axes.get_figure()
    whole = part is part.canvas.figure
    artists = {name: None if whole else getattr(part, f"_sup{name}", None) for name in ("title", "xlabel", "ylabel")}
    seeing.must_be_honest(part, *(artist for artist in artists.values() if artist is not None))
    return {name: seeing.words(artist, behind) for name, artist in artists.items()}


def _legends(axes: Any, behind: Any) -> list[dict[str, Any]] | None:
    """The legend of a panel, and those of the part of a figure that it stands in."""
    own, part = axes.get_legend(), axes.get_figure()
    around = [] if part is part.canvas.figure else list(part.legends[:4])
    seeing.must_be_honest(*around)
    entries = [_legend(legend, behind) for legend in around if legend.get_visible()]
    if own is not None and own.get_visible():
        entries.insert(0, _legend(own, axes.get_facecolor()))
    return [entry for legend in entries for entry in legend] if entries else None


def _curves(axes: Any, packer: Packer) -> list[dict[str, Any]]:
    room = min(_MAX_CURVES, _MAX_CURVES_IN_ALL - len(packer.arrays) // 2)
    curves = [_line(line, axes, packer) for line in axes.get_lines()[: max(room, 0)]]
    others = ((artist, drawn) for artist in (*axes.collections, *axes.patches) for drawn in _drawn_by(artist))
    for artist, (x, y, colour) in itertools.islice(others, max(room - len(curves), 0)):
        curves.append(_curve(artist, x, y, colour, packer) | _ink_of(artist, colour))
    return curves


def _drawn_by(artist: Any) -> Iterator[tuple[np.ndarray, np.ndarray, Any]]:
    """Points and colour of every curve of an artist that is no single line: a collection of lines, stairs, scattered points."""
    from matplotlib.collections import Collection, LineCollection
    from matplotlib.patches import StepPatch

    if isinstance(artist, Collection | StepPatch):
        seeing.must_be_honest(artist)
    if isinstance(artist, LineCollection):
        colours = itertools.cycle(artist.get_edgecolor())
        for segment, colour in zip(artist.get_segments(), colours, strict=False):
            if len(segment) > 3:  # not a mark, as `vlines` makes them
                yield segment[:, 0], segment[:, 1], colour
    elif isinstance(artist, StepPatch):
        values, edges, _ = artist.get_data()
        yield _plain_floats(edges)[:-1], _plain_floats(values), artist.get_edgecolor()
    elif isinstance(artist, Collection):
        offsets = _plain_floats(artist.get_offsets())
        if offsets.ndim == 2 and len(offsets) > 2:
            yield offsets[:, 0], offsets[:, 1], _face(artist)


def _plain_floats(values: Any) -> np.ndarray:
    """Numbers of an artist, masked ones as NaN."""
    filled: np.ndarray = np.ma.asarray(values, dtype=float).filled(np.nan)
    return filled


_FARTHEST = 1e12
_NOTHING = ("None", "none", "", " ", None)


def _line(line: Any, axes: Any, packer: Packer) -> dict[str, Any]:
    seeing.must_be_honest(line)
    x, y = (
        _plain_floats(get(orig=False)) for get in (line.get_xdata, line.get_ydata)
    )  # dates and names as they are drawn
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


def _stroke(line: Any) -> str:
    """What tells lines of one colour and style apart: dashes, width and opacity."""
    dashes = getattr(line, "_unscaled_dash_pattern", None)  # matplotlib has no getter for it
    return _short((dashes, line.get_linewidth(), line.get_alpha()))


def _curve(artist: Any, x: Any, y: Any, colour: Any, packer: Packer) -> dict[str, Any]:
    n = min(len(x), len(y))
    step = max(1, -(-n // _MAX_POINTS))
    return {
        "label": _short(str(artist.get_label())),
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
    """A coordinate as it can be told: what a filter that runs away makes of an axis has no end."""
    return float(np.clip(np.nan_to_num(float(value)), -_FARTHEST, _FARTHEST))


def _opacity(artist: Any) -> float:
    alpha = artist.get_alpha() if artist.get_visible() else 0.0
    return 1.0 if alpha is None or np.ndim(alpha) else float(alpha)


def _ink_of(artist: Any, colour: Any) -> dict[str, Any]:
    """The colours of a collection's points or of its lines, and how wide it draws."""
    from matplotlib.collections import Collection, LineCollection

    if isinstance(artist, Collection) and not isinstance(artist, LineCollection):
        sizes = artist.get_sizes() if hasattr(artist, "get_sizes") else ()
        inks = [*artist.get_facecolor()[:_MAX_POINTS], *artist.get_edgecolor()[:1]]
        return {"inks": _inks(inks), "width": float(np.sqrt(np.median(sizes))) if len(sizes) else 6.0}
    return {"inks": _inks([colour]), "width": _bounded(np.max(artist.get_linewidth(), initial=0.0))}


def _inks(colours: Iterable[Any]) -> list[str]:
    """Each colour once, with its opacity; none at all where there are so many that any may be meant."""
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
    """Entries as a reader sees them: the words, and the colour and stroke of the sample beside them."""
    handles = getattr(legend, "legend_handles", None) or getattr(legend, "legendHandles", [])
    pairs = list(zip(legend.get_texts()[:_MAX_CURVES], handles, strict=False))
    seeing.must_be_honest(*(artist for pair in pairs for artist in pair))
    return [_entry(text, handle, behind) for text, handle in pairs]


def _entry(text: Any, handle: Any, behind: Any) -> dict[str, Any]:
    line = hasattr(handle, "get_linestyle") and hasattr(handle, "get_color")
    colour = (
        handle.get_color() if line else (_face(handle) if hasattr(handle, "get_offsets") else handle.get_facecolor())
    )
    return {
        "text": seeing.words(text, behind),
        "colour": _colour(colour),
        "style": str(handle.get_linestyle())[:8] if line else "",
        "marker": str(handle.get_marker())[:8] if line and hasattr(handle, "get_marker") else "",
        "stroke": _stroke(handle) if line else "",
    }


def _placed(text: Any) -> dict[str, Any]:
    from matplotlib.text import Annotation

    where = text.xy if isinstance(text, Annotation) else text.get_position()  # an annotation may stand beside its point
    x, y = (float(v) if isinstance(v, int | float | np.number) else float("nan") for v in where)
    return {"text": _short(text.get_text()), "place": [_bounded(x), _bounded(y)], "colour": _colour(text.get_color())}


def _short(text: object) -> str:
    return str(text)[:200]
