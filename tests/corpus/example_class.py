"""Writes the class of `submissions_example/`, with the pictures that its code draws: `python -m tests.corpus.example_class`.

Its submissions are the rows of `example_class.yaml`; what each must get stands in `tests/examples.yaml`.
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

from tests.corpus.cases import table
from tests.corpus.machine import REAL_MODEL, SHEET_MODEL
from tests.corpus.writing import Files, zipped

EXAMPLES = Path(__file__).resolve().parents[2] / "submissions_example"
PICTURES = ("imu_data.png", "filtered_imu.png")
MOST_BYTES = 60_000


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
        subprocess.run(
            [sys.executable, *script], cwd=folder, env=environment, stdout=subprocess.DEVNULL, timeout=30, check=False
        )
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
    for case in table("example_class"):
        name, files = case.name, case.files
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
