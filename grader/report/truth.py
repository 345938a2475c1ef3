"""List and save bundles of traces, the recorded truth, for `imugrade traces` and the kits."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from grader.base.errors import RequestError
from grader.base.files import write_whole
from grader.base.text import printable
from grader.engine.traces import Scenario, Traces


def listing(traces: Traces) -> str:
    """Describe traces (true recordings): name, hash, versions of the packages that recorded them, scenarios and array shapes."""
    versions = ", ".join(f"{name} {number}" for name, number in traces.versions.items())
    head = [f"{traces.name} traces, {traces.sha256[:16]}, recorded with {versions}"]
    return "\n".join([*head, *(line for scenario in traces.scenarios.values() for line in _described(scenario))])


def _described(scenario: Scenario) -> list[str]:
    shapes = (f"{name} {'×'.join(map(str, array.shape)) or 'scalar'}" for name, array in scenario.items())
    return ["", f"{scenario.name}: {printable(scenario.description, 300)}", *(f"  {shape}" for shape in shapes)]


def save(traces: Traces, out: Path) -> Path:
    """Write traces (true recordings) as `<name>.npz` and `<name>.json`, readable only by their owner: hidden ones are secret.

    The path of the `.npz` file is returned.

    Raises
    ------
    RequestError
        If it cannot be written.
    """
    path = out / f"{traces.name}.npz"
    arrays: dict[str, Any] = dict(traces.arrays)
    write_whole(path.with_suffix(".json"), json.dumps(dict(traces.manifest), indent=2, ensure_ascii=False) + "\n")
    try:
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as stream:
            np.savez_compressed(stream, **arrays)
        path.with_suffix(".json").chmod(0o600)
    except OSError as problem:
        raise RequestError(f"{path}: cannot write it: {problem.strerror or problem}; choose another place") from problem
    return path


def files(traces: Traces) -> dict[str, bytes]:
    """Return the contents of the files that `save` writes, by suffix (".npz", ".json"), to pack them into a zip or a wheel."""
    with tempfile.TemporaryDirectory(prefix="imugrade-") as scratch:
        path = save(traces, Path(scratch))
        return {suffix: path.with_suffix(suffix).read_bytes() for suffix in (".json", ".npz")}
