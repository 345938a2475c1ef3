"""Guard the worker code (ours) against student code in its process: a private copy of NumPy, and a search for replaced functions.

This is no security boundary. A student's patch of NumPy, intended or not, does not change what is measured. If a submission
rewrites the worker code through frames or memory, none of its answers is accepted. Where possible, decisions rest on measurements
outside this process.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Iterator, Mapping
from typing import Any


class ChangedError(RuntimeError):
    """Exception: student code has replaced a part of the worker code (ours, in the same process), so its answer proves nothing."""


class Guard:
    """Record of the worker code's functions and classes, made before student code runs; `check` raises if one was replaced."""

    def __init__(self, package: str) -> None:
        self._modules = [
            module for name, module in sys.modules.items() if name == package or name.startswith(f"{package}.")
        ]
        self._keep_numpy()
        self._known = [member for module in self._modules for member in _members(module)]

    def _keep_numpy(self) -> None:
        """Give the worker code's modules a copy of the numpy module, so that a student's patch of NumPy changes nothing there."""
        import numpy

        own = types.ModuleType("numpy")
        vars(own).update(vars(numpy))
        for module in self._modules:
            if vars(module).get("np") is numpy:
                vars(module)["np"] = own

    def hide(self) -> None:
        """Remove the worker code from `sys.modules`, so that student code cannot import it."""
        for module in self._modules:
            sys.modules.pop(module.__name__, None)

    def check(self) -> None:
        """Raise ChangedError if a function, class or method of the worker code was replaced since this guard was made."""
        for names, name, value, code in self._known:
            now = names.get(name)
            if now is not value or (code is not None and now.__code__ is not code):
                raise ChangedError(f"the worker code was changed: {name}")


Member = tuple[Mapping[str, Any], str, Any, types.CodeType | None]
"""The namespace of a name, the name, the object that it names, and the code of that if it is a function (else None)."""


def _members(module: types.ModuleType) -> Iterator[Member]:
    """Yield what the guard compares of a module: its functions, classes and modules, and the methods of its own classes."""
    for name, value in vars(module).items():
        if isinstance(value, types.FunctionType | type | types.ModuleType):
            yield vars(module), name, value, getattr(value, "__code__", None)
        if isinstance(value, type) and value.__module__ == module.__name__:
            for method, function in vars(value).items():
                if isinstance(function, types.FunctionType):
                    yield vars(value), method, function, function.__code__
