"""Checks of `NoisyIMU`: each returns how one measured property deviates from what the sheet asks, None if it is right."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from grader.engine.findings import Came, Deviation, Size
from grader.labs.imu import statistics as st
from grader.labs.imu.collection import SENSOR_UNITS
from grader.labs.imu.compare import BOTH, SENSOR_NAMES, changes_in_words, distinct_texts, vector
from grader.labs.imu.noise_model import explain
from grader.labs.imu.noise_model.explain import JUDGE
from grader.labs.imu.noise_model.measure import Facts
from grader.labs.imu.noise_model.reads import TRUTH_ATOL, Reads

_UNLIKE = 1.2
"""Ratio of the spreads of two axes, of 2,500 reads each, that have one size by a chance of `statistics.ALPHA` only."""
CHANNELS = [f"{name} {axis}" for name in SENSOR_NAMES for axis in "xyz"]


class Bias(TypedDict):
    """Values, all text, for the message on a wrong default bias: the sensor, its unit, and `came`, the bias that was measured."""

    sensor: str
    unit: str
    came: str


class Spread(Bias):
    """Values for the message on noise of a wrong size: the sensor, its unit, and `came`, the size that was measured, in words.

    `std` is the size asked for, `reads` the number of reads that were judged, `grain` the step of rounding, 0 without.
    """

    std: float
    reads: int
    grain: float


class GivenBias(Bias):
    """Values, all text but `grain`, for the message on reads whose bias is not the given one: the sensor, its unit, and vectors.

    `wanted` is the given bias, `came` the mean error of the reads in whichever of the two robot states it is furthest from that.
    Both of the first state, for comparison: `beside`, the mean error minus the given bias, and `silent`, the mean error when no
    noise and a bias of zero are asked for. `grain` is the rounding step, 0 without.
    """

    wanted: str
    beside: str
    silent: str
    grain: float


class Law(TypedDict):
    """Values for the message on noise that is not white and normal; the message of each fault uses some of them.

    `beside` is the mean error minus the given bias, as text. `grain` is the step of rounding, `memory` the correlation with earlier
    reads, `most` the largest error in standard deviations, `ratio` Geary's ratio, a test of normality.
    """

    sensor: str
    unit: str
    beside: str
    grain: float
    memory: float
    most: float
    ratio: float


Together = TypedDict("Together", {"one": str, "other": str, "came": float, "reads": int})


@JUDGE.check("noise_model.noise_size", lab_step=5)
def check_noise_size(facts: Facts) -> Deviation[Spread] | None:
    """The noise of each sensor has the requested standard deviation"""
    wrong = [*BOTH] if not facts.follows else explain.sizes_off(facts)
    if not wrong:
        return None
    sensor, unit = facts.sensors[wrong[0]], SENSOR_UNITS[wrong[0]]
    reads = sensor.noise
    came = f"{sensor.twins.noise_size():.3g} {unit}" if sensor.drifts else _spread(reads, unit)
    numbers: Spread = {
        "sensor": SENSOR_NAMES[wrong[0]], "unit": unit, "came": came,
        "std": reads.std, "reads": reads.residual[..., 0].size, "grain": explain.grain(facts),
    }  # fmt: skip
    return Deviation(numbers, affected=len(wrong) / len(BOTH))  # the noise of the other sensor is right


@JUDGE.check("noise_model.given_bias", lab_step=5)
def check_given_bias(facts: Facts) -> Deviation[GivenBias] | None:
    """A given bias is added to every reading, also if it is zero"""
    both = [*BOTH] if facts.exchanged or facts.one_twice else []
    missing = both or explain.missing_bias(facts)
    if not (wrong := missing or explain.bias_beside(facts)):
        return None
    reads, silent = facts.sensors[wrong[0]].reads, facts.sensors[wrong[0]].silent
    gap = np.abs(reads.offset - reads.bias)
    expected, came = distinct_texts(reads.bias, reads.offset[int(np.argmax(gap.max(axis=1)))])
    numbers: GivenBias = {
        "sensor": SENSOR_NAMES[wrong[0]], "unit": SENSOR_UNITS[wrong[0]], "wanted": expected, "came": came,
        "silent": vector(silent.offset[0]), "beside": vector(reads.offset[0] - reads.bias), "grain": explain.grain(facts),
    }  # fmt: skip
    size = Size("the mean of the reads is off", float(gap.max()), SENSOR_UNITS[wrong[0]])
    affected = len(missing) / 2 if missing else 0.5 if all(s.reads.bias_is_right for s in facts.sensors) else 1.0
    return Deviation(numbers, size=size, affected=affected)


@JUDGE.check("noise_model.default_bias", lab_step=5)
def check_default_bias(facts: Facts) -> Deviation[Bias] | None:
    """Without a given bias, each instance draws a bias for every axis and keeps it"""
    wrong = next((which for off in explain.DEFAULTS if (which := off(facts))), None)
    if wrong is None:
        return None
    came = vector(facts.sensors[wrong[0]].means[1])
    return Deviation({"sensor": SENSOR_NAMES[wrong[0]], "unit": SENSOR_UNITS[wrong[0]], "came": came}, 0.5)


@JUDGE.check("noise_model.white_and_gaussian", lab_step=5)
def check_white_and_gaussian(facts: Facts) -> Deviation[Law] | None:
    """The noise is Gaussian with zero mean, and no read depends on the one before"""
    if not (wrong := explain.odd_laws(facts)):
        return None
    noise, raw = facts.sensors[wrong[0]].noise, facts.sensors[wrong[0]].reads
    beside = raw.offset[-1] - raw.bias
    numbers: Law = {
        "sensor": SENSOR_NAMES[wrong[0]],
        "unit": SENSOR_UNITS[wrong[0]],
        "beside": vector(np.where(np.abs(beside) > TRUTH_ATOL, beside, 0.0)),
        "grain": explain.grain(facts),
        "memory": max(sensor.noise.memory for sensor in facts.sensors),
        "most": float(np.abs(noise.centred).max()) / noise.std,
        "ratio": noise.geary,
    }
    return Deviation(numbers)


@JUDGE.check("noise_model.axes_and_sensors_independent", lab_step=5)
def check_axes_and_sensors_independent(facts: Facts) -> Deviation[Together] | None:
    """The noise of each axis of each sensor is independent of the others"""
    if facts.noiseless:
        return Deviation({"one": SENSOR_NAMES[0], "other": SENSOR_NAMES[1], "came": 1.0, "reads": 0})
    values = explain.columns(facts)
    worst, i, j = explain.most_correlated(values)
    if worst <= st.correlation_bound(len(values)):
        return None
    size = Size("two of the six channels have noise that goes together")
    return Deviation({"one": CHANNELS[i], "other": CHANNELS[j], "came": worst, "reads": len(values)}, size=size)


@JUDGE.check("noise_model.leaves_simulation_alone", lab_step=5)
def check_leaves_simulation_alone(facts: Facts) -> Deviation[Came] | None:
    """A noisy read changes nothing in the simulator's own data"""
    told = changes_in_words(facts.disturbance)
    return Deviation({"came": told}) if told else None


def _spread(reads: Reads, unit: str) -> str:
    """Return the standard deviation of the noise in words: one number for all axes, one for each if they differ."""
    axes = np.sqrt(np.mean(reads.centred**2, axis=(0, 1)))
    if reads.still:
        return "the same number at every read"
    if axes.max() < _UNLIKE * axes.min():
        return f"{reads.pooled_spread:.3g} {unit}"
    changes = " and ".join(f"{spread:.3g} on {axis}" for spread, axis in zip(axes, "xyz", strict=True))
    return f"{changes} ({unit})"
