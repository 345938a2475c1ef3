"""Packages of other desks that change nothing in what is computed: a bar that shows progress, the looks of plots.

Whoever draws or computes with a package that is not here is told so by Python, as anywhere.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterable, Iterator
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

_LOOKS = ("set", "set_theme", "set_style", "set_context", "set_palette", "reset_defaults", "despine")
"""What seaborn is asked for mostly, before or after matplotlib draws."""


def stand_in() -> None:
    """Put these in the place of what is not installed."""
    for name, modules in (("tqdm", _bars), ("seaborn", _looks)):
        if importlib.util.find_spec(name) is None:
            sys.modules.update({module.__name__: module for module in modules()})


class _Bar:
    """A bar of progress that nobody sees."""

    def __init__(
        self, iterable: Iterable[Any] | None = None, *_: object, total: float | None = None, **__: object
    ) -> None:
        self.iterable, self.total, self.n = iterable, total, 0.0

    def __iter__(self) -> Iterator[Any]:
        for each in self.iterable or ():
            yield each
            self.n += 1

    def __len__(self) -> int:
        return len(self.iterable) if hasattr(self.iterable, "__len__") else int(self.total or 0)  # type: ignore[arg-type]

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *args: object) -> None:
        """Nothing was opened."""

    def update(self, n: float = 1) -> None:
        self.n += n

    @staticmethod
    def write(text: object = "", *_: object, **__: object) -> None:
        print(text)

    def close(self, *args: object, **options: object) -> None:
        """Nothing is shown."""

    set_description = set_description_str = set_postfix = set_postfix_str = refresh = display = clear = reset = close


def _bars() -> Iterator[ModuleType]:
    for name in ("tqdm", "tqdm.auto", "tqdm.notebook", "tqdm.std"):
        module = _named(name)
        vars(module).update(tqdm=_Bar, trange=lambda *ends, **_: _Bar(range(*ends)), tqdm_notebook=_Bar)
        yield module


def _looks() -> Iterator[ModuleType]:
    seaborn = _named("seaborn")

    def __getattr__(name: str) -> Any:  # noqa: N807 - PEP 562
        if name.startswith("__"):
            raise AttributeError(name)
        raise ModuleNotFoundError("No module named 'seaborn'", name="seaborn")

    vars(seaborn).update({name: lambda *args, **options: None for name in _LOOKS} | {"__getattr__": __getattr__})
    yield seaborn


def _named(name: str) -> ModuleType:
    module = ModuleType(name)
    module.__spec__ = ModuleSpec(name, None)
    return module
