"""Write the program of `imugrade repro`, which repeats the calls of a failed check with NumPy, MuJoCo and the student's files only.

Each private function that yields lines writes one kind of question, as `grader.labs.imu.worker` asks it in the sandbox.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grader.engine.check_catalog import Check
from grader.engine.check_runner import CheckRun, grading_order
from grader.engine.lab import Lab
from grader.engine.traces import Traces
from grader.labs.imu.compare import Array
from grader.labs.imu.filtering.explain import recursion
from grader.labs.imu.filtering.measure import ATOL, DEFAULT_ALPHA
from grader.labs.imu.student import Student

Lines = Iterator[str]
_COMPARE = f"""
def compare(name, mine, expected):
    mine, rows = np.asarray(mine), len(expected)
    if mine.shape != expected.shape:
        print(f"{{name}}: {{len(mine) if mine.shape else 'no'}} rows, and {{rows}} are expected")
        return
    differs = np.flatnonzero(~(np.abs(mine - expected).reshape(rows, -1) <= {ATOL}).all(axis=1))
    if len(differs) == 0:
        print(f"{{name}}: all rows as expected")
        return
    row = differs[0]
    print(f"{{name}}: row {{row}} is the first that differs, of {{rows}}: yours {{mine[row]}}, expected {{expected[row]}}")
"""
"""A function of the program: it prints the first row in which a series differs from the expected one."""


@dataclass(frozen=True)
class RecordedCall:
    """A call of the student's code (a question) that a failed check asked for, as `imugrade repro` writes it down.

    `op` is the kind of call, such as ``filter``; `fields` and `arrays` are its inputs. The arrays go into ``repro.npz`` as
    ``<name>_<number>``; `number` counts the check's calls. `expected` holds the correct arrays, see the function `expected`.
    """

    number: int
    op: str
    fields: Mapping[str, Any]
    arrays: Mapping[str, np.ndarray]
    expected: Mapping[str, np.ndarray] = field(default_factory=dict)

    def given(self, name: str) -> str:
        """Return the Python expression with which the generated program reads the array `name` of this call."""
        return f'given["{name}_{self.number}"]'

    @property
    def kept(self) -> dict[str, np.ndarray]:
        """The arrays of this call by their names in `repro.npz`: inputs, `expected` and, if a model is sent, its MJCF text."""
        model = {"model": np.array(self.fields["model"])} if "model" in self.fields else {}
        expected = {f"expected_{name}": array for name, array in self.expected.items()}
        return {f"{name}_{self.number}": array for name, array in {**self.arrays, **model, **expected}.items()}

    @property
    def module(self) -> str:
        """The name of the student's module in the generated program."""
        return self._dotted if self._can_be_imported else "file_" + re.sub(r"\W", "_", self._dotted)

    @property
    def import_line(self) -> str:
        """The line of the generated program that imports the student's file, even `imu-reader.py`, which `import` cannot name."""
        if self._can_be_imported:
            return f"import {self.module}"
        return f"{self.module} = importlib.import_module({self._dotted!r})"

    @property
    def _dotted(self) -> str:
        return str(self.fields["path"]).removesuffix(".py").replace("/", ".")

    @property
    def _can_be_imported(self) -> bool:
        return all(part.isidentifier() and not keyword.iskeyword(part) for part in self._dotted.split("."))


class Recorder(Student):
    """Session with the sandbox that also records which calls each check asks for, so that `imugrade repro` can repeat them."""

    now = ""

    def __init__(self, *args: Any, truth: Traces, **options: Any) -> None:
        super().__init__(*args, truth=truth, **options)
        self.truth = truth
        self._asking: list[Any] = []  # keys of the questions that are being answered, the innermost last
        self._questions: dict[Any, tuple[str, Mapping[str, Any], Mapping[str, np.ndarray]]] = {}  # by key
        # By a check's id or a question's key, the keys of the questions that it asked.
        self._asked_by: dict[Any, list[Any]] = {}

    def once(self, key: Any, ask: Callable[[], Any]) -> Any:
        """Return question `key`'s answer, from `ask` if new; record it under the question that led to it, else the check."""
        keys = self._asked_by.setdefault(self._asking[-1] if self._asking else self.now, [])
        keys += [key] if key not in keys else []
        self._asking.append(key)
        try:
            return super().once(key, ask)
        finally:
            self._asking.pop()

    def ask(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> Any:
        if self._asking and op in WRITTEN:
            self._questions[self._asking[-1]] = (op, fields, arrays or {})
        return super().ask(op, fields, arrays)

    def questions(self, check_id: str) -> list[RecordedCall]:
        """Return the calls that a check asked for, in order, including those whose answers an earlier check had already got."""
        keys = [key for key in dict.fromkeys(self._below(check_id)) if key in self._questions]
        asked = [(number, *self._questions[key]) for number, key in enumerate(keys, 1)]
        return [RecordedCall(*each, expected=expected(*each[1:], self.truth)) for each in asked]

    def _below(self, key: Any) -> Iterator[Any]:
        """Yield the keys of the calls that were made for `key`, a check or another call, at any depth."""
        for each in self._asked_by.get(key, ()):
            yield each
            yield from self._below(each)


class Watched(CheckRun):
    """Run of the checks that tells the session, a `Recorder`, which check begins, so that it records each check's calls.

    It ends with the criterion `until`, as those after it do not change its outcome; None runs all.
    """

    def __init__(self, lab: Lab, student: Recorder, truth: Traces, until: str | None) -> None:
        super().__init__(lab, student, truth, None)
        self._until = until

    def wants(self, this: Check) -> bool:
        last = this.criterion if self._until is None else self._until
        return super().wants(this) and grading_order(self._lab, this.criterion) <= grading_order(self._lab, last)

    def begin(self, this: Check) -> None:
        self.student.now = this.id  # type: ignore[attr-defined] # a Recorder
        super().begin(this)


def expected(op: str, fields: Mapping[str, Any], arrays: Mapping[str, Array], truth: Traces) -> dict[str, Array]:
    """Return the correct arrays, to compare with, of a "filter" call or a "simulate" call whose run `truth` holds; else {}."""
    if op == "filter":
        return {f"output_{i}": _filtered(case, arrays) for i, case in enumerate(fields["cases"])}
    if op == "simulate" and "gravity" not in arrays:
        scenario = truth["push_dirty" if "qpos" in arrays else "push"]
        timestep, steps = scenario["time"][0], round(fields["duration_s"] / scenario["time"][0])
        if (fields["timestep"] or timestep) == timestep and steps <= len(scenario["time"]):
            # not the times: those before and those after the steps are both right
            return {name: scenario[name][:steps] for name in ("acceleration", "angular_velocity")}
    return {}


def _filtered(case: Mapping[str, Any], arrays: Mapping[str, Array]) -> Array:
    x, alpha = arrays[case["input"]], DEFAULT_ALPHA if case["alpha"] is None else case["alpha"]
    before = x[0] if case["initial"] is None else arrays[case["initial"]]
    return recursion(alpha, x, alpha * x[0] + (1 - alpha) * before)


def program(check_id: str, said: str, questions: Sequence[RecordedCall], folder: str) -> str:
    """Return the text of a program that repeats the calls of a failed check on the student's machine.

    Parameters
    ----------
    said : the feedback of the check, which becomes the program's docstring
    questions : the calls of the check, all of ``.py`` files, because the program imports the files that it calls
    folder : relative path from the program to the student's files
    """
    lines = [
        f'"""{check_id} once more: your own code on the same input, which is in repro.npz beside this file.',
        "",
        *(line.replace("\\", "/").replace('"""', "'''") for line in said.splitlines()),
        '"""',
        "",
        "import importlib",
        "import os",
        "import sys",
        "from pathlib import Path",
        "",
        *(["import mujoco"] if any("model" in each.fields for each in questions) else []),
        "import numpy as np",
        "",
        "HERE = Path(__file__).resolve().parent",
        f"sys.path.insert(0, str(HERE / {folder!r}))",
        "os.chdir(HERE)  # the lab's model lies here where the sheet loads it, and what is saved comes here",
        'given = np.load(HERE / "repro.npz")',
        *(_COMPARE.splitlines() if any(each.expected for each in questions) else []),
    ]
    for question in questions:
        lines += ["", f"# {question.number}", question.import_line, "", *WRITTEN[question.op](question)]
    return "\n".join(lines) + "\n"


def _simulation(question: RecordedCall) -> Lines:
    yield f"model = mujoco.MjModel.from_xml_string(str({question.given('model')}))"
    yield "data = mujoco.MjData(model)"


def _state(question: RecordedCall, row: int = 0) -> Lines:
    yield f"data.qpos[:], data.qvel[:] = {question.given('qpos')}[{row}], {question.given('qvel')}[{row}]"
    yield "mujoco.mj_forward(model, data)"


def _read(question: RecordedCall) -> Lines:
    yield from _simulation(question)
    yield f"for accel_id, gyro_id in {question.given('pairs')}.tolist():"
    yield f"    for qpos, qvel in zip({question.given('qpos')}, {question.given('qvel')}):"
    yield "        mujoco.mj_resetData(model, data)"
    yield "        data.qpos[:], data.qvel[:] = qpos, qvel"
    yield "        mujoco.mj_forward(model, data)"
    yield f"        mine = {question.module}.get_imu_readings(model, data, accel_id, gyro_id)"
    yield '        print(f"ids {accel_id} and {gyro_id}: yours", *mine)'
    yield '        print("   the sensors say", data.sensor(accel_id).data, data.sensor(gyro_id).data)'


def _simulate(question: RecordedCall) -> Lines:
    fields, arrays = question.fields, question.arrays
    yield from _simulation(question)
    if fields["timestep"]:
        yield f"model.opt.timestep = {fields['timestep']}"
    if "gravity" in arrays:
        yield f"model.opt.gravity[:] = {question.given('gravity')}"
    if "qpos" in arrays:
        yield f"data.qpos[:], data.qvel[:] = {question.given('qpos')}, {question.given('qvel')}"
        yield f"data.time = {fields['time_s']}"
        yield "mujoco.mj_forward(model, data)"
    for name in ("accel_id", "gyro_id"):
        yield f'vars({question.module}).setdefault("{name}", {fields[name]})  # where your function reads it from its file'
    yield f"recording = {question.module}.simulate_and_collect(model, data, {fields['duration_s']})"
    yield "for name, series in recording.items():"
    yield "    print(name, np.shape(series))"
    yield "    print(np.asarray(series)[:3])"
    for name in question.expected:
        yield f'if "{name}" in recording:'
        yield f'    compare("{name}", recording["{name}"], {question.given(f"expected_{name}")})'


def _noisy(question: RecordedCall, std: Mapping[str, Any], biases: str) -> str:
    ids = f"{question.fields['accel_id']}, {question.fields['gyro_id']}"
    stds = f"accel_noise_std={std['accel_noise_std']}, gyro_noise_std={std['gyro_noise_std']}"
    return f"{question.module}.NoisyIMU(model, data, {ids}, {stds}{biases})"


def _truth(question: RecordedCall) -> str:
    readings = ", ".join(f"data.sensor({question.fields[name]}).data" for name in ("accel_id", "gyro_id"))
    return f'print("the sensors say", {readings})'


def _noise(question: RecordedCall) -> Lines:
    given = {"accel_bias", "gyro_bias"} & question.arrays.keys()
    biases = "".join(f", {name}={question.given(name)}" for name in sorted(given))
    yield from (*_simulation(question), *_state(question))
    yield f"imu = {_noisy(question, question.fields, biases)}"
    yield f"reads = np.array([imu.read() for _ in range({question.fields['reads']})])  # reads, sensor, axis"
    yield _truth(question)
    yield 'print("yours, mean:", *reads.mean(axis=0))'
    yield 'print("yours, standard deviation:", *reads.std(axis=0, ddof=1))'


def _noise_twins(question: RecordedCall) -> Lines:
    yield from _simulation(question)
    for number, (stds, row) in enumerate(zip(question.fields["twins"], question.fields["states"], strict=True)):
        yield from _state(question, row)
        yield _truth(question)
        names = enumerate(("accel_bias", "gyro_bias") if "biases" in question.arrays else ())
        biases = "".join(f", {name}={question.given('biases')}[{number}, {sensor}]" for sensor, name in names)
        yield "np.random.seed(1234)"
        yield f"imu = {_noisy(question, stds, biases)}"
        yield f'print("instance {number + 1}:", *np.array([imu.read() for _ in range({question.fields["reads"]})])[0])'


def _default_bias(question: RecordedCall) -> Lines:
    count = question.fields["instances"]
    yield from (*_simulation(question), *_state(question))
    yield f"reads = np.array([{_noisy(question, question.fields, '')}.read() for _ in range({count})])"
    yield _truth(question)
    yield 'print("one read of each instance, mean:", *reads.mean(axis=0))'
    yield 'print("one read of each instance, standard deviation:", *reads.std(axis=0, ddof=1))'


_HANDLING = {
    "plain": (),
    "spoil_input": ("    measurement[:] = 1000  # the caller uses its array for something else",),
    "spoil_output": ("    out[...] = 1000  # the caller uses what came out for something else",),
    "beside": ("    other.update(100 - 3 * measurement)  # another instance lives beside it",),
}


def _filter(question: RecordedCall) -> Lines:
    for i, case in enumerate(question.fields["cases"]):
        options = {} if case["alpha"] is None else {"alpha": repr(case["alpha"])}
        options |= {} if case["initial"] is None else {"initial_value": question.given(case["initial"])}
        yield f"low_pass = {_low_pass(question, options)}"
        if case["handling"] == "beside":
            yield f"other = {_low_pass(question, options | {'alpha': repr(1 - case['alpha'])})}"
        yield "mine = []"
        yield f"for measurement in {question.given(case['input'])}.copy():"
        yield "    out = low_pass.update(measurement)"
        yield "    mine.append(np.array(out))"
        yield from _HANDLING[case["handling"]]
        yield f'print("in ", {question.given(case["input"])}[:3].tolist())'
        yield 'print("out", [out.tolist() for out in mine[:3]])'
        yield f'compare("output", mine, {question.given(f"expected_output_{i}")})'


def _low_pass(question: RecordedCall, options: Mapping[str, str]) -> str:
    return f"{question.module}.LowPassFilter({', '.join(f'{name}={value}' for name, value in options.items())})"


def _plot(question: RecordedCall) -> Lines:
    series = ", ".join(f"{name!r}: {question.given(key)}" for name, key in question.fields["keys"].items())
    yield f"{question.module}.plot_imu_data({{{series}}})  # draws and saves the picture that was judged"


def _tilt(question: RecordedCall) -> Lines:
    for case in question.fields["cases"]:
        yield f"tilt = {question.module}.ComplementaryFilter({case['dt']})"
        series = f"zip({question.given(case['accel'])}, {question.given(case['gyro'])})"
        yield f"mine = np.array([tilt.update(accel, gyro) for accel, gyro in {series}])"
        yield 'print("roll and pitch, first and last:", mine[0], mine[-1])'


def _allan(question: RecordedCall) -> Lines:
    rate = question.fields["sample_rate_hz"]
    yield f"taus, adev = {question.module}.allan_deviation({question.given('samples')}, {rate})"
    yield "print(np.column_stack([taus, adev]))"


def _imus(question: RecordedCall) -> Lines:
    yield from (*_simulation(question), *_state(question))
    yield f"for place, reading in {question.module}.read_all_imus(model, data).items():"
    yield "    print(place, *reading)"


WRITTEN: Mapping[str, Callable[[RecordedCall], Lines]] = {
    "read": _read,
    "simulate": _simulate,
    "noise": _noise,
    "noise_twins": _noise_twins,
    "default_bias": _default_bias,
    "filter": _filter,
    "plot": _plot,
    "tilt": _tilt,
    "allan": _allan,
    "imus": _imus,
}
