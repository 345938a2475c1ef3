"""`python -m grader` is `imugrade`."""

from __future__ import annotations

import sys

from grader.cli import main

if __name__ == "__main__":  # a worker process of a run imports this file again
    sys.exit(main())
