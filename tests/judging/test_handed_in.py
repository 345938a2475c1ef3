"""When a picture that was handed in counts, and when it is told that code does not draw it: by made-up students and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
import pytest

from grader.engine.figures import Figure, Picture, Stray
from grader.engine.findings import A_PERSON_MAY, Fault, Missing
from grader.engine.traces import Traces
from grader.labs.imu.answers import KEYS, Drawing
from grader.labs.imu.checks import handed_in
from grader.labs.imu.checks.plot_runs import series_of
from tests.judging.made import truth
from tests.judging.test_check_visualization import Plotted, Sheet, _compared, _curve, _figure, _with_curves

pytestmark = pytest.mark.quick
PREVIEW, PALETTE = np.zeros((60, 80), np.uint8), np.full((256, 3), 255, np.uint8)
SEEN = Picture((800, 600), 0.2, PREVIEW, PALETTE)
FAULT = Fault("ValueError", "broken", "imu_reader.py", 7, None)
NOTHING = Drawing(())


class Handing(Plotted):
    """One that hands in a picture of that name beside its code."""

    def __init__(self, drawing: Drawing = NOTHING, *scripts: Drawing, picture: Picture | None = SEEN, raises: bool = False) -> None:  # fmt: skip
        super().__init__(drawing, scripts, {"imu_data.png": picture})
        self.files, self._raises = {"imu_data.png": b""}, raises

    def plot(self, *given: Any, **more: Any) -> Drawing:
        if self._raises:
            raise Missing("plot_imu_data", "name-missing", "nobody made it")
        return super().plot(*given, **more)


@pytest.fixture
def shown() -> Iterator[set[int]]:
    """The sensors that the picture shows: both, unless a test says otherwise."""
    sensors = {0, 1}

    def looked(preview: np.ndarray, palette: np.ndarray, series: Mapping[str, np.ndarray]) -> set[int]:
        assert (preview is PREVIEW, palette is PALETTE) == (True, True)
        assert all(np.array_equal(series[key], truth()["push"][key]) for key in KEYS)
        return sensors

    with mock.patch.object(handed_in, "sensors_shown", looked):
        yield sensors


@pytest.mark.parametrize(
    ("picture", "something"),
    [
        (SEEN, True),
        (None, False),
        (replace(SEEN, ink=0.005), False),
        (replace(SEEN, ink=0.006), True),
        (replace(SEEN, ink=0.59), True),
        (replace(SEEN, ink=0.6), False),
        (replace(SEEN, size_px=(149, 600)), False),
        (replace(SEEN, size_px=(600, 149)), False),
        (replace(SEEN, size_px=(150, 150)), True),
    ],
)
def test_a_picture_that_may_be_a_plot_shows_something(picture: Picture | None, something: bool) -> None:
    assert handed_in.shows_something(Handing(picture=picture), "imu_data.png") is something
    assert not handed_in.shows_something(Handing(picture=picture), "another.png")


# --- which counts --------------------------------------------------------------------------------------------------------


def drawing(*figures: Figure, **more: Any) -> Drawing:
    """Of figures whose pixels came along."""
    pixels = np.zeros((2, 2, 3), np.uint8)
    return Drawing(tuple(replace(figure, pixels=pixels) for figure in figures), **more)


def _named(figure: Figure, name: str) -> Figure:
    return replace(figure, path=f"plots/{name}")


def _upper(figure: Figure) -> Figure:
    return replace(figure, axes=figure.axes[:1])


def _twice(figure: Figure) -> Figure:
    return replace(figure, axes=figure.axes * 2)


SHEET, EMPTY, COMPARED = Sheet().figure, replace(Sheet().figure, axes=()), _compared().figures[0]
UNLIKE, BY_NAME = (
    _compared("one", "two", other=np.array).figures[0],
    _compared("raw", "filtered", other=np.cos).figures[0],
)
BESIDE_CODE: dict[str, tuple[Handing, bool]] = {
    "no code": (Handing(), True),
    "code that is missing": (Handing(raises=True), True),
    "axes without curves": (Handing(drawing(EMPTY)), True),
    "a plot": (Handing(drawing(SHEET)), False),
    "a plot of something else": (Handing(drawing(UNLIKE)), False),
    "a plot by a script": (Handing(NOTHING, drawing(SHEET)), False),
    "a plot by a second script": (Handing(NOTHING, drawing(EMPTY), drawing(EMPTY, SHEET)), False),
    "one panel by a script under another name": (Handing(NOTHING, drawing(_named(_upper(SHEET), "a.png"))), True),
    "one panel by a script under its name": (Handing(NOTHING, drawing(_named(_upper(SHEET), "imu_data.png"))), False),
    "axes without curves by a script under its name": (Handing(NOTHING, drawing(EMPTY)), True),
    "a comparison by a script": (Handing(NOTHING, drawing(_named(COMPARED, "a.png"))), True),
    "a comparison in two panels": (Handing(NOTHING, drawing(_named(_twice(COMPARED), "a.png"))), True),
    "a comparison by its words alone": (Handing(NOTHING, drawing(_named(_twice(BY_NAME), "a.png"))), True),
    "a comparison by its file alone": (Handing(NOTHING, drawing(_named(_twice(UNLIKE), "filtered.png"))), True),
    "something else in two panels": (Handing(NOTHING, drawing(_named(_twice(UNLIKE), "a.png"))), False),
    "a tiny picture": (Handing(picture=replace(SEEN, size_px=(149, 600))), False),
    "a small picture": (Handing(picture=replace(SEEN, size_px=(150, 600))), True),
    "no picture": (Handing(picture=None), False),
}


@pytest.mark.usefixtures("shown")
@pytest.mark.parametrize(("student", "counts"), BESIDE_CODE.values(), ids=BESIDE_CODE)
def test_a_picture_counts_where_no_code_draws_a_plot(student: Handing, counts: bool) -> None:
    student.notes.clear()
    assert handed_in.counts(student, truth()) is counts
    told = (
        f"imu_data.png was handed in, and no code draws it. The grader cannot read its labels; {A_PERSON_MAY} for them"
    )
    assert student.notes == ([told] if counts else [])


@pytest.mark.parametrize("sensors", [set(), {0}, {1}])
def test_a_picture_that_does_not_show_both_sensors_does_not_count(shown: set[int], sensors: set[int]) -> None:
    shown.intersection_update(sensors)
    student = Handing()
    assert not handed_in.counts(student, truth())
    assert student.notes == []


def test_of_the_labs_robot_the_public_run_is_looked_for_and_of_another_its_own() -> None:
    secret = replace(truth(), name="secret")
    assert handed_in._public(secret).name == truth().name
    with mock.patch.object(handed_in, "is_of", lambda _, traces: traces is not secret):
        assert handed_in._public(secret) is secret


# --- which is another one than the code draws ---------------------------------------------------------------------------

TIME = truth()["tumbling"]["time"]


def _of(*rows: np.ndarray, **words: Any) -> Figure:
    curves = [_curve(TIME, row, "x", "#ff0000") for row in rows]
    return replace(_figure(_with_curves(Sheet().panels[0], *curves)), **words)


REST = np.full(len(TIME), 9.81)
ACCEL, RATE = (truth()["tumbling"][key].T for key in ("acceleration", "angular_velocity"))
RESTING, ACCELERATED, TURNED = _of(REST), _of(*ACCEL), _of(*RATE)
AGAINST_CODE: dict[str, tuple[Handing, str]] = {
    "the plot": (Handing(drawing(SHEET)), ""),
    "the acceleration": (Handing(drawing(ACCELERATED)), "angular velocity"),
    "two axes of the acceleration": (Handing(drawing(_of(*ACCEL[:2]))), "angular velocity"),
    "the angular velocity": (Handing(drawing(TURNED)), "acceleration"),
    "nothing that moves": (Handing(drawing(RESTING)), "acceleration and angular velocity"),
    "both in other units": (Handing(drawing(_of(*(3 + 7 * ACCEL), *(5 * RATE)))), ""),
    "nothing at all": (Handing(), ""),
    "axes without curves": (Handing(drawing(EMPTY)), ""),
    "code that is missing": (Handing(raises=True), ""),
    "one sensor, and then an exception": (Handing(drawing(ACCELERATED, fault=FAULT)), ""),
    "one sensor, and a picture of it": (Handing(drawing(ACCELERATED, strange=(Stray("a.png", ""),))), ""),
    "one sensor, and a picture that is broken": (Handing(drawing(ACCELERATED, strange=(Stray("a.png", "OSError"),))), "angular velocity"),
    "one sensor, and a figure that cannot be read": (Handing(Drawing((*drawing(ACCELERATED).figures, EMPTY))), ""),
    "one sensor, and the other by a script": (Handing(drawing(ACCELERATED), drawing(_named(TURNED, "imu_data.png"))), ""),
    "one sensor, and again by a script": (Handing(drawing(ACCELERATED), drawing(ACCELERATED)), "angular velocity"),
    "one sensor, and a script that broke": (Handing(drawing(ACCELERATED), drawing(ACCELERATED, fault=FAULT)), ""),
    "the rate, and a comparison of the acceleration by a script": (Handing(drawing(TURNED), drawing(_named(COMPARED, "b.png"))), "acceleration"),
    "the rate, and a comparison under the name of the plot": (Handing(drawing(TURNED), drawing(_named(COMPARED, "imu_data.png"))), ""),
    "one sensor, and an axis of the other by a script under another name": (Handing(drawing(ACCELERATED), drawing(_named(_of(RATE[0]), "a.png"))), ""),
    "one sensor, and more than a hundred curves by a script": (Handing(drawing(ACCELERATED), drawing(_named(_of(*[REST] * 101), "imu_data.png"))), ""),
    "a hundred curves": (Handing(drawing(_of(*[REST] * 99, REST + 1))), "acceleration and angular velocity"),
    "more than a hundred curves": (Handing(drawing(_of(*[REST] * 101))), ""),
    "a tiny picture": (Handing(drawing(ACCELERATED), picture=replace(SEEN, size_px=(600, 149))), ""),
    "no picture that can be read": (Handing(drawing(ACCELERATED), picture=None), ""),
}  # fmt: skip


@pytest.mark.usefixtures("shown")
@pytest.mark.parametrize(("student", "missing"), AGAINST_CODE.values(), ids=AGAINST_CODE)
def test_a_picture_of_what_no_code_draws_is_told_to_whoever_looks(student: Handing, missing: str) -> None:
    student.notes.clear()
    handed_in.hold_against_code(student, truth())
    told = (
        "imu_data.png was handed in and shows both sensors. The plot that the code draws shows no "
        f"{missing}: the picture may come from another version of the code"
    )
    assert student.notes == ([told] if missing else [])


def test_a_picture_that_does_not_show_both_sensors_is_not_held_against_the_code(shown: set[int]) -> None:
    shown.remove(0)
    student = Handing(drawing(ACCELERATED))
    handed_in.hold_against_code(student, truth())
    assert student.notes == []


@pytest.mark.usefixtures("shown")
def test_without_a_picture_nothing_is_looked_at() -> None:
    student = Handing(drawing(ACCELERATED))
    student.files = {}
    handed_in.hold_against_code(student, truth())
    assert student.notes == []


@pytest.mark.parametrize("run", ["tumbling", "push"])
@pytest.mark.usefixtures("shown")
def test_curves_of_either_run_are_of_their_sensor(run: str) -> None:
    recorded = truth()[run]
    curves = [_curve(recorded["time"], row, "x", "#ff0000") for row in recorded["acceleration"].T]
    student = Handing(drawing(_figure(_with_curves(Sheet().panels[0], *curves))))
    handed_in.hold_against_code(student, truth())
    assert len(student.notes) == 1
    assert "shows no angular velocity" in student.notes[0]


@pytest.mark.usefixtures("shown")
def test_pictures_are_held_against_the_public_run_and_curves_against_that_as_well() -> None:
    secret, asked = replace(truth(), name="secret"), []

    def series(traces: Traces, run: str = "tumbling") -> Mapping[str, np.ndarray]:
        asked.append((traces.name, run))
        return series_of(traces, run)

    with mock.patch.object(handed_in, "series_of", series):
        assert handed_in._shows_both(SEEN, secret)
        handed_in._missing_from([], secret)
    public = truth().name
    assert asked == [(public, "push"), ("secret", "tumbling"), ("secret", "push"), (public, "push")]
