"""Which sensors a picture shows, by pictures that are painted pixel by pixel: any dress is recognised, and nothing else is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np
import pytest

from grader.engine.figures import Mask
from grader.labs.imu.answers import KEYS, Array
from grader.labs.imu.diagnosis import handed_in
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.labs.imu.diagnosis.ink_match import Weight
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


def ten_seconds() -> Picture:
    picture = Picture(height=500, width=900)
    drawn = {"seconds": 10.0, "inks": (BLACK,) * 3}
    return picture.panel(0.05, 0.45, ACCEL, **drawn).panel(0.55, 0.95, GYRO, **drawn)  # type: ignore[arg-type]


def on_lined_paper() -> Picture:
    """Two of five rows are a little darker than the others: they are neither ground nor drawn."""
    picture = two(inks=(LIGHT,) * 3, frame=LIGHT)
    lines = np.isin(np.arange(picture.height) % 5, (0, 1))[:, None] & (picture.pixels == WHITE)
    picture.pixels[lines] = GREY
    picture.palette[GREY] = 231
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
    "of three seconds": two(seconds=3.0),
    "of five seconds": two(seconds=5.0),
    "of ten seconds": ten_seconds(),
    "without frames": two(frame=None),
    "in one colour": two(inks=(BLACK,) * 3),
    "in light grey": two(inks=(LIGHT,) * 3, frame=LIGHT),
    "in the lightest grey": faint(234),
    "in light grey on lined paper": on_lined_paper(),
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


# --- regions -------------------------------------------------------------------------------------------------------------


def test_the_longest_line_of_a_column_is_unbroken() -> None:
    mask = np.array([[1, 0, 1, 0], [1, 1, 0, 0], [0, 1, 1, 0], [1, 1, 0, 0]], bool)
    assert handed_in._longest(mask).tolist() == [2, 3, 1, 0]


def _lined(*columns: int, tall: int = 100) -> Mask:
    """A region of 100 rows with borders that are so tall."""
    mask = np.zeros((100, 300), bool)
    mask[:tall, list(columns)] = True
    return mask


def _stroke(first: int, last: int, thick: int = 1) -> Mask:
    """What a curve's colour leaves from the first column to the last."""
    mask = np.zeros((100, 300), bool)
    mask[50 : 50 + thick, first : last + 1] = True
    return mask


SPANS: dict[str, tuple[Mask, list[Mask], list[tuple[int, int]]]] = {
    "nothing": (_lined(), [], []),
    "two borders": (_lined(30, 279), [], [(41, 269), (30, 280)]),
    "borders of two panels": (
        _lined(10, 139, 160, 289), [], [(23, 277), (10, 290), (16, 134), (10, 140), (166, 284), (160, 290)],
    ),
    "a border in the middle": (_lined(10, 150, 289), [], [(23, 277), (10, 290), (156, 284), (150, 290)]),
    "lines that are as tall as a border": (_lined(30, 279, tall=12), [], [(41, 269), (30, 280)]),
    "lines that are shorter": (_lined(30, 279, tall=11), [], []),
    "panels that are too narrow": (_lined(210, 278), [], []),
    "a panel that is just wide enough": (_lined(210, 279), [], [(210, 280)]),
    "a colour": (_lined(), [_stroke(20, 199)], [(20, 200), (20, 150), (20, 100), (100, 200)]),
    "a colour over too few columns": (_lined(), [_stroke(80, 220)], [(100, 200)]),
    "a colour over half of them": (_lined(), [_stroke(80, 229)], [(80, 230), (150, 230), (100, 200)]),
    "a colour that fills a fifth": (_lined(), [_stroke(0, 299, 20)], [(0, 300), (0, 150), (150, 300), (0, 100), (100, 200), (200, 300)]),
    "a colour that fills more": (_lined(), [_stroke(0, 299, 21)], []),
    "two colours that end together": (_lined(), [_stroke(40, 199), _stroke(20, 199)],
                                      [(40, 200), (20, 200), (40, 150), (20, 150), (20, 100), (100, 200)]),
    "two colours that are next to each other": (_lined(), [_stroke(20, 290), _stroke(22, 292)],
                                                [(20, 291), (20, 150), (150, 291), (20, 100), (100, 200), (200, 291)]),
    "two colours that are not": (_lined(), [_stroke(20, 149), _stroke(23, 149)], [(20, 150), (23, 150), (20, 100), (23, 100)]),
}  # fmt: skip


@pytest.mark.parametrize(("mask", "colours", "spans"), SPANS.values(), ids=SPANS)
def test_curves_may_go_where_a_colour_does_or_between_borders(
    mask: Mask, colours: list[Mask], spans: list[tuple[int, int]]
) -> None:
    assert handed_in._spans(mask, colours) == spans


def _colours(counts: Sequence[int], greys: Sequence[float]) -> list[list[int]]:
    """Of so many pixels of each grey, on white: which of them are of each strong colour."""
    part = np.repeat(np.arange(len(counts)), counts)[None]
    palette = np.repeat(np.array(greys, np.float32)[:, None], 3, axis=1)
    its = handed_in._colours(part, palette, 1 - palette[:, 0])
    return [sorted(set(part[mask].tolist())) for mask in its]


@pytest.mark.parametrize(
    ("counts", "greys", "colours"),
    [
        ((25, 25), (1.0, 0.0), [[1]]),
        ((25, 24), (1.0, 0.0), []),
        ((25, 99), (1.0, 0.75), []),
        ((25, 99), (1.0, 0.69), [[1]]),
        ((25, 30, 40), (1.0, 0.2, 0.6), [[1], [2]]),
        ((25, 30, 90), (1.0, 0.2, 0.6), [[2], [1]]),
        ((25, 30, 40, 9), (1.0, 0.2, 0.3, 0.1), [[1, 2]]),
        ((25, 90, 30, 30), (1.0, 0.4, 0.5, 0.6), [[1, 2], [2, 3]]),
        ((9, 99, 90, 80, 70, 60, 50), (1.0, 0.0, 0.16, 0.32, 0.48, 0.64, 0.66), [[1], [2], [3], [4], [5, 6]]),
    ],
)
def test_strong_colours_are_told_apart_those_of_most_pixels_first(
    counts: Sequence[int], greys: Sequence[float], colours: list[list[int]]
) -> None:
    assert _colours(counts, greys) == colours


def _grounds(preview: Array) -> list[tuple[int, int, int, int, int]]:
    """First and last row, first and last column, and the colour's number of each ground."""
    palette = PALETTE.astype(np.float32) / 255
    return [
        (rows.start, rows.stop, columns.start, columns.stop, int(np.abs(palette - ground).max(axis=1).argmin()))
        for rows, columns, ground in handed_in._grounds(preview, palette)
    ]


def _plain(*rectangles: tuple[int, int, int, int, int]) -> np.ndarray:
    """A white picture of 100 x 100 with rectangles in it: rows, columns and colour."""
    preview = np.zeros((100, 100), np.uint8)
    for top, bottom, left, right, colour in rectangles:
        preview[top:bottom, left:right] = colour
    return preview


_WHOLE = (0, 100, 0, 100, WHITE)
GROUNDS: dict[str, tuple[np.ndarray, list[tuple[int, int, int, int, int]]]] = {
    "one": (_plain(), [_WHOLE]),
    "a panel": (_plain((10, 60, 20, 90, DARK)), [_WHOLE, (10, 60, 20, 90, DARK)]),
    "a panel that is small": (_plain((10, 30, 20, 39, DARK)), [_WHOLE]),
    "a panel that is just large enough": (_plain((10, 30, 20, 40, DARK)), [_WHOLE, (10, 30, 20, 40, DARK)]),
    "two panels that are small": (_plain((10, 25, 20, 40, DARK), (50, 65, 20, 40, DARK)), [_WHOLE]),
    "two panels of one colour": (
        _plain((5, 45, 5, 95, DARK), (55, 95, 5, 95, DARK)), [(5, 45, 5, 95, DARK), (55, 95, 5, 95, DARK)],
    ),
    "a thin line across": (_plain((50, 52, 0, 100, BLACK)), [_WHOLE]),
    "a thick line across": (_plain((50, 56, 0, 100, BLACK)), [(0, 50, 0, 100, WHITE), (56, 100, 0, 100, WHITE), (50, 56, 0, 100, BLACK)]),
    "five colours": (
        _plain((0, 10, 0, 100, RED), (20, 32, 0, 100, GREEN), (40, 53, 0, 100, BLUE), (60, 69, 0, 100, GREY)),
        [(10, 20, 0, 100, WHITE), (32, 40, 0, 100, WHITE), (53, 60, 0, 100, WHITE), (69, 100, 0, 100, WHITE),
         (40, 53, 0, 100, BLUE), (20, 32, 0, 100, GREEN), (0, 10, 0, 100, RED)],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("preview", "grounds"), GROUNDS.values(), ids=GROUNDS)
def test_grounds_are_what_one_colour_fills(preview: np.ndarray, grounds: list[tuple[int, int, int, int, int]]) -> None:
    assert _grounds(preview) == grounds


def test_two_shades_that_nobody_tells_apart_are_one_ground() -> None:
    palette = np.repeat(np.array([[1.0], [0.97]], np.float32), 3, axis=1)
    assert len(list(handed_in._grounds(_plain((60, 100, 0, 100, 1)), palette))) == 1


@pytest.mark.parametrize(("rows", "regions"), [(30, 1), (31, 0)])
def test_a_region_is_mostly_ground(rows: int, regions: int) -> None:
    preview = _plain()
    preview[::3][:rows] = BLACK
    found = list(handed_in._regions(preview, PALETTE.astype(np.float32) / 255, 0.14))
    assert len(found) == regions


# --- panels --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("width", "other", "alike"),
    [
        (100, 104, True), (104, 100, True), (100, 105, False), (105, 100, False), (970, 1000, True), (969, 1000, False),
        (1030, 1000, True), (1031, 1000, False),
    ],
)  # fmt: skip
def test_panels_are_as_wide_as_each_other_to_a_few_columns(width: float, other: float, alike: bool) -> None:
    assert handed_in._as_wide(width, other) is alike


_ALL = (0, 1, 2)


def _group(promises: Mapping[Any, float], duration_s: float = 2.0, width: float = 400.0) -> handed_in._Group:
    places: Any = {key: [SimpleNamespace(promise=its), SimpleNamespace(promise=9.0)] for key, its in promises.items()}
    return handed_in._Group(duration_s, width, places)


@pytest.mark.parametrize(
    ("promises", "promise"),
    [
        ({}, -2.0),
        ({(0, _ALL): 0.5}, -0.5),
        ({(0, _ALL): 0.5, (1, _ALL): 0.25}, 0.75),
        ({(0, (0,)): 0.5, (0, (1,)): 0.25, (0, (2,)): 0.75, (1, _ALL): 0.25}, 0.75),
        ({(0, (0,)): 0.5, (0, (1,)): 0.25, (0, (2,)): 0.75, (0, _ALL): 0.75, (1, _ALL): 0.25}, 1.0),
        ({(1, (0,)): 0.5, (1, (1,)): 0.5, (0, _ALL): 0.5}, 0.5),
    ],
)
def test_a_group_promises_what_its_likeliest_panels_do(promises: Mapping[Any, float], promise: float) -> None:
    assert _group(promises).promise == pytest.approx(promise)


@pytest.mark.parametrize(
    ("duration_s", "width", "alike"), [(2.0, 400.0, True), (2.0, 410.0, True), (2.0, 450.0, False), (3.0, 400.0, False)]
)
def test_groups_are_alike_by_duration_and_width(duration_s: float, width: float, alike: bool) -> None:
    assert _group({}).is_like(_group({}, duration_s, width)) is alike


def test_groups_are_of_places_that_are_as_wide_the_likeliest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    def places(promise: float, first: int, last: int, _curves: object) -> list[Any]:
        return [(_ALL, SimpleNamespace(width=last - first, promise=promise))]

    monkeypatch.setattr(handed_in, "places", places)
    spans: Any = [(0.2, (0, 400)), (0.3, (9, 300)), (0.6, (5, 407)), (0.4, (50, 450))]
    groups = handed_in._groups(spans, {key: truth()["push"][key] for key in KEYS})
    assert [group.duration_s for group in groups] == list(handed_in.DURATIONS)
    for group in groups:
        for sensor in (0, 1):
            assert [(its.width, its.promise) for its in group.places[sensor, _ALL]] == [
                (402, 0.6),
                (400, 0.4),
                (400, 0.2),
            ]


def _weighing(weights: Mapping[Any, Sequence[tuple[float, float]]]) -> set[int]:
    """What is shown where places weigh so much: what is followed, and the evidence."""
    places: Any = {key: [Weight(*its) for its in each] for key, each in weights.items()}
    with mock.patch.multiple(handed_in, settled=lambda place: place, weighed=lambda place: place):
        return handed_in._shown(handed_in._Group(2.0, 400.0, places))


def _apart(sensor: int, *evidence: float) -> dict[Any, list[tuple[float, float]]]:
    return {(sensor, (channel,)): [(0.9, nats)] for channel, nats in enumerate(evidence)}


SHOWN: dict[str, tuple[Mapping[Any, Sequence[tuple[float, float]]], set[int]]] = {
    "nothing": ({}, set()),
    "both in a panel each": ({(0, _ALL): [(0.75, 40.0)], (1, _ALL): [(0.9, 90.0)]}, {0, 1}),
    "one that is followed too little": ({(0, _ALL): [(0.74, 99.0)], (1, _ALL): [(0.9, 90.0)]}, {1}),
    "one with too little evidence": ({(0, _ALL): [(0.8, 50.0)], (1, _ALL): [(0.9, 39.0)]}, {0}),
    "the fourth place of one": ({(0, _ALL): [(0.1, 9.0), (0.2, 99.0), (0.9, 9.0), (0.9, 50.0)]}, {0}),
    "the fifth place of one": ({(0, _ALL): [(0.9, 9.0)] * 4 + [(0.9, 50.0)]}, set()),
    "both in panels of their own": (_apart(0, 20, 20, 20) | _apart(1, 5, 5, 50), {0, 1}),
    "one of three with too little": (_apart(0, 4.9, 40, 40) | _apart(1, 5, 5, 50), {1}),
    "three with too little together": (_apart(0, 19, 20, 20) | _apart(1, 20, 20, 20), {1}),
    "two of three": (_apart(0, 50, 50), set()),
    "one in a panel, the other in three": ({(0, _ALL): [(0.9, 90.0)], **_apart(1, 30, 30, 30)}, {0}),
    "one in a panel, both in three": ({(0, _ALL): [(0.9, 90.0)], **_apart(0, 30, 30, 30), **_apart(1, 30, 30, 30)}, {0, 1}),
}  # fmt: skip


@pytest.mark.parametrize(("weights", "shown"), SHOWN.values(), ids=SHOWN)
def test_sensors_are_shown_where_curves_stand(
    weights: Mapping[Any, Sequence[tuple[float, float]]], shown: set[int]
) -> None:
    assert _weighing(weights) == shown


@pytest.mark.quick
def test_the_sheets_own_duration_is_looked_for_first_and_each_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[float] = []
    monkeypatch.setattr(handed_in, "Curves", lambda _time, _rows, duration: tried.append(duration))
    handed_in._groups([], {key: truth()["push"][key] for key in KEYS})
    durations = tried[::2]  # of both sensors
    assert durations[0] == 5.0
    assert tried[1::2] == durations
    assert len(set(durations)) == len(durations)


@pytest.mark.quick
def test_the_search_ends_where_both_sensors_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    for found, shown in (([{0, 1}, {0}], {0, 1}), ([{0}, {0, 1}], {0, 1}), ([set(), {1}], {1})):
        left = iter(found)
        monkeypatch.setattr(handed_in, "_regions", lambda *_: [])
        monkeypatch.setattr(handed_in, "_groups", lambda *_: ["group"])
        monkeypatch.setattr(handed_in, "_shown", lambda _group, left=left: next(left, set()))
        assert sensors_shown(np.zeros((2, 2), np.uint8), np.zeros((256, 3), np.uint8), {}) >= shown
