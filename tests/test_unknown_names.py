"""Which name is taken for which when a function raises for it, and that the function runs with that."""

from __future__ import annotations

import ast
import linecache
from types import ModuleType
from typing import Any

import pytest

from grader.harness import faults, mending, slips, submission

pytestmark = pytest.mark.quick
PATH = "program.py"


@pytest.fixture(autouse=True)
def empty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(submission.STATE, "modules", {})
    monkeypatch.setattr(submission.STATE, "furniture", {"libraries": ("np", "numpy", "plt")})
    monkeypatch.setattr(submission.STATE, "slips", [])


def _run(text: str, *, drawing: bool = False) -> tuple[Any, slips.Slip | None]:
    """What a program's `run` returns in a new process that knows what was noticed in the ones before; and what is noticed now."""
    own, module = faults.own_name(PATH), ModuleType("program")
    linecache.cache[own] = (len(text), None, text.splitlines(keepends=True), own)
    submission.STATE.modules[PATH] = module
    tree = ast.parse(text)
    mending.mend(tree, PATH)
    try:
        exec(compile(tree, own, "exec"), vars(module))
        return vars(module)["run"](), slips.noticed()
    except Exception as raised:
        slips.notice(raised, drawing=drawing)
        return raised, slips.noticed()


def _until_it_runs(text: str, *, drawing: bool = False) -> tuple[Any, list[tuple[str, str]]]:
    taken = submission.STATE.slips
    while True:
        value, slip = _run(text, drawing=drawing)
        if slip is None or slip in taken:
            return value, [(each["own"], each["meant"]) for each in taken]
        taken.append(slip)


def _in_a_class(*lines: str, init: str = "def __init__(self, gain=3):") -> str:
    body = "\n".join(f"        {line}" for line in lines)
    return f"class Filter:\n    {init}\n        self.gain = gain\n    def update(self):\n{body}\ndef run():\n    return Filter().update()"


def _asked(line: str) -> str:
    return f"import numpy as np\ndef run():\n    n, rows = 2, np.ones(2)\n    {line}\n    return n"


MENDED: dict[str, tuple[str, list[tuple[str, str]], Any]] = {
    "a variable": ("def run():\n    total = 1\n    return totl", [("totl", "total")], 1),
    "a letter too many": ("def run():\n    total = 1\n    return tottal", [("tottal", "total")], 1),
    "letters in another order": ("def run():\n    gain = 1\n    return gian", [("gian", "gain")], 1),
    "other capitals": ("def run():\n    x_axis = 1\n    return Xaxis", [("Xaxis", "x_axis")], 1),
    "in an expression with a frame of its own": ("def run():\n    rows = [1, 2]\n    return [rosw[0] for _ in rows]", [("rosw", "rows")], [1, 1]),
    "in a function within": ("def run():\n    total = 1\n    def inner():\n        value = total\n        return vlaue\n    return inner()", [("vlaue", "value")], 1),
    "below a decorator": ("import functools\n@functools.cache\ndef run():\n    total = 1\n    return totl", [("totl", "total")], 1),
    "a global": ("LIMIT = 3\ndef run():\n    return LIMTI", [("LIMTI", "LIMIT")], 3),
    "a built-in": ("def run():\n    return lenn([1])", [("lenn", "len")], 1),
    "twice in a function": ("def run():\n    total = 1\n    return totl + totl", [("totl", "total")], 2),
    "two names": ("def run():\n    total, other = 1, 2\n    return totl + othr", [("totl", "total"), ("othr", "other")], 3),
    "in a helper": ("def helper(total):\n    return totl\ndef run():\n    totl = 2\n    return helper(1) + totl", [("totl", "total")], 3),
    "self of an attribute": (_in_a_class("return gain"), [("gain", "self.gain")], 3),
    "self of a method": (
        "class Filter:\n    def double(self):\n        return 2\n    def update(self):\n        return double()\n"
        "def run():\n    return Filter().update()",
        [("double", "self.double")], 2,
    ),
    "an attribute": (_in_a_class("return self.gian"), [("self.gian", "self.gain")], 3),
    "an attribute that is not kept": (_in_a_class("return self.size", init="def __init__(self, size=4, gain=3):\n        size = size"), [("size", "self.size")], 4),
    "no self": (_in_a_class("return self.gain").replace("update(self)", "update()"), [("self", "self")], 3),
    "no self in __init__": (_in_a_class("return self.gain", init="def __init__(gain=3):"), [("self", "self")], 3),
    "np of a function": ("import numpy as np\ndef run():\n    return int(ones(1)[0])", [("ones", "np.ones")], 1),
    "a function of np": ("import numpy as np\ndef run():\n    return int(np.onse(1)[0])", [("np.onse", "np.ones")], 1),
    "a key": ("def run():\n    data = {'time': 1, 'value': 2}\n    return data['tiem']", [("data['tiem']", "data['time']")], 1),
    "a key as an attribute": ("def run():\n    data = {'time': 1}\n    return data.time", [("data.time", "data['time']")], 1),
    "a keyword": ("def half(width=2):\n    return width // 2\ndef run():\n    return half(widht=4)", [("widht", "width")], 2),
    "what is set": ("class Panel:\n    def set_title(self, text):\n        return text\ndef run():\n    return Panel().title('a')", [("Panel().title", "Panel().set_title")], "a"),
    "of this object alone": (
        "class Panel:\n    def set_title(self, text):\n        return text\nclass Text:\n    title = 'b'\n"
        "def run():\n    panel, text = Panel(), Text()\n    return panel.title('a') + text.title",
        [("panel.title", "panel.set_title")], "ab",
    ),
}  # fmt: skip
MENDED |= {
    "what is called and has to be indexed": (
        "import numpy as np\ndef run():\n    addresses = np.array([4, 5])\n    return int(addresses(1))",
        [("addresses(1)", "addresses[1]")], 5,
    ),
    "an attribute that is called and has to be indexed": (
        "import numpy as np\nclass Model:\n    adr = np.array([4, 5])\ndef run():\n    model = Model()\n    return int(model.adr(1))",
        [("model.adr(1)", "model.adr[1]")], 5,
    ),
    "a fraction of steps": ("def run():\n    n = 6 / 2\n    return [k for k in range(n)] + [n]", [("n", "int(n)")], [0, 1, 2, 3]),
    "a division of steps": ("def run():\n    return len([0 for _ in range(6 / 2)])", [("6 / 2", "int(6 / 2)")], 3),
    "a shape in two parts": (
        "import numpy as np\ndef run():\n    return np.zeros(2, 3).shape", [("np.zeros(2, 3)", "np.zeros((2, 3))")], (2, 3),
    ),
    "what append returns": (
        "def run():\n    rows = []\n    for k in range(3):\n        rows = rows.append(k)\n    return rows",
        [("rows.append(k)", "[*rows, k]")], [0, 1, 2],
    ),
    "a method that is not called": (
        "import numpy as np\ndef run():\n    given = np.ones(2)\n    value = given.copy\n    return (2 * value).tolist()",
        [("given.copy", "given.copy()")], [2.0, 2.0],
    ),
    "a method that is not called, and asked for another": (
        "import numpy as np\ndef run():\n    given = np.ones(2)\n    value = given.copy\n    return value.sum()",
        [("given.copy", "given.copy()")], 2.0,
    ),
    "an array that is asked for its truth": (_asked("if not rows:\n        rows = np.zeros(2)"), [("rows", "rows is not None")], 2),
    "an array that is asked for its truth, and another thing": (
        _asked("if rows and n:\n        n = 5"), [("rows", "rows is not None")], 5,
    ),
    "an array that is asked for its truth by a loop": (_asked("while n < 4 and not (n > 3 or not rows):\n        n += 1"), [("rows", "rows is not None")], 4),
    "an array, or another": (_asked("rows = rows or [1, 2, 3]\n    n = len(rows)"), [("rows", "rows is not None")], 2),
    "an array, or one of two others": (_asked("rows = rows or None or [1, 2, 3]\n    n = len(rows)"), [("rows", "rows is not None")], 2),
    "another, if there is an array": (_asked("rows = rows and [1, 2, 3]\n    n = len(rows)"), [("rows", "rows is not None")], 3),
    "one of two things, as there is an array": (_asked("n = 7 if rows else 8"), [("rows", "rows is not None")], 7),
    "an array that is compared with nothing": (_asked("if rows == None:\n        n = 9"), [("rows == None", "rows is None")], 2),
    "an array that differs from nothing": (_asked("if rows != None:\n        n = 9"), [("rows != None", "rows is not None")], 9),
    "a size that is an array": (
        "import numpy as np\ndef run():\n    rows = np.ones(2)\n    return len(np.random.normal(0, 0.1, size=rows))",
        [("np.random.normal(0, 0.1, size=rows)", "np.random.normal(0, 0.1, size=rows.shape)")], 2,
    ),
    "a size at its place that is an array": (
        "import numpy as np\ndef run():\n    rows = np.ones(2)\n    return len(rows + np.random.normal(0, 0.1, rows))",
        [("np.random.normal(0, 0.1, rows)", "np.random.normal(0, 0.1, rows.shape)")], 2,
    ),
    "a print": (
        "def run():\n    for n in range(3):\n        if n:\n            print(f'{[n]:.2f}',\n                  n)\n    return n",
        [("print(f'{[n]:.2f}', n)", "TypeError: unsupported format string passed to list.__format__")], 2,
    ),
    "a print that is all there is": (
        "def told(n):\n    print('n: ' + n)\ndef run():\n    told(1)\n    return 3",
        [("print('n: ' + n)", 'TypeError: can only concatenate str (not "int") to str')], 3,
    ),
    "a line for a log": (
        "def run():\n    log = None\n    log.info('on')\n    return 3",
        [("log.info('on')", "AttributeError: 'NoneType' object has no attribute 'info'")], 3,
    ),
    "NumPy by its own name": ("import numpy as np\nimport numpy\ndef run():\n    return int(ones(1)[0])", [("ones", "numpy.ones")], 1),
    "a fraction of rows": ("import numpy as np\ndef run():\n    n = 6 / 2\n    return np.zeros((n, 3)).shape", [("n", "int(n)")], (3, 3)),
}  # fmt: skip


@pytest.mark.parametrize(("text", "taken", "value"), MENDED.values(), ids=MENDED)
def test_it_runs_with_what_is_meant(text: str, taken: list[tuple[str, str]], value: Any) -> None:
    assert _until_it_runs(text) == (value, taken)


LEFT = {
    "two fractions": "import numpy as np\ndef run():\n    n, m = 6 / 2, 3.0\n    return np.zeros((n, m))",
    "a type that is none": "import numpy as np\ndef run():\n    return np.zeros(2, dtype='3 x')",
    "an attribute of nothing": "def run():\n    rows = None\n    return rows.appendix(1)",
    "one of two methods": "import numpy as np\ndef run():\n    a = np.ones(2)\n    b = a.copy, a.mean\n    return 2 * b[0]",
    "what is called and is a number": "def run():\n    gain = 1\n    return gain(1)",
    "two arrays that are asked for their truth": "import numpy as np\ndef run():\n    a = b = np.ones(2)\n    return 1 if a and b else 2",
    "an array that is compared with a number": "import numpy as np\ndef run():\n    a = np.ones(2)\n    return 1 if a > 0 else 2",
    "two that are alike": "def run():\n    rows1, rows2 = 1, 2\n    return rows3",
    "a short name": "def run():\n    dt = 1\n    return td",
    "one that nothing resembles": "def run():\n    total = 1\n    return measurement",
    "a member of a library, and a variable": "import numpy as np\ndef run():\n    mena = 1\n    return mean([mena])",
    "raised by hand": "def run():\n    total = 1\n    raise NameError('totl')",
    "a key that nothing resembles": "def run():\n    data = {'time': 1}\n    return data['acceleration']",
    "a key of what is no dictionary": "class Rows:\n    def __getitem__(self, key):\n        raise KeyError(key)\ndef run():\n    rows = Rows()\n    return rows['tiem']",
    "at the top level": "total = 1\ntotl\ndef run():\n    return 1",
    "another exception": "def run():\n    return 1 / 0",
    "an object that will not be looked at": (
        "class Shy:\n    def __dir__(self):\n        raise SystemExit\ndef run():\n    shy = Shy()\n    return shy.name"
    ),
    "more than can be told": (
        "class Panel:\n    def part(self):\n        return self\n    def set_title(self):\n        return 1\n"
        f"def run():\n    panel = Panel()\n    return panel{'.part()' * 40}.title()"
    ),
}  # fmt: skip


@pytest.mark.parametrize("text", LEFT.values(), ids=LEFT)
def test_what_may_mean_anything_is_left(text: str) -> None:
    _, noticed = _run(text)
    assert noticed is None


PARTS = "class Panel:\n    parts = []\n    def add(self, part, size=1):\n        self.parts = [*self.parts, 10 // size * part]\n"


def test_of_a_drawing_the_call_that_raises_is_left_out() -> None:
    text = (
        PARTS
        + "def run():\n    panel = Panel()\n    panel.add(1)\n    panel.add(2, size=0)\n    panel.add(3)\n    return panel.parts"
    )
    assert _run(text)[1] is None
    value, taken = _until_it_runs(text, drawing=True)
    assert (value, [own for own, _ in taken]) == ([10, 30], ["panel.add(2, size=0)"])


def test_a_call_whose_value_is_used_is_not_left_out() -> None:
    assert _run("def run():\n    size = int('a')\n    return size", drawing=True)[1] is None
    assert _run("def run():\n    raise ValueError('a')", drawing=True)[1] is None
    with pytest.raises(SystemExit) as ended:
        _run("def run():\n    exit(3)\n    return 1")
    slips.notice(ended.value, drawing=True)
    assert slips.noticed() is None


def test_it_is_told_where() -> None:
    _, slip = _run("LIMIT = 1\n\n\ndef run():\n    total = 1\n    return totl\n")
    assert slip == {"path": PATH, "function": 4, "at": 6, "kind": "expression", "own": "totl", "meant": "total"}
