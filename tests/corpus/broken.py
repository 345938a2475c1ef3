"""Bad input: what is handed in by mistake, in a hurry or in malice. Each ends in a verdict; what is untouched keeps its points."""



from __future__ import annotations

import struct
import zipfile
import zlib
from dataclasses import dataclass
from io import BytesIO

from tests.corpus.faulty_files import without
from tests.corpus.pieces import edit, lab, listy, looping, tidy, verbatim
from tests.corpus.writing import Files, Late, Link, tarred, zipped

ALL = ("sensor_access", "data_collection", "visualization", "noise_model", "filtering")


@dataclass(frozen=True)
class Broken:
    """A submission that is broken in some way.

    Attributes
    ----------
    name : str
        Unique; words joined by hyphens.
    files : Files
    as_ : str
        How it is handed in, see `writing.write`.
    status : tuple of str
        The verdicts that are right.
    keeps : tuple of str
        Criteria that stay at full points.
    costs : str
        The criterion that must lose points; "" if none must.
    names : tuple of str
        Ids that would be right; the first should be named, or one of the others in its place.
    """

    name: str
    files: Files
    as_: str = "folder"
    status: tuple[str, ...] = ("graded",)
    keeps: tuple[str, ...] = ()
    costs: str = ""
    names: tuple[str, ...] = ()


def but(*criteria: str) -> tuple[str, ...]:
    """All criteria other than these."""
    return tuple(criterion for criterion in ALL if criterion not in criteria)


# ---------------------------------------------------------------- nothing, junk, archives

NOTHING = ("empty",)
UNREADABLE = ("unreadable",)
NONE_OF_IT = ("empty", "unreadable")
GOOD_ZIP = zipped(tidy())


def png(width: int, height: int, rows: bytes = b"") -> bytes:
    """A PNG that claims a size and holds what it is given."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


WHITE = b"".join(b"\x00" + b"\xff" * (3 * 64) for _ in range(64))


def bomb() -> bytes:
    """A small zip of two hundred megabytes of zeros beside a sound submission."""
    buffer = BytesIO(GOOD_ZIP)
    with zipfile.ZipFile(buffer, "a", zipfile.ZIP_DEFLATED) as archive, archive.open("zeros.bin", "w") as entry:
        for _ in range(200):
            entry.write(bytes(1 << 20))
    return buffer.getvalue()


def nested(levels: int) -> bytes:
    inner = GOOD_ZIP
    for level in range(levels):
        inner = zipped({f"level{level}.zip": inner})
    return inner


def damaged(archive: bytes) -> bytes:
    """Bytes in the middle of the archive changed: its directory is whole, a file's checksum is not."""
    middle = archive.index(b"imu_reader.py") + 200
    return archive[:middle] + bytes(byte ^ 0xFF for byte in archive[middle : middle + 64]) + archive[middle + 64 :]


HAND_INS = [
    Broken("empty-folder", {"lab/": ""}, status=NOTHING),
    Broken("only-a-gitkeep", {".gitkeep": ""}, status=NOTHING),
    Broken("only-a-text", {"report.txt": "I did not have time."}, status=NOTHING),
    Broken("only-junk-of-an-archive", {"__MACOSX/._imu_reader.py": b"\x00\x05\x16\x07", ".DS_Store": b"\x00"}, status=NOTHING),
    Broken("empty-files", {"imu_reader.py": "", "noisy_imu.py": "", "filters.py": ""}, status=("graded", "empty"), costs="sensor_access", names=("name-missing",)),
    Broken("comments-only", dict.fromkeys(tidy(), "# TODO\n"), costs="filtering", names=("name-missing",)),
    Broken("pictures-only", {"imu_data.png": png(64, 64, WHITE), "filtered_imu.png": png(64, 64, WHITE)}, status=("graded", "empty")),
    Broken("empty-zip", {"s.zip": zipped({})}, "file", NONE_OF_IT),
    Broken("zip-cut-short", {"s.zip": GOOD_ZIP[: len(GOOD_ZIP) // 2]}, "file", UNREADABLE),
    Broken("zip-damaged", {"s.zip": damaged(GOOD_ZIP)}, "file", ("unreadable", "graded")),
    Broken("a-zip-by-name-only", {"s.zip": b"this is no archive\n" * 20}, "file", UNREADABLE),
    Broken("tar-cut-short", {"s.tar.gz": tarred(tidy())[:900]}, "file", UNREADABLE),
    Broken("a-tar-by-name-only", {"s.tar.gz": b"\x1f\x8b" + b"nothing" * 30}, "file", UNREADABLE),
    Broken("zip-in-zip", {"s.zip": nested(1)}, "file", keeps=ALL),
    Broken("zip-in-zip-in-zip-in-zip", {"s.zip": nested(3)}, "file", ("empty", "unreadable")),
    Broken("zip-bomb", Late({"s.zip": bomb}), "file", ("graded", "unreadable")),
    Broken("zip-that-climbs-out", {"s.zip": zipped({**tidy(), "../../outside.py": "print('outside')\n", "/tmp/absolute.py": "x = 1\n"})}, "file", keeps=ALL),
    Broken("links-to-the-system", {**tidy(), "passwd.txt": Link("/etc/passwd"), "everything": Link("/")}, keeps=ALL),
    Broken("reader-is-a-link", {**without(tidy(), "imu_reader.py"), "imu_reader.py": Link("/etc/hostname")}, keeps=("noise_model", "filtering"), costs="sensor_access"),
    Broken("link-in-a-circle", {**tidy(), "again": Link(".")}, keeps=ALL),
    Broken("links-in-a-tar", {"s.tar.gz": tarred({**tidy(), "evil": Link("../../../etc/passwd")})}, "file", keeps=ALL),
    Broken("names-with-control-characters", {**tidy(), "a\x1b[31mred\n.py": "x = 1\n", "=1+2.csv": "a\n"}, keeps=ALL),
    Broken("wrong-file-names", {"IMU-Reader (1).py": tidy()["imu_reader.py"], "noisy.py": tidy()["noisy_imu.py"], "filter final v2.py": tidy()["filters.py"]}, keeps=("sensor_access", "data_collection", "noise_model", "filtering")),
]

# ---------------------------------------------------------------- pictures

IMAGES = [
    Broken("huge-claimed-image", {**tidy(), "imu_data.png": png(60000, 60000, WHITE)}, keeps=ALL),
    Broken("truncated-image", {**tidy(), "imu_data.png": png(640, 480, WHITE)[:60], "filtered_imu.png": b"\x89PNG\r\n"}, keeps=ALL),
    Broken("text-as-image", {**tidy(), "imu_data.png": "see the other file"}, keeps=ALL),
    Broken("images-are-folders", {**tidy(), "imu_data.png/": "", "filtered_imu.png/keep.txt": "x"}, keeps=but("visualization")),
]

# ---------------------------------------------------------------- text that is no Python

ENCODINGS: list[Broken] = [
    Broken("utf-16-filters", {**tidy(), "filters.py": tidy()["filters.py"].encode("utf-16")}, keeps=but("filtering", "visualization"), costs="filtering", names=("does-not-import",)),
    Broken("binary-noise-model", {**listy(), "noisy_imu.py": bytes(range(256)) * 8}, keeps=but("noise_model", "visualization"), costs="noise_model", names=("does-not-import",)),
    Broken("latin-1-without-saying-so", {**verbatim(), "filters.py": verbatim()["filters.py"].encode("latin-1")}, keeps=but("filtering", "visualization")),
    Broken("python-2-filters", {**tidy(), "filters.py": tidy()["filters.py"].replace("class Low", "print 'filters'\n\n\nclass Low")}, keeps=but("filtering", "visualization"), costs="filtering", names=("does-not-import",)),
    Broken("notebook-of-broken-json", {"lab.ipynb": '{"cells": [{"cell_type": "code", "source": ['}, status=("empty",)),
    Broken("notebook-that-is-a-list", {"lab.ipynb": "[1, 2, 3]"}, status=("empty",)),
    Broken("unfilled-template", {name: text.split("    def ")[0].split("\ndef ")[0] for name, text in verbatim().items()}, costs="sensor_access"),
    Broken("nul-bytes-in-noise", {**tidy(), "noisy_imu.py": tidy()["noisy_imu.py"] + "\x00\x00"}, keeps=but("noise_model", "visualization"), costs="noise_model", names=("does-not-import",)),
]

# ---------------------------------------------------------------- packages, back ends

MACHINE = [
    Broken("pandas-in-the-filter", edit(tidy(), "filters.py", ("import mujoco\n", "import mujoco\nimport pandas as pd\n")), keeps=ALL),
    Broken("seaborn-in-the-reader", edit(listy(), "imu_reader.py", ("import mujoco\n", "import mujoco\nimport seaborn as sns\n")), keeps=ALL),
    Broken("tk-back-end", edit(tidy(), "imu_reader.py", ("import matplotlib.pyplot as plt\n", 'import matplotlib\n\nmatplotlib.use("TkAgg")\nimport matplotlib.pyplot as plt\n')), keeps=ALL),
    Broken("qt-back-end-switched", edit(looping(), "imu_reader.py", ("import mujoco\n", 'import mujoco\n\nplt.switch_backend("Qt5Agg")\n')), keeps=ALL),
    Broken("back-end-in-rc-parameters", edit(tidy(), "imu_reader.py", ("import mujoco\n", 'import mujoco\n\nplt.rcParams["backend"] = "macosx"\n')), keeps=ALL),
]

# ---------------------------------------------------------------- endings in each function

ENDINGS = {
    "loop": "while True:\n{i}    pass",
    "exit": "import os; os._exit(0)",
    "sys-exit": 'raise SystemExit("bye")',
    "segfault": "import ctypes; ctypes.string_at(0)",
    "recursion": "(lambda f: f(f))(lambda f: f(f))",
    "interrupt": "raise KeyboardInterrupt",
    "memory": "bytearray(1 << 40)",
    "flood": 'print("x" * 1000000)\n{i}raise RuntimeError("x" * 1000000)',
}
ENDING_NAMES = {
    "loop": ("never-returns",),
    "exit": ("kills-its-process",),
    "sys-exit": ("kills-its-process", "raises"),
    "segfault": ("kills-its-process",),
    "recursion": ("raises", "kills-its-process"),
    "interrupt": ("raises", "kills-its-process"),
    "memory": ("raises", "kills-its-process"),
    "flood": ("raises",),
}
# Where the ending is put: a file, a line, the criterion that it costs.
PLACES = {
    "reader": ("imu_reader.py", "    return read_sensor(model, data, accel_sensor_id), read_sensor(model, data, gyro_sensor_id)\n", "sensor_access"),
    "recording": ("imu_reader.py", "    mujoco.mj_resetData(model, data)\n", "data_collection"),
    "plot": ("imu_reader.py", '    fig.savefig("imu_data.png", dpi=100)\n', "visualization"),
    "noise": ("noisy_imu.py", "        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n", "noise_model"),
    "constructor": ("noisy_imu.py", "        self.model, self.data = model, data\n", "noise_model"),
    "filter": ("filters.py", "        x = np.array(measurement, dtype=float)\n", "filtering"),
}


def ended(place: str, ending: str) -> Broken:
    """A tidy submission that ends in one way in one function."""
    path, line, criterion = PLACES[place]
    indent = line[: len(line) - len(line.lstrip())]
    files = edit(tidy(), path, (line, indent + ENDINGS[ending].format(i=indent) + "\n" + line))
    return Broken(f"{ending}-in-{place}", files, keeps=but(criterion), costs=criterion, names=ENDING_NAMES[ending])


def ended_at_import(path: str, ending: str) -> Broken:
    """The ending before the first definition: it is stepped over, and the whole file counts."""
    files = {**tidy(), path: ENDINGS[ending].format(i="") + "\n" + tidy()[path]}
    return Broken(f"{ending}-when-{path[:-3].replace('_', '-')}-is-imported", files, keeps=ALL)


def ended_below(path: str, ending: str) -> Broken:
    """The ending below the last definition: what was defined before it counts."""
    files = {**tidy(), path: tidy()[path].split("\nif __name__")[0] + "\n" + ENDINGS[ending].format(i="") + "\n"}
    keeps = but("visualization") if path == "filters.py" else ALL
    return Broken(f"{ending}-below-{path[:-3].replace('_', '-')}", files, keeps=keeps)


ENDED = [ended(place, ending) for place in PLACES for ending in ENDINGS]
ENDED += [ended_at_import(path, ending) for path in tidy() for ending in ("loop", "exit", "segfault", "sys-exit")]
ENDED += [ended_below(path, ending) for path in tidy() for ending in ("sys-exit", "flood")]

# ---------------------------------------------------------------- answers of the wrong kind

ANSWERS = {
    "none": "None",
    "a-string": '"0 0 -9.81"',
    "nested-lists-of-uneven-length": "[[1.0], [2.0, 3.0]]",
    "objects": "[object(), object(), object()]",
    "complex-numbers": "np.array([1j, 2j, 3j])",
    "nan": "np.full(3, np.nan)",
    "infinity": "np.full(3, np.inf)",
    "a-billion-zeros": "np.zeros(1 << 27)",
    "a-generator": "(x for x in range(3))",
    "a-class": "int",
    "a-function": "print",
    "always-equal": 'type("Same", (), {"__eq__": lambda *a: True, "__array__": None})()',
    "a-masked-array": "np.ma.masked_all(3)",
    "an-empty-array": "np.array([])",
    "a-matrix": "np.zeros((3, 3))",
    "numbers-as-text": 'np.array(["1", "2", "3"])',
}
READER_LINE, FILTER_LINE, NOISE_LINE = PLACES["reader"][1], "        return self.state.copy()\n", "        return accel, gyro\n"


def answers(kind: str) -> list[Broken]:
    value = ANSWERS[kind]
    return [
        Broken(f"reader-answers-{kind}", edit(tidy(), "imu_reader.py", (READER_LINE, f"    return {value}, {value}\n")), keeps=but("sensor_access"), costs="sensor_access"),
        Broken(f"filter-answers-{kind}", edit(tidy(), "filters.py", (FILTER_LINE, f"        return {value}\n")), keeps=but("filtering"), costs="filtering"),
        Broken(f"noise-answers-{kind}", edit(tidy(), "noisy_imu.py", (NOISE_LINE, f"        return {value}, {value}\n")), keeps=but("noise_model"), costs="noise_model"),
    ]


TIDY_RETURN = '    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}\n'
RECORDINGS = {
    "none": "None",
    "a-list": "[time, acceleration, angular_velocity]",
    "no-keys": "{}",
    "keys-of-nothing": "dict.fromkeys(['time', 'acceleration', 'angular_velocity'])",
    "text-columns": "{'time': time.astype(str), 'acceleration': 'a', 'angular_velocity': b'b'}",
    "uneven-lengths": "{'time': time[:-5], 'acceleration': acceleration[5:], 'angular_velocity': angular_velocity[:, :2]}",
    "flat-arrays": "{'time': time, 'acceleration': acceleration.ravel(), 'angular_velocity': angular_velocity.ravel()}",
    "not-finite": "{'time': time, 'acceleration': acceleration * np.inf, 'angular_velocity': angular_velocity * np.nan}",
    "millions-of-keys": "{i: i for i in range(2_000_000)}",
    "itself-within": "(lambda d: d.update(time=d, acceleration=d, angular_velocity=d) or d)({})",
}


def recording(kind: str) -> Broken:
    files = edit(tidy(), "imu_reader.py", (TIDY_RETURN, f"    return {RECORDINGS[kind]}\n"))
    return Broken(f"recording-answers-{kind}", files, keeps=but("data_collection"), costs="data_collection")


SIGNATURES = [
    Broken("reader-without-parameters", lab(read="def get_imu_readings():\n    return np.zeros(3), np.zeros(3)\n"), keeps=but("sensor_access"), costs="sensor_access"),
    Broken("reader-is-a-number", lab(read="get_imu_readings = 42\n"), keeps=but("sensor_access"), costs="sensor_access"),
    Broken("reader-is-a-coroutine", edit(tidy(), "imu_reader.py", ("def get_imu_readings(", "async def get_imu_readings(")), keeps=but("sensor_access"), costs="sensor_access"),
    Broken("filter-is-a-function", lab(low_pass="def LowPassFilter(alpha=0.1, initial_value=None):\n    return None\n"), keeps=but("filtering"), costs="filtering"),
    Broken("filter-without-parameters", edit(tidy(), "filters.py", ("def __init__(self, alpha=0.1, initial_value=None):\n        self.alpha = alpha\n        self.state = None if initial_value is None else np.array(initial_value, dtype=float)", "def __init__(self):\n        self.alpha, self.state = 0.1, None"), ("LowPassFilter(alpha=0.1)", "LowPassFilter()")), keeps=but("filtering"), costs="filtering"),
    Broken("noise-without-a-bias-parameter", edit(tidy(), "noisy_imu.py", ("                 accel_bias=None, gyro_bias=None, rng=None):\n", "                 rng=None):\n        accel_bias = gyro_bias = None\n")), keeps=but("noise_model"), costs="noise_model"),
]

BROKEN: list[Broken] = [
    *HAND_INS,
    *IMAGES,
    *ENCODINGS,
    *MACHINE,
    *ENDED,
    *(broken for kind in ANSWERS for broken in answers(kind)),
    *(recording(kind) for kind in RECORDINGS),
    *SIGNATURES,
]
