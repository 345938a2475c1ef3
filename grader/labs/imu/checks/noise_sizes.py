"""How large the noise of a sensor is, in the light of what other checks charge: a drift, a correlation, another law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.engine.traces import Traces
from grader.labs.imu.checks import noise_runs as runs
from grader.labs.imu.compare import Array
from grader.labs.imu.diagnosis import noise as diagnosis
from grader.labs.imu.diagnosis import noise_laws as laws
from grader.labs.imu.diagnosis.noise import Facts
from grader.labs.imu.student import Student

_ROUGHLY = 0.3
"""600 noise-free values tell their spread to 3 %; the rest is for the shape of the law that the biases are drawn from."""


def right_but_for_strays(facts: Facts) -> bool:
    strays = laws.strays(facts)
    return strays is not None and diagnosis.size_is_right(facts, strays.spread)


def in_words(facts: Facts) -> str:
    """The spread of all axes; of each, where only these are off."""
    if abs(facts.pooled_spread / facts.std - 1) > 0.05:
        return f"{facts.pooled_spread:.3g}"
    return " and ".join(
        f"{spread:.3g} on {axis}"
        for spread, axis in zip(np.sqrt(np.mean(facts.centred**2, axis=(0, 1))), "xyz", strict=True)
    )


def right_beside_drift(student: Student, truth: Traces, which: int, facts: Facts) -> bool:
    """The size of noise beside a drift that is as large, which default_bias charges: what a larger one adds."""
    twins = runs.from_one_seed(student, truth) if runs.which_drift(student, truth)[which] else None
    return twins is not None and abs(twins[which].noise_size() / facts.std - 1) < _ROUGHLY


def right_of_correlated(student: Student, truth: Traces, which: int, facts: Facts) -> bool:
    """The size of noise whose memory white_and_gaussian charges: it goes with the argument, or what is new in a read fits."""
    twins = runs.from_one_seed(student, truth)
    return (twins is not None and twins[which].scales()) or diagnosis.size_is_right(facts, laws.innovation(facts))


def is_right(facts: Facts) -> bool:
    """The size, in the light of a fault that another check charges: a law that is not normal, noise that adds up."""
    if diagnosis.accumulates(facts):
        return diagnosis.size_is_right(facts, float(np.sqrt(np.mean(facts.increments**2))))
    if diagnosis.one_signed(facts):  # |normal| has the root mean square that was asked for, an exponential law the mean
        beside = np.abs(facts.residual - facts.bias)
        return any(diagnosis.size_is_right(facts, float(s)) for s in (np.sqrt(np.mean(beside**2)), beside.mean()))
    if laws.clipped(facts):
        return True
    return diagnosis.size_is_right(facts) or diagnosis.half_width_is_std(facts)


def redrawn_bias_explains(sensors: list[Facts], silent: list[Facts]) -> bool:
    """Whether what is too much is a bias that is drawn anew on every read, which default_bias charges."""
    if not diagnosis.bias_is_redrawn(sensors, silent):
        return False
    whole = [float(np.hypot(f.std, s.pooled_spread)) for f, s in zip(sensors, silent, strict=True)]
    return all(abs(f.pooled_spread / w - 1) < _ROUGHLY for f, w in zip(sensors, whole, strict=True))


_SHEETS_BIASES, _TOO_MANY = (0.1, 0.01), 20.0
"""m/s², rad/s: the standard deviations that Step 5 draws biases with; so many times as much is no sensor's any more."""


def too_large_for_a_sensor(biases: Sequence[Array]) -> tuple[int, float, float] | None:
    """The first sensor whose default biases (instances, reads, 3) are, how large they are, and what the sheet draws."""
    sizes = [float(np.sqrt(np.mean(bias**2))) for bias in biases]
    both = enumerate(zip(sizes, _SHEETS_BIASES, strict=True))
    return next(((which, size, sheets) for which, (size, sheets) in both if size > _TOO_MANY * sheets), None)
