"""One submission and its marks: nothing is gained by tricks, nothing is told that is hidden, no fault of ours is a zero."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.engine import check_runner, rubric
from grader.engine.grader import Marker
from grader.engine.traces import Traces
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import tidy
from tests.corpus.writing import Files
from tests.sandboxes import Opened
from tests.single_faults import marked

REPOSITORY = Path(__file__).resolve().parent.parent
_ZERO_READER = "\ndef get_imu_readings(model, data, accel_id, gyro_id):\n    return np.zeros(3), np.zeros(3)\n"


def _with(**ends: str) -> Files:
    """A sound submission, with code at the end of its reader or its filter."""
    files = tidy()
    return files | {f"{name}.py": files[f"{name}.py"] + code for name, code in ends.items()}


def test_the_reference_handed_in_scores_100(marker: Marker) -> None:
    result = marker.mark(read_submission(REPOSITORY / "reference", LAB.files))
    assert (result.status, result.score, result.misconceptions) == ("graded", 100.0, ())


@pytest.fixture(scope="module")
def honest(marker: Marker) -> float:
    """The score of a submission whose reader gives zeros."""
    return marked(marker, _with(imu_reader=_ZERO_READER)).score


@pytest.mark.parametrize(
    "trick",
    [
        "np.allclose = np.array_equal = lambda *a, **k: True\nnp.abs = lambda *a, **k: 0.0\n",
        "import json\njson.dumps = lambda *a, **k: '{}'\n",
        "class Yes(float):\n    __eq__ = __le__ = __ge__ = lambda *a: True\n    __sub__ = __rsub__ = lambda *a: Yes(0)\n"
        "def get_imu_readings(m, d, a, g):\n    return [Yes(0)] * 3, [Yes(0)] * 3\n",
        "import pytest\n",
        "import sys\nsys.modules['pytest'] = sys\nsys.exit = lambda *a: None\n",
    ],
    ids=["patches numpy", "patches json", "always equal", "wants pytest", "shadows pytest"],
)
def test_a_wrong_reader_gains_nothing_by_a_trick(marker: Marker, honest: float, trick: str) -> None:
    assert marked(marker, _with(imu_reader=_ZERO_READER + trick)).score <= honest < 100


def test_a_conftest_and_a_site_customisation_are_not_run(marker: Marker) -> None:
    bomb = "import os\nos._exit(0)\n"
    more = {"conftest.py": bomb, "sitecustomize.py": bomb, "pytest.ini": "[pytest]\naddopts = -x\n"}
    assert marked(marker, tidy() | more).score == 100


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
    shipped = rubric.load(LAB)
    listed = [weight.id for part in (*shipped.criteria, *shipped.extensions) for weight in part.checks]
    assert sorted(check_runner.known_checks(LAB)) == sorted(listed)


def test_a_call_that_does_not_fit_is_told_as_that_on_hidden_runs(hidden: Traces, opened: Opened) -> None:
    reader = "\ndef get_imu_readings(model, data, a, g, frame):\n    return data.sensordata[:3], data.sensordata[3:6]\n"
    with opened(hidden) as marker:
        result = marked(marker, _with(imu_reader=reader))
    told = result.criteria[0].checks[0].message
    assert told.endswith(
        "TypeError in the call itself, before a line of yours ran: compare its parameters with the sheet's"
    )


def test_no_plugin_of_the_machine_takes_part_in_the_marking(request: pytest.FixtureRequest) -> None:
    """hypothesis brings one, which these tests themselves run with."""
    name = "hypothesispytest"
    assert request.config.pluginmanager.has_plugin(name)
    assert not any(item.config.pluginmanager.has_plugin(name) for item in check_runner.session(LAB)._items)
