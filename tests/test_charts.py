from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from PIL import Image

from grader.course.record import Key, Store
from grader.engine import traces
from grader.engine.chart_data import Chart, Evidence, Panel, Role, packed, unpacked
from grader.engine.figures import Sight
from grader.engine.grader import Marker
from grader.engine.results import to_json
from grader.engine.submission_session import Conversation
from grader.intake import read_submission
from grader.labs.imu import bundles, charts
from grader.labs.imu.answers import Collection, FilterRun, NoiseRun
from grader.labs.imu.charts import drawn, filtering, motion, noise
from grader.labs.imu.charts.points import curve, worst_of_each
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.report import charts as drawing
from grader.report.pages import report_page
from tests.examples import FOLDER
from tests.judging.test_check_visualization import Sheet
from tests.made_up import SHA
from tests.made_up import result as made_up
from tests.sandboxes import Opened

TRUTH = bundles.shipped()


def panels(chart: Chart | None) -> dict[str, Panel]:
    assert chart is not None
    return {panel.title: panel for panel in chart.panels}


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
    really, gather = Conversation.ask, charts.charts

    def counted(student: Conversation, *args: Any, **kwargs: Any) -> Any:
        asked.append(args[0])
        return really(student, *args, **kwargs)

    def gathered(student: Conversation, truth: traces.Traces) -> tuple[Chart, ...]:
        before = len(asked)
        found = gather(student, truth)
        assert len(asked) == before
        return found

    monkeypatch.setattr(Conversation, "ask", counted)
    monkeypatch.setattr(charts, "charts", gathered)
    result = marker.mark(read_submission(FOLDER / "s01-sheet-verbatim", LAB.files))
    assert len(asked) > 5
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
    assert (
        page.count('<svg class="plane"') == sum(len(chart.panels) for chart in shown) == 11
    )  # two flat differences are a sentence
    assert len(page.encode()) < 400_000
    assert "charts" not in json.loads(to_json(result))


def test_of_hidden_scenarios_nothing_is_drawn(opened: Opened) -> None:
    with opened(replace(TRUTH, name="hidden")) as marker:
        result = marker.mark(read_submission(FOLDER / "s01-sheet-verbatim", LAB.files), only="filtering")
    assert result.score == 20
    assert result.evidence.charts == b""
    assert result.evidence.fingerprint


def test_a_picture_that_no_code_draws_is_shown_from_its_pixels_whatever_the_scenarios(opened: Opened) -> None:
    sheet = read_submission(FOLDER / "s01-sheet-verbatim", LAB.files)
    reader = sheet.files["imu_reader.py"].decode().partition("def plot_imu_data")[0]
    plain = {
        "imu_reader.py": f"{reader}def plot_imu_data(imu_data):\n    pass\n".encode(),
        "imu_data.png": sheet.files["imu_data.png"],
        "filtered_imu.png": b"\x89PNG no picture",
    }
    with opened(replace(TRUTH, name="hidden")) as marker:
        result = marker.mark(replace(sheet, files=plain), only="visualization")
    (shown,) = unpacked(result.evidence.charts)
    assert shown.title == "imu_data.png as it was handed in"
    content = base64.b64decode(shown.png)
    assert len(content) < 40_000
    with Image.open(io.BytesIO(content)) as picture:
        assert (picture.format, picture.mode, picture.size) == ("PNG", "P", (640, 427))
        assert {"Software", "comment"}.isdisjoint(picture.info)
    assert f'<img src="data:image/png;base64,{shown.png}"' in report_page(FinalGrade("x", result), (shown,))


def test_charts_that_cannot_be_gathered_cost_no_mark(marker: Marker, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(charts, "charts", broken)
    result = marker.mark(read_submission(FOLDER / "s01-sheet-verbatim", LAB.files), only="filtering")
    assert (result.status, result.score, result.evidence) == ("graded", 20, Evidence())


def test_evidence_is_recorded_beside_the_result_and_changes_nothing_of_it(tmp_path: Path) -> None:
    shown = (motion.chart(series(), TRUTH["push"]),)
    assert shown[0] is not None
    result = replace(made_up(), evidence=Evidence(packed(shown), (3, 2**32 - 1)))  # type: ignore[arg-type]
    key = Key("a", SHA, SHA, SHA, "0.1.0")
    with Store(tmp_path) as store:
        store.keep(key, result)
    with Store(tmp_path) as store:
        assert store.recall(key) == made_up() == result
        assert store.charts("a") == shown
        assert store.fingerprints() == {"a": (3, 2**32 - 1)}
        assert store.charts("b") == ()


# --- what they show -------------------------------------------------------------------------------------------------


def test_a_single_wrong_row_is_seen_however_many_rows_there_are() -> None:
    wrong = np.array(TRUTH["push"]["acceleration"][: len(series().time)])  # type: ignore[arg-type]
    wrong[777 % len(wrong), 1] += 5.0
    chart = motion.chart(series(acceleration=wrong), TRUTH["push"])
    residual = panels(chart)["Acceleration: yours minus the truth"]
    assert max(residual.curves[1].y) == pytest.approx(5.0, rel=1e-3)
    assert chart is not None
    assert chart.caption.endswith(f"Largest difference: 5 m/s² at {TRUTH['push']['time'][777 % len(wrong)]:.3g} s.")


def test_thinning_takes_the_worst_of_each_stretch() -> None:
    error = np.zeros(1001)
    error[[3, 500, 1000]] = (1.0, -2.0, np.nan)
    kept = worst_of_each(error, 50)
    assert len(kept) <= 50
    assert {3, 500, 1000} <= set(kept.tolist())
    assert np.all(np.diff(kept) > 0)


def test_what_nobody_sees_of_what_was_drawn_is_set_as_that() -> None:
    """The last two of five seconds lie outside the limits of one curve; of another nothing can be seen; the third is whole."""
    seen, hidden = Sight(np.ones(100, bool), np.ones(100, bool)), Sight(np.ones(100, bool), np.zeros(100, bool))
    x = np.linspace(0.0, 5.0, 51)
    cut, covered = Sheet().panels
    cut = replace(cut, x_limits=(0.0, 3.0), y_limits=(-2.0, 2.0), curves=tuple(
        replace(each, x=x, y=np.sin(x), n=51, sight=seen) for each in cut.curves[:1]
    ))  # fmt: skip
    covered = replace(covered, x_limits=(0.0, 5.0), y_limits=(-2.0, 2.0), curves=tuple(
        replace(each, x=x, y=np.cos(x), n=51, sight=sight) for each, sight in zip(covered.curves, (hidden, seen), strict=False)
    ))  # fmt: skip
    sheet = Sheet()
    sheet.says(axes=(cut, covered))
    (chart,) = drawn.charts(sheet.drawing(), ())
    first, second = chart.panels
    assert [(c.name, c.role, c.x[0], c.x[-1]) for c in first.curves] == [
        ("x", "drawn", 0.0, pytest.approx(3.1)), ("", "not-seen", pytest.approx(3.1), 5.0),
    ]  # fmt: skip
    assert [(c.name, c.role, len(c.x)) for c in second.curves] == [("x", "not-seen", 51), ("y", "drawn", 51)]
    assert chart.caption.endswith("Dotted curves are drawn by the code but not visible in the picture.")
    (whole,) = drawn.charts(Sheet().drawing(), ())
    assert "dotted" not in whole.caption


def test_points_that_cannot_be_drawn_are_left_out() -> None:
    drawn = curve("a", "x", np.arange(5.0), np.array([1.0, np.nan, np.inf, 1e300, 2.5]))
    assert (drawn.x, drawn.y) == ((0.0, 4.0), (1.0, 2.5))


ODD = [
    np.full((1200, 3), np.nan),
    np.full((1200, 3), 1e308),
    np.zeros((1, 3)),
    np.zeros((0, 3)),
    np.full((9000, 3), -1e11),
]


@pytest.mark.parametrize("odd", ODD, ids=("nan", "huge", "one row", "no row", "too many rows"))
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


def test_the_histogram_is_a_density_and_its_law_the_normal_one() -> None:
    shape = panels(noise.charts(white(), TRUTH)[0])["Accelerometer"]
    bars, law = shape.curves
    assert sum(bars.y) * (bars.x[1] - bars.x[0]) == pytest.approx(1.0, abs=1e-3)
    # 7,500 values: a bin of the middle scatters by 2.6 % of its height
    assert np.interp(0.0, bars.x, bars.y) == pytest.approx(0.3989, rel=0.15)
    assert max(law.y) == pytest.approx(0.3989, abs=1e-3)


def test_noise_of_another_size_stays_in_the_picture() -> None:
    chart = noise.charts(white(size=30.0), TRUTH)[0]
    bars = panels(chart)["Gyroscope"].curves[0]
    assert max(bars.x) > 60
    assert max(bars.y[0], bars.y[-1]) < 0.1 * max(bars.y)


def test_the_allan_plot_of_white_noise_lies_on_the_line_that_was_asked_for() -> None:
    for panel in noise.charts(white(), TRUTH)[1].panels:
        asked, found = panel.curves
        assert asked.x == found.x
        assert asked.x[0] == pytest.approx(TRUTH["push"].scalars["timestep"])
        ratio = np.array(found.y) / np.array(asked.y)
        # 6 records of 1,250 reads: the estimate at 125 reads a cluster scatters by some 15 %, at one read by 1 %
        assert ratio[0] == pytest.approx(1.0, abs=0.06)
        assert np.all(np.abs(ratio - 1) < 0.6)


def test_noise_that_does_not_move_has_no_allan_curve() -> None:
    for chart in noise.charts(white(size=0.0), TRUTH):
        assert drawing.views(chart)
    assert not panels(noise.charts(white(size=0.0), TRUTH)[1])["Gyroscope"].curves[1].x


def test_the_gain_of_the_sheets_filter_is_found_to_two_percent() -> None:
    scenario = TRUTH["filter"]
    chart = filtering.chart([FilterRun(scenario["low_passed"][0], None, None)], scenario)
    sheet, own = panels(chart)["Gain"].curves
    assert own.y == pytest.approx(sheet.y, rel=0.02)
    omega = 2 * np.pi * np.array(sheet.x)
    assert sheet.y == pytest.approx(np.abs(0.1 / (1 - 0.9 * np.exp(-1j * omega))), rel=0.01)


def test_a_filter_that_does_nothing_has_a_gain_of_one() -> None:
    scenario = TRUTH["filter"]
    chart = filtering.chart([FilterRun(scenario["input"], None, None)], scenario)
    assert set(panels(chart)["Gain"].curves[1].y) == {1.0}


# --- how they are set -----------------------------------------------------------------------------------------------


def view(*values: float, log: bool = False) -> drawing.View:
    line = curve("a", "own", np.arange(1.0, len(values) + 1), np.array(values))
    (found,) = drawing.views(Chart("p", "t", "c", (Panel("", "x", "y", (line,), log),)))
    return found


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ((0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        ((-0.02, 0.02), ["−0.02", "−0.01", "0.00", "0.01", "0.02"]),
        ((5.0, 5.0), None),
        ((0.0, 4e7), ["0", "1e+07", "2e+07", "3e+07", "4e+07"]),
    ],
)
def test_ticks_are_round_numbers(values: tuple[float, ...], texts: list[str] | None) -> None:
    found = [tick.text for tick in view(*values).y_ticks]
    assert len(found) >= 2
    assert texts is None or found == texts


def test_a_logarithmic_axis_is_marked_in_decades_or_finer() -> None:
    assert [tick.text for tick in view(0.001, 10.0, log=True).y_ticks] == ["0.001", "0.01", "0.1", "1", "10"]
    assert [tick.text for tick in view(0.04, 0.6, log=True).y_ticks] == ["0.05", "0.1", "0.2", "0.5"]


def test_a_curve_runs_from_border_to_border() -> None:
    found = view(0.0, 1.0)
    (first, last) = (tuple(map(float, pair.split(","))) for pair in found.strokes[0].points.split())
    assert (first[0], last[0]) == (found.left, found.right)
    assert found.top < last[1] < first[1] < found.bottom


def test_a_chart_is_told_in_words() -> None:
    assert view(0.0, 1.0).told == "Chart of a: y from 0 to 1, over x from 1 to 2."


def test_no_role_of_a_curve_is_a_class_that_means_something_else() -> None:
    style = (Path(drawing.__file__).parent / "templates" / "style.css").read_text(encoding="utf-8")
    assert [role for role in get_args(Role) if re.search(rf"(?m)^\.{role}\b(?![-.])", style)] == ["bars"]
