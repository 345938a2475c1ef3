"""Guard the worker code against changes by student code: keep NumPy and the built-in functions apart, and notice changes.

Student code runs in the same process, so this is no security boundary. A patch of NumPy or of a built-in function, whether
meant as a trick or as a convenience, does not change what is measured; a submission that rewrites the worker code through
its frames or in memory gets no answer accepted. Decisions rest on measurements outside this process wherever possible.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Iterator, Mapping
from typing import Any


class ChangedError(RuntimeError):
    """The worker code is not what it was when it was loaded."""


class Guard:
    """The worker code's functions and classes as they were before any of the student's code ran."""

    def __init__(self, package: str) -> None:
        self._modules = [
            module for name, module in sys.modules.items() if name == package or name.startswith(f"{package}.")
        ]
        self._keep_numpy()
        self._known = [member for module in self._modules for member in _members(module)]

    def _keep_numpy(self) -> None:
        """Give each module a numpy whose names nobody else can set."""
        import numpy

        own = types.ModuleType("numpy")
        vars(own).update(vars(numpy))
        for module in self._modules:
            if vars(module).get("np") is numpy:
                vars(module)["np"] = own

    def hide(self) -> None:
        """Take the worker code off the list of modules: it goes on without it."""
        for module in self._modules:
            sys.modules.pop(module.__name__, None)

    def check(self) -> None:
        """Raise ChangedError where a function or a method was exchanged."""
        for names, name, value, code in self._known:
            now = names.get(name)
            if now is not value or (code is not None and now.__code__ is not code):
                raise ChangedError(f"the worker code was changed: {name}")


Member = tuple[Mapping[str, Any], str, Any, types.CodeType | None]
"""Where a name stands, what it stands for, and what that does if it is a function."""


def _members(module: types.ModuleType) -> Iterator[Member]:
    """Functions and classes of a module, and the methods of its own classes."""
    for name, value in vars(module).items():
        if isinstance(value, types.FunctionType | type | types.ModuleType):
            yield vars(module), name, value, getattr(value, "__code__", None)
        if isinstance(value, type) and value.__module__ == module.__name__:
            for method, function in vars(value).items():
                if isinstance(function, types.FunctionType):
                    yield vars(value), method, function, function.__code__
