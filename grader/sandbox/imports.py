"""Import the worker code (ours, which answers requests about student code) and a lab's package, if any, that answers others."""

from __future__ import annotations

import builtins
import contextlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from types import ModuleType

from . import worker

_NAMES = ("grader.worker", "grader.questions")
"""Names of the two packages while they are imported, as their sources call each other. A submission finds neither."""


def load_worker_code(folders: Sequence[str], search: Sequence[str], *, thorough: bool = False) -> worker.Answer:
    """Import the worker code and a lab's own module, if there is one, and warm them up; return the function that answers requests.

    Parameters
    ----------
    folders : the folder with ``__init__.py`` of the worker code, then, if there is one, that of the lab's module
    search : `sys.path` from now on
    thorough : whether to also use each library once, so that the first use costs no worker time
    """
    sys.path[:] = search
    worker_code, *questions = _imported(dict(zip(_NAMES, folders, strict=False)))
    worker_code.warm_up(thorough, *questions)
    answer: worker.Answer = worker_code.answer
    return answer


def import_where_they_are(modules: Iterable[str]) -> None:
    """Import those of `modules` that are installed, so that workers forked later start with them; skip any that fails to import."""
    for name in modules:
        with contextlib.suppress(Exception):  # then it fails for the student's code, as it would anywhere
            importlib.import_module(name)


_OWN_BUILTINS = dict(vars(builtins))
"""Built-in functions of the worker code; student code can set those that all other modules share."""


class _Loader(SourceFileLoader):
    """Loader that gives the worker code built-in functions of its own, which student code cannot replace."""

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__builtins__"] = _OWN_BUILTINS
        super().exec_module(module)


class _Finder:
    """Import finder for the packages in `folders`, which are outside `sys.path`, used only while they are imported."""

    def __init__(self, folders: Mapping[str, str]) -> None:
        self._folders = folders

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        package, _, module = name.rpartition(".")
        if name in self._folders:
            return _spec(name, os.path.join(self._folders[name], "__init__.py"), [self._folders[name]])
        if package not in self._folders:
            return None
        file = os.path.join(self._folders[package], f"{module}.py")
        return _spec(name, file) if os.path.isfile(file) else None


def _spec(name: str, file: str, folders: list[str] | None = None) -> ModuleSpec | None:
    loader = _Loader(name, file)
    return importlib.util.spec_from_file_location(name, file, loader=loader, submodule_search_locations=folders)


def _imported(folders: Mapping[str, str]) -> list[ModuleType]:
    """Import the packages and return their modules; the package above them, which exists only for this, is removed again."""
    above = ModuleType(_NAMES[0].partition(".")[0])
    above.__path__ = []
    sys.modules[above.__name__] = above
    finder = _Finder(folders)
    sys.meta_path.insert(0, finder)
    try:
        return [importlib.import_module(name) for name in folders]
    finally:
        sys.meta_path.remove(finder)
        del sys.modules[above.__name__]
