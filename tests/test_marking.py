"""One submission and its marks: nothing is gained by tricks, nothing is told that is hidden, no fault of ours is a zero."""

from __future__ import annotations

from pathlib import Path

import pytest

from grader.engine import check_runner, rubric
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.engine.traces import Traces
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from tests.corpus.cases import case
from tests.corpus.writing import as_bytes, write
from tests.sandboxes import Opened

REPOSITORY = Path(__file__).resolve().parent.parent
_ZERO_READER = "\ndef get_imu_readings(model, data, accel_id, gyro_id):\n    return np.zeros(3), np.zeros(3)\n"


def _mark(marker: Marker, folder: Path, **changed: str) -> Result:
    sound = case("sound", "tidy_functions").files
    base = {name: as_bytes(content) for name, content in sound.items() if isinstance(content, str | bytes)}
    more = {name.replace("__", "."): as_bytes(text) for name, text in changed.items()}
    return marker.mark(read_submission(write({**base, **more}, folder), LAB.files))


def _source(name: str) -> str:
    content = case("sound", "tidy_functions").files[name]
    assert isinstance(content, str | bytes)
    return as_bytes(content).decode()


def test_the_reference_handed_in_scores_100(marker: Marker) -> None:
    result = marker.mark(read_submission(REPOSITORY / "reference", LAB.files))
    assert (result.status, result.score, result.misconceptions) == ("graded", 100.0, ())


@pytest.fixture(scope="module")
def honest(marker: Marker, tmp_path_factory: pytest.TempPathFactory) -> float:
    """The score of a submission whose reader gives zeros."""
    return _mark(
        marker, tmp_path_factory.mktemp("honest"), imu_reader__py=_source("imu_reader.py") + _ZERO_READER
    ).score


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
def test_a_wrong_reader_gains_nothing_by_a_trick(marker: Marker, honest: float, tmp_path: Path, trick: str) -> None:
    forged = _mark(marker, tmp_path / "forged", imu_reader__py=_source("imu_reader.py") + _ZERO_READER + trick)
    assert forged.score <= honest < 100


def test_a_conftest_and_a_site_customisation_are_not_run(marker: Marker, tmp_path: Path) -> None:
    bomb = "import os\nos._exit(0)\n"
    result = _mark(
        marker, tmp_path / "s", conftest__py=bomb, sitecustomize__py=bomb, pytest__ini="[pytest]\naddopts = -x\n"
    )
    assert result.score == 100


def test_leaving_without_an_answer_is_a_lost_check(marker: Marker, tmp_path: Path) -> None:
    leaving = _source("filters.py").replace(
        "def update(self", "def update(self, *a):\n        import os\n        os._exit(0)\n\n    def _old(self"
    )
    result = _mark(marker, tmp_path / "s", filters__py=leaving)
    points = {criterion.id: criterion.points for criterion in result.criteria}
    assert points == {
        "sensor_access": 20,
        "data_collection": 20,
        "visualization": 20,
        "noise_model": 20,
        "filtering": 0,
    }
    assert result.misconceptions == ("kills-its-process",)


def test_a_fault_of_the_grader_is_not_judged_and_never_a_zero(
    marker: Marker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> bool:
        raise ZeroDivisionError("a fault of ours")

    monkeypatch.setattr("grader.labs.imu.filtering.measure.Facts.noise_gain", property(broken))
    result = _mark(marker, tmp_path / "s")
    row = next(
        check for criterion in result.criteria for check in criterion.checks if check.id == "filtering.reduces_noise"
    )
    assert (result.status, row.outcome, row.points) == ("incomplete", "not_judged", None)
    assert row.message == "Not judged, through a fault of the grader: ZeroDivisionError: a fault of ours"


def test_checks_and_rubric_hold_the_same_ids() -> None:
    known = check_runner.known_checks(LAB)
    listed = [
        weight.id for part in (*rubric.load(LAB).criteria, *rubric.load(LAB).extensions) for weight in part.checks
    ]
    assert sorted(known) == sorted(listed)


def test_a_call_that_does_not_fit_is_told_as_that_on_hidden_runs(
    hidden: Traces, opened: Opened, tmp_path: Path
) -> None:
    reader = "\ndef get_imu_readings(model, data, a, g, frame):\n    return data.sensordata[:3], data.sensordata[3:6]\n"
    with opened(hidden) as marker:
        result = _mark(marker, tmp_path / "own", imu_reader__py=_source("imu_reader.py") + reader)
    told = result.criteria[0].checks[0].message
    assert told.endswith(
        "TypeError in the call itself, before a line of yours ran: compare its parameters with the sheet's"
    )


def test_hidden_data_is_not_told(hidden: Traces, opened: Opened, tmp_path: Path) -> None:
    spy = "\ndef get_imu_readings(model, data, accel_id, gyro_id):\n    raise ValueError(str(list(data.qpos)))\n"
    leaky = "\nclass LowPassFilter:\n    def __init__(self, alpha=0.1, initial_value=None):\n        pass\n    def update(self, x):\n        return str(list(x))\n"
    with opened(hidden) as marker:
        sound = _mark(marker, tmp_path / "sound")
        result = _mark(
            marker,
            tmp_path / "spy",
            imu_reader__py=_source("imu_reader.py") + spy,
            filters__py=_source("filters.py") + leaky,
        )
    assert sound.score == 100
    said = "\n".join(check.message for criterion in result.criteria for check in criterion.checks)
    for secret in (hidden["reading_lab"]["qpos"][0], hidden["filter"]["input"][0]):
        assert not any(f"{number:.3f}"[:-1] in said for number in secret if abs(number) > 1e-3)
    assert "Got       ValueError\n" in said + "\n"


def test_no_plugin_of_the_machine_takes_part_in_the_marking(request: pytest.FixtureRequest) -> None:
    """hypothesis brings one, which these tests themselves run with."""
    name = "hypothesispytest"
    assert request.config.pluginmanager.has_plugin(name)
    assert not any(item.config.pluginmanager.has_plugin(name) for item in check_runner.session(LAB)._items)
