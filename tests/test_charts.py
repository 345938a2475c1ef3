from __future__ import annotations

import base64
import io
import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grader.engine import traces
from grader.engine.chart_data import Chart, Evidence, Panel, packed, unpacked
from grader.engine.grader import Marker
from grader.engine.results import to_json
from grader.engine.submission_session import SubmissionSession
from grader.intake import read_submission
from grader.labs.imu import bundles, charts
from grader.labs.imu.answers import FilterRun, NoiseRun
from grader.labs.imu.charts import filtering, motion, noise, points
from grader.labs.imu.collection import Collection
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.report import charts as drawing
from grader.report.pages import report_page
from tests.examples import FOLDER
from tests.fake_results import result as made_up
from tests.sandboxes import Opened

TRUTH = bundles.shipped()
SHEET = read_submission(FOLDER / "s01-sheet-verbatim", LAB.files)


def panels(chart: Chart | None) -> dict[str, Panel]:
    return {panel.title: panel for panel in chart.panels} if chart else {}


def series(**more: Any) -> Collection:
    rows = int(TRUTH["push"].scalars["n_steps"])
    sound = {key: np.array(TRUTH["push"][key][:rows]) for key in ("time", "acceleration", "angular_velocity")}
    return Collection(**{**sound, **more})


def white(seed: int = 0, size: float = 1.0) -> NoiseRun:
    """What a sound NoisyIMU answers to the question of the public noise scenario."""
    rng, scenario = np.random.default_rng(seed), TRUTH["noise"]
    stds = scenario.scalars["accel_noise_std"], scenario.scalars["gyro_noise_std"]
    reads = [
        scenario[clean][:, None] + scenario[bias] + size * rng.normal(0.0, std, (2, 1250, 3))
        for clean, bias, std in zip(
            ("acceleration", "angular_velocity"), ("accel_bias", "gyro_bias"), stds, strict=True
        )
    ]
    return NoiseRun(reads[0], reads[1], np.zeros((2, 4)), None, None)


# --- what is gathered -----------------------------------------------------------------------------------------------


def test_a_sound_submission_has_every_chart_and_asks_nothing_more_for_them(
    marker: Marker, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    really, gather = SubmissionSession.ask, charts.charts

    def counted(student: SubmissionSession, op: str, *args: Any, **kwargs: Any) -> Any:
        asked.append(op)
        return really(student, op, *args, **kwargs)

    def gathered(student: SubmissionSession, truth: traces.Traces) -> tuple[Chart, ...]:
        before = len(asked)
        found = gather(student, truth)
        assert len(asked) == before > 5
        return found

    monkeypatch.setattr(SubmissionSession, "ask", counted)
    monkeypatch.setattr(charts, "charts", gathered)
    result = marker.mark(SHEET)
    shown = unpacked(result.evidence.charts)
    assert [(chart.part, chart.title) for chart in shown] == [
        ("data_collection", "Your series and the truth"),
        ("visualization", "What plot_imu_data draws"),
        ("visualization", "What your files draw"),
        ("noise_model", "Distribution of your noise"),
        ("noise_model", "Allan deviation of your noise"),
        ("filtering", "Your filter at work"),
    ]
    assert shown[0].caption.endswith("They agree within 0.002 m/s² and 0.0002 rad/s.")
    fed = [chart.title for chart in shown if "The grader plotted a test recording" in chart.caption]
    assert fed == ["What plot_imu_data draws"]
    legend = [each.name for each in drawing.views(shown[2])[0].legend]
    assert legend == ["Raw Z-acceleration", "Filtered Z-acceleration", "True gravity"]
    page = report_page(FinalGrade("x", result), shown)
    planes = sum(len(chart.panels) for chart in shown)
    assert page.count('<svg class="plane"') == planes == 11  # two flat differences are a sentence
    assert len(page.encode()) < 400_000
    assert "charts" not in json.loads(to_json(result))


def test_of_hidden_scenarios_nothing_is_drawn_but_a_picture_that_no_code_draws_is_shown_from_its_pixels(
    opened: Opened,
) -> None:
    reader = SHEET.files["imu_reader.py"].decode().partition("def plot_imu_data")[0]
    plain = {
        "imu_reader.py": f"{reader}def plot_imu_data(imu_data):\n    pass\n".encode(),
        "imu_data.png": SHEET.files["imu_data.png"],
        "filtered_imu.png": b"\x89PNG no picture",
    }
    with opened(replace(TRUTH, name="hidden")) as marker:
        filtered = marker.mark(SHEET, only="filtering")
        result = marker.mark(replace(SHEET, files=plain), only="visualization")
    assert (filtered.score, filtered.evidence.charts) == (20, b"")
    assert filtered.evidence.fingerprint
    (shown,) = unpacked(result.evidence.charts)
    assert shown.title == "imu_data.png as it was handed in"
    content = base64.b64decode(shown.png)
    assert len(content) < 40_000
    with Image.open(io.BytesIO(content)) as picture:
        assert (picture.format, picture.mode, picture.size) == ("PNG", "P", (640, 427))
        assert {"Software", "comment"}.isdisjoint(picture.info)
        orange = 255, 126, 11
        assert picture.convert("RGB").getpixel((74, 43)) == pytest.approx(orange, abs=8)
    assert f'<img src="data:image/png;base64,{shown.png}"' in report_page(FinalGrade("x", result), (shown,))


def test_charts_that_cannot_be_gathered_cost_no_mark(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(charts, "charts", broken)
    result = marker.mark(SHEET, only="filtering")
    assert (result.status, result.score, result.evidence) == ("graded", 20, Evidence())


# --- what they show -------------------------------------------------------------------------------------------------


def test_a_single_wrong_row_is_seen_however_many_rows_there_are() -> None:
    wrong = np.array(series().acceleration)
    row = 777 % len(wrong)
    wrong[row, 1] += 5.0
    chart = motion.chart(series(acceleration=wrong), TRUTH["push"])
    residual = panels(chart)["Acceleration: yours minus the truth"]
    assert max(residual.curves[1].y) == pytest.approx(5.0, rel=1e-3)
    assert str(chart and chart.caption).endswith(f"Largest difference: 5 m/s² at {TRUTH['push']['time'][row]:.3g} s.")


ODD = {
    "nan": np.full((1200, 3), np.nan),
    "huge": np.full((1200, 3), 1e308),
    "one row": np.zeros((1, 3)),
    "no row": np.zeros((0, 3)),
    "too many rows": np.full((9000, 3), -1e11),
}


@pytest.mark.parametrize("odd", ODD.values(), ids=ODD)
def test_odd_numbers_make_a_record_and_a_page(odd: np.ndarray) -> None:
    with np.errstate(all="ignore"):
        found = [
            motion.chart(series(acceleration=odd), TRUTH["push"]),
            *noise.charts(replace(white(), accel=np.resize(odd, (2, 1250, 3))) if odd.size else None, TRUTH),
            filtering.chart([FilterRun(odd, None, None)], TRUTH["filter"]),
        ]
    known = tuple(chart for chart in found if chart is not None)
    assert unpacked(packed(known)) == known
    assert "<svg" in report_page(FinalGrade("x", made_up()), tuple(replace(c, part="sensor_access") for c in known))


def test_the_allan_plot_of_white_noise_lies_on_the_line_that_was_asked_for() -> None:
    for panel in noise.charts(white(), TRUTH)[1].panels:
        asked, found = panel.curves
        assert asked.x == found.x
        assert asked.x[0] == pytest.approx(TRUTH["push"].scalars["timestep"])
        ratio = np.array(found.y) / np.array(asked.y)
        # 6 records of 1,250 reads: the estimate at 125 reads a cluster scatters by some 15 %, at one read by 1 %
        assert ratio[0] == pytest.approx(1.0, abs=0.06)
        assert np.all(np.abs(ratio - 1) < 0.6)


def test_the_gain_of_the_sheets_filter_is_found_to_two_percent() -> None:
    scenario = TRUTH["filter"]
    chart = filtering.chart([FilterRun(scenario["low_passed"][0], None, None)], scenario)
    sheet, own = panels(chart)["Gain"].curves
    assert own.y == pytest.approx(sheet.y, rel=0.02)
    omega = 2 * np.pi * np.array(sheet.x)
    assert sheet.y == pytest.approx(np.abs(0.1 / (1 - 0.9 * np.exp(-1j * omega))), rel=0.01)


@pytest.mark.parametrize("n", [1, 200, 201, 399, 1501])
def test_thinned_errors_keep_the_largest_and_are_no_more_than_asked_for(n: int) -> None:
    error = np.random.default_rng(n).normal(size=n)
    kept = points.worst_of_each(error, 200)
    assert len(kept) <= 200
    assert np.abs(error).argmax() in kept
