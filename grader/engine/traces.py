"""Ground truth as the grader sees it: bundles of arrays with a manifest, loaded, checked and obtained.

The reference writes bundles, the grader reads them; neither imports the other. MuJoCo's last digits differ between
versions and processors, so a bundle is recorded where the grading happens and cached, and always compared with a
tolerance.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import secrets
import shutil
import subprocess
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.engine.robot import LAB_FILE, LAB_IMU, LAB_MODEL, Model, Robot
from grader.engine.rubric_nodes import refuse
from grader.ground.errors import GraderError, RequestError
from grader.ground.package_data import beside
from grader.ground.text import printable

SCHEMA = "imugrade/traces/v1"
CACHE_VARIABLE = "IMUGRADE_CACHE"
RECORDING_LIMIT_S = 300
_UNFIT = 4  # the reference's exit code where a model cannot be graded

_SOURCES = beside("grader", "").parent


@dataclass(frozen=True, eq=False)
class Scenario(Mapping[str, NDArray[Any]]):
    """One scenario's arrays, as `scenario["acceleration"]` or `scenario.acceleration`; read-only.

    `scalars` holds its plain numbers and names, `model` the key of the model it takes place in (see `Traces.models`).
    """

    name: str
    description: str
    model: str | None
    scalars: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(repr=False)

    def __getitem__(self, key: str) -> NDArray[Any]:
        return self.arrays[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    def __getattr__(self, key: str) -> NDArray[Any]:
        # Reached for unknown names only. A copy being unpickled has no fields yet, so do not ask for them by attribute.
        arrays: Mapping[str, NDArray[Any]] = self.__dict__.get("arrays", {})
        if key not in arrays:
            raise AttributeError(f"scenario {self.__dict__.get('name')!r} has no array {key!r}")
        return arrays[key]


@dataclass(frozen=True, eq=False)
class Traces:
    """A bundle: `traces["push"].acceleration`. `arrays` has all of it by `<scenario>/<array>`."""

    name: str
    sha256: str
    manifest: Mapping[str, Any] = field(repr=False)
    arrays: Mapping[str, NDArray[Any]] = field(repr=False)
    scenarios: Mapping[str, Scenario] = field(repr=False)

    def __getitem__(self, scenario: str) -> Scenario:
        return self.scenarios[scenario]

    @property
    def models(self) -> Mapping[str, str]:
        """MJCF text by key: "lab", "shuffled", …"""
        models: Mapping[str, str] = self.manifest["models"]
        return models

    @property
    def robot(self) -> Robot:
        """What is graded on; where the manifest does not name it, the lab's."""
        about = self.manifest.get("robot", {"file": LAB_FILE, "imu": LAB_IMU})
        return Robot(about["file"], self.models.get("lab", ""), tuple(about["imu"]))

    def are_of(self, model: Model) -> bool:
        """Whether they were recorded for the robot that a rubric names."""
        return (self.robot.file, self.robot.imu) == (model.file, model.imu)

    @property
    def versions(self) -> Mapping[str, str]:
        """What recorded it: python, mujoco, numpy."""
        versions: Mapping[str, str] = self.manifest["versions"]
        return versions


def match_robot(model: Model, traces: Traces) -> None:
    """Refuse traces of another robot than the rubric names.

    Raises
    ------
    RubricError
        With the line that names it.
    """
    if not traces.are_of(model):
        has, wants = traces.robot, f"{model.file} ({', '.join(model.imu)})"
        said = f"the traces are of {has.file} ({', '.join(has.imu)}), not of {wants}; record them with this rubric"
        refuse(model.source, [(model.line("path"), printable(said, 600))])


# --- reading a bundle -----------------------------------------------------------------------------------------------


def load(path: Path) -> Traces:
    """Read a bundle and check that it is whole.

    Parameters
    ----------
    path : Path
        The `.npz` file; its manifest is the `.json` of the same name beside it.

    Raises
    ------
    RequestError
        If one of the two is missing, broken or not as it was recorded.
    """
    manifest = _read_manifest(path.with_suffix(".json"))
    arrays = _read_arrays(path)
    if _fingerprint(arrays, manifest) != manifest["sha256"]:
        raise RequestError(f"{path}: the traces are not those of the manifest beside it; record them again")
    try:
        scenarios = {name: _scenario(name, about, arrays) for name, about in manifest["scenarios"].items()}
    except (KeyError, TypeError, AttributeError) as error:
        raise RequestError(
            f"{path.with_suffix('.json')}: incomplete manifest ({error}); record the traces again"
        ) from None
    return Traces(manifest["name"], manifest["sha256"], manifest, arrays, scenarios)


def shipped() -> Traces:
    """The public bundle that comes with the package."""
    return load(beside("grader.labs.imu", "public.npz"))


def _read_manifest(path: Path) -> dict[str, Any]:
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RequestError(f"{path}: cannot read the manifest of the traces ({error.strerror})") from None
    except ValueError as error:
        raise RequestError(f"{path}: the manifest is not JSON ({error}); record the traces again") from None
    schema = manifest.get("schema") if isinstance(manifest, dict) else None
    if schema != SCHEMA:
        raise RequestError(f"{path}: its schema is {schema!r}, this version reads {SCHEMA!r}; record the traces again")
    missing = {"name", "sha256", "scenarios", "models", "versions"} - manifest.keys()
    if missing:
        raise RequestError(f"{path}: the manifest lacks {', '.join(sorted(missing))}; record the traces again")
    return dict(manifest)


def _read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        # Opened here: of a damaged archive np.load would leave the file open.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except OSError as error:
        raise RequestError(f"{path}: cannot read the traces ({error.strerror or error})") from None
    except (ValueError, EOFError, AttributeError, zipfile.BadZipFile, zlib.error):
        raise RequestError(f"{path}: not a trace bundle, or a damaged one; record the traces again") from None
    for array in arrays.values():
        array.setflags(write=False)  # one bundle serves every submission of a class
    return arrays


def _scenario(name: str, about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Scenario:
    own = {key: arrays[f"{name}/{key}"] for key in about["arrays"]}
    return Scenario(name, about["description"], about["model"], about["scalars"], own)


def _fingerprint(arrays: Mapping[str, NDArray[Any]], manifest: Mapping[str, Any]) -> str:
    """As the recorder computes it: the arrays' names, types, shapes, bytes, then the manifest but for two fields."""
    digest = hashlib.sha256()
    for key in sorted(arrays):
        array = arrays[key]
        digest.update(f"{key}\0{array.dtype.str}\0{array.shape}\0".encode())
        digest.update(array.tobytes(order="C"))
    content = {key: value for key, value in manifest.items() if key not in {"versions", "sha256"}}
    digest.update(json.dumps(content, sort_keys=True, separators=(",", ":")).encode())
    return digest.hexdigest()


# --- obtaining one: shipped, cached or recorded ---------------------------------------------------------------------


def obtain(seed: str | None, cache_dir: Path | None = None, model: Model = LAB_MODEL) -> Traces:
    """The bundle to grade with.

    Parameters
    ----------
    seed : str or None
        The instructor's secret, any text, for hidden traces; None for the public ones.
    cache_dir : Path, optional
        Where recorded bundles are kept; `$IMUGRADE_CACHE` or the platform's cache folder if left out.
    model : Model, optional
        The robot that the rubric names; the lab's if left out.

    Raises
    ------
    RequestError
        If hidden traces are wanted where the reference is not installed, or the seed is empty; a RubricError where the
        model cannot be graded, with the line.
    GraderError
        If recording hidden traces fails.
    """
    kept = cache_dir or default_cache_dir()
    if seed is None:
        return _public(kept) if model.is_lab else _public_of(model, kept)
    if not seed.strip():
        raise RequestError("the seed is empty; give any text that students cannot guess")
    if _reference() is None:
        raise RequestError("hidden traces need the reference, which is not installed here; grade without a seed")
    return _recorded("hidden", seed, kept, None if model.is_lab else _one_text(model))


def rehearse() -> Traces | None:
    """Hidden traces from a secret that is thrown away, to see whether they can be had here; None without the reference.

    Raises
    ------
    GraderError, RequestError
        If they cannot be recorded, or not read.
    """
    if _reference() is None:
        return None
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        return _fresh("hidden", secrets.token_hex(), Path(scratch, "bundle"))


def default_cache_dir() -> Path:
    """`$IMUGRADE_CACHE`, or the place where this platform keeps what can be made again."""
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "imugrade" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "imugrade"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "imugrade"


def _public(cache_dir: Path) -> Traces:
    """The shipped bundle where the simulator is the one that recorded it, else one recorded here, if that can be."""
    ours = shipped()
    if ours.versions["mujoco"] == version("mujoco") or _reference() is None:
        return ours
    try:
        return _recorded("public", str(ours.manifest["seed"]), cache_dir)
    except GraderError:
        return ours  # other digits at worst: comparisons allow for them


def _public_of(model: Model, cache_dir: Path) -> Traces:
    """The shipped bundle where a kit brought that of this robot, else one that is recorded here."""
    ours = shipped()
    carried = ours.are_of(model) and ours.robot.xml == _content(model)
    if carried and (ours.versions["mujoco"] == version("mujoco") or _reference() is None):
        return ours
    if _reference() is None:
        what = "the public traces of another model need the reference, which is not installed here"
        raise RequestError(f"{what}; use the kit that your instructor gave you")
    return _recorded("public", str(ours.manifest["seed"]), cache_dir, _one_text(model))


def _content(model: Model) -> str:
    try:
        return model.path.read_text(encoding="utf-8") if model.path else shipped().models["lab"]
    except (OSError, ValueError):
        return ""


def _one_text(model: Model) -> Robot:
    """The model with all that it includes.

    Raises
    ------
    RubricError
        If it cannot be graded: a line for each reason.
    GraderError
        If reading it fails for another one.
    """
    path = (model.path or _SOURCES / "reference" / "models" / LAB_FILE).resolve()
    names = ["--accelerometer", model.accelerometer, "--gyroscope", model.gyroscope]
    done = _run(["reference.robot", str(path), *names], "reading the model")
    if done.returncode == _UNFIT:
        reasons = json.loads(done.stderr.strip().splitlines()[-1])["unfit"]
        refuse(model.source, [(model.line(key), printable(text, 600)) for key, text in reasons])
    if done.returncode:
        raise GraderError(f"reading the model failed: {_last_line(done)}")
    return Robot(model.file, done.stdout, model.imu)


def _reference() -> Path | None:
    """The reference's folder beside this package. Not looked up by name: a student's folder could be called that."""
    folder = _SOURCES / "reference"
    return folder if (folder / "traces.py").is_file() else None


def _recorded(name: str, seed: str, cache_dir: Path, robot: Robot | None = None) -> Traces:
    """From the cache, or recorded and put there. A damaged entry is made again; a cache is not needed."""
    entry = cache_dir / "traces" / _cache_key(name, seed, robot)
    try:
        return load(entry / f"{name}.npz")
    except RequestError:
        shutil.rmtree(entry, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        fresh = Path(scratch) / "bundle"
        traces = _fresh(name, seed, fresh, robot)
        _keep(fresh, entry)
    return traces


def _fresh(name: str, seed: str, folder: Path, robot: Robot | None = None) -> Traces:
    _record(name, seed, folder, robot)
    return load(folder / f"{name}.npz")


def _keep(fresh: Path, entry: Path) -> None:
    """Put a bundle into the cache in one move, so that nobody sees half of it. Failing to is no harm."""
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=".staging-", dir=entry.parent))  # mode 0700: hidden traces are secret
    except OSError:
        return
    try:
        shutil.copytree(fresh, staging, dirs_exist_ok=True)
        staging.chmod(0o700)  # copytree copies the folder's own mode too
        staging.rename(entry)  # fails where another process was faster, with the same bundle
    except OSError:
        shutil.rmtree(staging, ignore_errors=True)


def _record(name: str, seed: str, out: Path, robot: Robot | None) -> None:
    """Run the recorder. The seed goes by a pipe: a command line can be read by other users."""
    command = ["reference.traces", "--out", str(out), "--name", name, "--seed", "-"]
    if robot is not None:
        file = out.parent / "model" / robot.file
        file.parent.mkdir()
        file.write_text(robot.xml, encoding="utf-8", newline="")
        command += ["--model", str(file), "--accelerometer", robot.imu[0], "--gyroscope", robot.imu[1]]
    what = f"recording the {name} traces"
    done = _run(command, what, seed)
    if done.returncode:
        raise GraderError(f"{what} failed: {_last_line(done)}")


def _run(module: list[str], what: str, text: str = "") -> subprocess.CompletedProcess[str]:
    """Run a module of the reference with its arguments, in a process of its own."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"} | {"MPLBACKEND": "Agg"}
    try:
        return subprocess.run(
            [sys.executable, "-m", *module],
            input=text,
            cwd=_SOURCES,  # `-m` looks here first
            env=environment,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=RECORDING_LIMIT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise GraderError(f"{what} failed: {type(error).__name__}") from None


def _last_line(done: subprocess.CompletedProcess[str]) -> str:
    return (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]


def _cache_key(name: str, seed: str, robot: Robot | None = None) -> str:
    """What the numbers depend on: name, seed, robot, versions, processor and the reference's own files."""
    digest = hashlib.sha256()
    parts = [SCHEMA, name, seed, version("mujoco"), version("numpy"), platform.machine(), platform.system()]
    parts += [robot.file, robot.xml, *robot.imu] if robot else []
    digest.update("\0".join(parts).encode("utf-8", "surrogatepass"))
    folder = _reference()
    sources = sorted([*folder.glob("*.py"), *folder.glob("models/*.xml")]) if folder else []
    for source in sources:
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:32]
