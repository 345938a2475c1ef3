"""Which name is taken for which when a function raises for it, and that the function runs with that."""

from __future__ import annotations

import ast
import linecache
import re
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


def _as_later(written: str) -> str:
    """A statement as Python writes it from 3.11 on: no brackets around several names that are set."""
    return re.sub(r"^\((\w+(?:, \w+)+)\) =", r"\1 =", written)


def _until_it_runs(text: str, *, drawing: bool = False) -> tuple[Any, list[tuple[str, str]]]:
    taken = submission.STATE.slips
    while True:
        value, slip = _run(text, drawing=drawing)
        if slip is None or slip in taken:
            return value, [(_as_later(each["own"]), each["meant"]) for each in taken]
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
    "a row that is put below others": (
        "import numpy as np\ndef run():\n    rows, row = np.zeros((1, 3)), np.ones(3)\n    return np.append(rows, row, axis=0).shape",
        [("row", "[row]")], (2, 3),
    ),
    "one of two that are put together": (
        "import numpy as np\ndef run():\n    rows, row = np.zeros((1, 3)), np.ones(3)\n    return np.concatenate([rows, row]).shape",
        [("row", "[row]")], (2, 3),
    ),
    "columns that were forgotten": (
        "import numpy as np\ndef run():\n    row, rows = np.ones(3), np.zeros(2)\n    rows = np.zeros(2)\n    rows[1] = row\n"
        "    return rows.shape".replace("row, rows = np.ones(3), np.zeros(2)", "row = np.ones(3)"),
        [("rows = np.zeros(2)", "rows = np.zeros((2, 3))")], (2, 3),
    ),
    "another number of columns": (
        "import numpy as np\ndef run():\n    rows = np.empty((2, 4))\n    rows[0], n = np.ones(3), 1\n    return rows.shape",
        [("rows = np.empty((2, 4))", "rows = np.empty((2, 3))")], (2, 3),
    ),
    "columns in place of rows": (
        "import numpy as np\ndef run():\n    rows = np.zeros((3, 5))\n    rows[4 - 3], other = np.ones(3), 1\n    return rows.shape",
        [("rows = np.zeros((3, 5))", "rows = np.zeros((5, 3))")], (5, 3),
    ),
    "a row for two arrays at once": (
        "import numpy as np\ndef read():\n    return np.ones(3), np.ones(3)\ndef run():\n    a, b = np.zeros((2, 3)), 1\n    b = np.zeros(2)\n"
        "    a[0], b[0] = read()\n    return a.shape, b.shape".replace("a, b = np.zeros((2, 3)), 1", "a = np.zeros((2, 3))"),
        [("b = np.zeros(2)", "b = np.zeros((2, 3))")], ((2, 3), (2, 3)),
    ),
    "a column too many for what is indexed twice": (
        "import numpy as np\ndef run():\n    row, rows = np.ones(3), 1\n    rows = np.zeros(2)\n    rows[1, :] = row\n    return rows.shape"
        .replace("row, rows = np.ones(3), 1", "row = np.ones(3)"),
        [("rows = np.zeros(2)", "rows = np.zeros((2, 3))")], (2, 3),
    ),
    "a draw of another number": (
        "import numpy as np\ndef run():\n    return (np.ones(3) + np.random.normal(0, 1, size=4)).shape",
        [("np.random.normal(0, 1, size=4)", "np.random.normal(0, 1, size=3)")], (3,),
    ),
    "a draw of another number, at its place": (
        "import numpy as np\ndef run():\n    return (np.random.normal(0, 1, 2) + np.ones(3)).shape",
        [("np.random.normal(0, 1, 2)", "np.random.normal(0, 1, 3)")], (3,),
    ),
    "arrays of one number where a slice has two": (
        "import numpy as np\ndef run():\n    first, n = np.array([1]), np.array([2])\n    return len(np.ones(9)[first:first + n])",
        [("first", "first[0]"), ("n", "n[0]")], 2,
    ),
    "a list that is computed with": (
        "class Filter:\n    def __init__(self):\n        self.value = None\n    def update(self, given):\n"
        "        if self.value is None:\n            self.value = [given]\n        else:\n            self.value = 0.5 * self.value\n"
        "        return self.value\ndef run():\n    kept = Filter()\n    return kept.update(4.0)[0], kept.update(4.0)[0]",
        [("self.value", "np.asarray(self.value)")], (4.0, 2.0),
    ),
    "a place of a list that is still empty": (
        "def run():\n    rows = []\n    for n in range(3):\n        rows[n] = 2 * n\n    return rows",
        [("rows[n] = 2 * n", "rows.append(2 * n)")], [0, 2, 4],
    ),
    "what is given in another order": (
        "def read(model, data, first, second):\n    return model.n + data[first] + data[second]\nclass Model:\n    n = 1\n"
        "def run():\n    model, data, a, b = Model(), [10, 20], 0, 1\n    return read(a, b, model, data)",
        [("read(a, b, model, data)", "read(model, data, a, b)")], 31,
    ),
    "what is not given": (
        "def read(model, data, first):\n    return model + data[first]\nclass Reader:\n    def __init__(self):\n"
        "        self.model, self.data = 1, [10]\n    def both(self):\n        return read(self.data, 0)\ndef run():\n    return Reader().both()",
        [("read(self.data, 0)", "read(self.model, self.data, 0)")], 11,
    ),
    "what a compiled function is given in another order": (
        "import mujoco\nmodel = mujoco.MjModel.from_xml_string('<mujoco/>')\ndata = mujoco.MjData(model)\n"
        "def run():\n    mujoco.mj_step(data, model)\n    return data.time",
        [("mujoco.mj_step(data, model)", "mujoco.mj_step(model, data)")], 0.002,
    ),
    "what a compiled function is not given": (
        "import mujoco\nclass Walk:\n    def __init__(self):\n        self.model = mujoco.MjModel.from_xml_string('<mujoco/>')\n"
        "        self.data = mujoco.MjData(self.model)\n    def on(self):\n        mujoco.mj_step(self.data)\n        return self.data.time\n"
        "def run():\n    return Walk().on()",
        [("mujoco.mj_step(self.data)", "mujoco.mj_step(self.model, self.data)")], 0.002,
    ),
    "what a compiled function has no place for": (
        "import mujoco\ndef run():\n    model = mujoco.MjModel.from_xml_string('<mujoco/>')\n    data = mujoco.MjData(model)\n"
        "    mujoco.mj_step(model, data, 0.5)\n    return data.time",
        [("mujoco.mj_step(model, data, 0.5)", "mujoco.mj_step(model, data)")], 0.002,
    ),
    "a name before its kind": (
        "import mujoco\ndef run():\n    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><body name=\"b\"/></worldbody></mujoco>')\n"
        "    return mujoco.mj_name2id(model, 'b', mujoco.mjtObj.mjOBJ_BODY)",
        [("mujoco.mj_name2id(model, 'b', mujoco.mjtObj.mjOBJ_BODY)", "mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, 'b')")], 1,
    ),
    "a member of the other object": (
        "class Model:\n    def __init__(self):\n        self.step = 2\nclass Data:\n    def __init__(self):\n        self.time = 3\n"
        "def run():\n    model, data = Model(), Data()\n    return data.step + model.time",
        [("data.step", "model.step"), ("model.time", "data.time")], 5,
    ),
    "a function of the other library": (
        "import numpy as np\nimport mujoco\ndef run():\n    return np.mj_versionString() == mujoco.mj_versionString()",
        [("np.mj_versionString", "mujoco.mj_versionString")], True,
    ),
    "what __init__ does nothing with": (
        "class Filter:\n    def __init__(self, gain=2, first=None):\n        self.gain = gain\n    def update(self, given):\n"
        "        if self.value is None:\n            self.value = given\n        return self.gain * self.value\n"
        "def run():\n    return Filter().update(3), Filter(first=4).update(3)",
        [("first", "self.value")], (6, 8),
    ),
    "two names for what is returned, exchanged": (
        "import numpy as np\nclass Figure:\n    pass\ndef made():\n    return Figure(), np.array([3, 4])\n"
        "def run():\n    axes, figure = made()\n    return int(axes[1])",
        [("axes, figure = made()", "figure, axes = made()")], 4,
    ),
    "a list that nothing makes": (
        "def run():\n    for n in range(3):\n        for m in range(2):\n            rows.append(n * m)\n    return rows",
        [("rows", "rows = []")], [0, 0, 0, 1, 0, 2],
    ),
    "rows that nothing makes": (
        "def run():\n    count = 3\n    for n in range(count):\n        rows[n] = 2 * n\n    return rows",
        [("rows", "rows = [None] * count")], [0, 2, 4],
    ),
    "a member of the other object, which this one has nearly": (
        "class Model:\n    def __init__(self):\n        self.sensor_adr = 2\nclass Data:\n    def __init__(self):\n        self.sensor_adrs = 3\n"
        "def run():\n    model, data = Model(), Data()\n    return data.sensor_adr",
        [("data.sensor_adr", "model.sensor_adr")], 2,
    ),
    "what is given in the other's place": (
        "class Model:\n    def __init__(self):\n        self.step = 2\nclass Data:\n    def __init__(self):\n        self.time = 3\n"
        "def read(model, data):\n    return model.step + data.time\n"
        "def run():\n    model, data = Model(), Data()\n    return read(data, model)",
        [("read(data, model)", "read(model, data)")], 5,
    ),
    "more names than values": (
        "def two():\n    return 1, 2\ndef run():\n    one, third, other = two()\n    return one + other",
        [("one, third, other = two()", "one, other = two()")], 3,
    ),
    "a fraction for a row": (
        "import numpy as np\ndef run():\n    rows = np.zeros(3)\n    rows[0.006 / 0.002 - 1] = 4\n    return rows.tolist()",
        [("0.006 / 0.002 - 1", "int(round(0.006 / 0.002 - 1))")], [0.0, 0.0, 4.0],
    ),
    "fewer names than values": (
        "def three():\n    return 1, 2, 3\ndef run():\n    one, other = three()\n    return one + other",
        [("one, other = three()", "one, other, *_ = three()")], 3,
    ),
    "a module that a variable hides": (
        "import math\ndef run():\n    n = math.floor(2.5)\n    math = [n]\n    return math",
        [("math.floor", "globals()['math'].floor")], [2],
    ),
    "a property that returns itself": (
        "class Filter:\n    def __init__(self):\n        self._gain = 3\n    @property\n    def gain(self):\n        return self.gain\n"
        "def run():\n    return Filter().gain",
        [("self.gain", "self._gain")], 3,
    ),
    "a base that is not begun": (
        "class Base:\n    def __init__(self, gain, more=2):\n        self.value = gain + more\nclass Filter(Base):\n    def __init__(self, gain):\n"
        "        self.gain = gain\ndef run():\n    return Filter(3).value",
        [("no super().__init__", "super().__init__(gain=gain)")], 5,
    ),
    "what is asserted": (
        "def run():\n    n = 3\n    assert n < 2, 'small'\n    return n",
        [("assert n < 2, 'small'", "AssertionError: small")], 3,
    ),
    "two lines in each other's place": (
        "def run():\n    if True:\n        n = 2 * value\n        value = 3\n    return n",
        [("value = 3", "value = 3, further up")], 6,
    ),
    "a variable that one branch sets": (
        "def run(kept=None):\n    if kept is None:\n        kept = 4\n    else:\n        out = 2 * kept\n        kept = out\n    return out",
        [("kept = 4", "out = kept = 4")], 4,
    ),
    "the variable of a comprehension": (
        "def run():\n    return [2 * index for n in range(3)]", [("index", "n")], [0, 2, 4],
    ),
    "the variable of a loop": (
        "def run():\n    rows = []\n    for n in range(3):\n        rows.append(index)\n    return rows", [("index", "n")], [0, 1, 2],
    ),
    "a loop that counts from one": (
        "import numpy as np\ndef run():\n    rows = np.zeros(3)\n    for n in range(1, 3 + 1):\n        rows[n] = 5\n    return rows.tolist()",
        [("range(1, 3 + 1)", "range(3)")], [5.0, 5.0, 5.0],
    ),
    "a loop that goes one too far": (
        "def run():\n    rows, count = [1, 2], 2\n    for n in range(count + 1):\n        last = rows[n]\n    return last",
        [("range(count + 1)", "range(count)")], 2,
    ),
    "what can be gone through once": (
        "import numpy as np\ndef made():\n    yield from [(1, 2), (3, 4)]\ndef run():\n    rows = made()\n"
        "    a = np.vstack([a for a, _ in rows])\n    b = np.vstack([b for _, b in rows])\n    return a.tolist(), b.tolist()",
        [("rows = made()", "rows = list(made())")], ([[1], [3]], [[2], [4]]),
    ),
    "a helper without its return": (
        "import numpy as np\ndef part(rows):\n    first = rows[:1]\ndef run():\n    return part(np.ones(3)).tolist()",
        [("no return", "first")], [1.0],
    ),
    "a value that is called": (
        "class Filter:\n    @property\n    def value(self):\n        return 3\n    def update(self):\n        return self.value()\n"
        "def run():\n    return Filter().update()",
        [("self.value()", "self.value")], 3,
    ),
    "a part of what is not there": (
        "def run():\n    data = [1, 2]\n    return sim.data[1]", [("sim.data", "data")], 2,
    ),
    "what the new random numbers call otherwise": (
        "import numpy as np\ndef run():\n    return np.random.default_rng(1).randn(3).shape",
        [("np.random.default_rng(1).randn", "np.random.default_rng(1).standard_normal")], (3,),
    ),
    "a longer word": (
        "class Sensor:\n    def __init__(self):\n        self.adr, self.dim = 4, 3\ndef run():\n    sensor = Sensor()\n    return sensor.address",
        [("sensor.address", "sensor.adr")], 4,
    ),
    "arrays that are not put together": (
        "import numpy as np\ndef run():\n    a, b = np.ones(2), np.zeros(1)\n    return np.concatenate(a, b).tolist()",
        [("np.concatenate(a, b)", "np.concatenate((a, b))")], [1.0, 1.0, 0.0],
    ),
    "a fraction of rows": ("import numpy as np\ndef run():\n    n = 6 / 2\n    return np.zeros((n, 3)).shape", [("n", "int(n)")], (3, 3)),
}  # fmt: skip


@pytest.mark.parametrize(("text", "taken", "value"), MENDED.values(), ids=MENDED)
def test_it_runs_with_what_is_meant(text: str, taken: list[tuple[str, str]], value: Any) -> None:
    assert _until_it_runs(text) == (value, taken)


LEFT = {
    "two fractions": "import numpy as np\ndef run():\n    n, m = 6 / 2, 3.0\n    return np.zeros((n, m))",
    "a type that is none": "import numpy as np\ndef run():\n    return np.zeros(2, dtype='3 x')",
    "what two other objects have": (
        "class Model:\n    def __init__(self, n):\n        self.step = n\nclass Data:\n    n = 0\n"
        "def run():\n    one, two, data = Model(1), Model(2), Data()\n    return data.step"
    ),
    "a base that needs more": (
        "class Base:\n    def __init__(self, gain):\n        self.value = gain\nclass Filter(Base):\n    def __init__(self):\n"
        "        self.gain = 1\ndef run():\n    return Filter().value"
    ),
    "a property that returns itself, and nothing is kept": (
        "class Filter:\n    @property\n    def gain(self):\n        return self.gain\ndef run():\n    return Filter().gain"
    ),
    "a variable that is set in another block": "def run():\n    n = value\n    if n:\n        value = 2\n    return n",
    "two loops whose variables nobody reads": "def run():\n    return [measurement for n in range(2) for m in range(2)]",
    "a helper that returns for one of two": (
        "def part(n):\n    if n:\n        return 1\ndef run():\n    return part(0).real"
    ),
    "one of two that __init__ does nothing with": (
        "class Filter:\n    def __init__(self, first=1, second=2):\n        self.gain = 1\n    def update(self):\n        return self.value\n"
        "def run():\n    return Filter().update()"
    ),
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
