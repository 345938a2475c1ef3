"""Noise model: white Gaussian noise of the size that was asked for, a constant bias, independent on every axis."""

from __future__ import annotations

import itertools
from typing import NoReturn

import numpy as np

from grader.engine.check_runner import check
from grader.engine.findings import CheckFailed, Ours, Size, Skipped, raised
from grader.engine.traces import Traces
from grader.labs.imu import statistics as st
from grader.labs.imu.answers import SENSOR_UNITS
from grader.labs.imu.checks import noise_runs as runs
from grader.labs.imu.checks import noise_sizes
from grader.labs.imu.compare import Array, vector
from grader.labs.imu.diagnosis import noise as diagnosis
from grader.labs.imu.diagnosis import noise_laws as laws
from grader.labs.imu.diagnosis.noise import Facts
from grader.labs.imu.diagnosis.noise_twins import Twins
from grader.labs.imu.number_format import told_apart
from grader.labs.imu.student import Student

_THE_SAME = 0.99
"""Of a correlation: what goes into one channel goes into the other, and next to nothing else does."""
_ALIKE = 0.1
"""Of a spread over the axes: ten times what the noise leaves of it in the mean of all reads."""
_SIZE_CHECK, _GIVEN_CHECK, _LAW_CHECK = (
    "noise_model.noise_size",
    "noise_model.given_bias",
    "noise_model.white_and_gaussian",
)
"""These charge what other checks see as well."""
_NAMES = ("accel", "gyro")
_AS_SMALL = Ours("Draw the default biases as small as sensors have them: about 0.1 m/s² and 0.01 rad/s (Step 5).")
_SIZE = Ours(
    "Draw the noise of each sensor with the standard deviation that was given for it, as it is: no other factor, unit or power "
    "of it, one draw for each axis and read (Step 5)."
)
_READ_FIRST = Ours(
    "Call get_imu_readings in every read(), and add the bias and the noise to what it returns: numbers that come from no sensor "
    "have neither (Step 5)."
)
_ONCE = Ours(
    "Add the bias of each sensor to its reading as it was given: whole, once, each component to its own axis, and nothing of "
    "another bias (Step 5)."
)
_NOTHING_ELSE = Ours(
    "Take the clean reading as it is now and add two things: the bias, and noise whose mean is zero. No factor and no further "
    "offset belongs to it (Step 5)."
)
_OF_ITS_OWN = Ours(
    "Draw six numbers on every read, one for each axis of each sensor, and use none of them twice (Step 5)."
)
_ALL_DIGITS = Ours(
    "Return the noisy readings as float64: no rounding to a step, no int and no dtype of few digits such as float16; round only "
    "where you print (Step 5)."
)
_READ_ONLY = Ours(
    "Let read() change nothing of the simulation: move mj_step, mj_resetData and any write to data to the code that calls it "
    "(Step 5)."
)
_ORDER = Ours(
    "Keep the two sensors apart in read(), the accelerometer first: look at the order of the ids, of what you unpack and "
    "of what you return, and at the bias that each one gets (Step 5)."
)


def of_the_sensors(student: Student, truth: Traces) -> None:
    """Skip a check where the readings do not follow the sensors: there is no noise and no bias without a reading."""
    if not runs.reads_the_sensors(student, truth):
        raise Skipped("readings that change with the sensors")


@check("noise_model.noise_size", lab_step=5)
def check_noise_size(student: Student, truth: Traces) -> None:
    """The noise of each sensor has the standard deviation that was asked for"""
    sensors = runs.steady(student, truth)
    if not runs.reads_the_sensors(student, truth):
        raise CheckFailed(
            "readings that change where the robot's state does",
            "readings that do not follow any sensor",
            hint=_READ_FIRST,
        )
    right = [
        noise_sizes.is_right(facts)
        or (laws.correlated(facts) and noise_sizes.right_of_correlated(student, truth, which, facts))
        or noise_sizes.right_beside_drift(student, truth, which, facts)
        for which, facts in enumerate(sensors)
    ]
    if all(right):
        runs.in_sound_form(student, truth)
        return
    again, silent = runs.given_again(student, truth), runs.without_noise_or_drift(student, truth)
    if noise_sizes.redrawn_bias_explains(sensors, silent):
        return
    wrong = right.index(False)
    mistakes = diagnosis.size_mistakes(sensors, again, silent)
    if not mistakes and laws.density(sensors, float(truth["push"].scalars["timestep"])):
        mistakes = ["noise-density"]
    raise CheckFailed(
        f"{_NAMES[wrong]} noise with a standard deviation of {sensors[wrong].std:g} {SENSOR_UNITS[wrong]}",
        f"{noise_sizes.in_words(sensors[wrong])} {SENSOR_UNITS[wrong]} over {sensors[wrong].residual[..., 0].size} reads",
        mistakes=mistakes,
        keeps=0.5 if any(right) else 0.0,
        hint="" if mistakes else _SIZE,
        belongs_to=(
            *((_LAW_CHECK,) if _law_explains(student, truth, [i for i, is_ in enumerate(right) if not is_]) else ()),
            *_with_one_twice(student, truth),
        ),
    )


def _law_explains(student: Student, truth: Traces, wrong: list[int]) -> bool:
    """Whether the noise goes with the size asked for, or has it but for a few reads, and only has another law.

    white_and_gaussian charges that.
    """
    sensors = runs.steady(student, truth)
    if not all(diagnosis.one_signed(sensors[i]) or not laws.is_normal(sensors[i]) for i in wrong):
        return False
    if all(map(noise_sizes.right_but_for_strays, (sensors[i] for i in wrong))):
        return True
    twins = runs.from_one_seed(student, truth)
    return twins is not None and all(twins[i].scales() for i in wrong)


@check("noise_model.given_bias", lab_step=5, needs=of_the_sensors)
def check_given_bias(student: Student, truth: Traces) -> None:
    """A bias that is given is added to every reading, zero included"""
    sensors, silent = runs.given(student, truth), runs.without_noise(student, truth)
    for key in ("given", "silent"):
        raised(runs.asked(student, truth, key, given=True).fault, "reading the noisy IMU with given biases")
    if runs.returns_exchanged(student, truth):
        raise CheckFailed(
            "accel first and gyro second from read(), each with its own bias",
            "gyro first and accel second",
            mistakes=["swapped-sensors"],
            hint=_ORDER,
        )
    if runs.is_one_twice(student, truth):
        twice = "the same three numbers twice"
        raise CheckFailed("both sensors from read(), the accelerometer first", twice, off=Size(twice), hint=_ORDER)
    off = [i for i, facts in enumerate(sensors) if not _bias_is_right(facts)]
    twins = runs.from_one_seed(student, truth) if off else None
    drifting = runs.which_drift(student, truth)
    exchanged = diagnosis.bias_mistakes(sensors) == ["swapped-sensors"]  # its bias, on the other sensor's reading
    wrong = [i for i in off if exchanged or not (twins and _bias_is_added(twins[i], sensors[i], drifts=drifting[i]))]
    redrawn = not any(drifting) and diagnosis.bias_is_redrawn(sensors, silent)
    if wrong:
        facts, unit = sensors[wrong[0]], SENSOR_UNITS[wrong[0]]
        state = int(np.argmax(np.abs(facts.offset - facts.bias).max(axis=1)))
        expected, came = told_apart(facts.bias, facts.offset[state])
        mistakes = ["bias-redrawn"] if redrawn else diagnosis.bias_mistakes(sensors)
        unused = mistakes in (["no-bias"], ["bias-argument-ignored"])
        if unused and twins and not all(t.ignores_bias() for t in twins if t.seeded):
            mistakes = []  # something of it is there, if too little to be seen beside the noise
        raise CheckFailed(
            f"readings that are {expected} {unit} off the clean ones on average ({_NAMES[wrong[0]]})",
            f"{came} {unit}",
            off=Size("the average is off", float(np.abs(facts.offset - facts.bias).max()), unit),
            mistakes=mistakes,
            keeps=0.5 if len(wrong) == 1 else 0.0,
            hint=_ORDER if mistakes == ["swapped-sensors"] else "" if mistakes else _ONCE,
            belongs_to=_SIZE_CHECK if mistakes == ["biases-exchanged"] and _has_stds_swapped(student, truth) else "",
        )
    another = [i for i in off if not drifting[i] and _has_another_bias(sensors[i], silent[i])]
    if another:
        which = another[0]
        raise CheckFailed(
            f"no {_NAMES[which]} bias but the one that is given",
            f"another one beside it, {vector(silent[which].offset[0])} {SENSOR_UNITS[which]} in one instance and "
            f"{vector(sensors[which].offset[0] - sensors[which].bias)} {SENSOR_UNITS[which]} in the next",
            off=Size("another one beside it, which is not the same for every instance"),
            hint=_ONCE,
        )
    if off:
        return  # what the readings are off by is not the bias: white_and_gaussian and default_bias charge it
    exact = [diagnosis.TRUTH_ATOL + facts.grain / 2 for facts in sensors]
    moved = [f for f, least in zip(silent, exact, strict=True) if np.abs(f.offset).max() > least]
    if any(facts.still for facts in moved):
        got = moved[0]
        raise CheckFailed(
            "no offset where the given bias is zero",
            vector(got.offset[0]),
            mistakes=["bias-argument-ignored"],
            keeps=0.5,
        )


def _has_stds_swapped(student: Student, truth: Traces) -> bool:
    """Whether each sensor has the other's standard deviation, which noise_size charges."""
    again, silent = runs.given_again(student, truth), runs.without_noise_or_drift(student, truth)
    return diagnosis.size_mistakes(runs.steady(student, truth), again, silent) == ["stds-swapped"]


def _bias_is_right(facts: Facts) -> bool:
    if diagnosis.accumulates(facts):  # where the walk starts is all that can be seen of the bias
        start = np.abs(facts.residual[0, 0] - facts.bias)
        return bool(start.max() <= 2 * st.Z * facts.std)
    if diagnosis.one_signed(facts):
        return True
    return diagnosis.bias_is_right(facts)


@check("noise_model.default_bias", lab_step=5, needs=of_the_sensors)
def check_default_bias(student: Student, truth: Traces) -> None:
    """Without a given bias, each instance draws its own, keeps it, and has one for every axis"""
    biases = runs.default_biases(student, truth)
    sensors, silent = runs.given(student, truth), runs.without_noise(student, truth)
    drifting = runs.which_drift(student, truth)
    still = [facts.still or drifts for facts, drifts in zip(silent, drifting, strict=True)]
    noisy = not all(still) and not diagnosis.bias_is_redrawn(sensors, silent)
    if any(drifting):
        _stays(drifting, biases, silent)
    none = [bool(np.abs(bias.mean(axis=1)).max() <= diagnosis.TRUTH_ATOL) for bias in biases]
    for which, (bias, name) in enumerate(zip(biases, _NAMES, strict=True)):
        _bias_is_constant(bias, name, noisy=noisy)
        mean = bias.mean(axis=1)
        if none[which]:
            if _drawn_with_noise(student, truth, which):
                continue
            mistake = "no-bias" if diagnosis.bias_mistakes(sensors) == ["no-bias"] else "bias-not-random"
            keeps = 0.0 if mistake == "no-bias" else 0.5
            raise CheckFailed(
                f"a random {name} bias for each instance",
                "none",
                mistakes=[mistake],
                keeps=keeps,
                belongs_to=_GIVEN_CHECK if mistake == "no-bias" and not all(f.still for f in sensors) else "",
            )
        if np.ptp(mean[1:], axis=0).max() <= diagnosis.EXACT and not noisy:
            got = f"{vector(mean[1])} for each of {len(mean)} instances"
            repeated = all(f.still for f in sensors) and diagnosis.size_mistakes(
                sensors, runs.given_again(student, truth), silent
            )
            reseeded = [] if repeated == ["no-noise"] else repeated
            mistakes = reseeded or ["bias-not-random"]
            raise CheckFailed(
                f"another {name} bias for each instance",
                got,
                mistakes=mistakes,
                keeps=0.5,
                belongs_to=_SIZE_CHECK if reseeded else "",
            )
        if np.ptp(mean, axis=1).max() <= diagnosis.TRUTH_ATOL:
            got = f"{vector(mean[0])}: the same on each axis"
            facts = sensors[which]  # with a bias that has three
            as_given = np.ptp(facts.offset, axis=1).max() < _ALIKE * np.ptp(facts.bias)
            raise CheckFailed(
                f"one {name} bias of its own on each axis",
                got,
                mistakes=["bias-shared"],
                keeps=0.5,
                belongs_to=_GIVEN_CHECK if as_given else "",
            )
    if any(none):
        return
    ratio = biases[1].mean(axis=1) / biases[0].mean(axis=1)
    if np.ptp(ratio) <= 1e-3 * np.abs(ratio).max():
        got = f"{ratio[0, 0]:.3g} times the accelerometer's for the gyroscope, on every axis"
        raise CheckFailed("a bias of its own for each sensor", got, mistakes=["bias-shared"], keeps=0.5)
    too_large = noise_sizes.too_large_for_a_sensor(biases)
    if too_large is not None and not noisy:
        which, drawn, sheets = too_large
        wanted = f"a default {_NAMES[which]} bias as sensors have it, about {sheets:g} {SENSOR_UNITS[which]}"
        law = () if all(map(_bias_is_right, sensors)) else (_LAW_CHECK,)  # it charges what else is in the mean
        elsewhere = (_GIVEN_CHECK, *law)
        raise CheckFailed(wanted, f"{drawn:.2g} {SENSOR_UNITS[which]}", keeps=0.5, hint=_AS_SMALL, belongs_to=elsewhere)


def _drawn_with_noise(student: Student, truth: Traces, which: int) -> bool:
    """Whether a sensor that has no bias where there is no noise has one where there is: its size may go with the noise's.

    Its mean over many reads then scatters from instance to instance, by more than the noise alone lets it.
    """
    mean = runs.default_biases(student, truth, stds=runs.asked_stds(truth), reads=runs.MANY)[which].mean(axis=1)
    _, most = st.spread_bounds(mean.size, mean.shape[1])
    return bool(np.sqrt(np.mean(np.var(mean, axis=0))) > most * runs.asked_stds(truth)[which] / np.sqrt(runs.MANY))


def _stays(drifting: list[bool], biases: list[Array], silent: list[Facts]) -> None:
    which = drifting.index(True)
    moved = max(float(np.ptp(biases[which], axis=1).max()), float(np.ptp(silent[which].residual, axis=1).max()))
    raise CheckFailed(
        f"one {_NAMES[which]} bias for all reads",
        f"one that drifts, by up to {moved:.3g} {SENSOR_UNITS[which]} over {runs.MANY} reads without noise",
        mistakes=["bias-drifts"],
        belongs_to=_GIVEN_CHECK,
    )


def _bias_is_constant(bias: Array, name: str, *, noisy: bool) -> None:
    moves = np.ptp(bias, axis=1)
    if moves.max() <= diagnosis.EXACT * max(1.0, np.abs(bias).max()) or noisy:
        return
    row = int(np.argmax(moves.max(axis=1)))
    read = int(np.argmax(np.abs(bias[row] - bias[row, 0]).max(axis=1)))
    wanted = f"one {name} bias that stays the same from read to read"
    got = f"{', then '.join(told_apart(bias[row, 0], bias[row, read]))} from the same instance"
    if np.abs(bias[:, 1:]).max() <= diagnosis.TRUTH_ATOL:
        raise CheckFailed(wanted, got, mistakes=["bias-drifts"], belongs_to=_GIVEN_CHECK)
    if np.ptp(bias[:, 1:], axis=(0, 1)).max() <= diagnosis.EXACT:  # the first read was before the next one was made
        got += ", and from every other one that was made meanwhile"
        raise CheckFailed(wanted, got, mistakes=["bias-shared"], keeps=0.5)
    if np.median(moves.max(axis=1)) <= diagnosis.EXACT:  # of most instances the bias stays
        raise CheckFailed(wanted, got, hint=_NOTHING_ELSE, belongs_to=_LAW_CHECK)
    raise CheckFailed(wanted, got, mistakes=["bias-redrawn"], belongs_to=_GIVEN_CHECK)


def _differs_from_read_to_read(student: Student, truth: Traces) -> NoReturn:
    """Noise that was drawn once and for all has no further fault; where none was drawn there is nothing to judge."""
    again, silent = runs.given_again(student, truth), runs.without_noise_or_drift(student, truth)
    mistakes = diagnosis.size_mistakes(runs.steady(student, truth), again, silent)
    wanted = "noise that differs from read to read"
    if mistakes in (["frozen-noise"], ["reseeded"]):
        raise CheckFailed(wanted, "one draw, which is repeated", mistakes=mistakes, belongs_to=_SIZE_CHECK)
    raise Skipped(wanted)


@check("noise_model.white_and_gaussian", lab_step=5, needs=of_the_sensors)
def check_white_and_gaussian(student: Student, truth: Traces) -> None:
    """The noise is Gaussian with zero mean, and no read depends on the one before"""
    raw, both = runs.given(student, truth), runs.steady(student, truth)
    if any(facts.grain for facts in raw):
        grains = " and ".join(
            f"{f.grain:g} {u} ({n})" for f, u, n in zip(raw, SENSOR_UNITS, _NAMES, strict=True) if f.grain
        )
        raise CheckFailed(
            "readings as fine as float64 has them",
            f"none finer than {grains}",
            mistakes=["precision-lost"],
            hint=_ALL_DIGITS,
        )
    sensors = [(f, n) for f, n in zip(both, _NAMES, strict=True) if not f.still]
    if not sensors:
        _differs_from_read_to_read(student, truth)
    for facts, name in sensors:
        _is_white(facts, name)
        if diagnosis.one_signed(facts):
            raise CheckFailed(f"{name} noise of both signs", "noise of one sign only", mistakes=["noise-not-zero-mean"])
        if laws.clipped(facts):
            most = float(np.abs(facts.centred).max())
            raise CheckFailed(
                f"{name} noise of a normal law, which nothing cuts off",
                f"none beyond {most / facts.std:.2f} standard deviations in {facts.residual.size} values",
                mistakes=["noise-clipped"],
            )
        if not laws.is_normal(facts):
            _is_so_in_all_reads(facts, name)
            values = laws.living(facts)
            got = f"{st.geary(values):.3f} over {values.size} values"
            wanted = f"{name} noise with a ratio of mean deviation to standard deviation of 0.798, as a normal law has"
            raise CheckFailed(wanted, got, mistakes=["not-gaussian"])
    _is_centred(student, truth, raw)


def _is_so_in_all_reads(facts: Facts, name: str) -> None:
    """Charge what happens to a few reads alone, where the others are as they should be."""
    strays = laws.strays(facts)
    if strays is not None:
        got = (
            f"{strays.count} of {facts.residual.size} values more than {st.Z:.1f} standard deviations off, "
            "and the others as a normal law has them"
        )
        off = Size("a few values are further off than a normal law has any")
        raise CheckFailed(f"{name} noise of a normal law in all reads", got, off=off, hint=_NOTHING_ELSE)


def _is_centred(student: Student, truth: Traces, sensors: list[Facts]) -> None:
    """Nothing stays of the readings on average but the clean ones and the bias, where given_bias has found the bias added."""
    off = [i for i, facts in enumerate(sensors) if not _bias_is_right(facts)]
    if not off or any(runs.which_drift(student, truth)):
        return
    which, twins = off[0], runs.from_one_seed(student, truth)
    if twins is None or not all(_bias_is_added(twins[i], sensors[i], drifts=False) for i in off):
        return
    facts, mistakes = sensors[which], diagnosis.bias_mistakes(sensors)
    if mistakes == ["swapped-sensors"] or _has_another_bias(facts, runs.without_noise(student, truth)[which]):
        return  # given_bias charges it
    known = [m for m in mistakes if m in ("noise-not-zero-mean", "stale-clean-reading")]
    beside = facts.offset[-1] - facts.bias
    raise CheckFailed(
        f"{_NAMES[which]} readings that are the clean ones and the bias on average",
        f"{vector(beside)} {SENSOR_UNITS[which]} beside these",
        off=Size("the average is off", float(np.abs(beside).max()), SENSOR_UNITS[which]),
        mistakes=known,
        hint="" if known else _NOTHING_ELSE,
    )


def _is_white(facts: Facts, name: str) -> None:
    if diagnosis.accumulates(facts):
        raise CheckFailed(
            f"{name} noise drawn anew on every read",
            "noise that adds up from read to read",
            mistakes=["noise-accumulates"],
        )
    bound = st.correlation_bound(facts.residual.shape[1])
    for lag in (1, 2, 3):
        worst = laws.correlation(facts, lag)
        if worst > bound:
            raise CheckFailed(
                f"{name} reads that do not depend on each other",
                f"a correlation of {worst:.2f} with the read {lag} before",
                mistakes=["noise-correlated"],
            )


@check("noise_model.axes_and_sensors_independent", lab_step=5, needs=of_the_sensors)
def check_axes_and_sensors_independent(student: Student, truth: Traces) -> None:
    """Each axis of each sensor has noise of its own"""
    sensors = runs.steady(student, truth)
    if all(facts.still for facts in sensors):
        _differs_from_read_to_read(student, truth)
    if any(
        map(laws.correlated, sensors)
    ):  # what is slow looks alike by chance; neighbouring reads differ by what is new
        sensors = [laws.paired(facts) for facts in sensors]
    columns = np.concatenate([_innovations(facts) for facts in sensors], axis=1)
    matrix = st.correlations(columns)
    bound = st.correlation_bound(len(columns))
    channels = [f"{sensor} {axis}" for sensor in _NAMES for axis in "xyz"]
    pairs = [(abs(matrix[i, j]), i, j) for i, j in itertools.combinations(range(6), 2)]
    worst, i, j = max(
        pairs, key=lambda pair: round(pair[0], 2)
    )  # as it is told: the last digits differ between processors
    if worst > bound:
        one = _is_one_for_all_axes(matrix, i // 3)
        raise CheckFailed(
            f"independent noise on {channels[i]} and {channels[j]}",
            f"a correlation of {worst:.2f} over {len(columns)} reads",
            off=Size("two of the six channels have noise that goes together"),
            mistakes=["same-noise-on-axes"] if one else [],
            hint="" if one else _OF_ITS_OWN,
            belongs_to=(*_with_one_twice(student, truth), *(() if _signs_agree(columns, i, j) else (_LAW_CHECK,))),
        )


def _is_one_for_all_axes(matrix: Array, which: int) -> bool:
    """Whether the noise of a sensor is one number for its three axes, by the correlations (6, 6) of all."""
    axes = slice(3 * which, 3 * which + 3)
    return bool(matrix[axes, axes].min() > _THE_SAME)


def _signs_agree(columns: Array, i: int, j: int) -> bool:
    """Whether two channels are correlated by more than what a few far values of theirs, which white_and_gaussian charges, make."""
    signs = st.correlations(np.sign(columns))
    return bool(abs(signs[i, j]) > st.correlation_bound(len(columns)))


def _with_one_twice(student: Student, truth: Traces) -> tuple[str, ...]:
    """What charges the same sensor in both places, of which the size and the noise are then those of one."""
    return (_GIVEN_CHECK,) if runs.is_one_twice(student, truth) else ()


def _innovations(facts: Facts) -> Array:
    if diagnosis.accumulates(facts):
        steps = np.concatenate([facts.increments[:, :1] * 0, facts.increments], axis=1)
        return np.asarray(steps.reshape(-1, 3))
    return facts.standardised


@check("noise_model.leaves_simulation_alone", lab_step=5)
def check_leaves_simulation_alone(student: Student, truth: Traces) -> None:
    """A noisy read changes nothing in the simulator's own data"""
    run = runs.judged(student, truth, "given")
    change = run.disturbance.max(axis=0, initial=0.0)
    names = ("data.time", "data.qpos", "data.qvel", "data.sensordata")
    changed = [f"{name} changed by {size:.3g}" for name, size in zip(names, change, strict=True) if not size <= 1e-12]
    if changed:
        only_sensors = change[:3].max() <= 1e-12
        mistake, hint = ("mutates-sensordata", "") if only_sensors else ("disturbs-simulation", _READ_ONLY)
        raise CheckFailed("the same data before and after a read", "; ".join(changed), mistakes=[mistake], hint=hint)


def _has_another_bias(facts: Facts, silent: Facts) -> bool:
    """Whether an instance without noise and bias is off, and by something else than one that has both."""
    beside = facts.offset - facts.bias
    apart = np.abs(silent.offset - beside).max() > 2 * diagnosis.mean_bound(facts)
    return bool(silent.still and np.abs(silent.offset).max() > diagnosis.TRUTH_ATOL and apart)


def _bias_is_added(twins: Twins, facts: Facts, *, drifts: bool) -> bool:
    """Whether another bias changes the readings by just that, whatever else is in them."""
    return twins.begins_with_bias() if drifts else twins.adds_bias(facts.grain)
