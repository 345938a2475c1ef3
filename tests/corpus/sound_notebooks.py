"""Sound notebooks with what notebooks hold beside Python: magics, shell commands, files that they write and run."""

from __future__ import annotations

from tests.corpus.pieces import COLLECT_LOOKUP, FILTER_INCREMENT, HEAD, NOISE_GENERATOR, PLOT_LOOP, READ_DIM
from tests.corpus.sound_layouts import COMPARE_CELLS, RUN_CELL
from tests.corpus.writing import notebook

FILTER_WITH_QUESTION = FILTER_INCREMENT.replace("dtype=float)\n        if", "dtype=float)  # is a copy needed?\n        if")
PARTS = (READ_DIM, COLLECT_LOOKUP, PLOT_LOOP, RUN_CELL, NOISE_GENERATOR, FILTER_INCREMENT, *COMPARE_CELLS)


def whole(*, head: str = HEAD, low_pass: str = FILTER_INCREMENT) -> dict[str, str]:
    """The lab in one notebook, some of its cells in other words."""
    return {"lab.ipynb": notebook(head, *(low_pass if part is FILTER_INCREMENT else part for part in PARTS))}


NOTEBOOKS = {
    "notebook_installs_over_two_lines": whole(head="!apt-get update && \\\n  apt-get install -y 'libgl1' \\\n  # it's slow\n" + HEAD),
    "notebook_asks_in_a_comment": whole(
        head="%matplotlib widget\n" + HEAD.replace("numpy as np", "numpy as np  # or jax.numpy?"),
        low_pass="%load_ext autoreload\n" + FILTER_WITH_QUESTION,
    ),
    "notebook_times_with_options": whole(
        low_pass=FILTER_INCREMENT + "\n%timeit -n10 -r 1 LowPassFilter().update(np.zeros(3))\nlow = %timeit -o -q LowPassFilter()\n%time \n",
    ),
    "notebook_formats_with_percent": whole(low_pass="!ls\nprint('alpha %s of %s'\n      % (0.1, 'filter'))\n" + FILTER_INCREMENT),
    "notebook_waits_at_top_level": whole(low_pass="import asyncio\n\nawait asyncio.sleep(0)\n" + FILTER_INCREMENT),
}
