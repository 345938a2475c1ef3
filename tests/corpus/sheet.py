"""The code of the lab sheet, step by step, with its indentation."""

from __future__ import annotations

from tests.corpus.pieces import part, verbatim

READER = part("steps", "reader")
COLLECT = part("steps", "recorder")
PLOT = part("steps", "plot")
LOW_PASS = part("steps", "filter")

VERBATIM = verbatim()
IMU_READER, NOISY, FILTERS = VERBATIM.values()
