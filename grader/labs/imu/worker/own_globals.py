"""Set the module globals that student functions read: sensor ids, model, data, measurement and recording.

On the lab sheet all code is one program, whose globals hold the values that it passes to its functions. We set those globals before
each call, so that functions that read them work here, too.
"""

from __future__ import annotations

import dis
import functools
import inspect
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from grader.worker import submission
from grader.worker.calling import Slot
from grader.worker.screen import replaced

_ACCELEROMETER = re.compile(r"^acc", re.IGNORECASE)
_GYROSCOPE = re.compile(r"^gyr", re.IGNORECASE)
_AN_ID = re.compile(r"id(x|ent)?$|index$|sensor$", re.IGNORECASE)
_SCENE = {name: re.compile(rf"^(mj|mujoco|my|sim)?_?{name}$", re.IGNORECASE) for name in ("model", "data")}


def provide_ids(ids: Mapping[str, int]) -> None:
    """Set each unset global that student functions read as a sensor id to ``accel`` or ``gyro`` of `ids`.

    On the lab sheet, the main program sets these globals; code that relies on that works here, too. Unset means missing or None,
    or negative if one of the student's functions sets the global later.
    """
    for module in list(submission.STATE.modules.values()):
        for name in _unset_globals(module):
            if _AN_ID.search(name) and _ACCELEROMETER.match(name):
                setattr(module, name, ids["accel"])
            elif _AN_ID.search(name) and _GYROSCOPE.match(name):
                setattr(module, name, ids["gyro"])


def provide_ids_of(model: Any) -> None:
    """Set the ids that student functions read as globals, and that are not set, to those of the robot's IMU in `model`.

    As `provide_ids` does. Nothing is set if `model` has no such IMU.
    """
    import mujoco

    names = submission.STATE.lab_configuration.get("imu", ())
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name) for name in names]
    if ids and min(ids) >= 0:
        provide_ids(dict(zip(("accel", "gyro"), ids, strict=True)))


@contextmanager
def set_model_and_data(model: Any, data: Any) -> Iterator[None]:
    """Set the globals that student functions read as model and data to `model` and `data`; restore the globals on exit.

    These are globals that hold an MjModel or MjData, and unset globals with a name such as ``mj_model``. If the globals hold
    different models, no model is set, as it is unknown which one is meant; the same holds for the data.
    """
    with ExitStack() as stack:
        for name, given in (("model", model), ("data", data)):
            places = [
                place
                for module in list(submission.STATE.modules.values())
                for place in _scene_globals(module, name, given)
            ]
            if len({id(held) for *_, held in places if held is not None}) <= 1:
                for module, own, _ in places:
                    stack.enter_context(replaced(module, {own: given}))
        yield


_MEASUREMENT = re.compile(
    r"^((raw|noisy|clean|new)_)?(acc(el(eration)?)?|gyro|measurements?|readings?|samples?)(_(raw|noisy))?$",
    re.IGNORECASE,
)


def measurement_global(update: Any) -> tuple[Callable[[Any], AbstractContextManager[None]], list[str]]:
    """Return how to give a filter its measurement if the student's method `update` reads a global as the measurement.

    Returned are a context manager that takes the measurement and sets the global to it, and ``["global measurement"]``, to report
    the deviation to the student. Without exactly one such global, the context manager does nothing and the list is empty.
    """
    function = getattr(update, "__func__", update)
    if not isinstance(function, FunctionType):
        return nullcontext, []
    owner = _module_of(function)
    read = [name for name in _globals_read(function.__code__, "LOAD_GLOBAL") if _MEASUREMENT.match(name)]
    meant = [name for name in read if _may_be_measured(getattr(owner, name, None))]
    if owner is None or len(meant) != 1:
        return nullcontext, []
    return lambda measurement: replaced(owner, {meant[0]: measurement}), ["global measurement"]


def _may_be_measured(value: Any) -> bool:
    return not callable(value) and np.shape(value) in ((), (3,))


def _module_of(function: Any) -> ModuleType | None:
    modules = submission.STATE.modules.values()
    return next((m for m in list(modules) if vars(m) is getattr(function, "__globals__", None)), None)


@contextmanager
def set_recording(recording: Any, function: Any, slots: Sequence[Slot]) -> Iterator[list[str]]:
    """Let a plot function that reads its recording from a global read `recording` there; restore the global on exit.

    Parameters
    ----------
    slots : the lab sheet's arguments for the recording and the series in it. No global is set if the function's body reads one of
        these parameters of its own, or unless just one global that it reads may, by name and value, hold a recording

    Yields
    ------
    ``["global imu_data"]``, for the report, if a global is set although the function has a parameter for the recording, which its
        body ignores; else an empty list
    """
    owner = _module_of(function)
    own = _own_names(function, *slots) or _own_names(function)[:1]
    if owner is None or _locals_read(function.__code__).intersection(own):
        yield []
        return
    classes = {module.__name__ for module in submission.STATE.modules.values()}
    read = [name for name in _globals_read(function.__code__, "LOAD_GLOBAL") if slots[0].meaning.search(name)]
    meant = [name for name in read if _may_be_recorded(vars(owner).get(name), classes)]
    with replaced(owner, dict.fromkeys(meant, recording) if len(meant) == 1 else {}):
        yield [f"global {slots[0].name}"] if own and len(meant) == 1 else []


def _may_be_recorded(value: Any, classes: Collection[str]) -> bool:
    """Return whether a global may hold the recording: None, a dict, a sequence without text, or an object of a student's class.

    `classes` are the names of the submission's modules.
    """
    if isinstance(value, tuple | list):
        return not any(isinstance(part, str) for part in value)
    return value is None or isinstance(value, dict) or type(value).__module__ in classes


def globals_read_instead(function: Any, slots: Collection[Slot]) -> list[str]:
    """Return which of model and data (`slots`) a function reads as globals and not as its parameters: ``["global model"]``.

    The list is empty if `function` is not written in Python. Call this inside `set_model_and_data`, which sets these globals.
    """
    import mujoco

    if not isinstance(function, FunctionType):
        return []
    kinds = {"model": mujoco.MjModel, "data": mujoco.MjData}
    used, held = _locals_read(function.__code__), list(_values_read(function))
    found = []
    for slot in slots:
        own = _own_names(function, slot)
        if own and not used.intersection(own) and any(isinstance(value, kinds[slot.name]) for value in held):
            found.append(f"global {slot.name}")
    return found


def _own_names(function: FunctionType, *slots: Slot) -> list[str]:
    """Return the names of a function's parameters that suit one of the slots; without slots, those without a default."""
    parameters = inspect.signature(function).parameters.values()
    return [p.name for p in parameters if (any(slot.suits(p) for slot in slots) if slots else p.default is p.empty)]


def _scene_globals(module: ModuleType, name: str, given: Any) -> Iterator[tuple[ModuleType, str, Any]]:
    """Yield module, name and present value of each global that a module's functions read as `name`, "model" or "data".

    It holds an object of the type of `given`, or it is unset and has such a name.
    """
    values = vars(module)
    for own in {own for function in _functions(module) for own in _globals_read(function.__code__, "LOAD_GLOBAL")}:
        held = values.get(own)
        if isinstance(held, type(given)) or (held is None and _SCENE[name].match(own)):
            yield module, own, held


def _unset_globals(module: ModuleType) -> set[str]:
    functions = _functions(module)
    names = {name for function in functions for name in _globals_read(function.__code__, "LOAD_GLOBAL")}
    set_later = {name for function in functions for name in _globals_read(function.__code__, "STORE_GLOBAL")}
    values = vars(module)
    return {name for name in names if values.get(name) is None or (name in set_later and _is_no_id(values[name]))}


def _functions(module: ModuleType) -> list[FunctionType]:
    """Return the functions of a student's module and of its classes, whose globals may have to be set."""
    members = [m for m in list(vars(module).values()) if getattr(m, "__module__", None) == module.__name__]
    functions = [m for m in members if isinstance(m, FunctionType)]
    for owner in (m for m in members if isinstance(m, type)):
        functions += [f for f in vars(owner).values() if isinstance(f, FunctionType)]
    return functions


def _values_read(function: FunctionType) -> Iterator[Any]:
    """Yield the values of all globals that a function reads, directly or through other functions; None for an unset one."""
    seen, waiting = {function}, [function]
    while waiting:
        this = waiting.pop()
        for name in _globals_read(this.__code__, "LOAD_GLOBAL"):
            value = this.__globals__.get(name)
            yield value
            if isinstance(value, FunctionType) and value not in seen:
                seen.add(value)
                waiting.append(value)


def _is_no_id(value: Any) -> bool:
    """Return whether a value is negative, so no sensor id: a placeholder, or `mj_name2id` of an unknown name."""
    return isinstance(value, int | np.integer) and bool(value < 0)


@functools.cache  # asked for every instance of a class
def _globals_read(code: CodeType, by: str) -> frozenset[str]:
    """Return the globals that code and its nested functions use with the bytecode instruction `by`, LOAD_GLOBAL or STORE_GLOBAL."""
    inner = (name for const in code.co_consts if isinstance(const, CodeType) for name in _globals_read(const, by))
    return frozenset({str(step.argval) for step in dis.get_instructions(code) if step.opname == by}.union(inner))


def _locals_read(code: CodeType) -> set[str]:
    """Return the local variables that a function reads. Python 3.13 has one instruction that reads two."""
    read = set(code.co_cellvars)
    for step in dis.get_instructions(code):
        if step.opname.startswith("LOAD_FAST"):
            read.update(step.argval if isinstance(step.argval, tuple) else (step.argval,))
    return read
