"""Faults of Step 6: the filter."""



from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import FILTER_INCREMENT, edit, lab, verbatim
from tests.corpus.sound_models import FILTER_CLOSURE, FILTER_DATACLASS, FILTER_LFILTER

# The comparison needs it to be callable, which a sound stand-in is not.
FILTER_CALLED = FILTER_INCREMENT + "\n    __call__ = update\n"


def sheet(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(verbatim(), "filters.py", *changes)


def _edited(piece: str, *changes: tuple[str, str]) -> dict[str, str]:
    return lab(low_pass=edit({"f": piece}, "f", *changes)["f"])


def increment(*changes: tuple[str, str]) -> dict[str, str]:
    return _edited(FILTER_INCREMENT, *changes)


def dataclass(*changes: tuple[str, str]) -> dict[str, str]:
    return _edited(FILTER_DATACLASS, *changes)


def closure(*changes: tuple[str, str]) -> dict[str, str]:
    return _edited(FILTER_CLOSURE, *changes)


def fault(name: str, mistake: str, files: dict[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "filtering", files, **more)  # type: ignore[arg-type]


RECURSION = "self.value = self.alpha * measurement + (1 - self.alpha) * self.value"
FIRST = "self.value = measurement.copy()"
STEP = "self.state = self.state + self.alpha * (x - self.state)"
RETURN = "        return self.value.copy()\n"
INDEPENDENT = ("filtering.instances_independent",)

MOVING_AVERAGE = '''\
from collections import deque


class LowPassFilter:
    """The mean of the last 1/alpha samples or so."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.window = deque([] if initial_value is None else [np.array(initial_value, dtype=float)], maxlen=max(1, round(2 / alpha - 1)))

    def update(self, measurement):
        self.window.append(np.array(measurement, dtype=float))
        return np.mean(self.window, axis=0)
'''

TWO_STAGES = '''\
class LowPassFilter:
    """Two first-order stages behind each other: falls off twice as steeply."""

    def __init__(self, alpha=0.1, initial_value=None):
        self.alpha = alpha
        self.y1 = self.y2 = None if initial_value is None else np.array(initial_value, dtype=float)

    def update(self, measurement):
        x = np.array(measurement, dtype=float)
        if self.y1 is None:
            self.y1 = self.y2 = x
        self.y1 = self.y1 + self.alpha * (x - self.y1)
        self.y2 = self.y2 + self.alpha * (self.y1 - self.y2)
        return self.y2.copy()
'''

FILTER_FAULTS = [
    fault("nothing-from-the-first-update", "wrong-return-type", sheet((RETURN, "            return self.value.copy()\n")), loses=("filtering.starts_from_first_measurement",)),
    fault("writes-into-the-initial-value", "mutates-input", sheet((RECURSION, "self.value *= 1 - self.alpha\n            self.value += self.alpha * measurement"))),
    fault("one-output-array-for-all", "aliased-output", sheet(("class LowPassFilter:", "_OUT = np.empty(3)\n\n\nclass LowPassFilter:"), (RETURN, "        _OUT[:] = self.value\n        return _OUT\n"))),
    fault("alpha-of-the-class", "shared-state", sheet(("self.alpha = alpha", "LowPassFilter.alpha = alpha"))),
    fault("weights-exchanged", "alpha-swapped", sheet((RECURSION, "self.value = (1 - self.alpha) * measurement + self.alpha * self.value"))),
    fault("moves-by-one-minus-alpha", "alpha-swapped", increment((STEP, "self.state = self.state + (1 - self.alpha) * (x - self.state)"))),
    fault("called-with-exchanged-weights", "alpha-swapped", edit(
        lab(low_pass=FILTER_CALLED), "filters.py", ("self.state + self.alpha * (x - self.state)", "self.state + (1 - self.alpha) * (x - self.state)"), ("low_pass.update(accel)", "low_pass(accel)"),
    )),
    fault("alpha-stored-inverted", "alpha-swapped", closure(("exponential_average(alpha, initial_value)", "exponential_average(1 - alpha, initial_value)"))),
    fault("returns-its-input", "no-filtering", sheet((RETURN, "        return measurement.copy()\n"))),
    fault("state-is-the-input", "no-filtering", increment((STEP, "self.state = x"))),
    fault("starts-from-zeros", "zero-initial-state", sheet((FIRST, "self.value = self.alpha * measurement"))),
    fault("zeros-when-none", "zero-initial-state", increment(("None if initial_value is None else np.array(initial_value, dtype=float)", "np.zeros(3) if initial_value is None else np.array(initial_value, dtype=float)"))),
    fault("default-of-zero", "zero-initial-state", dataclass(("initial_value: Optional[np.ndarray] = None", "initial_value: Optional[np.ndarray] = 0.0"))),
    fault("initial-value-not-stored", "initial-value-ignored", sheet(("self.value = initial_value", "self.value = None"))),
    fault("initial-value-not-used", "initial-value-ignored", increment(("None if initial_value is None else np.array(initial_value, dtype=float)", "None"))),
    fault("first-output-is-first-input", "initial-value-ignored", dataclass(("        if self._previous is None:", "        if not hasattr(self, 'seen') or self._previous is None:\n            self.seen = True"))),
    fault("zeros-are-no-initial-value", "initial-value-ignored", sheet(("if self.value is None:", "if self.value is None or not np.any(self.value):")), loses=("filtering.starts_from_first_measurement",), reason="it starts again whenever its state is all zero"),
    fault("state-of-the-class", "shared-state", increment(("    def __init__(self", "    state = None\n\n    def __init__(self"), ("        self.state = None if initial_value is None else np.array(initial_value, dtype=float)\n", "        if initial_value is not None:\n            LowPassFilter.state = np.array(initial_value, dtype=float)\n"), ("            self.state = x\n", "            LowPassFilter.state = x\n"), (STEP, STEP.replace("self.state = ", "LowPassFilter.state = ")))),
    fault("state-in-a-global", "shared-state", sheet(("class LowPassFilter:", "_value = None\n\nclass LowPassFilter:"), ("        self.value = initial_value\n", ""), ("        if self.value is None:", "        global _value\n        if _value is None:"), (FIRST, "_value = measurement.copy()"), (RECURSION, "_value = self.alpha * measurement + (1 - self.alpha) * _value"), (RETURN, "        return _value.copy()\n"))),
    fault("state-in-a-default-list", "shared-state", increment(("initial_value=None):", "initial_value=None, _state=[]):"), ("        self.state = None if initial_value is None else np.array(initial_value, dtype=float)\n", "        self._s = _state\n        if initial_value is not None:\n            self._s[:] = [np.array(initial_value, dtype=float)]\n"), ("        if self.state is None:\n            self.state = x\n        else:\n            self.state = self.state + self.alpha * (x - self.state)\n        return self.state.copy()\n", "        self._s[:] = [x if not self._s else self._s[0] + self.alpha * (x - self._s[0])]\n        return self._s[0].copy()\n")), reason="a default list is one list for all"),
    fault("returns-its-state", "aliased-output", sheet((RETURN, "        return self.value\n")), loses=INDEPENDENT),
    fault("returns-its-state-in-place", "aliased-output", increment((STEP, "self.state += self.alpha * (x - self.state)"), ("return self.state.copy()", "return self.state")), loses=INDEPENDENT),
    fault("keeps-the-callers-array", "aliased-input", sheet((FIRST, "self.value = measurement")), loses=INDEPENDENT, reason="the state changes when the caller changes the array that was passed in"),
    fault("scales-its-input-in-place", "mutates-input", sheet((RECURSION, "old = (1 - self.alpha) * self.value\n            measurement *= self.alpha\n            self.value = measurement + old"))),
    fault("subtracts-in-place", "mutates-input", increment(("        x = np.array(measurement, dtype=float)\n", "        x = measurement\n"), ("            self.state = x\n", "            self.state = x.copy()\n"), (STEP, "x -= self.state\n            self.state = self.state + self.alpha * x"))),
    fault("only-the-first-sample", "output-stuck", increment((STEP, "pass"))),
    fault("weight-rounded-to-zero", "output-stuck", sheet(("self.alpha = alpha", "self.alpha = int(alpha)")), reason="int(0.1) is 0"),
    fault("gain-of-two", "gain-not-one", sheet((RECURSION, "self.value = self.alpha * measurement + self.value"))),
    fault("weights-sum-to-less", "gain-not-one", increment((STEP, "self.state = self.alpha * x + (0.95 - self.alpha) * self.state"))),
    fault("only-the-decay", "gain-not-one", closure(("alpha * x + (1 - alpha) * y", "alpha * x + alpha * y"))),
    fault("always-a-tenth", "alpha-ignored", sheet(("self.alpha = alpha", "self.alpha = 0.1"))),
    fault("numbers-in-the-recursion", "alpha-ignored", increment((STEP, "self.state = 0.1 * x + 0.9 * self.state"))),
    fault("previous-input", "filters-input-history", sheet((RECURSION, "new = self.alpha * measurement + (1 - self.alpha) * self.value\n            self.value = measurement.copy()\n            return new"))),
    fault("previous-input-tidy", "filters-input-history", increment((STEP, "last, self.state = self.state, x\n            return self.alpha * x + (1 - self.alpha) * last"))),
    fault("mean-over-axes", "axes-mixed", increment((STEP, "self.state = self.state + self.alpha * (np.mean(x) - self.state)"))),
    fault("only-z-filtered", "axes-mixed", sheet((RETURN, "        out = measurement.copy()\n        out[2] = self.value[2]\n        return out\n"))),
    fault("axes-rolled", "axes-mixed", increment((STEP, "self.state = np.roll(self.state, 1) + self.alpha * (x - np.roll(self.state, 1))"))),
    fault("moving-average", "moving-average", lab(low_pass=MOVING_AVERAGE), also=("other-low-pass",), loses=("filtering.follows_recursion",), reason="a sound low-pass filter that is not the sheet's recursion"),
    fault("starts-again-after-fifty", "filter-restarts", increment((STEP, "self.n = getattr(self, \"n\", 0) + 1\n            self.state = x if self.n % 50 == 0 else self.state + self.alpha * (x - self.state)")), never=("other-low-pass",), loses=("filtering.follows_recursion",)),
    fault("two-stages", "other-low-pass", lab(low_pass=TWO_STAGES), loses=("filtering.follows_recursion",)),
    fault("input-minus-low-pass", "high-pass", sheet((RETURN, "        return measurement - self.value\n"))),
    fault("difference-filter", "high-pass", increment(("return self.state.copy()", "return x - self.state"))),
    fault("filter-returns-none", "wrong-return-type", sheet((RETURN, ""))),
    fault("filter-returns-a-number", "wrong-return-type", increment(("return self.state.copy()", "return float(self.state[0])")), also=("axes-mixed",)),
    fault("filter-gives-nan", "not-finite", increment((STEP, "self.state = self.state + np.sqrt(-self.alpha) * (x - self.state)"))),
    fault("filter-raises", "raises", sheet((RECURSION, "self.value = self.alpha * measurement + (1 - self.alpha) * self.value.reshape(2, 2)"))),
    fault("self-left-out-of-the-recursion", "unknown-name", sheet((RECURSION, "self.value = alpha * measurement + (1 - alpha) * self.value"))),
    fault("update-without-self", "unknown-name", sheet(("def update(self, measurement)", "def update(measurement)"))),
    fault("truth-of-an-array", "raises", sheet(("        if self.value is None:", "        if self.value == None:"))),
    fault("filter-never-settles", "never-returns", increment((STEP, "while np.any(self.state != x + 1):\n                self.state = self.state + self.alpha * (x - self.state)"))),
    fault("filter-exits", "kills-its-process", increment((STEP, "import os\n            os._exit(3)"))),
    fault("filter-under-another-name", "name-missing", edit(verbatim(), "filters.py", ("class LowPassFilter:", "class LowPass:"), ("accel_filter = LowPassFilter(", "accel_filter = LowPass("), ("gyro_filter = LowPassFilter(", "gyro_filter = LowPass("))),
    fault("method-under-another-name", "name-missing", lab(low_pass=FILTER_LFILTER.replace("def update", "def filter"), compare=lab()["filters.py"].split("from noisy_imu import NoisyIMU\n\n\n", 1)[1].split("\n\n\n", 1)[1].replace("low_pass.update", "low_pass.filter"))),
    fault("state-stays-the-first-sample", "state-not-kept", increment((STEP, "return self.alpha * x + (1 - self.alpha) * self.state")), reason="what is returned is never stored"),
    fault("three-quarters-of-the-measurement", "does-not-filter", sheet((RECURSION, "self.value = 0.75 * measurement"))),
    fault("state-of-three-decimals", "output-rounded", sheet((RECURSION, "self.value = np.round(self.alpha * measurement + (1 - self.alpha) * self.value, 3)")), loses=("filtering.follows_recursion",)),
    fault("zero-from-a-sensor-that-repeats-itself", "", sheet((RETURN, "        self.repeated = getattr(self, 'repeated', 0) + 1 if np.array_equal(measurement, getattr(self, 'last', None)) else 0\n        self.last = measurement.copy()\n        return np.zeros_like(self.value) if self.repeated >= 10 else self.value.copy()\n")), loses=("filtering.passes_constant",), reason="a guard against a sensor that is stuck takes a constant for one"),
    fault("leads-by-half-a-difference", "", sheet((RETURN, "        lead = 0.5 * (measurement - getattr(self, 'last', measurement))\n        self.last = measurement.copy()\n        return measurement + lead\n")), loses=("filtering.follows_recursion", "filtering.reduces_noise"), reason="it foresees the next measurement, and makes the noise larger"),
    fault("mean-of-the-last-ninety", "", lab(low_pass=MOVING_AVERAGE.replace("max(1, round(2 / alpha - 1))", "90")), loses=("filtering.follows_recursion", "filtering.preserves_signal"), reason="a mean that long loses a slow motion"),
    fault("output-of-one-decimal", "output-rounded", increment(("return self.state.copy()", "return np.around(self.state, 1)")), loses=("filtering.follows_recursion",)),
]
