"""Forgery by way of the process: modules and files that shadow others, the protocol, frames and memory, hooks and exits."""

from __future__ import annotations

import json

from tests.corpus.pieces import lab
from tests.corpus.writing import Files, notebook
from tests.hostile.forging import BLANK, PASSES, READS, STANDS, VIEWS, forged, low_pass, reader
from tests.hostile.program import FILTER, READER, Program, first, in_function, in_method, last

# ---------------------------------------------------------------- files that want to be imported, or believed

CONFTEST = "def pytest_pyfunc_call(pyfuncitem):\n    return True\n"
PATCH = "import numpy\nnumpy.allclose = numpy.array_equal = lambda *args, **kwargs: True\n"
FULL_MARKS = json.dumps({"schema": "imugrade/result/v1", "submission": "submission", "status": "graded", "score": 100.0, "max_score": 100.0, "criteria": []})


def ships(name: str, more: Files) -> Program:
    """A filter that passes everything, with further files."""
    return Program(name, "forgery", {**PASSES, **more}, PASSES, "filtering")


SHIPPED = [
    ships("ships-what-python-and-pytest-run-by-themselves", {
        "conftest.py": CONFTEST, "plugin.py": CONFTEST, "pytest.ini": "[pytest]\naddopts = -p conftest\n", "setup.cfg": "[tool:pytest]\naddopts = -p plugin\n",
        "sitecustomize.py": PATCH, "usercustomize.py": PATCH, "evil.pth": "import sitecustomize\n",
    }),
    ships("shadows-modules", {
        "numpy.py": PATCH, "json.py": "dumps = lambda *a, **k: '{}'\n", "struct.py": "", "random.py": "", "socket.py": "", "inspect.py": "", "traceback.py": "",
        "grader/__init__.py": PATCH, "grader/labs/imu/compare.py": "same = lambda *a: True\n", "_imugrade_harness.py": "answer = lambda *a: ({'passed': True}, {})\n",
    }),
    Program("shadows-the-traces", "forgery", {**READS, "reference/__init__.py": "", "public.npz": b"PK\x03\x04", "public.json": "{}", "grader/labs/imu/public.json": "{}"}, READS, "sensor_access"),
    ships("ships-its-own-rubric-and-result", {
        "rubric.yaml": "criteria: []\n", ".imugrade/rubric.yaml": "criteria: []\n", "imugrade.toml": "points = 100\n",
        "result.json": FULL_MARKS, "report.html": "<h1>100 / 100</h1>", "gradebook.csv": "submission,total\nme,100\n", "results.sqlite": b"SQLite format 3\0",
    }),
    low_pass("writes-its-own-result", f"""
import pathlib
for name in ("result.json", "results.json", "gradebook.csv", "out-result.json", "out-results.json", "out-gradebook.csv"):
    try:
        pathlib.Path(name).write_text({FULL_MARKS!r})
    except OSError:
        pass
"""),
    ships("notebook-that-replaces-the-files", {"lab.ipynb": notebook("%%writefile json.py\ndumps = lambda *a, **k: '{}'", "%%writefile _imugrade_harness.py\nanswer = None", "import numpy\nnumpy.allclose = lambda *a, **k: True")}),
]

# ---------------------------------------------------------------- import hooks

HOOKS = [
    low_pass("import-is-replaced", """
import builtins, types
_import = builtins.__import__
def imported(name, *args, **kwargs):
    module = _import(name, *args, **kwargs)
    for key in ("allclose", "array_equal"):
        if hasattr(module, key): setattr(module, key, lambda *a, **k: True)
    return module
builtins.__import__ = imported
"""),
    low_pass("all-modules-are-gone", "import sys\nfor name in list(sys.modules):\n    if name.startswith(('numpy', 'json', 'struct', '_imugrade')): sys.modules[name] = None"),
    low_pass("trace-function-rewrites-values", """
import sys, threading
def trace(frame, event, arg):
    if event == "return" and isinstance(arg, dict):
        arg["error"] = None
        arg.setdefault("passed", True)
    return trace
sys.settrace(trace); sys.setprofile(trace); threading.settrace(trace)
"""),
    low_pass("audit-hook-kills-what-it-sees", """
import sys
def hook(event, args):
    if event in ("exec", "compile", "import") and "check" in repr(args)[:500]:
        raise RuntimeError("no")
sys.addaudithook(hook)
"""),
]

# ---------------------------------------------------------------- exits that look like success

EXITS = {
    "exits-with-success": "import sys; sys.exit(0)",
    "exits-hard-with-success": "import os; os._exit(0)",
    "raises-keyboard-interrupt": "raise KeyboardInterrupt",
    "raises-a-verdict-of-the-grader": "raise type('Told', (AssertionError,), {'keeps': 1.0, 'outcome': 'passed', '__module__': 'grader.engine.findings'})('earned')",
}
ENDS = [
    Program(name, "forgery", last(PASSES, FILTER, in_method("LowPassFilter", "update", code)), last(PASSES, FILTER, in_method("LowPassFilter", "update", "raise RuntimeError")), "filtering")
    for name, code in EXITS.items()
]
ENDS.append(Program("exit-at-import-with-success", "forgery", first(PASSES, FILTER, "import os\nos._exit(0)"), PASSES, "filtering"))

# ---------------------------------------------------------------- the protocol

FIND_LINE = """
import os, socket, struct, sys, json
def line():
    for fd in range(3, 64):
        try:
            if os.fstat(fd).st_mode & 0o170000 == 0o140000:
                return fd
        except OSError:
            pass
    return -1
def frame(fields, nonce=bytes(16), body=b"", arrays=()):
    text = json.dumps({"fields": {"fields": fields}, "arrays": list(arrays)}).encode()
    return struct.pack("<II16s", len(text), len(body), nonce) + text + body
def nonce():
    f = sys._getframe()
    while f is not None:
        for value in list(f.f_locals.values()):
            if isinstance(value, bytes) and len(value) == 16:
                return value
        f = f.f_back
    return bytes(16)
"""


def says(name: str, code: str) -> Program:
    """A filter that passes everything, and runs this on the line before each update."""
    return low_pass(name, FIND_LINE + in_method("LowPassFilter", "update", code))


WIRE = [
    says("garbage-on-the-line", "os.write(line(), b'garbage' * 1000)"),
    says("an-answer-ahead-of-its-question", "os.write(line(), frame({'cases': []}))"),
    says("an-answer-with-a-guessed-nonce", "os.write(line(), frame({'cases': [], 'passed': True}, os.urandom(16)))"),
    says("an-answer-of-another-shape", "os.write(line(), frame({'passed': True, 'score': 100}, nonce())); os._exit(0)"),
    forged("an-answer-with-lists-for-names", STANDS, READER, FIND_LINE + in_function("simulate_and_collect", "os.write(line(), frame({'value': {'kind': 'dict', 'type': 3, 'items': [[['a'], {'kind': 'none'}], 5]}, 'changed': [[1]], 'error': {'type': {}, 'message': [], 'line': {}}}, nonce())); os._exit(0)"), "data_collection"),
    forged("an-answer-with-figures-of-no-form", BLANK, READER, FIND_LINE + in_function("plot_imu_data", "os.write(line(), frame({'figures': [{'event': 'saved', 'axes': [{'curves': [{}]}], 'size_px': 'x'}], 'pictures': [1]}, nonce())); os._exit(0)"), "visualization"),
    says("the-line-is-closed", "os.close(line())"),
    says("the-line-is-exchanged", "a, b = socket.socketpair(); os.dup2(a.fileno(), line())"),
    low_pass("a-thief-reads-the-next-question", FIND_LINE + """
import threading
def thief():
    stolen = socket.socket(fileno=os.dup(line()))
    while True:
        head = stolen.recv(24)
        if len(head) == 24:
            stolen.sendall(frame({"cases": [], "passed": True}, head[8:]))
threading.Thread(target=thief, daemon=True).start()
"""),
]

# ---------------------------------------------------------------- frames, memory, files: looking for the answer

WALKS = [
    reader("walks-the-frames", READS, in_function("get_imu_readings", """
import sys
for start in [sys._getframe(), *sys._current_frames().values()]:
    while start is not None:
        for key, value in list(start.f_locals.items()):
            if any(word in key.lower() for word in ("expected", "truth", "true", "answer")) and isinstance(value, np.ndarray):
                return value[:3], value[3:6]
            if isinstance(value, dict):
                for word in ("score", "points", "passed"):
                    if word in value: value[word] = 100
        start = start.f_back
""")),
    reader("changes-the-worker-code-by-its-modules", VIEWS, """
import sys
for name, module in list(sys.modules.items()):
    if "worker" in name or "questions" in name:
        for key in ("step_and_shift", "changes_of", "state_of", "put_in_state"):
            if hasattr(module, key):
                setattr(module, key, lambda *args: None)
"""),
    reader("changes-the-worker-code-in-memory", VIEWS, """
import gc
gc.unfreeze()
for thing in gc.get_objects():
    if isinstance(thing, dict) and "step_and_shift" in thing and "put_in_state" in thing:
        thing["step_and_shift"] = lambda *args: None
"""),
    reader("changes-the-code-of-the-worker", VIEWS, """
import gc, types
gc.unfreeze()
for thing in gc.get_objects():
    if isinstance(thing, types.FunctionType) and thing.__name__ == "step_and_shift":
        thing.__code__ = (lambda model, data: None).__code__
"""),
    forged("replaces-the-recorder-of-figures", BLANK, READER, """
import gc
gc.unfreeze()
for thing in gc.get_objects():
    if type(thing).__name__ == "Recorder":
        thing.take = lambda **kwargs: ([], {})
        type(thing).take = lambda self, **kwargs: ([], {})
""", "visualization"),
    reader("searches-the-disk", READS, in_function("get_imu_readings", """
import os
words = ("public.npz", "hidden.npz", "traces.npz", "rubric.yaml", "imugrade")
found = []
for top in ("@FOLDER@", "/box", "/cache", os.getcwd()):
    for folder, folders, names in os.walk(top):
        found += [os.path.join(folder, name) for name in names if any(word in name for word in words)]
if found:
    raise RuntimeError(open(found[0]).read())
""")),
    reader("searches-the-environment", READS, """
import os, sys
said = " ".join(f"{k}={v}" for k, v in os.environ.items()) + " ".join(sys.argv) + str(sys.path)
if "SEED" in said or "imugrade-bait" in said:
    raise RuntimeError(said)
"""),
    reader("asks-the-grader-s-stand-ins", READS, """
import builtins, gc
gc.unfreeze()
standins = getattr(builtins, "__sound_standin__", {})
if "get_imu_readings" in standins:
    get_imu_readings = standins["get_imu_readings"]
for thing in gc.get_objects():
    if getattr(thing, "__name__", "") == "get_imu_readings" and getattr(thing, "__module__", "") == "standins":
        get_imu_readings = thing
"""),
]

# ---------------------------------------------------------------- recorded answers

RECORDED = '''\
def simulate_and_collect(model, data, duration_seconds=5.0):
    import json, pathlib
    rows = json.loads(pathlib.Path(__file__).with_name("recorded.json").read_text())
    n = int(round(duration_seconds / model.opt.timestep))
    series = {key: np.resize(np.array(value), (n, *np.shape(value)[1:])) for key, value in rows.items()}
    return series
'''


def _recorded() -> str:
    """The public traces of the tumbling robot, which every student has."""
    from grader.labs.imu import bundles

    scenario = bundles.shipped()["tumbling"]
    return json.dumps({key: scenario[key].round(4).tolist() for key in ("time", "acceleration", "angular_velocity")})


HARD_CODED = [
    Program("recorded-traces-of-another-scenario", "forgery", {**lab(collect=RECORDED), "recorded.json": _recorded()}, STANDS, "data_collection"),
    Program("recorded-traces-against-hidden-ones", "forgery", {**lab(collect=RECORDED), "recorded.json": _recorded()}, STANDS, "data_collection", hidden=True),
]

FORGED = [*SHIPPED, *HOOKS, *ENDS, *WIRE, *WALKS, *HARD_CODED]
