"""Names that earlier releases of the lab's packages had: what runs on a student's desk may be older than what runs here."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


def install() -> None:
    """Put each name that has gone back in its place, as what the release notes say to use instead."""
    _restore_numpy_names()
    _restore_matplotlib_names()


def _restore_numpy_names() -> None:
    """NumPy 1.24 took the aliases of built-in types away, 2.0 those of numbers and functions, 2.4 the last of these."""
    types = {"float": float, "int": int, "complex": complex, "object": object, "float_": np.float64}
    types |= {"complex_": np.complex128, "bool8": np.bool_, "unicode_": np.str_, "string_": np.bytes_}
    numbers = dict.fromkeys(("Inf", "Infinity", "infty", "PINF"), np.inf) | {"NINF": -np.inf, "NaN": np.nan}
    functions = {
        "alltrue": np.all,
        "sometrue": np.any,
        "product": np.prod,
        "cumproduct": np.cumprod,
        "round_": np.round,
    }
    functions |= {"in1d": _in1d, "row_stack": np.vstack, "mat": np.asmatrix, "asfarray": _asfarray}
    if hasattr(np, "trapezoid"):
        functions["trapz"] = np.trapezoid
    _fill(sys.modules["numpy"], {**types, **numbers, **functions})


def _in1d(values: Any, others: Any, **options: Any) -> np.ndarray:
    return np.isin(np.ravel(values), others, **options)


def _asfarray(values: Any, dtype: Any = np.float64) -> np.ndarray:
    return np.asarray(values, dtype if np.issubdtype(dtype, np.inexact) else np.float64)


def _restore_matplotlib_names() -> None:
    """Matplotlib 3.8 took seaborn's styles away but for those of its version 0.8, 3.6 a canvas' title, 3.9 a way to colour maps."""
    import matplotlib as mpl
    from matplotlib import cm, style
    from matplotlib.backend_bases import FigureCanvasBase

    for name in list(style.library):
        if name.startswith("seaborn-v0_8"):
            style.library.setdefault(name.replace("-v0_8", "", 1), style.library[name])
    _fill(cm, {"get_cmap": lambda name=None, lut=None: _colour_map(mpl, name, lut)})
    _fill(FigureCanvasBase, {"set_window_title": lambda canvas, title: None})


def _colour_map(mpl: Any, name: Any, lut: int | None) -> Any:
    found = name if isinstance(name, mpl.colors.Colormap) else mpl.colormaps[name or mpl.rcParams["image.cmap"]]
    return found if lut is None else found.resampled(lut)


def _fill(owner: Any, names: dict[str, Any]) -> None:
    """Add only missing names: an existing one is this release's own meaning of the name."""
    for name, value in names.items():
        if name not in vars(owner):
            setattr(owner, name, value)
