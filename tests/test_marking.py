"""One submission and its marks: the reference gets all, no fault of ours is a zero, no plugin of the machine takes part."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.engine import check_runner, rubric
from grader.engine.grader import Marker
from grader.engine.traces import Traces
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import tidy
from tests.sandboxes import Opened
from tests.single_faults import marked

REPOSITORY = Path(__file__).resolve().parent.parent


def test_the_reference_handed_in_scores_100(marker: Marker) -> None:
    result = marker.mark(read_submission(REPOSITORY / "reference", LAB.files))
    assert (result.status, result.score, result.misconceptions) == ("graded", 100.0, ())


def test_a_fault_of_the_grader_is_not_judged_and_never_a_zero(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> bool:
        raise ZeroDivisionError("a fault of ours")

    monkeypatch.setattr("grader.labs.imu.filtering.measure.Facts.noise_gain", property(broken))
    result = marked(marker, tidy())
    row = next(
        check for criterion in result.criteria for check in criterion.checks if check.id == "filtering.reduces_noise"
    )
    assert (result.status, row.outcome, row.points) == ("incomplete", "not_judged", None)
    assert row.message == "Not judged, through a fault of the grader: ZeroDivisionError: a fault of ours"


def test_checks_and_rubric_hold_the_same_ids() -> None:
    listed = [check.id for check in rubric.load(LAB).checks]
    assert sorted(check_runner.known_checks(LAB)) == sorted(listed)


def test_a_call_that_does_not_fit_is_told_as_that_on_hidden_runs(hidden: Traces, opened: Opened) -> None:
    reader = "\ndef get_imu_readings(model, data, a, g, frame):\n    return data.sensordata[:3], data.sensordata[3:6]\n"
    files = tidy()
    files["imu_reader.py"] += reader
    with opened(hidden) as marker:
        result = marked(marker, files)
    told = result.criteria[0].checks[0].message
    assert told.endswith(
        "TypeError in the call itself, before a line of yours ran: compare its parameters with the sheet's"
    )


def test_no_plugin_of_the_machine_takes_part_in_the_marking(request: pytest.FixtureRequest) -> None:
    """hypothesis brings one, which these tests themselves run with."""
    name = "hypothesispytest"
    assert request.config.pluginmanager.has_plugin(name)
    assert not any(item.config.pluginmanager.has_plugin(name) for item in check_runner.session(LAB)._items)
