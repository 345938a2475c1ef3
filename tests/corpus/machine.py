"""A machine like a student's, for our own samples: it runs their files and looks at what they draw. Not a wall."""

from __future__ import annotations

import builtins
import importlib
import importlib.util
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import time
import types
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import mujoco
import mujoco.viewer
import numpy as np
from matplotlib.figure import Figure

REAL_MODEL = Path(__file__).resolve().parents[2] / "reference" / "models" / "humanoid-sensors.xml"
SHEET_MODEL = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"


def patch(saved: list[dict[str, Any]]) -> None:
    """Answers for what a student's machine has and a server has not: a keyboard, a screen, a notebook, the path of the model."""
    builtins.input = lambda prompt="": ""
    builtins.get_ipython = Shell  # type: ignore[attr-defined]
    load, stat, read = mujoco.MjModel.from_xml_path, os.stat, io.open

    def there(path: Any) -> Any:
        named = isinstance(path, str | Path) and str(path).endswith("humanoid-sensors.xml")
        return str(REAL_MODEL) if named and not os.access(path, os.R_OK) else path

    mujoco.MjModel.from_xml_path = staticmethod(lambda path, *rest: load(str(there(path)), *rest))
    vars(os)["stat"] = lambda path, **options: stat(there(path), **options)
    vars(io)["open"] = lambda path, mode="r", *rest, **options: read(there(path) if "r" in mode else path, mode, *rest, **options)
    plt.switch_backend("Agg")
    pyplot: Any = plt
    mpl.use = pyplot.switch_backend = lambda *a, **k: None
    plt.show = lambda *a, **k: plt.close("all")  # a closed window takes its figure along
    plt.pause = lambda *a, **k: None
    time.sleep = lambda s: None

    mujoco.viewer.launch_passive = Window
    os.system = lambda command: 0  # what is to be installed is there
    subprocess.check_call = lambda *a, **k: 0
    subprocess.run = lambda *a, **k: subprocess.CompletedProcess(a, 0, "", "")
    original = Figure.savefig

    def savefig(self: Figure, *args: Any, **kwargs: Any) -> Any:
        answer = original(self, *args, **kwargs)
        saved.append(figure_facts(self, kwargs.get("dpi", self.dpi)))
        return answer

    Figure.savefig = savefig  # type: ignore[method-assign]


class Window:
    """A viewer's window that stays open."""

    def __init__(self, model: Any, data: Any, **options: Any) -> None:
        self.cam, self.opt, self.user_scn = mujoco.MjvCamera(), mujoco.MjvOption(), mujoco.MjvScene(model, 100)

    def is_running(self) -> bool:
        return True

    def sync(self) -> None:
        pass

    close = sync

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *rest: Any) -> None:
        pass

    def lock(self) -> Any:
        return self


class Shell:
    """What a notebook's code is run by."""

    def __getattr__(self, name: str) -> Any:
        return lambda *a, **k: []

    def run_cell_magic(self, name: str, line: str, cell: str) -> None:
        exec(cell, sys._getframe(1).f_globals)


def figure_facts(figure: Figure, dpi: float) -> dict[str, Any]:
    texts = [t.get_text() for t in figure.findobj(mpl.text.Text) if t.get_text().strip()]
    curves = []
    for axes in figure.axes:
        for line in axes.get_lines():
            x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
            if len(x) > 2:
                curves.append((x, y))
        for points in axes.collections:
            if len(getattr(points, "get_offsets", list)()) > 2:
                curves.append(tuple(np.asarray(points.get_offsets()).T))
    labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
    parts: list[Any] = [figure, *figure.subfigs]  # the words of a whole figure have no public getter in old Matplotlib
    for part in parts:
        labels += [text.get_text() for text in (part._supxlabel, part._supylabel) if text]
    legends = [legend for axes in figure.axes if (legend := axes.get_legend())] + list(figure.legends)
    return {
        "curves": curves,
        "labels": [label for label in labels if label.strip()],
        "titles": [a.get_title() for a in figure.axes if a.get_title()] + [part._suptitle.get_text() for part in parts if part._suptitle],
        "legend": [t.get_text() for legend in legends for t in legend.get_texts()],
        "beside": [t.get_text() for axes in figure.axes for t in axes.texts],
        "texts": texts,
        "pixels": (figure.get_size_inches() * dpi).tolist(),
        "panels": len(figure.axes),
    }


def unpacked(path: Path, into: Path) -> Path:
    """The folder with the submission's files: archives opened, descended to where the Python files are."""
    if path.is_file() and path.suffix == ".zip":
        zipfile.ZipFile(path).extractall(into)
        path = into
    elif path.is_file():
        with tarfile.open(path) as archive:
            archive.extractall(into, filter="data")
        path = into
    inner = list(path.glob("*.zip"))
    if inner and not list(path.glob("*.py")):
        return unpacked(inner[0], into / "inner")
    found = sorted((p for ext in ("*.py", "*.ipynb") for p in path.rglob(ext)), key=lambda p: len(p.parts))
    return found[0].parent if found else path


# ---------------------------------------------------------------- running the files


def cells(path: Path) -> Iterator[str]:
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        source = "".join(cell["source"])
        if source.startswith("%%writefile"):
            head, body = source.split("\n", 1)
            (path.parent / head.split()[1]).write_text(body, encoding="utf-8")
            continue
        lines = source.split("\n")
        yield "\n".join("" if re.match(r"\s*([%!?]|\w+\s*=\s*!)|.*\w\?$", line) else line for line in lines)


def run_notebook(path: Path) -> dict[str, Any]:
    module = types.ModuleType("notebook")
    sys.modules["notebook"] = module
    for source in cells(path):
        try:
            exec(compile(source, path.name, "exec"), module.__dict__)
        except (Exception, SystemExit) as problem:
            print("cell:", repr(problem), file=sys.stderr)
    return module.__dict__


def run_scripts(folder: Path) -> list[dict[str, Any]]:
    """Run each file as a script and each notebook; their namespaces, one a file."""
    spaces = [run_notebook(path) for path in sorted(folder.glob("*.ipynb"))]
    package = (folder / "__init__.py").exists()
    sys.path[:0] = [str(folder.parent), str(folder.parent.parent)] if package else [str(folder)]
    if package:
        importlib.import_module(folder.name)
    names = ["imu_reader", "noisy_imu", "filters"]
    names += [p.stem for p in sorted(folder.glob("*.py")) if p.stem not in names and not p.stem.startswith(("test_", "__", "conftest"))]
    for name in names:
        if (folder / f"{name}.py").exists():
            spaces.append(_run_one(folder, name, package))
            plt.close("all")
    return spaces


def _run_one(folder: Path, name: str, package: bool) -> dict[str, Any]:
    """The namespace of a file that was imported and then run as a script; what it defined before an error counts."""
    sys.argv = [f"{name}.py"]
    full = f"{folder.name}.{name}" if package else name
    module = _executed(folder, full, name)
    _executed(folder, "__main__", name, package=full.rpartition(".")[0] or None)
    return vars(module)


def _executed(folder: Path, full: str, name: str, package: str | None = None) -> types.ModuleType:
    path = folder / f"{name}.py"
    spec = importlib.util.spec_from_file_location(full, path)
    if spec is None:
        raise ImportError(f"no way to import {path}")
    module = importlib.util.module_from_spec(spec)
    if full != "__main__":
        sys.modules[full] = module
    elif package:
        module.__package__ = package
    try:
        exec(compile(path.read_bytes(), str(path), "exec"), module.__dict__)
    except (Exception, SystemExit) as problem:
        print(f"{name} as {full}:", repr(problem), file=sys.stderr)
    return module
