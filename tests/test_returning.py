"""What a function would return that lacks its last line: a table of functions, and what they return then."""

from __future__ import annotations

import ast

import pytest

from grader.harness.returning import Kind, completed

WANTED: dict[str, Kind] = {"pair": "pair", "mapping": "mapping", "Low.update": "value", "Low.read": "pair"}
PAIR, MAPPING = "def pair():\n", "def mapping():\n"
UPDATE, READ = "class Low:\n    def update(self, x):\n", "class Low:\n    def read(self):\n"
LAST = {
    "the last two": (PAIR, "a = 1\nb = 2\nc = 3", "b, c"),
    "in the order in which they came": (PAIR, "a = 1\nb = 2\na -= 1\na += b", "a, b"),
    "set at once": (PAIR, "b, c = both()", "b, c"),
    "kept as a pair": (READ, "a = b = 1\nself.last = (a, b)\nself.reads += 1", "self.last"),
    "printed": (PAIR, "a = b = 1\nprint('here:', f'{a}', a, b)", "a, b"),
    "without the word": (PAIR, "a = b = 1\na, b", "a, b"),
    "with a print now and then": (READ, "a = 1\nb = 2\nif self.loud:\n    print(a)", "a, b"),
    "a dictionary": (MAPPING, "found = {'a': 1}\nprint('done')", "found"),
    "made by a call": (MAPPING, "found = dict(a=1)", "found"),
    "filled by a loop": (MAPPING, "found = {'a': [0]}\nfor k in range(1):\n    found['a'][k] = 1", "found"),
    "several that a loop fills": (
        MAPPING, "a, b = [0], []\nfor k in range(1):\n    a[k] = 1\n    b.append(k)\na = tuple(a)", "{'a': a, 'b': b}",
    ),
    "by itself": (MAPPING, "{'a': 1}", "{'a': 1}"),
    "of both branches": (
        UPDATE, "if self.y is None:\n    self.y = x\nelse:\n    self.y = 2 * x", "__import__('copy').copy(self.y)",
    ),
    "of the one that ends": (UPDATE, "if self.y is None:\n    return x\nelse:\n    y = 2 * x", "y"),
    "after the first": (
        UPDATE, "if self.y is None:\n    self.y = x\n    return x\nself.y = 2 * x\nself.all.append(x)",
        "__import__('copy').copy(self.y)",
    ),
}  # fmt: skip
LEFT_ALONE = {
    "returns": (PAIR, "a = 1\nb = 2\nreturn a, b"),
    "returns in each branch": (UPDATE, "if self.y is None:\n    return x\nelse:\n    return 2 * x"),
    "returns before": (UPDATE, "self.y = x\nif x:\n    return 1\nself.all.append(x)"),
    "branches that differ": (UPDATE, "if self.y is None:\n    self.y = x\nelse:\n    y = 2 * x"),
    "raises": (UPDATE, "self.y = x\nraise ValueError"),
    "ends with a loop that fills nothing": (MAPPING, "found = {}\nfor name in 'ab':\n    print(name)"),
    "ends with a loop that returns": (MAPPING, "found = {}\nfor name in 'ab':\n    found[name] = 1\n    return found"),
    "ends with a loop where a value is wanted": (UPDATE, "for k in range(3):\n    self.y[k] = x[k]"),
    "three at once": (PAIR, "a, b, c = three()"),
    "one alone": (PAIR, "a = 1"),
    "no dictionary": (MAPPING, "found = 1"),
    "parts of an array": (PAIR, "both[0] = 1\nboth[1] = 2"),
    "a text": (UPDATE, "'''What it does.'''"),
    "a generator": (PAIR, "a = 1\nb = 2\nyield a"),
    "of another name": ("def other():\n", "a = 1\nb = 2"),
}


def _file(head: str, body: str) -> ast.Module:
    indent = "        " if head.startswith("class") else "    "
    return ast.parse(head + "".join(f"{indent}{line}\n" for line in body.split("\n")))


@pytest.mark.parametrize(("head", "body", "value"), LAST.values(), ids=LAST)
def test_what_stands_last_is_returned(head: str, body: str, value: str) -> None:
    tree = _file(head, body)
    assert list(completed(tree, WANTED).values()) == [True]
    added = ast.unparse(tree).splitlines()[-1].strip()
    assert added.replace("(", "").replace(")", "") == f"return {value}".replace("(", "").replace(")", "")
    compile(tree, "file.py", "exec")


@pytest.mark.parametrize(("head", "body"), LEFT_ALONE.values(), ids=LEFT_ALONE)
def test_nothing_is_added_where_a_function_says_what_it_returns_or_leaves_nothing(head: str, body: str) -> None:
    tree = _file(head, body)
    assert not any(completed(tree, WANTED).values())
    assert ast.unparse(tree) == ast.unparse(_file(head, body))


def test_of_several_definitions_the_last_one_is_told_of() -> None:
    silent, sound = PAIR + "    a, b = both()\n", PAIR + "    return both()\n"
    assert completed(ast.parse(silent + sound), WANTED) == {"pair": False}
    assert completed(ast.parse(sound + silent), WANTED) == {"pair": True}
