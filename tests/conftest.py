"""Ctrl-C reaches what the tests start, also where a shell runs them in the background and has switched it off for them."""

from __future__ import annotations

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
