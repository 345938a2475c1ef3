"""Run `imugrade` as `python -m grader`. Beware: Python runs a `grader.py` in the working folder instead, if there is one."""

from __future__ import annotations

import os
import sys


def _import_nothing_from_here() -> None:
    """Take the working folder off Python's path, where `-m` has put it: it may be a student's, with modules of any name."""
    home = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    if sys.path[0] == os.getcwd() != home:
        del sys.path[0]


if __name__ == "__main__":  # a worker process of a run imports this file again
    _import_nothing_from_here()
    from grader.cli import main

    sys.exit(main())
