"""Import finder for submissions written as a package, whose files import each other by the package's name or from a dot.

The lab's files lie in the scratch folder itself, whatever folder they were submitted in. So the finder makes up the package, and
`package.filters` is the module `filters`.
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

_OWN = "handed_in"  # name of the package for relative imports
_AMBIGUOUS = "filters"  # not used to recognize a package: scipy, scikit-image and others have such a module, too


def imported_packages(sources: Iterable[str], paths: Iterable[str], required: Iterable[str]) -> set[str]:
    """Return the names by which source texts import the submission as a package: ``lab1`` for ``from lab1.sensors import read``.

    A name counts if a file of the submission (`paths`) or a `required` module is imported from it. Students may use several names.
    """
    modules = {*required, *(path.split("/")[0].removesuffix(".py") for path in paths)} - {_AMBIGUOUS}
    imports = re.compile(
        r"^[ \t]*(?:from|import)[ \t]+\.*([^\W\d][\w.]*?)(?:\.|[ \t]+import\b[ \t]*(?:\(\s*)?(?:\w+\s*,\s*)*)"
        rf"(?:{'|'.join(map(re.escape, sorted(modules)))})\b",
        re.MULTILINE,
    )
    return {package for source in sources for package in imports.findall(source)}


def make_imports_absolute(tree: ast.Module, path: str) -> None:
    """Make relative imports absolute in file `path` where they reach the submission's top folder, because it is no package."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level > path.count("/"):
            node.level, node.module = 0, node.module or _OWN


class PackageFinder:
    """Import finder for a submission whose files import each other through a package. Python asks it after all other finders.

    Parameters
    ----------
    names : function that returns the package's names (several if the files disagree), as `imported_packages` does; called once
    load_init : function of the package's name that returns the loader of its ``__init__.py``; None if there is none
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
        """Return the loader of the package under the name that is imported first, and an alias of it for its other names.

        Return None for an outer package (``a`` of ``a.b``), which has no file.
        """
        if name in self._around:
            return None
        first = next(made for made in self._made if made in self._own)
        return self._load_init(name) if name == first else _Alias(first)


class _Alias(importlib.abc.Loader):
    """Loader that gives a module of the submission its second name, in the package, so that the module runs only once."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._spec: Any = None

    def create_module(self, spec: Any) -> ModuleType:
        module = importlib.import_module(self._name)
        self._spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._spec  # importing has put the alias' there
