"""Handed-in pictures: the sheet's figure is recognised however it was saved, and nothing else is; beside code it is held against that."""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest
from PIL import Image

from grader.engine.findings import A_PERSON_MAY, ANOTHER_VERSION
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.engine.traces import Traces
from grader.intake import Submission
from grader.labs.imu import bundles
from grader.labs.imu.diagnosis.handed_in import sensors_shown
from grader.labs.imu.student import Student
from grader.worker.pictures import decode
from reference.imu_reader import MODEL_PATH, simulate_and_collect
from tests import handed_pictures
from tests.corpus.pieces import COMPARE, PLOT_LOOP, lab
from tests.recordings.marker import corpus_marker, recorded_corpus
from tests.sandboxes import Opened
from tests.scoreboard import handed_in

BOTH = {0, 1}
NOISE = Image.fromarray(np.random.default_rng(1).integers(0, 256, (600, 900, 3), np.uint8))


@pytest.fixture(scope="module")
def recording() -> dict[str, Any]:
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    return simulate_and_collect(model, mujoco.MjData(model), duration_seconds=5.0)


def drawn(
    recording: dict[str, Any], style: str = "default", dpi: int = 100, colours: tuple[str, ...] = ("C0", "C1", "C2")
) -> Any:
    """The sheet's own figure as a picture; in one colour, its curves differ by their strokes."""
    with mpl.rc_context():
        plt.style.use(style)
        figure, axes = plt.subplots(2, 1, figsize=(12, 8), sharex=True)
        for panel, key, label in zip(axes, ("acceleration", "angular_velocity"), ("m/s²", "rad/s"), strict=True):
            for axis, colour in enumerate(colours):
                stroke = ("-", "--", ":")[axis] if len(set(colours)) == 1 else "-"
                panel.plot(recording["time"], recording[key][:, axis], stroke, color=colour, label="XYZ"[axis])
            panel.set(title=key, ylabel=label)
            panel.legend()
            panel.grid(True)
        axes[0].axhline(-9.81, color="k", linestyle="--", alpha=0.3, label="Gravity")
        figure.tight_layout()
        stream = io.BytesIO()
        figure.savefig(stream, dpi=dpi)
        plt.close(figure)
    return Image.open(stream).convert("RGB")


@pytest.fixture(scope="module")
def figure(recording: dict[str, Any]) -> Any:
    return drawn(recording)


def content(picture: Any, form: str = "PNG") -> bytes:
    stream = io.BytesIO()
    picture.save(stream, form)
    return stream.getvalue()


def shown(picture: bytes) -> set[int]:
    """Which sensors are recognised."""
    _, arrays = decode({}, {"bytes": np.frombuffer(picture, np.uint8)})
    push = bundles.shipped()["push"]
    series = {key: push[key] for key in ("time", "acceleration", "angular_velocity")}
    return sensors_shown(arrays["preview"], arrays["palette"], series)


def in_a_window(picture: Any, colour: str = "#282c34") -> Any:
    width, height = picture.size
    window = Image.new("RGB", (width + 120, height + 180), colour)
    window.paste((220, 70, 60), (0, 0, width + 120, 40))
    window.paste(picture, (60, 100))
    return window


@pytest.mark.parametrize("dpi", [50, 200])
def test_the_sheets_figure_is_recognised_at_any_size(recording: dict[str, Any], dpi: int) -> None:
    assert shown(content(drawn(recording, dpi=dpi))) == BOTH


@pytest.mark.parametrize("style", ["dark_background", "ggplot"])
def test_the_sheets_figure_is_recognised_in_other_styles(recording: dict[str, Any], style: str) -> None:
    assert shown(content(drawn(recording, style))) == BOTH


def test_the_sheets_figure_is_recognised_on_a_screenshot(figure: Any) -> None:
    assert shown(content(in_a_window(figure))) == BOTH


def test_the_sheets_figure_is_recognised_in_the_bytes_of_a_jpeg(figure: Any) -> None:
    assert shown(content(figure, "JPEG")) == BOTH


@pytest.mark.parametrize("colours", [("k", "0.4", "0.7"), ("k", "k", "k")], ids=["greys", "strokes"])
def test_the_sheets_figure_is_recognised_without_colours(recording: dict[str, Any], colours: tuple[str, ...]) -> None:
    assert shown(content(drawn(recording, colours=colours))) == BOTH


def test_the_sheets_figure_is_recognised_in_the_style_classic(recording: dict[str, Any]) -> None:
    assert shown(content(drawn(recording, "classic"))) == BOTH


def test_a_dark_figure_is_recognised_in_a_light_window(recording: dict[str, Any]) -> None:
    assert shown(content(in_a_window(drawn(recording, "dark_background"), "white"))) == BOTH


def test_six_panels_of_one_channel_are_recognised(recording: dict[str, Any]) -> None:
    figure, panels = plt.subplots(3, 2, figsize=(12, 8))
    for axes, channel in zip(panels.T.ravel(), range(6), strict=True):
        key = ("acceleration", "angular_velocity")[channel // 3]
        axes.plot(recording["time"], recording[key][:, channel % 3])
    stream = io.BytesIO()
    figure.savefig(stream)
    plt.close(figure)
    assert shown(stream.getvalue()) == BOTH


@pytest.mark.parametrize("seed", range(6))
def test_random_pictures_of_other_things_show_nothing(seed: int) -> None:
    """More of them by ``python -m tests.benchmarks.handed_in``."""
    assert shown(content(handed_pictures.other(seed)[0])) != BOTH


def _sines(recording: dict[str, Any]) -> Any:
    waves = np.sin(np.outer(recording["time"], [2.0, 3.0, 5.0]))
    return drawn(recording | {"acceleration": waves - [0, 0, 9.81], "angular_velocity": waves})


@pytest.mark.parametrize(
    "other",
    [
        _sines,
        lambda recording: drawn(recording | {"angular_velocity": recording["acceleration"]}),
        lambda recording: drawn({key: values[:1] for key, values in recording.items()}),
        lambda _: NOISE,
        lambda _: Image.new("RGB", (900, 600), "white"),
    ],
    ids=["sines", "one sensor twice", "empty axes", "noise", "a blank sheet"],
)
def test_other_pictures_do_not_show_both_sensors(
    recording: dict[str, Any], other: Callable[[dict[str, Any]], Any]
) -> None:
    assert shown(content(other(recording))) != BOTH


def test_the_sheets_figure_is_recognised_on_a_photograph(figure: Any) -> None:
    """Of more colours than are kept: a desktop around a window."""
    coarse = NOISE.resize((16, 12), Image.Resampling.BOX)
    desktop = Image.blend(coarse.resize((1600, 1100), Image.Resampling.BICUBIC), NOISE.resize((1600, 1100)), 0.05)
    desktop.paste(figure, (150, 120))
    assert shown(content(desktop)) == BOTH


def test_a_picture_of_any_colours_is_reduced_quickly(figure: Any) -> None:
    """Noise took 27 times as long as a figure; its own reading and shrinking take 2 to 4 times as long."""
    took = []
    for picture in (figure, NOISE):
        handed, begun = np.frombuffer(content(picture), np.uint8), time.process_time()
        decode({}, {"bytes": handed})
        took.append(time.process_time() - begun)
    assert took[1] < 10 * took[0]


def test_it_earns_half_of_the_criterion_and_a_person_is_asked_to_look(figure: Any, marker: Marker) -> None:
    files = {name: text.encode() for name, text in lab(plot="", compare="").items()}
    picture = {"imu_data.png": content(figure)}
    result = marker.mark(Submission("s", "s", files | picture, (), "ready", ""), only="visualization")
    checks = {check.id.partition(".")[2]: check for check in result.criteria[0].checks}
    earned = sum(check.points or 0.0 for name, check in checks.items() if name != "comparison_plot")
    assert earned == pytest.approx(8.0)
    assert [note for note in result.notes if "imu_data.png" in note and A_PERSON_MAY in note]


def test_under_a_secret_it_earns_as_much_because_whoever_drew_it_did_not_know_it(
    figure: Any, hidden: Traces, opened: Opened
) -> None:
    with opened(hidden) as marker:
        marks = _marks(marker, lab(plot="", compare=""), content(figure))
    assert sum(marks[name] or 0.0 for name in marks if name != "comparison_plot") == pytest.approx(8.0)


def _marks(marker: Marker, files: Mapping[str, str], picture: bytes) -> dict[str, float | None]:
    return {check.id.partition(".")[2]: check.points for check in _marked(marker, files, picture).criteria[0].checks}


def _marked(marker: Marker, files: Mapping[str, str], picture: bytes) -> Result:
    handed = {name: text.encode() for name, text in files.items()} | {"imu_data.png": picture}
    return marker.mark(Submission("s", "s", handed, (), "ready", ""), only="visualization")


def test_a_comparison_of_two_panels_of_any_name_is_not_the_plot(figure: Any, marker: Marker) -> None:
    """Raw above and filtered below, saved as `before_after.png`: no code draws the data."""
    two = COMPARE.replace("fig, ax = plt.subplots(figsize=(10, 4))", "fig, (ax, low) = plt.subplots(2, 1)")
    two = two.replace("ax.plot(t, np.array(smooth)", "low.plot(t, np.array(smooth)")
    two = two.replace("ax.legend()", "ax.legend(), low.legend(), low.set_ylabel(ax.get_ylabel())")
    two = two.replace("filtered_imu.png", "before_after.png")
    assert two.count("low.plot") == two.count("low.legend") == two.count("before_after") == 1
    marks = _marks(marker, lab(plot="", compare=two), content(figure))
    assert marks["curves_match_data"] == pytest.approx(2.5)


# --- held against what the code draws ------------------------------------------------------------------------------------

GYROSCOPE = 'imu_data["angular_velocity"][:, k]'
OTHER_CODE = {
    "the other sensor": PLOT_LOOP.replace(GYROSCOPE, 'imu_data["acceleration"][:, k]'),
    "zeros": PLOT_LOOP.replace(GYROSCOPE, "np.zeros(len(t))").replace('imu_data["acceleration"][:, k]', "0 * t"),
    "noise": PLOT_LOOP.replace(GYROSCOPE, "np.random.default_rng(k).normal(size=len(t))"),
}
MAY_BE_ITS_OWN = {
    "wrong units": PLOT_LOOP.replace(GYROSCOPE, f"9.81 * {GYROSCOPE}"),
    "one axis of each": PLOT_LOOP.replace('enumerate("xyz")', 'enumerate("x")'),
    "a window of it": PLOT_LOOP.replace('    t = imu_data["time"]\n', '    imu_data = {k: v[:300] for k, v in imu_data.items()}\n    t = imu_data["time"]\n'),
    "an exception": PLOT_LOOP.replace(f"bottom.plot(t, {GYROSCOPE}", "bottom.plot(t, missing"),
    "another file": PLOT_LOOP.replace(f"bottom.plot(t, {GYROSCOPE}", "bottom.plot([], []"),
}  # fmt: skip
BOTH_IN_A_SCRIPT = """
if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    recorded = simulate_and_collect(model, mujoco.MjData(model), 5.0)
    figure, panels = plt.subplots(2, 1)
    panels[0].plot(recorded["time"], recorded["acceleration"])
    panels[1].plot(recorded["time"], recorded["angular_velocity"])
    figure.savefig("imu_data.png")
"""


def _notes_of(result: Result) -> list[str]:
    """What is told of a picture that shows what the code does not draw."""
    return [note for note in result.notes if ANOTHER_VERSION in note]


@pytest.mark.parametrize("plot", sorted({*OTHER_CODE} - {"the other sensor"}))
def test_a_picture_of_both_sensors_beside_code_that_draws_less_is_told_to_whoever_looks(
    figure: Any, marker: Marker, plot: str
) -> None:
    assert OTHER_CODE[plot] != PLOT_LOOP
    (note,) = _notes_of(_marked(marker, lab(plot=OTHER_CODE[plot]), content(figure)))
    missing = "acceleration and angular velocity" if plot == "zeros" else "angular velocity"
    assert f" The plot that the code draws shows no {missing}: " in note


@pytest.mark.parametrize("plot", MAY_BE_ITS_OWN)
def test_nothing_is_told_of_a_picture_that_the_code_itself_may_have_drawn(
    figure: Any, marker: Marker, plot: str
) -> None:
    assert MAY_BE_ITS_OWN[plot] != PLOT_LOOP
    files = lab(plot=MAY_BE_ITS_OWN[plot])
    if plot == "another file":
        files["imu_reader.py"] = files["imu_reader.py"].partition('if __name__ == "__main__":')[0] + BOTH_IN_A_SCRIPT
    assert _notes_of(_marked(marker, files, content(figure))) == []


def test_nothing_is_told_of_the_picture_that_the_code_drew_and_another_one_costs_nothing(
    recording: dict[str, Any], marker: Marker
) -> None:
    """The gyroscope's panel shows the acceleration, in the code and in the first picture."""
    own, true = (
        _marked(marker, lab(plot=OTHER_CODE["the other sensor"]), content(drawn(recording | changed)))
        for changed in ({"angular_velocity": recording["acceleration"]}, {})
    )
    assert (_notes_of(own), len(_notes_of(true))) == ([], 1)
    assert [check.points for check in own.criteria[0].checks] == [check.points for check in true.criteria[0].checks]


def test_under_a_secret_the_picture_is_still_of_the_public_run(figure: Any, hidden: Traces, opened: Opened) -> None:
    with opened(hidden) as marker:
        result = _marked(marker, lab(plot=OTHER_CODE["the other sensor"]), content(figure))
        assert len(_notes_of(result)) == 1


@pytest.mark.quick
def test_no_sound_submission_pays_for_a_look_at_its_picture(figure: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten of the corpus, with a picture beside them."""
    picture, looked = {"imu_data.png": content(figure)}, []
    monkeypatch.setattr(Student, "picture", lambda _, name: looked.append(name))
    for case in [case for case in recorded_corpus() if case.part == "sound"][::16]:
        handed = handed_in(case)
        result = corpus_marker().mark(replace(handed, files=handed.files | picture))
        assert _notes_of(result) == []
    assert looked == []
