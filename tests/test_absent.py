"""What is not there is not right: a check whose evidence is taken out of a sound submission's answers never passes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

from grader.labs.imu.lab import LAB
from grader.sandbox.wire import Frame
from tests.corpus.pieces import tidy
from tests.fuzz.answers import Bench

EMPTIED: Mapping[tuple[str, tuple[str, ...]], set[str]] = {
    ("read", ("arrays",)): {
        "sensor_access.matches_truth", "sensor_access.follows_address", "sensor_access.reading_is_a_copy",
        "sensor_access.leaves_simulation_alone",
    },
    ("read", ("calls",)): {"sensor_access.returns_two_vectors"},
    ("simulate", ("a0",)): {"data_collection.returns_named_arrays"},
    ("simulate", ("arrays",)): {
        f"data_collection.{name}" for name in ("matches_truth", "time_axis", "starts_from_reset", "applies_push")
    },
    ("simulate", ("value",)): {"data_collection.sample_count"},
    ("noise", ("arrays",)): {
        f"noise_model.{name}"
        for name in ("noise_size", "given_bias", "white_and_gaussian", "axes_and_sensors_independent", "leaves_simulation_alone")
    },
    ("default_bias", ("arrays",)): {"noise_model.default_bias"},
    ("filter", ("arrays",)): {
        f"filtering.{name}"
        for name in (
            "follows_recursion", "starts_from_first_measurement", "passes_constant", "reduces_noise", "preserves_signal",
            "instances_independent",
        )
    },
    ("plot", ("figures",)): {"visualization.saves_image", "visualization.two_labelled_panels", "visualization.curves_match_data"},
    ("plot", ("figures", "*", "axes", "*", "title")): {"visualization.titles"},
    ("plot", ("figures", "*", "axes", "*", "ylabel")): {"visualization.axis_labels_with_units"},
    ("plot", ("figures", "*", "axes", "*", "xlabel")): {"visualization.axis_labels_with_units"},
    ("plot", ("figures", "*", "axes", "*", "legend")): {"visualization.legend_names_curves"},
    ("run_script", ("figures",)): {"visualization.comparison_plot"},
}  # fmt: skip
"""By question and by the place in its answers that is emptied: the checks that must lose points."""


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with Bench(tidy()).open() as opened:
        yield opened


@pytest.fixture(scope="module")
def sound(bench: Bench) -> dict[str, float]:
    return bench.points()


@pytest.mark.parametrize(("op", "place"), EMPTIED)
def test_a_check_without_its_evidence_loses_points(
    op: str, place: tuple[str, ...], bench: Bench, sound: dict[str, float]
) -> None:
    points = bench.points(lambda asked, frame: _emptied(frame, place) if asked == op else frame)
    kept = {name for name in EMPTIED[op, place] if points[name] >= sound[name]}
    assert kept == set(), (
        f"no points lost without {op} {'.'.join(place)}: a fault with the share 0 there, or evidence of another place"
    )


def test_every_check_has_evidence_that_can_be_taken_away() -> None:
    criteria = {part.id for part in LAB.parts}
    judged = {name for names in EMPTIED.values() for name in names}
    checks = {check for part in LAB.parts if part.id in criteria for check in _checks_of(part.id)}
    assert judged == checks, (
        "add the check to EMPTIED, at the place in the worker's answer without which it cannot pass"
    )


def _checks_of(criterion: str) -> set[str]:
    from grader.engine.check_runner import known_checks

    return {name for name in known_checks(LAB) if name.startswith(f"{criterion}.")}


def _emptied(frame: Frame, place: tuple[str, ...]) -> Frame:
    """Return an answer with no numbers in any array or in one, or with an empty list, dictionary or text at a place."""
    if place == ("arrays",):
        return Frame(frame.fields, {name: _without_numbers(array) for name, array in frame.arrays.items()})
    if place[0] in frame.arrays:
        return Frame(frame.fields, {**frame.arrays, place[0]: frame.arrays[place[0]][:0]})
    return Frame(_without(frame.fields, place), frame.arrays)


def _without_numbers(array: np.ndarray) -> np.ndarray:
    return np.full_like(array, np.nan) if array.dtype.kind == "f" else array


def _without(value: Any, place: tuple[str, ...]) -> Any:
    if not place:
        return type(value)()
    first, *rest = place
    if first == "*":
        return [_without(each, tuple(rest)) for each in value]
    return {**value, first: _without(value[first], tuple(rest))} if first in value else value
