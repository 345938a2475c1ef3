"""Reading a figure from its facts: which curve shows which channel, and what labels, legends and titles claim.

Curves are tied to the data that the plot function was given, not to their labels; the labels are then held against the curves.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..answers import Array, Arrays, Collection, column_named

SENSORS = ("acceleration", "angular_velocity")
FEWEST_POINTS = 50
"""A curve that is thinned to fewer points hides the motion. The sheet's 1,500 samples may be thinned to 200; here there are 600."""
_MATCH = 1e-3
"""Of the channel's range. Thinned and single-precision data agree to 1e-6, a smoothed or shifted curve misses by 0.01 and more."""

Facts = Mapping[str, Any]


@dataclass(frozen=True)
class Shown:
    """A curve that shows a channel: sensor 0 or 1, axis 0 to 2, the scale of y and what x is."""

    sensor: int
    axis: int
    unit: str
    x: str
    curve: Facts


@dataclass(frozen=True)
class Panel:
    """One set of axes with what it shows: known channels and curves that show none."""

    facts: Facts
    shown: tuple[Shown, ...]
    strange: tuple[Facts, ...]

    @property
    def sensors(self) -> set[int]:
        return {s.sensor for s in self.shown}

    @property
    def mainly(self) -> set[int]:
        """The sensor that most of its curves show; both if they are as many."""
        counts = Counter(s.sensor for s in self.shown)
        return {sensor for sensor in counts if counts[sensor] == max(counts.values())}

    @property
    def area(self) -> float:
        left, low, right, high = self.facts["position"]
        return float((right - left) * (high - low))

    def is_inset_of(self, other: Panel) -> bool:
        """Whether it shows again, and much smaller, what another panel shows: that one has the names for both."""
        own, its = ({(s.sensor, s.axis) for s in panel.shown} for panel in (self, other))
        return bool(own) and own <= its and self.area < other.area / 2

    @property
    def words(self) -> str:
        """Everything that is written on the panel to say what it shows."""
        return " | ".join([self.facts["title"], self.facts["ylabel"]])


def joined(figures: Sequence[Facts]) -> Facts:
    """Several figures as the panels of one, each with what its own figure says of all its panels."""
    axes = [
        one
        | {key: one[key] or figure[key] for key in ("title", "xlabel", "ylabel")}
        | {"legend": [*(one["legend"] or ()), *(entry for legend in figure["legends"] for entry in legend)]}
        | {"position": [number + value for value in one["position"]]}  # no panel lies over one of another figure
        for number, figure in enumerate(figures)
        for one in figure["axes"]
    ]
    words = {"title": "", "xlabel": "", "ylabel": "", "legends": []}
    return {**figures[0], **words, "axes": axes, "texts": [text for figure in figures for text in figure["texts"]]}


def panels(figure: Facts, arrays: Arrays, series: Mapping[str, Array]) -> list[Panel]:
    """The visible axes that hold at least one curve of data."""
    found = []
    for axes in figure["axes"]:
        if axes["visible"]:
            panel = _panel(axes, arrays, series)
            if panel.shown or panel.strange:
                found.append(panel)
    return found


def _panel(axes: Facts, arrays: Arrays, series: Mapping[str, Array]) -> Panel:
    shown, strange = [], []
    for curve in axes["curves"]:
        if not curve["visible"] or curve["kind"] == "nothing":
            continue
        x, y = arrays[curve["x"]], arrays[curve["y"]]
        match = _channel(x, y, series)
        if match is not None:
            shown.append(Shown(*match, curve))
        elif not is_reference(x, y):
            strange.append(curve)
    return Panel(axes, tuple(shown), tuple(strange))


def is_reference(x: Array, y: Array) -> bool:
    """Whether a curve is a line at a fixed value or moment: `axhline`, `axvline` and their like."""
    return len(y) <= 3 or float(np.ptp(y)) == 0.0 or float(np.ptp(x)) == 0.0


def _channel(x: Array, y: Array, series: Mapping[str, Array]) -> tuple[int, int, str, str] | None:
    if len(y) < FEWEST_POINTS:
        return None
    time = series["time"]
    for kind, stamps in _abscissae(x, time):
        for sensor, key in enumerate(SENSORS):
            for axis in range(3):
                channel = series[key][:, axis]
                wanted = np.interp(stamps, time, channel)
                for unit, scale in _UNITS[sensor]:
                    if np.all(np.abs(y - scale * wanted) <= _MATCH * scale * np.ptp(channel)):
                        return sensor, axis, unit, kind
    return None


def _abscissae(x: Array, time: Array) -> list[tuple[str, Array]]:
    """What x may be, with the time stamps that follow: only readings under which x spans the recorded time."""
    rows = np.arange(len(time))
    kinds = [("s", x), ("ms", x / 1000), ("s from start", x + time[0])]
    kinds += [("index", np.interp(x, rows, time)), ("index", np.interp(x - 1, rows, time))]
    if len(x) < len(time):
        kinds.append(("index", np.interp(x * ((len(time) - 1) / max(1, len(x) - 1)), rows, time)))
    span = time[-1] - time[0]
    return [(kind, t) for kind, t in kinds if np.isfinite(t).all() and abs(np.ptp(t) / span - 1) < 0.1]


_UNITS = (
    (("m/s²", 1.0), ("cm/s²", 100.0), ("g", 1 / 9.81), ("g", 1 / 9.80665), ("mg", 1000 / 9.81), ("mg", 1000 / 9.80665)),
    (("rad/s", 1.0), ("mrad/s", 1000.0), ("deg/s", 180 / np.pi)),
)
UNITS = tuple(tuple(unit for unit, _ in scales) for scales in _UNITS)
"""The units of each sensor, that of the recorded numbers first."""


# --- what else was recorded ----------------------------------------------------------------------------------------------


def as_recorded(own: Collection, series: Mapping[str, Array]) -> dict[str, Array]:
    """What a submission records beside the three series, as it would have recorded it of the true ones.

    Multiples of a series, of a column and of a magnitude are made anew; numbers stay, and other rows are stretched to the length.
    """
    return {name: _as_recorded(name, value, own, series) for name, value in own.extras.items()}


def _as_recorded(name: str, value: Array, own: Collection, series: Mapping[str, Array]) -> Array:
    if value.ndim == 0:
        return value
    alike = [(true, recorded) for recorded, true in _derived(name, own, series) if recorded.shape == value.shape]
    for true, recorded in alike:
        scale = float(np.vdot(value, recorded) / max(np.vdot(recorded, recorded), 1e-300))
        if np.abs(value - scale * recorded).max() <= 1e-9 * max(1.0, float(np.abs(value).max())):
            return np.asarray(scale * true if recorded.any() else true)
    if own.time is None or len(value) != len(own.time):
        return value
    return np.asarray(value[np.linspace(0, len(value) - 1, len(series["time"])).round().astype(int)])


def _derived(name: str, own: Collection, series: Mapping[str, Array]) -> Iterator[tuple[Array, Array]]:
    """What may follow from the three series, as recorded and as true: that which the name speaks of first."""
    if own.time is not None:
        yield own.time, series["time"]
    said, axis = column_named(name), axis_of(name)
    for key in sorted(SENSORS, key=lambda key: key != said):
        recorded, true = getattr(own, key), series[key]
        if recorded is not None:
            for i in sorted(range(3), key=lambda i: i != axis):
                yield recorded[:, i], true[:, i]
            yield recorded, true
            yield np.linalg.norm(recorded, axis=1), np.linalg.norm(true, axis=1)


# --- words ---------------------------------------------------------------------------------------------------------------


_LOOKALIKES = str.maketrans("º⁄", "°/")
"""What is written for a degree and for a stroke, and would become a letter and stay what it is."""


def plain(text: str) -> str:
    """A label as a reader takes it: no TeX, superscripts as digits, lower case, no spaces."""
    text = unicodedata.normalize("NFKC", text.translate(_LOOKALIKES)).lower()
    text = re.sub(r"\b(?:in|en|em|per|pro|por|par)\s+|_(?=m?s(?:ec)?$)", "/", text)  # “in s”, “rad per s”, “time_s”
    text = re.sub(r"\\(?:mathrm|mathit|text|textrm|rm)\{([^{}]*)\}", r"\1", text)
    text = re.sub(r"\\[dt]?frac\{([^{}]*)\}\{([^{}]*(?:\{[^{}]*\})?)\}", r"\1/\2", text)
    text = re.sub(r"\\(mathrm|mathit|text|rm|left|right|,|;|!|frac|dfrac|dot|ddot|cdot|unit|si)", " ", text)
    text = text.replace("\\omega", "ω").replace("\\circ", "°").replace("\\degree", "°").replace("−", "-")
    return re.sub(r"[\s${}^\\·*_⋅×~]", "", text)


_ACCELERATION_UNIT = re.compile(
    r"m/\(?s(ec|ek)?\)?2|m/s/s|ms-2|mps2|m/sec/sec|ms2\b|ms2[\])]|(met(er|re)s?|meter|metros?|m[eè]tres?|метр\w*)[a-z]*(per|/|pro|por|par|al)?"
    r"s(ec|ek|eg)\w*(squared|2|²|quadrat|alcuadrado|carr[eé]e?|aoquadrado)|[\[(/,]m?g0?[\])]?$|[\[(]m?g|米/秒|м/с2"
)
_RATE_UNIT = re.compile(
    r"(?![a-z°]+/\(?s(ec|ek)?(2(?!\w)|/s))"  # not per second squared
    r"(rads?(ians?|iant\w*|i[aá]n\w*)?(/|s-1|ps|per|pro|por|par|·)|deg\w*(/|per|par|s-1)|°/s|°s-1|(?<!ra)dps|gra[du]\w*(/|per|pro|por)"
    r"|弧度|度/秒|(рад|°|град)/с(?!2)|1/s|s-1)"
)
_TIME_UNIT = re.compile(
    r"[\[(/,|]\(?(s|sec|secs|ms|us|min|sek|seg|sn|с|сек|мс|초)\.?[\])]?$|[\[(](s|sec|ms|sek|seg|秒|с|мс|초)[\])]|[\[(]s(since|from)"
    r"|second|sekund|segund|секунд|秒|:s$|ms\b|millis"
)
_MILLISECONDS = re.compile(r"[\[(/,|]ms[\])]?$|[\[(]ms[\])]|millis")
_COUNTED = re.compile(r"sample|index|step|abtast|muestra|échantillon|echantillon|frame|#|n$")


def unit_of(text: str) -> str | None:
    """The unit of `UNITS` that a label names; None where it names none of them."""
    words = plain(text)
    if _RATE_UNIT.search(words):
        if re.search(r"deg|°|(?<!ra)dps|gra[du]\w*(/|per|pro|por)|град|度/秒", words) and "弧度" not in words:
            return "deg/s"
        return "mrad/s" if "mrad" in words else "rad/s"
    if _ACCELERATION_UNIT.search(words):
        if re.search(r"s2|s-2|/s/s|squared|2|²|quadr|cuadr|carr|米", words):
            return "cm/s²" if "cm/" in words else "m/s²"
        return "mg" if re.search(r"[\[(/,]mg", words) else "g"
    return None


def has_unit_of(sensor: int, text: str) -> bool:
    """Whether a label names a unit of the sensor, whatever else it names."""
    return bool((_ACCELERATION_UNIT, _RATE_UNIT)[sensor].search(plain(text)))


def has_time_unit(text: str) -> bool:
    return bool(_TIME_UNIT.search(plain(text)))


def in_milliseconds(text: str) -> bool:
    return bool(_MILLISECONDS.search(plain(text)))


def counts_samples(text: str) -> bool:
    return bool(_COUNTED.search(plain(text)))


_NAMES = (
    r"accel|accél|acél|acel|beschl|加速|가속|specificforce|ускор|акселер|versnel|ivme|przysp",
    r"gyr|giro|angularv|angularr|omega|ω|winkelg|dreh|(vitesse|velocidade?)ang|角速|陀螺|ジャイロ|각속|자이로|угл|гиро|hoeksn",
)
"""What acceleration and angular velocity, and their sensors, are called."""
_ACCELERATION_WORDS = re.compile(_NAMES[0] + r"|acc|lineaire")
_RATE_WORDS = re.compile(_NAMES[1] + r"|angul|winkel|rate|spin|rotat")


def claims(text: str) -> set[int]:
    """Which sensor a text speaks of: 0 acceleration, 1 angular velocity; by its words, else by its unit."""
    words = plain(text)
    found = {0} if _ACCELERATION_WORDS.search(words) else set()
    if _RATE_WORDS.search(words):
        found.add(1)
    unit = unit_of(text)
    if unit is not None and not found:
        found.add(0 if unit in UNITS[0] else 1)
    return found


def names_only(sensor: int, text: str) -> bool:
    """Whether a text calls one sensor, or what it measures, by its name and says nothing of the other one."""
    return bool(re.search(_NAMES[sensor], plain(text))) and claims(text) == {sensor}


_AXIS_WORDS = (
    r"roll|rollen|wank|ロール|横滚",
    r"pitch|nick|tangage|cabeceo|ピッチ|俯仰",
    r"yaw|gier|lacet|guiñada|ヨー|偏航",
)
_AXIS_LETTERS = ("x", "y", "z")


def axis_of(text: str) -> int | None:
    """The axis (0, 1, 2) that a curve's name speaks of; None where it is not certain."""
    words = plain(text)
    named = {axis for axis, pattern in enumerate(_AXIS_WORDS) if re.search(pattern, words)}
    spaced = re.sub(r"[^a-z0-9]+", " ", unicodedata.normalize("NFKC", text).lower().replace("_", " "))
    for axis, letter in enumerate(_AXIS_LETTERS):
        if re.search(rf"(^|\s)(a|g|w|f|acc|accel|gyro|gyr|omega|lin|ang|rate|achse)?\s?{letter}(\s|$)", spaced):
            named.add(axis)
    return named.pop() if len(named) == 1 else None


# --- legends -------------------------------------------------------------------------------------------------------------


def names_of(panel: Panel, figure: Facts, arrays: Arrays) -> list[str | None]:
    """What the reader is told about each shown curve: its legend entry, or a text beside it."""
    entries = list(panel.facts["legend"] or ()) + [entry for legend in figure["legends"] for entry in legend]
    for other in figure["axes"]:
        if other is not panel.facts and other["legend"] and other["position"] == panel.facts["position"]:
            entries += other["legend"]  # twin axes share one legend
    texts = panel.facts["texts"]
    own = {s.curve["colour"] for s in panel.shown}
    neutral = [text for text in texts if text["colour"] not in own]
    room = _NEAR * float(np.ptp(panel.facts["y_limits"]))
    return [_name(s.curve, entries, texts) or _beside(s, neutral, arrays, room) for s in panel.shown]


def _beside(shown: Shown, texts: Sequence[Facts], arrays: Arrays, room: float) -> str | None:
    """A text in a colour of its own that names the curve's axis and stands near it.

    Where curves run close together nobody can tell which of them such a text stands nearest to, so none is called wrong by it.
    """
    x, y = _known(shown.curve, arrays)
    for text in texts:
        at, height = text["place"]
        within = x.min() - _NEAR * np.ptp(x) <= at <= x.max() + _NEAR * np.ptp(x)
        if within and y.min() - room <= height <= y.max() + room and axis_of(text["text"]) == shown.axis:
            return str(text["text"])
    return None


def _name(curve: Facts, entries: Sequence[Facts], texts: Sequence[Facts]) -> str | None:
    alike = [e for e in entries if e["colour"] == curve["colour"]]
    most = max((_likeness(e, curve) for e in alike), default=None)
    for entry in (e for e in alike if _likeness(e, curve) == most):
        if entry["text"].strip() and not entry["text"].startswith("_"):
            return str(entry["text"])
    beside = [t["text"] for t in texts if t["text"].strip() and t["colour"] == curve["colour"]]
    return str(beside[0]) if beside else None


def _likeness(entry: Facts, curve: Facts) -> tuple[bool, bool]:
    """How far a legend's sample looks like a curve of its colour: by style and marker, then by dashes, width and opacity."""
    style = (entry["style"], entry["marker"]) == (curve["style"], curve["marker"])
    return style, entry["stroke"] == curve["stroke"]


# --- raw and filtered ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Compared:
    """A curve and a smoother version of it, with the names that they carry."""

    raw: str
    smooth: str

    @property
    def exchanged(self) -> bool:
        return _says_smooth(self.raw) and _says_raw(self.smooth)

    @property
    def in_order(self) -> bool:
        return _says_raw(self.raw) or _says_smooth(self.smooth)


def comparisons(figure: Facts, arrays: Arrays) -> list[Compared]:
    """The raw series with smoother versions of them in a figure, on the same axes or on axes in the same unit."""
    drawn = [(axes, curve) for axes in figure["axes"] if axes["visible"] for curve in _long_curves(axes, arrays)]
    return [
        Compared(_name_on(above, raw), _name_on(below, smooth))
        for above, raw in drawn
        for below, smooth in drawn
        if raw is not smooth
        and (above is below or unit_of(above["ylabel"]) == unit_of(below["ylabel"]))
        and _is_smoothed(*_at_the_same_points(_known(raw, arrays), _known(smooth, arrays)))
    ]


def named_comparisons(figure: Facts, arrays: Arrays) -> list[Compared]:
    """Curves under the names of raw and filtered data in a figure, whatever the filter has made of them."""
    names = [
        _name_on(axes, curve) for axes in figure["axes"] if axes["visible"] for curve in _long_curves(axes, arrays)
    ]
    return [Compared(raw, smooth) for raw in names for smooth in names if _says_raw(raw) and _says_smooth(smooth)]


def series_drawn(figure: Facts, arrays: Arrays) -> list[Array]:
    """The values of every curve of data in a figure."""
    return [_known(c, arrays)[1] for axes in figure["axes"] if axes["visible"] for c in _long_curves(axes, arrays)]


def _name_on(axes: Facts, curve: Facts) -> str:
    return _name(curve, axes["legend"] or (), axes["texts"]) or ""


_NEAR = 0.2  # of a panel's width or height: what is farther from a curve is not beside it

_RAW_WORDS = re.compile(
    r"raw|(?<!de)(?<!de-)nois[ey]|unfilter|before|input|avant|antes|vordem|滤波前|measured|roh|ungefiltert|verrauscht|brut|crud|sinfiltrar|ruido|原始|噪|сыр"
)
_SMOOTH_WORDS = re.compile(r"filt|smooth|de-?nois|lowpass|low-pass|lpf|geglätt|liss|suaviz|滤|平滑|сглаж")


def _says_raw(name: str) -> bool:
    return bool(_RAW_WORDS.search(plain(name)))


def _says_smooth(name: str) -> bool:
    return bool(_SMOOTH_WORDS.search(plain(name))) and not _says_raw(name)


def _long_curves(axes: Facts, arrays: Arrays) -> list[Facts]:
    drawn = [c for c in axes["curves"] if c["visible"] and c["kind"] != "nothing"]
    long = [c for c in drawn if not is_reference(arrays[c["x"]], arrays[c["y"]])]
    return [c for c in long if len(_known(c, arrays)[1]) >= FEWEST_POINTS]


def _known(curve: Facts, arrays: Arrays) -> tuple[Array, Array]:
    """The points of a curve without those that are not drawn: while a filter warms up there is nothing to show."""
    x, y = arrays[curve["x"]], arrays[curve["y"]]
    known = np.isfinite(x) & np.isfinite(y)
    return x[known], y[known]


def _at_the_same_points(raw: tuple[Array, Array], smooth: tuple[Array, Array]) -> tuple[Array, Array, int]:
    """The values of both curves row by row, where both are drawn, and how many rows there are to a point of the shorter one."""
    if len(raw[0]) == len(smooth[0]):
        return raw[1], smooth[1], 1
    shorter, longer = sorted((raw[0], smooth[0]), key=len)
    x = longer[(longer >= shorter.min()) & (longer <= shorter.max())]
    return np.interp(x, *raw), np.interp(x, *smooth), len(longer) // len(shorter)


def _is_smoothed(raw: Array, smooth: Array, step: int) -> bool:
    """Whether one series is smoother than the other and goes where its running mean goes, at some lag.

    An exponential average follows a running mean with a correlation of 0.85 and more, whatever alpha; two different channels of a
    standing robot stay below 0.5. The second half is looked at: a filter may start from zero. Of a thinned curve every `step`-th
    value counts as drawn; the values between them lie on straight lines, and are no smoother for it.
    """
    if len(raw) < FEWEST_POINTS or np.std(np.diff(smooth[::step])) > 0.8 * np.std(np.diff(raw[::step])):
        return False
    return any(_follows(raw, smooth, window) for window in (3, 9, 27, 81) if 4 * window < len(raw))


def _follows(raw: Array, smooth: Array, window: int) -> bool:
    mean = np.convolve(raw, np.full(window, 1 / window), mode="valid")
    lags = range(0, min(2 * window, len(mean) // 4) + 1)
    return any(_alike(mean, smooth[window // 2 + lag :]) for lag in lags)


def _alike(wanted: Array, got: Array) -> bool:
    n = min(len(wanted), len(got))
    a, b = wanted[n // 2 : n] - wanted[n // 2 : n].mean(), got[n // 2 : n] - got[n // 2 : n].mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    near = abs(float(wanted[n // 2 : n].mean() - got[n // 2 : n].mean())) <= 3 * float(np.std(a)) + 1e-12
    as_large = 0.25 < float(np.std(b)) / max(float(np.std(a)), 1e-300) < 4
    return power > 0 and float(a @ b) / power > 0.75 and near and as_large
