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

FIELDS = ["title", "hint", "explanation", "step", "wrong", "right"]
RAISED = [
    "array-as-condition",
    "name-missing",
    "sensor-not-found",
    "index-out-of-bounds",
    "not-written",
    "unknown-name",
]
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


VAIN = "Invalid name 'imu'. Valid names: ['torso']"


@pytest.mark.parametrize(
    ("exception", "message", "line", "name", "key"),
    [
        ("IndexError", "whatever Python or NumPy says", None, "", "index-out-of-bounds"),
        ("NameError", "whatever Python says", None, "", "unknown-name"),
        ("UnboundLocalError", "whatever Python says", None, "", "unknown-name"),
        ("KeyError", f'"{VAIN}"', None, "", "raises"),
        ("ValueError", "whatever NumPy says", None, "", "raises"),
        ("NotImplementedError", "TODO", None, "", "not-written"),
        ("KeyError", VAIN, "adr = model.sensor('imu').adr[0]", "", "sensor-not-found"),
        ("KeyError", "whatever another MuJoCo says", "return data.sensor (name).data", "", "sensor-not-found"),
        ("KeyError", VAIN, "settings['sensor']", "", "raises"),
        ("KeyError", "whatever another MuJoCo says", "body = model.body('imu')", "", "raises"),
        ("ValueError", "in any words", "if self.value == None:", "", "array-as-condition"),
        ("ValueError", "in any words", "if not self.value:", "", "array-as-condition"),
        ("ValueError", "in any words", "self.bias = accel_bias or np.zeros(3)", "", "array-as-condition"),
        ("ValueError", "in any words", "bias = given if given else rng.normal(0, 0.1, 3)", "", "array-as-condition"),
        ("ValueError", "in any words", "bias = given if given is not None else rng.normal(0, -1, 3)", "", "raises"),
        ("ValueError", "in any words", "if alpha > 1: raise ValueError('alpha')", "", "raises"),
        ("ValueError", "in any words", "self.value = np.array(measurement).reshape(4)", "", "raises"),
        ("AttributeError", "in any words", None, "update", "name-missing"),
        ("AttributeError", "in any words", None, "read", "name-missing"),
        ("AttributeError", "in any words", None, "alpha", "raises"),
    ],
)
def test_what_was_raised_shows_a_mistake(exception: str, message: str, line: str | None, name: str, key: str) -> None:
    place = (None, None) if line is None else ("imu_reader.py", 3)
    assert mistake_of(Fault(exception, message, *place, line, name), catalogue(LAB)) == key


# --- the file ---------------------------------------------------------------------------------------------------------


def test_no_name_is_used_in_two_groups() -> None:
    assert len(ENTRIES) == sum(len(entries) for entries in MISTAKES.values())


@every_mistake
def test_an_entry_has_all_fields_each_within_its_limits(key: str) -> None:
    """A hint is one or two short sentences, an explanation two to five, an example one to four lines of Python."""
    entry = ENTRIES[key]
    assert [field for field in entry if field not in CHARGING] == FIELDS + ["raised"] * (key in RAISED)
    assert all(isinstance(entry[field], str) and entry[field].strip() for field in FIELDS if field != "step")
    for field, least, most in (("hint", 1, 2), ("explanation", 2, 5)):
        assert entry[field].endswith(".")
        assert "\n" not in entry[field]
        assert least <= sentences(entry[field]) <= most
    assert len(entry["hint"]) <= 160
    for version in ("wrong", "right"):
        lines = entry[version].splitlines()
        assert 1 <= len(lines) <= 4
        assert max(map(len, lines)) <= 110
        ast.parse(entry[version])


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


@pytest.mark.parametrize("group", MISTAKES)
def test_the_step_is_one_of_the_criterion_and_hint_and_explanation_name_it(group: str) -> None:
    for key, entry in MISTAKES[group].items():
        step = entry["step"]
        assert step in STEPS.get(group, {None, 1, 2}), key
        if step is not None:
            assert f"Lab 04-01, Step {step}" in entry["explanation"], key
            assert f"Step {step}" in entry["hint"], key


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


LOOP = "model, data, n_steps, accelerations, angular_velocities, get_imu_readings, accel_id, gyro_id"


def collected(key: str, version: str, model: Any) -> np.ndarray:
    """The accelerations that a collecting loop with these lines leaves behind, ten samples after a push."""
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    rows: Any = [] if "append" in ENTRIES[key][version] else np.zeros((10, 3))
    adr = model.sensor("torso_accelerometer").adr[0]

    def reader(*_: Any) -> tuple[Any, Any]:
        return data.sensordata[adr : adr + 3].copy(), np.zeros(3)

    done = example(key, version, LOOP)(model, data, 10, rows, np.zeros((10, 3)), reader, 0, 0)
    return np.array(done["accelerations"])


def test_the_loops_go_wrong_as_their_explanations_say(model: Any) -> None:
    loops = ["read-before-step", "aliased-rows", "rows-left-zero"]
    truth, *others = (collected(key, "right", model) for key in loops)
    assert all(np.array_equal(truth, other) for other in others)
    assert len(np.unique(truth[:, 0])) == 10
    late, aliased, short = (collected(key, "wrong", model) for key in loops)
    assert np.array_equal(late, [np.zeros(3), *truth[:-1]])
    assert np.array_equal(aliased, [truth[-1]] * 10)
    assert np.array_equal(short, [*truth[:-1], np.zeros(3)])


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
