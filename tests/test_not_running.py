"""What does not run, does nothing or stands at module level costs what a fair marker takes, in every layout."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import pytest

from grader.engine import rubric
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.corpus.cases import Case, of
from tests.corpus.cases import case as case_of
from tests.corpus.pieces import LAYOUTS, edit, steps, tidy, verbatim
from tests.recordings import Marking
from tests.sandboxes import Opened
from tests.scoreboard import Verdict, graded_by, look_at_edit
from tests.single_faults import lost_by, marked, submission_of, thinned

DEFINED_IN = {
    "imu_reader.py": {"sensor_access", "data_collection", "visualization"},
    "noisy_imu.py": {"noise_model"},
    "filters.py": {"filtering"},
}
"""The criteria whose definitions stand in each file."""


def _judged() -> list[Case]:
    """Return the first and the last case of each group in each file; the others end in the same way, and only their repair differs."""
    alike = defaultdict[tuple[str, str], list[Case]](list)
    for case in of("repairable"):
        alike[case.name.partition(":")[0], case.file].append(case)
    return [case for cases in alike.values() for case in (cases if len(cases) < 2 else (cases[0], cases[-1]))]


@pytest.mark.parametrize("case", thinned(_judged(), 12))
def test_it_costs_what_needs_it_alone(case: Case, player: Marking) -> None:
    lost = {check.partition(".")[0] for check in lost_by(marked(player, case.files))}
    assert lost <= DEFINED_IN[case.file]
    assert len(lost) == (len(DEFINED_IN[case.file]) if case.name.startswith("syntax") else 1)


@pytest.mark.parametrize("nothing", thinned(of("nothing"), 12))
def test_a_part_that_does_nothing_keeps_a_few_points_for_its_form(nothing: Case, player: Marking) -> None:
    assert graded_by(player, nothing).troubles == []


METHOD = "def update(self, measurement):"


@pytest.mark.parametrize(
    ("files", "old", "new"),
    [
        (tidy(), "class LowPassFilter:", "class LowPassFilter"),
        (tidy(), METHOD, f"{METHOD}\n        x = '"),
        (tidy(), METHOD, f"{METHOD}\n      pass\n   pass"),
        (verbatim(), METHOD, f"{METHOD}\n        x = (1"),
    ],
    ids=["colon of a class", "quote", "indentation", "bracket on the sheet"],
)
def test_a_filter_that_does_not_parse_keeps_the_comparison_that_its_file_draws(
    files: dict[str, str], old: str, new: str, player: Marking
) -> None:
    result = marked(player, edit(files, "filters.py", (old, new)))
    assert [criterion.points for criterion in result.criteria] == [20, 20, 20, 20, 0]
    assert not any("was stopped" in note for note in result.notes), result.notes


@pytest.mark.parametrize(
    "source",
    [
        "raise SyntaxError",
        "def broken(:\n    plt.savefig('filtered_imu.png')\n",
        "# savefig\nx = (\n",
        "def broken(:\n    pass\n\nimport matplotlib.pyplot as plt\nplt.savefig('filtered_imu.png')\n",
    ],
    ids=["type name", "in what does not parse", "in a comment", "an empty figure"],
)
def test_a_filter_file_that_draws_no_comparison_loses_it(source: str, player: Marking) -> None:
    result = marked(player, tidy() | {"filters.py": source})
    assert [criterion.points for criterion in result.criteria] == [20, 20, 16, 20, 0]


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


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.weekly] if n % 4 else []) for n, name in enumerate(ODD)]
)
def test_odd_data_at_module_level_costs_nothing(name: str, player: Marking) -> None:
    result = marked(player, {path: f"{ODD[name]}\n{text}\n{ODD[name]}" for path, text in verbatim().items()})
    assert (result.status, lost_by(result)) == ("graded", {})
    "\n".join(result.notes).encode()


# --- the sheet's own layout, everything at module level, with one edit ---

_WAITING = ("loop-", "long-", "waits-", "live-", "thread-", "demo-below-a-guard")
_ALIKE = ("sys-exit-in-", "segfault-in-", "abort-in-")
"""The first are waited for, some seconds each, the others end like `exit-in-`; `tests.scoreboard` has them all."""
QUICK = [
    case for case in of("module level") if not case.name.startswith((*_WAITING, *_ALIKE)) or case.name == "loop-between"
]
ELSEWHERE = (
    "exit-in-reader", "exit-between", "misspelled-call", "pandas-unused", "pylab-star", "pdb-in-the-noise", "defined-in-an-if",
)  # fmt: skip


def in_layout(case: Case, layout: str) -> Submission:
    return submission_of({name: text for name, text in LAYOUTS[layout](case.files).items() if isinstance(text, str)})


@pytest.mark.parametrize(
    ("case", "layout"),
    [
        *(
            pytest.param(
                case, "three-files", marks=[pytest.mark.weekly] if n % 6 else [], id=f"{case.name}-three-files"
            )
            for n, case in enumerate(QUICK)
        ),
        *((case_of("module level", name), layout) for name in ELSEWHERE for layout in ("one-file", "notebook")),
    ],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_an_edit_costs_what_a_fair_marker_takes(player: Marking, case: Case, layout: str) -> None:
    verdict = Verdict(case)
    look_at_edit(verdict, player.mark(in_layout(case, layout)), case)
    assert verdict.troubles == []


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import os\nos._exit(0)", "imu_reader.py, line 50 was skipped: it ends the process; the rest of the file was used"),
        ("1 / 0", "imu_reader.py, line 49 was skipped: ZeroDivisionError: division by zero; the rest of the file was used"),
        (
            "import pandas as pd\nmean = pd.Series(accel).mean()",
            "imu_reader.py, line 49 was skipped: ModuleNotFoundError: No module named 'pandas'; so was 1 more statement; "
            "the rest of the file was used",
        ),
    ],
)  # fmt: skip
def test_what_is_stepped_over_is_a_note_with_file_and_line(player: Marking, code: str, said: str) -> None:
    sheet = steps()
    sheet["recorder.py"] = f"{code}\n\n{sheet['recorder.py']}"
    result = player.mark(in_layout(Case("module level", "one", sheet), "three-files"))
    assert (result.score, result.notes) == (100.0, (said,))


def test_who_waits_is_told_for_what(opened: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grader.engine.session._SLOW_S", 0.3)
    case = case_of("module level", "loop-between")
    said: list[str] = []
    with opened(bundles.shipped(), replace(rubric.load(LAB), limits=rubric.Limits(1.0, 12.0))) as marker:
        marker.mark(in_layout(case, "three-files"), only="sensor_access", waiting=said.append)
    assert said == ["Waiting for imu_reader.py to be imported: 1 s of CPU time at most."]
