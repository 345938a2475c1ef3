"""Parts that do nothing useful, with numbers that their author chooses: none earns more than its form."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import mujoco
import numpy as np
import pytest

from grader.labs.imu.filtering import checks as filtering
from tests.judging import test_check_data_collection as collecting
from tests.judging import test_check_noise_model as noise
from tests.judging import test_check_sensor_access as reading
from tests.judging.fake_students import Check, FakeStudent, kept

pytestmark = pytest.mark.quick
FORM, FORM_OF_RECORDING = 4.0, 6.0
"""Points for the form of a part, as in the corpus: what its checks leave to work without any content."""
NEVER_WRITTEN = np.full(3, np.nan)
"""What the sandbox has in an array of `np.empty` before anything is written to it."""

Counted = Callable[[int, float], Any]
"""What is added at the n-th call, from n and the standard deviation that was asked for."""
COUNTED: Mapping[str, Counted] = {
    "nothing": lambda n, std: 0.0,
    "a constant": lambda n, std: 0.1,
    "the standard deviation": lambda n, std: std,
    "one at every second read": lambda n, std: -(n % 2),
    "ten at every second read": lambda n, std: 10.0 * (n % 2),
    "the standard deviation with alternating sign": lambda n, std: std * (-1) ** n,
    "three values in turn": lambda n, std: std * 1.2247 * (n % 3 - 1),
    "the number of the read": lambda n, std: float(n),
    "a little more at each read": lambda n, std: 1e-6 * n,
    "a sine": lambda n, std: std * 2**0.5 * np.sin(n),
    "a sine for each axis": lambda n, std: std * 2**0.5 * np.sin(n * np.array([0.3, 0.7, 1.1])),
    "ten at the 700th read": lambda n, std: 10.0 * (n == 700),
    "ten at every 500th read": lambda n, std: 10.0 * (n % 500 == 0),
    "the right size at every 500th read": lambda n, std: std * 500**0.5 * (n % 500 == 0),
    "one axis in turn": lambda n, std: np.eye(3)[n % 3],
}


# --- noise models ----------------------------------------------------------------------------------------------------------


class Counting(noise.Sound):
    """A noisy IMU without any random draw and without a bias: the clean reading and a function of the number of the read."""

    beside: Counted = COUNTED["nothing"]

    def begin(self) -> None:
        self.count = [0, 0]

    def bias(self, which: int, size: float, given: Any) -> Any:
        return np.zeros(3)

    def number(self, which: int) -> int:
        self.count[which] += 1
        return self.count[which]

    def one(self, which: int) -> Any:
        return self.clean(which) + type(self).beside(self.number(which), self.stds[which])


class CountingAll(Counting):
    """The same, with one counter for all instances."""

    total = 0

    def number(self, which: int) -> int:
        CountingAll.total += 1
        return CountingAll.total // 2


class Rounding(Counting):
    """Clean readings that are rounded to a step."""

    step = 1.0

    def one(self, which: int) -> Any:
        return (self.clean(which) / self.step).round() * self.step


class RoundingNoise(Rounding):
    """The right noise without a bias, rounded to a step that hides both."""

    def one(self, which: int) -> Any:
        return ((self.clean(which) + self.noise(which)) / self.step).round() * self.step


def _noise_models() -> Iterator[tuple[str, type]]:
    for name, beside in COUNTED.items():
        for kind, by in ((Counting, "instance"), (CountingAll, "class")):
            yield f"{name}, by {by}", type("Useless", (kind,), {"beside": staticmethod(beside)})
    for step in (1e-3, 0.01, 0.1, 1.0, 20.0):
        yield f"rounded to {step:g}", type("Useless", (Rounding,), {"step": step})
    for step in (2.0, 20.0):
        yield f"noise rounded to {step:g}", type("Useless", (RoundingNoise,), {"step": step})
    yield (
        "a multiple of the standard deviation for each axis",
        type("Useless", (Counting,), {"one": _of_three_multiples}),
    )
    yield "never written", noise.of(one=lambda *_: NEVER_WRITTEN)


def _of_three_multiples(self: Counting, which: int) -> Any:
    return self.clean(which) + self.stds[which] * np.array([1.0, -1.0, 0.5])


# --- readers ---------------------------------------------------------------------------------------------------------------


def _counting_reader(beside: Counted, about: Any = 0.0) -> reading.Reader:
    count = itertools.count()
    return lambda *_: (about + np.zeros(3) + beside(next(count), 0.1), np.zeros(3))


COMPARED: Mapping[str, Callable[[Any], Any]] = {
    "signs": np.sign,
    "comparisons with zero": lambda x: x > 0,
    "comparisons with zero as numbers": lambda x: (x > 0).astype(float),
    "the largest axis": lambda x: (x == x.max()).astype(float),
    "the order of the axes": lambda x: np.argsort(x).astype(float),
    "tens": lambda x: x.round(-1),
    "nothing of it": lambda x: 0 * x,
    "an imaginary part beside it": lambda x: x + 1j,
    "a mask over it": lambda x: np.ma.masked_all(3),
    "texts": lambda x: [str(value) for value in x],
}


def _readers() -> Iterator[tuple[str, Callable[[], reading.Reader]]]:
    for name, beside in COUNTED.items():
        yield f"zero and {name}", partial(_counting_reader, beside)
        yield f"gravity and {name}", partial(_counting_reader, beside, np.array([0.0, 0.0, -9.81]))
    for name, change in COMPARED.items():
        yield name, partial(reading.altered, change, change)
    yield "the time", lambda: lambda _m, data, *_: (np.full(3, data.time), np.full(3, data.time))
    yield "never written", lambda: lambda *_: (NEVER_WRITTEN, NEVER_WRITTEN)


# --- recorders -------------------------------------------------------------------------------------------------------------


def _few(rows: int, *, steps: int | None = None, repeats: int = 1) -> Callable[[], Any]:
    """A recorder of the first rows alone, each so many times; it makes one step a row, or so many before the first."""

    def recorded(self: Any, model: Any, data: Any, duration: float, *ids: int) -> Iterator[Any]:
        for _ in range((steps or 1) - 1):
            mujoco.mj_step(model, data)
        for _ in range(rows):
            self.step(model, data, 0)
            yield from [self.row(model, data, *ids)] * (repeats if repeats > 0 else self.steps(model, duration))

    return collecting.of(rows=recorded)


def _recorders() -> Iterator[tuple[str, Callable[[], Any]]]:
    yield "one step, one row", _few(1)
    yield "two steps, two rows", _few(2)
    yield "nineteen rows", _few(19)
    yield "all steps, one row", _few(1, steps=1500)
    yield "one step, its row for all", _few(1, repeats=0)
    yield "two steps, each row many times", _few(2, repeats=700)
    yield "no row", collecting.of(rows=lambda *_: iter(()))
    for name, change in COMPARED.items():
        yield name, collecting.telling(lambda t, a, g, _m, change=change: (t, *(_of_rows(change, x) for x in (a, g))))
    yield "never written", collecting.telling(lambda t, a, g, _m: (t, np.full_like(a, np.nan), np.full_like(g, np.nan)))


def _of_rows(change: Callable[[Any], Any], rows: np.ndarray) -> Any:
    changed = [change(row) for row in rows]
    return np.ma.array(changed) if isinstance(changed[0], np.ma.MaskedArray) else np.array(changed)


# --- filters ---------------------------------------------------------------------------------------------------------------


def _filter(update: Callable[[Any, Any], Any]) -> type:
    def begin(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
        self.alpha, self.n = alpha, 0

    def counted(self: Any, measurement: Any) -> Any:
        self.n += 1
        return update(self, measurement)

    return type("LowPassFilter", (), {"__init__": begin, "update": counted})


def recursive(
    step: Callable[[Any, Any], Any] = lambda s, m: s.alpha * m + (1 - s.alpha) * s.y,
    out: Callable[[Any], Any] = np.array,
) -> type:
    """A filter that starts from the first measurement; `step` makes each output, which is `y` in the next call, from the last one."""

    def update(self: Any, measurement: Any) -> Any:
        self.y = np.array(measurement) if self.n == 1 and self.y is None else step(self, measurement)
        return out(self.y)

    def begin(self: Any, alpha: float = 0.1, initial_value: Any = None) -> None:
        self.alpha, self.n, self.y = alpha, 0, initial_value

    return type("LowPassFilter", (_filter(update),), {"__init__": begin})


def _weighing(weight: Callable[[float], float]) -> type:
    return recursive(lambda s, m: weight(s.alpha) * m + (1 - weight(s.alpha)) * s.y)


def _first_mean(self: Any, measurement: Any) -> Any:
    return self.y if self.n > 30 else self.y + (measurement - self.y) / self.n


def _almost_filters() -> Iterator[tuple[str, type]]:
    """Filters that remember a trace of earlier measurements, or that follow a trace of later ones."""
    yield "a thousandth of the last output", _weighing(lambda _: 0.999)
    yield "a fiftieth of the last output", _weighing(lambda _: 0.98)
    yield "a thousandth of alpha's own", _weighing(lambda alpha: 1 - alpha / 1000)
    yield "a sine of the last output", recursive(lambda s, m: m + 1e-3 * np.sin(s.y))
    yield "half, and a thousandth of the last output", recursive(lambda s, m: 0.5 * m + 1e-3 * s.y)
    yield "a thousandth of the measurement", _weighing(lambda _: 1e-3)
    yield "a thousandth of alpha", _weighing(lambda alpha: alpha / 1000)
    yield "a thousandth of the measurement, and half", recursive(lambda s, m: 1e-3 * m + 0.5 * s.y)
    yield "the first seven alone", recursive(lambda s, m: s.y if s.n > 7 else s.alpha * m + (1 - s.alpha) * s.y)
    yield "the mean of the first thirty", recursive(_first_mean)


def _filters() -> Iterator[tuple[str, type]]:
    yield from _almost_filters()
    for name, beside in COUNTED.items():
        yield f"the measurement and {name}", _filter(lambda s, m, beside=beside: m + beside(s.n, 0.1))
        yield f"{name} alone", _filter(lambda s, m, beside=beside: np.zeros(3) + beside(s.n, 0.1))
    for name, change in COMPARED.items():
        yield name, _filter(lambda s, m, change=change: change(m))
    for step in (0.01, 1.0):
        yield f"rounded to {step}", _filter(lambda s, m, step=step: (m / step).round() * step)
    yield "half", _filter(lambda s, m: m / 2)
    yield "alpha times the measurement", _filter(lambda s, m: s.alpha * m)
    yield "never written", _filter(lambda s, m: NEVER_WRITTEN)


FILTER_CHECKS = [check for name, check in vars(filtering).items() if name.startswith("check_")]
PARTS: Mapping[str, tuple[Sequence[Check], float, Callable[[], Iterator[tuple[str, Any]]]]] = {
    "NoisyIMU": (noise.CHECKS, FORM, _noise_models),
    "get_imu_readings": (reading.CHECKS, FORM, _readers),
    "simulate_and_collect": (collecting.CHECKS, FORM_OF_RECORDING, _recorders),
    "LowPassFilter": (FILTER_CHECKS, FORM, _filters),
}
USELESS = [(part, name, made) for part, (_, _, all_of) in PARTS.items() for name, made in all_of()]


class Restarting(FakeStudent):
    """A student of one part, which is made anew in a new process, so that its counter begins again."""

    def __init__(self, part: str, made: Any) -> None:
        super().__init__()
        self.part, self.made = part, made
        self.end_session()

    def end_session(self) -> None:
        self.parts[self.part] = self.made if self.part in _CLASSES else self.made()


_CLASSES = ("NoisyIMU", "LowPassFilter")


def earned(part: str, made: Any) -> dict[str, float]:
    """The points of a useless part, by check."""
    return kept(Restarting(part, made), PARTS[part][0])


_EVERY = 12
"""One of so many useless parts runs on each change, all of them each week."""


@pytest.mark.parametrize(
    ("part", "made"),
    [
        pytest.param(part, made, id=f"{part}: {name}", marks=[pytest.mark.weekly] if n % _EVERY else [])
        for n, (part, name, made) in enumerate(USELESS)
    ],
)
def test_a_useless_part_earns_its_form_at_most(part: str, made: Any) -> None:
    points = earned(part, made)
    assert sum(points.values()) <= PARTS[part][1], points


def test_loud_noise_without_a_bias_earns_no_more_than_the_right_noise_without_one() -> None:
    loud, right = (
        noise.kept(noise.of(bias=lambda *_: np.zeros(3), noise=lambda s, i, by=by: by * noise.Sound.noise(s, i)))
        for by in (10, 1)
    )
    assert sum(loud.values()) == sum(right.values()) - 6.0, loud


if __name__ == "__main__":  # the best-paid useless parts
    paid = sorted(((sum(earned(part, made).values()), part, name) for part, name, made in USELESS), reverse=True)
    print(f"{len(paid)} useless parts", *[f"{points:g}  {part}: {name}" for points, part, name in paid[:20]], sep="\n")
