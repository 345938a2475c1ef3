"""Run signals through the student's low-pass filter and report what came out."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from grader.worker import submission
from grader.worker.calling import adapt
from grader.worker.values import Packer, numbers

from . import calls, own_globals
from .questions import Reply, parts_of, reporting_errors, vectors_in


def filter_cases(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Run the student's `LowPassFilter` over given measurements, a new instance for each case.

    Parameters
    ----------
    fields : ``path`` and ``cases``, each with ``input`` (array name), ``alpha`` (or None: the default), ``initial`` (array name
        or None), ``handling``: ``plain`` (nothing special); ``spoil_input``, ``spoil_output`` (the caller overwrites the array
        afterwards); ``beside`` (a second instance with another alpha is fed other data in between).

    Returns
    -------
    ``cases`` : per case ``output`` (array name or None), ``odd`` (what came in place of the first missing vector), ``error``,
        ``departs`` (names of arguments that the student's class takes differently), ``input_changed`` and ``output_changed`` (by
        the filter), as in `FilterRun`.
    """
    kind = submission.find("LowPassFilter", fields["path"])
    packer = Packer()
    building = functools.cache(functools.partial(calls.filter_builder, kind))
    cases = [_filter_case(building, case, arrays, packer) for case in fields["cases"]]
    return {"cases": cases}, packer.arrays


def _filter_case(
    building: Callable[[], Any], case: dict[str, Any], arrays: dict[str, Any], packer: Packer
) -> dict[str, Any]:
    signal = np.array(arrays[case["input"]])
    answer: dict[str, Any] = {
        "output": None, "odd": None, "error": None, "input_changed": False, "output_changed": False, "departs": [],
    }  # fmt: skip
    rows: list[np.ndarray] = []
    kept: list[list[tuple[str, np.ndarray]]] = []
    initial = None if case["initial"] is None else np.array(arrays[case["initial"]])
    with reporting_errors(answer):
        options = {} if case["alpha"] is None else {"alpha": case["alpha"]}
        if initial is not None:
            options["initial_value"] = initial
        build, in_building = building()
        instance = build(options)
        own, another = calls.method_of(instance, "update", 1)
        measuring, read_instead = own_globals.measurement_global(own)
        update, departs = adapt(own, calls.UPDATE, {"dt": calls.BETWEEN_S})
        answer["departs"] = [*in_building, *another, *departs, *read_instead]
        beside = None
        if case["handling"] == "beside":
            other = build(options | {"alpha": 1 - case["alpha"]})
            beside, _ = adapt(calls.method_of(other, "update", 1)[0], calls.UPDATE, {"dt": calls.BETWEEN_S})
        first: Any = None
        for measurement in signal:
            with measuring(measurement):
                value, row = _filtered(update, measurement, case["handling"], answer, packer)
            first = first if rows else value
            rows.append(row)
            kept.append(_vectors_kept(instance) if answer["odd"] and value is not None else [])
            if beside is not None:
                beside(100.0 - 3.0 * measurement)
        if isinstance(first, np.ndarray) and first.size == rows[0].size:
            with suppress(TypeError, ValueError):
                answer["output_changed"] = not np.array_equal(numbers(first).ravel(), rows[0], equal_nan=True)
        answer["input_changed"] |= initial is not None and initial.tolist() != arrays[case["initial"]].tolist()
    if rows:
        answer["output"] = packer.keep(_hidden_state(kept, signal, np.array(rows)))
    return answer


def _vectors_kept(instance: Any) -> list[tuple[str, np.ndarray]]:
    """Return copies of the vectors in a filter's attributes, by name, to find its output if `update` returns none; [] if none."""
    with suppress(TypeError):
        return [(name, vector.copy()) for name, vector in vectors_in(vars(instance).items())]
    return []


def _hidden_state(kept: list[list[tuple[str, np.ndarray]]], signal: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the vectors that the filter keeps if no update returned one: its output, of a filter that forgets `return`.

    If several kept vectors differ from the input and from each other, or an update returned a vector, return `rows`.
    """
    if not np.isnan(rows).all() or len({tuple(name for name, _ in each) for each in kept}) != 1:
        return rows
    series = [np.array([vector for _, vector in each]) for each in zip(*kept, strict=True)]
    own = [each for each in series if not np.array_equal(each, signal[: len(each)])] or series
    moving = [each for each in own if np.ptp(each, axis=0).any()] or own
    return moving[0] if all(np.array_equal(each, moving[0]) for each in moving) and moving else rows


def _filtered(
    update: Callable[[np.ndarray], Any], measurement: np.ndarray, handling: str, answer: dict[str, Any], packer: Packer
) -> tuple[Any, np.ndarray]:
    """Pass one measurement to the filter; return what came back, and the row of numbers in it (NaN if there is none).

    What the filter did to the measurement, and the first value of another form, are noted in `answer`.
    """
    given = measurement.copy()
    value = update(given)
    try:
        row = numbers(value).reshape(measurement.shape)
    except (TypeError, ValueError):
        row = _first_vector(value, measurement)
        answer["odd"] = answer["odd"] or packer.node(value)
    answer["input_changed"] = answer["input_changed"] or given.tolist() != measurement.tolist()
    if handling == "spoil_input":
        given[:] = 1e3
    if handling == "spoil_output" and isinstance(value, np.ndarray) and value.flags.writeable:
        value[...] = 1e3
    return value, row


def _first_vector(value: Any, measurement: np.ndarray) -> np.ndarray:
    """Find a vector in a value of another form: the first that is not the measurement itself, else that; NaN if there is none."""
    with suppress(TypeError):
        vectors = [vector.copy() for _, vector in vectors_in(parts_of(value))]
        return next((v for v in vectors if not np.array_equal(v, measurement)), [*vectors, np.full(3, np.nan)][0])
    return np.full(3, np.nan)
