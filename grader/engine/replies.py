"""Types and rules for replies of the sandbox. A reply that breaks them is `Malformed`: the check fails, and the grader goes on.

`sandbox.wire` has already checked the frame (message) that holds a reply. Here each question has a `Rule`: the reply's fields must
fit a type, which also limits their size, and the arrays that they name must have the shapes that the question requires. So no check
gets a value that the worker code could not have sent, even if student code wrote the reply.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any, NamedTuple

import msgspec
import numpy as np
from msgspec import Meta, Struct

from grader.base.errors import Malformed
from grader.engine.figures import Figure, Pixels, decode_figures
from grader.engine.reply_types import Long, Names, Number, Short, Whole
from grader.sandbox.wire import Frame

MAX_NUMBERS = 600_000
"""Largest number of elements in an array that a student's function returned; 100 times what the lab asks for."""
MAX_CURVES = 240
"""Largest number of curves in all figures of one reply."""
_DEPTH = 6
_MOST_ITEMS = 64  # of a list or an object that a student's function returned
_MOST_PIXELS = 640 * 640
_LONGEST_SIDE = 640

Paths = Annotated[list[Long], Meta(max_length=5000)]


class Wrong(Exception):  # noqa: N818 - it never leaves this module
    """Exception for a reply that breaks a rule, which becomes `Malformed`; the message says where."""


Asked = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Answer:
    """A reply (`frame`) to validate, and the `fields` and arrays (`asked`) of its question, from which the right shapes follow.

    `array` refuses a name that the reply used before (`named`): else a small reply, naming a large array often, could fill memory.
    """

    frame: Frame
    fields: Mapping[str, Any]
    asked: Asked
    named: set[str] = field(default_factory=set)

    def array(self, name: Any, *shape: int | None) -> np.ndarray:
        """Return the float64 array `name` of the reply. In `shape`, None stands for any length; without a shape, any is right.

        Raises
        ------
        Wrong
            If there is no such array of this shape, the reply names it in two places, or it has over `MAX_NUMBERS` values.
        """
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

    def node(self, value: Any, depth: int = 0) -> None:
        """Check a node: a description, made by `worker.values`, of a value from student code; None (no value) passes at depth 0.

        `depth` is the number of nodes that this one is nested in.

        Raises
        ------
        Wrong
            If the node breaks a rule, such as a limit on its size or depth.
        """
        if value is None and not depth:
            return
        node = converted(value, _Node)
        if depth > _DEPTH:
            raise Wrong("nested too deep")
        if node.kind in ("array", "number") or (node.kind == "list" and node.key is not None):
            if self.array(node.key).ndim and node.kind == "number":
                raise Wrong("a number of more than one number")
        elif node.key is not None:
            raise Wrong("numbers where there are none")
        elif node.kind in ("tuple", "list"):
            self.nodes(node.items, _MOST_ITEMS, depth=depth + 1)
        elif node.kind in ("dict", "object"):
            members = converted(node.items, list[tuple[Short, Any]])
            self.nodes([member for _, member in members], _MOST_ITEMS, depth=depth + 1)
        elif node.kind not in ("none", "text", "too_large", "other"):
            raise Wrong("a value of no known kind")

    def nodes(self, values: Any, most: int, exactly: int | None = None, depth: int = 1) -> None:
        """Check each item of the list `values` with `node`, at the nesting depth `depth`.

        Raise `Wrong` for a bad item, for more than `most` items, and for another number of items than `exactly` (None: any number).
        """
        if not isinstance(values, list) or len(values) > most or exactly not in (None, len(values)):
            raise Wrong("no list, or one of another length")
        for value in values:
            self.node(value, depth)


class Rule(NamedTuple):
    """Rule for the reply to one kind of question: the type that its fields must fit, and a function that checks its arrays."""

    reply: type[Struct]
    arrays: Callable[[Answer, Any], None]


def checked(op: str, frame: Frame, fields: Mapping[str, Any], arrays: Asked, rules: Mapping[str, Rule]) -> Frame:
    """Return the reply `frame` if it is valid for the question `op`, which was sent with these `fields` and `arrays` (by name).

    `rules` are those for the lab's own questions, by `op`; every lab has `RULES`.

    Raises
    ------
    Malformed
        If the reply breaks a rule.
    """
    rule = {**RULES, **rules}[op]
    try:
        rule.arrays(Answer(frame, fields, arrays), converted(frame.fields, rule.reply))
    except Wrong as wrong:
        raise Malformed(f"what came back is no answer to {op!r}: {wrong}") from None
    return frame


def converted(value: Any, type_: Any) -> Any:
    """Return the value as an instance of this type; raise `Wrong`, with the place of the error, if it does not fit."""
    try:
        return msgspec.convert(value, type_)
    except msgspec.ValidationError as error:
        raise Wrong(str(error)) from None


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(shape) == len(wanted) and all(w in (None, n) for n, w in zip(shape, wanted, strict=True))


def no_arrays(answer: Answer, reply: Any) -> None:
    """Check nothing and accept the reply: the function of a `Rule` whose replies have no arrays to check."""


# --- replies that every lab's sandbox gives ------------------------------------------------------------------------------


class _Node(Struct):
    kind: Short
    type: Short = ""
    key: str | None = None
    items: Any = None


class ErrorReply(Struct):
    """The part of a sandbox's reply that describes an exception of student code; `StudentError` documents its fields."""

    type: Short
    message: Long
    file: Short | None
    line: Whole | None
    text: Long | None
    name: Short | None


class SteppedOver(ErrorReply):
    """A statement that failed while the worker loaded a file, and was skipped, so that the rest of the file could be judged."""

    path: Long
    number: Whole
    at: Whole
    how: Short
    defines: Names
    within: Names


class Called(Struct):
    """Reply to a question that runs student code. If the code raised `error`, the reply has only the results before that."""

    error: ErrorReply | None = None


class Drawings(Called, kw_only=True):
    """Reply with figures that student code drew; the function `drawings` checks each figure and its arrays."""

    figures: Annotated[list[dict[str, Any]], Meta(max_length=16)]


class Submit(Struct):
    written: Paths


class Outline(Struct):
    names: Annotated[dict[Long, Names], Meta(max_length=5000)]


class RunScript(Drawings, kw_only=True):
    stepped_over: Annotated[list[SteppedOver], Meta(max_length=40)]


class Load(RunScript, kw_only=True):
    names: Names
    unreadable: ErrorReply | None
    supplied: Names
    misspelled: Annotated[list[tuple[Short, Short]], Meta(max_length=64)]


class Image(Struct):
    """Reply about a handed-in picture: its size, number of colours and share of drawn pixels (`ink`); or why it is unreadable."""

    readable: bool
    reason: Short = ""
    size_px: tuple[Whole, Whole] | None = None
    colours: Whole | None = None
    ink: Number | None = None


def _image(answer: Answer, reply: Image) -> None:
    if reply.readable and None in (reply.size_px, reply.colours, reply.ink):
        raise Wrong("a picture without its size")
    if reply.readable:
        _pixels(answer)
    elif not reply.reason:
        raise Wrong("no picture, and no reason")


def _pixels(answer: Answer) -> None:
    """Check that a reply holds a small picture with a palette of 256 colours."""
    preview, palette = (answer.frame.arrays.get(name) for name in ("preview", "palette"))
    if preview is None or palette is None or not preview.dtype == palette.dtype == np.uint8:
        raise Wrong("a picture without pixels")
    if preview.ndim != 2 or not 0 < preview.size <= _MOST_PIXELS or palette.shape != (256, 3):
        raise Wrong(f"a picture of shape {preview.shape} and {palette.shape} colours")


# --- figures -------------------------------------------------------------------------------------------------------------


class Points(Struct):
    """Names of the two arrays of a reply, of one length, that hold the coordinates of points."""

    x: str
    y: str


def drawings(answer: Answer, reply: Drawings) -> None:
    """Check the figures of a reply, with their pixels and curves; raise `Wrong` if they break a rule."""
    try:
        figures = decode_figures(answer.frame, partial(_figure_array, answer))
    except (ValueError, msgspec.ValidationError, TypeError, KeyError, AttributeError) as error:
        raise Wrong(f"no figure: {error}") from None
    for figure in figures:
        _check_pixels(figure)
    curves = [curve for figure in figures for axes in figure.axes for curve in axes.curves]
    if len(curves) > MAX_CURVES:
        raise Wrong(f"{len(curves)} curves")
    if any(len(curve.x) != len(curve.y) for curve in curves):
        raise Wrong("a curve with more of x than of y")


def _figure_array(answer: Answer, type_: Any, name: Any) -> np.ndarray:
    """Return an array that a figure of the reply names: pixels if `type_` is `Pixels`, else the coordinates of a curve."""
    if type_ != Pixels:
        return answer.array(name, None)
    pixels = answer.frame.arrays.get(str(name))
    if pixels is None or pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
        raise Wrong("a figure without pixels")
    return pixels


def _check_pixels(figure: Figure) -> None:
    """Check that a figure's pixels are not too many and have the size that the figure states; an unreadable figure has none."""
    height, width = figure.pixels.shape[:2]
    if max(width, height) > _LONGEST_SIDE:
        raise Wrong(f"a picture of {width} × {height} pixels")
    if max(abs(width - figure.extent[0]), abs(height - figure.extent[1])) > 1:
        raise Wrong("a picture of another size than its figure")


def points(answer: Answer, curves: Iterable[Points]) -> None:
    for curve in curves:
        if len(answer.array(curve.x, None)) != len(answer.array(curve.y, None)):
            raise Wrong("a curve with more of x than of y")


RULES: Mapping[str, Rule] = {
    "submit": Rule(Submit, no_arrays), "outline": Rule(Outline, no_arrays), "load": Rule(Load, drawings),
    "run_script": Rule(RunScript, drawings), "image": Rule(Image, _image),
}  # fmt: skip
