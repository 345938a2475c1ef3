"""The checks of Filtering, on made-up filters."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.engine.findings import Fault, Lost
from grader.ground.text import printable
from grader.labs.imu.checks import check_filtering as checks
from grader.labs.imu.checks import filter_runs
from grader.labs.imu.compare import vector
from tests.judging.made import Case, Made, is_as_marked, misfits, truth

RECURSION, FIRST, CONSTANT, NOISE, SIGNAL, OWN = (
    checks.check_follows_recursion,
    checks.check_starts_from_first_measurement,
    checks.check_passes_constant,
    checks.check_reduces_noise,
    checks.check_preserves_signal,
    checks.check_instances_independent,
)


class Sound:
    """The sheet's filter, in steps that a faulty one changes."""

    def __init__(self, alpha: float = 0.1, initial_value: Any = None) -> None:
        self.alpha = alpha
        self.value = None if initial_value is None else np.array(initial_value, float)
        self.begin()

    def begin(self) -> None:
        """Whatever else there is to remember."""

    def first(self, x: np.ndarray) -> np.ndarray:
        return x.copy()

    def next(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return self.alpha * x + (1 - self.alpha) * y

    def out(self, y: np.ndarray) -> Any:
        return y.copy()

    def update(self, measurement: np.ndarray) -> Any:
        self.value = self.first(measurement) if self.value is None else self.next(measurement, self.value)
        return self.out(self.value)


def of(**steps: Any) -> type:
    """A filter that differs from the sound one in these steps."""
    return type("Filter", (Sound,), steps)


def _default_alpha(self: Any, alpha: float = 0.3, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha, initial_value)


def _ignores_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha)


def _halves_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha, None if initial_value is None else initial_value / 2)


def _writes_into_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha, initial_value)
    if initial_value is not None:
        initial_value += 1


def _keeps_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha)
    self.value = initial_value


def _in_place(self: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    y[:] = Sound.next(self, x, y)
    return y


def _zero_for_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha, None if initial_value is None else np.zeros(3))


def _alpha_of_one_with_initial(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha if initial_value is None else 1.0, initial_value)


def _limits_alpha(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
    Sound.__init__(self, min(alpha, 0.3), initial_value)


class Averaging(Sound):
    """The mean of the last four."""

    size = 4

    def begin(self) -> None:
        self.last: deque[np.ndarray] = deque(maxlen=self.size)

    def update(self, measurement: np.ndarray) -> Any:
        self.last.append(measurement.copy())
        return np.mean(self.last, axis=0)


class SecondOrder(Sound):
    """Two of them, one behind the other: smooth, and another recursion."""

    def begin(self) -> None:
        self.second: Any = None

    def out(self, y: np.ndarray) -> Any:
        self.second = y if self.second is None else self.next(y, self.second)
        return np.array(self.second)


class Behind(Sound):
    """What belongs to the measurement before."""

    def update(self, measurement: np.ndarray) -> Any:
        before = measurement if self.value is None else self.value
        super().update(measurement)
        return np.array(before)


class Adding(Sound):
    """A filter that is no low-pass: it adds to what it has."""

    def next(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.9 * y + 0.5 * np.sin(x)


class Noisy(Sound):
    """As large as what comes in, and larger."""

    def begin(self) -> None:
        self.before: Any = None

    def out(self, y: np.ndarray) -> Any:
        return y.copy()

    def update(self, measurement: np.ndarray) -> Any:
        before = measurement if self.before is None else self.before
        self.before = measurement.copy()
        return measurement + 0.5 * (measurement - before) + 0.001 * np.sin(before)


class Shared(Sound):
    """A state of the class."""

    state: Any = None

    def update(self, measurement: np.ndarray) -> Any:
        cls = type(self)
        cls.state = measurement.copy() if cls.state is None else self.next(measurement, cls.state)
        return cls.state.copy()


class Gated(Sound):
    """What is far from the output is left out."""

    def next(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return super().next(x, y) if np.abs(x - y).max() < 1.0 else y


class WarmingUp(Sound):
    """The first ten measurements as they are."""

    def begin(self) -> None:
        self.updates = 0

    def next(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        self.updates += 1
        return x.copy() if self.updates < 10 else super().next(x, y)


class NothingAtFirst(Sound):
    """None from the first update."""

    def begin(self) -> None:
        self.updates = 0

    def update(self, measurement: np.ndarray) -> Any:
        self.updates += 1
        y = super().update(measurement)
        return y if self.updates > 1 else None


class HighPass(Sound):
    """What the filter takes away."""

    def update(self, measurement: np.ndarray) -> Any:
        return measurement - super().update(measurement)


class InPlace(Sound):
    """One array for all outputs."""

    def update(self, measurement: np.ndarray) -> Any:
        if self.value is None:
            self.value = measurement.copy()
        else:
            self.value *= 1 - self.alpha
            self.value += self.alpha * measurement
        return self.value


class Guarded(Sound):
    """Nothing, once the same measurement has come ten times."""

    def begin(self) -> None:
        self.last: Any = None
        self.repeated = 0

    def update(self, measurement: np.ndarray) -> Any:
        self.repeated = self.repeated + 1 if np.array_equal(measurement, self.last) else 0
        self.last = measurement.copy()
        y = super().update(measurement)
        return 0 * y if self.repeated >= 10 else y


class OneArray(Sound):
    """A state of its own, and one array that all outputs are written into."""

    def begin(self) -> None:
        self.last = np.zeros(3)

    def out(self, y: np.ndarray) -> Any:
        self.last[:] = y
        return self.last


class NoneOfAConstant(Guarded):
    """No numbers, once the same measurement has come ten times."""

    def out(self, y: np.ndarray) -> Any:
        return y.copy() if self.repeated < 10 else y * np.nan


class NothingOfAConstant(Guarded):
    """None, once the same measurement has come ten times."""

    def update(self, measurement: np.ndarray) -> Any:
        y = super().update(measurement)
        return None if self.repeated >= 10 else y


class NoneOfASlowMotion(Sound):
    """No numbers, once the measurement has changed by little ten times."""

    def begin(self) -> None:
        self.last: Any = None
        self.slow = 0

    def update(self, measurement: np.ndarray) -> Any:
        change = 1.0 if self.last is None else np.abs(measurement - self.last).max()
        self.slow = self.slow + 1 if 0 < change < 0.07 else 0
        self.last = measurement.copy()
        return super().update(measurement) * (np.nan if self.slow >= 10 else 1.0)


class Leaking(Sound):
    """A high-pass that lets a little of the rest through."""

    leak = 5e-4

    def update(self, measurement: np.ndarray) -> Any:
        return measurement - (1 - self.leak) * super().update(measurement)


class SecondOrderGuarded(Guarded, SecondOrder):
    """Two in a row; nothing, once the same measurement has come ten times."""

    def begin(self) -> None:
        Guarded.begin(self)
        SecondOrder.begin(self)


class SecondOrderSlow(SecondOrder):
    """Two in a row that take their time."""

    def begin(self) -> None:
        self.alpha /= 50
        super().begin()


class SecondOrderSmaller(SecondOrder):
    """Two in a row, of whose motion a part is lost."""

    def update(self, measurement: np.ndarray) -> Any:
        y = super().update(measurement)
        self.start = getattr(self, "start", y)
        return self.start + 0.75 * (y - self.start)


class SharedFromElsewhere(Shared):
    """A state of the class, which begins wrongly."""

    def update(self, measurement: np.ndarray) -> Any:
        first = type(self).state is None
        y = super().update(measurement)
        if first:
            type(self).state = y = y + 1
        return y


class SharedAndOut(Shared):
    """A state of the class, handed out."""

    def update(self, measurement: np.ndarray) -> Any:
        super().update(measurement)
        return type(self).state


class PairsAfterNothing(NothingAtFirst):
    """None from the first update, pairs from the next."""

    def update(self, measurement: np.ndarray) -> Any:
        y = super().update(measurement)
        return None if y is None else (y, self.alpha)


class NothingTwice(NothingAtFirst):
    """None from the first two updates."""

    def begin(self) -> None:
        self.updates = -1


class Random(Sound):
    """Other outputs every time."""

    def begin(self) -> None:
        self.rng = np.random.default_rng()

    def out(self, y: np.ndarray) -> Any:
        return y + self.rng.normal(0, 0.01, 3)


def _writes_into_input(self: Any, measurement: np.ndarray) -> Any:
    y = Sound.update(self, measurement)
    measurement[:] = y
    return y


def _raises(self: Any, measurement: np.ndarray) -> Any:
    raise RuntimeError("broken")


class StuckAfterTheFirst(Sound):
    """Zeros, then the same numbers, whatever goes in."""

    def out(self, y: np.ndarray) -> Any:
        first, self.told = not hasattr(self, "told"), True
        return np.zeros(3) if first else np.array([1.0, 2.0, 3.0])


class HighPassFromZero(Sound):
    """What a low-pass filter that starts from zero takes away."""

    def begin(self) -> None:
        self.low = np.zeros(3)

    def update(self, measurement: np.ndarray) -> Any:
        self.low = self.next(measurement, self.low)
        return measurement - self.low


WRONG_TYPE = (0.0, ["wrong-return-type"])
IN_INITIAL = of(__init__=_keeps_initial, next=_in_place)
THE_SAME = of(update=lambda _s, x: x.copy())
STILL = of(update=lambda _s, x: np.array([1.0, 2.0, 3.0]))
NAN = of(out=lambda _s, y: y * np.nan)
NUMBER = of(out=lambda _s, y: float(y[0]))
ROUNDED = of(out=lambda _s, y: y.round(2))
LIMITED = of(out=lambda _s, y: np.clip(y, -9.5, 9.5))
LIMITED_DEFAULT = of(__init__=_default_alpha, out=LIMITED.out)  # type: ignore[attr-defined]
LIMITED_FROM_ZERO = of(first=lambda s, x: s.alpha * x, out=LIMITED.out)  # type: ignore[attr-defined]
SWAPPED_LIMITED_FROM_ZERO = of(
    first=lambda s, x: (1 - s.alpha) * x,
    next=lambda s, x, y: (1 - s.alpha) * x + s.alpha * y,
    out=LIMITED.out,  # type: ignore[attr-defined]
)
NOW_AND_THEN = of(out=lambda _s, y: np.maximum(y, -11.5))
FROM_ZERO = of(first=lambda s, x: s.alpha * x)
LARGER = of(next=lambda s, x, y: s.alpha * x + (1.1 - s.alpha) * y)
HALF = of(next=lambda s, x, y: 0.5 * (s.alpha * x + (1 - s.alpha) * y), first=lambda _s, x: 0.5 * x)
ALPHA_SWAPPED = of(next=lambda s, x, y: (1 - s.alpha) * x + s.alpha * y)
GROWING = of(next=lambda s, x, y: s.alpha * x + 1.2 * y)
PAIRS = of(out=lambda _s, y: (y.copy(), 0.1))
LOUDER = of(next=lambda _s, x, y: 1.2 * x + 0.2 * y)
OF_ITSELF = of(next=lambda s, x, y: 1.2 * y)
WHOLE_STATE = of(next=lambda s, x, y: (s.alpha * x + (1 - s.alpha) * y).round())
OWN_FROM_ZERO = of(first=lambda _s, x: 0.25 * x, next=lambda _s, x, y: 0.25 * x + 0.75 * y)
FROZEN = of(next=lambda _s, _x, y: y)
FASTER = of(next=lambda s, x, y: s.alpha**0.5 * x + (1 - s.alpha**0.5) * y)


class AsksForTime(Sound):
    def update(self, measurement: np.ndarray, dt: float) -> Any:  # type: ignore[override]
        return super().update(measurement)


def _without_a_default(self: Any, alpha: float, initial_value: Any = None) -> None:
    Sound.__init__(self, alpha, initial_value)


def _without_a_default_limited(self: Any, alpha: float, initial_value: Any = None) -> None:
    _limits_alpha(self, alpha, initial_value)


def _other_names(self: Any, smoothing: float = 0.1, start: Any = None) -> None:
    Sound.__init__(self, smoothing, start)


FITTING = [
    *misfits(RECURSION, lambda: Made(LowPassFilter=type("Fresh", (Sound,), {})), "LowPassFilter", 0.5),
    Case("has to be given alpha", RECURSION, lambda: Made(LowPassFilter=of(__init__=_without_a_default)), (0.5, [])),
    Case("asks for the time", RECURSION, lambda: Made(LowPassFilter=AsksForTime), (0.5, ["other-parameters"])),
    Case("other names", RECURSION, lambda: Made(LowPassFilter=of(__init__=_other_names)), (0.5, ["other-parameters"])),
]
CASES = FITTING + [
    Case(name, check, lambda kind=kind: Made(LowPassFilter=type("Fresh", (kind,), {})), marked)  # type: ignore[misc]
    for check, rows in {
        RECURSION: [
            ("without outliers", Gated, (0.0, [])),
            ("ten as they are", WarmingUp, (0.0, [])),
            ("sound", Sound, None),
            ("another default", of(__init__=_default_alpha), (0.5, [])),
            ("rounded", ROUNDED, (0.0, ["output-rounded"])),
            ("limited", LIMITED, (0.0, [])),
            ("limited now and then", NOW_AND_THEN, (0.0, [])),
            ("alpha swapped", ALPHA_SWAPPED, (0.0, ["alpha-swapped"])),
            ("the root of alpha", FASTER, (0.0, [])),
            ("one behind", Behind, (0.0, [])),
            ("a moving average", Averaging, (0.0, ["moving-average"])),
            ("two in a row", SecondOrder, (0.0, ["other-low-pass"])),
            ("no low-pass at all", Adding, (0.0, [])),
            ("noisier than before", Noisy, (0.0, [])),
            ("the measurement itself", THE_SAME, (0.0, ["no-filtering"])),
            ("a gain of another size", LARGER, (0.0, ["gain-not-one"])),
            ("a high-pass", HighPass, (0.0, ["high-pass"])),
            ("from zero", FROM_ZERO, None),
            ("a number", NUMBER, (0.5, ["wrong-return-type"])),
            ("no numbers", NAN, (0.0, ["not-finite"])),
            ("raises", of(update=_raises), "raised"),
            ("nothing at first", NothingAtFirst, None),
            ("an alpha of its own", of(next=lambda _s, x, y: 0.25 * x + 0.75 * y), (0.0, ["alpha-ignored"])),
            ("stuck", STILL, (0.0, ["output-stuck"])),
            ("an output among others", PAIRS, (0.5, ["wrong-return-type"])),
            ("an output among others after nothing", PairsAfterNothing, None),
            ("nothing from the first two", NothingTwice, WRONG_TYPE),
            ("alpha limited", of(__init__=_limits_alpha), (0.0, [])),
            ("alpha limited, to be given", of(__init__=_without_a_default_limited), (0.0, [])),
            (
                "alpha to be given, and ignored",
                of(__init__=_without_a_default, next=lambda _s, x, y: 0.25 * x + 0.75 * y),
                (0.0, ["alpha-ignored"]),
            ),
            ("another default, from zero", of(__init__=_default_alpha, first=lambda _s, x: 0 * x), (0.5, [])),
            ("a state of whole numbers", WHOLE_STATE, (0.0, ["output-rounded"])),
            ("two in a row, nothing of a constant", SecondOrderGuarded, (0.0, [])),
            ("two in a row, too slow", SecondOrderSlow, (0.0, [])),
            ("two in a row, with less of the motion", SecondOrderSmaller, (0.0, ["other-low-pass"])),
            ("limited, with another default", LIMITED_DEFAULT, (0.0, ["other-low-pass"])),
            ("growing", GROWING, (0.0, ["gain-not-one"])),
            ("no numbers of a constant", NoneOfAConstant, None),
        ],
        FIRST: [
            ("sound", Sound, None),
            (
                "the initial value is ignored, with a weight below zero",
                of(__init__=_ignores_initial, next=lambda _s, x, y: 1.2 * x - 0.2 * y),
                (0.5, ["initial-value-ignored"]),
            ),
            ("from zero", FROM_ZERO, (0.0, ["zero-initial-state"])),
            ("zero", of(first=lambda _s, x: 0 * x), (0.0, ["zero-initial-state"])),
            ("from elsewhere", of(first=lambda _s, x: x + 1), (0.0, [])),
            ("nothing at first", NothingAtFirst, WRONG_TYPE),
            ("the initial value is ignored", of(__init__=_ignores_initial), (0.5, ["initial-value-ignored"])),
            ("half the initial value", of(__init__=_halves_initial), (0.5, [])),
            ("a gain of a half", HALF, (0.0, [])),
            ("limited", LIMITED, (0.5, [])),
            ("rounded", ROUNDED, (0.0, [])),
            ("a high-pass", HighPass, (0.0, [])),
            ("shared", Shared, (0.5, ["initial-value-ignored"])),
            ("shared, from elsewhere", SharedFromElsewhere, (0.0, [])),
            ("from zero, with an alpha of its own", OWN_FROM_ZERO, (0.0, ["zero-initial-state"])),
            (
                "from zero, alpha swapped",
                of(first=lambda s, x: (1 - s.alpha) * x, next=lambda s, x, y: (1 - s.alpha) * x + s.alpha * y),
                (0.0, ["zero-initial-state"]),
            ),
            ("limited, from zero", LIMITED_FROM_ZERO, (0.0, ["zero-initial-state"])),
            ("alpha swapped, limited, from zero", SWAPPED_LIMITED_FROM_ZERO, (0.0, ["zero-initial-state"])),
            ("one axis from elsewhere", of(first=lambda _s, x: x * [1, 1, 0.5]), (0.0, [])),
            (
                "zero in the place of the initial value",
                of(__init__=_zero_for_initial),
                (0.5, ["initial-value-ignored"]),
            ),
            ("no filter with an initial value", of(__init__=_alpha_of_one_with_initial), (0.5, [])),
            ("an average", Averaging, (0.5, [])),
            ("alpha swapped", ALPHA_SWAPPED, (0.5, [])),
            ("an output among others", PAIRS, None),
            ("nothing from the first two", NothingTwice, WRONG_TYPE),
            ("the measurement itself", THE_SAME, "skipped"),
            ("stuck", STILL, "skipped"),
            ("raises", of(update=_raises), "raised"),
        ],
        CONSTANT: [
            ("sound", Sound, None),
            ("off by a little", of(out=lambda _s, y: y + 0.0015), (0.0, [])),
            ("a high-pass from zero", HighPassFromZero, "skipped"),
            ("a gain of another size", LARGER, (0.0, ["gain-not-one"])),
            ("an average", Averaging, None),
            ("one that adds", Adding, (0.0, [])),
            ("guarded", Guarded, (0.0, [])),
            ("limited", LIMITED, None),
            ("rounded", ROUNDED, (0.0, [])),
            ("a high-pass", HighPass, "skipped"),
            ("from zero", FROM_ZERO, None),
            ("the measurement itself", THE_SAME, "skipped"),
            ("no numbers of it", NoneOfAConstant, (0.0, ["not-finite"])),
            ("nothing of it", NothingOfAConstant, WRONG_TYPE),
            ("next to nothing", Leaking, "skipped"),
            ("a hundredth", type("Leaky", (Leaking,), {"leak": 0.01}), (0.0, [])),
            ("growing", GROWING, (0.0, ["gain-not-one"])),
            ("growing by itself", OF_ITSELF, "skipped"),
            ("one axis out", of(out=lambda _s, y: y * [1, 1.01, 1]), (0.0, [])),
            ("a state of whole numbers", WHOLE_STATE, (0.0, [])),
        ],
        NOISE: [
            ("sound", Sound, None),
            ("stuck after the first", StuckAfterTheFirst, "skipped"),
            ("an average", Averaging, None),
            ("noisier than before", Noisy, (0.0, [])),
            ("a high-pass", HighPass, None),
            ("the measurement itself", THE_SAME, "skipped"),
            ("alpha swapped", ALPHA_SWAPPED, None),
            ("rounded", ROUNDED, None),
            ("louder", LOUDER, (0.0, ["gain-not-one"])),
            ("growing", GROWING, (0.0, ["gain-not-one"])),
            ("growing by itself", OF_ITSELF, "skipped"),
            ("a state of whole numbers", WHOLE_STATE, None),
        ],
        SIGNAL: [
            ("sound", Sound, None),
            ("a high-pass", HighPass, "skipped"),
            ("one that adds", Adding, (0.0, [])),
            ("a long average", type("Long", (Averaging,), {"size": 150}), (0.0, [])),
            ("noisier than before", Noisy, None),
            ("the measurement itself", THE_SAME, "skipped"),
            ("a gain of another size", LARGER, (0.0, ["gain-not-one"])),
            ("no numbers of it", NoneOfASlowMotion, (0.0, ["not-finite"])),
            ("a state of whole numbers", WHOLE_STATE, (0.0, [])),
            ("two in a row, too slow", SecondOrderSlow, (0.0, [])),
            ("growing by itself", OF_ITSELF, "skipped"),
        ],
        OWN: [
            ("sound", Sound, None),
            ("shared", Shared, (0.0, ["shared-state"])),
            ("random", Random, (0.0, [])),
            ("hands its state out", of(out=lambda _s, y: y), (0.5, ["aliased-output"])),
            ("keeps what comes in", of(first=lambda _s, x: x), (0.5, ["aliased-input"])),
            ("writes into what comes in", of(update=_writes_into_input), (0.5, ["mutates-input"])),
            ("one array for all", InPlace, (0.5, ["aliased-output"])),
            ("the measurement itself", THE_SAME, None),
            ("stuck", STILL, "skipped"),
            ("an average", Averaging, None),
            ("one array for what comes out", OneArray, (0.5, ["aliased-output"])),
            ("writes into the initial value later", IN_INITIAL, (0.5, ["mutates-input"])),
            ("writes into the initial value", of(__init__=_writes_into_initial), (0.5, ["mutates-input"])),
            ("stuck at the first", FROZEN, None),
            ("shared, and handed out", SharedAndOut, (0.0, ["shared-state", "aliased-output"])),
        ],
    }.items()
    for name, kind, marked in rows
]


@pytest.mark.quick
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_a_made_up_filter_is_marked_fairly(case: Case) -> None:
    is_as_marked(case)


@pytest.mark.quick
def test_the_charts_of_a_report_find_the_runs() -> None:
    student = Made(LowPassFilter=Sound)
    OWN(student, truth())
    assert [len(run.output) for run in student.answered("filter")[:4]] == [400, 400, 400, 100]


@pytest.mark.quick
def test_why_there_is_no_filter_without_alpha_is_told_with_its_place_and_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    for file, begins in (("filters.py", "TypeError at filters.py, line 7: "), (None, "TypeError: ")):
        fault = Fault("TypeError", "x" * 190 + "\x1b[0m" + "y" * 100, file, 7, None)
        monkeypatch.setattr(checks, "asked", lambda *_, fault=fault: SimpleNamespace(needs_alpha=fault))
        with pytest.raises(Lost) as lost:
            checks._needs_no_alpha(Made(), truth())
        assert lost.value.got == begins + printable(fault.message, 200)
        assert lost.value.where == fault.at


@pytest.mark.quick
def test_the_measurement_that_met_the_initial_value_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    student = Made(LowPassFilter=of(__init__=_halves_initial))
    cases = filter_runs.asked(student, truth())
    signal = np.arange(180.0).reshape(60, 3)
    run = cases.from_initial[1]
    assert run.output is not None
    output = np.vstack([run.output[:1], run.output[1:] + 1e6])
    changed = replace(cases, from_initial=(signal, replace(run, output=output)))
    monkeypatch.setattr(checks, "asked", lambda *_: changed)
    with pytest.raises(Lost) as lost:
        checks._follows_initial_value(student, truth())
    assert f"from the measurement {vector(signal[0])} after" in lost.value.expected
    wanted = cases.initial_alpha * signal[0] + (1 - cases.initial_alpha) * cases.initial
    assert str(lost.value.off) == str(checks._off(output[0], wanted))
