"""Compatibility names: what earlier releases of NumPy and matplotlib had, for code written with an older release."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np


def install() -> None:
    """Add each removed name that is still missing, with the replacement that the release notes recommend."""
    _restore_numpy_names()
    _restore_matplotlib_names()


def _restore_numpy_names() -> None:
    """Add the names that NumPy removed: aliases of built-in types (1.24), of numbers and functions (2.0), and the rest (2.4)."""
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
    """Add the names that matplotlib removed: `set_window_title` (3.6), seaborn's styles (3.8), `cm.get_cmap` (3.9)."""
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
    """Add the names that `owner` lacks; a name that it has keeps its meaning in this release."""
    for name, value in names.items():
        if name not in vars(owner):
            setattr(owner, name, value)
