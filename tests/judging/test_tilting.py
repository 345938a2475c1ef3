"""What a filter of tilt does with its two sensors, told from responses and from outputs that are made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grader.labs.imu.bonuses import complementary_filter as tilting
from grader.labs.imu.bonuses.complementary_filter import Response
from grader.labs.imu.compare import Array

pytestmark = pytest.mark.quick
_TILT, _DEGREE = np.array([0.25, -0.12]), 180 / np.pi
_SOUND = Response(np.eye(2) * 0.98, np.full(2, 0.02), _TILT, True)
_GYRO_DEAF = replace(_SOUND, turn=np.zeros((2, 2)), first=np.ones(2))
_EXCHANGED = np.array([[0.0, 1], [1, 0]])


@pytest.mark.parametrize(
    ("seen", "told"),
    [
        (replace(_SOUND, moved=False, settled=np.zeros(2)), ["gyro-only"]),
        (_GYRO_DEAF, ["accel-only"]),
        (replace(_GYRO_DEAF, turn=np.diag([0.0, -0.0011])), []),
        (replace(_SOUND, first=np.full(2, 0.98), turn=np.eye(2) * 0.02), ["weights-swapped"]),
        (replace(_SOUND, first=np.array([0.964, 0.98]), turn=np.eye(2) * 0.02), []),
        (replace(_SOUND, settled=_TILT * _DEGREE), ["degrees-not-radians"]),
        (replace(_SOUND, settled=_TILT * _DEGREE * 0.94), []),
        (replace(_SOUND, turn=np.eye(2) * _DEGREE), ["degrees-not-radians"]),
        (replace(_SOUND, turn=np.eye(2) / _DEGREE * 1.09), ["degrees-not-radians"]),
        (replace(_SOUND, settled=_TILT * [1, -1]), ["tilt-sign-wrong"]),
        (replace(_SOUND, settled=_TILT * [-1, 1] + [0, 0.021]), []),
        (replace(_SOUND, settled=np.add(_TILT, [np.pi, 0])), ["tilt-sign-wrong"]),
        (replace(_SOUND, turn=0.98 * _EXCHANGED), ["tilt-sign-wrong"]),
        (replace(_SOUND, turn=-0.89 * np.eye(2)), []),
    ],
)  # fmt: skip
def test_the_one_fault_that_a_response_shows_is_told(seen: Response, told: list[str]) -> None:
    assert [name for name, holds in tilting.FAULTS.items() if holds(seen)][:1] == told


def _after_turns(x: Array, y: Array, samples_later: int = 0) -> list[Array]:
    """Outputs of which each sees its turn come out at once or later, and stay."""
    outputs = [np.tile([0.5, -3.1], (250, 1)) for _ in range(2)]
    for out, turn in zip(outputs, (x, y), strict=True):
        out[200 + samples_later :] += 0.2 * np.asarray(turn)
    return [tilting.wrapped(out) for out in outputs]


@pytest.mark.parametrize("later", [0, 1])
def test_a_turn_counts_at_once_or_a_sample_later(later: int) -> None:
    assert tilting.turns(_after_turns([1.0, 0], [0.0, -1], later)) == pytest.approx(np.diag([1.0, -1]))
    assert tilting.turns(_after_turns([0.5, 2], [0.0, 0], later)) == pytest.approx(np.array([[0.5, 2], [0, 0]]))
    assert tilting.turns(_after_turns([1.0, 0], [0.0, 1], 2)) == pytest.approx(np.zeros((2, 2)))


def _tilted(first: Array, settled: Array, before: Array = (3.1, -3.1)) -> Array:  # type: ignore[assignment]
    out = np.tile(np.asarray(before, float), (3200, 1))
    out[200], out[201:] = out[200] + first, out[199] + settled
    return out


def test_the_response_is_what_the_probes_show() -> None:
    seen = tilting.response([*_after_turns([1.0, 0], [0.0, 1]), _tilted(0.02 * _TILT, 0.9 * _TILT, (0.1, 0.2))])  # type: ignore[arg-type]
    assert seen is not None
    assert seen.turn == pytest.approx(np.eye(2))
    assert seen.first == pytest.approx([0.02, 0.02])
    assert seen.settled == pytest.approx(0.9 * _TILT + [0.1, 0.2])
    assert seen.moved


def test_of_outputs_that_are_not_whole_nothing_is_told() -> None:
    whole = [*_after_turns([1.0, 0], [0.0, 1]), _tilted(_TILT, _TILT)]
    assert tilting.response(whole) is not None
    assert tilting.response([whole[0][:249], *whole[1:]]) is None
    assert tilting.response([*whole[:2], np.where(np.arange(3200)[:, None] == 3000, np.nan, whole[2])]) is None
