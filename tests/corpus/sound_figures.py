"""Sound ways to draw the two pictures: layouts, labels, languages, back ends."""



from __future__ import annotations

from tests.corpus import sheet
from tests.corpus.pieces import COMPARE, PLOT_LOOP, edit, lab

# Every channel in its own panel.
PLOT_3X2 = '''\
def plot_imu_data(imu_data):
    fig, axs = plt.subplots(3, 2, figsize=(14, 9), sharex="col")
    names = ["x", "y", "z"]
    for row in range(3):
        left, right = axs[row]
        left.plot(imu_data["time"], imu_data["acceleration"][:, row], "C%d" % row)
        left.set_title("Acceleration along " + names[row])
        left.set_ylabel("a_%s in m/s^2" % names[row])
        right.plot(imu_data["time"], imu_data["angular_velocity"][:, row], "C%d" % row)
        right.set_title("Angular velocity about " + names[row])
        right.set_ylabel("w_%s in rad/s" % names[row])
    for ax in axs[-1]:
        ax.set_xlabel("t in s")
    fig.savefig("imu_data.png", bbox_inches="tight")
'''

PLOT_MOSAIC = '''\
def plot_imu_data(imu_data):
    fig, ax = plt.subplot_mosaic([["acc"], ["gyr"]], figsize=(10, 7), layout="constrained")
    t = imu_data["time"]
    lines = []
    for k, name in enumerate(["X axis", "Y axis", "Z axis"]):
        (line,) = ax["acc"].plot(t, imu_data["acceleration"][:, k], color=f"C{k}", label=name)
        ax["gyr"].plot(t, imu_data["angular_velocity"][:, k], color=f"C{k}")
        lines.append(line)
    ax["acc"].set(ylabel=r"Specific force ($\\mathrm{m/s^2}$)")
    ax["gyr"].set(ylabel=r"Angular rate ($\\mathrm{rad/s}$)", xlabel="Time (s)")
    fig.legend(handles=lines, loc="outside right upper", title="both panels")
    fig.suptitle("IMU on the torso: accelerometer (top), gyroscope (bottom)")
    fig.savefig("imu_data.png", dpi=110)
'''

PLOT_NO_PYPLOT = '''\
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def plot_imu_data(imu_data):
    fig = Figure(figsize=(10, 7))
    FigureCanvasAgg(fig)
    upper = fig.add_subplot(211)
    lower = fig.add_subplot(212, sharex=upper)
    for ax, key, title, unit in (
        (upper, "acceleration", "Accelerometer", "m s⁻²"),
        (lower, "angular_velocity", "Gyroscope", "rad s⁻¹"),
    ):
        for column, label in zip(np.transpose(imu_data[key]), "xyz"):
            ax.plot(imu_data["time"], column, label=label)
        ax.set_title(title)
        ax.set_ylabel(f"{key.replace('_', ' ')} [{unit}]")
        ax.legend()
    lower.set_xlabel("time [s]")
    fig.savefig("imu_data.png")
'''

PLOT_BUFFER = '''\
import io
from pathlib import Path


def plot_imu_data(imu_data):
    """Draws into memory first and writes the bytes when they are complete."""
    fig, axes = plt.subplots(nrows=2, figsize=(9, 6))
    for ax, key, ylabel in zip(axes, ("acceleration", "angular_velocity"),
                               ("Acceleration (meters per second squared)", "Angular velocity (radians per second)")):
        ax.plot(imu_data["time"], imu_data[key], label=["x", "y", "z"])
        ax.set_xlabel("Time (seconds)")
        ax.set_ylabel(ylabel)
        ax.set_title(key.replace("_", " ").capitalize())
        ax.legend()
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png", dpi=120)
    Path("imu_data.png").write_bytes(buffer.getvalue())
    plt.close("all")
'''

# The curves carry their names at their right end; there is no legend box.
PLOT_DIRECT_LABELS = '''\
def plot_imu_data(imu_data):
    t = np.asarray(imu_data["time"])
    fig, (ax_a, ax_w) = plt.subplots(2, 1, figsize=(11, 7), sharex=True)
    for k, name in enumerate(("x", "y", "z")):
        for ax, values in ((ax_a, imu_data["acceleration"]), (ax_w, imu_data["angular_velocity"])):
            (line,) = ax.plot(t, values[:, k])
            ax.annotate(name, xy=(t[-1], values[-1, k]), xytext=(6, 0), textcoords="offset points",
                        color=line.get_color(), va="center")
    ax_a.set_title("What the accelerometer feels")
    ax_w.set_title("What the gyroscope feels")
    ax_a.set_ylabel("acceleration (m/s²)")
    ax_w.set_ylabel("angular velocity (rad/s)")
    ax_w.set_xlabel("time (s)")
    fig.savefig("imu_data.png", dpi=100)
'''

PLOT_STEP = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1, figsize=(12, 8))
    for k, lab in enumerate(["forward", "right", "down"]):
        axes[0].step(imu_data["time"], imu_data["acceleration"][:, k], where="post", label=lab)
        axes[1].step(imu_data["time"], imu_data["angular_velocity"][:, k], where="post", label=lab)
    axes[0].set(title="Accelerometer", xlabel="Time, s", ylabel="Acceleration, m/s²")
    axes[1].set(title="Gyroscope", xlabel="Time, s", ylabel="Angular velocity, rad/s")
    axes[0].legend()
    axes[1].legend()
    plt.savefig("imu_data")        # matplotlib adds .png
'''

PLOT_SCATTER = '''\
def plot_imu_data(imu_data):
    fig, axes = plt.subplots(2, 1, figsize=(12, 8))
    for panel, key, what, unit in zip(axes, ["acceleration", "angular_velocity"], ["Acceleration", "Angular rate"],
                                      ["m/s**2", "rad/s"]):
        for k, marker in enumerate(".+x"):
            panel.scatter(imu_data["time"], imu_data[key][:, k], s=6, marker=marker, label="XYZ"[k])
        panel.set_title(what + " over time")
        panel.set_xlabel("Time (s)")
        panel.set_ylabel(what + " (" + unit + ")")
        panel.legend(ncol=3)
    fig.savefig("imu_data.png", dpi=90)
    plt.close()
'''

PLOT_THINNED = '''\
def plot_imu_data(imu_data, max_points=500):
    """A screen has no room for every sample."""
    step = max(1, len(imu_data["time"]) // max_points)
    t, a, w = (np.asarray(imu_data[k])[::step] for k in ("time", "acceleration", "angular_velocity"))
    fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 6))
    top.plot(t, a, ".-", markersize=2)
    top.legend(["x", "y", "z"], loc="upper right")
    top.set(title="accelerometer", ylabel="(m/s²)", xlabel="(s)")
    bottom.plot(t, w, ".-", markersize=2)
    bottom.legend(["x", "y", "z"], loc="upper right")
    bottom.set(title="gyroscope", ylabel="(rad/s)", xlabel="(s)")
    fig.savefig("imu_data.png")
'''

PLOT_DEGREES = '''\
def plot_imu_data(imu_data):
    """The gyroscope is drawn in degrees per second: easier to imagine."""
    fig, (top, bottom) = plt.subplots(2, 1, figsize=(10, 7), sharex=True)
    top.plot(imu_data["time"], imu_data["acceleration"], label=("x", "y", "z"))
    bottom.plot(imu_data["time"], np.rad2deg(imu_data["angular_velocity"]), label=("roll", "pitch", "yaw"))
    top.set(title="Accelerometer", ylabel="Acceleration (m/s²)")
    bottom.set(title="Gyroscope", ylabel="Angular velocity (deg/s)", xlabel="Time (s)")
    top.legend()
    bottom.legend()
    fig.savefig("imu_data.png")
    plt.show()
'''

PLOT_TWIN = '''\
def plot_imu_data(imu_data):
    """One panel with two scales: acceleration on the left, angular velocity on the right."""
    fig, left = plt.subplots(figsize=(12, 6))
    right = left.twinx()
    for k, axis in enumerate("xyz"):
        left.plot(imu_data["time"], imu_data["acceleration"][:, k], color=f"C{k}", label=f"acceleration {axis}")
        right.plot(imu_data["time"], imu_data["angular_velocity"][:, k], color=f"C{k + 3}", ls="--", label=f"angular velocity {axis}")
    left.set_xlabel("Time (s)")
    left.set_ylabel("Acceleration (m/s²), solid")
    right.set_ylabel("Angular velocity (rad/s), dashed")
    left.set_title("Accelerometer and gyroscope")
    left.legend(loc="upper left")
    right.legend(loc="upper right")
    fig.savefig("imu_data.png", dpi=100)
'''

PLOT_SIDE_BY_SIDE = '''\
def plot_imu_data(imu_data, show=True, filename="imu_data.png"):
    plt.style.use("dark_background")
    fig, (ax1, ax2) = plt.subplots(1, 2, figsize=(16, 6))
    styles = ["-", "--", ":"]
    for i, s in enumerate(styles):
        ax1.plot(imu_data["time"], imu_data["acceleration"][:, i], s, label="a" + "xyz"[i])
        ax2.plot(imu_data["time"], imu_data["angular_velocity"][:, i], s, label="ω" + "xyz"[i])
    ax1.set_title("Acceleration")
    ax2.set_title("Angular velocity")
    ax1.set_ylabel("m/s²")
    ax2.set_ylabel("rad/s")
    fig.supxlabel("Time in s")
    ax1.legend()
    ax2.legend()
    plt.savefig(filename, dpi=80)
    if show:
        plt.show()
'''

# The function draws; whoever calls it saves.
PLOT_RETURNS_FIGURE = PLOT_LOOP.replace('    fig.savefig("imu_data.png", dpi=100)\n    plt.close(fig)\n', "    return fig\n")
MAIN_SAVES = '''\
if __name__ == "__main__":
    plt.ion()
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    figure = plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), 3.0))
    figure.savefig("imu_data.png", dpi=100)
    plt.pause(0.001)
'''


def _sheet_plot(*changes: tuple[str, str]) -> str:
    return edit({"p": sheet.PLOT}, "p", *changes)["p"]


# The sheet's own figure with its words in other languages.
PLOT_GERMAN = _sheet_plot(
    ("'Acceleration (m/s²)'", "'Beschleunigung in m/s²'"),
    ("'Accelerometer Readings'", "'Messwerte des Beschleunigungssensors'"),
    ("'Time (s)'", "'Zeit in s'"),
    ("'Angular Velocity (rad/s)'", "'Winkelgeschwindigkeit in rad/s'"),
    ("'Gyroscope Readings'", "'Messwerte des Drehratensensors'"),
    ("'Roll rate'", "'Rollrate'"),
    ("'Pitch rate'", "'Nickrate'"),
    ("'Yaw rate'", "'Gierrate'"),
)
PLOT_FRENCH = _sheet_plot(
    ("'Acceleration (m/s²)'", "'Accélération (m·s⁻²)'"),
    ("'Accelerometer Readings'", "'Mesures de l\\'accéléromètre'"),
    ("'Time (s)'", "'Temps (s)'"),
    ("'Angular Velocity (rad/s)'", "'Vitesse angulaire (rad·s⁻¹)'"),
    ("'Gyroscope Readings'", "'Mesures du gyroscope'"),
    ("'Roll rate'", "'roulis'"),
    ("'Pitch rate'", "'tangage'"),
    ("'Yaw rate'", "'lacet'"),
)
PLOT_SPANISH = _sheet_plot(
    ("'Acceleration (m/s²)'", "'Aceleración [m/s²]'"),
    ("'Accelerometer Readings'", "'Acelerómetro'"),
    ("'Time (s)'", "'Tiempo [s]'"),
    ("'Angular Velocity (rad/s)'", "'Velocidad angular [rad/s]'"),
    ("'Gyroscope Readings'", "'Giróscopo'"),
    ("'Roll rate'", "'Alabeo'"),
    ("'Pitch rate'", "'Cabeceo'"),
    ("'Yaw rate'", "'Guiñada'"),
)
PLOT_CHINESE = _sheet_plot(
    ("'Acceleration (m/s²)'", "'加速度 (m/s²)'"),
    ("'Accelerometer Readings'", "'加速度计'"),
    ("'Time (s)'", "'时间 (s)'"),
    ("'Angular Velocity (rad/s)'", "'角速度 (rad/s)'"),
    ("'Gyroscope Readings'", "'陀螺仪'"),
    ("'Roll rate'", "'滚转'"),
    ("'Pitch rate'", "'俯仰'"),
    ("'Yaw rate'", "'偏航'"),
)
PLOT_JAPANESE = _sheet_plot(
    ("'Acceleration (m/s²)'", "'加速度 [m/s^2]'"),
    ("'Accelerometer Readings'", "'加速度センサ'"),
    ("'Time (s)'", "'時間 [s]'"),
    ("'Angular Velocity (rad/s)'", "'角速度 [rad/s]'"),
    ("'Gyroscope Readings'", "'ジャイロセンサ'"),
    ("'Roll rate'", "'ロール'"),
    ("'Pitch rate'", "'ピッチ'"),
    ("'Yaw rate'", "'ヨー'"),
)
PLOT_KOREAN = _sheet_plot(
    ("'Acceleration (m/s²)'", "'가속도 (m/s²)'"),
    ("'Accelerometer Readings'", "'가속도 센서'"),
    ("'Time (s)'", "'시간 (s)'"),
    ("'Angular Velocity (rad/s)'", "'각속도 (rad/s)'"),
    ("'Gyroscope Readings'", "'자이로스코프'"),
)
PLOT_RUSSIAN = _sheet_plot(
    ("'Acceleration (m/s²)'", "'Ускорение, м/с²'"),
    ("'Accelerometer Readings'", "'Показания акселерометра'"),
    ("'Time (s)'", "'Время, с'"),
    ("'Angular Velocity (rad/s)'", "'Угловая скорость, рад/с'"),
    ("'Gyroscope Readings'", "'Показания гироскопа'"),
)

# Numbers in another unit than the recorded ones, and labels that say so.
PLOT_PORTUGUESE_DEGREES = (
    PLOT_DEGREES.replace("Acceleration (m/s²)", "Aceleração (m/s²)")
    .replace("Angular velocity (deg/s)", "Velocidade angular (graus/s)")
    .replace("Time (s)", "Tempo (s)")
)
PLOT_MILLISECONDS = PLOT_LOOP.replace('t = imu_data["time"]', 't = 1000 * imu_data["time"]').replace("Time [s]", "Time [ms]")
PLOT_MILLISECONDS_BESIDE_TICKS = PLOT_LOOP.replace(
    '    bottom.set_xlabel("Time [s]")\n',
    '    bottom.set_xlabel("Time [ms]")\n    bottom.xaxis.set_major_formatter(lambda seconds, _: f"{1000 * seconds:.0f}")\n',
)

# The titles tell of the experiment, the labels of the sensors.
PLOT_TITLES_OF_THE_EXPERIMENT = PLOT_LOOP.replace('"Torso accelerometer"', '"Push of 0.5 m/s, sample rate 500 Hz"').replace(
    '"Torso gyroscope"', '"Torso (global frame), accurate to 1 %"'
)


def _compare(*changes: tuple[str, str]) -> str:
    return edit({"c": COMPARE}, "c", *changes)["c"]


COMPARE_GERMAN = _compare(
    ('"raw z"', '"Rohsignal z"'),
    ('"filtered z"', '"gefiltert z"'),
    ('"Time (s)"', '"Zeit in s"'),
    ('"Acceleration (m/s²)"', '"Beschleunigung in m/s²"'),
    ('"Raw and filtered acceleration"', '"Rohsignal und gefiltertes Signal"'),
)
COMPARE_CHINESE = _compare(
    ('"raw z"', '"原始信号"'),
    ('"filtered z"', '"滤波后"'),
    ('"Time (s)"', '"时间 (s)"'),
    ('"Acceleration (m/s²)"', '"加速度 (m/s²)"'),
    ('"Raw and filtered acceleration"', '"原始信号与滤波信号对比"'),
)

# All three axes, one panel each, raw behind and filtered in front.
COMPARE_THREE_PANELS = '''\
if __name__ == "__main__":
    model = mujoco.MjModel.from_xml_path(MODEL_PATH)
    data = mujoco.MjData(model)
    imu = NoisyIMU(model, data, model.sensor("torso_accelerometer").id, model.sensor("torso_gyroscope").id)
    lp = LowPassFilter(0.05)
    raw = np.zeros((600, 3))
    flt = np.zeros((600, 3))
    for i in range(600):
        mujoco.mj_step(model, data)
        raw[i] = imu.read()[0]
        flt[i] = lp.update(raw[i])
    fig, axs = plt.subplots(3, 1, sharex=True, figsize=(9, 8), constrained_layout=True)
    for ax, r, f, name in zip(axs, raw.T, flt.T, "xyz"):
        ax.plot(r, color="0.7")
        ax.plot(f, color="C3")
        ax.set_ylabel(f"a_{name} (m/s²)")
    axs[-1].set_xlabel("sample")
    fig.legend(["raw", "filtered"], ncol=2)
    fig.suptitle("Noisy accelerometer before and after the low-pass filter")
    fig.savefig("filtered_imu.png")
'''

# Raw above, filtered below, as some draw a comparison.
COMPARE_RAW_AS_DOTS = COMPARE.replace('alpha=0.5, label="raw z")', 'marker=".", linestyle="none", color="gray", label="measured z")')

PLOT_TWO_FILES = '''\
def plot_imu_data(imu_data):
    """One picture for each sensor."""
    for name, unit, title in (("acceleration", "m/s²", "Accelerometer"), ("angular_velocity", "rad/s", "Gyroscope")):
        plt.figure(figsize=(9, 4))
        plt.plot(imu_data["time"], imu_data[name], label=["x", "y", "z"])
        plt.title(title)
        plt.xlabel("Time (s)")
        plt.ylabel(f"{name.replace('_', ' ')} ({unit})")
        plt.legend()
        plt.tight_layout()
        plt.savefig(f"imu_data_{name}.png")
        plt.close()
'''

PLOT_NAMED_IN_BLACK = '''\
def plot_imu_data(imu_data):
    """The names stand at the ends of the curves, in black."""
    fig, axes = plt.subplots(2, 1, figsize=(10, 7), sharex=True)
    t = imu_data["time"]
    for ax, name, unit in zip(axes, ("acceleration", "angular_velocity"), ("m/s^2", "rad/s")):
        for k, axis in enumerate("xyz"):
            ax.plot(t, imu_data[name][:, k])
            ax.text(t[-1], imu_data[name][-1, k], f" {axis}", va="center")
        ax.set_title(name.replace("_", " "))
        ax.set_ylabel(f"{name.replace('_', ' ')} [{unit}]")
    axes[-1].set_xlabel("time [s]")
    fig.savefig("imu_data.png")
    plt.close(fig)
'''

PLOT_PIECEWISE = '''\
def plot_imu_data(imu_data):
    """One call a point, or a segment, in a loop."""
    fig, axes = plt.subplots(2, 1, figsize=(10, 7), sharex=True)
    t = imu_data["time"]
    for ax, name, unit in zip(axes, ("acceleration", "angular_velocity"), ("m/s^2", "rad/s")):
        for k, (axis, colour) in enumerate(zip("xyz", "rgb")):
            for i in range(0, len(t) - 1, STEP):
                DRAW
        ax.set_title(name.replace("_", " "))
        ax.set_ylabel(f"{name.replace('_', ' ')} [{unit}]")
        ax.legend()
    axes[-1].set_xlabel("time [s]")
    fig.savefig("imu_data.png")
    plt.close(fig)
'''
ONE_LABEL = 'label=axis if i == 0 else "_"'
PLOT_DOT_BY_DOT = PLOT_PIECEWISE.replace("STEP", "max(1, len(t) // 250)").replace(
    "DRAW", f'ax.plot(t[i], imu_data[name][i, k], ".", color=colour, {ONE_LABEL})'
)
PLOT_SCATTER_BY_POINT = PLOT_PIECEWISE.replace("STEP", "max(1, len(t) // 250)").replace(
    "DRAW", f"ax.scatter(t[i], imu_data[name][i, k], s=5, color=colour, {ONE_LABEL})"
)
PLOT_BY_SEGMENTS = PLOT_PIECEWISE.replace("STEP", "1").replace(
    "DRAW", f"ax.plot(t[i : i + 2], imu_data[name][i : i + 2, k], color=colour, {ONE_LABEL})"
)

PLOT_SHADED_BY_TIME = '''\
from matplotlib.collections import LineCollection


def plot_imu_data(imu_data):
    """Each curve in one hue that darkens with time, its name at its end."""
    fig, axes = plt.subplots(2, 1, figsize=(10, 7), sharex=True)
    t = imu_data["time"]
    for ax, name, unit in zip(axes, ("acceleration", "angular_velocity"), ("m/s^2", "rad/s")):
        for k, (axis, hue) in enumerate(zip("xyz", ("Reds", "Greens", "Blues"))):
            points = np.column_stack([t, imu_data[name][:, k]])
            segments = np.stack([points[:-1], points[1:]], axis=1)
            ax.add_collection(LineCollection(segments, array=t[:-1], cmap=hue, norm=plt.Normalize(-t[-1], t[-1])))
            ax.text(t[-1], points[-1, 1], f" {axis}", va="center")
        ax.autoscale()
        ax.set_title(name.replace("_", " "))
        ax.set_ylabel(f"{name.replace('_', ' ')} [{unit}]")
    axes[-1].set_xlabel("time [s]")
    fig.savefig("imu_data.png")
    plt.close(fig)
'''

FIGURES = {
    "a_call_for_each_point": lab(plot=PLOT_DOT_BY_DOT),
    "a_scatter_for_each_point": lab(plot=PLOT_SCATTER_BY_POINT),
    "a_call_for_each_segment": lab(plot=PLOT_BY_SEGMENTS),
    "curves_that_darken_with_time": lab(plot=PLOT_SHADED_BY_TIME),
    "a_picture_for_each_sensor": lab(plot=PLOT_TWO_FILES),
    "names_beside_the_curves_in_black": lab(plot=PLOT_NAMED_IN_BLACK),
    "main_file_draws_the_comparison": {
        **lab(compare=""),
        "main.py": "import matplotlib.pyplot as plt\nimport mujoco\nimport numpy as np\n\nfrom filters import LowPassFilter\n"
        "from imu_reader import MODEL_PATH\nfrom noisy_imu import NoisyIMU\n\n\n" + COMPARE,
    },
    "panels_three_by_two": lab(plot=PLOT_3X2),
    "mosaic_one_legend_for_the_figure": lab(plot=PLOT_MOSAIC, compare=COMPARE_THREE_PANELS),
    "figure_without_pyplot": lab(plot=PLOT_NO_PYPLOT),
    "saved_through_a_buffer": lab(plot=PLOT_BUFFER),
    "names_beside_the_curves": lab(plot=PLOT_DIRECT_LABELS),
    "step_curves_and_name_without_ending": lab(plot=PLOT_STEP, compare=COMPARE_RAW_AS_DOTS),
    "scatter": lab(plot=PLOT_SCATTER),
    "thinned_curves_unit_only_labels": lab(plot=PLOT_THINNED),
    "gyroscope_in_degrees_and_labelled_so": lab(plot=PLOT_DEGREES),
    "twin_axes": lab(plot=PLOT_TWIN),
    "side_by_side_dark": lab(plot=PLOT_SIDE_BY_SIDE),
    "main_saves_what_the_function_drew": lab(plot=PLOT_RETURNS_FIGURE, main=MAIN_SAVES),
    "labels_in_german": lab(plot=PLOT_GERMAN, compare=COMPARE_GERMAN),
    "labels_in_french": lab(plot=PLOT_FRENCH),
    "labels_in_spanish": lab(plot=PLOT_SPANISH),
    "labels_in_chinese": lab(plot=PLOT_CHINESE, compare=COMPARE_CHINESE),
    "labels_in_japanese": lab(plot=PLOT_JAPANESE),
    "labels_in_korean": lab(plot=PLOT_KOREAN),
    "labels_in_russian": lab(plot=PLOT_RUSSIAN),
    "degrees_in_portuguese": lab(plot=PLOT_PORTUGUESE_DEGREES),
    "time_in_milliseconds_and_labelled_so": lab(plot=PLOT_MILLISECONDS),
    "milliseconds_beside_the_ticks": lab(plot=PLOT_MILLISECONDS_BESIDE_TICKS),
    "titles_of_the_experiment": lab(plot=PLOT_TITLES_OF_THE_EXPERIMENT),
}
