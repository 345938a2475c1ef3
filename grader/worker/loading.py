"""Load a submission: write its files into the scratch folder, run them, and report what failed in each.

All definitions of a file or notebook count: module-level statements that fail are skipped, see `statements`. If the grader sends
stand-ins (working definitions in place of broken ones), they replace the student's own, see `standins`.
"""

from __future__ import annotations

import ast
import importlib.machinery
import importlib.util
import itertools
import os
import shlex
import sys
import types
from pathlib import Path
from typing import Any

from . import (
    compiling,
    drawing,
    environment,
    faults,
    fuzzy_names,
    notebooks,
    packages,
    recorder,
    repeatability,
    standins,
    statements,
)
from .missing_imports import MissingImports
from .submission import STATE

_MAX_PATHS = 4000  # most files of a submission with those that its notebooks write; their list fits into an answer
_MAX_OUTLINED = 100  # most files that an outline lists
_ABOVE = "course/labs"  # above the folder of the submission; programs may look for files some folders above their own
_LEVELS = 1 + _ABOVE.count("/")


def submit(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer a request: write the submission's files into the scratch folder and prepare the process. Student code runs later.

    ``fields["files"]`` lists (path, key in `arrays`, n). If n > 0, a copy goes n folders above the scratch folder, where programs
    may look for it. For the other fields see `_submit` in `engine.session`. Return as ``written`` the paths of the files that
    notebooks write with ``%%writefile``.
    """
    skipped = {(path, number): why for path, number, why in fields["skipped"]}
    STATE.stepper = statements.StatementRunner(skipped, tuple(fields["place"]), list(fields["homes"]))
    STATE.homes = {name: file.removesuffix(".py") for name, file in fields["homes"].items()}
    STATE.required = tuple(file.removesuffix(".py") for file in fields["required"])
    STATE.lab_configuration = fields["lab_configuration"]
    STATE.folder = os.path.abspath(f"{_ABOVE}/{fields['folder']}")
    os.makedirs(STATE.folder, exist_ok=True)
    os.chdir(STATE.folder)
    environment.remember_folder(STATE.folder)
    for path, key, levels_above in fields["files"]:
        _write(path, arrays[key].tobytes())
        if 0 < levels_above <= _LEVELS:
            _write("../" * levels_above + path, arrays[key].tobytes())  # for who opens it by way of its own folder
        STATE.paths.append(path)
    sent = len(STATE.paths)
    for path in [path for path in STATE.paths if path.endswith(".ipynb")]:
        _write_cells_to_files(path, fields["withheld"])
    environment.install(run_magic=_run_magic)
    STATE.install_lab(STATE.lab_configuration)
    repeatability.seed(fields["seed"])
    recorder.watch(read_back=drawing.reads_pictures_back(arrays[key].tobytes() for _, key, _ in fields["files"]))
    _prepare_imports()
    standins.define(fields["standins"])
    return {"written": STATE.paths[sent:]}, {}


def load(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer a request: import the file or notebook ``path``; return a report and figures' arrays.

    A statement that uses half of what is left of ``within_s`` seconds is interrupted (not on Windows), and the next one runs.
    The report holds ``names`` (those that the lab sheet asks for and the file defines), ``supplied`` (names that it forgot to
    import), ``misspelled`` ((right, student's name) pairs), ``unreadable`` (its syntax error or None), ``stepped_over`` (the
    statements that failed or were interrupted so far, in any file) and ``figures``.
    """
    del arrays
    path: str = fields["path"]
    with environment.in_scratch_folder(STATE.folder), statements.time_limit(fields["within_s"]):
        module = _run_notebook(path) if path.endswith(".ipynb") else _import_file(path)
    seen, arrays = recorder.RECORDER.take(STATE.folder)
    answer: dict[str, Any] = {"names": STATE.stepper.defined(vars(module)) if module else []}
    answer["supplied"] = STATE.supplied.get(path, [])
    answer["misspelled"] = [*STATE.misspelled.get(path, []), *STATE.misspelled_methods.get(path, {}).items()]
    return seen | answer | {"unreadable": _unreadable(path), "stepped_over": STATE.stepper.noted}, arrays


def run_script(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer a request: run file ``path`` as `python FILE` does; return a report and figures' arrays.

    Up to ``within_s`` seconds are shared as in `load`. The report holds ``figures``, ``stepped_over`` (failed or interrupted
    statements, also of other files), and ``error``: the file's syntax error (if no stand-ins were sent) or its first statement in
    ``stepped_over``, as a dict like that of `faults.describe`; None without one.
    """
    del arrays
    path: str = fields["path"]
    with environment.in_scratch_folder(STATE.folder), statements.time_limit(fields["within_s"]):
        module = sys.modules["__main__"] = _main_module(path)
        _run_file(path, vars(module))
        if STATE.standins and path in STATE.unreadable:
            del STATE.unreadable[path]  # this fault is reported elsewhere
            _run_what_parses(path, vars(module))
    seen, arrays = recorder.RECORDER.take(STATE.folder)
    error = _unreadable(path) or next((e for e in STATE.stepper.noted if e["path"] == path), None)
    return seen | {"error": error, "stepped_over": STATE.stepper.noted}, arrays


def _main_module(path: str) -> types.ModuleType:
    module = types.ModuleType("__main__")
    module.__file__ = str(Path(STATE.folder, path))
    return module


def outline(fields: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answer a request: return ``names``, {file: required names that it defines at top level}, and no arrays. No code runs."""
    del fields, arrays
    found = ((path, sorted(compiling.defined(path).intersection(STATE.stepper.wanted))) for path in STATE.code())
    return {"names": dict(itertools.islice(((path, names) for path, names in found if names), _MAX_OUTLINED))}, {}


def _write(path: str, content: bytes) -> None:
    target = Path(STATE.folder, path)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)


# --- importing -----------------------------------------------------------------------------------------------------------


class _Loader(importlib.machinery.SourceFileLoader):
    """Loader of a student's file: a file with errors keeps the definitions that work, so that other files can import them."""

    def exec_module(self, module: types.ModuleType) -> None:
        path = Path(self.path).relative_to(STATE.folder).as_posix()
        STATE.modules[path] = module
        if own := standins.of_module(module.__name__):  # what a broken file lacks, others have from it
            vars(module).update(STATE.sheet_names(STATE.lab_configuration, own))
        if not _run_file(path, vars(module)):
            vars(module).setdefault("__getattr__", _absent_names(path))
        standins.fill(path, vars(module))


def _absent_names(home: str) -> Any:
    """Return ``__getattr__`` for a file with errors: a name that it lacks can be imported, and raises NameError when it is used."""

    def __getattr__(name: str) -> Any:  # noqa: N807 - PEP 562
        if name.startswith("__"):
            raise AttributeError(name)
        return statements.MissingName(lambda: NameError(f"{home} did not define {name}"))

    return __getattr__


class _MissingPartner(importlib.machinery.SourceFileLoader):
    """Loader of a required file that was not submitted: its module holds stand-ins, working definitions that the grader sends."""

    def get_code(self, fullname: str) -> types.CodeType:
        return compile("", self.path, "exec")

    def exec_module(self, module: types.ModuleType) -> None:
        own = standins.of_module(module.__name__)
        vars(module).update(STATE.sheet_names(STATE.lab_configuration, own) | own)
        vars(module)["__getattr__"] = _absent_names(f"{module.__name__}.py")


class _UnderAnotherName(_MissingPartner):
    """Loader of a required file that was not submitted: it runs another file that defines its names, and passes these on."""

    def exec_module(self, module: types.ModuleType) -> None:
        found = _run_notebook(self.path) if self.path.endswith(".ipynb") else _import_file(self.path)
        vars(module).update({n: v for n, v in vars(found).items() if not n.startswith("__")} if found else {})


class _PartnerFinder:
    """Import finder for required files that were not submitted under their names, so that the files that import them still run."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> Any:
        if path is not None or name not in STATE.required:
            return None
        if standins.of_module(name):
            return importlib.util.spec_from_loader(name, _MissingPartner(name, f"{name}.py"))
        other = next((p for p in STATE.code() if any(STATE.homes.get(n) == name for n in compiling.defined(p))), None)
        return other and importlib.util.spec_from_loader(name, _UnderAnotherName(name, other))


def _prepare_imports() -> None:
    def hook(path: str) -> Any:
        place = os.path.abspath(path)
        if not Path(place).is_relative_to(STATE.folder):
            place = _original_of(place)
        return importlib.machinery.FileFinder(place, (_Loader, [".py"]))

    sys.path_hooks.insert(0, hook)
    sys.path.insert(0, STATE.folder)
    sys.meta_path += [_PartnerFinder, packages.PackageFinder(_own_packages, _load_init)]
    sys.dont_write_bytecode = True
    sys.argv = ["lab.py"]


def _original_of(place: str) -> str:
    """Return the submission's own folder in place of one above it, such as ``../step5``; raise ImportError if there is none."""
    for above in Path(STATE.folder).parents[:_LEVELS]:
        if Path(place).is_relative_to(above) and (own := Path(STATE.folder, Path(place).relative_to(above))).is_dir():
            return str(own)
    raise ImportError(place)


def _own_packages() -> set[str]:
    code = [path for path in STATE.paths if path.endswith(".py")]
    return packages.imported_packages(
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
    """Run a file's statements in the namespace `names`, skipping those that fail; return True if it parses and none failed."""
    standins.fill(path, names)  # what a file misspells, its own lines may call by the right name
    units = compiling.units_in(Path(STATE.folder, path).read_bytes(), path)
    if units is None:
        return False
    known = len(STATE.stepper.noted)
    missing, meant = _missing_imports(path, units, names), standins.misspelled(path, units)
    _run_units(units, path, names, missing, meant)
    missing.at_end(names)
    STATE.misspelled.setdefault(path, [*standins.alias_misspelled(meant, names)])
    return len(STATE.stepper.noted) == known


def _run_what_parses(path: str, names: dict[str, Any]) -> None:
    """Run those statements of a file with a syntax error that parse, so that its figures are drawn.

    Stand-ins, working definitions that the grader sends, are there in place of the others.
    """
    units = compiling.units_that_parse(Path(STATE.folder, path).read_bytes(), path)
    _run_units(units, path, names, _missing_imports(path, units, names), standins.misspelled(path, units))


def _library_or_partner(name: str) -> Any:
    """Return what a name means that a file forgot to import, from a required file or a library of the lab; None if unknown."""
    if name not in STATE.homes:
        return STATE.sheet_names(STATE.lab_configuration, {}).get(name)
    try:
        return vars(importlib.import_module(STATE.homes[name])).get(name)
    except Exception:  # a partner that was not handed in, or cannot be found under its name
        return None


def _unreadable(path: str) -> dict[str, Any] | None:
    """Return the syntax error of a file, or of a notebook's first cell that has one; None if all of it parses."""
    return next((e for p, e in STATE.unreadable.items() if p == path or p.startswith(f"{path}:")), None)


def _run_units(
    units: list[statements.Unit], path: str, names: dict[str, Any], missing: MissingImports, meant: dict[str, str]
) -> None:
    wanted = STATE.lab_configuration.get("methods", ())

    def after(node: ast.stmt) -> None:
        if isinstance(node, ast.ClassDef):
            known = STATE.misspelled_methods.setdefault(path.partition(":cell ")[0], {})
            fuzzy_names.alias_misspelled_method(names.get(node.name), node.name, wanted, known)
        standins.replace_defined(node, meant, names)
        missing.after(node, names)

    STATE.stepper.run(units, path, names, after)


def _missing_imports(path: str, units: list[statements.Unit], names: dict[str, Any]) -> MissingImports:
    libraries = STATE.lab_configuration.get("libraries", ())
    missing = MissingImports(units, libraries, STATE.stepper.wanted, _library_or_partner)
    missing.before(names)
    STATE.supplied.setdefault(path, missing.supplied)
    return missing


# --- notebooks -----------------------------------------------------------------------------------------------------------


def _run_notebook(path: str) -> types.ModuleType:
    if path in STATE.modules:
        return STATE.modules[path]
    module = types.ModuleType("__main__")
    STATE.modules[path] = module
    standins.fill(path, vars(module))
    _run_cells(path, vars(module))
    standins.fill(path, vars(module))
    return module


def _run_cells(path: str, names: dict[str, Any]) -> None:
    cells: dict[str, list[statements.Unit]] = {}
    for number, source in enumerate(_cells(path), start=1):
        text, name = source.encode("utf-8", "replace"), f"{path}:cell {number}"
        cells[name] = compiling.units_in(text, name, flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT) or []
    every = [unit for units in cells.values() for unit in units]
    missing, meant = _missing_imports(path, every, names), standins.misspelled(path, every)
    for name, units in cells.items():
        _run_units(units, name, names, missing, meant)
    missing.at_end(names)
    STATE.misspelled.setdefault(path, [*standins.alias_misspelled(meant, names)])


def _run_magic(line: str, names: dict[str, Any]) -> None:
    """Do what ``%run FILE`` does: run a notebook's cells in the namespace `names`, or run a program and add its names to it."""
    path = next(Path(word).as_posix() for word in shlex.split(line) if not word.startswith("-"))
    if path.endswith(".ipynb"):
        _run_cells(path, names)
        return
    program = _main_module(path)
    _run_file(path, vars(program))
    names.update({name: value for name, value in vars(program).items() if not name.startswith("__")})


def _write_cells_to_files(path: str, withheld: list[str]) -> None:
    """Write the files of ``%%writefile NAME.py`` cells, so that they are there before anything is imported.

    Existing files are kept, and those in `withheld`, which killed an earlier process, are not written.
    """
    try:
        files = notebooks.files_written(Path(STATE.folder, path).read_bytes())
    except (ValueError, RecursionError):
        return
    for name, text in files.items():
        room = len(STATE.paths) < _MAX_PATHS
        if room and name not in withheld and not Path(STATE.folder, name).exists():
            _write(name, text.encode("utf-8", "replace"))
            STATE.paths.append(name)


def _cells(path: str) -> list[str]:
    content = Path(STATE.folder, path).read_bytes()
    try:
        return notebooks.code_cells(content)
    except (ValueError, RecursionError) as error:
        told = {"type": "SyntaxError", "message": "this is not a notebook that can be read"}
        STATE.unreadable[path] = faults.describe(error) | told | compiling.merge_conflict(content, path)
        return []
