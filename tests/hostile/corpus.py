"""All programs of the corpus."""

from __future__ import annotations

from tests.hostile.denying import DENIALS
from tests.hostile.escaping import ESCAPES
from tests.hostile.forging import LYING, PATCHED, PLOTS
from tests.hostile.forging_protocol import FORGED
from tests.hostile.poisoning import POISONS
from tests.hostile.program import Program
from tests.hostile.reading import BYTES

PROGRAMS: tuple[Program, ...] = (*PATCHED, *PLOTS, *LYING, *FORGED, *DENIALS, *ESCAPES, *POISONS, *BYTES)
