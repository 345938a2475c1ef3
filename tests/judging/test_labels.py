"""What a label says, by symbols that are the same in every language; words stand in `languages.yaml`, with samples of their own."""

from __future__ import annotations

import pytest

from grader.labs.imu.visualization import labels

pytestmark = pytest.mark.quick
UNITS: dict[str | None, list[str]] = {
    "m/s²": [
        "Acceleration (m/s²)", "a [m/s^2]", "m/s**2", r"$\mathrm{m/s^2}$", r"$\dfrac{m}{s^{2}}$", "m s^-2", r"m$\cdot$s$^{-2}$", "m/s/s", "mps2",
        "m/sec²", "meters per second squared", "ms⁻²", "м/с²", "m⁄s²", r"$\mathit{m}/\text{s}^2$", "m·s−2", r"\left(m/s^2\right)",
    ],
    "cm/s²": ["Acceleration (cm/s²)"],
    "g": ["Acceleration (g)", "a [g]", "accel / g", "Accel, g", "Beschleunigung in g"],
    "mg": ["Acceleration (mg)", "a [mg]"],
    "rad/s": [
        "Angular velocity (rad/s)", "rad s^-1", r"$\frac{rad}{s}$", "rad⁄s", "radians per second", "rad·s⁻¹", "1/s", "rad/sec", "RAD/S",
        r"$\omega$ [rad/s]", "角速度 弧度/秒", "Угловая скорость, радиан в секунду",
    ],
    "mrad/s": ["mrad/s"],
    "deg/s": ["°/s", "º/s", "deg/s", "(dps)", r"$^\circ/s$", r"$\degree$/s", "degrees per second", "°s⁻¹", "Angular velocity in deg/s"],
    None: ["rad/s²", "Acceleration", "Gyro", "deg", "°/s²", "m", "", "Time (s)", "x"],
}  # fmt: skip


@pytest.mark.parametrize(("unit", "text"), [(unit, text) for unit, texts in UNITS.items() for text in texts])
def test_a_unit_is_known_however_it_is_written(unit: str | None, text: str) -> None:
    assert labels.unit_of(text) == unit
    assert labels.has_unit_of(0, text) is (unit in ("m/s²", "cm/s²", "g", "mg"))
    assert labels.has_unit_of(1, text) is (unit in ("rad/s", "mrad/s", "deg/s"))


TIMES = {
    "s": ["Time (s)", "Time [s]", "t / s", "time_s", "Time in s", "Time, s", "seconds", "t [sec]", "Time (s.)", r"$t\,[s]$"],
    "ms": ["Time (ms)", "t / ms", "time_ms", "milliseconds", "Time [ms]", "Time in ms", "Time (ms) since the start"],
    "": ["Time", "x", "Angular velocity (rad)", ""],
}  # fmt: skip


@pytest.mark.parametrize(("unit", "text"), [(unit, text) for unit, texts in TIMES.items() for text in texts])
def test_a_unit_of_time_is_known_however_it_is_written(unit: str, text: str) -> None:
    assert labels.has_time_unit(text) is bool(unit)
    assert labels.in_milliseconds(text) is (unit == "ms")


@pytest.mark.parametrize(
    ("text", "sensors"),
    [
        ("Accelerometer", {0}), ("Gyroscope", {1}), ("Acceleration and angular velocity", {0, 1}), ("x (m/s²)", {0}), ("x (rad/s)", {1}),
        ("Spin of the torso", {1}), ("Rotation", {1}), ("Winkel", {1}), ("acc x", {0}),
        ("Top", set()), ("Gyroscope (m/s²)", {1}), ("Accelerometer [°/s]", {0}), ("", set()),
    ],
)  # fmt: skip
def test_a_text_speaks_of_a_sensor_by_its_words_or_else_by_its_unit(text: str, sensors: set[int]) -> None:
    assert labels.claims(text) == sensors
    assert isinstance(labels.claims(text), frozenset)  # it is kept for whoever asks next


AXES: dict[int | None, list[str]] = {
    0: ["x", "X", "ax", "a_x", "accel x", "gyro_x", "x-axis", "X axis (raw)", "Acc-X", "lin x", "rate x", r"$a_x$", "$\\omega_x$", "Roll"],
    1: ["y", "ay", "omega_y", "GyrY", "filtered y", "fy", "Pitch"],
    2: ["z", "gz", "ang z", "Achse Z", "f z", "Yaw"],
    None: ["", "x and y", "xyz", "exact", "magnitude", "a", "max"],
}  # fmt: skip


@pytest.mark.parametrize(("axis", "text"), [(axis, text) for axis, texts in AXES.items() for text in texts])
def test_an_axis_is_known_by_its_letter(axis: int | None, text: str) -> None:
    assert labels.axis_of(text) == axis


@pytest.mark.parametrize(
    ("name", "raw", "smooth"),
    [
        ("raw", True, False), ("Raw x", True, False), ("filtered", False, True), ("Filtered", False, True), ("unfiltered", True, False), ("low-pass", False, True),
        ("denoised", False, True), ("x", False, False), ("raw and filtered", True, False), ("", False, False),
    ],
)  # fmt: skip
def test_raw_and_filtered_are_told_by_their_names(name: str, raw: bool, smooth: bool) -> None:
    assert (labels.says_raw(name), labels.says_smooth(name)) == (raw, smooth)


# --- words, in each language of languages.yaml ---

SAMPLES = [(code, text, kind) for code, block in labels.languages().items() for text, kind in block["labels"].items()]


@pytest.mark.parametrize("code", labels.languages())
def test_a_language_has_three_axes_and_samples_of_every_unit(code: str) -> None:
    block = labels.languages()[code]
    assert len(block["axes"]) == 3
    assert {"m/s²", "rad/s", "s"} <= set(block["labels"].values())


@pytest.mark.parametrize(("code", "text", "kind"), SAMPLES)
def test_a_label_is_read_as_what_it_says(code: str, text: str, kind: str) -> None:
    if kind == "samples":
        assert labels.counts_samples(text)
    elif kind in ("s", "ms"):
        assert labels.has_time_unit(text)
        assert labels.in_milliseconds(text) == (kind == "ms")
    else:
        assert labels.unit_of(text) == kind
        assert labels.claims(text) == {0 if kind == "m/s²" else 1}


@pytest.mark.parametrize("code", labels.languages())
def test_the_words_for_axes_and_for_the_comparison_are_told_apart(code: str) -> None:
    block = labels.languages()[code]
    assert [labels.axis_of(word) for words in block["axes"] for word in words] == [
        axis for axis, words in enumerate(block["axes"]) for _ in words
    ]
    assert all(labels.says_raw(word) for word in block["raw"])
    assert all(labels.says_smooth(word) for word in block["filtered"])
