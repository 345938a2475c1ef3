"""The bases of the corpus, from `bases.yaml`: sound submissions in four hands, their parts, and how these are put together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from tests.corpus.writing import notebook

MODEL_PATH = "textbook/assets/robot-models/mujoco/humanoid-sensors.xml"
BASES = ("verbatim", "tidy", "listy", "looping", "steps")
_STEPS_OF = {
    "imu_reader.py": ("model", "reader", "reading", "recorder", "recording", "plot", "plotting"),
    "noisy_imu.py": ("noise", "noisy"),
    "filters.py": ("filter", "filtering"),
}
"""The steps of the sheet in each of its files."""
_PARTS_OF = {
    "imu_reader.py": ("head", "read", "collect", "plot", "main"),
    "noisy_imu.py": ("noise_head", "noise", "noise_main"),
    "filters.py": ("filter_head", "low_pass", "compare"),
}
"""The parts in each file of the other bases."""
PARTS = tuple(name for names in _PARTS_OF.values() for name in names)
_HEADS = {
    "imu_reader.py": "",
    "noisy_imu.py": "from imu_reader import *\n\n",
    "filters.py": "from noisy_imu import *\n\n",
}


@cache
def read(table: str) -> Mapping[str, Mapping[str, Any]]:
    """Return what a YAML file of this folder holds."""
    text = (Path(__file__).parent / f"{table}.yaml").read_text(encoding="utf-8")
    loaded: Mapping[str, Mapping[str, Any]] = yaml.load(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    return loaded


def part(base: str, name: str) -> str:
    """Return the code of a part of a base; what the base does not have of its own is that of `tidy`."""
    bases = read("bases")
    found = bases[base][name] if name in bases[base] else bases["tidy"][name]
    if isinstance(found, str):
        return found
    ((other, its_name),) = found.items()
    return part(other, its_name)


def steps() -> dict[str, str]:
    """Return the code of the sheet, a file for each step."""
    return {f"{name}.py": part("steps", name) for names in _STEPS_OF.values() for name in names}


def three_files(steps: Mapping[str, str]) -> dict[str, str]:
    """Return the sheet's three files, with a blank line between the steps, as they are pasted into a file."""
    return {path: _HEADS[path] + "\n".join(steps[f"{name}.py"] for name in names) for path, names in _STEPS_OF.items()}


def lab_of(base: str, parts: Mapping[str, str]) -> dict[str, str]:
    """Return the files of a base with other parts: their code, or the base that has it.

    Raises
    ------
    ValueError
        If the base has no such part.
    """
    if base in ("steps", "verbatim"):
        if parts:
            raise ValueError(f"the base {base!r} is not made of parts")
        return steps() if base == "steps" else verbatim()
    if unknown := set(parts) - set(PARTS):
        raise ValueError(f"no parts: {sorted(unknown)}")
    code = {name: part(parts[name], name) if parts[name] in BASES else parts[name] for name in parts}
    return {
        path: "\n\n".join(code[name] if name in code else part(base, name) for name in names)
        for path, names in _PARTS_OF.items()
    }


def lab(**parts: str) -> dict[str, str]:
    """Return the sheet's three files from parts; what is not given is that of `tidy`."""
    return lab_of("tidy", parts)


def verbatim() -> dict[str, str]:
    """The sheet's own code in three files."""
    return three_files(steps())


def tidy() -> dict[str, str]:
    """Functions, a generator, main guards: nothing runs at import."""
    return lab_of("tidy", {})


def edit(files: Mapping[str, str], path: str, *changes: tuple[str, str]) -> dict[str, str]:
    """Return the files with passages of one exchanged, one after the other; each must be there exactly once.

    Raises
    ------
    ValueError
        If a passage is missing or not unique: the sample would then not have the fault that it claims.
    """
    text = files[path]
    for old, new in changes:
        if text.count(old) != 1:
            raise ValueError(f"{path} holds {text.count(old)} of {old!r}, one is needed")
        text = text.replace(old, new)
    return {**files, path: text}


LAYOUTS: Mapping[str, Callable[[Mapping[str, str]], dict[str, str]]] = {
    "three-files": three_files,
    "one-file": lambda steps: {"lab.py": "\n".join(steps.values())},
    "notebook": lambda steps: {"lab.ipynb": notebook(*steps.values())},
}
"""How the sheet's steps, with an edit from `module_level.yaml`, are handed in."""
VERBATIM = verbatim()
IMU_READER, NOISY, FILTERS = VERBATIM.values()
PLOT_LOOP = part("tidy", "plot")
FILTER_INCREMENT = part("tidy", "low_pass")
COMPARE = part("tidy", "compare")
COLLECT_WHILE = part("looping", "collect")
