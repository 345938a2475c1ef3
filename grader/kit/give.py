"""Writing the kits: for students, for Gradescope, for Classroom 50 and for GitHub."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.errors import RequestError
from grader.kit import wheel
from grader.report import truth
from grader.rubric import load
from grader.text import printable
from grader.traces import Traces, lab_model

STARTERS = ("imu_reader.py", "noisy_imu.py", "filters.py", "README.md")
MODEL = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"  # the sheet's path
_FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Kit:
    """One kit that was written: where, for whom, and which scenarios it grades with."""

    place: Path
    title: str
    scenarios: str


@dataclass(frozen=True)
class Wanted:
    """Which kits are wanted, and where; None is not wanted. `hidden` traces go to Gradescope alone."""

    student: Path | None = None
    gradescope: Path | None = None
    classroom50: Path | None = None
    github: Path | None = None
    rubric: Path | None = None
    hidden: Traces | None = None


def kits(wanted: Wanted) -> Iterator[Kit]:
    """Write them one after the other."""
    if wanted.student is not None:
        yield student(wanted.student, wanted.rubric)
    if wanted.gradescope is not None:
        yield gradescope(wanted.gradescope, wanted.rubric, wanted.hidden)
    if wanted.classroom50 is not None:
        yield classroom50(wanted.classroom50, wanted.rubric)
    if wanted.github is not None:
        yield github(wanted.github, wanted.rubric)


def student(out: Path, rubric: Path | None = None) -> Kit:
    """Starter files, the model at the sheet's path, a README and the wheel, in a new folder.

    Raises
    ------
    RequestError
        If the folder has something in it: a student's work must not be overwritten.
    """
    files = {name: _text(f"starter/{name}.txt").encode() for name in STARTERS}
    files |= {MODEL: lab_model().read_bytes(), wheel.name(): _wheel(rubric)}
    _new_folder(out, files)
    return Kit(out, "students", "public scenarios")


def classroom50(out: Path, rubric: Path | None = None) -> Kit:
    """`autograder.py` and the wheel, for ``CLASSROOM/autograders/ASSIGNMENT``."""
    files = {"autograder.py": _text("platforms/autograder.py.txt").encode(), wheel.name(): _wheel(rubric)}
    _new_folder(out, files)
    return Kit(out, "Classroom 50", "public scenarios: the job runs in the student's repository")


def github(out: Path, rubric: Path | None = None) -> Kit:
    """A workflow and the wheel, for the root of the repository that students start from."""
    workflow = _text("platforms/imugrade.yml.txt").encode()
    files = {".github/workflows/imugrade.yml": workflow, f".github/imugrade/{wheel.name()}": _wheel(rubric)}
    for path in files:
        if (out / path).exists():
            raise RequestError(f"{printable(str(out / path))}: it is there already; remove it or choose another folder")
    _write(out, files)
    return Kit(out, "GitHub Actions", "public scenarios: the job runs in the student's repository")


def gradescope(out: Path, rubric: Path | None = None, hidden: Traces | None = None) -> Kit:
    """`autograder.zip`: `setup.sh` and `run_autograder` at its root, the wheel, and hidden traces if they are given."""
    traces = {} if hidden is None else _bundle(hidden)
    options = ' --traces "$ROOT/source/hidden.npz"' if traces else ""
    files = {
        "setup.sh": _text("platforms/setup.sh.txt").encode(),
        "run_autograder": _text("platforms/run_autograder.txt").replace("{options}", options).encode(),
        wheel.name(): _wheel(rubric),
        **traces,
    }
    if out.exists():
        raise RequestError(f"{printable(str(out))}: it is there already; remove it or choose another name")
    _write(out.parent, {out.name: wheel.pack(files, ("setup.sh", "run_autograder"))})
    return Kit(out, "Gradescope", "hidden scenarios" if traces else "public scenarios: no seed was given")


def _wheel(rubric: Path | None) -> bytes:
    if load(rubric).model.path is not None:
        raise RequestError(f"{rubric}: it names a model of its own, which a kit cannot carry; leave `path` out")
    return wheel.build(rubric)


def _text(path: str) -> str:
    return (_FOLDER / path).read_text(encoding="utf-8").replace("{wheel}", wheel.name())


def _bundle(hidden: Traces) -> dict[str, bytes]:
    """The recorded bundle, not the seed: who has the one cannot make the other."""
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        truth.save(hidden, Path(scratch))
        written = {path.suffix: path.read_bytes() for path in Path(scratch).rglob("*") if path.is_file()}
    return {f"hidden{suffix}": content for suffix, content in sorted(written.items())}


def _new_folder(out: Path, files: Mapping[str, bytes]) -> None:
    try:
        taken = out.is_dir() and any(out.iterdir())
    except OSError as problem:
        raise RequestError(
            f"{printable(str(out))}: cannot read it ({problem.strerror}); choose another place"
        ) from None
    if taken:
        raise RequestError(
            f"{printable(str(out))}: the folder is not empty; choose a new one, so nothing is overwritten"
        )
    _write(out, files)


def _write(out: Path, files: Mapping[str, bytes]) -> None:
    for path, content in files.items():
        place = out / path
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        except OSError as problem:
            reason = problem.strerror or problem
            raise RequestError(f"{printable(str(place))}: cannot write it: {reason}; choose another place") from problem
