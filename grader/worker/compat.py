"""Compatibility names: what other releases of NumPy, SciPy and matplotlib have, so that code written for one of them runs.

Names can be added, but no method of an array, and no conversion: `int` of an array of one element raises from NumPy 2.4 on, which
is why the package requires an earlier one.
"""

from __future__ import annotations

import math
import sys
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

import numpy as np


def install() -> None:
    """Add names of other releases that the installed NumPy, SciPy and matplotlib lack, so that code for those releases runs."""
    _restore_numpy_names()
    _restore_matplotlib_names()
    for name in _SCIPY_NAMES:
        if name in sys.modules:
            _restore_scipy_names(sys.modules[name])
    sys.meta_path.insert(0, _ScipyFinder)


def _restore_numpy_names() -> None:
    """Add the names that NumPy removed: aliases of built-in types (1.24), of numbers and functions (2.0), `trapz` and others (2.4).

    Add the names that NumPy 2.0 brought, such as `concat`, where an earlier release is installed.
    """
    types: dict[str, Any] = {
        "float": float,
        "int": int,
        "complex": complex,
        "object": object,
        "str": str,
        "bool": np.bool_,
    }
    types |= {"float_": np.float64, "complex_": np.complex128, "cfloat": np.complex128, "bool8": np.bool_}
    types |= {"unicode_": np.str_, "string_": np.bytes_, "math": math}
    if exceptions := getattr(np, "exceptions", None):  # since 1.25
        types |= {
            name: getattr(exceptions, name) for name in ("AxisError", "ComplexWarning", "VisibleDeprecationWarning")
        }
    numbers = dict.fromkeys(("Inf", "Infinity", "infty", "PINF"), np.inf) | {"NINF": -np.inf, "NaN": np.nan}
    functions: dict[str, Any] = {
        "alltrue": np.all,
        "sometrue": np.any,
        "product": np.prod,
        "cumproduct": np.cumprod,
        "round_": np.round,
    }
    functions |= {"in1d": _in1d, "row_stack": np.vstack, "mat": np.asmatrix, "asfarray": _asfarray, "disp": _display}
    functions |= {"acos": np.arccos, "asin": np.arcsin, "atan": np.arctan, "atan2": np.arctan2, "pow": np.power}
    functions |= {"concat": np.concatenate, "permute_dims": np.transpose}
    functions["trapz"] = functions["trapezoid"] = getattr(np, "trapezoid", None) or vars(np)["trapz"]
    _fill(sys.modules["numpy"], {**types, **numbers, **functions})


def _in1d(values: Any, others: Any, **options: Any) -> np.ndarray:
    return np.isin(np.ravel(values), others, **options)


def _asfarray(values: Any, dtype: Any = np.float64) -> np.ndarray:
    return np.asarray(values, dtype if np.issubdtype(dtype, np.inexact) else np.float64)


def _display(text: Any, device: Any = None, linefeed: bool = True) -> None:
    print(text, file=device, end="\n" if linefeed else "")


def _restore_matplotlib_names() -> None:
    """Add the names that matplotlib removed, so that plots written for an earlier release are drawn.

    These are `set_window_title` (3.6), seaborn's styles (3.8), `cm.get_cmap` and `legendHandles` (3.9), `tostring_rgb` (3.10).
    """
    import matplotlib as mpl
    from matplotlib import cm, style
    from matplotlib.backend_bases import FigureCanvasBase
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.legend import Legend

    for name in list(style.library):
        if name.startswith("seaborn-v0_8"):
            style.library.setdefault(name.replace("-v0_8", "", 1), style.library[name])
    _fill(cm, {"get_cmap": lambda name=None, lut=None: _colour_map(mpl, name, lut)})
    _fill(FigureCanvasBase, {"set_window_title": lambda canvas, title: None})
    _fill(FigureCanvasAgg, {"tostring_rgb": lambda canvas: np.asarray(canvas.buffer_rgba())[..., :3].tobytes()})
    _fill(Legend, {"legendHandles": property(lambda legend: legend.legend_handles)})


def _colour_map(mpl: Any, name: Any, lut: int | None) -> Any:
    found = name if isinstance(name, mpl.colors.Colormap) else mpl.colormaps[name or mpl.rcParams["image.cmap"]]
    return found if lut is None else found.resampled(lut)


_SCIPY_NAMES = {
    "scipy.integrate": {"trapz": "trapezoid", "simps": "simpson", "cumtrapz": "cumulative_trapezoid"},
    "scipy.signal": dict.fromkeys(
        ("hann", "hamming", "blackman", "gaussian", "bartlett", "boxcar", "kaiser"), "windows"
    ),
}
"""Names that SciPy removed (1.13, 1.14), by module: the name that is there now, or the module into which they moved."""


class _ScipyFinder:
    """Import finder that adds removed names to a SciPy module when student code imports it; to import all of SciPy takes long."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name in _SCIPY_NAMES else None
        if spec is not None:
            loader: Any = spec.loader
            really = loader.exec_module

            def exec_module(module: ModuleType) -> None:
                really(module)
                _restore_scipy_names(module)

            loader.exec_module = exec_module
        return spec


def _restore_scipy_names(module: ModuleType) -> None:
    present = {old: getattr(module, new) for old, new in _SCIPY_NAMES[module.__name__].items()}
    _fill(
        module, {old: getattr(found, old) if isinstance(found, ModuleType) else found for old, found in present.items()}
    )


def _fill(owner: Any, names: dict[str, Any]) -> None:
    """Add those of `names` that a module or class lacks; a name that it has keeps its meaning in the installed release."""
    for name, value in names.items():
        if name not in vars(owner):
            setattr(owner, name, value)
