"""Sound submissions in other wrappings: encodings, folders, archives, notebooks."""



from __future__ import annotations

from tests.corpus import sheet
from tests.corpus.pieces import (
    COLLECT_APPEND,
    COLLECT_LOOKUP,
    COMPARE,
    FILTER_INCREMENT,
    HEAD,
    MODEL_PATH,
    NOISE_GENERATOR,
    PLOT_LOOP,
    PLOT_PYPLOT,
    READ_DIM,
    READ_NAMED,
    lab,
    listy,
    looping,
    tidy,
    verbatim,
)
from tests.corpus.writing import Content, notebook

Files = dict[str, Content]


def below(folder: str, files: dict[str, str]) -> Files:
    return {f"{folder}/{name}": content for name, content in files.items()}


def tabbed(text: str) -> str:
    """Indented with tabs: four spaces at the start of a line become one."""

    def line(text: str) -> str:
        body = text.lstrip(" ")
        return "\t" * ((len(text) - len(body)) // 4) + " " * ((len(text) - len(body)) % 4) + body

    return "\n".join(map(line, text.split("\n")))


def latin_1(files: dict[str, str]) -> Files:
    """As an old editor saves it, with the line that says so; the sheet's ² is in Latin-1."""
    return {name: ("# -*- coding: latin-1 -*-\n" + text).encode("latin-1") for name, text in files.items()}


BOM = {name: b"\xef\xbb\xbf" + text.encode() for name, text in looping().items()}
CRLF = {name: text.replace("\n", "\r\n") for name, text in verbatim().items()}
TABS = {name: tabbed(text) for name, text in tidy().items()}

ONE_FILE = {
    "lab_04_01.py": "\n\n".join((HEAD, READ_DIM, COLLECT_LOOKUP, PLOT_LOOP, NOISE_GENERATOR, FILTER_INCREMENT))
    + "\n\n"
    + COMPARE
    + f"""\
    model = mujoco.MjModel.from_xml_path("{MODEL_PATH}")
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))
"""
}

MIXED_UP = {  # every name is there, none where the sheet expects it
    "imu_reader.py": "from filters import *\n",
    "noisy_imu.py": "from part2 import NoisyIMU\n",
    "part1.py": "\n\n".join((HEAD, READ_NAMED, COLLECT_APPEND, PLOT_PYPLOT)),
    "part2.py": "\n\n".join((HEAD, "from part1 import get_imu_readings", NOISE_GENERATOR)),
    "filters.py": "from part1 import *\nfrom part2 import NoisyIMU\n\n" + FILTER_INCREMENT + "\n\n" + COMPARE
    + '''\
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))
''',
}

PACKAGE = {
    "README.md": "# Lab 04-01\n\nRun `python -m imu.imu_reader` from here.\n",
    "requirements.txt": "mujoco\nnumpy\nmatplotlib\n",
    "imu/__init__.py": '"""IMU lab."""\n\nfrom .imu_reader import get_imu_readings  # noqa: F401\n',
    "imu/imu_reader.py": tidy()["imu_reader.py"],
    "imu/noisy_imu.py": tidy()["noisy_imu.py"].replace("from imu_reader", "from .imu_reader"),
    "imu/filters.py": tidy()["filters.py"].replace("from imu_reader", "from .imu_reader").replace("from noisy_imu", "from .noisy_imu"),
}

WITH_JUNK: Files = {
    **listy(),
    ".DS_Store": b"\x00\x00\x00\x01Bud1\x00",
    "__MACOSX/._imu_reader.py": b"\x00\x05\x16\x07\x00\x02\x00\x00Mac OS X        ",
    "__pycache__/imu_reader.cpython-311.pyc": b"\xa7\r\r\n" + bytes(12),
    ".vscode/settings.json": "{}\n",
    "notes.txt": "remember to hand in before Friday\n",
    "imu_reader_old.py": "def get_imu_readings(:\n    pass\n",
    "test_filters.py": "from filters import LowPassFilter\n\n\ndef test_default():\n    assert LowPassFilter().alpha == 0.1\n",
}

IMPORTS_CELL = f"""\
%matplotlib inline
import matplotlib.pyplot as plt
import mujoco
import numpy as np

MODEL_PATH = "{MODEL_PATH}"
"""
RUN_CELL = """\
model = mujoco.MjModel.from_xml_path(MODEL_PATH)
data = mujoco.MjData(model)
imu_data = simulate_and_collect(model, data, duration_seconds=3.0)
plot_imu_data(imu_data)
imu_data["acceleration"].mean(axis=0)
"""
COMPARE_CELLS = COMPARE.split("\n\n\nif __name__")[0], "compare()"

NOTEBOOK = notebook(
    ("markdown", "# Lab 04-01\nName: see cover sheet"),
    "!pip install mujoco --quiet",
    IMPORTS_CELL,
    ("markdown", "## Step 2"),
    READ_DIM,
    COLLECT_LOOKUP,
    PLOT_PYPLOT,
    "%%time\n" + RUN_CELL,
    "?np.random.normal",
    NOISE_GENERATOR,
    "imu = NoisyIMU(model, data, model.sensor('torso_accelerometer').id, model.sensor('torso_gyroscope').id)\n"
    "imu.read()",
    "%timeit -n 10 imu.read()",
    FILTER_INCREMENT,
    *COMPARE_CELLS,
    "files = !ls\nprint(len(files))",
)

NOTEBOOK_SHEET = notebook(
    ("markdown", "Code from the sheet, one step a cell"),
    sheet.STEP_1,
    sheet.READER,
    sheet.STEP_2_DEMO,
    sheet.COLLECT,
    sheet.STEP_3_DEMO,
    sheet.PLOT,
    sheet.STEP_4_DEMO,
    sheet.NOISY_IMU,
    sheet.STEP_5_DEMO,
    sheet.LOW_PASS,
    sheet.STEP_6_DEMO,
    lines=False,
)

NOTEBOOK_BAD_CELL = notebook(
    IMPORTS_CELL,
    "from IPython.display import display, Markdown\ndisplay(Markdown('*hello*'))",
    READ_NAMED,
    "get_imu_readings(model, data)   # NameError: I had not made them yet",
    COLLECT_APPEND,
    PLOT_LOOP,
    "def unfinished(:\n    ???",
    RUN_CELL,
    NOISE_GENERATOR,
    "raise SystemExit",
    FILTER_INCREMENT,
    *COMPARE_CELLS,
)

NOTEBOOK_WRITEFILE = notebook(
    ("markdown", "The three files are written from here."),
    "%%writefile imu_reader.py\n" + tidy()["imu_reader.py"],
    "%%writefile noisy_imu.py\n" + tidy()["noisy_imu.py"],
    "%%writefile filters.py\n" + tidy()["filters.py"],
    "!python imu_reader.py\n!python filters.py",
    "from IPython.display import Image\nImage('imu_data.png')",
)

LAYOUTS: dict[str, Files] = {
    "latin_1_with_its_line": latin_1(listy()),
    "byte_order_mark": dict(BOM),
    "sheet_with_crlf": dict(CRLF),
    "tabs": dict(TABS),
    "one_file": dict(ONE_FILE),
    "names_in_other_files": dict(MIXED_UP),
    "package_with_relative_imports": dict(PACKAGE),
    "with_junk_of_editors": dict(WITH_JUNK),
    "one_folder_down": below("lab04", tidy()),
    "three_folders_down": below("Übung 4/Abgabe (final)/src", looping()),
    "notebook_only": {"lab.ipynb": NOTEBOOK},
    "notebook_of_the_sheet": {"Untitled.ipynb": NOTEBOOK_SHEET},
    "notebook_with_bad_cells": {"lab 04.ipynb": NOTEBOOK_BAD_CELL},
    "notebook_that_writes_the_files": {"lab.ipynb": NOTEBOOK_WRITEFILE},
    "zip_of_files": dict(tidy()),
    "zip_of_a_folder": below("lab-04-01-main", verbatim()),
    "tar_gz": below("hand_in", lab(read=READ_NAMED)),
    "zip_in_a_folder": dict(listy()),
}

# How those are handed in that are not plain folders (see `writing.write`).
WRAPPED = {"zip_of_files": "zip", "zip_of_a_folder": "zip", "tar_gz": "tar.gz", "zip_in_a_folder": "zip in folder"}
