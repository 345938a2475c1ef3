"""What each edit of one line costs: `python -m tests.benchmarks.one_line [verbatim|tidy [EVERY]]`.

Every statement of a sound submission is left out, written twice and exchanged with the next; every number, operator, comparison,
argument, text and name in it is changed, one at a time. Nobody judged these edits beforehand, and most were foreseen by nobody.
Printed are those that cost, with what they cost; those that cost in two criteria, or in two checks of one that can both be asked, come
last: there one fault may have been charged twice.
"""

from __future__ import annotations

import argparse
import ast
import random
from collections.abc import Callable, Iterator, Sequence
from itertools import islice

from grader.engine import rubric
from grader.engine.grader import Marker
from grader.engine.results import CheckResult, Result
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import tidy, verbatim
from tests.corpus.writing import Files

_OPPOSITE = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
_NOT = {ast.Is: "is not", ast.IsNot: "is", ast.Lt: ">=", ast.Gt: "<=", ast.Eq: "!="}
_DEFINITIONS = (ast.FunctionDef, ast.ClassDef)
Edit = tuple[str, str]
"""What was done where, and the file's text after it."""


class _File:
    """One file's text, its tree, and the ways to change a line of it."""

    def __init__(self, text: str) -> None:
        self.text, self.lines, self.tree = text, text.split("\n"), ast.parse(text)
        self._random = random.Random(1)

    def edits(self) -> Iterator[Edit]:
        for node in ast.walk(self.tree):
            for body in (getattr(node, "body", None), getattr(node, "orelse", None)):
                if isinstance(body, list) and body:
                    yield from self._of_statements(body)
            if isinstance(node, ast.expr) and node.lineno == node.end_lineno:
                yield from self._of_expression(node)
            if isinstance(node, ast.FunctionDef):
                yield from self._of_names(node)

    def _of_statements(self, body: Sequence[ast.stmt]) -> Iterator[Edit]:
        for statement, following in zip(body, [*body[1:], None], strict=True):
            if isinstance(statement, _DEFINITIONS) or _is_text(statement):
                continue
            first, end = statement.lineno - 1, statement.end_lineno or 0
            indent = " " * statement.col_offset
            yield self._lines(
                "left out", [*self.lines[:first], f"{indent}pass", *self.lines[end:]], first, self.lines[first]
            )
            yield self._lines("twice", [*self.lines[:end], *self.lines[first:]], first)
            if following is not None and not isinstance(following, _DEFINITIONS):
                start, stop = following.lineno - 1, following.end_lineno or 0
                order = [(start, stop), (end, start), (first, end)]
                moved = [line for part in order for line in self.lines[slice(*part)]]
                yield self._lines(
                    "after the next", [*self.lines[:first], *moved, *self.lines[stop:]], first, self.lines[first]
                )

    def _of_expression(self, node: ast.expr) -> Iterator[Edit]:
        put = self._put
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
            yield put("number", node, repr(node.value + 1 if isinstance(node.value, int) else node.value * 2))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and not self._of(node).startswith('"""'):
            yield put("text", node, f"{self._of(node)[:-1]}x{self._of(node)[-1]}")
        elif isinstance(node, ast.BinOp):
            left, right = self._of(node.left), self._of(node.right)
            if type(node.op) in _OPPOSITE:
                yield put("operator", node, f"({left}) {_OPPOSITE[type(node.op)]} ({right})")
            yield put("left side alone", node, f"({left})")
            yield put("right side alone", node, f"({right})")
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in _NOT:
            yield put(
                "comparison", node, f"{self._of(node.left)} {_NOT[type(node.ops[0])]} {self._of(node.comparators[0])}"
            )
        elif isinstance(node, ast.UnaryOp):
            yield put("no sign", node, self._of(node.operand))
        elif isinstance(node, ast.Tuple) and len(node.elts) == 2:
            yield put("exchanged", node, f"({self._of(node.elts[1])}, {self._of(node.elts[0])})")
        elif isinstance(node, ast.Call):
            yield from self._of_call(node)

    def _of_call(self, node: ast.Call) -> Iterator[Edit]:
        given = [self._of(each) for each in (*node.args, *node.keywords)]
        called = self._of(node.func)
        if isinstance(node.func, ast.Attribute) and not given:
            yield self._put("no call", node, self._of(node.func.value))
        for n in range(len(given)):
            yield self._put("no argument", node, f"{called}({', '.join([*given[:n], *given[n + 1 :]])})")
        for n in range(len(node.args) - 1):
            swapped = [*given[:n], given[n + 1], given[n], *given[n + 2 :]]
            yield self._put("arguments exchanged", node, f"{called}({', '.join(swapped)})")

    def _of_names(self, function: ast.FunctionDef) -> Iterator[Edit]:
        names = sorted({each.id for each in ast.walk(function) if isinstance(each, ast.Name)})
        kept = sorted({each.attr for each in ast.walk(self.tree) if _is_of_self(each)})
        for node in ast.walk(function):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and len(names) > 1:
                yield self._put("another name", node, self._random.choice([name for name in names if name != node.id]))
            if isinstance(node, ast.Attribute) and _is_of_self(node) and len(kept) > 1:
                other = self._random.choice([name for name in kept if name != node.attr])
                yield self._put("another attribute", node, f"self.{other}")

    def _of(self, node: ast.AST) -> str:
        return ast.get_source_segment(self.text, node) or ""

    def _put(self, what: str, node: ast.expr, new: str) -> Edit:
        line = self.lines[node.lineno - 1].encode()
        changed = (line[: node.col_offset] + new.encode() + line[node.end_col_offset :]).decode()
        at = node.lineno - 1
        return self._lines(what, [*self.lines[:at], changed, *self.lines[at + 1 :]], at)

    def _lines(self, what: str, lines: list[str], at: int, shown: str = "") -> Edit:
        return f"{at + 1}, {what}: {' '.join((shown or lines[at]).split())[:80]}", "\n".join(lines)


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _is_of_self(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self"


def edited(files: Files) -> Iterator[tuple[str, Files]]:
    """Every such edit of a submission that is still Python."""
    for path, content in files.items():
        if path.endswith(".py"):
            for what, text in _File(str(content)).edits():
                try:
                    ast.parse(text)
                except SyntaxError:
                    continue
                yield f"{path}:{what}", {**files, path: text}


def charged(result: Result) -> list[CheckResult]:
    """The checks that cost points and could be asked."""
    checks = [check for part in result.criteria for check in part.checks]
    return [check for check in checks if check.points != check.max_points and check.outcome != "skipped"]


def costs_twice(lost: Sequence[CheckResult]) -> bool:
    return len({check.id.split(".")[0] for check in lost}) > 1


_SOURCES: dict[str, Callable[[], Files]] = {"verbatim": verbatim, "tidy": tidy}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.one_line", description=__doc__)
    parser.add_argument("layout", nargs="?", choices=_SOURCES, default="verbatim")
    parser.add_argument("every", nargs="?", type=int, default=1, help="mark every so manyth edit")
    options = parser.parse_args()
    counted, twice, several = 0, [], []
    with Marker(rubric.load(LAB), bundles.shipped()) as marker:
        for name, files in islice(edited(_SOURCES[options.layout]()), 0, None, options.every):
            content = {path: text if isinstance(text, bytes) else text.encode() for path, text in files.items()}
            result = marker.mark(Submission("s", "s", content, (), "ready", ""))
            counted, lost = counted + 1, charged(result)
            if lost:
                line = f"{result.score:6.2f} {name}  {' '.join(f'{c.id} {(c.points or 0) - c.max_points:+g}' for c in lost)}"
                print(line, flush=True)
                twice += [line] if costs_twice(lost) else []
                several += [line] if len(lost) > 1 and not costs_twice(lost) else []
    print(
        f"\n{counted} edits; in two criteria {len(twice)}, in two checks of one {len(several)}:",
        *twice,
        *several,
        sep="\n",
    )


if __name__ == "__main__":
    main()
