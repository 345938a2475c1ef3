"""The mutation operators: each turns one place of a file into code that is slightly wrong.

Not mutmut and not cosmic-ray: both run a test command against a changed module in its package, where ours are handed in and graded by
a marker that stays warm; and neither takes away a statement, a copy, a keyword or a text, which is what goes wrong in this lab.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

Change = Iterator[ast.AST | None]
"""What a node may become; None where a statement goes away."""


@dataclass(frozen=True)
class Mutant:
    """A file with one fault: which operator made it, in which function, and what became of which line."""

    file: str
    place: str
    operator: str
    line: int
    change: str
    source: str

    @property
    def key(self) -> str:
        """The same as long as the code is the same, wherever it stands."""
        return f"{self.file} {self.place}: {self.change}"


def mutants(file: str, source: str, skipped: frozenset[str]) -> list[Mutant]:
    """All mutants of a file, those of the `skipped` functions and of annotations, docstrings and imports left out."""
    tree = ast.parse(source)
    alone = {
        node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)
    }  # without its call, such a statement is gone
    places = [(node, place) for node, place in _places(tree, "") if place not in skipped]
    made = [
        m for node, place in places for m in _at(file, source, node, place) if node not in alone or m.operator != "copy"
    ]
    unique = {m.source: m for m in reversed(made)}
    kept = [m for m in made if unique[m.source] is m]
    seen: Counter[str] = Counter()
    numbered = []
    for mutant in kept:
        seen[mutant.key] += 1
        more = f" ({seen[mutant.key]})" if seen[mutant.key] > 1 else ""
        numbered.append(Mutant(file, mutant.place, mutant.operator, mutant.line, mutant.change + more, mutant.source))
    return numbered


# ---------------------------------------------------------------- where


def _places(node: ast.AST, place: str) -> Iterator[tuple[ast.AST, str]]:
    """Every node that is code, with the function or class that it stands in."""
    if isinstance(node, ast.Import | ast.ImportFrom) or _is_guard(node) or _is_list_of_names(node):
        return
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        place = f"{place}.{node.name}" if place else node.name
    yield node, place
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not _is_docstring(child):
                yield from _places(child, place)


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_guard(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and "__name__" in ast.unparse(node.test)


def _is_list_of_names(node: ast.AST) -> bool:
    """Whether it is `__all__`, which mypy reads."""
    return isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"


def _at(file: str, source: str, node: ast.AST, place: str) -> Iterator[Mutant]:
    for name, operator in OPERATORS.items():
        for new in operator(node):
            lines = _replaced(source, node, new)
            old, now = ast.unparse(node), "" if new is None else ast.unparse(new)
            if old == now:
                continue  # two members alike have changed places
            yield Mutant(file, place, name, node.lineno, f"{_one_line(old)} → {_one_line(now) or 'nothing'}", lines)  # type: ignore[attr-defined]


def _one_line(code: str) -> str:
    return " ".join(code.split())


def _replaced(source: str, node: ast.AST, new: ast.AST | None) -> str:
    """The source with one node in its place replaced; everything else stays as it is written."""
    raw = source.encode()
    starts = [0]
    for line in raw.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    begin = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
    end = starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
    text = "pass" if new is None else ast.unparse(new)
    if isinstance(new, ast.expr) and not isinstance(new, ast.Tuple | ast.Slice | ast.Starred):
        text = f"({text})"
    return (raw[:begin] + text.encode() + raw[end:]).decode()


# ---------------------------------------------------------------- operators


def _arithmetic(node: ast.AST) -> Change:
    swaps = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
             ast.Pow: ast.Mult}  # fmt: skip
    if isinstance(node, ast.BinOp) and type(node.op) in swaps:
        yield ast.BinOp(node.left, swaps[type(node.op)](), node.right)


def _sign(node: ast.AST) -> Change:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield node.operand


def _comparison(node: ast.AST) -> Change:
    swaps = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot,
             ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}  # fmt: skip
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        yield ast.Compare(node.left, [swaps[type(node.ops[0])]()], node.comparators)


def _condition(node: ast.AST) -> Change:
    if isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.And() if isinstance(node.op, ast.Or) else ast.Or(), node.values)
    if isinstance(node, ast.IfExp):
        yield ast.IfExp(node.test, node.orelse, node.body)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield node.operand


def _number(node: ast.AST) -> Change:
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int):
        yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.Constant) and isinstance(node.value, float):
        yield ast.Constant(2 * node.value if node.value else 1.0)


def _text(node: ast.AST) -> Change:
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value:
        yield ast.Constant("")


def _statement(node: ast.AST) -> Change:
    if isinstance(node, ast.Expr | ast.Assign | ast.AugAssign | ast.Raise):
        yield None
    if isinstance(node, ast.Return) and node.value is not None:
        yield ast.Return(None)


def _copy(node: ast.AST) -> Change:
    """A call goes, what it was given stays: no copy, no conversion, no rounding."""
    if isinstance(node, ast.Call) and node.args and not isinstance(node.args[0], ast.Starred):
        yield node.args[0]


def _keyword(node: ast.AST) -> Change:
    if isinstance(node, ast.Call):
        for keyword in node.keywords:
            yield ast.Call(node.func, node.args, [k for k in node.keywords if k is not keyword])


def _exchange(node: ast.AST) -> Change:
    """Two neighbours change places: arguments, members of a tuple."""
    if isinstance(node, ast.Call) and not any(isinstance(a, ast.Starred) for a in node.args):
        for i in range(len(node.args) - 1):
            yield ast.Call(node.func, _swapped(node.args, i), node.keywords)
    if isinstance(node, ast.Tuple) and not any(isinstance(e, ast.Slice) for e in node.elts):
        for i in range(len(node.elts) - 1):
            yield ast.Tuple(_swapped(node.elts, i), node.ctx)


def _swapped(items: list[ast.expr], i: int) -> list[ast.expr]:
    return [*items[:i], items[i + 1], items[i], *items[i + 2 :]]


def _bound(node: ast.AST) -> Change:
    if isinstance(node, ast.Slice):
        if node.lower is not None:
            yield ast.Slice(None, node.upper, node.step)
        if node.upper is not None:
            yield ast.Slice(node.lower, None, node.step)


OPERATORS: dict[str, Callable[[ast.AST], Change]] = {
    "arithmetic": _arithmetic,
    "sign": _sign,
    "comparison": _comparison,
    "condition": _condition,
    "number": _number,
    "text": _text,
    "statement": _statement,
    "copy": _copy,
    "keyword": _keyword,
    "exchange": _exchange,
    "bound": _bound,
}
