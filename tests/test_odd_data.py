"""Odd data and hooks at module level cost nothing where all definitions are sound."""

from __future__ import annotations

import pytest

from tests.corpus.pieces import verbatim
from tests.recordings import Marking
from tests.single_faults import lost_by, marked

ODD = {
    "half a character in a message": "raise ValueError('caf\\udce9')\n",
    "half a character in the name of a type": "raise type('E\\udce9', (ValueError,), {})()\n",
    "half a character in a title": "import matplotlib.pyplot as p\np.figure()\np.plot([1, 2])\np.title('caf\\udce9')\np.savefig('x.png')\n",
    "half a character in a file name": "import matplotlib.pyplot as p\np.figure()\np.plot([1, 2])\np.savefig('caf\\udce9.png')\n",
    "half a character in a key": "open('\\udce9.txt', 'w').write('x')\nraise KeyError('\\udce9')\n",
    "an attribute that raises": "class E(ImportError):\n    name = property(lambda self: 1 / 0)\nraise E('x')\n",
    "a definition that raises such an error": (
        "class E(ImportError):\n    name = property(lambda self: 1 / 0)\n    __str__ = lambda self: 1 / 0\n"
        "def tells(f):\n    raise E('x')\n@tells\ndef helper():\n    pass\n"
    ),
    "an import that raises such an error": (
        "import sys\nclass E(ImportError):\n    name = property(lambda self: 1 / 0)\n    __str__ = lambda self: 1 / 0\n"
        "class F:\n    def find_spec(*a):\n        raise E('x')\nsys.meta_path.insert(0, F)\ntry:\n    import nothing_of_that_name as a, other as b\n"
        "finally:\n    sys.meta_path.remove(F)\n"
    ),
    "a type whose name is computed": "class M(type):\n    __name__ = property(lambda c: 1 / 0)\nclass E(ValueError, metaclass=M):\n    pass\nraise E()\n",
    "a traceback that is computed": "class E(ValueError):\n    __traceback__ = property(lambda self: 1 / 0)\nraise E()\n",
    "a class that is computed": "class E(BaseException):\n    @property\n    def __class__(self):\n        raise self\nraise E('x')\n",
    "an exit whose class is computed": "class E(SystemExit):\n    @property\n    def __class__(self):\n        raise self\nraise E('x')\n",
    "attributes that all raise": "class E(BaseException):\n    def __getattribute__(self, name):\n        raise self\nraise E('x')\n",
    "an import error whose class is computed": (
        "class E(ImportError):\n    __class__ = name = property(lambda self: 1 / 0)\ndef tells(f):\n    raise E('x')\n"
        "@tells\ndef helper():\n    pass\n"
    ),
    "a line of fifty digits": "e = SyntaxError('x')\ne.filename, e.lineno, e.offset, e.text = '<submission>/filters.py', 10**50, 10**50, 'x'\nraise e\n",
    "fields of other kinds": "e = SyntaxError('x')\ne.filename, e.lineno, e.offset, e.text, e.msg = '<submission>/filters.py', [], {}, 5, b'x'\nraise e\n",
    "a field that raises": "class E(SyntaxError):\n    filename = property(lambda self: 1 / 0)\n    lineno = filename\nraise E('x')\n",
    "settrace": "import sys\ndef hook(*args):\n    raise RuntimeError('traced')\nsys.settrace(hook)\nsys._getframe().f_trace = hook\n",
    "settrace in a thread": "import threading\ndef hook(*args):\n    raise RuntimeError('traced')\nthreading.settrace(hook)\nthreading.Thread(target=print).start()\n",
    "a trace on all frames": "import sys\ndef hook(*args):\n    raise RuntimeError('traced')\nsys.settrace(hook)\nf = sys._getframe()\nwhile f:\n    f.f_trace, f = hook, f.f_back\n",
    "setprofile": "import sys\ndef hook(*args):\n    raise RuntimeError('profiled')\nsys.setprofile(hook)\n",
    "an audit hook": "import sys\ndef hook(*args):\n    raise RuntimeError('audited')\nsys.addaudithook(hook)\n",
    "an exit at the end": "import atexit, sys\natexit.register(sys.exit, 3)\n",
}  # fmt: skip


@pytest.mark.parametrize("name", ODD)
def test_odd_data_at_module_level_costs_nothing(name: str, player: Marking) -> None:
    result = marked(player, {path: f"{ODD[name]}\n{text}\n{ODD[name]}" for path, text in verbatim().items()})
    assert (result.status, lost_by(result)) == ("graded", {})
    "\n".join(result.notes).encode()
