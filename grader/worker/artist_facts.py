"""Facts about matplotlib artists that matplotlib itself must tell, not student code: a panel's place, and text that can be read.

Student code could make `get_ylabel` return a label that is not drawn. So matplotlib's own methods are restored while facts are
taken, and an artist of a class that overrides such a method is rejected.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from . import faults

_SMALLEST_FONT = 3.0
_NEAR = 0.04  # largest invisible difference of two colours, each channel 0 to 1
_ASKED = frozenset(["axes", "collections", "draw", "legend_handles", "legends", "lines", "texts", "xy"])
_ASKED |= {"__class__", "__getattr__", "__getattribute__"}


class OverriddenArtistError(ValueError):
    """Exception: student code overrides a method of a matplotlib artist, so what the artist tells may not be what it draws."""


# --- matplotlib as it was ------------------------------------------------------------------------------------------------

_CLASSES: dict[type, dict[str, Any]] = {}


def remember_classes() -> None:
    """Record the members of matplotlib's classes before student code runs, so that `original_classes` can restore them."""
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
    """Record the present members of these classes anew, after we replaced some, so that `original_classes` keeps our versions."""
    _CLASSES.update((kind, dict(vars(kind))) for kind in kinds)


@contextlib.contextmanager
def original_classes() -> Iterator[None]:
    """Give matplotlib's classes their own methods back while a figure is read; on exit put the student's changes in again."""
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


def reject_overrides(*artists: Any) -> None:
    """Raise OverriddenArtistError if student code overrides a member of `artists` that the grader reads: an artist may then lie."""
    for artist in artists:
        strange = [kind for kind in type(artist).__mro__ if kind not in _CLASSES and kind.__module__ != "builtins"]
        own = [name for kind in strange if not _generated(kind) for name in vars(kind) if _is_asked(name)]
        own += [name for name, value in vars(artist).items() if _is_asked(name) and callable(value)]
        if own:
            raise OverriddenArtistError(f"{type(artist).__name__} overrides {own[0]}"[:200])


def _is_asked(name: str) -> bool:
    """Return whether the grader reads artist members of this name (getters and a few others), which nobody may override."""
    return name.startswith("get_") or name in _ASKED


def _generated(kind: type) -> bool:
    """Return whether a class is matplotlib's own, loaded after `remember_classes`; what it overrides is not the student's."""
    return kind.__module__.startswith(("matplotlib.", "mpl_toolkits.")) and "<locals>" not in kind.__qualname__


# --- what is in the picture ----------------------------------------------------------------------------------------------


def place(axes: Any) -> Any:
    """Return a panel's position (a `Bbox`) in fractions of the whole figure, even if the panel lies in a subfigure."""
    return axes.bbox.transformed(axes.get_figure().canvas.figure.transFigure.inverted())


def readable_text(text: Any, behind: Any) -> str:
    """Return a `Text` artist's text, at most 200 characters; "" if it is None, hidden, tiny or of the colour `behind` it."""
    from matplotlib.colors import to_rgba

    if text is None or not text.get_visible() or float(text.get_fontsize()) < _SMALLEST_FONT:
        return ""
    alpha = text.get_alpha()
    try:
        drawn, ground = np.array(to_rgba(text.get_color())), np.array(to_rgba(behind))
    except (ValueError, TypeError):
        return faults.mask_addresses(str(text.get_text()))[:200]
    strength = float(drawn[3]) * (1.0 if alpha is None else float(alpha))
    lost = ground[3] > 0.5 and np.abs(drawn[:3] - ground[:3]).max() <= _NEAR
    return "" if strength <= 0.05 or lost else faults.mask_addresses(str(text.get_text()))[:200]
