"""Which sensors a picture shows, by pictures that are painted pixel by pixel: any dress is recognised, and nothing else is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from grader.labs.imu.answers import KEYS, Array
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from tests.judging.made import truth

pytestmark = pytest.mark.quick
PUSH = {key: truth()["push"][key] for key in KEYS}
WHITE, BLACK, RED, GREEN, BLUE, DARK, GREY, LIGHT = range(8)
PALETTE = np.array(
    [[255] * 3, [0] * 3, [214, 39, 40], [44, 160, 44], [31, 119, 180], [40, 44, 52], [150] * 3, [215] * 3], np.uint8
)
COLOURS = (RED, GREEN, BLUE)
SIX = np.hstack([PUSH["acceleration"], PUSH["angular_velocity"]])
ACCEL, GYRO, BOTH = PUSH["acceleration"], PUSH["angular_velocity"], {0, 1}


@dataclass
class Picture:
    """Pixels, and the colours that they are of."""

    ground: int = WHITE
    height: int = 400
    width: int = 520
    palette: np.ndarray = field(default_factory=PALETTE.copy)

    def __post_init__(self) -> None:
        self.pixels = np.full((self.height, self.width), self.ground, np.uint8)

    def panel(
        self, low: float, high: float, curves: Array, inks: Sequence[int] = COLOURS, *, left: float = 0.1, right: float = 0.95,
        seconds: float = 1.2, frame: int | None = BLACK, ground: int | None = None,
    ) -> Picture:  # fmt: skip
        """Curves (m, k) on one scale, between these parts of the height and of the width; after 1.2 s they go back."""
        top, bottom = round(low * self.height), round(high * self.height)
        first, last = round(left * self.width), round(right * self.width)
        if ground is not None:
            self.pixels[top:bottom, first:last] = ground
        if frame is not None:
            self.pixels[[top, bottom], first : last + 1] = frame
            self.pixels[top : bottom + 1, [first, last]] = frame
        margin = (last - first) / 22
        stamps = np.arange(0, seconds, seconds / 4000)
        back = np.abs((stamps + 1.2) % 2.4 - 1.2)
        columns = np.rint(first + margin + stamps / seconds * (last - first - 2 * margin)).astype(int)
        for channel, ink in zip(curves.T, inks, strict=False):
            share = (curves.max() - np.interp(back, PUSH["time"] - PUSH["time"][0], channel)) / np.ptp(curves)
            rows = np.rint(top + (bottom - top) * (0.05 + 0.9 * share)).astype(int)
            for thick in (0, 1):
                self.pixels[rows + thick, columns] = ink
        return self

    def shown(self) -> set[int]:
        return sensors_shown(self.pixels, self.palette, PUSH)


def two(**drawn: object) -> Picture:
    return Picture().panel(0.05, 0.45, ACCEL, **drawn).panel(0.55, 0.95, GYRO, **drawn)  # type: ignore[arg-type]


def aside(**second: float) -> Picture:
    """Both panels abreast."""
    left, right = {"left": 0.05, "right": 0.48}, {"left": 0.55, "right": 0.98} | second
    return Picture(width=640).panel(0.1, 0.9, ACCEL, **left).panel(0.1, 0.9, GYRO, **right)  # type: ignore[arg-type]


def six(channels: Array, ink: int = BLUE) -> Picture:
    """A panel for each channel: three rows, two columns."""
    picture = Picture(height=480, width=640)
    for number, channel in enumerate(channels.T):
        low, left = 0.05 + 0.32 * (number % 3), 0.06 + 0.48 * (number // 3)
        picture.panel(low, low + 0.25, channel[:, None], (ink,), left=left, right=left + 0.42)
    return picture


def abreast() -> Picture:
    """A row for each sensor and a panel for each of its channels, without frames."""
    picture = Picture(width=640)
    for number, channel in enumerate(SIX.T):
        low, left = 0.05 + 0.5 * (number // 3), 0.03 + 0.33 * (number % 3)
        picture.panel(low, low + 0.4, channel[:, None], (BLUE,), left=left, right=left + 0.29, frame=None)
    return picture


def in_a_window(figure: Picture, ground: int) -> Picture:
    window = Picture(ground, height=640, width=640)
    window.pixels[:40] = RED
    window.pixels[140:540, 60:580] = figure.pixels
    return window


def gridded() -> Picture:
    """A grid below the curves, and a legend over them."""
    picture = two()
    lines = np.zeros_like(picture.pixels, bool)
    lines[30:180:30, 52:494] = lines[230:380:30, 52:494] = lines[20:180, 52:494:60] = lines[220:380, 52:494:60] = True
    picture.pixels[lines & (picture.pixels == WHITE)] = LIGHT
    picture.pixels[25:65, 430:490] = WHITE
    picture.pixels[[30, 45, 60], 440:455] = np.array(COLOURS)[:, None]
    return picture


def faint(ink: int) -> Picture:
    """Curves that are hardly darker than their ground, 255."""
    picture = two(inks=(LIGHT,) * 3, frame=LIGHT)
    picture.palette[LIGHT] = ink
    return picture


def dashed(gap: int) -> Picture:
    picture = two(inks=(BLACK,) * 3)
    for columns in range(60, 490, 3 * gap):
        picture.pixels[25:175, columns : columns + gap] = WHITE
        picture.pixels[225:375, columns : columns + gap] = WHITE
    return picture


RECOGNISED = {
    "as the sheet draws it": two(),
    "of two seconds": two(seconds=2.0),
    "of five seconds": two(seconds=5.0),
    "without frames": two(frame=None),
    "in one colour": two(inks=(BLACK,) * 3),
    "in light grey": two(inks=(LIGHT,) * 3, frame=LIGHT),
    "in the lightest grey": faint(234),
    "on a dark ground": Picture(DARK).panel(0.05, 0.45, ACCEL, frame=WHITE).panel(0.55, 0.95, GYRO, frame=WHITE),
    "on grounds of their own": two(ground=LIGHT, frame=WHITE),
    "beneath a grid": gridded(),
    "in strokes": dashed(4),
    "abreast": aside(),
    "three abreast": abreast(),
    "in six panels": six(SIX),
    "in six panels, in black": six(SIX, BLACK),
    "in a window": in_a_window(two(), DARK),
    "dark in a light window": in_a_window(Picture(DARK).panel(0.05, 0.45, ACCEL).panel(0.55, 0.95, GYRO), WHITE),
    "one within the other's frame": Picture().panel(0.05, 0.45, GYRO).panel(0.55, 0.95, ACCEL),
}
MIRRORED = ACCEL[::-1], GYRO[::-1]
OTHERS = {
    "blank": (Picture(), set()),
    "black": (Picture(BLACK), set()),
    "hardly to be seen": (faint(240), set()),
    "frames alone": (two(inks=()), set()),
    "one sensor alone": (Picture().panel(0.05, 0.95, GYRO), {1}),
    "one sensor twice": (Picture().panel(0.05, 0.45, ACCEL).panel(0.55, 0.95, ACCEL), {0}),
    "another motion": (Picture().panel(0.05, 0.45, MIRRORED[0]).panel(0.55, 0.95, MIRRORED[1]), set()),
    "upside down": (Picture().panel(0.05, 0.45, -ACCEL).panel(0.55, 0.95, -GYRO), set()),
    "of other durations": (Picture().panel(0.05, 0.45, ACCEL).panel(0.55, 0.95, GYRO, seconds=2.0), {1}),
    "of other widths": (Picture().panel(0.05, 0.45, ACCEL).panel(0.55, 0.95, GYRO, right=0.8), {0}),
    "four of six panels": (six(np.hstack([ACCEL, GYRO[:, :1]])), {0}),
    "narrow": (Picture().panel(0.05, 0.45, ACCEL, right=0.2).panel(0.55, 0.95, GYRO, right=0.2), set()),
    "half hidden": (dashed(60), set()),
}


@pytest.mark.parametrize("picture", RECOGNISED.values(), ids=RECOGNISED)
def test_the_recording_is_recognised_in_any_dress(picture: Picture) -> None:
    assert picture.shown() == BOTH


@pytest.mark.parametrize(("picture", "shown"), OTHERS.values(), ids=OTHERS)
def test_nothing_else_is_taken_for_it(picture: Picture, shown: set[int]) -> None:
    assert picture.shown() == shown


def test_noise_shows_nothing() -> None:
    picture = Picture()
    picture.pixels[:] = np.random.default_rng(3).integers(0, len(PALETTE), picture.pixels.shape)
    assert picture.shown() == set()
