"""Submissions that are written as a package: their files import each other by the package's name, or from a dot.

The lab's files lie in the scratch folder itself, whatever folder they were handed in below. So the package that they speak of
is made here, and `package.filters` is the module `filters`.
"""

from __future__ import annotations

import ast
import functools
import importlib
import importlib.abc
import importlib.machinery
import re
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

_OWN = "handed_in"  # what a dot means
_AMBIGUOUS = "filters"  # scipy, scikit-image and others have such a module, too


def imported_packages(sources: Iterable[str], paths: Iterable[str], required: Iterable[str]) -> set[str]:
    """The packages out of which these sources import files of the submission, or those that it should have."""
    modules = {*required, *(path.split("/")[0].removesuffix(".py") for path in paths)} - {_AMBIGUOUS}
    imports = re.compile(
        r"^[ \t]*(?:from|import)[ \t]+\.*([^\W\d][\w.]*?)(?:\.|[ \t]+import\b[ \t]*(?:\(\s*)?(?:\w+\s*,\s*)*)"
        rf"(?:{'|'.join(map(re.escape, sorted(modules)))})\b",
        re.MULTILINE,
    )
    return {package for source in sources for package in imports.findall(source)}


def make_imports_absolute(tree: ast.Module, path: str) -> None:
    """Let a file import from the folder of the submission, or one above, which it takes for a package, by plain names."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level > path.count("/"):
            node.level, node.module = 0, node.module or _OWN


class PackageFinder:
    """Finds the submission as a package, and in it its files; the last to be asked, after all that is installed.

    Parameters
    ----------
    names : tells what the package is called, as `imported_packages` does; asked once, where an import finds nothing else
    load_init : makes the loader of the package's ``__init__.py``, or None where there is none
    """

    def __init__(self, names: Callable[[], set[str]], load_init: Callable[[str], Any]) -> None:
        self._names, self._load_init = names, load_init
        self._made: list[str] = []

    @functools.cached_property
    def _own(self) -> set[str]:
        return self._names() | {_OWN}

    @functools.cached_property
    def _around(self) -> set[str]:
        return {name[: dot.start()] for name in self._own for dot in re.finditer(r"\.", name)} - self._own

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        package, _, module = name.rpartition(".")
        if package and package not in self._made:
            return None
        if name in self._own | self._around:
            self._made.append(name)
            return importlib.machinery.ModuleSpec(name, self._package(name), is_package=True)
        return importlib.machinery.ModuleSpec(name, _Alias(module)) if package else None

    def _package(self, name: str) -> Any:
        """The loader of the package, whichever name it is first asked for by, or of one that it lies in."""
        if name in self._around:
            return None
        first = next(made for made in self._made if made in self._own)
        return self._load_init(name) if name == first else _Alias(first)


class _Alias(importlib.abc.Loader):
    """A module of the submission under its name in the package; it is run once."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._spec: Any = None

    def create_module(self, spec: Any) -> ModuleType:
        module = importlib.import_module(self._name)
        self._spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._spec  # importing has put the alias' there
