"""List, save and pack traces, the true recordings that submissions are compared with, for `imugrade traces` and `imugrade kit`."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from grader.base.errors import RequestError
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
    try:
        out.mkdir(parents=True, exist_ok=True)
        for suffix, content in files(traces).items():
            with open(os.open(path.with_suffix(suffix), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as stream:
                path.with_suffix(suffix).chmod(0o600)  # one that was there keeps its mode
                stream.write(content)
    except OSError as problem:
        raise RequestError(f"{path}: cannot write it: {problem.strerror or problem}; choose another place") from problem
    return path


def files(traces: Traces) -> dict[str, bytes]:
    """Return the contents of the files that `save` writes, by suffix (".json", ".npz"), to pack them into a zip or a wheel."""
    arrays, packed = dict[str, Any](traces.arrays), io.BytesIO()
    np.savez_compressed(packed, **arrays)
    manifest = json.dumps(dict(traces.manifest), indent=2, ensure_ascii=False) + "\n"
    return {".json": manifest.encode("utf-8", "replace"), ".npz": packed.getvalue()}
