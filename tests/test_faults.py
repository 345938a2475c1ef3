"""The table of faults: complete, within its limits, and true: its examples are run."""

from __future__ import annotations

import ast
import importlib
import math
import re
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args, get_type_hints

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest

from grader.engine import rubric
from grader.engine.charging import Judge
from grader.engine.faults import catalogue, rows
from grader.engine.feedback import fault_of
from grader.engine.findings import StudentError
from grader.labs.imu.bonuses import checks as bonuses
from grader.labs.imu.lab import LAB

ENTRIES = catalogue(LAB)
PARTS = [importlib.import_module(f"grader.labs.imu.{part.id}.checks").JUDGE for part in LAB.parts]
PARTS += [each for each in vars(bonuses).values() if isinstance(each, Judge)]
STEPS = {"sensor_access": {2}, "data_collection": {3}, "visualization": {4, 6}, "noise_model": {5}, "filtering": {6}}


def example(key: str, version: str, parameters: str) -> Callable[..., Any]:
    """The lines of an example as the body of a function, which returns its local names or what the lines return."""
    body = textwrap.indent(getattr(ENTRIES[key], version), "    ")
    namespace: dict[str, Any] = {"np": np, "mujoco": mujoco}
    exec(f"def lines({parameters}):\n{body}\n    return locals()", namespace)
    return namespace["lines"]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("exception", "line", "name", "key"),
    [
        ("IndexError", None, "", "index-out-of-bounds"),
        ("UnboundLocalError", None, "", "unknown-name"),
        ("NotImplementedError", None, "", "not-written"),
        ("KeyError", None, "", "raises"),
        ("KeyError", "return data.sensor (name).data", "", "sensor-not-found"),
        ("KeyError", "settings['sensor']", "", "raises"),
        ("KeyError", "body = model.body('imu')", "", "raises"),
        ("ValueError", "if self.value == None:", "", "array-as-condition"),
        ("ValueError", "if not self.value:", "", "array-as-condition"),
        ("ValueError", "self.bias = accel_bias or np.zeros(3)", "", "array-as-condition"),
        ("ValueError", "bias = given if given else rng.normal(0, 0.1, 3)", "", "array-as-condition"),
        ("ValueError", "bias = given if given is not None else rng.normal(0, -1, 3)", "", "raises"),
        ("ValueError", "if alpha > 1: raise ValueError('alpha')", "", "raises"),
        ("AttributeError", None, "update", "name-missing"),
        ("AttributeError", None, "alpha", "raises"),
    ],
)
def test_what_was_raised_shows_a_fault(exception: str, line: str | None, name: str, key: str) -> None:
    """Whatever its text says: Python, NumPy and MuJoCo change it."""
    place = (None, None) if line is None else ("imu_reader.py", 3)
    assert fault_of(StudentError(exception, "Invalid name 'imu'", *place, line, name), catalogue(LAB)) == key


# --- the file ---------------------------------------------------------------------------------------------------------


def test_no_name_stands_twice_in_the_file() -> None:
    names = re.findall(r"(?m)^  (\S+):", (LAB.folder / "faults.yaml").read_text(encoding="utf-8"))
    assert len(names) == len(set(names)) == len(rows(LAB))


@pytest.mark.parametrize("key", ENTRIES)
def test_an_entry_has_all_fields_each_within_its_limits(key: str) -> None:
    """A hint is one or two short sentences, an explanation two to five, an example one to four lines of Python."""
    entry = ENTRIES[key]
    assert entry.title
    for text, least, most in ((entry.hint, 1, 2), (entry.explanation, 2, 5)):
        assert text.endswith(".")
        assert "\n" not in text
        assert least <= len(re.findall(r"[.?!](?=\s|$)", text)) <= most
    assert len(entry.hint) <= 160
    for code in (entry.wrong, entry.right):
        lines = code.splitlines()
        assert 1 <= len(lines) <= 4
        assert max(map(len, lines)) <= 110
        ast.parse(code)
    assert entry.step in STEPS.get(entry.group, {None, 1, 2})
    if entry.step is not None:
        assert f"Lab 04-01, Step {entry.step}" in entry.explanation
        assert f"Step {entry.step}" in entry.hint


def test_what_a_fault_deducts_are_shares_of_checks_that_there_are() -> None:
    known = {weight.id for weight in rubric.load(LAB).checks}
    for key, row in rows(LAB).items():
        group = key.partition(".")[0] if row.group == "checks" else row.group
        assert {name if "." in name else f"{group}.{name}" for name in row.deducts} <= known, key
        assert all(0 <= share <= 1 for share in row.deducts.values()), key
        assert row.group != "checks" or key in known, key


SAMPLES: dict[Any, object] = {str: "text", int: 2, float: 1.5}
"""A value of each type that a number of a deviation may have."""


def numbers_of(measure: Callable[..., Any]) -> dict[str, object]:
    """Return a value for each number that a measure's deviations have, by the type that it returns."""
    deviation = get_args(get_type_hints(measure)["return"])[0]
    return {key: SAMPLES[kind] for key, kind in get_type_hints(get_args(deviation)[0]).items()}


def shown() -> Iterator[tuple[str, str, dict[str, object]]]:
    """Yield every row with each property in which it may show, and that property's numbers."""
    for part in PARTS:
        for name, (_, measure) in part.checks.items():
            yield name, name, numbers_of(measure)
        for reason in part.reasons:
            _, measure = part.checks.get(f"{part.id}.{reason.of}", (None, part.others.get(reason.of)))
            assert measure is not None, reason
            yield reason.cause, reason.of, numbers_of(measure)


@pytest.mark.quick
def test_every_text_of_a_fault_finds_its_numbers_wherever_the_fault_shows() -> None:
    known = {(row, place): numbers for row, place, numbers in shown()}
    unnumbered = {(key, "no property"): {} for key in rows(LAB).keys() - {row for row, _ in known}}
    for (key, place), numbers in (known | unnumbered).items():
        for text in (rows(LAB)[key].expected, rows(LAB)[key].got):
            assert "{" not in text.format_map(numbers), (key, place)


def test_a_fault_that_costs_points_at_several_checks_has_a_public_name() -> None:
    """The report puts the checks of one fault together by its name."""
    for key, row in rows(LAB).items():
        costs = [name for name, share in row.deducts.items() if share and "." not in name]
        assert len(costs) < 2 or key in ENTRIES, key


# --- what the words and the lines speak of exists ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def model() -> Any:
    path = Path(__file__).parent.parent / "reference" / "models" / "humanoid-sensors.xml"
    return mujoco.MjModel.from_xml_path(str(path))


@pytest.fixture
def data(model: Any) -> Any:
    """The robot a tenth of a second after a push: every channel of every IMU is alive."""
    data = mujoco.MjData(model)
    data.qvel[:6] = [0.5, 0.3, 0.0, 0.1, 0.2, 0.3]
    mujoco.mj_step(model, data, nstep=50)
    return data


def test_every_attribute_that_words_and_examples_name_exists(model: Any, data: Any) -> None:
    known = {"mujoco": mujoco, "model": model, "data": data, "np": np, "plt": plt}
    for key, entry in ENTRIES.items():
        text = "\n".join((entry.hint, entry.explanation, entry.wrong, entry.right))
        for owner, chain in re.findall(r"(?<![\w.])(mujoco|model|data|np|plt)\.(\w+(?:\.\w+)*)", text):
            target = known[owner]
            for name in chain.split("."):
                assert hasattr(target, name), f"{key}: {owner}.{chain}"
                target = getattr(target, name)


# --- the examples, run ------------------------------------------------------------------------------------------------

READER = "model, data, accel_sensor_id, gyro_sensor_id, accel_adr, gyro_adr, acceleration, angular_velocity"
READERS = [key for key, entry in ENTRIES.items() if entry.group == "sensor_access" and key != "cached-reading"]


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
    rows: Any = [] if "append" in getattr(ENTRIES[key], version) else np.zeros((10, 3))
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


@pytest.mark.parametrize("key", FILTERS)
def test_the_mended_filter_follows_the_sheets_recursion_and_the_wrong_one_does_not(key: str) -> None:
    samples = np.random.default_rng(1).normal([0.0, 1.0, -9.81], 0.5, (6, 3))
    truth = [samples[0]]
    for sample in samples[1:]:
        truth.append(0.3 * sample + 0.7 * truth[-1])

    def follows(version: str) -> bool:
        given = samples.copy()
        state = SimpleNamespace(alpha=0.3, value=given[0].copy(), previous=given[0].copy())
        update, outputs = example(key, version, "self, measurement"), []
        for sample in given[1:]:
            found = update(state, sample)
            outputs.append(found.get("output", state.value) if isinstance(found, dict) else found)
        return np.allclose(outputs, truth[1:], rtol=0, atol=1e-12) and np.array_equal(given, samples)

    assert follows("right")
    assert not follows("wrong")


@pytest.mark.parametrize(
    "key", ["variance-as-std", "std-ignored", "same-noise-on-axes", "not-gaussian", "noise-not-zero-mean"]
)
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
