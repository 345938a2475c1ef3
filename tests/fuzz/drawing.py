"""Answers drawn from the rules that answers must keep: whatever a rule asks for is made up when it asks, so that it is satisfied.

Values are what code could send that wants to make us stumble: empty, enormous, not finite, constant, almost right.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import inspect

from grader.base.errors import Malformed
from grader.engine import figures, replies
from grader.engine.replies import Answer, Wrong
from grader.sandbox.wire import Frame

_WORDS = (
    "", "x", "time", "acceleration", "angular_velocity", "imu_data.png", "filtered_imu.png", "LowPassFilter", "m/s²", "Acceleration (m/s^2)",
    "deg/s", "Time (s)", "accel x raw", "filtered", "ValueError", "ModuleNotFoundError", "raised", "overran", "ended", "savefig", "png", "#1f77b4",
    "#00000000", "black", "line", "scatter", "steps", "-", "None", "nan", "1e400", "%s {} $\\frac{a}{", "\u202e\x1b[31m", "\0", "ı İ ß ﷺ 🧭",
    "m/s" * 60, "(" * 100, "٣", "-1", "a/b/../c.py", "qpos", "0" * 150,
)  # fmt: skip
_NUMBERS = (0, -0.0, 1, -1, 3, 1e-320, 1e-12, 0.5, 100, 1e12, -1e12)
_WHOLES = (0, 1, -1, 3, 60, 640, 480, 5000, 1_000_000_000, -1_000_000_000)
_LENGTHS = (0, 1, 2, 3, 4, 6, 50, 300)
_TRIES = 12


class Drawn(Answer):
    """An answer that comes into being as its rule looks at it."""

    def __init__(self, frame: Frame, fields: Mapping[str, Any], asked: Mapping[str, np.ndarray], chance: random.Random) -> None:
        super().__init__(frame, fields, asked)
        object.__setattr__(self, "chance", chance)
        object.__setattr__(self, "likely", chance.random())  # how often a value is an ordinary one: of some answers nearly all are

    chance: random.Random
    likely: float

    def array(self, name: Any, *shape: int | None) -> np.ndarray:
        if isinstance(name, str) and name not in self.frame.arrays:
            self.frame.arrays[name] = self.numbers(tuple(self._length(name) if n is None else n for n in shape))
        return super().array(name, *shape)

    # --- values -------------------------------------------------------------------------------------------------------

    def value(self, of: Any, name: str = "") -> Any:
        """A value of a declared type; of some names we know what makes sense."""
        chance = self.chance
        if isinstance(of, inspect.StrType):
            most = of.max_length or 200
            return chance.choice(_WORDS)[:most] if chance.random() < 0.97 else "m" * most
        if isinstance(of, inspect.LiteralType):
            return chance.choice(of.values)
        if isinstance(of, inspect.UnionType):
            return None if chance.random() < 0.3 + 0.6 * self.likely else self.value(of.types[0])
        if isinstance(of, inspect.ListType | inspect.VarTupleType):
            wanted = chance.choice((0, 1, 2, 3, 6)) if chance.random() < 0.95 else 64
            return [self._item(of.item_type, name) for _ in range(self._exactly(name, min(64 if of.max_length is None else of.max_length, wanted)))]
        if isinstance(of, inspect.TupleType):
            return [self.value(each) for each in of.item_types]
        if isinstance(of, inspect.StructType | inspect.DataclassType):
            return {each.name: self.value(each.type, each.name) for each in of.fields if each.name not in _LATER}
        if isinstance(of, inspect.AnyType):
            return None if name != "node" and chance.random() < 0.3 + 0.6 * self.likely else self.made_node(1)
        return chance.choice(_PLAIN[type(of)])

    def _item(self, of: Any, name: str) -> Any:
        if name == "figures":
            return self.figure()
        return self.value(of, "node" if name in ("calls", "later") else "")

    def _exactly(self, name: str, wanted: int) -> int:
        """How many items the rule asks for, where it asks for a number."""
        if name == "cases":
            return len(self.fields["cases"])
        pairs = len(self.asked.get("pairs", "1"))
        return {"calls": pairs * len(self.asked.get("qpos", ())), "later": pairs}.get(name, wanted)

    def made_node(self, depth: int) -> dict[str, Any]:
        """What a student's function may have returned."""
        chance, inner = self.chance, depth < replies._DEPTH - 3
        kinds = ["array", "array", "number", "list", "none", "text", "too_large", "other", *(["tuple", "dict", "object", "items"] * inner)]
        kind = chance.choice(kinds) if chance.random() > self.likely else chance.choice(("tuple", "dict", "array")) if inner else "array"
        if kind in ("array", "number", "list"):
            return {"kind": kind, "key": self._new(() if kind == "number" else self._shape())}
        if kind in ("tuple", "items"):
            return {"kind": "tuple" if kind == "tuple" else "list", "items": [self.made_node(depth + 1) for _ in range(chance.choice((0, 1, 2, 2, 2, 3)))]}
        if kind in ("dict", "object"):
            names = [chance.choice(_WORDS[:6] if chance.random() < 0.8 else _WORDS)[:200] for _ in range(chance.choice((0, 1, 3, 3, 5)))]
            return {"kind": kind, "type": "dict", "items": [[name, self.made_node(depth + 1)] for name in names]}
        return {"kind": kind, "type": "Odd"} if kind == "other" else {"kind": kind}

    def numbers(self, shape: tuple[int, ...]) -> np.ndarray:
        chance, noise = self.chance, np.random.default_rng(self.chance.randrange(2**32))
        of = chance.choice(_SORTS) if chance.random() > self.likely else _ordinary
        with np.errstate(all="ignore"):
            made = np.ascontiguousarray(of(noise, shape), dtype=np.float64)
            if made.size and chance.random() > 0.5 + 0.5 * self.likely:
                made.flat[chance.randrange(made.size)] = chance.choice((np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324))
        made.setflags(write=False)
        return made

    # --- sizes and names ----------------------------------------------------------------------------------------------

    def _length(self, name: str) -> int:
        """Of an axis of which any length will do: mostly one that was asked about."""
        if name.startswith("out") and "cases" in self.fields:
            case = self.fields["cases"][int(name[3:])]
            rows = len(self.asked[case.get("input") or case["accel"]])
            broke_off = self.frame.fields["cases"][int(name[3:])]["error"] is not None
            return self.chance.choice((0, 1, rows // 2, rows)) if broke_off else rows
        whole = [int(n) for array in self.asked.values() for n in array.shape] + [int(self.fields.get("steps", 1))]
        return self.chance.choice((*whole, *_LENGTHS))

    def _shape(self) -> tuple[int, ...]:
        rows = self._length("")
        return self.chance.choice(((3,), (3,), (rows,), (rows, 3), (rows, 3), (6,), (2, 3), (), (1, 1, 3), (0, 3), (3, rows), (rows, 1), (5, 1, 2)))

    def _new(self, shape: tuple[int, ...]) -> str:
        name = f"n{len(self.frame.arrays)}"
        self.frame.arrays[name] = self.numbers(shape)
        return name

    def _furnished(self, name: str, value: Any) -> Any:
        """With the names of arrays that the rule will look for."""
        if name == "cases":
            for number, case in enumerate(value):
                broke_off = case["error"] is not None and self.chance.random() < 0.3
                case["output"] = None if broke_off else f"out{number}"
        if name == "curves":
            return [{**curve, **self._points()} for curve in value]
        return value

    def _points(self) -> dict[str, str]:
        rows = self._length("")
        return {"x": self._new((rows,)), "y": self._new((rows,))}

    def figure(self) -> dict[str, Any]:
        panels = [{**self.value(_AXES), "curves": self._curves()} for _ in range(self.chance.choice((0, 1, 2, 2, 2, 3, 6)))]
        facts = self.value(_FIGURE)
        head = {name: facts[name] for name in ("event", "path", "format", "size_px")}
        if self.chance.random() < 0.7:
            head |= {"event": "savefig", "path": self.chance.choice(("imu_data.png", "filtered_imu.png")), "format": "png"}
        if self.chance.random() < 0.1:
            return {**head, "unreadable": "OSError", "axes": []}
        return {**facts, **head, "legends": [self.value(_LEGEND)], "axes": panels}

    def _curves(self) -> list[dict[str, Any]]:
        count = self.chance.choice((0, 1, 3, 3, 3, 6))
        return [{**self.value(_CURVE), **self._points()} for _ in range(count)]


def _ordinary(noise: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return noise.normal(size=shape) + np.where(np.arange(shape[-1] if shape else 1) % 3 == 2, -9.81, 0.0).reshape(-1)[: shape[-1] if shape else None]


_SORTS: tuple[Callable[[np.random.Generator, tuple[int, ...]], Any], ...] = (
    lambda noise, shape: np.zeros(shape),
    lambda noise, shape: np.full(shape, np.nan),
    lambda noise, shape: np.full(shape, 1.7e308) * noise.choice((1.0, -1.0), size=shape),
    lambda noise, shape: np.full(shape, 5e-324),
    lambda noise, shape: noise.normal(size=shape) * 10.0 ** noise.integers(-300, 300, size=shape),
    lambda noise, shape: np.arange(int(np.prod(shape)), dtype=float).reshape(shape),
    lambda noise, shape: noise.integers(-3, 3, size=shape),
    lambda noise, shape: np.cumsum(noise.normal(size=shape), axis=0) if shape else np.array(1.0),
    lambda noise, shape: np.where(noise.random(shape) < 0.5, np.nan, 1.0),
)
_PLAIN: Mapping[Any, Any] = {inspect.IntType: _WHOLES, inspect.FloatType: _NUMBERS, inspect.BoolType: (False, True), inspect.DictType: ({},)}
_LATER = frozenset({"visible_parts", "pixels", "x", "y"})
"""Fields of records that are made from arrays, or by us."""
_AXES, _FIGURE, _CURVE = (inspect.type_info(of) for of in (figures.Axes, figures.Figure, figures.Curve))
_LEGEND = inspect.type_info(tuple[figures.Entry, ...])


def drawn(
    op: str, fields: Mapping[str, Any], asked: Mapping[str, np.ndarray], rules: Mapping[str, replies.Rule], chance: random.Random,
    like: Frame | None = None,
) -> Frame | None:  # fmt: skip
    """An answer to a question that its rule takes; None where chance made none.

    Parameters
    ----------
    like : an answer to it, whose shape is kept and of whose numbers many are replaced
    """
    for _ in range(_TRIES):
        answer = Drawn(Frame(dict(like.fields) if like else {}, dict(like.arrays) if like else {}), fields, asked, chance)
        if like is not None:
            _replace_some(answer)
        elif op == "simulate":
            _start_of(answer)
        elif op == "image":
            _pixels_of(answer)
        try:
            rule = {**replies.RULES, **rules}[op]
            if like is None:
                told = answer.value(inspect.type_info(rule.reply))
                answer.frame.fields.update({name: answer._furnished(name, value) for name, value in told.items()})
            rule.arrays(answer, replies.converted(answer.frame.fields, rule.reply))
            return replies.checked(op, Frame(answer.frame.fields, answer.frame.arrays), fields, asked, rules)
        except (Wrong, Malformed):
            continue
    return None


def _replace_some(answer: Drawn) -> None:
    """Other numbers in the same places."""
    for name, array in answer.frame.arrays.items():
        if array.dtype == np.float64 and answer.chance.random() > answer.likely:
            answer.frame.arrays[name] = answer.numbers(array.shape)
    if answer.chance.random() > answer.likely and answer.frame.fields.get("error") is None:
        answer.frame.fields["error"] = answer.value(inspect.type_info(replies.ErrorReply | None))


def _pixels_of(answer: Drawn) -> None:
    noise = np.random.default_rng(answer.chance.randrange(99))
    size = answer.chance.choice(((1, 1), (1, 640), (480, 640), (3, 2)))
    answer.frame.arrays["preview"] = noise.integers(0, answer.chance.choice((1, 2, 64)), size=size).astype(np.uint8)
    answer.frame.arrays["palette"] = noise.integers(0, 256, size=(256, 3)).astype(np.uint8)


_FIRST = {
    "first_qpos": (29,), "first_qvel": (28,), "first_gravity": (3,), "first_timestep": (1,), "first_steps": (1,), "first_force": (28,),
    "first_set_at": (2,), "first_set_qpos": (2, 29), "first_set_qvel": (2, 28), "first_set_force": (2, 28),
}  # fmt: skip


def _start_of(answer: Drawn) -> None:
    """The state of a first step: with sizes of its own in places."""
    for name, shape in _FIRST.items():
        if answer.chance.random() < 0.5 + 0.5 * answer.likely:
            odd = answer.chance.random() > 0.5 + 0.5 * answer.likely
            answer.frame.arrays[name] = answer.numbers((*shape[:-1], answer._length("")) if odd else shape)
