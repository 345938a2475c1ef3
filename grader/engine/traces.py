"""Load and verify ground truth: bundles of traces, the arrays of each scenario, with a manifest.

A lab's recorder writes bundles and the grader reads them; neither imports the other.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grader.base.errors import RequestError

SCHEMA = "imugrade/traces/v1"


@dataclass(frozen=True, eq=False)
class Scenario(Mapping[str, NDArray[Any]]):
    """Ground truth of one scenario: read-only arrays, as `scenario["acceleration"]` or `scenario.acceleration`.

    `scalars` holds values that are no arrays, such as the time step; `model` is the key of the simulated model in `Traces.models`,
    None without a model.
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
        # Called for unknown names only. While a copy is unpickled it has no fields yet, so they are read from `__dict__`.
        arrays: Mapping[str, NDArray[Any]] = self.__dict__.get("arrays", {})
        if key not in arrays:
            raise AttributeError(f"scenario {self.__dict__.get('name')!r} has no array {key!r}")
        return arrays[key]


@dataclass(frozen=True, eq=False)
class Traces:
    """Ground truth to grade with: the true recording of each scenario (simulated motion), such as `traces["push"].acceleration`.

    The attribute `arrays` holds the same arrays by `<scenario>/<array>`, as the file does; `manifest` is the JSON beside the file.
    """

    name: str
    sha256: str
    manifest: Mapping[str, Any] = field(repr=False)
    arrays: Mapping[str, NDArray[Any]] = field(repr=False)
    scenarios: Mapping[str, Scenario] = field(repr=False)

    def __getitem__(self, scenario: str) -> Scenario:
        return self.scenarios[scenario]

    @property
    def models(self) -> Mapping[str, str]:
        """The MJCF texts of the models that the scenarios simulate, by the key in `Scenario.model`."""
        models: Mapping[str, str] = self.manifest["models"]
        return models

    @property
    def versions(self) -> Mapping[str, str]:
        """The versions of the packages with which this ground truth was recorded."""
        versions: Mapping[str, str] = self.manifest["versions"]
        return versions


def load(path: Path) -> Traces:
    """Read ground truth from the file `path` (``.npz``), and verify it against its manifest, the ``.json`` of the same name.

    Raises
    ------
    RequestError
        If one of the two is missing, damaged or changed since it was recorded.
    """
    manifest = _read_manifest(path.with_suffix(".json"))
    arrays = _read_arrays(path)
    if _fingerprint(arrays, manifest) != manifest["sha256"]:
        raise RequestError(f"{path}: the traces do not match their manifest; record them again")
    try:
        scenarios = {name: _scenario(name, about, arrays) for name, about in manifest["scenarios"].items()}
    except (KeyError, TypeError, AttributeError) as error:
        raise RequestError(
            f"{path.with_suffix('.json')}: incomplete manifest ({error}); record the traces again"
        ) from None
    return Traces(manifest["name"], manifest["sha256"], manifest, arrays, scenarios)


def _read_manifest(path: Path) -> dict[str, Any]:
    """Read the manifest of ground truth; raise RequestError if it is missing, no JSON, of another schema or incomplete."""
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
    """Read the arrays of ground truth, read-only, as all submissions share them; raise RequestError if the file is damaged."""
    try:
        # Opened here, because np.load leaves the file of a damaged archive open.
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
    """Return the digest of ground truth as the recorder computes it, to find out whether the files were changed.

    It covers the arrays, and the manifest without ``versions`` and ``sha256``.
    """
    digest = hashlib.sha256()
    for key in sorted(arrays):
        array = arrays[key]
        digest.update(f"{key}\0{array.dtype.str}\0{array.shape}\0".encode())
        digest.update(array.tobytes(order="C"))
    content = {key: value for key, value in manifest.items() if key not in {"versions", "sha256"}}
    digest.update(json.dumps(content, sort_keys=True, separators=(",", ":")).encode())
    return digest.hexdigest()
