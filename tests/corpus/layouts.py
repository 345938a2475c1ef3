"""Layouts of the sheet's steps: what the cases of `module_level.yaml` change is handed in as files, as one file, as a notebook."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tests.corpus.pieces import steps, three_files
from tests.corpus.writing import Files, notebook

Steps = Mapping[str, str]


def one_file(steps: Steps) -> Files:
    return {"lab.py": "\n".join(steps.values())}


def one_notebook(steps: Steps) -> Files:
    return {"lab.ipynb": notebook(*steps.values())}


LAYOUTS: Mapping[str, Callable[[Steps], Files]] = {
    "three-files": three_files,
    "one-file": one_file,
    "notebook": one_notebook,
}


def above(step: str, code: str) -> Steps:
    """Return the sheet's steps with code above one of them."""
    sheet = steps()
    return {**sheet, f"{step}.py": f"{code}\n\n{sheet[f'{step}.py']}"}
