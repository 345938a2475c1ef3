"""`python -m grader` is `imugrade`, but for one thing: Python runs a `grader.py` that lies where it is called first."""

from __future__ import annotations

import os
import sys


def _import_nothing_from_here() -> None:
    """With `-m` modules are looked for in the current folder first, which may be a student's."""
    home = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    if sys.path[0] == os.getcwd() != home:
        del sys.path[0]


if __name__ == "__main__":  # a worker process of a run imports this file again
    _import_nothing_from_here()
    from grader.cli import main

    sys.exit(main())
