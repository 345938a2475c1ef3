"""What the box may answer to each question. Whatever else comes is `Malformed`: the student's loss, never the grader's fault.

The frame around an answer was checked already (`sandbox.wire`). Here its content is held against what was asked: which
fields there are, of which kind and size, and whether the arrays that they name are there in the shape that the question
calls for. So no check ever meets a value that the harness could not have sent, whoever sent it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import Malformed
from .sandbox.wire import Frame

MAX_NUMBERS = 600_000
"""Of one array that a student's function returned: a hundred times what the lab asks for."""
MAX_CURVES = 240
"""Of all figures of one answer."""
_TEXT = 2000
_SHORT = 200
_DEPTH = 6
_WHOLE = 1_000_000_000
_COORDINATE = 1e12
_MOST_PIXELS = 640 * 640


class _Wrong(Exception):  # noqa: N818 - it never leaves this module
    """Where an answer is not what it should be."""


Asked = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class _Answer:
    """An answer with the question's fields and arrays."""

    frame: Frame
    fields: Mapping[str, Any]
    asked: Asked

    def array(self, name: Any, *shape: int | None) -> np.ndarray:
        """The array of that name, of numbers, in that shape (None: any length; no shape: any)."""
        if not isinstance(name, str) or name not in self.frame.arrays:
            raise _Wrong("an array that is not there")
        array = self.frame.arrays[name]
        if array.dtype != np.float64 or array.size > MAX_NUMBERS:
            raise _Wrong(f"array {name!r} is of {array.dtype} and has {array.size} elements")
        if shape and not _fits(array.shape, shape):
            raise _Wrong(f"array {name!r} has shape {array.shape}")
        return array

    def part(self, name: str, kind: Callable[[Any], Any]) -> Any:
        """One field of the answer, which has to be there."""
        return _part(self.frame.fields, name, kind)

    @property
    def faulty(self) -> bool:
        """Whether the student's code raised: then the answer may break off."""
        return self.frame.fields.get("error") is not None


def checked(op: str, frame: Frame, fields: Mapping[str, Any], arrays: Asked) -> Frame:
    """The frame, if it is an answer to the question `op` with these fields and arrays.

    Raises
    ------
    Malformed
        If it is not.
    """
    answer = _Answer(frame, fields, arrays)
    try:
        if op in _FAULTS_IN:
            _maybe(_fault)(frame.fields.get("error"))
        _RULES[op](answer)
    except _Wrong as wrong:
        raise Malformed(f"what came back is no answer to {op!r}: {wrong}") from None
    return frame


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(w in (None, n) for n, w in zip(shape, wanted, strict=True))


# --- kinds of values -----------------------------------------------------------------------------------------------------


def _text(limit: int) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        if not isinstance(value, str) or len(value) > limit:
            raise _Wrong("no text, or too much of it")

    return rule


def _whole(value: Any) -> None:
    if type(value) is not int or abs(value) > _WHOLE:
        raise _Wrong("no whole number, or too large a one")


def _number(value: Any) -> None:
    if type(value) not in (int, float) or not abs(value) <= _COORDINATE:
        raise _Wrong("no number, or too large a one")


def _flag(value: Any) -> None:
    if type(value) is not bool:
        raise _Wrong("neither true nor false")


def _maybe(kind: Callable[[Any], Any]) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        if value is not None:
            kind(value)

    return rule


def _listed(kind: Callable[[Any], Any], most: int, exactly: int | None = None) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        if not isinstance(value, list) or len(value) > most or exactly not in (None, len(value)):
            raise _Wrong("no list, or one of another length")
        for item in value:
            kind(item)

    return rule


def _part(record: Any, name: str, kind: Callable[[Any], Any]) -> Any:
    if not isinstance(record, dict) or name not in record:
        raise _Wrong(f"{name!r} is missing")
    try:
        kind(record[name])
    except _Wrong as wrong:
        raise _Wrong(f"{name!r}: {wrong}") from None
    return record[name]


def _mapping(value: Any) -> None:
    if not isinstance(value, dict):
        raise _Wrong("no object")


def _record(**kinds: Callable[[Any], Any]) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        for name, kind in kinds.items():
            _part(value, name, kind)

    return rule


_short, _long = _text(_SHORT), _text(_TEXT)
_fault = _record(
    type=_short, message=_long, file=_maybe(_short), line=_maybe(_whole), text=_maybe(_long), name=_maybe(_short)
)


# --- what a student's function returned ----------------------------------------------------------------------------------


def _node(answer: _Answer, depth: int = 0) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        kind = _part(value, "kind", _short)
        if depth > _DEPTH:
            raise _Wrong("nested too deep")
        if kind in ("array", "number") or (kind == "list" and "key" in value):
            if answer.array(value.get("key")).ndim and kind == "number":
                raise _Wrong("a number of more than one number")
        elif kind in ("tuple", "list"):
            _part(value, "items", _listed(_node(answer, depth + 1), 64))
        elif kind in ("dict", "object"):
            _part(value, "type", _short)
            _part(value, "items", _listed(_member(answer, depth + 1), 64))
        elif kind == "other":
            _part(value, "type", _short)
        elif kind not in ("none", "text", "too_large"):
            raise _Wrong("a value of no known kind")
        if "key" in value and kind not in ("array", "number", "list"):
            raise _Wrong("numbers where there are none")

    return rule


def _member(answer: _Answer, depth: int) -> Callable[[Any], None]:
    def rule(value: Any) -> None:
        if not isinstance(value, list) or len(value) != 2:
            raise _Wrong("a member is a name and a value")
        _short(value[0])
        _node(answer, depth)(value[1])

    return rule


def _changes(answer: _Answer, most: int) -> None:
    if len(answer.array("disturbance", None, 4)) > most:
        raise _Wrong("more changes than calls")


# --- questions about the lab's parts -------------------------------------------------------------------------------------


def _submit(answer: _Answer) -> None:
    answer.part("paths", _listed(_long, 5000))


def _outline(answer: _Answer) -> None:
    names = answer.part("names", _mapping)
    _listed(_long, 5000)(list(names))
    for defined in names.values():
        _listed(_long, 300)(defined)


def _load(answer: _Answer) -> None:
    answer.part("names", _listed(_long, 500))
    answer.part("errors", _listed(_fault, 20))
    _drawings(answer)


def _read(answer: _Answer) -> None:
    pairs, states = len(answer.asked["pairs"]), len(answer.asked["qpos"])
    whole = not answer.faulty
    answer.part("calls", _listed(_node(answer), pairs * states, pairs * states if whole else None))
    answer.part("later", _listed(_node(answer), pairs, pairs if whole else None))
    _changes(answer, pairs * states)


def _simulate(answer: _Answer) -> None:
    answer.part("value", _maybe(_node(answer)))
    answer.part("changed", _listed(_short, 20))
    for name in answer.frame.arrays:
        if name.startswith("first_"):
            answer.array(name, {"first_gravity": 3, "first_timestep": 1}.get(name))


def _noise(answer: _Answer) -> None:
    states = len(answer.asked["qpos"])
    _draws(answer, states)
    _changes(answer, states)


def _default_bias(answer: _Answer) -> None:
    _draws(answer, answer.fields["instances"])


def _draws(answer: _Answer, rows: int) -> None:
    answer.part("odd", _maybe(_node(answer)))
    for name in ("accel", "gyro"):
        answer.array(name, rows, answer.fields["reads"], 3)


def _filter(answer: _Answer) -> None:
    cases = answer.fields["cases"]
    kinds = _record(odd=_maybe(_node(answer)), error=_maybe(_fault), input_changed=_flag, output_changed=_flag)
    answer.part("cases", _listed(kinds, len(cases), len(cases)))
    for case, asked in zip(answer.frame.fields["cases"], cases, strict=True):
        signal = answer.asked[asked["input"]]
        _series(answer, case, len(signal), signal.shape[1:])


def _series(answer: _Answer, case: Mapping[str, Any], rows: int, row: tuple[int, ...]) -> None:
    """Rows for every measurement; fewer, or none at all, only where the student's code raised."""
    broke_off = case["error"] is not None
    if case.get("output") is None and broke_off:
        return
    output = answer.array(case.get("output"), None, *row)
    if len(output) > rows or (len(output) < rows and not broke_off):
        raise _Wrong(f"{len(output)} outputs for {rows} measurements")


def _plot(answer: _Answer) -> None:
    _drawings(answer)


def _run_script(answer: _Answer) -> None:
    _drawings(answer)


def _image(answer: _Answer) -> None:
    if answer.part("readable", _flag):
        answer.part("size_px", _listed(_whole, 2, 2))
        answer.part("colours", _whole)
        answer.part("ink", _number)
        _pixels(answer)
    else:
        answer.part("reason", _short)


def _pixels(answer: _Answer) -> None:
    """A small picture of 64 colours."""
    preview, palette = (answer.frame.arrays.get(name) for name in ("preview", "palette"))
    if preview is None or palette is None or not preview.dtype == palette.dtype == np.uint8:
        raise _Wrong("a picture without pixels")
    if preview.ndim != 2 or not 0 < preview.size <= _MOST_PIXELS or palette.shape != (64, 3) or preview.max() >= 64:
        raise _Wrong(f"a picture of shape {preview.shape} and {palette.shape} colours")


# --- questions about the extensions --------------------------------------------------------------------------------------


def _tilt(answer: _Answer) -> None:
    cases = answer.fields["cases"]
    answer.part("cases", _listed(_record(odd=_maybe(_node(answer)), error=_maybe(_fault)), len(cases), len(cases)))
    for case, asked in zip(answer.frame.fields["cases"], cases, strict=True):
        _series(answer, case, len(answer.asked[asked["accel"]]), (2,))


def _allan(answer: _Answer) -> None:
    answer.part("value", _maybe(_node(answer)))


def _imus(answer: _Answer) -> None:
    states = len(answer.asked["qpos"])
    answer.part("calls", _listed(_node(answer), states, None if answer.faulty else states))
    answer.part("later", _maybe(_node(answer)))


def _live(answer: _Answer) -> None:
    answer.array("events", None, 3)
    answer.part("returned", _flag)
    answer.part("simulated", _number)
    answer.part("curves", _listed(_record(moment=_number, label=_long), 1024))
    for curve in answer.frame.fields["curves"]:
        _points(answer, curve)


# --- figures -------------------------------------------------------------------------------------------------------------

_entry = _record(text=_short, colour=_short, style=_short, marker=_short, stroke=_short)
_placed = _record(text=_short, place=_listed(_number, 2, 2), colour=_short)
_AXES = {
    "visible": _flag, "position": _listed(_number, 4, 4), "xlabel": _short, "ylabel": _short, "title": _short,
    "legend": _maybe(_listed(_entry, 64)), "texts": _listed(_placed, 64), "y_limits": _listed(_number, 2, 2),
}  # fmt: skip
_CURVE = {
    "label": _short, "colour": _short, "kind": _short, "visible": _flag, "n": _whole, "style": _short, "marker": _short,
    "stroke": _short,
}  # fmt: skip
_FIGURE = {
    "title": _short, "xlabel": _short, "ylabel": _short, "texts": _listed(_short, 64),
    "legends": _listed(_listed(_entry, 64), 8),
}  # fmt: skip


def _drawings(answer: _Answer) -> None:
    answer.part("pictures", _listed(_long, 300))
    answer.part("figures", _listed(_figure, 16))
    curves = [c for figure in answer.frame.fields["figures"] for axes in figure["axes"] for c in axes["curves"]]
    if len(curves) > MAX_CURVES:
        raise _Wrong(f"{len(curves)} curves")
    for curve in curves:
        _points(answer, curve)


def _figure(figure: Any) -> None:
    _record(event=_short, path=_maybe(_long), format=_short, size_px=_listed(_whole, 2, 2))(figure)
    unreadable = "unreadable" in figure
    _part(figure, "axes", _listed(_record(**_AXES, curves=_listed(_record(**_CURVE), 64)), 0 if unreadable else 24))
    if not unreadable:
        _record(**_FIGURE)(figure)


def _points(answer: _Answer, curve: Mapping[str, Any]) -> None:
    x, y = (answer.array(curve.get(name), None) for name in ("x", "y"))
    if len(x) != len(y):
        raise _Wrong("a curve with more of x than of y")


_RULES: Mapping[str, Callable[[_Answer], None]] = {
    "submit": _submit, "outline": _outline, "load": _load, "run_script": _run_script, "read": _read, "simulate": _simulate,
    "noise": _noise, "default_bias": _default_bias, "filter": _filter, "plot": _plot, "image": _image, "tilt": _tilt,
    "allan": _allan, "imus": _imus, "live": _live,
}  # fmt: skip
_FAULTS_IN = frozenset(_RULES) - {"submit", "outline", "load", "image"}
