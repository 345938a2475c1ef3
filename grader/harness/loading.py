"""Loading a submission: writing its files into the scratch folder and importing them, each with what it got wrong.

What a file or a notebook defines counts, whatever its other lines do: statements that fail are stepped over, see `stepping`.
Where the grader sends sound stand-ins for broken parts, they take the place of the student's own definitions.
"""

from __future__ import annotations

import ast
import builtins
import contextlib
import importlib.machinery
import importlib.util
import os
import re
import shlex
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from . import desktop, drawing, faults, gaps, newer, notebooks, packages, recorder, returning, spelling, stepping, world
from .lending import Lending

_FOLDER = "course/labs/lab-04-01"  # programs look for what they need some folders above their own
_RELATIVE = re.compile(r"\bfrom[\s\\]*\.")


class _State:
    """What this worker knows of its one submission."""

    def __init__(self) -> None:
        self.folder = ""
        self.paths: list[str] = []
        self.standins: dict[str, Any] = {}
        self.modules: dict[str, types.ModuleType] = {}
        self.unreadable: dict[str, dict[str, Any]] = {}
        self.stepper: stepping.Stepper
        self.homes: dict[str, str] = {}  # every name that is asked for, and the module that it is expected in
        self.required: tuple[str, ...] = ()  # the modules that others import from
        self.furniture: dict[str, Any] = {}
        # by file: what is asked for, and which method, with the name that it has there; who uses what the file does not import; who
        # lacks a return
        self.misspelt: dict[str, list[tuple[str, str]]] = {}
        self.other_methods: dict[str, dict[str, str]] = {}
        self.lent: dict[str, list[tuple[str, str]]] = {}
        self.unreturned: dict[str, dict[str, bool]] = {}
        self.sheet_names: Callable[[dict[str, Any]], dict[str, Any]] = lambda furniture: {}


STATE = _State()


def submit(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Take the submission's files, the robot and the stand-ins; nothing of the student's runs yet.

    Answers with the paths of all files, those among them that a notebook writes with ``%%writefile``.
    """
    skipped = {(path, number): why for path, number, why in fields["skipped"]}
    STATE.stepper = stepping.Stepper(skipped, tuple(fields["place"]), list(fields["homes"]))
    STATE.homes = {name: file.removesuffix(".py") for name, file in fields["homes"].items()}
    STATE.required = tuple(file.removesuffix(".py") for file in fields["required"])
    STATE.furniture = fields["furniture"]
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
    world.furnish(STATE.furniture, run_magic=_run_magic)
    world.seed(fields["seed"])
    recorder.watch(read_back=drawing.reads_pictures_back(arrays[key].tobytes() for _, key, _ in fields["files"]))
    _prepare_imports()
    _define_standins(fields["standins"])
    return {"paths": STATE.paths}, {}


def load(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Import one file (or run one notebook) and tell which of the wanted names it defines and what was stepped over."""
    del arrays
    path: str = fields["path"]
    with world.at_home(STATE.folder), stepping.limited(fields["within_s"]):
        module = _run_notebook(path) if path.endswith(".ipynb") else _import_file(path)
    seen, arrays = recorder.RECORDER.take(STATE.folder)
    answer: dict[str, Any] = {"names": STATE.stepper.defined(vars(module)) if module else []}
    answer["lent"] = STATE.lent.get(path, [])
    answer["misspelt"] = [*STATE.misspelt.get(path, []), *STATE.other_methods.get(path, {}).items()]
    answer["unreturned"] = [name for name, lacked in STATE.unreturned.get(path, {}).items() if lacked]
    return seen | answer | {"unreadable": _unreadable(path), "stepped_over": STATE.stepper.noted}, arrays


def run_script(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Run one file as `python FILE` does, and tell which figures it saved."""
    del arrays
    path: str = fields["path"]
    with world.at_home(STATE.folder), stepping.limited(fields["within_s"]):
        module = sys.modules["__main__"] = _main_module(path)
        _run_file(path, vars(module))
        desktop.end_program()
    seen, arrays = recorder.RECORDER.take(STATE.folder)
    error = _unreadable(path) or next((e for e in STATE.stepper.noted if e["path"] == path), None)
    return seen | {"error": error, "stepped_over": STATE.stepper.noted}, arrays


def _main_module(path: str) -> types.ModuleType:
    module = types.ModuleType("__main__")
    module.__file__ = str(Path(STATE.folder, path))
    return module


def outline(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Which of the wanted names each file or notebook defines at its top level, read from its text; nothing of it runs."""
    del fields, arrays
    code = [path for path in STATE.paths if path.endswith((".py", ".ipynb"))]
    return {"names": {path: sorted(_defined(path).intersection(STATE.stepper.wanted)) for path in code}}, {}


def _defined(path: str) -> set[str]:
    content = Path(STATE.folder, path).read_bytes()
    try:
        texts = notebooks.code_cells(content) if path.endswith(".ipynb") else [_decode(content)]
    except (ValueError, SyntaxError, RecursionError):
        return set()
    names: set[str] = set()
    nodes: list[ast.stmt] = []
    for text in texts:
        try:
            parsed = ast.parse(text).body
            names.update(name for node in parsed for name in stepping.bound(node))
            nodes += parsed
        except SyntaxError:
            names.update(gaps.names_in(text))
        except (ValueError, RecursionError, MemoryError):
            continue
    return names.union(name for name, _ in spelling.slips(nodes, _at_home_in(path)))


def find(name: str, path: str) -> Any:
    """The object called `name` in the loaded file `path`; KeyError where the grader asks for what is not there."""
    return vars(STATE.modules[path])[name]


def _write(path: str, content: bytes) -> None:
    target = Path(STATE.folder, path)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)


# --- importing -----------------------------------------------------------------------------------------------------------


class _Loader(importlib.machinery.SourceFileLoader):
    """Imports a student's file; what it defines beside an error counts for the file that imports it."""

    def exec_module(self, module: types.ModuleType) -> None:
        path = Path(self.path).relative_to(STATE.folder).as_posix()
        STATE.modules[path] = module
        if any(STATE.homes.get(name) == module.__name__ for name in STATE.standins):
            vars(module).update(STATE.sheet_names(STATE.furniture))  # what a broken file lacks, others have from it
        if not _run_file(path, vars(module)):
            vars(module).setdefault("__getattr__", _absent_names(path))
        _stand_in(path, vars(module))


def _stand_in(path: str, names: dict[str, Any]) -> None:
    """Put stand-ins where a file lacks a name: its definition failed, it was deleted again, or it should be there."""
    lacking = [name for name in STATE.standins if name not in names]
    own = _defined(path) if lacking else set()
    for name in lacking:
        home = f"{STATE.homes.get(name)}.py"
        if home == path or home not in STATE.paths or name in own:
            names[name] = STATE.standins[name]


def _absent_names(home: str) -> Any:
    """A module's ``__getattr__``: what a broken file did not define can be imported from it, and fails where it is used."""

    def __getattr__(name: str) -> Any:  # noqa: N807 - PEP 562
        if name.startswith("__"):
            raise AttributeError(name)
        return stepping.NotThere(lambda: NameError(f"{home} did not define {name}"))

    return __getattr__


class _MissingPartner(importlib.machinery.SourceFileLoader):
    """Stands for a required file that was not handed in, once its own checks are over."""

    def get_code(self, fullname: str) -> types.CodeType:
        return compile("", self.path, "exec")

    def exec_module(self, module: types.ModuleType) -> None:
        vars(module).update(STATE.sheet_names(STATE.furniture))
        vars(module).update({n: s for n, s in STATE.standins.items() if STATE.homes.get(n) == module.__name__})
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
        if path is not None or name not in STATE.required:
            return None
        if any(STATE.homes.get(n) == name for n in STATE.standins):
            return importlib.util.spec_from_loader(name, _MissingPartner(name, f"{name}.py"))
        codes = sorted((p for p in STATE.paths if p.endswith((".py", ".ipynb"))), key=lambda p: (p.count("/"), p))
        other = next((p for p in codes if any(STATE.homes.get(n) == name for n in _defined(p))), None)
        return other and importlib.util.spec_from_loader(name, _UnderAnotherName(name, other))


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
    return packages.spoken_of(
        (Path(STATE.folder, path).read_text("utf-8", "replace") for path in code), code, STATE.required
    )


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


def _run_file(path: str, names: dict[str, Any]) -> bool:
    """Run a file's statements among these names; whether it could be read, and each of them ended well."""
    _stand_in(path, names)  # what a file misspells, its own lines may call by the right name
    units = _units_in(Path(STATE.folder, path).read_bytes(), path)
    if units is None:
        return False
    known = len(STATE.stepper.noted)
    _run_units(units, path, names, _lending_to(path, units, names))
    STATE.misspelt.setdefault(path, [*_put_right(path, units, names)])
    return len(STATE.stepper.noted) == known


def _put_right(path: str, units: list[stepping.Unit], names: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Give a file's definitions that are misspelt their right names; where these have stand-ins, the slips stand for them too."""
    for name, own in spelling.slips([unit.node for unit in units], _at_home_in(path)):
        if name in STATE.standins:
            names[own] = _in_place_of(names.get(own), name)
        elif own in names:
            names[name] = names[own]
            yield name, own


def _at_home_in(path: str) -> list[str]:
    """The wanted names that a file defines if anything does: those of its own, and those of files that were not handed in."""
    homes = {name: f"{home}.py" for name, home in STATE.homes.items()}
    return [name for name, home in homes.items() if home == path or home not in STATE.paths]


def _lend(name: str) -> Any:
    """A library of the sheet, or what a partner defines."""
    if name not in STATE.homes:
        return STATE.sheet_names(STATE.furniture).get(name)
    try:
        return vars(importlib.import_module(STATE.homes[name])).get(name)
    except Exception:  # a partner that was not handed in, or cannot be found under its name
        return None


def _unreadable(path: str) -> dict[str, Any] | None:
    """What is wrong with a file, or the first such cell of a notebook, that is no Python at all."""
    return next((e for p, e in STATE.unreadable.items() if p == path or p.startswith(f"{path}:")), None)


def _units_in(source: bytes, path: str, *, flags: int = 0) -> list[stepping.Unit] | None:
    """The statements of a file or a cell; None where it is no Python, which is kept in mind."""
    try:
        return _compile(source, path, flags)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as refused:
        STATE.unreadable[path] = faults.describe(refused)
        return None


def _run_units(units: list[stepping.Unit], path: str, names: dict[str, Any], lending: Lending) -> None:
    meant = dict(spelling.other_methods([unit.node for unit in units], STATE.furniture.get("methods", {})))

    def after(node: ast.stmt) -> None:
        if isinstance(node, ast.ClassDef):
            known = STATE.other_methods.setdefault(path.partition(":cell ")[0], {})
            spelling.call_by_right_names(names.get(node.name), node.name, meant, known)
        bound = [name for name in stepping.bound(node) if name in STATE.standins]
        names.update({name: _in_place_of(names.get(name), name) for name in bound})
        lending.after(node, names)

    STATE.stepper.run(units, path, names, after)


def _in_place_of(own: Any, name: str) -> Any:
    """The stand-in for a definition; for a class one with the methods that it has beside the sheet's: a script may call those."""
    standin = STATE.standins[name]
    if not (issubclass(type(own), type) and isinstance(standin, type)):
        return standin
    sheets = {part for kind in standin.__mro__ for part in vars(kind)}
    methods = (types.FunctionType, classmethod, staticmethod)
    members = [member for kind in reversed(type.mro(own)) for member in spelling.members_of(kind).items()]
    beside = {part: value for part, value in members if isinstance(value, methods) and part not in sheets}
    meant = (each for known in STATE.other_methods.values() for each in known.items())
    beside |= {method: getattr(standin, n.partition(".")[2]) for n, method in meant if n.startswith(f"{name}.")}
    return type(name, (standin,), beside)


def _lending_to(path: str, units: list[stepping.Unit], names: dict[str, Any]) -> Lending:
    lending = Lending(units, STATE.furniture.get("libraries", ()), STATE.stepper.wanted, _lend)
    lending.before(names)
    STATE.lent.setdefault(path, lending.lent)
    return lending


# --- compiling -----------------------------------------------------------------------------------------------------------


def _decode(source: bytes) -> str:
    """Source text by its declared encoding; bytes that are not UTF-8 and declare nothing are taken for Latin-1."""
    try:
        return importlib.util.decode_source(source)
    except (UnicodeDecodeError, SyntaxError):
        if source.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in source:
            raise SyntaxError("the file is not UTF-8 text (it looks like UTF-16): save it as UTF-8") from None
        return source.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")


def _compile(source: bytes, path: str, flags: int = 0) -> list[stepping.Unit]:
    text = _decode(source)
    own = faults.own_name(path)
    _remember_lines(own, text)
    try:
        tree = _parsed(text, own)
        if _RELATIVE.search(text):
            packages.without_dots(tree, path)  # let files that were written as a package import each other
        lacked = returning.completed(tree, STATE.furniture.get("returns", {}))
        STATE.unreturned.setdefault(path.partition(":cell ")[0], {}).update(lacked)
        return stepping.units_of(tree, own, flags=flags)
    except SyntaxError as refused:
        return gaps.units_around(text, own, STATE.stepper.wanted, refused, flags=flags)


def _parsed(text: str, own: str) -> ast.Module:
    """What Python reads there, or what a later one would."""
    try:
        return ast.parse(text, own)
    except SyntaxError:
        later = newer.reworded(text)
        if later is None:
            raise
        with contextlib.suppress(SyntaxError):
            return ast.parse(later, own)
        raise


def _remember_lines(own: str, text: str) -> None:
    import linecache

    linecache.cache[own] = (len(text), None, text.splitlines(keepends=True), own)


def _define_standins(sources: dict[str, str]) -> None:
    space = types.ModuleType("standins")
    vars(space)["__builtins__"] = vars(builtins)
    for name, source in sources.items():
        exec(compile(source, "<stand-in>", "exec"), vars(space))
        STATE.standins[name] = vars(space)[name]


# --- notebooks -----------------------------------------------------------------------------------------------------------


def _run_notebook(path: str) -> types.ModuleType:
    if path in STATE.modules:
        return STATE.modules[path]
    module = types.ModuleType("__main__")
    STATE.modules[path] = module
    _stand_in(path, vars(module))
    _run_cells(path, vars(module))
    _stand_in(path, vars(module))
    return module


def _run_cells(path: str, names: dict[str, Any]) -> None:
    cells: dict[str, list[stepping.Unit]] = {}
    for number, source in enumerate(_cells(path), start=1):
        text, name = source.encode("utf-8", "replace"), f"{path}:cell {number}"
        cells[name] = _units_in(text, name, flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT) or []
    every = [unit for units in cells.values() for unit in units]
    lending = _lending_to(path, every, names)
    for name, units in cells.items():
        _run_units(units, name, names, lending)
    STATE.misspelt.setdefault(path, [*_put_right(path, every, names)])


def _run_magic(line: str, names: dict[str, Any]) -> None:
    """Do what ``%run FILE`` does: a notebook's cells run among the names of who asks, a program leaves its own there."""
    path = next(Path(word).as_posix() for word in shlex.split(line) if not word.startswith("-"))
    if path.endswith(".ipynb"):
        _run_cells(path, names)
        return
    program = _main_module(path)
    _run_file(path, vars(program))
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
        told = {"type": "SyntaxError", "message": "this is not a notebook that can be read"}
        STATE.unreadable[path] = faults.describe(error) | told
        return []
