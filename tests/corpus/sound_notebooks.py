"""Sound notebooks with what notebooks hold beside Python: magics, shell commands, files that they write and run."""

from __future__ import annotations

from tests.corpus.pieces import COLLECT_LOOKUP, FILTER_INCREMENT, HEAD, NOISE_GENERATOR, PLOT_LOOP, READ_DIM, tidy
from tests.corpus.sound_layouts import COMPARE_CELLS, RUN_CELL
from tests.corpus.writing import notebook

FILTER_WITH_QUESTION = FILTER_INCREMENT.replace("dtype=float)\n        if", "dtype=float)  # is a copy needed?\n        if")
PARTS = (READ_DIM, COLLECT_LOOKUP, PLOT_LOOP, RUN_CELL, NOISE_GENERATOR, FILTER_INCREMENT, *COMPARE_CELLS)


def whole(*, head: str = HEAD, low_pass: str = FILTER_INCREMENT) -> dict[str, str]:
    """The lab in one notebook, some of its cells in other words."""
    return {"lab.ipynb": notebook(head, *(low_pass if part is FILTER_INCREMENT else part for part in PARTS))}


def writing(**heads: str) -> dict[str, str]:
    """The tidy files, each written by a cell whose first line is given; a second line adds the rest of the file."""
    cells = []
    for name, head in heads.items():
        first, _, rest = head.partition("\n")
        start, cut, end = tidy()[f"{name}.py"].partition("\n\nclass " if rest else "\0")
        cells += [f"{first}\n{start}", f"{rest}\n{cut}{end}"] if rest else [f"{first}\n{start}"]
    return {"lab.ipynb": notebook(*cells, "import sys\nsys.path.append('src')\nimport filters\nfilters.compare()")}


# One notebook a file, each begins by running the one before; the reader is a program that leaves its ids behind.
READER_PROGRAM = tidy()["imu_reader.py"] + """\
    ids = [mujoco.MjModel.from_xml_path(MODEL_PATH).sensor(f"torso_{kind}").id for kind in ("accelerometer", "gyroscope")]
    raise SystemExit(0)
"""
RUNNING = {
    "imu_reader.py": READER_PROGRAM,
    "noisy_imu.ipynb": notebook("%run -t ./imu_reader.py", "accel_id, gyro_id = ids", NOISE_GENERATOR),
    "filters.ipynb": notebook("%run 'noisy_imu.ipynb'\nassert gyro_id", FILTER_INCREMENT, *COMPARE_CELLS),
}
# The first cell of many a notebook in Colab; all that follows needs what it imports.
COLAB = """\
!pip install -q mediapy
from google.colab import drive, files
import mediapy as media
import os
drive.mount('/content/drive', force_remount=True)
os.chdir('/content/drive/MyDrive/lab')
uploaded = files.upload()
for name in uploaded:
    print(name, len(uploaded[name]))
try:
    import google.colab
    os.mkdir('/content/pictures')
except ImportError:
    print('not in Colab')
"""

NOTEBOOKS = {
    "notebook_installs_over_two_lines": whole(head="!apt-get update && \\\n  apt-get install -y 'libgl1' \\\n  # it's slow\n" + HEAD),
    "notebook_asks_in_a_comment": whole(
        head="%matplotlib widget\n" + HEAD.replace("numpy as np", "numpy as np  # or jax.numpy?"),
        low_pass="%load_ext autoreload\n" + FILTER_WITH_QUESTION,
    ),
    "notebook_times_with_options": whole(
        low_pass=FILTER_INCREMENT + "\n%timeit -n10 -r 1 LowPassFilter().update(np.zeros(3))\nlow = %timeit -o -q LowPassFilter()\n%time \n",
    ),
    "notebook_formats_with_percent": whole(low_pass="!ls\nprint('alpha %s of %s'\n      % (0.1, 'filter'))\n" + FILTER_INCREMENT),
    "notebook_waits_at_top_level": whole(low_pass="import asyncio\n\nawait asyncio.sleep(0)\n" + FILTER_INCREMENT),
    "notebook_writes_into_a_folder": writing(
        imu_reader="%%writefile src/imu_reader.py", noisy_imu="%%writefile src/noisy_imu.py", filters="%%writefile src/filters.py"
    ),
    "notebook_writes_in_other_words": writing(
        imu_reader='%%file "./imu_reader.py"',
        noisy_imu="%%file noisy_imu.py\n%%file -a noisy_imu.py",
        filters="%%writefile /content/filters.py\n%%writefile --append 'filters.py'",
    ),
    "notebooks_run_each_other": RUNNING,
    "notebook_of_colab": whole(
        head=COLAB + HEAD, low_pass=FILTER_INCREMENT + "\nmedia.show_video([np.zeros((4, 4, 3))], fps=30)\nfiles.download('imu_data.png')\n"
    ),
}
