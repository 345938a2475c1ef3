"""The four extensions: the reference's are right, sound ones of any style are passed, each known fault is named."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

import reference
from grader.engine import rubric, traces
from grader.engine.grader import Marker
from grader.engine.results import ExtensionResult, Result, from_dict, to_dict
from grader.engine.submission_session import SubmissionSession
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.bonuses import allan_variance, complementary_filter, live_plot
from grader.labs.imu.lab import LAB
from reference.allan_variance import allan_deviation
from reference.complementary_filter import ComplementaryFilter, tilt_of
from reference.extension_scenarios import tilt_drifting, tilt_shaken, tilt_steep, true_tilt
from reference.scene import Recording, generator
from tests.corpus.cases import EXTENSIONS, Case, case, of
from tests.corpus.pieces import tidy
from tests.rubrics import edited
from tests.sandboxes import Opened
from tests.single_faults import marked

FOLDER = Path(reference.__file__).parent
ENDLESS = [case for case in of("extensions") if case.fault == "never-returns"]


@pytest.fixture(scope="module")
def truth(cache: Path) -> traces.Traces:
    """The public bundle, recorded anew where the simulator is another version than the one that recorded it."""
    return bundles.obtain(LAB, None, cache)


Mark = Callable[..., Result]


@pytest.fixture
def mark(marker: Marker) -> Mark:
    """Mark a sound submission with these files."""
    return lambda files, *only: marked(marker, {**tidy(), **files}, *only)


def lost(result: ExtensionResult) -> set[str]:
    return {check.id for check in result.checks if check.outcome != "passed"}


# --- marking --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("faulty", ENDLESS, ids=lambda faulty: faulty.name)
def test_an_extension_that_never_returns_is_stopped(faulty: Case, truth: traces.Traces, opened: Opened) -> None:
    with opened(truth, replace(rubric.load(LAB), limits=rubric.Limits(1.0, 20.0))) as impatient:
        result = marked(impatient, {**tidy(), **faulty.files}, faulty.only)
    assert lost(result.extensions[0]) == set(faulty.loses)
    assert result.extensions[0].checks[0].outcome == "timeout"
    assert result.misconceptions == (faulty.fault,)


def test_without_extensions_no_question_is_asked_about_them(mark: Mark, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    ask = SubmissionSession.ask

    def noting(self: SubmissionSession, op: str, *rest: Any) -> Any:
        asked.append(op)
        return ask(self, op, *rest)

    monkeypatch.setattr(SubmissionSession, "ask", noting)
    result = mark({})
    assert {"read", "filter"} <= set(asked)
    assert not {"tilt", "allan", "imus", "live"} & set(asked)
    assert [(e.attempted, e.checks, e.points) for e in result.extensions] == [(False, (), 0.0)] * 4
    assert to_dict(result)["extensions"][1] == {
        "id": "allan_variance", "attempted": False, "points": 0.0, "max_points": 0.0, "checks": []
    }  # fmt: skip


def test_extensions_that_crash_or_meddle_leave_the_five_criteria_alone(mark: Mark) -> None:
    meddling = "import imu_reader\nimu_reader.get_imu_readings = None\nimport os\nos._exit(3)\n"
    result = mark(dict.fromkeys(EXTENSIONS.values(), meddling))
    assert (result.status, [criterion.points for criterion in result.criteria]) == ("graded", [20.0] * 5)
    assert all(extension.attempted and lost(extension) for extension in result.extensions)


def test_an_extension_in_another_file_counts_and_the_note_says_where(mark: Mark) -> None:
    blocks = case("extensions", "allan_variance-blocks").files["allan_variance.py"]
    result = mark({"extras.py": blocks}, "allan_variance")
    assert lost(result.extensions[0]) == set()
    assert result.notes == ("allan_deviation was found in extras.py; the sheet expects it in allan_variance.py",)


@pytest.mark.parametrize(
    ("files", "attempted"),
    [
        ({"allan_variance.py": b""}, True),
        ({"mine.py": b"def  allan_deviation(x, f): ..."}, True),
        ({"lab.ipynb": b'"source": ["%%writefile allan_variance.py\\n"]'}, True),
        ({"mine.py": b"# allan_deviation is for next week\nx = allan_deviation"}, False),
        ({"notes.txt": b"def allan_deviation(x, f): ..."}, False),
        ({}, False),
    ],
)
def test_an_extension_is_attempted_where_its_file_or_its_name_is(files: dict[str, bytes], attempted: bool) -> None:
    bonus = LAB.part("allan_variance")
    assert bonus is not None
    assert bonus.attempted_in(files) is attempted


# --- extra credit ---------------------------------------------------------------------------------------------------


GRANTED = rubric.parse(LAB, edited("# extra_credit: {each: 5, cap: 10}", "extra_credit: {each: 5, cap: 10}").encode())


def test_extra_credit_stands_beside_the_score_up_to_the_cap(truth: traces.Traces, opened: Opened) -> None:
    with opened(truth, GRANTED) as marker:
        result = marker.mark(read_submission(FOLDER, LAB.files))  # the reference, which passes all of its own
        partly = marked(marker, {**tidy(), **case("extensions", "no-half").files})
    assert {e.id: lost(e) for e in result.extensions} == {bonus.id: set() for bonus in LAB.bonuses}
    assert [(e.points, e.max_points) for e in result.extensions] == [(5.0, 5.0)] * 4
    assert (result.score, result.max_score, result.extra_credit, result.total) == (100.0, 100.0, 10.0, 110.0)
    record = to_dict(result)
    assert record["extra_credit"] == {"points": 10.0, "cap": 10.0}
    assert from_dict(record) == result
    assert partly.score == 100.0
    assert partly.extra_credit == partly.extensions[1].points == pytest.approx(5.0 * 8 / 14, abs=0.01)


# --- the reference: tilt --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.4, -0.3), (-1.2, 1.3), (2.5, 0.2), (0.0, -1.5)])
def test_tilt_and_truth_agree_for_a_sensor_at_rest(roll: float, pitch: float) -> None:
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    ned_from_body = np.array([[cp, sr * sp, cr * sp], [0.0, cr, -sr], [-sp, sr * cp, cr * cp]])
    world_from_body = np.diag([1.0, -1.0, -1.0]) @ ned_from_body
    reading = world_from_body.T @ [0.0, 0.0, 9.81]
    assert tilt_of(reading) == pytest.approx((roll, pitch))
    assert true_tilt(world_from_body) == pytest.approx([roll, pitch])


RIDES = (
    (tilt_drifting, ("gyro_alone_rms",), 3.0), (tilt_shaken, ("accel_alone_rms",), 1.4),
    (tilt_steep, ("accel_alone_rms", "gyro_alone_rms"), 1.4),
)  # fmt: skip


@pytest.mark.parametrize(("ride", "singles", "factor"), RIDES)
def test_on_any_hidden_motion_the_sheets_filter_is_far_above_the_limit(
    ride: Callable[..., Recording], singles: tuple[str, ...], factor: float, truth: traces.Traces
) -> None:
    """Eight motions each; the logarithms of the margins lie six of their deviations or more above zero."""
    gimbal = mujoco.MjModel.from_xml_string(truth.models["gimbal"])
    margins = []
    for seed in range(8):
        scene = SimpleNamespace(rng=generator("hidden", str(seed), ride.__name__), gimbal=gimbal)
        recording = ride(scene)
        attitude = ComplementaryFilter(recording.scalars["dt"])
        rows = zip(recording.arrays["acceleration"], recording.arrays["angular_velocity"], strict=True)
        estimate = np.array([attitude.update(*row) for row in rows])
        error = np.angle(np.exp(1j * (estimate - recording.arrays["tilt"])))[len(estimate) // 2 :]
        alone = np.array([recording.scalars[single] for single in singles])
        margins.append(np.log(alone / factor / np.sqrt(np.mean(error**2))))
    assert np.min(margins) > math.log(2.0)
    assert (np.mean(margins, axis=0) > 5.0 * np.std(margins, axis=0)).all()


# --- the reference: Allan deviation ---------------------------------------------------------------------------------


def test_the_allan_deviation_is_that_of_an_independent_program(truth: traces.Traces) -> None:
    """One test, not one a kind of noise: each test worker would import scipy.stats with the program."""
    import allantools

    scenario = truth["allan"]
    rate = scenario.scalars["sample_rate_hz"]
    for kind in ("white", "walk", "quantised", "drift", "mixed"):
        taus, adev = allan_deviation(scenario[kind], rate)
        theirs_taus, theirs, _, _ = allantools.oadev(scenario[kind], rate=rate, data_type="freq", taus=taus[:-2])
        ours = dict(zip(taus.round(9), adev, strict=True))
        assert len(theirs_taus) >= len(taus) - 4
        # Both sum 4,000 numbers in double precision, one of them after integrating: 1e-12 of the largest second difference.
        np.testing.assert_allclose([ours[tau] for tau in theirs_taus.round(9)], theirs, rtol=1e-8, err_msg=kind)
        np.testing.assert_allclose(scenario[f"{kind}_adev"], adev, rtol=1e-9, err_msg=kind)


# --- what only a hostile program returns ------------------------------------------------------------------------------

ODD = [np.nan, np.inf, -np.inf, 0.0, -1.0, 1e308, 5e-324]


@pytest.mark.parametrize("odd", ODD)
def test_numbers_of_no_sense_are_judged_without_an_exception(odd: float, truth: traces.Traces) -> None:
    samples, watched = truth["allan"]["white"], truth["watched"]
    with np.errstate(all="ignore"):
        for taus, curve in ((np.full(20, odd), np.ones(20)), (np.arange(1.0, 21.0), np.full(20, odd))):
            assert allan_variance.meaning([(taus, curve, samples)], 50.0).fault is None
            allan_variance.slopes((taus, curve, samples), allan_variance.in_seconds, 50.0)
        for x, y in ((np.full(30, odd), np.arange(30.0)), (np.arange(30.0), np.full(30, odd) + np.arange(30.0))):
            assert not live_plot.shows(x, y, watched["pushed"], 0.004)
        run = live_plot.LiveRun(np.full((5, 3), odd), (), 1.0)
        assert run.updates <= 1
        assert run.span >= 0 or np.isnan(run.span)
        assert run.changes_after >= 0
        outputs = [np.full((complementary_filter.BEFORE + complementary_filter.AFTER, 2), odd)] * 3
        seen = complementary_filter.response(outputs)
        assert seen is None or not any(holds(seen) for holds in complementary_filter.FAULTS.values())
