"""What functions read as globals stands for what they are given, and who passes over what it is given is told of."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import mujoco
import pytest

from grader.labs.imu.worker import calls, own_globals
from grader.worker import submission

pytestmark = pytest.mark.quick
Load = Callable[[str], Any]


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch) -> Load:
    """Makes a submission's only file of this code, which has a model and data of its own."""

    def loaded(code: str) -> Any:
        program = ModuleType("program")
        model, data = _scene()
        vars(program).update(model=model, data=data, mujoco=mujoco)
        exec(code, vars(program))
        submission.STATE.modules["program.py"] = program
        return program

    monkeypatch.setattr(submission.STATE, "modules", {})
    return loaded


def _scene() -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    return model, mujoco.MjData(model)


BOTH, TOLD = ["model", "data"], ["global model", "global data"]
READS = {
    "both": ("def f(m, d):\n    return model, data", BOTH, TOLD),
    "both, and the parameters": ("def f(m=None, d=None):\n    return (m or model), (d or data)", BOTH, []),
    "both, without parameters": ("def f():\n    return model, data", BOTH, []),
    "in a method": ("class C:\n    def read(self):\n        return model, data\nf = lambda m, d: C().read()", BOTH, []),
    "in a helper": ("def helper():\n    return data.time\ndef f(m, d):\n    return m.nq, helper()", ["data"], ["global data"]),
    "by another name": ("simulation = data\ndel data\ndef f(m, d):\n    return model, simulation", BOTH, TOLD),
    "where nothing has set them": ("del model, data\ndef f(m, d):\n    return model, mj_data", BOTH, TOLD),
    "one beside one that nothing has set": ("def f(m, d):\n    return model, data, mj_data", [*BOTH, "data"], TOLD),
    "an attribute of that name": ("class C:\n    data = None\ndef f(m, d):\n    return C.data, m", [], []),
    "one of two": ("other = mujoco.MjData(model)\ndef f(m, d):\n    return model, data, other", ["model"], TOLD),
}  # fmt: skip


@pytest.mark.parametrize(("code", "meant", "told"), READS.values(), ids=READS)
def test_globals_that_functions_read_stand_for_what_is_given_and_who_passes_over_it_is_told_of(
    load: Load, code: str, meant: list[str], told: list[str]
) -> None:
    program, (model, data) = load(code), _scene()
    before = dict(vars(program))
    with own_globals.set_model_and_data(model, data):
        stands = [each for each in vars(program).values() if each is model or each is data]
        assert own_globals.globals_read_instead(program.f, (calls.MODEL, calls.DATA)) == told
    assert [{id(model): "model", id(data): "data"}[id(each)] for each in stands] == meant
    assert vars(program) == before


PLOTS = {
    "its parameter": ("imu_data = {}\ndef f(imu_data):\n    return imu_data", [], False),
    "a global": ("imu_data = {}\ndef f(d):\n    return imu_data", ["global imu_data"], True),
    "a global that nothing has set": ("def f():\n    return recorded", [], True),
    "one of two": ("imu_data, results = {}, {}\ndef f():\n    return imu_data, results", [], False),
    "the words of a legend": ("DATA_NAMES = ('x', 'y')\ndef f(time, acceleration):\n    return DATA_NAMES", [], False),
}


@pytest.mark.parametrize(("code", "told", "stands"), PLOTS.values(), ids=PLOTS)
def test_the_recording_stands_for_the_global_that_a_plot_reads(
    load: Load, code: str, told: list[str], stands: bool
) -> None:
    program = load(code)
    before, recording = dict(vars(program)), {"time": [0.0]}
    with own_globals.set_recording(recording, program.f, calls.PLOTTER[:4]) as read_instead:
        assert read_instead == told
        assert any(value is recording for value in vars(program).values()) == stands
    assert vars(program) == before


MEASURES = {
    "the measurement": ("def update(x):\n    return x", 5, []),
    "a global in its place": ("accel = 1\ndef update(x):\n    return accel", 5, ["global measurement"]),
    "one, and nothing is given": ("gyro = 1\ndef update():\n    return gyro", 5, ["global measurement"]),
    "a bias": ("accel_bias = 1\ndef update(x):\n    return accel_bias", 1, []),
    "one of two": ("accel, gyro = 1, 2\ndef update(x):\n    return accel + gyro", 3, []),
}


@pytest.mark.parametrize(("code", "got", "told"), MEASURES.values(), ids=MEASURES)
def test_a_global_that_a_filter_reads_stands_for_what_it_is_given(
    load: Load, code: str, got: object, told: list[str]
) -> None:
    program = load(code)
    before = dict(vars(program))
    measuring, read_instead = own_globals.measurement_global(program.update)
    with measuring(5):
        assert program.update(*([] if "update()" in code else [5])) == got
    assert (read_instead, vars(program)) == (told, before)
