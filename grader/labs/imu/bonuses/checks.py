"""Checks of the extensions: each returns how one measured property deviates from what is asked, None if it is right."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from grader.engine.findings import Came, Deviation, Form, Size
from grader.labs.imu.bonuses import allan_variance, live_plot
from grader.labs.imu.bonuses.allan_variance import ALLAN, KINDS, Allan
from grader.labs.imu.bonuses.complementary_filter import TILT, Tilt, wrapped
from grader.labs.imu.bonuses.live_plot import LIVE, SPAN, UPDATES, Live
from grader.labs.imu.bonuses.multiple_imus import IMUS, Imus
from grader.labs.imu.compare import Array, thinned, vector
from grader.labs.imu.statistics import allan_deviation

Wanted = TypedDict("Wanted", {"wanted": str, "came": str})
Beaten = TypedDict("Beaten", {"limit": float, "error": float})
Times = TypedDict("Times", {"count": int, "low": float, "high": float, "longest": float})
Ratio = TypedDict("Ratio", {"ratio": float, "tau": float})
Slope = TypedDict("Slope", {"nominal": float, "kind": str, "came": float})
Places = TypedDict("Places", {"where": str, "places": str, "form": str, "came": str})
AtPlace = TypedDict("AtPlace", {"wanted": str, "place": str, "came": str})
Changed = TypedDict("Changed", {"changed": int, "read": int})
Simulated = TypedDict("Simulated", {"wanted": float, "came": float})
Updates = TypedDict("Updates", {"least": int, "wanted": float, "came": int})
Curves = TypedDict("Curves", {"right": int, "judged": int})

# ---- the complementary filter ----

_ANGLES = "two numbers from update(), roll and pitch"
_LEVEL_ATOL = 0.01
"""rad. A filter that starts at zero or at the accelerometer's tilt is level from the first sample on, to rounding."""
_SETTLED_ATOL = 0.03
"""rad, after 30 s. The sheet's alpha 0.98 forgets a wrong start in 1 s, a slow Mahony filter (gain 0.5) in 2 s."""
_BETTER_THAN_GYRO, _BETTER_THAN_ACCEL = 3.0, 1.4
"""Factor by which the error must be smaller: exp(mean - 6.7 deviations) of log(factor) over hidden motions, for the weakest
setting that is still sound. Six deviations are 1e-9; the rest allows for a deviation that 20 motions tell to 12 %. Weakest are,
with mean factor and deviation of its logarithm: alpha 0.995 where the gyroscope drifts, 7.8 and 0.034 (limit 6.2); alpha 0.9 where
the accelerometer is shaken, 2.56 and 0.089 (limit 1.41); Madgwick's filter with 0.04 where it is steep, 2.88 and 0.107 (limit
1.41). Alpha 0.98, Mahony with gains 0.5 to 2 and Madgwick with 0.1 lie higher in all. Weights the wrong way round give 1.00, a
time step twice too long 0.7 where it is steep."""


@TILT.check("complementary_filter.returns_roll_and_pitch")
def check_returns_roll_and_pitch(facts: Tilt) -> Deviation[Form] | None:
    """update() returns roll and pitch, both 0 where the sensor is level and at rest"""
    if not facts.has_angles:
        return Deviation({"form": _ANGLES, "came": facts.odd or "NaN or infinity"})
    worst = np.abs(wrapped(facts.level)).max()
    numbers: Form = {"form": _ANGLES, "came": vector(facts.level[-1])}
    return None if worst <= _LEVEL_ATOL else Deviation(numbers, size=_size(worst))


@TILT.check("complementary_filter.settles_at_tilt")
def check_settles_at_tilt(facts: Tilt) -> Deviation[Wanted] | None:
    """Held still at a tilt, the filter settles at the true roll and pitch, wherever it started"""
    errors = np.abs(wrapped(facts.settled - facts.tilts)).max(axis=1)
    worst = int(np.argmax(errors))
    share = 0.5 if errors[0] <= _SETTLED_ATOL else 1.0
    numbers: Wanted = {"wanted": vector(facts.tilts[worst]), "came": vector(facts.settled[worst])}
    return None if errors[worst] <= _SETTLED_ATOL else Deviation(numbers, share, _size(errors[worst]))


@TILT.check("complementary_filter.beats_gyroscope_alone")
def check_beats_gyroscope_alone(facts: Tilt) -> Deviation[Beaten] | None:
    """Where the gyroscope has a bias, the filter does not drift away with it"""
    return _beats(facts, "beats_gyroscope_alone", "gyro_alone_rms", _BETTER_THAN_GYRO)


@TILT.check("complementary_filter.beats_accelerometer_alone")
def check_beats_accelerometer_alone(facts: Tilt) -> Deviation[Beaten] | None:
    """Where the sensor is shaken, the filter does not take the shaking for a tilt"""
    if facts.response is not None and facts.response.ignores_gyroscope:
        return Deviation({"limit": 0.0, "error": facts.errors["beats_accelerometer_alone"]})
    return _beats(facts, "beats_accelerometer_alone", "accel_alone_rms", _BETTER_THAN_ACCEL)


@TILT.check("complementary_filter.holds_when_steep")
def check_holds_when_steep(facts: Tilt) -> Deviation[Beaten] | None:
    """The filter beats both sensors alone in large and fast pitching, at another time step"""
    beaten = (_beats(facts, "holds_when_steep", f"{each}_alone_rms", _BETTER_THAN_ACCEL) for each in ("accel", "gyro"))
    return next(filter(None, beaten), None)


def _beats(facts: Tilt, check: str, single: str, factor: float) -> Deviation[Beaten] | None:
    error, alone = facts.errors[check], facts.alone[check][single]
    if error * factor <= alone:
        return None
    share = 0.5 if error * np.sqrt(factor) <= alone else 1.0
    return Deviation({"limit": alone / factor, "error": error}, share, Size("the angles are off", error, "rad"))


def _size(error: float) -> Size:
    return Size("an angle is off", float(error), "rad")


# ---- the Allan deviation ----

_NOMINAL = dict(zip(KINDS, (-0.5, 0.5, -1.0, 1.0), strict=True))
_WORDS = dict(zip(KINDS, ("white noise", "a random walk", "quantisation", "a steady drift"), strict=True))
_SLOPE_ATOL = 0.15
"""Between the slope of a sound estimate and that of the overlapping one on the same record, measured in `tests/test_extensions.py`.
Neighbouring kinds differ by 0.5."""


@ALLAN.check("allan_variance.returns_times_and_deviations")
def check_returns_times_and_deviations(facts: Allan) -> Deviation[Form] | None:
    """allan_deviation returns averaging times and as many deviations"""
    form = "two arrays of one length, (taus_s, adev)"
    if facts.odd is None:
        return Deviation({"form": form, "came": facts.white.shape})
    return Deviation({"form": form, "came": f"{facts.odd} with NaN or infinity"}, share=0.5) if facts.odd else None


@ALLAN.check("allan_variance.averaging_times")
def check_averaging_times(facts: Allan) -> Deviation[Times] | None:
    """The averaging times are in seconds, from about a sample to a good part of the record"""
    taus, _, samples = facts.records["white"]
    low, high, count = taus.min() * facts.rate, taus.max() * facts.rate, len(np.unique(taus))
    numbers: Times = {"count": count, "low": taus.min(), "high": taus.max(), "longest": len(samples) / 2 / facts.rate}
    if facts.is_deviation and not facts.meaning.seconds:
        return Deviation(numbers)
    fits = low >= 0.5 and high <= len(samples) / 2 * 1.01 + 1 and count >= 5 and high >= 10 * low
    return None if fits else Deviation(numbers, share=0.5)


@ALLAN.check("allan_variance.matches_definition")
def check_matches_definition(facts: Allan) -> Deviation[Ratio] | None:
    """The deviation is the root of half the mean square difference of neighbouring averages"""
    if facts.is_deviation:
        return None  # whatever the unit of its averaging times, which another check measures
    taus, curve, samples = facts.worst
    size = int(np.clip(allan_variance.in_seconds(taus, facts.rate)[0], 1, len(samples) // 2))
    return Deviation({"ratio": curve[0] / allan_deviation(samples, size), "tau": taus[0]})


@ALLAN.check("allan_variance.shows_kinds_of_noise")
def check_shows_kinds_of_noise(facts: Allan) -> Deviation[Slope] | None:
    """Its slope is −1/2 for white noise, +1/2 for a random walk, −1 for quantisation and +1 for drift"""
    size = facts.meaning.size if facts.is_deviation else allan_variance.in_seconds
    for kind, nominal in _NOMINAL.items():
        wanted, got = allan_variance.slopes(facts.records[kind], size, facts.rate)
        if not abs(got - wanted) <= _SLOPE_ATOL:
            return Deviation({"nominal": nominal, "kind": _WORDS[kind], "came": got})
    return None


@ALLAN.check("allan_variance.takes_three_axes")
def check_takes_three_axes(facts: Allan) -> Deviation[Came] | None:
    """Samples of three axes, (n, 3), give a curve for each axis"""
    if facts.together.adev is None:
        return Deviation({"came": facts.together.shape})
    known = facts.together.adev[np.isfinite(facts.together.adev).all(axis=1)]
    together = known[thinned(len(known))]
    for axis, run in enumerate(facts.alone):
        if run.curve is None or not _is_same(together[:, axis], run.curve[1]):
            return Deviation({"came": f"another curve for axis {'xyz'[axis]} than when it is the only one"})
    return None


def _is_same(curve: Array, other: Array) -> bool:
    return len(curve) == len(other) and np.allclose(curve, other, rtol=1e-9, atol=0.0)


# ---- all IMUs ----


@IMUS.check("multiple_imus.finds_every_place")
def check_finds_every_place(facts: Imus) -> Deviation[Places] | None:
    """read_all_imus has an entry for every place of the model that has an accelerometer and a gyroscope"""
    shape = next((world.got.shape for world in facts.worlds if not world.read), "")
    numbers: Places = {
        "where": "",
        "places": "",
        "form": "a dictionary of readings by place, such as 'torso'",
        "came": shape,
    }
    if facts.has_no_dictionary:
        return Deviation(numbers)
    missing = [[place for place in world.true if place not in world.read] for world in facts.worlds]
    where = "" if missing[0] else " of a model with other places"
    places = " and ".join(f"'{place}'" for place in (missing[0] or missing[1])[:3])
    numbers |= {"where": where, "places": places}
    return Deviation(numbers, share=1.0 if missing[0] else 0.5) if any(missing) else None


@IMUS.check("multiple_imus.matches_truth")
def check_matches_truth(facts: Imus) -> Deviation[AtPlace] | None:
    """Each place's reading is that of its own accelerometer and gyroscope"""
    world = next((world for world in facts.worlds if world.wrong), None)
    if world is None:
        return None
    place = world.wrong[0]
    state = int(np.argmax(np.abs(world.read[place] - world.true[place]).max(axis=1)))
    numbers: AtPlace = {
        "wanted": vector(world.true[place][state]),
        "place": place,
        "came": vector(world.read[place][state]),
    }
    return Deviation(numbers, 1.0 if world is facts.lab else 0.5, Size("readings of other places"))


@IMUS.check("multiple_imus.readings_are_copies")
def check_readings_are_copies(facts: Imus) -> Deviation[Changed] | None:
    """A reading keeps its values while the simulation goes on"""
    changed = facts.lab.changed
    return Deviation({"changed": len(changed), "read": len(facts.lab.read)}) if changed else None


# ---- a plot that grows ----

_JUDGED = 10
"""Points that a curve needs before it is compared with the truth."""
_MOST = 24
"""Curves that are compared, the latest ones."""


@LIVE.check("realtime_visualization.returns")
def check_returns(facts: Live) -> Deviation[Simulated] | None:
    """live_plot simulates for the time that it was asked for, and returns"""
    simulated = facts.run.simulated
    numbers: Simulated = {"wanted": facts.duration_s, "came": simulated}
    return None if simulated >= 0.9 * facts.duration_s else Deviation(numbers, share=0.5 if simulated > 0 else 1.0)


@LIVE.check("realtime_visualization.grows_while_stepping")
def check_grows_while_stepping(facts: Live) -> Deviation[Updates] | None:
    """The curves grow while the simulation goes on, not after it"""
    updates = facts.run.updates
    if updates >= UPDATES and facts.run.span >= SPAN * facts.duration_s:
        return None
    replayed = facts.run.changes_after >= UPDATES
    share = 0.5 if updates >= UPDATES - 2 and not facts.shows_once and not replayed else 1.0
    return Deviation({"least": UPDATES, "wanted": facts.duration_s, "came": updates}, share)


@LIVE.check("realtime_visualization.shows_true_data")
def check_shows_true_data(facts: Live) -> Deviation[Curves] | None:
    """The curves show what the IMU reads"""
    judged = [(x, y) for x, y in facts.run.curves if len(y) >= _JUDGED][-_MOST:]
    right = sum(any(live_plot.shows(x, y, its, facts.timestep) for its in facts.channels) for x, y in judged)
    if judged and right * 2 >= len(judged):
        return None
    return Deviation({"right": right, "judged": len(judged)}, share=0.5 if right else 1.0)
