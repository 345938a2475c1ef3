"""A question is known by all that it asks: the same one is asked once, and one that differs in anything is another."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from grader.engine.question import Question
from grader.labs.imu.bonuses.allan_variance import allan
from grader.labs.imu.bonuses.complementary_filter import TiltCase, tilt
from grader.labs.imu.bonuses.live_plot import live
from grader.labs.imu.bonuses.multiple_imus import imus
from grader.labs.imu.replies import RULES
from grader.labs.imu.robot import robot_of
from grader.labs.imu.student import FilterCase, Student
from grader.labs.imu.worker import HANDLERS
from tests.judging.fake_students import truth

pytestmark = pytest.mark.quick


def test_a_question_that_differs_in_anything_is_another() -> None:
    pairs, stds = np.array([[0, 1]]), np.array([0.1, 0.2])
    fields, arrays = {"reads": 3, "model": "x" * 5000}, {"pairs": pairs, "stds": stds}
    questions = [
        Question(op="read", about="reader", becomes=str, fields=fields, arrays=arrays),
        Question(op="read", about="NoisyIMU", becomes=str, fields=fields, arrays=arrays),
        Question(op="read", about="reader", becomes=str, fields={**fields, "model": "x" * 5001}, arrays=arrays),
        *(
            Question(op="read", about="reader", becomes=str, fields=fields, arrays={**arrays, **changed})
            for changed in ({"pairs": pairs.T}, {"stds": stds.view(np.int64)}, {"stds": pairs, "pairs": stds})
        ),
    ]
    assert len({question.key for question in questions}) == len(questions)


class Noting(Student):
    """Notes what it is asked, and answers nothing."""

    def __init__(self) -> None:
        self.robot, self.keys = robot_of(truth()), []  # type: ignore[misc]

    def once(self, key: Any, ask: Callable[[], Any]) -> Any:
        self.keys.append(key)
        return np.zeros((5, 6))


_VECTORS, _STATE = np.arange(15.0).reshape(5, 3), {"qpos": np.zeros((1, 4)), "qvel": np.zeros((1, 3))}
_NOISE = {**_STATE, "ids": (1, 2), "reads": 3, "stds": (0.1, 0.2)}
_OTHER: Mapping[str, Any] = {
    "model": "<mujoco/>", "qpos": np.ones((1, 4)), "qvel": np.ones((1, 3)), "pairs": np.array([[2, 1]]), "ids": (2, 1),
    "duration_s": 2.0, "timestep": 0.004, "dirty": (np.ones(4), np.ones(3), 1.0), "gravity": np.ones(3), "reads": 4,
    "stds": (0.1, 0.3), "biases": None, "instances": 9, "cases": [FilterCase(_VECTORS, alpha=0.4)], "steps": 4,
    "course": {"qpos": np.ones(3)}, "sheet": {"time": _VECTORS}, "data": {"t": _VECTORS}, "samples": _VECTORS[:, 0],
    "sample_rate_hz": 50.0, "push": 0.1, "own_form": True, "one_draw": True,
}  # fmt: skip
_ASKED: Mapping[Any, dict[str, Any]] = {
    Student.read: {"model": "<m/>", **_STATE, "pairs": np.array([[1, 2]])},
    Student.simulate: {"duration_s": 1.0, "ids": (1, 2), "timestep": None, "dirty": None, "gravity": None},
    Student.replay: {"course": {"qpos": np.zeros(3)}, "steps": 3},
    Student.read_along: {"course": {"qpos": np.zeros(3)}, "steps": 5, "ids": (1, 2)},
    Student.noise: {**_NOISE, "biases": (np.zeros(3), np.ones(3))},
    Student.noise_twins: {**_NOISE, "stds": [(0.1, 0.2)], "biases": np.zeros((1, 2, 3)), "states": [0]},
    Student.default_bias: {**_STATE, "ids": (1, 2), "stds": (0.1, 0.2), "instances": 8, "one_draw": False},
    Student.filter: {"cases": [FilterCase(_VECTORS, alpha=0.3)]},
    Student.plot: {"data": {"time": _VECTORS + 1}, "sheet": {"time": _VECTORS + 1}, "ids": (1, 2), "own_form": False},
    tilt: {"cases": [TiltCase(0.1, _VECTORS, _VECTORS)]},
    allan: {"samples": _VECTORS, "sample_rate_hz": 100.0},
    imus: {"model": "<m/>", **_STATE},
    live: {"model": "<m/>", "ids": (1, 2), "duration_s": 1.0, "timestep": 0.002, "push": 0.5},
}
_CHANGED: Mapping[Any, dict[str, Any]] = {
    Student.noise_twins: {"stds": [(0.1, 0.3)], "biases": np.ones((1, 2, 3)), "states": [1]},
    tilt: {"cases": [TiltCase(0.2, _VECTORS, _VECTORS)]},
}


@pytest.mark.parametrize("ask", _ASKED, ids=lambda ask: ask.__name__)
def test_every_parameter_of_every_question_makes_it_another(ask: Callable[..., Any]) -> None:
    parameters = set(inspect.signature(ask).parameters) - {"self", "student", "called"}
    assert parameters == _ASKED[ask].keys(), "a new parameter wants a value here, and another one in _OTHER"
    student = Noting()
    ask(student, **_ASKED[ask])
    ask(student, **_ASKED[ask])
    assert len(set(student.keys)) == 1
    for name in parameters:
        ask(student, **{**_ASKED[ask], name: {**_OTHER, **_CHANGED.get(ask, {})}[name]})
    assert len(set(student.keys)) == 1 + len(parameters)


def test_every_question_has_a_handler_a_rule_and_its_place_here() -> None:
    asked_here = {ask.__name__ for ask in _ASKED} - {"replay"}
    assert asked_here == RULES.keys()
    # no student's code runs beside a replay
    assert HANDLERS.keys() - RULES.keys() == {"replay"}, "a handler without a rule"
    assert RULES.keys() <= HANDLERS.keys()
