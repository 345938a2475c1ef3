"""Pictures as people hand them in, drawn by chance: plots of the lab's recording in any dress, and pictures of other things.

An honest one is a plot of the recording in one of matplotlib's styles, in colours, greys or strokes, in one of a few layouts, with
what people add, saved at 60 to 300 dots an inch, and then perhaps photographed from a screen: a frame around it, a JPEG, fewer pixels.
Another one is drawn the same way from other series, or is no plot at all.
"""

from __future__ import annotations

import io
import itertools
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import mujoco
import numpy as np
from PIL import Image, ImageDraw

from reference.imu_reader import MODEL_PATH, simulate_and_collect

Recording = dict[str, Any]

STYLES = [style for style in plt.style.available if not style.startswith("_")] + ["default"] * 6
_COLOURS = [None, None, None, ("r", "g", "b"), ("tab:red", "tab:green", "tab:blue"), ("k", "0.4", "0.7"), ("C3", "C4", "C5"),
            ("orange", "purple", "teal"), ("crimson", "gold", "navy"), ("#e41a1c", "#377eb8", "#4daf4a"),
            ("0.1", "0.35", "0.55"), ("black", "black", "black"), ("c", "m", "y"), ("navy", "royalblue", "skyblue")]  # fmt: skip
_KEYS = ("acceleration", "angular_velocity")
DRESSES = ("plain", "greys", "classic", "dark in light", "light in dark", "any")


def recorded(seconds: float = 5.0, **changed: Any) -> Recording:
    """The sheet's recording, or one of another motion: after a push (6,), under another gravity (3,)."""
    model = mujoco.MjModel.from_xml_path(str(MODEL_PATH))
    data = mujoco.MjData(model)
    if not changed:
        return dict(simulate_and_collect(model, data, duration_seconds=seconds))
    model.opt.gravity[:] = changed.get("gravity", (0, 0, -9.81))
    mujoco.mj_resetData(model, data)
    data.qvel[:6] = changed.get("push", (0.5, 0, 0, 0, 0, 0))
    rows = []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        sensors = (data.sensor("torso_accelerometer").data, data.sensor("torso_gyroscope").data)
        rows.append([data.time, *itertools.chain(*sensors)])
    table = np.array(rows)
    return {"time": table[:, 0], "acceleration": table[:, 1:4], "angular_velocity": table[:, 4:]}


# --- honest --------------------------------------------------------------------------------------------------------------


def honest(seed: int) -> tuple[Any, dict[str, Any]]:
    """A picture of the sheet's recording, and how it was made."""
    rng = np.random.default_rng([1, seed])
    seconds = float(rng.choice([5.0, 5.0, 5.0, 5.0, 3.0, 10.0, 2.0]))
    picture, told = dressed(rng, recorded(seconds))
    return picture, told | {"seconds": seconds}


def dressed(rng: Any, recording: Recording) -> tuple[Any, dict[str, Any]]:
    """A recording drawn as somebody draws it, and saved as somebody saves it."""
    dress = str(rng.choice(DRESSES, p=[0.2, 0.15, 0.1, 0.1, 0.1, 0.35]))
    style = {"greys": "default", "plain": "default", "classic": "classic", "dark in light": "dark_background",
             "light in dark": "default"}.get(dress) or str(rng.choice(STYLES))  # fmt: skip
    colours = _COLOURS[rng.integers(len(_COLOURS))] if dress in ("any", "light in dark") else None
    if dress == "greys":
        colours = [("k", "0.4", "0.7"), ("0.1", "0.35", "0.55"), ("0.0", "0.3", "0.6"), ("black",) * 3][rng.integers(4)]
    told = {"dress": dress, "style": style, "colours": colours}
    with mpl.rc_context():
        plt.style.use(style)
        light = min(mpl.colors.to_rgb(mpl.rcParams["axes.facecolor"])) > 0.8
        if colours and not light:  # nobody draws black on black, or greys on grey
            told["colours"] = colours = None
        figure, layout = _figure(rng, recording, colours)
        picture = _saved(rng, figure)
    frame = {"dark in light": "light", "light in dark": "dark"}.get(dress) or str(
        rng.choice(["", "", "", "", "light", "dark", "grey"])
    )
    if frame:
        picture = framed(rng, picture, frame)
    form = str(rng.choice(["png", "png", "png", "jpeg", "small"]))
    if form == "jpeg":
        picture = jpeg(picture, int(rng.integers(55, 95)))
    elif form == "small":
        share = float(rng.uniform(0.6, 1))
        longest = max(picture.size) * share
        if longest > 600:
            picture = picture.resize([max(1, round(n * share)) for n in picture.size], Image.Resampling.LANCZOS)
    return picture, told | {"layout": layout, "frame": frame, "form": form, "size": picture.size}


def _figure(rng: Any, recording: Recording, colours: Any) -> tuple[Any, str]:
    layout = str(rng.choice(["2x1", "2x1", "2x1", "2x1", "1x2", "3x2", "2x3", "6x1"]))
    rows, columns = int(layout[0]), int(layout[2])
    size = [(12, 8), (10, 8), (10, 6), (8, 6), (12, 6), (14, 10), (15, 5), (6.4, 4.8)][rng.integers(8)]
    if layout in ("3x2", "2x3", "6x1"):
        size = [(12, 8), (14, 10), (12, 10), (16, 9)][rng.integers(4)]
    elif layout == "1x2":
        size = [(12, 5), (14, 6), (12, 8), (16, 6)][rng.integers(4)]
    figure, panels = plt.subplots(rows, columns, figsize=size, sharex=bool(rng.integers(2)), squeeze=False)
    places = {"2x1": lambda s, k: panels[s, 0], "1x2": lambda s, k: panels[0, s], "3x2": lambda s, k: panels[k, s],
              "2x3": lambda s, k: panels[s, k], "6x1": lambda s, k: panels[3 * s + k, 0]}[layout]  # fmt: skip
    strokes = ["-"] * 3
    if colours and len(set(colours)) == 1 and rows * columns == 2:
        strokes = ["-", "--", ":"]
    elif rng.integers(6) == 0:
        strokes = [["--"] * 3, ["-", "--", "-."], ["-", "--", ":"], ["-."] * 3][rng.integers(4)]
    width = float(rng.choice([0.6, 0.8, 1.0, 1.5, 1.5, 2.0, 3.0]))
    alpha = float(rng.choice([1, 1, 1, 1, 0.8, 0.7]))
    markers = bool(rng.integers(10) == 0)
    cycled = bool(rng.integers(2))  # six panels: a colour for each axis, or the first colour for all of them
    for s, key in enumerate(_KEYS):
        for k, name in enumerate("XYZ"):
            options: dict[str, Any] = {"linewidth": width, "alpha": alpha, "linestyle": strokes[k]}
            if colours:
                options["color"] = colours[k]
            elif rows * columns == 6 and cycled:
                options["color"] = f"C{k}"
            if markers:
                options |= {"marker": ".", "markersize": 3}
            places(s, k).plot(recording["time"], recording[key][:, k], label=f"{'ag'[s]}_{name}", **options)
    limits = rng.integers(4)
    names = ("Accelerometer", "Gyroscope")
    for number, axes in enumerate(panels.ravel()):
        axes.set_title(names[number % 2] if rng.integers(2) else f"Panel {number}")
        axes.set_ylabel("m/s²")
        axes.set_xlabel("Time (s)")
        if rng.integers(4):
            axes.legend(loc=str(rng.choice(["best", "upper right", "lower right", "upper left"])))
    grid = rng.integers(4)
    for axes in panels.ravel():
        if grid:
            axes.grid(True, alpha=(1, 0.3, 0.6)[grid - 1])
        if limits == 0:
            axes.set_xlim(0, recording["time"][-1])
        elif limits == 1:
            axes.margins(y=0.2)
    if rng.integers(4) == 0:
        panels[0, 0].axhline(-9.81, color="k", linestyle="--", alpha=0.3)
    if rng.integers(5) == 0:
        figure.suptitle("IMU data of the torso")
    if rng.integers(3):
        figure.tight_layout()
    return figure, layout


def _saved(rng: Any, figure: Any) -> Any:
    dpi = int(rng.choice([60, 72, 80, 100, 100, 100, 120, 150, 200, 300]))
    if min(figure.get_size_inches()) * dpi * max(figure.get_size_inches()) * dpi > 12e6:
        dpi = 200
    stream = io.BytesIO()
    figure.savefig(stream, dpi=dpi, bbox_inches="tight" if rng.integers(4) == 0 else None)
    plt.close(figure)
    return Image.open(stream).convert("RGB")


def framed(rng: Any, picture: Any, frame: str) -> Any:
    """A window of a desktop around a picture: title bar, borders, a line of tools."""
    back, bar, word = {
        "light": ((255, 255, 255), (222, 225, 230), (60, 60, 60)),
        "grey": ((240, 240, 240), (200, 205, 210), (40, 40, 40)),
        "dark": ((32, 33, 36), (53, 54, 58), (220, 220, 220)),
    }[frame]
    width, height = picture.size
    edge, top = int(rng.integers(0, 80)), int(rng.integers(30, 120))
    window = Image.new("RGB", (width + 2 * edge, height + top + edge + 30), back)
    pen = ImageDraw.Draw(window)
    pen.rectangle((0, 0, window.width, 28), fill=bar)
    for number, colour in enumerate([(237, 106, 94), (245, 191, 79), (98, 197, 84)]):
        pen.ellipse((10 + 20 * number, 8, 22 + 20 * number, 20), fill=colour)
    pen.text((window.width // 2 - 20, 8), "Figure 1", fill=word)
    window.paste(picture, (edge, top))
    pen.text((10, window.height - 20), "x=1.234 y=-9.81", fill=word)
    return window


def jpeg(picture: Any, quality: int) -> Any:
    stream = io.BytesIO()
    picture.save(stream, "JPEG", quality=quality)
    return Image.open(stream).convert("RGB")


# --- others --------------------------------------------------------------------------------------------------------------


def other(seed: int) -> tuple[Any, dict[str, Any]]:
    """A picture that does not show the sheet's recording, and how it was made."""
    rng = np.random.default_rng([2, seed])
    kind = str(rng.choice(OTHERS))
    if kind in _SERIES:
        picture, told = dressed(rng, _SERIES[kind](rng))
    else:
        picture, told = _SHEETS[kind](rng), {}
    return picture, told | {"kind": kind}


def _times(rng: Any) -> Any:
    return np.linspace(0, float(rng.choice([2.0, 3.0, 5.0, 10.0])), int(rng.integers(300, 2500)))


def _of(t: Any, acceleration: Any, rate: Any) -> Recording:
    return {"time": t, "acceleration": acceleration, "angular_velocity": rate}


def _sines(rng: Any) -> Recording:
    t = _times(rng)
    first, second = (np.sin(np.outer(t, rng.uniform(1, 20, 3)) + rng.uniform(0, 6, 3)) for _ in (0, 1))
    return _of(t, first * [1, 0.3, 2] - [0, 0, 9.81], second)


def _decays(rng: Any) -> Recording:
    t = _times(rng)
    both = [
        np.exp(-np.outer(t, rng.uniform(0.5, 5, 3)))
        * np.cos(np.outer(t, rng.uniform(3, 40, 3)))
        * rng.uniform(0.2, 2, 3)
        for _ in (0, 1)
    ]
    return _of(t, both[0] - [0, 0, 9.81], both[1])


def _steps(rng: Any) -> Recording:
    t = _times(rng)
    both = [1 - np.exp(-np.outer(t, rng.uniform(1, 6, 3))) * np.cos(np.outer(t, rng.uniform(2, 30, 3))) for _ in (0, 1)]
    return _of(t, both[0] * [1, 2, 5], both[1])


def _joints(rng: Any) -> Recording:
    t = _times(rng)
    angles = np.cumsum(rng.normal(size=(len(t), 3)) * np.exp(-t)[:, None], axis=0)
    smooth = np.array([np.convolve(channel, np.ones(41) / 41, "same") for channel in angles.T]).T
    return _of(t, smooth, np.gradient(smooth, axis=0))


def _constant(rng: Any) -> Recording:
    t = _times(rng)
    noise = rng.normal(size=(2, len(t), 3)) * float(rng.choice([0.0, 0.0, 1e-3, 0.05]))
    return _of(t, noise[0] + [0, 0, -9.81], noise[1])


def _noise(rng: Any) -> Recording:
    t = _times(rng)
    return _of(t, rng.normal(size=(len(t), 3)) - [0, 0, 9.81], rng.normal(size=(len(t), 3)))


def _walks(rng: Any) -> Recording:
    t = _times(rng)
    return _of(t, *np.cumsum(rng.normal(size=(2, len(t), 3)), axis=1))


def _motion(rng: Any) -> Recording:
    push = np.zeros(6)
    push[rng.integers(6)] = float(rng.choice([-1.5, -0.8, 0.9, 1.5]))
    push[rng.integers(3)] += float(rng.choice([-0.7, 0.6]))
    return recorded(float(rng.choice([3.0, 5.0])), push=push)


def _backwards(rng: Any) -> Recording:
    return recorded(float(rng.choice([3.0, 5.0])), push=(-0.5, 0, 0, 0, 0, 0))


def _still(rng: Any) -> Recording:
    return recorded(3.0, push=np.zeros(6))


def _one_twice(rng: Any) -> Recording:
    told = recorded(float(rng.choice([3.0, 5.0])))
    key = _KEYS[rng.integers(2)]
    return told | dict.fromkeys(_KEYS, told[key])


def _turned(rng: Any) -> Recording:
    """Time runs the other way, or up is down: the values are there and the recording is not."""
    told = recorded(float(rng.choice([2.0, 3.0, 5.0])))
    back = slice(None, None, -1)
    return told | {key: told[key][back] if rng.integers(2) else -told[key] for key in _KEYS}


_SERIES = {
    "sines": _sines, "decays": _decays, "steps": _steps, "joints": _joints, "constant": _constant, "noise": _noise,
    "walks": _walks, "motion": _motion, "backwards": _backwards, "still": _still, "one twice": _one_twice, "turned": _turned,
}  # fmt: skip


def _paper(rng: Any) -> Any:
    shade = int(rng.integers(200, 256))
    page = Image.new("RGB", (int(rng.integers(500, 1400)), int(rng.integers(500, 1400))), (shade, shade, shade))
    pen = ImageDraw.Draw(page)
    for row in range(40, page.height - 40, 18):
        words = " ".join("x" * int(n) for n in rng.integers(1, 10, size=page.width // 50))
        pen.text((40, row), words, fill=tuple(int(n) for n in rng.integers(0, 120, 3)))
    return page


def _photo(rng: Any) -> Any:
    small = rng.integers(0, 256, (int(rng.integers(4, 30)), int(rng.integers(4, 30)), 3), np.uint8)
    photo = Image.fromarray(small).resize((960, 720), Image.Resampling.BICUBIC)
    return jpeg(photo, 80)


def _snow(rng: Any) -> Any:
    shape = (int(rng.integers(300, 900)), int(rng.integers(300, 900)), 3)
    sparse = rng.random(shape[:2]) < float(rng.choice([0.03, 0.1, 0.3, 1.0]))
    return Image.fromarray(np.where(sparse[..., None], rng.integers(0, 256, shape), 255).astype(np.uint8))


def _stripes(rng: Any) -> Any:
    page = np.full((700, 1000, 3), 255, np.uint8)
    every = int(rng.integers(4, 30))
    page[::every] = rng.integers(0, 200, 3)
    if rng.integers(2):
        page[:, ::every] = rng.integers(0, 200, 3)
    page[1::every] = rng.integers(0, 200, 3)
    return Image.fromarray(page)


def _bars(rng: Any) -> Any:
    figure, axes = plt.subplots(2, 1, figsize=(10, 7))
    axes[0].bar(np.arange(30), rng.random(30))
    axes[1].scatter(*rng.normal(size=(2, int(rng.integers(100, 4000)))), s=float(rng.uniform(2, 30)), c="C1")
    axes[0].hist(rng.normal(size=900), bins=40)
    return _saved(rng, figure)


def _empty(rng: Any) -> Any:
    figure, axes = plt.subplots(2, 1, figsize=(10, 7))
    for each in axes:
        each.grid(bool(rng.integers(2)))
        each.set(title="Acceleration", xlabel="Time (s)", xlim=(0, 5))
    return _saved(rng, figure)


def _white(rng: Any) -> Any:
    return Image.new("RGB", (900, 600), str(rng.choice(["white", "black", "grey", "#fafafa"])))


_SHEETS = {
    "paper": _paper, "photo": _photo, "snow": _snow, "stripes": _stripes, "bars": _bars, "empty": _empty, "white": _white,
}  # fmt: skip
OTHERS = (*_SERIES, *_SHEETS)
