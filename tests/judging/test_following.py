"""Whether ink follows curves, on regions that are drawn by hand: where curves stand is found, and chance follows none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from grader.engine.figures import Mask
from grader.labs.imu.diagnosis import ink_match
from grader.labs.imu.diagnosis.ink_match import Curves, Ink, Place

pytestmark = pytest.mark.quick
TIME = np.linspace(0, 1.2, 601)
WAVES = np.array([np.sin(9 * TIME) - 1, 2 * np.cos(13 * TIME) * TIME, 1.5 * np.sin(7 * TIME + 2)])
CURVES = Curves(TIME, WAVES, 2.0)
"""The first 1.2 s of a recording of 2 s."""
HEIGHT, WIDTH = 201, 300
TOP, TALL, FIRST, LAST = 20.0, 150.0, 30.0, 280.0
"""Rows of the highest value and from there to the lowest; columns of the first and of the last moment."""


def at(curves: Curves = CURVES, ink: Ink | None = None, **moved: float) -> Place:
    place = {"top": TOP, "height": TALL, "first": FIRST, "last": LAST} | moved
    return Place(curves, ink or drawn(), **place, promise=0.0)


def drawn(curves: Curves = CURVES, own_scales: bool = False) -> Ink:
    """What curves leave in a region, one pixel thick."""
    mask = np.zeros((HEIGHT, WIDTH), bool)
    for channel in curves.values:
        its = channel if own_scales else curves.values
        stamps = np.arange(0, curves.time[-1], 2e-4)
        rows = TOP + (its.max() - np.interp(stamps, curves.time, channel)) / np.ptp(its) * TALL
        columns = FIRST + stamps / curves.duration_s * (LAST - FIRST)
        mask[np.rint(rows).astype(int), np.rint(columns).astype(int)] = True
    return Ink.of(mask)


def blank(of: bool = False) -> Ink:
    return Ink.of(np.full((HEIGHT, WIDTH), of))


def speckled(share: float) -> Mask:
    return np.random.default_rng(1).random((HEIGHT, WIDTH)) < share


# --- ink -----------------------------------------------------------------------------------------------------------------


def test_ink_is_near_its_pixel_and_next_to_it() -> None:
    mask = np.zeros((14, 9), bool)
    mask[5, 6] = mask[0, 0] = mask[13, 8] = True
    ink = Ink.of(mask)
    near = np.zeros_like(mask)
    near[4:7, 5:8] = near[:2, :2] = near[12:, 7:] = True
    assert np.array_equal(ink.near, near)
    assert np.argwhere(ink.rough).tolist() == [[0, 0], [1, 6]]
    assert ink.rough.shape == (3, 9)


@pytest.mark.parametrize(
    ("row", "column", "there"),
    [
        (4, 5, True), (6, 7, True), (3, 5, False), (4, 4, False), (6.4, 7.4, True), (6.6, 7, False), (6, 7.6, False),
        (0, 0, True), (-0.6, 0, False), (-1, 0, False), (-300, 0, False), (13, 8, True), (13.6, 8, False), (14, 8, False),
        (300, 8, False), (0, 8, False), (13, 0, False),
    ],
)  # fmt: skip
def test_there_is_no_ink_above_or_below(row: float, column: float, there: bool) -> None:
    mask = np.zeros((14, 9), bool)
    mask[5, 6] = mask[0, 0] = mask[13, 8] = True
    assert Ink.of(mask).at(np.array([row]), np.array([column])).tolist() == [there]


# --- curves --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("first", "last", "columns"),
    [(30, 280, (30, 180)), (29.5, 279.5, (30, 179)), (-20, 230, (0, 130)), (200, 450, (200, 299)), (0, 20, (0, 11))],
)
def test_a_curve_is_known_where_its_recording_is(first: float, last: float, columns: tuple[int, int]) -> None:
    found, values = CURVES.within(first, last, WIDTH)
    assert (found[0], found[-1], len(found)) == (*columns, columns[1] - columns[0] + 1)
    stamps = (found - first) / (last - first) * 2.0
    assert values == pytest.approx(np.array([np.interp(stamps, TIME, wave) for wave in WAVES]))


def test_curves_in_one_panel_go_from_the_highest_value_of_all_down_to_the_lowest() -> None:
    place = at()
    columns, rows = place.rows()
    assert (columns[0], columns[-1], rows.shape) == (30, 180, (3, 151))
    assert rows == pytest.approx(TOP + (WAVES.max() - CURVES.within(FIRST, LAST, WIDTH)[1]) / np.ptp(WAVES) * TALL)
    assert place.width == LAST - FIRST


def test_a_place_is_moved_by_its_rows_and_by_its_columns() -> None:
    moved = at().moved(np.array([1.0, 2, 3, 4]))
    assert (moved.top, moved.height, moved.first, moved.last) == (TOP + 1, TALL + 2, FIRST + 3, LAST + 4)


# --- searching -----------------------------------------------------------------------------------------------------------


def _searched(
    ink: Ink, curves: Curves = CURVES, first: float = FIRST, last: float = LAST
) -> dict[tuple[int, ...], Place]:
    return dict(ink_match.places(ink, int(first), int(last), curves))


def test_three_curves_on_one_scale_are_found_where_they_are_drawn() -> None:
    places = _searched(drawn())
    assert list(places) == [(0, 1, 2), (0,), (1,), (2,)]
    found = places[0, 1, 2]
    assert found.top == pytest.approx(TOP, abs=4)
    assert found.height == pytest.approx(TALL, rel=0.1)
    assert (found.first, found.last, found.width) == (FIRST, LAST, LAST - FIRST)
    assert np.array_equal(found.curves.values, WAVES)
    assert found.promise > 0.7


@pytest.mark.parametrize("channel", range(3))
def test_a_curve_is_found_on_a_scale_of_its_own(channel: int) -> None:
    alone = replace(CURVES, values=WAVES[[channel]])
    found = _searched(drawn(alone))[(channel,)]
    assert found.top == pytest.approx(TOP, abs=4)
    assert found.height == pytest.approx(TALL, rel=0.1)
    assert np.array_equal(found.curves.values, alone.values)
    assert found.promise > 0.7


def test_of_places_that_are_followed_alike_the_largest_is_taken() -> None:
    place = _searched(blank(of=True))[0, 1, 2]
    assert place.top == 2
    assert place.height == pytest.approx(0.9 * (HEIGHT // 4 * 4))


def test_where_nothing_is_drawn_no_place_is_promising() -> None:
    assert all(place.promise < 0 for place in _searched(blank()).values())
    assert all(place.promise < 0.3 for place in _searched(Ink.of(speckled(0.05))).values())


def test_of_two_curves_one_is_missing_in_the_promise() -> None:
    two = replace(CURVES, values=WAVES[:2])
    both = _searched(drawn())[0, 1, 2].promise
    lacking = drawn(two)
    assert _searched(lacking)[0, 1, 2].promise < both - 0.15


@pytest.mark.parametrize(
    ("first", "last", "tall", "flat", "found"),
    [
        (30, 280, HEIGHT, False, 4),
        (30, 71, HEIGHT, False, 4),
        (30, 69, HEIGHT, False, 0),
        (30, 280, HEIGHT, True, 0),
        (30, 280, 20, False, 4),
        (30, 280, 19, False, 0),
    ],
)
def test_short_low_and_resting_curves_are_not_looked_for(
    first: int, last: int, tall: int, flat: bool, found: int
) -> None:
    values = WAVES * [[1], [1], [0]] if flat else WAVES
    ink = Ink.of(speckled(0.02)[:tall])
    assert len(_searched(ink, replace(CURVES, values=values), first, last)) == found


def test_three_curves_far_apart_on_one_scale_are_looked_for_one_by_one() -> None:
    apart = replace(CURVES, values=WAVES + np.array([[0], [40], [80]]))
    assert list(_searched(drawn(apart), apart)) == [(0,), (1,), (2,)]


@pytest.mark.parametrize("columns", [1, 2])
def test_a_line_in_ink_that_is_everywhere_is_followed_by_chance(columns: int) -> None:
    """Of every row a half is ink, or all of it, of which some is never chance."""
    seen = np.ones((60, 4), bool)
    seen[:, ::2] = columns == 2
    beyond = ink_match._beyond_chance(seen, np.array([[0.0] * 4, [1.0] * 4]))
    assert beyond.shape == (60, 27, 2)
    shortest = beyond[:50, -1]
    assert shortest == pytest.approx(np.full_like(shortest, 0.0 if columns == 1 else 1.0))


MOVED = [
    {"top": TOP + 6},
    {"height": TALL - 9},
    {"first": FIRST + 4, "last": LAST - 5},
    {"top": TOP - 5, "height": TALL + 6, "last": LAST + 6},
    {"first": FIRST - 4, "last": LAST - 4},
]


@pytest.mark.parametrize("moved", MOVED)
def test_a_place_settles_where_the_curves_are(moved: dict[str, float]) -> None:
    place = ink_match.settled(at(**moved))
    assert (place.top, place.height, place.first, place.last) == pytest.approx((TOP, TALL, FIRST, LAST), abs=4.5)
    assert ink_match.weighed(place).followed > 0.97


def test_a_place_settles_no_farther_than_a_span_may_be_off() -> None:
    assert ink_match.settled(at(first=FIRST + 8)).first == FIRST + 3
    assert ink_match.settled(at(first=FIRST - 8)).first == FIRST - 3


@pytest.mark.parametrize(
    ("moved", "near"),
    [
        ({"first": FIRST + 5, "last": LAST - 9}, True),
        ({"first": FIRST - 5, "last": LAST + 9}, True),
        ({"first": FIRST + 5.5}, False),
        ({"first": FIRST - 5.5}, False),
        ({"last": LAST + 9.5}, False),
        ({"last": LAST - 9.5}, False),
        ({"top": 99.0, "height": 10.0}, True),
        ({"height": 9.5}, False),
    ],
)
def test_a_place_is_near_another_by_its_columns_and_high_enough(moved: dict[str, float], near: bool) -> None:
    assert ink_match._is_near(at(**moved), at()) is near


@pytest.mark.parametrize("moved", [{}, {"last": 60.0}])
def test_a_place_that_is_right_or_too_short_stays(moved: dict[str, float]) -> None:
    assert ink_match.settled(start := at(**moved)) is start


def test_a_place_that_is_too_short_is_followed_by_less_than_nothing() -> None:
    assert ink_match._followed(at(ink=blank(of=True), last=60.0)) < ink_match._followed(at(ink=blank()))


def test_where_nothing_is_drawn_a_place_stays() -> None:
    assert ink_match.settled(start := at(ink=blank())) is start


# --- weighing ------------------------------------------------------------------------------------------------------------


def test_curves_that_are_drawn_are_followed_beyond_chance() -> None:
    weight = ink_match.weighed(at())
    assert weight.followed == 1.0
    assert weight.evidence > 200


def test_every_fourth_row_of_a_clear_curve_speaks_for_it_by_a_tenths_chance() -> None:
    alone = replace(CURVES, values=WAVES[:1])
    way = np.abs(np.diff(at(alone).rows()[1])).sum()
    evidence = ink_match.weighed(at(alone, drawn(alone))).evidence
    assert evidence == pytest.approx(way / 4 * ink_match._surprise(1.0, 0.1), rel=0.01)


def test_ink_aside_of_the_curves_is_what_chance_would_have() -> None:
    """A third of all rows, in stripes, and the curve: its evidence is that of a third's chance."""
    alone = replace(CURVES, values=WAVES[:1])
    clear = drawn(alone)
    striped = Ink(clear.near | (np.arange(HEIGHT) % 9 < 3)[:, None], clear.rough)
    way = np.abs(np.diff(at(alone).rows()[1])).sum()
    evidence = ink_match.weighed(at(alone, striped)).evidence
    assert evidence == pytest.approx(way / 4 * ink_match._surprise(1.0, 1 / 3), rel=0.2)


@pytest.mark.parametrize("ink", [blank(), blank(of=True), Ink.of(speckled(0.3))], ids=["blank", "black", "noise"])
def test_ink_that_lies_there_by_chance_is_no_evidence(ink: Ink) -> None:
    assert ink_match.weighed(at(ink=ink)).evidence < 5


def test_the_curve_that_is_followed_least_is_told() -> None:
    lacking = drawn(replace(CURVES, values=np.vstack([WAVES[:2], WAVES[:1]])))
    least = ink_match.weighed(at(ink=lacking))
    assert least.followed < 0.4
    assert 20 < least.evidence < ink_match.weighed(at()).evidence / 2


def test_a_curve_elsewhere_is_not_followed() -> None:
    assert ink_match.weighed(at(top=TOP + 40)).evidence < 10
    assert ink_match.weighed(at(top=TOP + 40)).followed < 0.4


@pytest.mark.parametrize(("moved", "followed"), [({"height": 19.0}, 0.0), ({"last": 69.0}, 0.0), ({"last": 71.0}, 1.0)])
def test_low_and_short_curves_weigh_nothing(moved: dict[str, float], followed: float) -> None:
    weight = ink_match.weighed(at(ink=blank(of=True), **moved))
    assert (weight.followed, weight.evidence) == pytest.approx((followed, 0.0), abs=0.5)


def test_curves_that_hardly_move_weigh_nothing_however_far_apart() -> None:
    calm = replace(CURVES, values=0.1 * np.tile(np.sin(9 * TIME), (3, 1)) + [[0.0], [1], [2]])
    assert ink_match.weighed(at(calm, drawn(calm))) == ink_match.Weight(0.0, 0.0)


@pytest.mark.parametrize("below", [True, False])
def test_ink_on_one_side_of_a_curve_is_half_of_what_chance_would_have(below: bool) -> None:
    alone = replace(CURVES, values=WAVES[:1])
    columns, (rows,) = at(alone).rows()
    side = np.zeros((HEIGHT, WIDTH), bool)
    side[:, columns.astype(int)] = (np.arange(HEIGHT)[:, None] > rows) == below
    ink = Ink(drawn(alone).near | side, blank().rough)
    evidence = ink_match.weighed(at(alone, ink)).evidence
    assert evidence == pytest.approx(np.abs(np.diff(rows)).sum() / 4 * ink_match._surprise(1.0, 0.5), rel=0.2)


def test_every_row_on_the_way_counts_once() -> None:
    down, across = ink_match._rises(np.array([10.0, 20, 30]), np.array([[0.0, 10, 0], [5, 5, 5]]))
    assert down.tolist() == [*range(11), *range(9, 0, -1)]
    assert across.tolist() == list(range(10, 30))


@pytest.mark.parametrize(
    ("share", "chance", "nats"),
    [
        (0.5, 0.1, 0.5 * math.log(5) + 0.5 * math.log(0.5 / 0.9)),
        (0.9, 0.3, 0.9 * math.log(3) + 0.1 * math.log(1 / 7)),
        (0.3, 0.3, 0.0),
        (0.2, 0.3, 0.0),
        (1.0, 0.1, 0.999 * math.log(9.99) + 0.001 * math.log(1 / 900)),
        (1.0, 1.0, 0.0),
    ],
)
def test_an_observation_surprises_by_what_it_is_beyond_chance(share: float, chance: float, nats: float) -> None:
    assert ink_match._surprise(share, chance) == pytest.approx(nats)


def test_the_search_looks_half_evenly_and_half_where_curves_move() -> None:
    values = np.zeros((1, 200))
    values[0, 100:] = np.arange(100) ** 2
    few = ink_match._telling(values)
    assert (few[0], few[-1], len(few)) == (0, 199, 40)
    assert np.count_nonzero(few < 100) == pytest.approx(10, abs=1)
    assert np.count_nonzero(few >= 170) == pytest.approx(13, abs=1)
    assert ink_match._telling(values[:, 90:120]).tolist()[-1] == 29
    assert len(ink_match._telling(values[:, 90:120])) == 30
