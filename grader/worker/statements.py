"""Run a file statement by statement: a statement that raises, exits or does not end is skipped, and the following ones run.

A statement may take half of the remaining time; then it is interrupted. Before each statement the process writes down which one it
runs, so that the grader learns which one ended the process or could not be interrupted. The next process is told to skip it.
"""

from __future__ import annotations
import __future__

import ast
import builtins
import contextlib
import copy
import itertools
import json
import os
import signal
import time
import types
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from inspect import CO_COROUTINE
from typing import Any, TypeGuard

from . import faults

_REAL_CLOCK, _CPU_CLOCK = time.monotonic, time.process_time  # student code finds others, see `repeatability`
_TICK_S = 0.25
_IDLE_SHARE = 0.02  # of one processor: a process that uses less is waiting
_HINTS_AS_TEXT = __future__.annotations.compiler_flag
_MAX_NOTED = 40  # most skipped statements of a submission that are reported
_FUTURE = sum({int(getattr(__future__, name).compiler_flag) for name in __future__.all_feature_names})
_IMPORTS = (ast.Import, ast.ImportFrom)
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


class OutOfTimeError(BaseException):
    """Exception: a statement used up its time. It is a BaseException, so that `except Exception` in student code lets it pass."""


class MissingName:
    """Placeholder for a name that could not be imported or defined, so that code which does not use it runs.

    Calling, indexing or iterating it, or reading an attribute, raises the original error; arithmetic a TypeError.
    """

    def __init__(self, error: Callable[[], BaseException]) -> None:
        self._error = error

    def _fail(self, *args: Any, **kwargs: Any) -> Any:
        raise self._error()

    __call__ = __getitem__ = __iter__ = __len__ = __enter__ = __mro_entries__ = _fail

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name) if name.startswith("__") else self._error()


@dataclass(frozen=True)
class Unit:
    """Piece of code that is run and skipped as a whole: a statement, or a notebook cell with a top-level `await`.

    `number` identifies it in the file; `node` is its syntax tree (of a cell the first statement), `code` what is run.
    """

    number: int
    node: ast.stmt
    code: types.CodeType


# --- time ----------------------------------------------------------------------------------------------------------------


class _Clock:
    """Time limit of the statements that run since `start`: CPU time and idle time. A statement may use half of what is left."""

    def __init__(self) -> None:
        self._end_s = self._until_s = self._idle_s = 0.0
        self._seen = (0.0, 0.0)
        self._before: Any = None

    def start(self, within_s: float) -> None:
        self._idle_s, self._seen = 0.0, (_CPU_CLOCK(), _REAL_CLOCK())
        self._end_s = self._seen[0] + within_s
        if hasattr(signal, "setitimer"):  # not on Windows: there the time is kept from outside alone
            self._before = signal.signal(signal.SIGALRM, self._tick)
            signal.setitimer(signal.ITIMER_REAL, 2 * _TICK_S, _TICK_S)

    def stop(self) -> None:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)
            if signal.getsignal(signal.SIGALRM) == self._tick:
                signal.signal(signal.SIGALRM, self._before)

    def allow(self) -> None:
        """Give the statement that runs next half of the remaining time, so that those after it have some, too."""
        now_s = _CPU_CLOCK() + self._idle_s
        self._until_s = now_s + (self._end_s - now_s) / 2

    def _tick(self, _number: int, frame: types.FrameType | None) -> None:
        cpu_s, wall_s = _CPU_CLOCK(), _REAL_CLOCK()
        if cpu_s - self._seen[0] <= _IDLE_SHARE * (wall_s - self._seen[1]):
            self._idle_s += wall_s - self._seen[1]
        self._seen = (cpu_s, wall_s)
        if cpu_s + self._idle_s >= self._until_s and _in_student_statement(frame):
            raise OutOfTimeError


_CLOCK = _Clock()


def _in_student_statement(frame: types.FrameType | None) -> bool:
    """Return whether a student's statement is running, which may be interrupted, and not the worker code between two statements."""
    while frame is not None and frame.f_code is not StatementRunner._run_unit.__code__:
        if faults.is_own(frame.f_code.co_filename):
            return True
        frame = frame.f_back
    return False


@contextlib.contextmanager
def time_limit(within_s: float) -> Iterator[None]:
    """Limit the statements that run in this block to `within_s` seconds in all, so that one that never ends leaves time for others.

    A statement that has used half of what was left is interrupted by OutOfTimeError; on Windows, none is.
    """
    _CLOCK.start(within_s)
    try:
        yield
    finally:
        _CLOCK.stop()


# --- running -------------------------------------------------------------------------------------------------------------


class StatementRunner:
    """Runner of a file's statements, one by one, so that a failing one does not cost those after it; `noted` lists skipped ones.

    Parameters
    ----------
    skipped : (file, number of a statement that ended an earlier process) -> the reason why it is not run again
    place : (offset, size) in the file that stdout goes to; the running statement is noted there, to find one that kills the worker
    wanted : the required names; a failed statement is recorded with those that it would have defined
    """

    def __init__(self, skipped: dict[tuple[str, int], str], place: tuple[int, int], wanted: list[str]) -> None:
        self._skipped, self._place, self.wanted = skipped, place, wanted
        self._fd = os.dup(1)
        self._running: list[tuple[str, int]] = []
        self.noted: list[dict[str, Any]] = []

    def run(self, units: list[Unit], path: str, names: dict[str, Any], after: Callable[[ast.stmt], None]) -> None:
        """Run the statements of file `path`, compiled one by one as `units`, in the namespace `names`.

        `after` is called with the node of each, failed and skipped ones too. Statements that raise, overrun their time or are
        listed in `skipped` are added to `noted`.
        """
        names["__builtins__"] = vars(builtins)  # those that all modules share: the worker's are its own
        for unit in itertools.chain.from_iterable(_as_run(unit, names) for unit in units):
            if why := self._skipped.get((path, unit.number)):
                self._note(path, unit, "ended", why)
            else:
                self._run_in_place(path, unit, names)
            after(unit.node)

    def _run_in_place(self, path: str, unit: Unit, names: dict[str, Any]) -> None:
        self._running.append((path, unit.number))
        self._write_place()
        try:
            self._run_unit(path, unit, names)
        finally:
            self._running.pop()
            self._write_place()
            _CLOCK.allow()

    def _run_unit(self, path: str, unit: Unit, names: dict[str, Any]) -> None:
        _CLOCK.allow()
        try:
            _evaluate(unit.code, names)
        except OutOfTimeError as interrupted:
            within = _callables_on(interrupted.__traceback__, self.wanted)
            self._note(path, unit, "overran", "it had not ended when its time was up", within)
        except BaseException as raised:  # whatever student code raises, SystemExit included
            self._step_over(path, unit, names, raised)

    def _step_over(self, path: str, unit: Unit, names: dict[str, Any], raised: BaseException) -> None:
        """Record a statement that raised, and keep what did not depend on the failure.

        Kept are the other names of an import, and a definition without its type hints (from Python 3.14 on, hints are evaluated on
        demand anyway). A name that needs a failed import becomes a `MissingName`.
        """
        if isinstance(unit.node, _IMPORTS) and faults.is_a(raised, ImportError):
            self._import_the_rest(path, unit, names, raised)
            return
        is_defined = isinstance(unit.node, DEFINITIONS) and faults.is_a(raised, Exception)
        how = "hints" if is_defined and self._is_defined_without_hints(unit, names) else "raised"
        if how == "raised" and faults.is_a(raised, ImportError):
            lost = [name for name in bound(unit.node) if name not in self.wanted]  # a helper's decorator, say
            names.update({name: _not_imported(raised) for name in lost if name not in names})
        self._note(path, unit, how, raised)

    def _is_defined_without_hints(self, unit: Unit, names: dict[str, Any]) -> bool:
        try:
            _evaluate(_compiled(unit.node, unit.code.co_filename, _HINTS_AS_TEXT), names)
        except Exception:
            return False
        return True

    def _import_the_rest(self, path: str, unit: Unit, names: dict[str, Any], raised: BaseException) -> None:
        assert isinstance(unit.node, _IMPORTS)
        if len(unit.node.names) == 1:
            (alias,) = unit.node.names
            if alias.name != "*":
                names.setdefault(alias.asname or alias.name.split(".")[0], _not_imported(raised))
            self._note(path, unit, "raised", raised)
            return
        for alias in unit.node.names:
            single = copy.copy(unit.node)
            single.names = [alias]
            self._run_unit(path, Unit(unit.number, single, _compiled(single, unit.code.co_filename)), names)

    def _note(self, path: str, unit: Unit, how: str, why: str | BaseException, within: Collection[str] = ()) -> None:
        """Record a skipped statement, the required names that it would have defined, and those whose code ran then (`within`)."""
        if len(self.noted) >= _MAX_NOTED:
            return
        line = _first_line(unit.node)
        told = faults.fault_at(path, line, why) if type(why) is str else faults.describe(why)  # type: ignore[arg-type] # its `__class__` may be student code
        defines = [name for name in (*bound(unit.node), *_imported(unit.node)) if name in self.wanted]
        about = {"path": path, "number": unit.number, "at": line, "how": how, "defines": defines}
        self.noted.append(told | about | {"within": sorted(within)})

    def defined(self, names: dict[str, Any]) -> list[str]:
        """Return the names required by the lab that the namespace `names` defines; placeholders of failed imports do not count."""
        return [name for name in self.wanted if name in names and not isinstance(names[name], MissingName)]

    def _write_place(self) -> None:
        """Write down the running statement, so that the grader finds it if it ends this process; a failed write is ignored."""
        at, room = self._place
        said = json.dumps(self._running[-1:]).encode()
        if hasattr(os, "pwrite") and len(said) <= room:
            with contextlib.suppress(OSError):
                os.pwrite(self._fd, said.ljust(room), at)


def _as_run(unit: Unit, names: dict[str, Any]) -> list[Unit]:
    """Return a unit alone, or, for a program's ``if __name__ == "__main__"``, the statements below it, which run one by one."""
    node, flags = unit.node, unit.code.co_flags
    if not is_main_guard(node) or names.get("__name__") != "__main__" or flags & CO_COROUTINE:
        return [unit]
    numbered = enumerate(node.body, (unit.number + 1) << 16)  # as no other statement is
    own = [(number, each) for number, each in numbered if not _is_text(each)]
    return [Unit(number, each, _compiled(each, unit.code.co_filename, flags & _FUTURE)) for number, each in own]


def is_main_guard(node: ast.stmt) -> TypeGuard[ast.If]:
    if not isinstance(node, ast.If) or node.orelse or not isinstance(node.test, ast.Compare):
        return False
    sides = [node.test.left, *node.test.comparators]
    names = [side.id for side in sides if isinstance(side, ast.Name)]
    values = [side.value for side in sides if isinstance(side, ast.Constant)]
    return (names, values) == (["__name__"], ["__main__"]) and isinstance(node.test.ops[0], ast.Eq)


def _callables_on(trace: types.TracebackType | None, wanted: Collection[str]) -> set[str]:
    """Return the required functions, and classes of methods, that ran when a statement was interrupted, by its traceback."""
    found: set[str] = set()
    while trace is not None:
        code, names = trace.tb_frame.f_code, trace.tb_frame.f_globals
        found.update(name for name in wanted if code in _codes_of(names.get(name)))
        trace = trace.tb_next
    return found


def _codes_of(value: Any) -> list[types.CodeType]:
    functions = [value, *vars(value).values()] if isinstance(value, type) else [value]
    return [each.__code__ for each in functions if isinstance(each, types.FunctionType)]


def _not_imported(raised: BaseException) -> MissingName:
    kind = ModuleNotFoundError if faults.is_a(raised, ModuleNotFoundError) else ImportError
    message, name = faults.message_of(raised), faults.attribute_of(raised, "name", str)
    return MissingName(lambda: kind(message, name=name))


def _evaluate(code: types.CodeType, names: dict[str, Any]) -> None:
    awaiting = eval(code, names)
    if awaiting is not None:
        import asyncio  # few cells wait for anything

        asyncio.run(awaiting)


# --- compiling -----------------------------------------------------------------------------------------------------------


def units_of(tree: ast.Module, name: str, *, flags: int = 0) -> list[Unit]:
    """Return a file's top-level statements, each compiled alone, or a cell with `await` as one unit; SyntaxError if one is invalid.

    `name` is the file name in tracebacks, `flags` those of `compile`: PyCF_ALLOW_TOP_LEVEL_AWAIT says that the text is a cell.
    """
    flags |= _future_flags(tree)
    if flags & ast.PyCF_ALLOW_TOP_LEVEL_AWAIT and _awaits(tree) and tree.body:
        whole: types.CodeType = compile(tree, name, "exec", flags, dont_inherit=True)
        return [Unit(0, tree.body[0], whole)]
    statements = [(n, node) for n, node in enumerate(tree.body) if n == 0 or not _is_text(node)]
    return [Unit(n, node, _compiled(node, name, flags)) for n, node in statements]


def _compiled(node: ast.stmt, name: str, flags: int = 0) -> types.CodeType:
    code: types.CodeType = compile(ast.Module([node], []), name, "exec", flags, dont_inherit=True)
    return code


def _is_text(node: ast.stmt) -> bool:
    """Return whether a statement is only a constant. Compiled by itself, a string would become the module's docstring."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _awaits(tree: ast.Module) -> bool:
    return any(isinstance(node, ast.Await | ast.AsyncFor | ast.AsyncWith) for node in ast.walk(tree))


def _future_flags(tree: ast.Module) -> int:
    named = [a.name for n in tree.body if isinstance(n, ast.ImportFrom) and n.module == "__future__" for a in n.names]
    features = [getattr(__future__, name) for name in named if name in __future__.all_feature_names]
    return sum({int(feature.compiler_flag) for feature in features})


def _first_line(node: ast.stmt) -> int:
    lines: list[int] = [each.lineno for each in getattr(node, "decorator_list", ())]
    return min([node.lineno, *lines])


def bound(node: ast.AST) -> list[str]:
    """Return the names that a statement defines or assigns, in any of its branches; imported names are left out."""
    if isinstance(node, DEFINITIONS):
        return [node.name]
    if isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
    inner = [*getattr(node, "body", ()), *getattr(node, "orelse", ()), *getattr(node, "finalbody", ())]
    inner += getattr(node, "handlers", ())
    return [name for each in inner if isinstance(each, ast.AST) for name in bound(each)]


def _imported(node: ast.AST) -> list[str]:
    return [alias.asname or alias.name for alias in node.names] if isinstance(node, ast.ImportFrom) else []
