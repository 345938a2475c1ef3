"""What all tests run under.

Ctrl-C reaches what the tests start, also where a shell runs them in the background and has switched it off for them. And modules are
compiled once, as they are wherever the package is installed, also where the environment says otherwise: the tests start hundreds of
processes.
"""

from __future__ import annotations

import os
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
