"""What all tests run under.

Ctrl-C reaches what the tests start, also where a shell runs them in the background and has switched it off for them. And modules are
compiled once, as they are wherever the package is installed, also where the environment says otherwise: the tests start hundreds of
processes.
"""
# ruff: noqa: E402 - what is imported before that is not compiled once

from __future__ import annotations

import os
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from collections.abc import Iterator

import pytest

from grader.engine import rubric
from grader.engine.marking import Marker
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.tapes import suite


@pytest.fixture(scope="session")
def marker() -> Iterator[Marker]:
    """A warm one for whatever is marked by the lab's own rubric and data: to open one takes longer than to mark."""
    with Marker(rubric.load(LAB), bundles.shipped()) as opened:
        yield opened


@pytest.fixture(scope="session")
def player() -> Iterator[suite.Marking]:
    """The same from tapes, for what a test of `tests.tapes.suite` marks."""
    with suite.opened() as marking:
        yield marking
