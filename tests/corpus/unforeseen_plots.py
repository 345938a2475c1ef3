"""Pictures that show less than their code says, and sound ones in rare styles, with what a careful marker takes.

Each was written, and its cost decided, before the code that judges it: `loses` are the checks that lose points, `most` is what
they may lose together, `names` the mistakes that may be named; what is sound loses nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

from tests.corpus.pieces import COMPARE, PLOT_LOOP, edit, lab

CURVES, SAVED, COMPARISON = "curves_match_data", "saves_image", "comparison_plot"
NEEDS_CURVES = ("two_labelled_panels", CURVES, "axis_labels_with_units", "legend_names_curves", "titles")
"""What a picture loses on which no curve can be seen."""
NOT_SEEN = ("curves-not-seen",)


@dataclass(frozen=True)
class Unforeseen:
    """A submission whose picture has one fault that no list foresaw, or none."""

    name: str
    files: dict[str, str]
    loses: tuple[str, ...] = ()
    most: float = 0.0
    names: tuple[str, ...] = ()


def _plot(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(plot=edit({"p": PLOT_LOOP}, "p", *changes)["p"])


def _compare(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(compare=edit({"c": COMPARE}, "c", *changes)["c"])


_LAYOUT = "    fig.tight_layout()\n"
_SAVE = '    fig.savefig("imu_data.png", dpi=100)\n'
_STROKE = ('label=f"$a_{axis}$"', 'label=rf"$\\omega_{axis}$"')


def _late(*lines: str) -> dict[str, str]:
    """The sound plot with further lines before it is saved."""
    return _plot((_LAYOUT, "".join(f"    {line}\n" for line in lines) + _LAYOUT))


def _on_each(*lines: str) -> dict[str, str]:
    return _late("for ax in fig.axes:", *(f"    {line}" for line in lines))


def _stroked(options: str) -> dict[str, str]:
    """The sound plot with further options of every curve."""
    return _plot(*((old, f"{options}, {old}") for old in _STROKE))


def _saved(*lines: str) -> dict[str, str]:
    return _plot((_SAVE, "".join(f"    {line}\n" for line in lines)))


# --- what hides every curve ----------------------------------------------------------------------------------------------

_OVER_EACH = {
    "a-white-sheet": ['ax.axhspan(-1e4, 1e4, color="white", zorder=9)'],
    "a-white-band-filled-in": ['ax.fill_between([-1, 9], -1e4, 1e4, color="white", zorder=9)'],
    "white-letters": ['ax.text(0.5, 0.5, "\\u2588" * 9, transform=ax.transAxes, fontsize=400, ha="center", va="center", color="white")'],
    "a-grid-like-planks": ["ax.set_axisbelow(False)", 'ax.grid(True, color="white", linewidth=90)'],
    "a-grid-like-a-net": [
        "ax.set_axisbelow(False)",
        "ax.yaxis.set_major_locator(plt.MultipleLocator(np.ptp(ax.get_ylim()) / 150))",
        'ax.yaxis.set_major_formatter("")',
        'ax.grid(True, axis="y", color="white", linewidth=3, alpha=1)',
    ],
    "ticks-like-planks": ["ax.set_axisbelow(False)", 'ax.tick_params(axis="x", direction="in", length=2000, width=90, color="white")'],
    "a-picture-of-nothing": ['ax.imshow(np.ones((2, 2, 3)), extent=[-9, 9, -1e4, 1e4], aspect="auto", zorder=9, clip_on=True)', "ax.relim()"],
    "one-thick-stroke": ['ax.plot(ax.get_xlim(), np.mean(ax.get_ylim()) * np.ones(2), color="white", linewidth=900)'],
    "a-box-of-an-annotation": ['ax.annotate(".", (0.5, 0.5), xycoords="axes fraction", bbox={"fc": "white", "ec": "white", "boxstyle": "square,pad=90"})'],
    "one-white-bar": ['ax.bar([0.5], [2e4], width=99, bottom=-1e4, color="white", zorder=9)', "ax.margins(0)"],
    "large-white-points": ['ax.scatter(np.linspace(*ax.get_xlim(), 40), np.full(40, np.mean(ax.get_ylim())), s=2e5, color="white", zorder=9)'],
    "white-frames": ["for spine in ax.spines.values():", '    spine.set(linewidth=2000, color="white", zorder=9)'],
    "a-white-heading": ['ax.set_title("\\u2588" * 20, fontsize=500, color="white", y=-0.5)'],
    "a-white-axis-label": ['ax.set_xlabel("\\u2588" * 20, fontsize=500, color="white", labelpad=-400)'],
    "a-white-mesh": ['ax.pcolormesh([-9, 9], [-1e4, 1e4], [[0.5]], cmap="gray", vmin=0, vmax=0.5, zorder=9)'],
    "a-legend-like-a-wall": ["ax.legend(fontsize=150, framealpha=1, loc='center')"],
    "a-legend-padded-like-a-wall": ["ax.legend(borderpad=60, framealpha=1, loc='center')"],
    "a-table-over-all": ['ax.table([[""]], bbox=[0, 0, 1, 1], cellColours=[["white"]], zorder=9)'],
    "a-white-arrow": ['ax.annotate("", (1, 0.5), (0, 0.5), "axes fraction", arrowprops={"color": "white", "width": 900, "headwidth": 901})'],
    "a-wedge-over-all": ['ax.add_patch(plt.matplotlib.patches.Wedge((0.5, 0.5), 9, 0, 360, transform=ax.transAxes, color="white", zorder=9))'],
    "an-inset-over-all": ["inset = ax.inset_axes([0, 0, 1, 1], zorder=9)", "inset.set(xticks=[], yticks=[])"],
    "a-sheet-in-the-curves-colours": ["for k in range(3):", '    ax.axhspan(-1e4 + k, 1e4, color=f"C{k}", zorder=9)'],
}  # fmt: skip

_OVER_ALL = {
    "axes-over-the-figure": ["fig.add_axes([0, 0, 1, 1], zorder=9).set(xticks=[], yticks=[])"],
    "a-sheet-over-the-figure": ['fig.add_artist(plt.Rectangle((0, 0), 1, 1, color="white", zorder=99))'],
    "letters-over-the-figure": ['fig.text(0.5, 0.5, "\\u2588" * 9, fontsize=900, ha="center", va="center", color="white", zorder=99)'],
    "an-image-over-the-figure": ["fig.figimage(np.ones((2000, 2000, 3)), zorder=99)"],
    "a-legend-over-the-figure": ["fig.legend(fontsize=200, framealpha=1, loc='center')"],
    "a-title-over-the-figure": ['fig.suptitle("\\u2588" * 9, fontsize=900, color="white", y=1.5)'],
}  # fmt: skip

_FAINT = {
    "no-opacity": "alpha=0",
    "hardly-any-opacity": "alpha=0.005",
    "no-width": "linewidth=0",
    "white-on-white": 'color="white"',
    "nearly-white": 'color="#fbfbfb"',
    "no-colour": 'color="none"',
    "dashes-that-never-come": "linestyle=(0, (0.01, 1000))",
    "dashes-far-apart": "linestyle=(0, (2, 120))",
    "one-point-in-a-thousand": 'marker=".", markevery=1000, linestyle="none"',
    "switched-off": "visible=False",
    "markers-of-no-size": 'linestyle="none", marker="o", markersize=0.01, markeredgewidth=0',
    "hollow-white-markers": 'linestyle="none", marker="o", markerfacecolor="white", markeredgecolor="white"',
}

_UNDONE = {
    "clipped-to-nothing": ["line.set_clip_path(plt.Circle((9, 9), 0.1, transform=fig.transFigure))"],
    "filtered-to-nothing": ["line.set_agg_filter(lambda image, dpi: (np.zeros_like(image), 0, 0))"],
    "moved-away": ["line.set_transform(ax.transData + plt.matplotlib.transforms.Affine2D().translate(0, 9999))"],
    "moved-by-half-a-panel": ["line.set_transform(ax.transData + plt.matplotlib.transforms.Affine2D().translate(90, 120))"],
    "stroked-in-white": [
        "import matplotlib.patheffects as effects",
        'line.set_path_effects([effects.Stroke(foreground="white", linewidth=3)])',
    ],
    "squeezed-to-a-point": ["line.set_transform(ax.transAxes + plt.matplotlib.transforms.Affine2D().scale(0.001))"],
}  # fmt: skip

_PANELS = {
    "panels-in-the-curves-colour": ['ax.set_facecolor("C0")', "for line in ax.lines:", '    line.set_color("C0")'],
    "panels-like-stamps": ["ax.set_position([0.1, 0.1 + 0.5 * (ax is top), 0.02, 0.02])"],
    "panels-beside-the-paper": ["ax.set_position([2, 2, 0.5, 0.5])"],
    "limits-that-show-nothing": ["ax.set_ylim(1e3, 2e3)"],
    "a-time-that-never-comes": ["ax.set_xlim(100, 200)"],
}

_HIDDEN = [
    *(Unforeseen(name, _on_each(*lines), NEEDS_CURVES, 15.0, NOT_SEEN) for name, lines in _OVER_EACH.items()),
    *(Unforeseen(name, _late(*lines), NEEDS_CURVES, 15.0, NOT_SEEN) for name, lines in _OVER_ALL.items()),
    *(Unforeseen(name, _stroked(options), NEEDS_CURVES, 15.0, NOT_SEEN) for name, options in _FAINT.items()),
    *(
        Unforeseen(name, _on_each("for line in ax.lines:", *(f"    {line}" for line in lines)), NEEDS_CURVES, 15.0, NOT_SEEN)
        for name, lines in _UNDONE.items()
    ),
    *(Unforeseen(name, _on_each(*lines), NEEDS_CURVES, 15.0, NOT_SEEN) for name, lines in _PANELS.items()),
    Unforeseen(
        "panels-switched-off", _on_each("ax.set_visible(False)"), (*NEEDS_CURVES, SAVED), 18.0, ("blank-image",)
    ),
    Unforeseen(
        "a-class-that-draws-nothing",
        _late("plt.Line2D.draw = lambda self, renderer: None"),
        NEEDS_CURVES, 15.0, NOT_SEEN,
    ),
    Unforeseen(
        "a-corner-is-saved",
        _saved('fig.savefig("imu_data.png", bbox_inches=plt.matplotlib.transforms.Bbox([[0, 0], [0.5, 0.5]]))', "plt.close(fig)"),
        (*NEEDS_CURVES, SAVED), 18.0, (*NOT_SEEN, "low-resolution"),
    ),
]  # fmt: skip

# --- what hides some curves, or a part of them -----------------------------------------------------------------------------

_PARTLY = [
    Unforeseen("a-fiftieth-is-left", _on_each("ax.set_xlim(t[0], t[0] + 0.02 * np.ptp(t))"), (CURVES,), 6.0, NOT_SEEN),
    Unforeseen("the-first-fifth", _late("top.set_xlim(t[0], t[0] + 0.2 * np.ptp(t))"), (CURVES,), 6.0, NOT_SEEN),
    Unforeseen("the-last-third", _late("bottom.set_xlim(t[0] + 0.67 * np.ptp(t), t[-1])"), (CURVES,), 6.0, NOT_SEEN),
    Unforeseen("gravity-left-outside", _late("top.set_ylim(100, 101 + imu_data['acceleration'].max())"), (CURVES,), 4.0, NOT_SEEN),
    Unforeseen("one-panel-covered", _late('bottom.axhspan(-1e4, 1e4, color="white", zorder=9)'), (CURVES,), 3.0, NOT_SEEN),
    Unforeseen("one-curve-in-white", _late('top.lines[1].set_color("white")', "top.legend()"), (CURVES,), 1.0, NOT_SEEN),
    Unforeseen("one-curve-see-through", _late("bottom.lines[2].set_alpha(0)"), (CURVES,), 1.0, NOT_SEEN),
    Unforeseen("one-curve-under-a-wide-one", _late("top.lines[2].set(linewidth=800, zorder=9)"), (CURVES,), 3.0, NOT_SEEN),
    Unforeseen("one-curve-in-hair-dashes", _late("top.lines[0].set_linestyle((0, (0.01, 300)))"), (CURVES,), 1.0, NOT_SEEN),
]  # fmt: skip

# --- other numbers in every curve: the words about them are right ---------------------------------------------------------------

_NOISY = [
    Unforeseen(
        f"noise-of-{size}-added-while-plotting",
        _late(f"for line in (*top.lines, *bottom.lines): line.set_ydata(line.get_ydata() + np.random.normal(0, {size}, len(t)))"),
        (CURVES,), 5.0, ("wrong-data-plotted",),
    )
    for size in (0.5, 2)
]  # fmt: skip

# --- what stands in the file at the end -------------------------------------------------------------------------------------

_TWO_FIGURES = '''\
def plot_imu_data(imu_data):
    for name, unit, title in (("acceleration", "m/s²", "Accelerometer"), ("angular_velocity", "rad/s", "Gyroscope")):
        plt.figure(figsize=(9, 4))
        plt.plot(imu_data["time"], imu_data[name], label=["x", "y", "z"])
        plt.title(title)
        plt.xlabel("Time (s)")
        plt.ylabel(f"{name.replace('_', ' ')} ({unit})")
        plt.legend()
        plt.savefig("imu_data.png")
        plt.close()
'''
_LOST = ("picture-overwritten", "plot-not-saved", "blank-image")

_FILES = [
    Unforeseen("two-figures-under-one-name", lab(plot=_TWO_FIGURES), (SAVED,), 1.5, _LOST),
    Unforeseen("a-blank-figure-afterwards", _saved(_SAVE.strip(), "plt.figure(figsize=(9, 6)).savefig('imu_data.png')"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen("cut-short", _saved(_SAVE.strip(), "with open('imu_data.png', 'r+b') as file:", "    file.truncate(300)"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen("emptied", _saved(_SAVE.strip(), "open('imu_data.png', 'w').close()"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen("words-in-its-place", _saved(_SAVE.strip(), "open('imu_data.png', 'w').write('no picture' * 99)"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen("removed", _saved(_SAVE.strip(), "import os", "os.remove('imu_data.png')"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen("never-leaves-the-memory", _saved("import io", "fig.savefig(io.BytesIO(), format='png')", "plt.close(fig)"), (SAVED, "titles"), 3.0, _LOST),
    Unforeseen(
        "noise-in-its-place",
        _saved(_SAVE.strip(), "import PIL.Image as I", "I.fromarray(np.random.randint(0, 255, (600, 900, 3), np.uint8)).save('imu_data.png')"),
        (SAVED, "titles"), 3.0, _LOST,
    ),
    Unforeseen("a-pdf-alone", _saved("fig.savefig('imu_data.pdf')", "plt.close(fig)"), (SAVED,), 1.0),
    Unforeseen("an-svg-alone", _saved("fig.savefig('imu_data.svg')", "plt.close(fig)"), (SAVED,), 1.0),
]  # fmt: skip

# --- the comparison ---------------------------------------------------------------------------------------------------------

_RAW, _SMOOTH = ('np.array(raw)[:, 2], alpha=0.5, label="raw z"', 'np.array(smooth)[:, 2], label="filtered z"')
_COMPARISONS = {
    "raw-over-the-filtered": _compare((_RAW, 'np.array(raw)[:, 2], label="raw z", linewidth=9, zorder=9')),
    "filtered-in-white": _compare((_SMOOTH, f'{_SMOOTH}, color="white", zorder=0')),
    "raw-see-through": _compare((_RAW, 'np.array(raw)[:, 2], alpha=0, label="raw z"')),
    "a-comparison-outside-the-limits": _compare(("    ax.legend()\n", "    ax.legend()\n    ax.set_ylim(100, 200)\n")),
    "a-comparison-under-a-sheet": _compare(("    ax.legend()\n", "    ax.legend()\n    ax.axhspan(-99, 99, color='w', zorder=9)\n")),
    "filtered-outside-the-limits": _compare((_SMOOTH, 'np.array(smooth)[:, 2] + 99, label="filtered z"'), ("    ax.legend()\n", "    ax.legend()\n    ax.set_ylim(-11, -9)\n")),
}  # fmt: skip

_READ = "        accel, _ = imu.read()\n"
_TRUE = 'data.sensor("torso_accelerometer").data.copy()'
_NO_COMPARISONS = {
    "the-filtered-one-of-another-axis": _compare((_SMOOTH, 'np.array(smooth)[:, 0], label="filtered z"')),
    "the-raw-one-a-hair-larger": _compare((_SMOOTH, 'np.array(raw)[:, 2] * 1.0001, label="filtered z"')),
    "the-raw-one-a-little-later": _compare((_SMOOTH, 'np.roll(np.array(raw)[:, 2], 5), label="filtered z"')),
    "the-mean-for-the-filtered": _compare((_SMOOTH, 'np.full(len(raw), np.mean(np.array(raw)[:, 2])), label="filtered z"')),
    "a-sine-for-the-filtered": _compare((_SMOOTH, 'np.sin(3 * np.array(t)) / 10 - 9.81, label="filtered z"')),
    "two-sines": _compare((_RAW, 'np.sin(3 * np.array(t)), label="raw z"'), (_SMOOTH, 'np.cos(5 * np.array(t)), label="filtered z"')),
}  # fmt: skip
_WITHOUT_NOISE = {
    "a-comparison-without-noise": _compare((_READ, f"        accel = {_TRUE}\n")),
    "a-comparison-with-noise-of-no-size": _compare(("    for _ in range(n):\n", "    imu.accel_noise_std = 0.0\n    for _ in range(n):\n")),
}  # fmt: skip

FAULTY = [
    *_HIDDEN,
    *_PARTLY, *_NOISY,
    *_FILES,
    *(
        Unforeseen(name, files, (COMPARISON,), 4.0, ("comparison-missing", "comparison-wrong-data", *NOT_SEEN))
        for name, files in _COMPARISONS.items()
    ),
    *(Unforeseen(name, files, (COMPARISON,), 4.0, ("comparison-missing", "comparison-wrong-data")) for name, files in _NO_COMPARISONS.items()),
    *(Unforeseen(name, files, (COMPARISON,), 2.0) for name, files in _WITHOUT_NOISE.items()),
]

# --- sound ones ---------------------------------------------------------------------------------------------------------------

_CANVAS = ("fig.canvas.draw()", "pixels = np.asarray(fig.canvas.buffer_rgba())")
_HEAD = "import matplotlib.pyplot as plt\nimport numpy as np\n\n\n"
_SENSORS = '(("acceleration", "m/s^2"), ("angular_velocity", "rad/s"))'

_ANIMATED = f'''\
def plot_imu_data(imu_data):
    from matplotlib.animation import FuncAnimation

    fig, axes = plt.subplots(2, 1, sharex=True)
    lines, t = [], imu_data["time"]
    for ax, (key, unit) in zip(axes, {_SENSORS}):
        lines += [(ax.plot([], [], label=name)[0], imu_data[key][:, k]) for k, name in enumerate("xyz")]
        low, high = imu_data[key].min(), imu_data[key].max()
        ax.set(title=key, ylabel=f"{{key}} [{{unit}}]", xlim=(0, t[-1]), ylim=(low, high))
        ax.legend()
    axes[1].set_xlabel("time [s]")

    def update(n):
        for line, y in lines:
            line.set_data(t[:n], y[:n])
        return [line for line, _ in lines]

    animation = FuncAnimation(fig, update, frames=range(1, len(t) + 1, 50), interval=20, repeat=False)
    plt.show()
    update(len(t))
    fig.savefig("imu_data.png")
    return animation
'''

_IN_PAUSES = f'''\
def plot_imu_data(imu_data):
    plt.ion()
    fig, axes = plt.subplots(2, 1, sharex=True)
    n = len(imu_data["time"])
    for stop in (n // 3, 2 * n // 3, n):
        for ax, (key, unit) in zip(axes, {_SENSORS}):
            ax.cla()
            ax.plot(imu_data["time"][:stop], imu_data[key][:stop], label=["x", "y", "z"])
            ax.set(title=key, ylabel=f"{{key}} [{{unit}}]")
            ax.legend()
        axes[1].set_xlabel("time [s]")
        plt.pause(0.01)
    plt.ioff()
    plt.savefig("imu_data.png")
'''

_WRAPPED = f'''\
def draw(*args, plotter=None, **options):
    return (plotter or plt.plot)(*args, **options)


def plot_imu_data(imu_data):
    plt.figure(figsize=(9, 7))
    for n, (key, unit) in enumerate({_SENSORS}, start=1):
        plt.subplot(2, 1, n)
        for k, name in enumerate("XYZ"):
            draw(imu_data["time"], imu_data[key][:, k], label=name)
        plt.title(key)
        plt.ylabel(f"{{key}} [{{unit}}]")
        plt.xlabel("time [s]")
        plt.legend()
    plt.savefig("imu_data.png")
'''


def _beside(projection: str, drawn: str) -> dict[str, str]:
    """Each panel has another one beside it, without words, which shows the same in another way."""
    return lab(plot=f'''\
def plot_imu_data(imu_data):
    fig = plt.figure(figsize=(12, 8))
    for n, (key, unit) in enumerate({_SENSORS}):
        ax = fig.add_subplot(2, 2, 1 + 2 * n)
        ax.plot(imu_data["time"], imu_data[key], label=["x", "y", "z"])
        ax.set(title=key, ylabel=f"{{key}} [{{unit}}]", xlabel="time [s]")
        ax.legend()
        fig.add_subplot(2, 2, 2 + 2 * n, projection="{projection}").plot({drawn})
    fig.savefig("imu_data.png")
''')


_SOUND = {
    "saved-by-pillow": _saved(*_CANVAS, "from PIL import Image", "Image.fromarray(pixels).convert('RGB').save('imu_data.png')", "plt.close(fig)"),
    "saved-by-imsave": _saved(*_CANVAS, "plt.imsave('imu_data.png', pixels)", "plt.close(fig)"),
    "saved-by-pillow-from-a-buffer": _saved(
        "import io", "from PIL import Image", "buffer = io.BytesIO()", "fig.savefig(buffer, dpi=110)",
        "Image.open(buffer).convert('RGB').resize((900, 540)).save('imu_data.png')", "plt.close(fig)",
    ),
    "saved-to-an-open-file": _saved("with open('imu_data.png', 'wb') as file:", "    fig.savefig(file, dpi=110)", "plt.close(fig)"),
    "saved-under-another-name-and-moved": _saved("import os", "fig.savefig('new.png', dpi=110)", "os.replace('new.png', 'imu_data.png')"),
    "saved-as-it-grows": _plot(
        ("sharex=True)\n", "sharex=True, squeeze=True)\n"), (_SAVE, "    top.set_visible(True)\n" + _SAVE),
        ('    top.set_title("Torso accelerometer")\n', '    top.set_title("Torso accelerometer")\n    fig.savefig("imu_data.png")\n'),
    ),
    "a-pdf-beside-it": _saved("fig.savefig('imu_data.pdf')", _SAVE.strip(), "plt.close(fig)"),
    "limits-for-the-own-recording": _late("top.set_ylim(-14, 4)", "bottom.set_ylim(-1.5, 1.5)", "bottom.set_xlim(0, 5)"),
    "the-first-tenth-left-out": _late("bottom.set_xlim(t[0] + 0.1 * np.ptp(t), t[-1])"),
    "shaded-moments": _late("top.axvspan(t[50], t[200], color='C1', alpha=0.2)", "bottom.axvspan(t[50], t[200], color='0.9')"),
    "a-band-around-each-curve": _on_each("for line in list(ax.lines):", "    x, y = line.get_data()", "    ax.fill_between(x, y - 0.3, y + 0.3, color=line.get_color(), alpha=0.2)"),
    "thick-lines": _stroked("linewidth=4"),
    "hair-lines": _stroked("linewidth=0.3"),
    "dotted-lines": _stroked('linestyle=":"'),
    "loosely-dotted-lines": _stroked('linestyle=(0, (1, 5))'),
    "faint-lines": _stroked("alpha=0.3"),
    "pixels-for-points": _stroked('linestyle="none", marker=","'),
    "hollow-markers": _stroked('linestyle="none", marker="o", markersize=4, markerfacecolor="none"'),
    "markers-now-and-then": _stroked('marker="s", markevery=40'),
    "yellow-and-its-neighbours": _stroked('color=("yellow", "gold", "khaki")[k]'),
    "grey-tones": _stroked('color=("0.2", "0.5", "0.75")[k]'),
    "outlined-in-white": _on_each("import matplotlib.patheffects as effects", "for line in ax.lines:", '    line.set_path_effects([effects.withStroke(linewidth=3, foreground="white")])'),
    "a-picture-without-paper": _saved("fig.savefig('imu_data.png', transparent=True)", "plt.close(fig)"),
    "a-dark-sheet": _saved("for ax in fig.axes:", "    ax.set_facecolor('#222222')", "fig.savefig('imu_data.png', facecolor='#111111')", "plt.close(fig)"),
    "a-coloured-ground": _on_each("ax.set_facecolor('#eaeaf2')", "ax.grid(color='white', linewidth=1.5)"),
    "time-runs-to-the-left": _late("bottom.invert_xaxis()", "top.invert_yaxis()"),
    "a-legend-beside-the-panel": _on_each("ax.legend(loc='center left', bbox_to_anchor=(1.01, 0.5))"),
    "a-close-grid": _on_each("ax.minorticks_on()", "ax.grid(True, which='both', linewidth=0.4)"),
    "a-watermark": _late("fig.text(0.5, 0.5, 'DRAFT', fontsize=90, color='0.5', alpha=0.2, rotation=30, ha='center')"),
    "a-time-symmetric-log": _late("bottom.set_yscale('symlog')"),
    "a-small-figure": _plot(("figsize=(10, 6)", "figsize=(4.5, 3.2)")),
    "a-poster": _plot(("figsize=(10, 6)", "figsize=(40, 25)")),
    "room-made-by-the-layout": _plot(("sharex=True)", "sharex=True, layout='constrained')"), (_LAYOUT, "")),
    "equal-axes": _late("bottom.set_aspect('auto')", "top.set_box_aspect(0.2)"),
    "saved-tight": _saved("fig.savefig('imu_data.png', bbox_inches='tight', dpi=100)", "plt.close(fig)"),
    "an-inset-of-the-start": _on_each("inset = ax.inset_axes([0.6, 0.1, 0.35, 0.35])", "for line in list(ax.lines):", "    inset.plot(*(row[:100] for row in line.get_data()))", "ax.indicate_inset_zoom(inset)"),
    "in-space-beside": _beside("3d", "*imu_data[key].T"),
    "round-a-pole-beside": _beside("polar", "np.arctan2(imu_data[key][:, 1], imu_data[key][:, 0]), np.linalg.norm(imu_data[key], axis=1)"),
    "an-animation-that-ends": lab(plot=_ANIMATED),
    "drawn-in-pauses": lab(plot=_IN_PAUSES),
    "through-a-wrapper": lab(plot=_WRAPPED),
    "by-another-file": lab(plot="import plots\n\n\ndef plot_imu_data(imu_data):\n    plots.make(imu_data)\n") | {"plots.py": _HEAD + PLOT_LOOP.replace("plot_imu_data", "make")},
    "drawn-twice": _on_each("for line in list(ax.lines):", "    ax.plot(*line.get_data(), color=line.get_color(), alpha=0.3, linewidth=5)"),
}  # fmt: skip

SOUND = [Unforeseen(name, files) for name, files in _SOUND.items()]
ALL = [*FAULTY, *SOUND]
