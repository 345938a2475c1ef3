"""Where Python says what it expected, that is put there: the whole text reads as before the slip, or as it must be meant."""

from __future__ import annotations

import ast

import pytest

from grader.harness import completing
from tests.corpus.sheet import VERBATIM

pytestmark = pytest.mark.quick
TEXT = str(VERBATIM["imu_reader.py"]) + str(VERBATIM["filters.py"])
RETURN, STEPS = "        return self.value.copy()", "    for i in range(n_steps):"
MENDED: dict[str, tuple[str, str, str]] = {
    "a colon after a function": ("def update(self, measurement):", "def update(self, measurement)", ""),
    "a colon before a comment": (STEPS, f"{STEPS[:-1]}  # n: steps", f"{STEPS[:-1]}  :# n: steps"),
    "a colon after a class": ("class LowPassFilter:", "class LowPassFilter", ""),
    "a colon after else": ("        else:\n", "        else\n", ""),
    "a comparison with None": ("if self.value is None:", "if self.value = None:", ""),
    "a comparison": ("if self.value is None:", "if self.alpha = 1:", "if self.alpha == 1:"),
    "a bracket of a call": (RETURN, f"{RETURN[:-1]}", ""),
    "a bracket of a call that goes on": ("np.zeros((n_steps, 3))\n    angular", "np.zeros((n_steps, 3)\n    angular", ""),
    "a bracket before a colon": (STEPS, "    for i in range(n_steps:", ""),
    "a bracket of parameters": ("def update(self, measurement):", "def update(self, measurement:", ""),
    "a bracket of several lines": ("        'angular_velocity': angular_velocities\n    }", "        'angular_velocity': angular_velocities", "        'angular_velocity': angular_velocities}"),
    "a bracket too many": (RETURN, f"{RETURN})", ""),
    "a bracket of another kind": (RETURN, f"{RETURN[:-1]}]", ""),
    "a quote": ("set_title('Accelerometer Readings')", "set_title('Accelerometer Readings)", ""),
    "quotes of a book": ("set_title('Accelerometer Readings')", "set_title(‘Accelerometer Readings’)", ""),
    "a space of a book": ("    n_steps = int(", "    n_steps =\xa0int(", ""),
    "a comma between values": ("np.zeros((n_steps, 3))\n    angular", "np.zeros((n_steps 3))\n    angular", ""),
    "a comma between parameters": ("(model, data, accel_sensor_id,", "(model, data accel_sensor_id,", ""),
    "a comma between lines": ("        'time': times,\n        'acc", "        'time': times\n        'acc", "        'time': times\n,        'acc"),
    "a line too far out": (RETURN, RETURN[4:], ""),
    "a line a space too far in": (RETURN, f" {RETURN}", ""),
    "a line a space too far out": (RETURN, RETURN[1:], ""),
    "a tabulator": (RETURN, RETURN.replace("        ", "\t"), ""),
    "a merge that is not finished": (STEPS, f"<<<<<<< HEAD\n{STEPS}\n=======\n    for i in range(3):\n>>>>>>> theirs", f"\n{STEPS}\n\n\n"),
    "a merge with what was there before": (STEPS, f"<<<<<<< HEAD\n{STEPS}\n||||||| base\n    for i in (1,):\n=======\n    for i in range(3):\n>>>>>>> theirs", f"\n{STEPS}\n\n\n\n\n"),
    "a mark of a merge": (STEPS, f"<<<<<<< HEAD\n{STEPS}", f"\n{STEPS}"),
    "a block with nothing in it": ("class LowPassFilter:", "def helper(x):  # later\n\nclass LowPassFilter:", "def helper(x): pass  # later\n\nclass LowPassFilter:"),
    "print as a statement": ('print(f"Angular velocity: {gyro}")', 'print f"Angular velocity: {gyro}"', ""),
    "else if": ("        else:\n", "        else if self.alpha:\n", "        elif self.alpha:\n"),
    "an increment": ("        times[i] = data.time\n", "        times[i] = data.time\n        i++\n", "        times[i] = data.time\n        i += 1\n"),
}  # fmt: skip


def _read(text: str) -> None:
    compile(ast.parse(text), "lab.py", "exec")


def _completed(text: str) -> tuple[str, list[SyntaxError]] | None:
    with pytest.raises(SyntaxError) as refused:
        _read(text)
    return completing.completed(text, refused.value, _read)


def _slipped(old: str, new: str) -> str:
    assert TEXT.count(old) == 1
    return TEXT.replace(old, new)


@pytest.mark.parametrize(("old", "new", "meant"), MENDED.values(), ids=MENDED)
def test_it_reads_as_it_is_meant(old: str, new: str, meant: str) -> None:
    found = _completed(_slipped(old, new))
    assert found is not None
    assert found[0] == TEXT.replace(old, meant or old)
    assert len(found[1]) == 1


def test_several_slips_are_put_right_one_after_the_other() -> None:
    text = (
        _slipped(STEPS, STEPS[:-1]).replace("class LowPassFilter:", "class LowPassFilter").replace(RETURN, f"{RETURN})")
    )
    found = _completed(text)
    assert found is not None
    assert found[0] == TEXT
    at = {TEXT.split("\n")[(each.lineno or 0) - 1] for each in found[1]}
    assert at == {STEPS, "class LowPassFilter:", RETURN}


LEFT = {
    "five slips": TEXT.replace("):\n", ")\n"),
    "an import that is not finished": _slipped("import numpy as np\n", "import numpy as\n"),
    "no program": "Dear player, this\nis my work. For\nthe lab!",
    "more than can be read again and again": "x = (\n" + "1 +\n" * 60_000,
}


@pytest.mark.parametrize("text", LEFT.values(), ids=LEFT)
def test_what_may_mean_anything_is_left(text: str) -> None:
    assert _completed(text) is None
