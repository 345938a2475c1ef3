"""Writes the class of `submissions_example/`, with the pictures that its code draws: `python -m tests.corpus.example_class`.

What each must get stands in `tests/examples.yaml`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image

from tests.corpus import sheet
from tests.corpus.extensions import FAULTY_EXTENSIONS, SOUND_EXTENSIONS
from tests.corpus.faulty import FAULTY
from tests.corpus.machine import REAL_MODEL, SHEET_MODEL
from tests.corpus.pieces import READ_FANCY, edit, lab, listy, verbatim
from tests.corpus.sound_layouts import NOTEBOOK
from tests.corpus.sound_models import FILTER_LFILTER, NOISE_STANDARD_NORMAL
from tests.corpus.sound_typed import TYPED
from tests.corpus.writing import Files, zipped

EXAMPLES = Path(__file__).resolve().parents[2] / "submissions_example"
PICTURES = ("imu_data.png", "filtered_imu.png")
MOST_BYTES = 60_000


def fault(name: str) -> Files:
    return next(f.files for f in FAULTY if f.name == name)


CLASS: dict[str, Files] = {
    "s01-sheet-verbatim": verbatim(),
    "s02-vectorised": lab(read=READ_FANCY, noise=NOISE_STANDARD_NORMAL, low_pass=FILTER_LFILTER),
    "s03-notebook": {"lab-04-01.ipynb": NOTEBOOK},
    "s04-object-oriented": TYPED,
    "s05-zip": listy(),
    "s06-id-as-address": fault("id-as-slice-start"),
    "s07-no-units": fault("labels-without-units"),
    "s08-no-reset": fault("reset-forgotten-tidy"),
    "s09-variance-as-std": fault("std-taken-as-variance"),
    "s10-zero-initial-state": fault("zeros-when-none"),
    "s11-kills-its-interpreter": fault("filter-exits"),
    "s12-endless-loop": edit(
        lab(collect=sheet.COLLECT.replace("accel_id, gyro_id)", "*ids)"), noise=sheet.NOISY_IMU),
        "imu_reader.py",
        ("    for i in range(n_steps):\n", '    ids = model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id\n    i = 0\n    while i < n_steps:\n'),
    ),
    "s13-rows-all-the-same": fault("views-appended"),
    "s14-empty": {".gitkeep": ""},
    "s15-extensions": {
        **lab(),
        "complementary_filter.py": next(f.source for f in FAULTY_EXTENSIONS if f.mistake == "weights-swapped"),
        "allan_variance.py": SOUND_EXTENSIONS["allan_variance"]["phase"],
        "multi_imu.py": SOUND_EXTENSIONS["multiple_imus"]["named"],
        "live_plot.py": SOUND_EXTENSIONS["realtime_visualization"]["func-animation"],
    },
}


def drawn(files: Files) -> dict[str, bytes]:
    """The pictures that the files draw when they are run as scripts, one after the other; none from one that does not end."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for place in (folder / SHEET_MODEL, folder / "run.py"):
            place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REAL_MODEL, folder / SHEET_MODEL)
        for name, content in files.items():
            (folder / name).write_text(str(content), encoding="utf-8")
        for script in _scripts(folder):
            _run(script, folder)
        return {name: small(folder / name) for name in PICTURES if (folder / name).exists()}


def _scripts(folder: Path) -> list[list[str]]:
    run_cells = "import sys; from pathlib import Path; from tests.corpus.machine import run_notebook; run_notebook(Path(sys.argv[1]))"
    notebooks = [["-c", run_cells, str(path)] for path in sorted(folder.glob("*.ipynb"))]
    return notebooks + [[name] for name in ("imu_reader.py", "noisy_imu.py", "filters.py") if (folder / name).exists()]


def _run(script: list[str], folder: Path) -> None:
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": str(EXAMPLES.parent)}
    try:
        subprocess.run([sys.executable, *script], cwd=folder, env=environment, stdout=subprocess.DEVNULL, timeout=30, check=False)
    except subprocess.TimeoutExpired:
        print(f"{script[0]} does not end")


def small(path: Path) -> bytes:
    """The same pixels with a palette, in fewer bytes; the picture is not made smaller."""
    for colours in (128, 32, 12):
        buffer = BytesIO()
        Image.open(path).convert("RGB").quantize(colours, dither=Image.Dither.NONE).save(buffer, "PNG", optimize=True)
        if buffer.tell() < MOST_BYTES:
            break
    return buffer.getvalue()


def main() -> None:
    """All of the class, or those that are named on the command line."""
    for name, files in CLASS.items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        folder = EXAMPLES / name
        folder.mkdir(parents=True, exist_ok=True)
        whole: Files = {**files, **drawn(files)} if name != "s14-empty" else files
        if name == "s05-zip":
            whole = {"lab4.zip": zipped({f"lab4/{path}": content for path, content in whole.items()})}
        for path, content in whole.items():
            (folder / path).write_bytes(content if isinstance(content, bytes) else str(content).encode("utf-8"))
        print(name, {path: (folder / path).stat().st_size for path in whole})


if __name__ == "__main__":
    main()
