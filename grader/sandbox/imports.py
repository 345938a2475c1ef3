"""Importing a harness: a folder of modules that knows the lab, under a name that no submission uses."""

from __future__ import annotations

import builtins
import contextlib
import importlib.util
import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from types import ModuleType

from . import worker

_NAME = "_imugrade_harness"


def load_harness(
    folder: str, search: Sequence[str], *, warm: Sequence[str] = (), thorough: bool = False
) -> worker.Answer:
    """Import the folder as a package, let it warm up, import the modules `warm` where they are, and return its `answer`."""
    sys.path[:] = search
    harness = _import(folder)
    harness.warm_up(thorough)
    for name in warm:
        with contextlib.suppress(Exception):  # then it fails for the student's code, as it would anywhere
            importlib.import_module(name)
    answer: worker.Answer = harness.answer
    return answer


_OWN_BUILTINS = dict(vars(builtins))
"""What the harness finds as built-in functions: a student's code sets those that everyone else shares."""


class _Loader(SourceFileLoader):
    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__builtins__"] = _OWN_BUILTINS
        super().exec_module(module)


class _Finder:
    """Finds the harness's modules, one folder of them."""

    def __init__(self, folder: str) -> None:
        self._folder = folder

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        package, _, module = name.rpartition(".")
        file = os.path.join(self._folder, f"{module}.py")
        if package != _NAME or not os.path.isfile(file):
            return None
        return importlib.util.spec_from_file_location(name, file, loader=_Loader(name, file))


def _import(folder: str) -> ModuleType:
    file = os.path.join(folder, "__init__.py")
    spec = importlib.util.spec_from_file_location(
        _NAME, file, loader=_Loader(_NAME, file), submodule_search_locations=[folder]
    )
    if spec is None or spec.loader is None:
        raise ImportError(f"{folder} is not a package")
    module = importlib.util.module_from_spec(spec)
    sys.modules[_NAME] = module
    finder = _Finder(folder)
    sys.meta_path.insert(0, finder)
    try:
        spec.loader.exec_module(module)
    finally:
        sys.meta_path.remove(finder)
    return module
