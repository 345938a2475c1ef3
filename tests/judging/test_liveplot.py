"""What the curves of a live plot show, by curves that are made of a recording by hand."""

from __future__ import annotations

import numpy as np
import pytest

from grader.labs.imu.bonuses import live_plot as liveplot
from grader.labs.imu.compare import Array

pytestmark = pytest.mark.quick
DT, COUNT = 0.002, 600
STAMPS = DT * (np.arange(COUNT) + 1)
CHANNELS = np.column_stack(
    [
        *(3 + 20 * STAMPS + 5 * np.sin((5 + axis) * STAMPS) for axis in range(3)),
        *(1 + 4 * STAMPS + np.sin((7 + axis) * STAMPS) for axis in range(3)),
    ]
)
"""Three of an accelerometer and three of a gyroscope, which never come back to where they were."""
RATE, ACCEL = CHANNELS[:, 4], CHANNELS[:, 0]
SECOND = np.hstack([-50 - CHANNELS, CHANNELS])
"""They are those of a second IMU, on which no noise is."""
RNG = np.random.default_rng(5)


@pytest.mark.parametrize(
    ("events", "updates", "after", "span"),
    [
        ([], 0, 0, 0.0),
        ([(0.0, 0, 1)], 0, 1, 0.0),
        ([(0.0, 0, 1), (0.5, 10, 2), (0.5, 11, 3), (1.0, 20, 4)], 2, 1, 1.0),
        ([(0.2, 3, 1), (1.0, 20, 2), (1.0, 20, 3)], 2, 2, 0.8),
        ([(-1.0, 3, 1), (1.0, 20, 2)], 1, 1, 2.0),
    ],
)
def test_changes_are_counted_by_the_moments_of_the_simulation(
    events: list[tuple[float, int, int]], updates: int, after: int, span: float
) -> None:
    table = np.array(events, float).reshape(-1, 3)
    run = liveplot.LiveRun(table, (), 1.0)
    assert (run.updates, run.changes_after) == (updates, after)
    assert run.span == pytest.approx(span)


def noisy(channel: Array, size: float, bias: float = 0.0) -> Array:
    return channel + bias + RNG.uniform(-size, size, len(channel))


MIXED = [500, 20, 300, 410, 100]
GAPS = np.where(np.arange(COUNT) % 5 == 0, np.nan, RATE)
SHOWN: dict[str, tuple[Array, Array]] = {
    "over the time before each step": (STAMPS - DT, RATE),
    "over milliseconds": (1000 * STAMPS, RATE),
    "three readings": (STAMPS[100:400:100], RATE[100:400:100]),
    "five readings, with times that are rounded": (
        STAMPS[MIXED] + 1e-9 * np.array([1, -1, 1, -1, 1]),
        RATE[MIXED],
    ),
    "five readings in degrees": (STAMPS[MIXED] - DT, np.degrees(RATE[MIXED])),
    "with gaps": (STAMPS, GAPS),
    "with gaps in the times": (np.where(np.isnan(GAPS), np.nan, STAMPS), RATE),
    "off by less than two machines differ": (STAMPS, RATE + 0.9e-3),
    "with the sheet's noise": (STAMPS, noisy(RATE, 0.05, 0.04)),
    "nine tenths of it in the run": (np.concatenate([STAMPS[:90], 50 + STAMPS[:10]]), RATE[:100]),
    "over anything else, in degrees": (-np.arange(100.0), np.degrees(RATE[450:550])),
    "over anything else, from the first reading": (np.zeros(8), RATE[:71:10]),
    "over anything else, from the first reading, after what was filled in": (np.zeros(9), np.append(0.0, RATE[:71:10])),
    "over anything else, eight readings": (np.zeros(8), RATE[450:530:10]),
}
REST = np.zeros((COUNT, 6))
OTHERS: dict[str, tuple[Array, Array]] = {
    "twice as much": (STAMPS, 2 * RATE),
    "off by more than noise": (STAMPS, noisy(RATE, 0.05, 0.3)),
    "rather too far off": (STAMPS, RATE + 0.13),
    "five readings, one of them wrong": (STAMPS[MIXED], RATE[MIXED] + np.array([0, 0.3, 0, 0, 0])),
    "over anything else, an old one wrong": (np.zeros(100), RATE[450:550] - 0.01 * (np.arange(100) == 4)),
    "nothing that is a number": (STAMPS, np.full(COUNT, np.nan)),
    "over anything else, seven from the first, and before them the last": (np.zeros(8), np.append(RATE[-1], RATE[:7])),
    "seven readings over anything else": (np.zeros(7), RATE[450:520:10]),
    "half of it in the run": (
        np.concatenate([STAMPS[:50], 50 + STAMPS[:50]]),
        np.concatenate([RATE[:50], np.ones(50)]),
    ),
    "over times beyond the simulation": (1e30 * STAMPS, np.sin(7 * STAMPS)),
}


@pytest.mark.parametrize("name", SHOWN)
def test_a_curve_that_follows_a_channel_shows_it(name: str) -> None:
    assert liveplot.shows(*SHOWN[name], CHANNELS, DT)
    assert liveplot.shows(*SHOWN[name], SECOND, DT) is ("noise" not in name)


@pytest.mark.parametrize(("x", "y"), OTHERS.values(), ids=OTHERS)
def test_a_curve_that_follows_no_channel_shows_none(x: Array, y: Array) -> None:
    assert not liveplot.shows(x, y, CHANNELS, DT)
    assert not liveplot.shows(x, y, SECOND, DT)


@pytest.mark.parametrize(("size", "off", "shown"), [(0.08, 0.0, True), (0.001, 0.08, False), (0.08, 1.0, False)])
def test_noise_is_to_be_seen_on_a_channel_that_rests(size: float, off: float, shown: bool) -> None:
    assert liveplot.shows(STAMPS, RNG.uniform(-size, size, COUNT) + off, REST, DT) is shown


def test_noise_alone_is_no_channel_that_moves_a_little() -> None:
    """Both begin with a jolt, so that the first reading is like no other one."""
    jolt = 0.5 * (np.arange(COUNT) < 2)
    moving, noise = 0.08 * np.sin(20 * STAMPS) + jolt, RNG.uniform(-0.02, 0.02, COUNT)
    channels = np.column_stack([CHANNELS[:, :5], moving])
    assert liveplot.shows(STAMPS, moving + noise, channels, DT)
    assert not liveplot.shows(STAMPS, jolt + noise, channels, DT)


_LATER = CHANNELS * (STAMPS > 0.05)[:, None]
"""The robot rests at first."""


@pytest.mark.parametrize(
    ("y", "shown"),
    [
        (RNG.uniform(-0.6, 0.6, COUNT), False),
        (RNG.uniform(-0.09, 0.09, COUNT), False),
        (0.5 * np.sin(3 * STAMPS), False),
        (_LATER[:, 4], True),
        (noisy(_LATER[:, 0], 0.5), True),
    ],
)
def test_seconds_are_no_milliseconds_of_a_robot_that_rests_at_first(y: Array, shown: bool) -> None:
    assert liveplot.shows(STAMPS, y, _LATER, DT) is shown


@pytest.mark.parametrize("times", [1, 2, 3])
def test_a_reading_may_be_drawn_up_to_three_times(times: int) -> None:
    assert liveplot.shows(np.repeat(STAMPS, times), np.repeat(noisy(RATE, 0.05), times), CHANNELS, DT)
