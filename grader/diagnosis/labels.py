"""What labels, legends and titles say: units, sensors and axes, in many languages."""

from __future__ import annotations

import re
import unicodedata

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
    """The unit of `plots.UNITS` that a label names; None where it names none of them."""
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
        found.add(1 if has_unit_of(1, text) else 0)
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
