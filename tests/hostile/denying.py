"""Denial of service: code that never ends, ends its process, or takes all of something. It is lost, and nothing else is."""

from __future__ import annotations

import io
import zipfile
import zlib
from functools import cache

from tests.corpus.pieces import lab
from tests.corpus.writing import Late, notebook, zipped
from tests.hostile.forging import BLANK
from tests.hostile.picture import END, head, png
from tests.hostile.program import FILTER, READER, Program, but, first, in_function, in_method, last, sound

LOOP = "while True:\n    pass"


def attack(name: str, path: str, code: str, *lost: str, at_start: bool = False, only: str | None = None) -> Program:
    files = first(sound(), path, code) if at_start else last(sound(), path, code)
    return Program(name, "denial", files, only=only, keeps=but(*lost) if only is None else ())


def in_filter(name: str, code: str, *keeps: str) -> Program:
    """An attack in the filter, graded on the filter alone, which it may cost if that is not in `keeps`."""
    return Program(name, "denial", last(sound(), FILTER, in_method("LowPassFilter", "update", code)), only="filtering", keeps=keeps)


LOOPS = [
    attack("loops-at-import-of-the-reader", READER, LOOP, "sensor_access", "data_collection", "visualization", at_start=True),
    attack("loops-in-the-reader", READER, in_function("get_imu_readings", LOOP), "sensor_access", "data_collection", "noise_model", "visualization"),
    in_filter("loops-in-the-filter", LOOP),
    attack("loops-when-it-is-deleted", FILTER, "def _del(self):\n    while True: pass\nLowPassFilter.__del__ = _del", only="filtering"),
    attack("loops-in-an-attribute", FILTER, "def _get(self, name):\n    while True: pass\nLowPassFilter.__getattribute__ = _get", only="filtering"),
    attack("loops-in-the-module-s-getattr", FILTER, "def __getattr__(name):\n    while True: pass", only="filtering"),
    attack("loops-at-exit", FILTER, "import atexit\n@atexit.register\ndef forever():\n    while True: pass", only="filtering"),
    in_filter("loops-in-the-words-of-an-error", "class E(Exception):\n    def __str__(self):\n        while True: pass\n    __repr__ = __str__\nraise E"),
    in_filter("loops-in-a-conversion", "class Forever:\n    def __array__(self, *a, **k):\n        while True: pass\n    def __float__(self):\n        while True: pass\n    __len__ = __iter__ = __getitem__ = __float__\nreturn Forever()"),
    in_filter("loops-in-c-code", "sum(range(10**13))"),
    in_filter("loops-in-eight-threads", "import threading\ndef spin():\n    while True: sum(range(10**6))\nfor _ in range(8): threading.Thread(target=spin, daemon=True).start()\nspin()"),
    in_filter("ignores-every-signal", "import signal\nfor s in range(1, 65):\n    try: signal.signal(s, signal.SIG_IGN)\n    except (OSError, ValueError): pass\nsignal.pthread_sigmask(signal.SIG_BLOCK, range(1, 65))\nwhile True: pass"),
    in_filter("swallows-every-exception", "while True:\n    try:\n        while True: pass\n    except BaseException: pass"),
    attack("waits-for-itself", FILTER, in_method("LowPassFilter", "update", "import threading\nlock = threading.Lock()\nlock.acquire()\nlock.acquire()"), only="filtering"),
    in_filter("sleeps-for-a-year", "import time\ntime.sleep(3e7)", "filtering"),
    in_filter("stops-itself", "import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)"),
    in_filter("sets-an-alarm", "import signal\nsignal.setitimer(signal.ITIMER_REAL, 0.01)\nwhile True: pass"),
]

FORKS = """
import os
for _ in range(20):
    try:
        if os.fork() == 0:
            end = __import__('time').monotonic
            start = end()
            while end() - start < 20: pass
            os._exit(0)
    except OSError:
        break
"""
FLOODS = [
    in_filter("forks-twenty-times", FORKS),
    in_filter("starts-threads", "import threading\nheld = threading.Event()\ntry:\n    for _ in range(500): threading.Thread(target=held.wait, args=(20,), daemon=True).start()\nexcept RuntimeError: pass"),
    in_filter("takes-memory-at-once", "x = bytearray(3 << 30)"),
    in_filter("takes-memory-bit-by-bit", "x = []\nfor _ in range(30): x.append(np.ones(12_500_000))"),
    in_filter("writes-one-large-file", "with open('big', 'wb', 0) as f:\n    for _ in range(100): f.write(bytes(1 << 20))"),
    in_filter("writes-many-files", "for n in range(3000): open(f'f{n}', 'w').close()"),
    in_filter("makes-a-deep-folder", "import os\nfor _ in range(300):\n    os.mkdir('d'); os.chdir('d')"),
    in_filter("opens-every-descriptor", "import os\nheld = []\ntry:\n    for _ in range(2000): held.append(os.open('/dev/null', 0))\nexcept OSError: pass"),
    in_filter("prints-without-end", "for _ in range(3000): print('x' * 10_000)"),
    in_filter("writes-to-descriptor-one", "import os\ntry:\n    for _ in range(300): os.write(1, b'x' * 100_000)\nexcept OSError: pass"),
    in_filter("recurses-without-end", "def f(): return f()\nf()"),
    in_filter("recurses-in-c", "import sys\nsys.setrecursionlimit(10**9)\nx = []\nfor _ in range(10**6): x = [x]\nrepr(x)"),
    in_filter("ends-by-a-fault-of-memory", "import ctypes\nctypes.string_at(0)"),
    in_filter("raises-an-error-of-100-megabytes", "raise ValueError('x' * 100_000_000)"),
    in_filter("raises-a-long-chain", "e = None\nfor n in range(20_000):\n    new = ValueError(n); new.__cause__ = e; e = new\nraise e"),
]


def returns(name: str, code: str, only: str = "data_collection") -> Program:
    function = {"data_collection": "simulate_and_collect", "sensor_access": "get_imu_readings"}[only]
    return Program(name, "denial", last(sound(), READER, in_function(function, code)), only=only)


VALUES = [
    returns("returns-a-cycle", "x = []\nx.append(x)\nreturn x"),
    returns("returns-a-deep-list", "x = 0.0\nfor _ in range(100_000): x = [x]\nreturn x"),
    returns("returns-a-huge-view", "return {'time': np.broadcast_to(0.0, 10**12), 'acceleration': np.broadcast_to(0.0, (10**10, 3)), 'angular_velocity': np.broadcast_to(0.0, (10**10, 3))}"),
    returns("returns-as-much-as-may-be", "n = 199_000\nt = (1 + np.arange(n)) * 0.002\nreturn {'time': t, 'acceleration': np.random.rand(n, 3), 'angular_velocity': np.random.rand(n, 3)}"),
    returns("returns-keys-of-a-megabyte", "return {chr(97 + n) * 1_000_000: np.zeros(3) for n in range(20)}"),
    returns("returns-an-endless-sequence", "class Endless(list):\n    def __len__(self): return 10**12\n    def __getitem__(self, i): return 0.0\n    def __iter__(self):\n        while True: yield 0.0\nreturn Endless()"),
    returns("returns-a-lying-length", "class Lying(tuple):\n    def __len__(self): return 2\nreturn Lying(range(1000))", "sensor_access"),
    returns("returns-a-generator", "def f():\n    while True: yield np.zeros(3)\nreturn f()", "sensor_access"),
    returns("returns-an-endless-dictionary", "class Endless(dict):\n    def keys(self):\n        n = 0\n        while True:\n            n += 1\n            yield str(n)\n    def __getitem__(self, key): return 0.0\nreturn Endless()"),
    returns("returns-numbers-without-end", "return 10**5000, -10**5000", "sensor_access"),
    returns("returns-numbers-near-the-limit", "return np.full(3, 1.7e308), np.full(3, -1.7e308)", "sensor_access"),
    returns("returns-times-near-the-limit", "s = _sound_simulate_and_collect(*args, **kwargs)\ns['time'] = s['time'] * 1e300\nreturn s"),
    returns("returns-many-dimensions", "return np.zeros((1,) * 32), np.zeros((1,) * 12)", "sensor_access"),
    returns("returns-the-whole-model", "return args[0], args[1]", "sensor_access"),
]

# ---------------------------------------------------------------- plots

COMPARES_WITHOUT_END = '''\
def compare():
    rng = np.random.default_rng(0)
    for _ in range(12):
        fig, axes = plt.subplots(4, 4)
        for ax in axes.flat:
            for k in range(48):
                ax.plot(rng.normal(size=6000).cumsum() if k % 2 else rng.normal(size=6000))
        fig.savefig("filtered_imu.png")


if __name__ == "__main__":
    compare()
'''
PLOTS = [
    Program("draws-thousands-of-comparisons", "denial", lab(compare=COMPARES_WITHOUT_END), only="visualization"),
    attack("saves-a-picture-of-a-gigapixel", READER, in_function("plot_imu_data", "plt.figure(figsize=(1000, 1000)).savefig('x.png', dpi=1000)"), only="visualization"),
    attack("opens-thousands-of-figures", READER, "def plot_imu_data(d):\n    import warnings\n    warnings.simplefilter('ignore')\n    for _ in range(3000): plt.figure()", only="visualization"),
    attack("draws-a-million-points", READER, "def plot_imu_data(d):\n    fig, axes = plt.subplots(2, 1)\n    for ax in axes: ax.scatter(np.random.rand(1_000_000), np.random.rand(1_000_000))\n    fig.savefig('imu_data.png')", only="visualization"),
    attack("labels-of-a-megabyte", READER, "def plot_imu_data(d):\n    fig, ax = plt.subplots()\n    ax.plot(d['time'], d['acceleration'], label='(m/s^2' * 200_000)\n    ax.set_ylabel('m/s' * 300_000)\n    fig.savefig('imu_data.svg')", only="visualization"),
    attack("draws-nan-and-infinity", READER, "def plot_imu_data(d):\n    fig, axes = plt.subplots(2, 1)\n    for ax in axes:\n        ax.plot(d['time'], d['acceleration'] * np.nan)\n        ax.plot([np.inf] * 60, [-np.inf] * 60)\n        ax.plot(np.linspace(0, 1e300, 60), np.linspace(-1e308, 1e308, 60))\n    fig.savefig('imu_data.png')", only="visualization"),
    attack("draws-curves-of-no-length", READER, "def plot_imu_data(d):\n    fig, axes = plt.subplots(2, 1)\n    for ax in axes:\n        for n in (0, 1, 2, 3): ax.plot(d['time'][:n], d['acceleration'][:n])\n        ax.plot([], []); ax.scatter([], [])\n        ax.plot(d['time'], np.zeros(len(d['time']))); ax.plot([1.0] * 99, d['time'][:99])\n    fig.savefig('imu_data.png')", only="visualization"),
]

# ---------------------------------------------------------------- sources and archives


@cache
def bomb(megabytes: int = 600) -> bytes:
    """A zip whose one file unpacks to very much."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("imu_reader.py", "w") as member:
        for _ in range(megabytes):
            member.write(bytes(1 << 20))
    return buffer.getvalue()


@cache
def picture_bomb() -> bytes:
    """A PNG that says it has a gigapixel."""
    return png(head(60_000, 60_000), (b"IDAT", zlib.compress(bytes(40_000_000), 9)), END)


def source(name: str, text: str | bytes) -> Program:
    return Program(name, "denial", {**sound(), FILTER: text}, only="filtering")


SOURCES = [
    source("source-nested-too-deep", "x = " + "(" * 50_000 + ")" * 50_000),
    source("source-with-a-huge-number", "x = " + "9" * 5_000_000),
    source("source-of-a-huge-constant", "x = 'a' * 10**9\ny = (1,) * 10**7\n"),
    source("source-of-one-line", "#" + "x" * 10_000_000),
    source("source-of-nothing-but-zeros", bytes(1_000_000)),
    source("source-with-a-strange-encoding", b"# -*- coding: utf-7 -*-\n+AGE- = 1\n"),
    Program("notebook-nested-too-deep", "denial", {**sound(), "lab.ipynb": "[" * 200_000}, only="filtering", keeps=("filtering",)),
    Program("notebook-with-100000-cells", "denial", Late({"lab.ipynb": lambda: notebook(*["x = 1"] * 20_000)}), only="filtering"),
    Program("zip-that-unpacks-to-600-megabytes", "denial", Late({"hand-in.zip": bomb}), as_="file"),
    Program("zip-with-30000-entries", "denial", Late({"hand-in.zip": lambda: zipped({f"d{n}/x.py": "" for n in range(30_000)})}), as_="file", only="filtering"),
    Program("picture-of-a-gigapixel", "denial", Late({**BLANK, "imu_data.png": picture_bomb}), only="visualization"),
]

DENIALS = [*LOOPS, *FLOODS, *VALUES, *PLOTS, *SOURCES]
