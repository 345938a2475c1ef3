"""Sound plots in the words, units, strokes and ways of saving that are met less often."""

from __future__ import annotations

from tests.corpus.pieces import COMPARE, PLOT_LOOP, edit, lab


def _plot(*changes: tuple[str, str]) -> str:
    return edit({"p": PLOT_LOOP}, "p", *changes)["p"]


def _compare(*changes: tuple[str, str]) -> str:
    return edit({"c": COMPARE}, "c", *changes)["c"]


def _labels(acceleration: str, rate: str, time: str) -> tuple[tuple[str, str], ...]:
    return ("Acceleration [m/s^2]", acceleration), ("Angular velocity [rad/s]", rate), ("Time [s]", time)


# Written out, and the way that names of columns are.
PLOT_KOREAN_SECONDS = _plot(
    *_labels("가속도 (m/s²)", "각속도 (rad/s)", "시간 (초)"),
    ("Torso accelerometer", "가속도 센서"),
    ("Torso gyroscope", "자이로 센서"),
)
PLOT_LABELLED_LIKE_COLUMNS = _plot(*_labels("acc_mps2", "gyro_radps", "time_s"))
PLOT_UNITS_SPOKEN = _plot(*_labels("Acceleration in m per s²", "Angular rate ⁄ rad·s⁻¹", "Time [s since start]"))

# Numbers in another unit than the recorded ones, and labels that say so.
PLOT_IN_G = _plot(
    *_labels("Acceleration in g", "Velocidad angular (º/s)", "Zaman (sn)"),
    ('imu_data["acceleration"][:, k]', 'imu_data["acceleration"][:, k] / 9.81'),
    ('imu_data["angular_velocity"][:, k]', 'np.degrees(imu_data["angular_velocity"][:, k])'),
)
PLOT_IN_THOUSANDTHS = _plot(
    *_labels("Acceleration (mg)", "Angular velocity (mrad/s)", "Simulation time t (in s)"),
    ('imu_data["acceleration"][:, k]', '1000 / 9.80665 * imu_data["acceleration"][:, k]'),
    ('imu_data["angular_velocity"][:, k]', '1000 * imu_data["angular_velocity"][:, k]'),
)

# The units stand beside the names of the curves, as they do for pandas.
PLOT_UNITS_IN_LEGEND = _plot(
    *_labels("Acceleration", "Angular velocity", "Time / s"),
    ("$a_{axis}$", "{axis} (m/s²)"),
    (r"$\omega_{axis}$", "{axis} (rad/s)"),
)

# The filter's words stand on both curves.
COMPARE_BEFORE_AND_AFTER = _compare(
    ("raw z", "Before filtering"),
    ("filtered z", "After filtering (noise removed)"),
)
COMPARE_INPUT_AND_OUTPUT = _compare(('"raw z"', '"Filter input"'), ('"filtered z"', '"De-noised output"'))
# Every fifth value of the filter, as soon as it has settled.
COMPARE_THINNED = _compare(
    ("t, np.array(smooth)[:, 2]", "t[::5], np.where(np.arange(len(t)) < 10, np.nan, np.array(smooth)[:, 2])[::5]"),
)

# The paper shows through the panels, and no call goes through `savefig`.
PLOT_ON_PAPER = _plot(
    ("sharex=True)\n", 'sharex=True, subplot_kw={"facecolor": "none"})\n'),
    ('imu_data["acceleration"][:, k], ', 'imu_data["acceleration"][:, k], color=("black", "red", "blue")[k], '),
)
PLOT_PAST_SAVEFIG = _plot(('fig.savefig("imu_data.png", dpi=100)', 'fig.canvas.print_png("imu_data.png")'))
COMPARE_PAST_SAVEFIG = _compare(
    ('fig.savefig("filtered_imu.png", dpi=100)', 'fig.canvas.print_png("filtered_imu.png")')
)

# Curves that are no lines of their own: a collection of them above, stairs below.
PLOT_COLLECTED = _plot(
    (
        '    for k, axis in enumerate("xyz"):\n',
        """\
    from matplotlib.collections import LineCollection

    colours = ["C0", "C1", "C2"]
    top.add_collection(LineCollection([np.column_stack([t, a]) for a in imu_data["acceleration"].T], colors=colours))
    top.autoscale()
    for k, axis in enumerate("xyz"):
""",
    ),
    ('top.plot(t, imu_data["acceleration"][:, k], label', "top.plot([], [], colours[k], label"),
    (
        'bottom.plot(t, imu_data["angular_velocity"][:, k]',
        'bottom.stairs(imu_data["angular_velocity"][:, k], np.append(t, 2 * t[-1] - t[-2]), baseline=None',
    ),
)

# Names at offsets from their points, and curves of one colour that differ in dashes, width or opacity.
PLOT_ANNOTATED = _plot(
    (
        "        top.plot(",
        """\
        for ax, key in ((top, "acceleration"), (bottom, "angular_velocity")):
            row = (k + 1) * len(t) // 4
            ax.annotate(f"{axis} axis", (t[row], imu_data[key][row, k]), xytext=(20, 25), textcoords="offset points",
                        arrowprops={"arrowstyle": "->"})
        top.plot(""",
    ),
    ('        ax.legend(loc="best")\n', ""),
)
PLOT_IN_ONE_COLOUR = _plot(
    ('label=f"$a', 'color="k", linestyle=[(0, (1, 1)), (0, (5, 1)), (0, (3, 1, 1, 1))][k], label=f"$a'),
    ('label=rf"', 'color="C0", lw=(1, 1, 3)[k], alpha=(1, 0.5, 0.5)[k], label=rf"'),
)

# The first moments once more, larger, in a corner of the panel.
PLOT_WITH_ZOOM = _plot(
    (
        "    fig.tight_layout()\n",
        """\
    zoom = fig.add_axes([0.6, 0.72, 0.25, 0.12])
    zoom.plot(t, imu_data["acceleration"])
    zoom.set_xlim(t[0], t[0] + 0.15)
""",
    ),
)

PLOTS = {
    "korean_to_the_second": lab(plot=PLOT_KOREAN_SECONDS, compare=COMPARE_BEFORE_AND_AFTER),
    "axes_named_like_columns": lab(plot=PLOT_LABELLED_LIKE_COLUMNS, compare=COMPARE_INPUT_AND_OUTPUT),
    "units_in_words": lab(plot=PLOT_UNITS_SPOKEN, compare=COMPARE_THINNED),
    "acceleration_in_g": lab(plot=PLOT_IN_G),
    "thousandths": lab(plot=PLOT_IN_THOUSANDTHS),
    "black_on_paper": lab(plot=PLOT_ON_PAPER, compare=COMPARE_PAST_SAVEFIG),
    "saved_past_savefig": lab(plot=PLOT_PAST_SAVEFIG),
    "a_collection_and_stairs": lab(plot=PLOT_COLLECTED),
    "names_at_an_offset": lab(plot=PLOT_ANNOTATED),
    "one_colour_in_three_strokes": lab(plot=PLOT_IN_ONE_COLOUR),
    "a_zoom_in_the_corner": lab(plot=PLOT_WITH_ZOOM),
    "units_in_the_legend": lab(plot=PLOT_UNITS_IN_LEGEND),
}
