"""Rules for a worker's reply to a question. Any other reply is `Malformed`: the check fails, and the grader goes on.

`sandbox.wire` has already checked the frame around a reply. This module checks its content against the question: which fields
it has, their type and size, and whether the arrays that they name exist in the shape that the question requires. So no check
gets a value that the worker code could not have sent, even if student code wrote the reply.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grader.base.errors import Malformed
from grader.sandbox.wire import Frame

MAX_NUMBERS = 600_000
"""Largest number of elements in an array that a student's function returned; 100 times what the lab asks for."""
MAX_CURVES = 240
"""Largest number of curves in all figures of one reply."""
_TEXT = 2000
_SHORT = 200
_NAMES = 64  # most names in a list
_STATEMENTS = 40  # most skipped statements in a report
_DEPTH = 6
_WHOLE = 1_000_000_000
_COORDINATE = 1e12
_MOST_PIXELS = 640 * 640
_LONGEST_SIDE = 640


class Wrong(Exception):  # noqa: N818 - it never leaves this module
    """A reply breaks a rule; the message says where."""


Asked = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Answer:
    """A reply, with the question's fields and arrays.

    A reply may name each array only once, as the worker code does; so records made from it are no larger than what was sent.
    """

    frame: Frame
    fields: Mapping[str, Any]
    asked: Asked
    named: set[str] = field(default_factory=set)

    def array(self, name: Any, *shape: int | None) -> np.ndarray:
        """Return the float64 array of that name if it has that shape (None: any length; no shape: any)."""
        if not isinstance(name, str) or name not in self.frame.arrays:
            raise Wrong("an array that is not there")
        if name in self.named:
            raise Wrong(f"array {name!r} in two places")
        self.named.add(name)
        array = self.frame.arrays[name]
        if array.dtype != np.float64 or array.size > MAX_NUMBERS:
            raise Wrong(f"array {name!r} is of {array.dtype} and has {array.size} elements")
        if shape and not _fits(array.shape, shape):
            raise Wrong(f"array {name!r} has shape {array.shape}")
        return array

    def part(self, name: str, kind: Callable[[Any], Any]) -> Any:
        """Return a required field of the reply after checking its kind."""
        return part_of(self.frame.fields, name, kind)

    @property
    def faulty(self) -> bool:
        """True if the student's code raised: the reply may then be incomplete."""
        return self.frame.fields.get("error") is not None


Rule = Callable[[Answer], None]


def checked(op: str, frame: Frame, fields: Mapping[str, Any], arrays: Asked, rules: Mapping[str, Rule]) -> Frame:
    """Return the frame if it is a valid reply to the question `op` with these fields and arrays.

    Parameters
    ----------
    rules : rules for the lab's own questions; the student's code may raise in each of them

    Raises
    ------
    Malformed
        If the reply breaks a rule.
    """
    answer = Answer(frame, fields, arrays)
    try:
        if op not in _WITHOUT_FAULT:
            maybe(fault)(frame.fields.get("error"))
        {**_RULES, **rules}[op](answer)
    except Wrong as wrong:
        raise Malformed(f"what came back is no answer to {op!r}: {wrong}") from None
    return frame


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(w in (None, n) for n, w in zip(shape, wanted, strict=True))


# --- kinds of values -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """A rule for one value, with the function and the arguments that made it."""

    made: Callable[..., Kind]
    of: tuple[Any, ...]
    rule: Callable[[Any], None]

    def __call__(self, value: Any) -> None:
        self.rule(value)


def text(limit: int) -> Kind:
    def rule(value: Any) -> None:
        if not isinstance(value, str) or len(value) > limit:
            raise Wrong("no text, or too much of it")

    return Kind(text, (limit,), rule)


def whole(value: Any) -> None:
    if type(value) is not int or abs(value) > _WHOLE:
        raise Wrong("no whole number, or too large a one")


def number(value: Any) -> None:
    if type(value) not in (int, float) or not abs(value) <= _COORDINATE:
        raise Wrong("no number, or too large a one")


def flag(value: Any) -> None:
    if type(value) is not bool:
        raise Wrong("neither true nor false")


def maybe(kind: Callable[[Any], Any]) -> Kind:
    def rule(value: Any) -> None:
        if value is not None:
            kind(value)

    return Kind(maybe, (kind,), rule)


def listed(kind: Callable[[Any], Any], most: int, exactly: int | None = None) -> Kind:
    """Return the rule for a list of at most `most` items of one kind, or of `exactly` this number."""

    def rule(value: Any) -> None:
        if not isinstance(value, list) or len(value) > most or exactly not in (None, len(value)):
            raise Wrong("no list, or one of another length")
        for item in value:
            kind(item)

    return Kind(listed, (kind, most, exactly), rule)


def part_of(record: Any, name: str, kind: Callable[[Any], Any]) -> Any:
    """Check one entry of a record by its rule, and return it."""
    if not isinstance(record, dict) or name not in record:
        raise Wrong(f"{name!r} is missing")
    try:
        kind(record[name])
    except Wrong as wrong:
        raise Wrong(f"{name!r}: {wrong}") from None
    return record[name]


def mapping(value: Any) -> None:
    if not isinstance(value, dict):
        raise Wrong("no object")


def record(**kinds: Callable[[Any], Any]) -> Kind:
    def rule(value: Any) -> None:
        for name, kind in kinds.items():
            part_of(value, name, kind)

    return Kind(record, (kinds,), rule)


def every(*kinds: Callable[[Any], None]) -> Kind:
    def rule(value: Any) -> None:
        for kind in kinds:
            kind(value)

    return Kind(every, kinds, rule)


short, long = text(_SHORT), text(_TEXT)
fault = record(type=short, message=long, file=maybe(short), line=maybe(whole), text=maybe(long), name=maybe(short))
_stepped_over = record(
    type=short,
    message=long,
    path=long,
    number=whole,
    at=whole,
    how=short,
    defines=listed(short, _NAMES),
    within=listed(short, _NAMES),
)


# --- what a student's function returned ----------------------------------------------------------------------------------


def node(answer: Answer, depth: int = 0) -> Kind:
    """Return the rule for a node, as `worker.values` describes a returned value."""

    def rule(value: Any) -> None:
        kind = part_of(value, "kind", short)
        if depth > _DEPTH:
            raise Wrong("nested too deep")
        if kind in ("array", "number") or (kind == "list" and "key" in value):
            if answer.array(value.get("key")).ndim and kind == "number":
                raise Wrong("a number of more than one number")
        elif kind in ("tuple", "list"):
            part_of(value, "items", listed(node(answer, depth + 1), 64))
        elif kind in ("dict", "object"):
            part_of(value, "type", short)
            part_of(value, "items", listed(_member(answer, depth + 1), 64))
        elif kind == "other":
            part_of(value, "type", short)
        elif kind not in ("none", "text", "too_large"):
            raise Wrong("a value of no known kind")
        if "key" in value and kind not in ("array", "number", "list"):
            raise Wrong("numbers where there are none")

    return Kind(node, (answer, depth), rule)


def _member(answer: Answer, depth: int) -> Callable[[Any], None]:
    """Return a validator of one dictionary item or attribute: a list of its name and its node."""

    def rule(value: Any) -> None:
        if not isinstance(value, list) or len(value) != 2:
            raise Wrong("a member is a name and a value")
        short(value[0])
        node(answer, depth)(value[1])

    return rule


# --- questions that every lab's sandbox answers ---------------------------------------------------------------------------


def _submit(answer: Answer) -> None:
    answer.part("written", listed(long, 5000))


def _outline(answer: Answer) -> None:
    names = answer.part("names", mapping)
    listed(long, 5000)(list(names))
    for defined in names.values():
        listed(short, _NAMES)(defined)


def _load(answer: Answer) -> None:
    answer.part("names", listed(short, _NAMES))
    answer.part("unreadable", maybe(fault))
    answer.part("supplied", listed(short, _NAMES))
    answer.part("misspelled", listed(listed(short, 2, 2), _NAMES))
    _run_script(answer)


def _run_script(answer: Answer) -> None:
    answer.part("stepped_over", listed(every(fault, _stepped_over), _STATEMENTS))
    drawings(answer)


def _image(answer: Answer) -> None:
    """Check the reply about a decoded picture."""
    if answer.part("readable", flag):
        answer.part("size_px", listed(whole, 2, 2))
        answer.part("colours", whole)
        answer.part("ink", number)
        _pixels(answer)
    else:
        answer.part("reason", short)


def _pixels(answer: Answer) -> None:
    """Check a small picture of 256 colours."""
    preview, palette = (answer.frame.arrays.get(name) for name in ("preview", "palette"))
    if preview is None or palette is None or not preview.dtype == palette.dtype == np.uint8:
        raise Wrong("a picture without pixels")
    if preview.ndim != 2 or not 0 < preview.size <= _MOST_PIXELS or palette.shape != (256, 3):
        raise Wrong(f"a picture of shape {preview.shape} and {palette.shape} colours")


# --- figures -------------------------------------------------------------------------------------------------------------

_entry = record(text=short, colour=short, style=short, marker=short, stroke=short)
_placed = record(text=short, place=listed(number, 2, 2), colour=short)
_AXES: dict[str, Callable[[Any], Any]] = {
    "visible": flag, "position": listed(number, 4, 4), "xlabel": short, "ylabel": short, "title": short,
    "legend": maybe(listed(_entry, 64)), "texts": listed(_placed, 64), "x_limits": listed(number, 2, 2),
    "y_limits": listed(number, 2, 2), "scales": listed(short, 2, 2), "own_ticks": flag, "own_height": flag,
}  # fmt: skip
_CURVE: dict[str, Callable[[Any], Any]] = {
    "label": short, "colour": short, "kind": short, "n": whole, "style": short, "marker": short, "stroke": short,
    "alpha": number, "inks": listed(short, 16), "width": number,
}  # fmt: skip
_FIGURE: dict[str, Callable[[Any], Any]] = {
    "title": short, "xlabel": short, "ylabel": short, "texts": listed(short, 64),
    "legends": listed(listed(_entry, 64), 8), "extent": listed(number, 2, 2), "dots": number,
}  # fmt: skip


def drawings(answer: Answer) -> None:
    """Check the figures of a reply: their facts, small pictures and curves."""
    answer.part("figures", listed(_figure, 16))
    for figure in answer.frame.fields["figures"]:
        if "unreadable" not in figure:
            _check_pixels(answer, figure)
    curves = [c for figure in answer.frame.fields["figures"] for axes in figure["axes"] for c in axes["curves"]]
    if len(curves) > MAX_CURVES:
        raise Wrong(f"{len(curves)} curves")
    for curve in curves:
        points(answer, curve)


def _figure(figure: Any) -> None:
    record(event=short, path=maybe(long), format=short, size_px=listed(whole, 2, 2))(figure)
    unreadable = "unreadable" in figure
    part_of(figure, "axes", listed(record(**_AXES, curves=listed(record(**_CURVE), 64)), 0 if unreadable else 24))
    if not unreadable:
        record(**_FIGURE)(figure)


def _check_pixels(answer: Answer, figure: Mapping[str, Any]) -> None:
    """Check the pixels of a figure: they exist and have the size that the figure states."""
    pixels = answer.frame.arrays.get(str(figure.get("seen")))
    if pixels is None or pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise Wrong("a figure without pixels")
    height, width = pixels.shape[:2]
    if not 0 < min(width, height) <= max(width, height) <= _LONGEST_SIDE:
        raise Wrong(f"a picture of {width} × {height} pixels")
    if max(abs(width - figure["extent"][0]), abs(height - figure["extent"][1])) > 1:
        raise Wrong("a picture of another size than its figure")


def points(answer: Answer, curve: Mapping[str, Any]) -> None:
    x, y = (answer.array(curve.get(name), None) for name in ("x", "y"))
    if len(x) != len(y):
        raise Wrong("a curve with more of x than of y")


_RULES: Mapping[str, Rule] = {
    "submit": _submit, "outline": _outline, "load": _load, "run_script": _run_script, "image": _image,
}  # fmt: skip
_WITHOUT_FAULT = frozenset({"submit", "outline", "load", "image"})
