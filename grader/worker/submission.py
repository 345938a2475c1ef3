"""State of the one submission that this process runs (`STATE`): its files' paths, loaded modules, required names and faults."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

from . import statements


class _State:
    """Knowledge of the worker about its submission: files, loaded modules, required names, and what is wrong with each file."""

    def __init__(self) -> None:
        self.folder = ""
        self.paths: list[str] = []
        self.standins: dict[str, Any] = {}
        self.modules: dict[str, types.ModuleType] = {}
        self.unreadable: dict[str, dict[str, Any]] = {}
        self.stepper: statements.StatementRunner
        self.homes: dict[str, str] = {}  # every name that is asked for, and the module that it is expected in
        self.required: tuple[str, ...] = ()  # the modules that others import from
        self.lab_configuration: dict[str, Any] = {}
        # by file: required names and methods with the names that they have there; names that the file forgot to import
        self.misspelled: dict[str, list[tuple[str, str]]] = {}
        self.misspelled_methods: dict[str, dict[str, str]] = {}
        self.supplied: dict[str, list[str]] = {}
        self.sheet_names: Callable[[dict[str, Any], dict[str, Any]], dict[str, Any]] = lambda configuration, standins: {}
        self.install_lab: Callable[[dict[str, Any]], None] = lambda configuration: None

    def code(self) -> list[str]:
        """Return the paths of programs and notebooks, those nearest to the submission's top folder first, to search for a name."""
        code = (path for path in self.paths if path.endswith((".py", ".ipynb")))
        return sorted(code, key=lambda path: (path.count("/"), path))

    def names_expected_in(self, path: str) -> list[str]:
        """Return the required names that a file may define: its own, and those of required files that were not submitted."""
        homes = {name: f"{home}.py" for name, home in self.homes.items()}
        return [name for name, home in homes.items() if home == path or home not in self.paths]


STATE = _State()


def find(name: str, path: str) -> Any:
    """Return the object that the loaded file `path` defines as `name`, such as a student's function; KeyError if there is none."""
    return vars(STATE.modules[path])[name]
