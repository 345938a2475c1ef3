"""Record ground-truth traces: run the scenarios and write them as a bundle of files, all that the grader gets of the truth.

A bundle is `<name>.npz`, whose arrays are called `<scenario>/<array>`, and `<name>.json`, its manifest. The same seed and the same
versions give the same bytes. `python -m reference.traces --out DIR` records the public bundle.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import platform
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from . import robot
from .robot import Robot
from .scenarios import PUBLIC_SEED, Bundle, simulate
from .scene import LAB_PAIR, Recording

SCHEMA = "imugrade/traces/v1"

UNITS = {
    "time": "s",
    "acceleration": "m/s²",
    "angular_velocity": "rad/s",
    "accel_bias": "m/s²",
    "gyro_bias": "rad/s",
    "qpos": "m, unit quaternion, rad",
    "qvel": "m/s, rad/s",
    "qacc": "m/s², rad/s²",
    "cvel": "rad/s, m/s",
    "cacc": "rad/s², m/s²",
    "sensordata": "SI, as MuJoCo defines each sensor",
}
FRAMES = {
    "acceleration": "the sensor site's own; specific force, so gravity shows up as an upward push",
    "angular_velocity": "the sensor site's own",
    "site_xmat": "rotation from the site's frame into the world's",
    "cvel": "of the accelerometer's body: rotation, then translation, in the world's axes, at the centre of mass of its tree",
    "cacc": "as cvel; with gravity",
    "rows": "read right after mj_step; time is data.time after that step",
}


def fingerprint(arrays: Mapping[str, NDArray[Any]], manifest: Mapping[str, Any]) -> str:
    """Return a hash of arrays and manifest (without `versions` and `sha256`), by which the grader notices changed files."""
    digest = hashlib.sha256()
    for key in sorted(arrays):
        array = arrays[key]
        digest.update(f"{key}\0{array.dtype.str}\0{array.shape}\0".encode())
        digest.update(array.tobytes(order="C"))
    content = {key: value for key, value in manifest.items() if key not in {"versions", "sha256"}}
    digest.update(json.dumps(content, sort_keys=True, separators=(",", ":")).encode())
    return digest.hexdigest()


def record(out: Path, seed: str = PUBLIC_SEED, name: str = "public", own: Robot | None = None) -> Path:
    """Simulate all scenarios and write them as a bundle.

    Parameters
    ----------
    out : Path
        Folder; it is made if it is missing.
    seed : str
        Any text; all random numbers follow from it. The manifest of the public bundle contains it, that of a hidden one does not.
    name : str
        "public", or "hidden" for random settings and robot variants; also the name of the files.
    own : Robot, optional
        The instructor's own robot, in place of the lab's.

    Returns
    -------
    Path
        The `.npz` file; the manifest lies beside it.
    """
    bundle = simulate(name, seed, own)
    arrays = flat_arrays(bundle)
    manifest = _manifest(bundle, name, seed)
    if own is not None:
        manifest["robot"] = own.about()
    manifest["sha256"] = fingerprint(arrays, manifest)
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{name}.npz"
    write_npz(path, arrays)
    text = json.dumps(manifest, indent=1, ensure_ascii=False) + "\n"
    path.with_suffix(".json").write_text(text, encoding="utf-8", newline="\n")
    return path


def flat_arrays(bundle: Bundle) -> dict[str, NDArray[Any]]:
    """Return scenarios' arrays by `<scenario>/<array>`, as a trace file holds them: float64, or int64 for counts and indices."""
    flat = {f"{one.name}/{key}": np.asarray(value) for one in bundle.recordings for key, value in one.arrays.items()}
    return {key: array.astype("<i8" if array.dtype.kind == "i" else "<f8") for key, array in flat.items()}


def write_npz(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as `np.savez_compressed` does, but with a fixed date in the archive: the same arrays give the same file."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key in sorted(arrays):
            member = zipfile.ZipInfo(f"{key}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            member.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(member, "w") as stream:
                np.lib.format.write_array(stream, np.array(arrays[key], order="C"), allow_pickle=False)


def _manifest(bundle: Bundle, name: str, seed: str) -> dict[str, Any]:
    public = {"seed": seed} if name == "public" else {}
    return {
        "schema": SCHEMA,
        "name": name,
        **public,
        "units": UNITS,
        "frames": FRAMES,
        "versions": {
            "python": platform.python_version(),
            "mujoco": mujoco.__version__,
            "numpy": np.__version__,
        },
        "scenarios": {one.name: _about(one) for one in bundle.recordings},
        "models": dict(bundle.models),
    }


def _about(one: Recording) -> dict[str, Any]:
    return {
        "description": one.description,
        "model": one.model,
        "arrays": sorted(one.arrays),
        "scalars": dict(one.scalars),
    }


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m reference.traces", description="Record ground-truth traces.")
    parser.add_argument("--out", type=Path, required=True, help="folder to write the bundle into")
    parser.add_argument("--seed", default=PUBLIC_SEED, help="any text; '-' reads it from standard input")
    parser.add_argument("--model", type=Path, help="the instructor's own robot, an MJCF file")
    parser.add_argument("--accelerometer", metavar="NAME", default=LAB_PAIR[0], help="sensor of that robot")
    parser.add_argument("--gyroscope", metavar="NAME", default=LAB_PAIR[1], help="sensor of that robot")
    parser.add_argument("--name", choices=["public", "hidden"], help="default: public for the public seed, else hidden")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    arguments = _arguments(argv)
    # A secret on the command line could be read by every user of the machine, so it may come by a pipe.
    seed = sys.stdin.read().rstrip("\r\n") if arguments.seed == "-" else arguments.seed
    name = arguments.name or ("public" if seed == PUBLIC_SEED else "hidden")
    own = arguments.model and robot.read(arguments.model, arguments.accelerometer, arguments.gyroscope)
    print(record(arguments.out, seed, name, own))
    return 0


if __name__ == "__main__":
    sys.exit(main())
