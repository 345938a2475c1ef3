"""Faults of Step 4, and of the comparison in Step 6: the pictures."""



from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import COMPARE, NOISE_MAIN, PLOT_LOOP, PLOT_PYPLOT, edit, lab, verbatim
from tests.corpus.sound_figures import PLOT_3X2


def sheet(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(verbatim(), "imu_reader.py", *changes)


def loop(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(plot=edit({"p": PLOT_LOOP}, "p", *changes)["p"])


def pyplot(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(plot=edit({"p": PLOT_PYPLOT}, "p", *changes)["p"])


def compare(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(compare=edit({"c": COMPARE}, "c", *changes)["c"])


def only(*checks: str) -> dict[str, tuple[str, ...]]:
    return {"loses": tuple(f"visualization.{check}" for check in checks)}


def fault(name: str, mistake: str, files: dict[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "visualization", files, **more)  # type: ignore[arg-type]


SAVE = '    fig.savefig("imu_data.png", dpi=100)\n'
SHEET_SAVE = "    plt.savefig('imu_data.png', dpi=150)\n"
SHEET_SHOW = "    plt.show()\n"
SHEET_COMPARE_SAVE = "plt.savefig('filtered_imu.png', dpi=150)\n"


def _times(plot: str) -> str:
    return plot.replace("imu_data['time'], ", "")


ONE_PANEL = '''\
def plot_imu_data(imu_data):
    plt.figure(figsize=(10, 6))
    for k, axis in enumerate("xyz"):
        plt.plot(imu_data["time"], imu_data["acceleration"][:, k], label=f"acceleration {axis} (m/s²)")
        plt.plot(imu_data["time"], imu_data["angular_velocity"][:, k], label=f"angular velocity {axis} (rad/s)")
    plt.title("IMU data")
    plt.xlabel("Time (s)")
    plt.ylabel("Acceleration (m/s²), angular velocity (rad/s)")
    plt.legend()
    plt.savefig("imu_data.png")
    plt.close()
'''

ONE_PANEL_FOR_EACH_AXIS = '''\
def plot_imu_data(imu_data):
    fig, panels = plt.subplots(3, 1, figsize=(10, 9), sharex=True)
    for k, ax in enumerate(panels):
        ax.plot(imu_data["time"], imu_data["acceleration"][:, k], label="acceleration (m/s²)")
        ax.plot(imu_data["time"], imu_data["angular_velocity"][:, k], label="angular velocity (rad/s)")
        ax.set_title("IMU, axis " + "xyz"[k])
        ax.set_ylabel("Acceleration (m/s²), angular velocity (rad/s)")
        ax.legend()
    panels[-1].set_xlabel("Time (s)")
    fig.savefig("imu_data.png")
    plt.close(fig)
'''

PLOT_FAULTS = [
    fault("shown-not-saved", "plot-not-saved", sheet((SHEET_SAVE, ""))),
    fault("drawn-and-closed", "plot-not-saved", loop((SAVE, ""))),
    fault("saved-after-show", "blank-image", sheet((SHEET_SAVE + SHEET_SHOW, SHEET_SHOW + SHEET_SAVE)), reason="the window took the figure along"),
    fault("saved-after-clf", "blank-image", pyplot(('    plt.savefig("imu_data.png")\n', '    plt.clf()\n    plt.savefig("imu_data.png")\n'))),
    fault("saved-a-new-figure", "blank-image", loop((SAVE, '    plt.figure(figsize=(10, 6))\n    plt.savefig("imu_data.png")\n'))),
    fault("saved-before-anything-is-drawn", "blank-image", loop(("sharex=True)\n", "sharex=True)\n" + SAVE), ("    fig.tight_layout()\n" + SAVE, "    fig.tight_layout()\n")), **only("saves_image", "titles")),
    fault("saved-before-drawing-and-shown", "blank-image", sheet(("sharex=True)\n", "sharex=True)\n" + SHEET_SAVE), (SHEET_SAVE + SHEET_SHOW, SHEET_SHOW)), **only("saves_image", "titles")),
    fault("no-labels-at-all", "no-axis-labels", sheet(("    axes[0].set_ylabel('Acceleration (m/s²)')\n", ""), ("    axes[1].set_xlabel('Time (s)')\n", ""), ("    axes[1].set_ylabel('Angular Velocity (rad/s)')\n", "")), **only("axis_labels_with_units")),
    fault("no-labels-loop", "no-axis-labels", loop(('    top.set_ylabel("Acceleration [m/s^2]")\n', ""), ('    bottom.set_ylabel("Angular velocity [rad/s]")\n', ""), ('    bottom.set_xlabel("Time [s]")\n', "")), **only("axis_labels_with_units")),
    fault("labels-without-units", "no-units", sheet(("'Acceleration (m/s²)'", "'Acceleration'"), ("'Time (s)'", "'Time'"), ("'Angular Velocity (rad/s)'", "'Angular Velocity'")), **only("axis_labels_with_units")),
    fault("labels-without-units-pyplot", "no-units", lab(plot=PLOT_PYPLOT.replace("time / s", "time").replace("acceleration / (m/s²)", "acceleration").replace("angular rate / (rad/s)", "angular rate")), **only("axis_labels_with_units")),
    fault("units-of-the-y-axes-missing", "no-units", loop(('"Acceleration [m/s^2]"', '"Acceleration"'), ('"Angular velocity [rad/s]"', '"Angular velocity"')), **only("axis_labels_with_units")),
    fault("legend-never-called", "no-legend", lab(plot=PLOT_LOOP.replace('        ax.legend(loc="best")\n', "")), **only("legend_names_curves")),
    fault("legend-without-labels", "no-legend", sheet(("    axes[0].legend()\n", ""), ("    axes[1].legend()\n", "")), **only("legend_names_curves")),
    fault("curves-without-names", "no-legend", lab(plot=PLOT_PYPLOT.replace('    plt.legend(["x", "y", "z"])\n', "")), **only("legend_names_curves")),
    fault("legend-in-another-order", "legend-order-wrong", lab(plot=PLOT_PYPLOT.replace('["x", "y", "z"]', '["z", "y", "x"]')), also=("wrong-data-plotted",)),
    fault("labels-x-and-y-exchanged", "legend-order-wrong", sheet(("label='X'", "label='Y'"), ("label='Y'", "label='X'")), also=("wrong-data-plotted",)),
    fault("no-titles", "no-title", sheet(("    axes[0].set_title('Accelerometer Readings')\n", ""), ("    axes[1].set_title('Gyroscope Readings')\n", "")), **only("titles")),
    fault("no-titles-pyplot", "no-title", pyplot(('    plt.title("Accelerometer")\n', ""), ('    plt.title("Gyroscope")\n', "")), **only("titles")),
    fault("x-drawn-three-times", "wrong-data-plotted", sheet(("imu_data['acceleration'][:, 1]", "imu_data['acceleration'][:, 0]"), ("['acceleration'][:, 2]", "['acceleration'][:, 0]"))),
    fault("gyroscope-panel-shows-acceleration", "wrong-data-plotted", loop(('imu_data["angular_velocity"][:, k]', 'imu_data["acceleration"][:, k]')), also=("panels-swapped",)),
    fault("cumulative-sum-drawn", "wrong-data-plotted", loop(('imu_data["angular_velocity"][:, k]', 'np.cumsum(imu_data["angular_velocity"][:, k])'))),
    fault("one-column-twice", "wrong-data-plotted", sheet(("imu_data['angular_velocity'][:, 2], label='Yaw rate'", "imu_data['angular_velocity'][:, 1], label='Yaw rate'"))),
    fault("one-curve-of-the-other-sensor", "wrong-data-plotted", sheet(("imu_data['angular_velocity'][:, 0]", "imu_data['acceleration'][:, 0]")), never=("one-panel",), **only("curves_match_data")),
    fault("draws-its-own-recording", "global-for-parameter", sheet(("def plot_imu_data(imu_data)", "def plot_imu_data(recorded)")), **only("saves_image")),
    fault("first-hundred-samples-only", "", loop(('    t = imu_data["time"]\n', '    imu_data = {name: values[:100] for name, values in imu_data.items()}\n    t = imu_data["time"]\n')), **only("curves_match_data")),
    fault("minutes-under-seconds", "wrong-data-plotted", loop(('    t = imu_data["time"]\n', '    t = imu_data["time"] / 60\n')), also=("x-not-time",), **only("curves_match_data")),
    fault("z-only", "curves-missing", sheet(*[(f"    axes[{p}].plot(imu_data['time'], imu_data['{k}'][:, {i}], label='{label}')\n", "") for p, k, i, label in ((0, "acceleration", 0, "X"), (0, "acceleration", 1, "Y"), (1, "angular_velocity", 0, "Roll rate"), (1, "angular_velocity", 1, "Pitch rate"))])),
    fault("two-of-three", "curves-missing", loop(('enumerate("xyz")', 'enumerate("xy")'))),
    fault("accelerometer-panel-only", "curves-missing", lab(plot='''\
def plot_imu_data(imu_data):
    fig, ax = plt.subplots(figsize=(10, 5))
    ax.plot(imu_data["time"], imu_data["acceleration"], label=["x", "y", "z"])
    ax.set(title="Accelerometer", xlabel="Time (s)", ylabel="Acceleration (m/s²)")
    ax.legend()
    fig.savefig("imu_data.png")
    plt.close(fig)
'''), also=("one-panel",)),
    fault("both-on-one-scale", "one-panel", lab(plot=ONE_PANEL)),
    fault("both-on-one-scale-for-each-axis", "one-panel", lab(plot=ONE_PANEL_FOR_EACH_AXIS), **only("two_labelled_panels")),
    fault("labels-of-panels-exchanged", "panels-swapped", loop(('imu_data["acceleration"][:, k]', 'imu_data["angular_velocity"][:, k]'), ('imu_data["angular_velocity"][:, k]', 'imu_data["acceleration"][:, k]')), also=("wrong-data-plotted",)),
    fault("titles-and-units-of-panels-exchanged", "panels-swapped", sheet(("'Acceleration (m/s²)'", "'Angular Velocity (rad/s)'"), ("'Angular Velocity (rad/s)'", "'Acceleration (m/s²)'"), ("'Accelerometer Readings'", "'Gyroscope readings'"), ("'Gyroscope Readings'", "'Accelerometer Readings'")), also=("wrong-data-plotted",)),
    fault("label-of-the-panel-above-copied", "panels-swapped", sheet(("'Angular Velocity (rad/s)'", "'Acceleration (m/s²)'")), **only("two_labelled_panels")),
    fault("title-of-the-panel-above-copied", "panels-swapped", sheet(("'Gyroscope Readings'", "'Accelerometer Readings'")), **only("two_labelled_panels")),
    fault("titles-of-panels-exchanged", "panels-swapped", sheet(("'Accelerometer Readings'", "'Gyroscope readings'"), ("'Gyroscope Readings'", "'Accelerometer readings'")), **only("two_labelled_panels")),
    fault("units-of-panels-exchanged", "no-units", loop(("[m/s^2]", "[rad/s]"), ("[rad/s]", "[m/s^2]")), reason="the unit that belongs there is missing", never=("panels-swapped",), **only("axis_labels_with_units")),
    fault("unit-of-the-other-sensor", "no-units", sheet(("(rad/s)", "(m/s²)")), never=("panels-swapped",), **only("axis_labels_with_units")),
    fault("angular-velocity-per-second-squared", "no-units", sheet(("(rad/s)", "(rad/s²)")), **only("axis_labels_with_units")),
    fault("milliseconds-over-seconds", "no-units", sheet(("'Time (s)'", "'Time (ms)'")), also=("x-not-time",), reason="the unit that the numbers have is missing", **only("axis_labels_with_units")),
    fault("against-the-sample-index", "x-not-time", edit({**verbatim(), "imu_reader.py": _times(verbatim()["imu_reader.py"])}, "imu_reader.py")),
    fault("against-the-index-loop", "x-not-time", loop(('    t = imu_data["time"]\n', '    t = np.arange(len(imu_data["time"]))\n'))),
    fault("a-stamp-not-a-picture", "low-resolution", loop(("figsize=(10, 6)", "figsize=(3, 2)"), ("dpi=100", "dpi=30"), ("    fig.tight_layout()\n", ""))),
    fault("sixteen-dpi", "low-resolution", sheet((SHEET_SAVE, "    plt.savefig('imu_data.png', dpi=10)\n"))),
    fault("comparison-never-drawn", "comparison-missing", lab(compare=""), **only("comparison_plot")),
    fault("comparison-not-saved", "comparison-missing", edit(verbatim(), "filters.py", (SHEET_COMPARE_SAVE, "")), also=("plot-not-saved",), **only("comparison_plot")),
    fault("filtered-alone", "comparison-missing", compare(('    ax.plot(t, np.array(raw)[:, 2], alpha=0.5, label="raw z")\n', "")), **only("comparison_plot")),
    fault("raw-alone", "comparison-missing", compare(('    ax.plot(t, np.array(smooth)[:, 2], label="filtered z")\n', "")), **only("comparison_plot")),
    fault("raw-drawn-twice", "comparison-wrong-data", edit(verbatim(), "filters.py", ("plt.plot(filtered_data[:, 2]", "plt.plot(raw_data[:, 2]")), **only("comparison_plot")),
    fault("raw-thinned-for-filtered", "comparison-wrong-data", compare(("t, np.array(smooth)[:, 2]", "t[::5], np.array(raw)[::5, 2]")), **only("comparison_plot")),
    fault("filtered-drawn-twice", "comparison-wrong-data", compare(("np.array(raw)[:, 2]", "np.array(smooth)[:, 2]")), **only("comparison_plot")),
    fault("gyroscope-filtered-beside-acceleration", "comparison-wrong-data", compare(("accel, _ = imu.read()", "accel, gyro = imu.read()"), ("low_pass.update(accel)", "low_pass.update(gyro)")), **only("comparison_plot")),
    fault("a-new-filter-for-each-sample", "comparison-wrong-data", compare(("low_pass.update(accel)", "LowPassFilter(alpha=0.1).update(accel)")), **only("comparison_plot")),
    fault("filter-that-lets-all-pass", "comparison-wrong-data", compare(("LowPassFilter(alpha=0.1)", "LowPassFilter(alpha=1.0)")), **only("comparison_plot")),
    fault("plot-stops", "raises", sheet(("    fig, axes =", "    scaled = imu_data['acceleration'] * np.ones(7)\n    fig, axes ="))),
    fault("plot-raises", "raises", sheet(("axes[1].set_xlabel('Time (s)')", "axes[1].set_xlabel('Time (s)', fontsize='gigantic')"))),
    fault("label-of-pyplot-on-a-panel", "raises", sheet(("axes[1].set_xlabel('Time (s)')", "axes[1].xlabel('Time (s)')"))),
    fault("plot-never-returns", "never-returns", loop((SAVE, SAVE + "    while plt.get_fignums():\n        pass\n"))),
    fault("plot-kills", "kills-its-process", pyplot(('    plt.savefig("imu_data.png")\n', '    import ctypes\n    ctypes.string_at(0)\n    plt.savefig("imu_data.png")\n'))),
    fault("no-plot-function", "name-missing", lab(plot=PLOT_3X2.replace("plot_imu_data", "make_plots"), main=NOISE_MAIN.split("    imu =", maxsplit=1)[0] + "    make_plots(simulate_and_collect(model, data, 3.0))\n")),
]
