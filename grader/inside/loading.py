"""Loading a submission: writing its files into the scratch folder and importing them, each with what it got wrong.

A file that stops with an error keeps what it defined before; a notebook is run cell by cell, and a bad cell spoils only
itself. Where the grader sends sound stand-ins for broken parts, they take the place of the student's own definitions.
"""

from __future__ import annotations

import ast
import builtins
import contextlib
import importlib.machinery
import importlib.util
import inspect
import os
import re
import shlex
import sys
import types
from pathlib import Path
from typing import Any

from . import drawing, faults, figures, notebooks, packages, world

_REQUIRED = ("imu_reader", "noisy_imu", "filters")
_FOLDER = "course/labs/lab-04-01"  # programs look for what they need some folders above their own
_STANDIN_HOOK = "__sound_standin__"
_LONGEST_NAME = 200
_RELATIVE = re.compile(r"\bfrom[\s\\]*\.")


class _State:
    """What this worker knows of its one submission."""

    def __init__(self) -> None:
        self.folder = ""
        self.paths: list[str] = []
        self.standins: dict[str, Any] = {}
        self.modules: dict[str, types.ModuleType] = {}
        self.errors: dict[str, dict[str, Any]] = {}


STATE = _State()


def submit(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Take the submission's files, the lab model and the stand-ins; nothing of the student's runs yet.

    Answers with the paths of all files, those among them that a notebook writes with ``%%writefile``.
    """
    os.makedirs(_FOLDER, exist_ok=True)
    os.chdir(_FOLDER)
    STATE.folder = os.getcwd()
    world.settle(STATE.folder)
    for path, key, levels_above in fields["files"]:
        _write(path, arrays[key].tobytes())
        if 0 < levels_above <= _FOLDER.count("/"):
            _write("../" * levels_above + path, arrays[key].tobytes())  # for who opens it by way of its own folder
        STATE.paths.append(path)
    for path in [path for path in STATE.paths if path.endswith(".ipynb")]:
        _write_cells_to_files(path, fields["withheld"])
    world.furnish(fields["lab_model"], run_magic=_run_magic)
    world.seed(fields["seed"])
    figures.watch(read_back=drawing.reads_pictures_back(arrays[key].tobytes() for _, key, _ in fields["files"]))
    _prepare_imports()
    _define_standins(fields["standins"])
    return {"paths": STATE.paths}, {}


def load(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Import one file (or run one notebook) and tell what it defines and what went wrong."""
    del arrays
    path: str = fields["path"]
    with world.at_home(STATE.folder):
        module = _run_notebook(path) if path.endswith(".ipynb") else _import_file(path)
    seen, facts = figures.RECORDER.take()
    names = [n for n in vars(module) if not n.startswith("_") and len(n) <= _LONGEST_NAME] if module else []
    answer = {"names": sorted(names)[:500], "errors": _errors_of(path), "figures": seen}
    return answer | {"pictures": figures.written_pictures(STATE.folder)}, facts


def run_script(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Run one file as `python FILE` does, and tell which figures it saved."""
    del arrays
    path: str = fields["path"]
    error = None
    with world.at_home(STATE.folder):
        module = sys.modules["__main__"] = _main_module(path)
        try:
            _run(_compile(Path(path).read_bytes(), path), vars(module))
        except BaseException as raised:  # whatever student code raises, SystemExit included
            error = faults.describe(raised)
    seen, facts = figures.RECORDER.take()
    return {"error": error, "figures": seen, "pictures": figures.written_pictures(STATE.folder)}, facts


def _main_module(path: str) -> types.ModuleType:
    module = types.ModuleType("__main__")
    module.__file__ = str(Path(STATE.folder, path))
    return module


def outline(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The names that each file or notebook defines at its top level, read from its text; nothing of it runs."""
    del fields, arrays
    return {"names": {path: _defined(path) for path in STATE.paths if path.endswith((".py", ".ipynb"))}}, {}


def _defined(path: str) -> list[str]:
    content = Path(STATE.folder, path).read_bytes()
    try:
        texts = notebooks.code_cells(content) if path.endswith(".ipynb") else [_decode(content)]
    except (ValueError, SyntaxError, RecursionError):
        return []
    names: list[str] = []
    for text in texts:
        try:
            names += [name for node in ast.parse(text).body for name in _bound(node)]
        except (ValueError, SyntaxError, RecursionError, MemoryError):
            continue
    return sorted({name for name in names if len(name) <= _LONGEST_NAME})[:300]


def _bound(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.Assign):
        return [t.id for t in node.targets if isinstance(t, ast.Name)]
    return []


def find(name: str, path: str) -> Any:
    """The object called `name` in the loaded file `path`; KeyError where the grader asks for what is not there."""
    return vars(STATE.modules[path])[name]


def _write(path: str, content: bytes) -> None:
    target = Path(STATE.folder, path)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)


# --- importing -----------------------------------------------------------------------------------------------------------


class _Loader(importlib.machinery.SourceFileLoader):
    """Imports a student's file; what it defined before an error counts for the file that imports it."""

    def get_code(self, fullname: str) -> types.CodeType:
        path = Path(self.path)
        return _compile(path.read_bytes(), path.relative_to(STATE.folder).as_posix())

    def exec_module(self, module: types.ModuleType) -> None:
        path = Path(self.path).relative_to(STATE.folder).as_posix()
        STATE.modules[path] = module
        try:
            _run(self.get_code(module.__name__), vars(module))
        except BaseException as raised:  # whatever student code raises, SystemExit included
            STATE.errors[path] = faults.describe(raised)
            vars(module).setdefault("__getattr__", _absent_names(path))
            if any(_home_of(name) == module.__name__ for name in STATE.standins):
                vars(module).update({n: v for n, v in _sheet_names().items() if n not in vars(module)})
        for name, standin in STATE.standins.items():
            if path.removesuffix(".py") == _home_of(name) and name not in vars(module):
                setattr(module, name, standin)


def _absent_names(home: str) -> Any:
    """A module's ``__getattr__``: what a broken file did not define can be imported from it, and fails where it is used."""

    def __getattr__(name: str) -> Any:  # noqa: N807 - PEP 562
        if name.startswith("__"):
            raise AttributeError(name)
        return _Absent(f"{home} did not define {name}")

    return __getattr__


class _Absent:
    """Stands for a name that a broken partner file did not get to define."""

    def __init__(self, why: str) -> None:
        self._why = why

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        raise NameError(self._why)

    def __getattr__(self, name: str) -> Any:
        raise NameError(self._why) if not name.startswith("__") else AttributeError(name)


class _MissingPartner(importlib.machinery.SourceFileLoader):
    """Stands for a required file that was not handed in, once its own checks are over."""

    def get_code(self, fullname: str) -> types.CodeType:
        return compile("", self.path, "exec")

    def exec_module(self, module: types.ModuleType) -> None:
        vars(module).update(_sheet_names())
        vars(module).update({n: s for n, s in STATE.standins.items() if _home_of(n) == module.__name__})
        vars(module)["__getattr__"] = _absent_names(f"{module.__name__}.py")


class _UnderAnotherName(_MissingPartner):
    """Stands for a required file whose names another file of the submission defines."""

    def exec_module(self, module: types.ModuleType) -> None:
        found = _run_notebook(self.path) if self.path.endswith(".ipynb") else _import_file(self.path)
        vars(module).update({n: v for n, v in vars(found).items() if not n.startswith("__")} if found else {})


class _PartnerFinder:
    """Finds the required files that were not handed in under their names."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> Any:
        if path is not None or name not in _REQUIRED:
            return None
        if any(_home_of(n) == name for n in STATE.standins):
            return importlib.util.spec_from_loader(name, _MissingPartner(name, f"{name}.py"))
        codes = sorted((p for p in STATE.paths if p.endswith((".py", ".ipynb"))), key=lambda p: (p.count("/"), p))
        other = next((p for p in codes if any(_home_of(n) == name and n in _KNOWN for n in _defined(p))), None)
        return other and importlib.util.spec_from_loader(name, _UnderAnotherName(name, other))


def _sheet_names() -> dict[str, Any]:
    """What ``from imu_reader import *`` brings along in the sheet's own code."""
    import matplotlib.pyplot as plt
    import mujoco
    import numpy as np

    model = mujoco.MjModel.from_xml_path(world.LAB_MODEL_NAME)
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, f"torso_{k}") for k in ("accelerometer", "gyroscope")]
    names = {"np": np, "numpy": np, "mujoco": mujoco, "plt": plt, "model": model, "data": mujoco.MjData(model)}
    return names | dict(zip(("accel_id", "gyro_id"), ids, strict=True))


_KNOWN = ("get_imu_readings", "simulate_and_collect", "plot_imu_data", "NoisyIMU", "LowPassFilter")


def _home_of(name: str) -> str:
    return {"NoisyIMU": "noisy_imu", "LowPassFilter": "filters"}.get(name, "imu_reader")


def _prepare_imports() -> None:
    def hook(path: str) -> Any:
        if not Path(path).is_relative_to(STATE.folder):
            raise ImportError(path)
        return importlib.machinery.FileFinder(path, (_Loader, [".py"]))

    sys.path_hooks.insert(0, hook)
    sys.path.insert(0, STATE.folder)
    sys.meta_path += [_PartnerFinder, packages.PackageFinder(_own_packages, _load_init)]
    sys.dont_write_bytecode = True
    sys.argv = ["lab.py"]


def _own_packages() -> set[str]:
    code = [path for path in STATE.paths if path.endswith(".py")]
    return packages.spoken_of((Path(STATE.folder, path).read_text("utf-8", "replace") for path in code), code)


def _load_init(name: str) -> _Loader | None:
    init = Path(STATE.folder, "__init__.py")
    return _Loader(name, str(init)) if init.exists() else None


def _import_file(path: str) -> types.ModuleType | None:
    name = Path(path).stem
    folder = Path(STATE.folder, path).parent
    if path in STATE.modules:
        return STATE.modules[path]
    if str(folder) not in sys.path:
        sys.path.insert(1, str(folder))
    spec = importlib.util.spec_from_file_location(
        name, Path(STATE.folder, path), loader=_Loader(name, str(Path(STATE.folder, path)))
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if name.isidentifier() and name not in sys.modules:
        sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _errors_of(path: str) -> list[dict[str, Any]]:
    return [{"path": p, **error} for p, error in STATE.errors.items() if p == path or p.startswith(f"{path}:")][:20]


def _run(code: types.CodeType, names: dict[str, Any]) -> None:
    """Run code among these names, with the built-in functions that all modules share: the harness's are its own."""
    names["__builtins__"] = vars(builtins)
    awaiting = eval(code, names)
    if code.co_flags & inspect.CO_COROUTINE:
        import asyncio  # few cells wait for anything

        asyncio.run(awaiting)


# --- compiling -----------------------------------------------------------------------------------------------------------


def _decode(source: bytes) -> str:
    """Source text by its declared encoding; bytes that are not UTF-8 and declare nothing are taken for Latin-1."""
    try:
        return importlib.util.decode_source(source)
    except (UnicodeDecodeError, SyntaxError):
        if source.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in source:
            raise SyntaxError("the file is not UTF-8 text (it looks like UTF-16): save it as UTF-8") from None
        return source.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")


def _compile(source: bytes, path: str, flags: int = 0) -> types.CodeType:
    text = _decode(source)
    own = faults.own_name(path)
    _remember_lines(own, text)
    source_or_tree = _adapted(ast.parse(text, own), path) if STATE.standins or _RELATIVE.search(text) else text
    code: types.CodeType = compile(source_or_tree, own, "exec", flags, dont_inherit=True)
    return code


def _remember_lines(own: str, text: str) -> None:
    import linecache

    linecache.cache[own] = (len(text), None, text.splitlines(keepends=True), own)


def _adapted(tree: ast.Module, path: str) -> ast.Module:
    """Let files that were written as a package import each other, and put stand-ins after the definitions they replace."""
    packages.without_dots(tree, path)
    if STATE.standins:
        body: list[ast.stmt] = []
        for node in tree.body:
            body += [node, *_replacements(node)]
        tree.body = body
    return ast.fix_missing_locations(tree)


def _replacements(node: ast.stmt) -> list[ast.stmt]:
    names = [name for name in _bound(node) if name in STATE.standins]
    lines = [f"{name} = __import__('builtins').{_STANDIN_HOOK}[{name!r}]" for name in names]
    made = [statement for line in lines for statement in ast.parse(line).body]
    return [ast.copy_location(statement, node) for statement in made]


def _define_standins(sources: dict[str, str]) -> None:
    space = types.ModuleType("standins")
    for name, source in sources.items():
        _run(compile(source, "<stand-in>", "exec"), vars(space))
        STATE.standins[name] = vars(space)[name]
    setattr(builtins, _STANDIN_HOOK, STATE.standins)


# --- notebooks -----------------------------------------------------------------------------------------------------------


def _run_notebook(path: str) -> types.ModuleType:
    if path in STATE.modules:
        return STATE.modules[path]
    module = types.ModuleType("__main__")
    STATE.modules[path] = module
    _run_cells(path, vars(module))
    return module


def _run_cells(path: str, names: dict[str, Any]) -> None:
    for number, source in enumerate(_cells(path), start=1):
        where = f"{path}:cell {number}"
        try:
            _run(_compile(source.encode("utf-8", "replace"), where, ast.PyCF_ALLOW_TOP_LEVEL_AWAIT), names)
        except BaseException as raised:  # whatever student code raises, SystemExit included
            STATE.errors[where] = faults.describe(raised)


def _run_magic(line: str, names: dict[str, Any]) -> None:
    """Do what ``%run FILE`` does: a notebook's cells run among the names of who asks, a program leaves its own there."""
    path = next(Path(word).as_posix() for word in shlex.split(line) if not word.startswith("-"))
    if path.endswith(".ipynb"):
        _run_cells(path, names)
        return
    program = _main_module(path)
    with contextlib.suppress(BaseException):  # whatever ends it, SystemExit included, does not end the notebook
        _run(_compile(Path(STATE.folder, path).read_bytes(), path), vars(program))
    names.update({name: value for name, value in vars(program).items() if not name.startswith("__")})


def _write_cells_to_files(path: str, withheld: list[str]) -> None:
    """Do what ``%%writefile NAME.py`` cells do, so that the files are there before anything is imported."""
    try:
        files = notebooks.files_written(Path(STATE.folder, path).read_bytes())
    except (ValueError, RecursionError):
        return
    for name, text in files.items():
        if name not in withheld and not Path(STATE.folder, name).exists():
            _write(name, text.encode("utf-8", "replace"))
            STATE.paths.append(name)


def _cells(path: str) -> list[str]:
    try:
        return notebooks.code_cells(Path(STATE.folder, path).read_bytes())
    except (ValueError, RecursionError) as error:
        STATE.errors[path] = {
            **faults.describe(error),
            "type": "SyntaxError",
            "message": "this is not a notebook that can be read",
        }
        return []
