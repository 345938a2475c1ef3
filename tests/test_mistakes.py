"""The catalogue of mistakes: complete, within its limits, and true: its examples are run."""

from __future__ import annotations

import ast
import math
import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest
import yaml

from grader.engine import rubric
from grader.engine.faults import catalogue
from grader.engine.feedback import mistake_of
from grader.engine.findings import Fault
from grader.labs.imu.lab import LAB

ROOT = Path(__file__).parent.parent
TABLE: dict[str, dict[str, dict[str, Any]]] = yaml.safe_load(
    (ROOT / "grader" / "labs" / "imu" / "faults.yaml").read_text(encoding="utf-8")
)
MISTAKES = {
    group: named
    for group, rows in TABLE.items()
    if (named := {key: row for key, row in rows.items() if "explanation" in row})
}
CHARGING = ["deducts", "takes", "expected", "got"]
ENTRIES = {key: entry for group in MISTAKES.values() for key, entry in group.items()}

# What each name stands for. Results and gradebooks carry the names, so neither they nor their meaning may drift.
MEANS = {
    "sensor_access": {
        "sensor-id-as-address": "uses the sensor's id as its place in sensordata",
        "hard-coded-address": "relies on the order of the lab model's sensors; another model has them elsewhere",
        "off-by-one-address": "the slice starts one element too early or too late",
        "swapped-sensors": "returns the two sensors in exchanged order",
        "view-not-copy": "returns an array that changes later: a view of sensordata, or one array that every call fills again",
        "wrong-length": "returns a vector that does not have three components",
        "sign-flipped": "changes the sign of the reading, on one axis or on all",
        "gravity-removed": "adds or subtracts gravity",
        "wrong-units": "returns another unit than m/s² and rad/s",
        "axes-permuted": "returns the components in another order",
        "world-frame": "rotates the reading with the sensor's orientation (site_xmat)",
        "not-the-sensor": "reads another array of the simulator, such as qvel, qacc or cvel, instead of sensordata",
        "disturbs-simulation": "changes the simulation while it reads: steps, resets or writes to data",
        "cached-reading": "returns an earlier reading again",
        "precision-lost": "returns fewer digits than the sensor has: rounded, as integers, or in a short float type",
    },
    "data_collection": {
        "no-reset": "does not reset the simulation first: a second run starts where the first ended",
        "no-perturbation": "the recording shows no push: it is missing, undone by a later reset, or made in other data",
        "wrong-perturbation": "pushes in another way than data.qvel[0] = 0.5 once at the start",
        "read-before-step": "reads the sensors before the step: every row is late by one sample",
        "aliased-rows": "stores one array many times, so that every row holds the last sample",
        "ignores-duration": "the number of samples does not follow duration_seconds and the model's time step",
        "hard-coded-timestep": "assumes a time step instead of reading model.opt.timestep",
        "samples-skipped": "makes more than one step for each stored row",
        "time-axis-wrong": "the time stamps are not the simulation time in seconds",
        "arrays-transposed": "arrays of shape (3, n) instead of (n, 3)",
        "wrong-keys": "the dictionary's keys are not time, acceleration, angular_velocity",
        "channels-swapped": "stores the accelerations under 'angular_velocity' and the angular velocities under 'acceleration'",
        "nothing-simulated": "returns numbers that no simulation made",
        "rows-left-zero": "some rows of the arrays are never filled",
        "modifies-model": "changes the model, for example its gravity or its time step",
    },
    "visualization": {
        "plot-not-saved": "saves no picture of the plot",
        "blank-image": "saves an empty figure",
        "no-axis-labels": "axes have no labels",
        "no-units": "axis labels name no unit, or the unit of something else",
        "no-legend": "nothing names the curves of a panel",
        "legend-order-wrong": "legend entries name the wrong curves",
        "no-title": "panels have no title",
        "wrong-data-plotted": "a curve does not show what it should",
        "curves-missing": "some of the six curves are missing",
        "one-panel": "draws both sensors on the same axes",
        "panels-swapped": "a panel is labelled as one sensor and shows the other",
        "x-not-time": "draws the curves against something else than the time in seconds",
        "low-resolution": "saves a picture that is too small to read",
        "comparison-missing": "no saved picture shows raw and filtered data together",
    },
    "noise_model": {
        "no-noise": "returns the clean reading (plus bias at most)",
        "gyro-not-noisy": "noise on one of the two sensors only",
        "variance-as-std": "takes the standard deviation as a variance, or squares it",
        "std-ignored": "uses a fixed standard deviation instead of the argument",
        "stds-swapped": "uses one sensor's standard deviation for the other",
        "same-noise-on-axes": "one random number for all three axes",
        "frozen-noise": "draws the noise once and repeats it on every read",
        "reseeded": "seeds the generator inside read(), so every read has the same noise",
        "not-gaussian": "draws from another distribution than the normal one",
        "noise-not-zero-mean": "noise of one sign, or with an offset beside the bias",
        "multiplicative-noise": "scales the reading instead of adding to it",
        "noise-accumulates": "each read adds to the noise of the read before",
        "no-bias": "the bias is never added",
        "bias-redrawn": "draws a new bias on every read",
        "bias-argument-ignored": "a bias given to the constructor is not used (zero included)",
        "bias-not-random": "the default bias is the same for every instance",
        "bias-shared": "one bias for both sensors, all axes or all instances",
        "bias-sign-flipped": "subtracts the bias",
        "mutates-sensordata": "adds the noise to the simulator's own array",
        "stale-clean-reading": "reads the sensor once and adds noise to that for ever",
    },
    "filtering": {
        "alpha-swapped": "gives the new measurement the weight 1 - alpha",
        "no-filtering": "returns the measurement unfiltered",
        "zero-initial-state": "starts from zero instead of the first measurement",
        "initial-value-ignored": "does not use the initial value that is given",
        "shared-state": "all filters share one state",
        "aliased-output": "returns the array that it keeps as its state",
        "mutates-input": "writes into an array that it was given",
        "output-stuck": "the output does not change after the first sample",
        "gain-not-one": "the two weights do not add up to 1",
        "alpha-ignored": "uses a fixed weight instead of alpha",
        "filters-input-history": "mixes with the last measurement instead of the last output",
        "axes-mixed": "the axes are mixed, or only some of them are filtered",
        "other-low-pass": "smooths, but not with the sheet's recursion",
        "high-pass": "returns the noise and removes the slow part",
    },
    "extensions": {
        "gyro-only": "integrates the gyroscope without a correction by the accelerometer",
        "accel-only": "uses the accelerometer's tilt without the gyroscope",
        "weights-swapped": "gives the accelerometer the weight of the gyroscope",
        "degrees-not-radians": "uses degrees, or mixes degrees and radians",
        "tilt-sign-wrong": "computes roll or pitch with a wrong sign or from a wrong axis",
        "std-not-allan": "computes a standard deviation of averages instead of the Allan deviation",
        "allan-factor-missing": "leaves out the factor one half",
        "tau-wrong": "returns averaging times that are not in seconds",
        "same-imu-repeated": "returns the same sensor for every place",
        "imu-missing": "does not read all IMUs of the model",
        "plot-not-live": "draws the plot only once, after the simulation",
    },
    "any": {
        "file-missing": "a required file is missing",
        "name-missing": "a required function, class or method is not defined",
        "does-not-import": "the file has a syntax error, or raises an exception while it is imported",
        "raises": "the code raises an exception on valid input",
        "never-returns": "the code does not end within its time limit",
        "kills-its-process": "the code ends or crashes the Python interpreter",
        "wrong-return-type": "returns something else than the sheet describes",
        "not-finite": "returns NaN or infinity",
        "sensor-not-found": "uses a sensor name that the model does not have",
        "tampering": "tries to reach the grader instead of solving the lab",
    },
}
ADDED = {
    "sensor_access": ["same-sensor-twice"],
    "data_collection": ["keeps-old-rows", "first-row-empty", "fixed-rate", "rows-altered", "random-push"],
    "visualization": ["comparison-wrong-data", "picture-overwritten", "curves-not-seen"],
    "noise_model": [
        "bias-drifts",
        "noise-density",
        "noise-correlated",
        "noise-clipped",
        "bias-axes-exchanged",
        "biases-exchanged",
    ],
    "filtering": [
        "aliased-input",
        "moving-average",
        "does-not-filter",
        "state-not-kept",
        "output-rounded",
        "filter-restarts",
    ],
    "any": [
        "index-out-of-bounds",
        "missing-package",
        "not-written",
        "unknown-name",
        "other-parameters",
        "global-for-parameter",
    ],
}
FIELDS = ["title", "hint", "explanation", "step", "wrong", "right"]
RAISED = ["name-missing", "sensor-not-found", "index-out-of-bounds", "not-written", "unknown-name"]
STEPS = {"sensor_access": {2}, "data_collection": {3}, "visualization": {4, 6}, "noise_model": {5}, "filtering": {6}}

every_mistake = pytest.mark.parametrize("key", ENTRIES)


def example(key: str, version: str, parameters: str) -> Callable[..., Any]:
    """The lines of an example as the body of a function, which returns its local names or what the lines return."""
    body = textwrap.indent(ENTRIES[key][version], "    ")
    namespace: dict[str, Any] = {"np": np, "mujoco": mujoco}
    exec(f"def lines({parameters}):\n{body}\n    return locals()", namespace)
    return namespace["lines"]  # type: ignore[no-any-return]


def sentences(text: str) -> int:
    return len(re.findall(r"[.?!](?=\s|$)", text))


@pytest.mark.parametrize(
    ("exception", "message", "key"),
    [
        ("IndexError", "whatever Python or NumPy says", "index-out-of-bounds"),
        ("NameError", "whatever Python says", "unknown-name"),
        ("UnboundLocalError", "whatever Python says", "unknown-name"),
        ("KeyError", "\"Invalid name 'imu'. Valid names: ['torso']\"", "raises"),
        ("ValueError", "whatever NumPy says", "raises"),
        ("NotImplementedError", "TODO", "not-written"),
    ],
)
def test_the_type_of_an_exception_shows_a_mistake(exception: str, message: str, key: str) -> None:
    assert mistake_of(Fault(exception, message, None, None, None), catalogue(LAB)) == key


@pytest.mark.parametrize("message", ["Invalid name 'imu'. Valid names: ['torso']", "whatever another MuJoCo says"])
@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("adr = model.sensor('imu').adr[0]", "sensor-not-found"),
        ("return data.sensor (name).data", "sensor-not-found"),
        ("settings['sensor']", "raises"),
        ("body = model.body('imu')", "raises"),
    ],
)
def test_a_line_that_looks_up_a_sensor_in_vain_shows_a_mistake(line: str, key: str, message: str) -> None:
    assert mistake_of(Fault("KeyError", message, "imu_reader.py", 3, line), catalogue(LAB)) == key


@pytest.mark.parametrize(("name", "key"), [("update", "name-missing"), ("read", "name-missing"), ("alpha", "raises")])
def test_a_method_that_is_not_there_shows_a_mistake(name: str, key: str) -> None:
    assert mistake_of(Fault("AttributeError", "in any words", None, None, None, name), catalogue(LAB)) == key


# --- the file ---------------------------------------------------------------------------------------------------------


def test_every_mistake_is_there_in_its_group_and_in_order() -> None:
    expected = {group: [*means, *ADDED.get(group, [])] for group, means in MEANS.items()}
    assert {group: list(entries) for group, entries in MISTAKES.items()} == expected
    assert list(MISTAKES) == list(MEANS)


def test_what_a_name_means_has_not_changed() -> None:
    kept = {group: {key: MISTAKES[group][key]["title"] for key in means} for group, means in MEANS.items()}
    assert kept == MEANS


def test_no_name_is_used_in_two_groups() -> None:
    assert len(ENTRIES) == sum(len(entries) for entries in MISTAKES.values())


@every_mistake
def test_an_entry_has_all_fields_and_none_is_empty(key: str) -> None:
    entry = ENTRIES[key]
    assert [field for field in entry if field not in CHARGING] == FIELDS + ["raised"] * (key in RAISED)
    assert all(isinstance(entry[field], str) and entry[field].strip() for field in FIELDS if field != "step")


def test_what_a_fault_deducts_and_takes_are_shares_of_checks_that_there_are() -> None:
    known = {weight.id for weight in rubric.load(LAB).checks}
    for group, found in TABLE.items():
        for key, row in found.items():
            named = [
                name if "." in name else f"{group}.{name}" for name in (*row.get("deducts", ()), *row.get("takes", ()))
            ]
            assert set(named) <= known, key
            assert all(0 < share <= 1 for share in row.get("deducts", {}).values()), key
    assert set(TABLE["checks"]) <= known


@every_mistake
def test_a_hint_is_one_or_two_short_sentences_on_one_line(key: str) -> None:
    hint = ENTRIES[key]["hint"]
    assert hint.endswith(".")
    assert "\n" not in hint
    assert len(hint) <= 160
    assert 1 <= sentences(hint) <= 2


@every_mistake
def test_an_explanation_is_two_to_five_sentences(key: str) -> None:
    explanation = ENTRIES[key]["explanation"]
    assert explanation.endswith(".")
    assert "\n" not in explanation
    assert 2 <= sentences(explanation) <= 5


@pytest.mark.parametrize("group", MISTAKES)
def test_the_step_is_one_of_the_criterion_and_hint_and_explanation_name_it(group: str) -> None:
    for key, entry in MISTAKES[group].items():
        step = entry["step"]
        assert step in STEPS.get(group, {None, 1, 2}), key
        if step is not None:
            assert f"Lab 04-01, Step {step}" in entry["explanation"], key
            assert f"Step {step}" in entry["hint"], key


@every_mistake
@pytest.mark.parametrize("version", ["wrong", "right"])
def test_an_example_is_one_to_four_lines_of_python(key: str, version: str) -> None:
    code = ENTRIES[key][version]
    assert 1 <= len(code.splitlines()) <= 4
    assert max(map(len, code.splitlines())) <= 110
    ast.parse(code)


@every_mistake
def test_the_mended_lines_are_not_the_wrong_ones(key: str) -> None:
    wrong, right = ENTRIES[key]["wrong"], ENTRIES[key]["right"]
    assert right != wrong
    assert wrong.startswith("#") or ast.dump(ast.parse(right)) != ast.dump(ast.parse(wrong))


def test_the_sheets_common_errors_are_answered_with_its_own_solutions() -> None:
    assert "Check the sensor names in your XML model file" in ENTRIES["sensor-not-found"]["hint"]
    assert "mujoco.mj_id2name()" in ENTRIES["sensor-not-found"]["hint"]
    assert "sensor_adr and sensor_dim match your sensor configuration" in ENTRIES["index-out-of-bounds"]["hint"]
    answer = "check that the model has gravity enabled and that the sensor is attached to a body"
    assert answer in ENTRIES["gravity-removed"]["explanation"]


# --- what the words and the lines speak of exists ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def model() -> Any:
    return mujoco.MjModel.from_xml_path(str(ROOT / "reference" / "models" / "humanoid-sensors.xml"))


@pytest.fixture
def data(model: Any) -> Any:
    """The robot a tenth of a second after a push: every channel of every IMU is alive."""
    data = mujoco.MjData(model)
    data.qvel[:6] = [0.5, 0.3, 0.0, 0.1, 0.2, 0.3]
    mujoco.mj_step(model, data, nstep=50)
    return data


@every_mistake
def test_every_attribute_that_words_and_examples_name_exists(key: str, model: Any, data: Any) -> None:
    known = {"mujoco": mujoco, "model": model, "data": data, "np": np, "plt": plt}
    for field in ("hint", "explanation", "wrong", "right"):
        for owner, chain in re.findall(r"(?<![\w.])(mujoco|model|data|np|plt)\.(\w+(?:\.\w+)*)", ENTRIES[key][field]):
            target = known[owner]
            for name in chain.split("."):
                assert hasattr(target, name), f"{owner}.{chain}"
                target = getattr(target, name)


# --- the examples, run ------------------------------------------------------------------------------------------------

READER = "model, data, accel_sensor_id, gyro_sensor_id, accel_adr, gyro_adr, acceleration, angular_velocity"
READERS = [key for key in MISTAKES["sensor_access"] if key != "cached-reading"]


def read(key: str, version: str, model: Any, data: Any, place: str) -> tuple[Any, Any]:
    """What a reader with these lines returns; lines that an example leaves out are sound."""
    ids = [model.sensor(f"{place}_{kind}").id for kind in ("accelerometer", "gyroscope")]
    addresses = [int(model.sensor_adr[i]) for i in ids]
    sound = [data.sensordata[adr : adr + 3].copy() for adr in addresses]
    found = example(key, version, READER)(model, data, *ids, *addresses, *sound)
    return found if isinstance(found, tuple) else (found["acceleration"], found["angular_velocity"])


def sound_reader(key: str, version: str, model: Any, data: Any) -> bool:
    """Whether it reads two IMUs right, twice, hands out copies and leaves the simulation alone."""
    before = (data.time, data.sensordata.copy())
    for place in ("torso", "torso", "right_foot"):
        accel, gyro = read(key, version, model, data, place)
        truth = [before[1][model.sensor(f"{place}_{kind}").adr[0] :][:3] for kind in ("accelerometer", "gyroscope")]
        if not (np.array_equal(accel, truth[0]) and np.array_equal(gyro, truth[1])):
            return False
        if np.shares_memory(accel, data.sensordata) or np.shares_memory(gyro, data.sensordata):
            return False
    return bool(data.time == before[0])


@pytest.mark.parametrize("key", READERS)
def test_the_mended_reader_reads_every_imu_and_the_wrong_one_does_not(key: str, model: Any, data: Any) -> None:
    assert sound_reader(key, "right", model, data)
    assert not sound_reader(key, "wrong", model, data)


def test_the_example_beyond_the_end_raises_as_its_explanation_says(model: Any, data: Any) -> None:
    with pytest.raises(IndexError, match="out of bounds"):
        read("index-out-of-bounds", "wrong", model, data, "right_foot")
    assert sound_reader("index-out-of-bounds", "right", model, data)


def test_an_unknown_sensor_is_minus_one_and_reads_the_last_sensor(model: Any) -> None:
    found = {
        version: example("sensor-not-found", version, "model")(model)["accel_id"] for version in ("wrong", "right")
    }
    assert found["wrong"] == -1
    assert model.sensor_adr[found["wrong"]] == model.sensor(model.nsensor - 1).adr[0]
    assert found["right"] == model.sensor("torso_accelerometer").id


LOOP = "model, data, n_steps, accelerations, angular_velocities, get_imu_readings, accel_id, gyro_id"


def collected(key: str, version: str, model: Any) -> np.ndarray:
    """The accelerations that a collecting loop with these lines leaves behind, ten samples after a push."""
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    rows: Any = [] if "append" in ENTRIES[key][version] else np.zeros((10, 3))
    adr = model.sensor("torso_accelerometer").adr[0]

    def reader(*_: Any) -> tuple[Any, Any]:
        return data.sensordata[adr : adr + 3].copy(), np.zeros(3)

    return np.array(
        example(key, version, LOOP)(model, data, 10, rows, np.zeros((10, 3)), reader, 0, 0)["accelerations"]
    )


def test_the_loops_go_wrong_as_their_explanations_say(model: Any) -> None:
    loops = ["read-before-step", "aliased-rows", "rows-left-zero"]
    truth, *others = (collected(key, "right", model) for key in loops)
    assert all(np.array_equal(truth, other) for other in others)
    assert len(np.unique(truth[:, 0])) == 10
    late, aliased, short = (collected(key, "wrong", model) for key in loops)
    assert np.array_equal(late, [np.zeros(3), *truth[:-1]])
    assert np.array_equal(aliased, [truth[-1]] * 10)
    assert np.array_equal(short, [np.zeros(3), *truth[:-1]])


FILTERS = [
    *("alpha-swapped", "no-filtering", "mutates-input", "output-stuck", "gain-not-one"),
    *("alpha-ignored", "filters-input-history", "axes-mixed", "high-pass"),
]


def filtered(key: str, version: str, samples: np.ndarray, alpha: float = 0.3) -> tuple[list[Any], np.ndarray]:
    """What comes out after the first sample, and what is left of the samples."""
    samples = samples.copy()
    state = SimpleNamespace(alpha=alpha, value=samples[0].copy(), previous=samples[0].copy())
    update, outputs = example(key, version, "self, measurement"), []
    for sample in samples[1:]:
        found = update(state, sample)
        outputs.append(found.get("output", state.value) if isinstance(found, dict) else found)
    return outputs, samples


@pytest.mark.parametrize("key", FILTERS)
def test_the_mended_filter_follows_the_sheets_recursion_and_the_wrong_one_does_not(key: str) -> None:
    samples = np.random.default_rng(1).normal([0.0, 1.0, -9.81], 0.5, (6, 3))
    truth = [samples[0]]
    for sample in samples[1:]:
        truth.append(0.3 * sample + 0.7 * truth[-1])

    def follows(version: str) -> bool:
        outputs, left = filtered(key, version, samples)
        return np.allclose(outputs, truth[1:], rtol=0, atol=1e-12) and np.array_equal(left, samples)

    assert follows("right")
    assert not follows("wrong")


NOISES = ["variance-as-std", "std-ignored", "same-noise-on-axes", "not-gaussian", "noise-not-zero-mean"]


@pytest.mark.parametrize("key", NOISES)
def test_the_mended_noise_is_white_and_of_the_asked_size_and_the_wrong_one_is_not(key: str) -> None:
    sensor = SimpleNamespace(accel_noise_std=0.2)

    def sound(version: str) -> bool:
        np.random.seed(4)  # the sheet's own generator
        draw = example(key, version, "self")
        noise = np.array([np.broadcast_to(draw(sensor)["noise"], 3) for _ in range(4000)])
        # Six standard errors of 4000 draws: of the mean, of the spread, of a correlation.
        centred = np.all(np.abs(noise.mean(axis=0)) < 6 * 0.2 / math.sqrt(4000))
        sized = np.all(np.abs(noise.std(axis=0) / 0.2 - 1) < 6 / math.sqrt(2 * 4000))
        apart = np.all(np.abs(np.corrcoef(noise.T) - np.eye(3)) < 6 / math.sqrt(4000))
        return bool(centred and sized and apart)

    assert sound("right")
    assert not sound("wrong")


# --- the figures in the explanations ----------------------------------------------------------------------------------


def passes(*weights: float) -> str:
    """The share of white noise that a filter with this impulse response lets through."""
    return f"{100 * math.sqrt(sum(w * w for w in weights)):.0f} %"


def test_the_figures_of_the_filters_are_those_of_their_impulse_responses() -> None:
    sheet = passes(*(0.1 * 0.9**k for k in range(400)))
    swapped = passes(*(0.9 * 0.1**k for k in range(400)))
    history = f"{passes(0.1, 0.9)} of white noise comes through instead of {sheet}"
    assert f"{swapped} of its size instead of {sheet}" in ENTRIES["alpha-swapped"]["explanation"]
    assert history in ENTRIES["filters-input-history"]["explanation"]
    within = next(n for n in range(1, 100) if 0.9**n <= 0.01)
    assert f"takes {within} samples to come within 1 %" in ENTRIES["zero-initial-state"]["explanation"]


def test_the_figures_of_the_noises_are_those_of_their_distributions() -> None:
    assert f"{math.sqrt(3):.1f} times too small" in ENTRIES["not-gaussian"]["explanation"]
    assert f"{math.sqrt(2 / math.pi):.1f} standard deviations" in ENTRIES["noise-not-zero-mean"]["explanation"]
    assert f"scatter by {math.hypot(0.05, 0.1):.2f} instead of 0.05" in ENTRIES["bias-redrawn"]["explanation"]
    assert f"{0.05 / 0.05**2:.0f} times too small" in ENTRIES["variance-as-std"]["explanation"]
    assert f"it becomes {math.sqrt(0.05):.2f}" in ENTRIES["variance-as-std"]["explanation"]


def test_the_tilt_of_an_upright_sensor_is_zero_with_the_mended_lines_only() -> None:
    found = {v: example("tilt-sign-wrong", v, "accel")([0.0, 0.0, -9.81])["accel_roll"] for v in ("wrong", "right")}
    assert abs(found["right"]) == 0
    assert abs(found["wrong"]) == math.pi


def test_the_allan_deviation_of_white_noise_has_the_size_of_one_average() -> None:
    averages = np.random.default_rng(2).normal(0, 0.3, 100_000)
    found = {k: example(k, "wrong", "averages")(averages)["adev"] for k in ("std-not-allan", "allan-factor-missing")}
    right = example("std-not-allan", "right", "averages")(averages)["adev"]
    assert right == pytest.approx(0.3, rel=0.02)
    assert found["allan-factor-missing"] == pytest.approx(math.sqrt(2) * right)
    assert found["std-not-allan"] == pytest.approx(right, rel=0.02)  # white noise hides it, as the explanation says
    drift = np.linspace(0, 10, averages.size)
    assert example("std-not-allan", "wrong", "averages")(averages + drift)["adev"] > 5 * right
