"""Meaning of labels, legends and titles: which unit, sensor or axis a text names, in the languages of `languages.yaml`.

Symbols such as m/s² are the same in every language and are listed here; words are in that file, a block for each language.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import yaml

_once = lru_cache(maxsize=1024)  # a text is asked for with every pair of curves that bear it
_LOOKALIKES = str.maketrans("º⁄", "°/")
"""Look-alikes of the degree sign and of the stroke, which normalisation would make a letter or leave."""

_KINDS = {
    "acceleration", "angular_velocity", "hints", "axes", "raw", "filtered", "metre", "radian", "degree", "second", "per", "squared",
    "seconds", "milliseconds", "samples", "labels",
}  # fmt: skip


@cache
def languages() -> Mapping[str, Mapping[str, Any]]:
    """Return the words that labels may use for sensors, axes and units, by language code, from `languages.yaml`.

    AssertionError if a language in that file lacks a key or has an unknown one.
    """
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    text = (Path(__file__).parents[1] / "languages.yaml").read_text(encoding="utf-8")
    blocks: Mapping[str, Mapping[str, Any]] = yaml.load(text, Loader=loader)
    for code, block in blocks.items():
        assert block.keys() == _KINDS, (
            f"languages.yaml: {code} lacks, or has for itself, {', '.join(_KINDS ^ block.keys())}"
        )
    return blocks


def _any_of(stems: Iterable[str]) -> str:
    """Return the source of a regular expression that matches any of these words; nothing if there are none."""
    listed = sorted({re.escape(unicodedata.normalize("NFKC", stem).lower()) for stem in stems})
    return f"(?:{'|'.join(listed)})" if listed else r"(?!)"


def _words(key: str) -> str:
    return _any_of(stem for block in languages().values() for stem in block[key])


def _hints(key: str) -> str:
    return _any_of(stem for block in languages().values() for stem in block["hints"][key])


@_once
def plain(text: str) -> str:
    """Return a label as the patterns here expect it: lower case, no spaces or TeX, superscripts as digits, "per" as a slash."""
    text = unicodedata.normalize("NFKC", text.translate(_LOOKALIKES)).lower()
    text = re.sub(r"\b(?:in|en|em|per|pro|por|par)\s+|_(?=m?s(?:ec)?$)", "/", text)  # “in s”, “rad per s”, “time_s”
    text = re.sub(r"\\(?:mathrm|mathit|text|textrm|rm)\{([^{}]*)\}", r"\1", text)
    text = re.sub(r"\\[dt]?frac\{([^{}]*)\}\{([^{}]*(?:\{[^{}]*\})?)\}", r"\1/\2", text)
    text = re.sub(r"\\(mathrm|mathit|text|rm|left|right|,|;|!|frac|dfrac|dot|ddot|cdot|unit|si)", " ", text)
    text = text.replace("\\omega", "ω").replace("\\circ", "°").replace("\\degree", "°").replace("−", "-")
    return re.sub(r"[\s${}^\\·*_⋅×~]", "", text)


_SOME = r"\w{0,24}?"  # a bound on words within a unit: without, a title of repeated units takes the cube of its length
_PER = f"(?:/|{_words('per')})"
_SQUARED = f"(?:2|²|{_words('squared')})"
_ACCELERATION_UNIT = re.compile(
    r"m/\(?s(?:ec|ek)?\)?2|m/s/s|m\.?s-2|mps2|m/sec/sec|ms2\b|ms2[\])]|[\[(/,]m?g0?[\])]?$|[\[(]m?g|м/с2"
    rf"|{_words('metre')}{_SOME}{_PER}?(?:{_words('second')}|s[eé][ckg]){_SOME}{_SQUARED}|米/秒"
)
_RATE_UNIT = re.compile(
    r"(?![a-z°]{1,24}/\(?s(ec|ek)?(2(?!\w)|/s))"  # not per second squared
    rf"(?:{_words('radian')}{_SOME}(?:{_PER}|\.?s-1|ps)|{_words('degree')}{_SOME}(?:{_PER}|\.?s-1)"
    r"|°/?s(?:-1)?|°/с(?!2)|(?<!ra)dps|1/s|s-1|弧度)"
)
_DEGREES = re.compile(rf"{_words('degree')}(?!{_SOME}{_words('radian')}){_SOME}(?:{_PER}|\.?s-1)|°|(?<!ra)dps")
_SECONDS = f"(?:{_words('seconds')}|{_words('milliseconds')})"
_TIME_UNIT = re.compile(
    rf"(?:^|[\[(/,|:—–-])\(?{_SECONDS}\.?[\])]?$|[\[(]{_SECONDS}[\])]|[\[(]s(?:since|from)|ms\b|millis|{_words('second')}"
)
_MILLISECONDS = re.compile(rf"[\[(/,|—–-]{_words('milliseconds')}[\])]?$|[\[(]{_words('milliseconds')}[\])]|millis")
_COUNTED = re.compile(rf"{_words('samples')}|n$")


@_once
def unit_of(text: str) -> str | None:
    """Return the unit of `curves.UNITS` that a label names, to compare with the drawn numbers; None if it names no such unit."""
    words = plain(text)
    if _RATE_UNIT.search(words):
        if _DEGREES.search(words.replace("弧度", "rad")):
            return "deg/s"
        return "mrad/s" if "mrad" in words else "rad/s"
    if _ACCELERATION_UNIT.search(words):
        if re.search(rf"s2|s-2|/s(?:ec)?/s|{_SQUARED}|米", words):
            return "cm/s²" if "cm/" in words else "m/s²"
        return "mg" if re.search(r"[\[(/,]mg", words) else "g"
    return None


def has_unit_of(sensor: int, text: str) -> bool:
    """Return whether a label names any unit of this sensor (0 acceleration, 1 angular velocity), perhaps among other units."""
    return bool((_ACCELERATION_UNIT, _RATE_UNIT)[sensor].search(plain(text)))


def has_time_unit(text: str) -> bool:
    return bool(_TIME_UNIT.search(plain(text)))


def in_milliseconds(text: str) -> bool:
    return bool(_MILLISECONDS.search(plain(text)))


def counts_samples(text: str) -> bool:
    return bool(_COUNTED.search(plain(text)))


_NAMES = (_words("acceleration"), _words("angular_velocity"))
"""Names of acceleration and angular velocity, and of their sensors."""
_ACCELERATION_WORDS = re.compile(f"{_NAMES[0]}|{_hints('acceleration')}")
_RATE_WORDS = re.compile(f"{_NAMES[1]}|{_hints('angular_velocity')}")


@_once
def claims(text: str) -> frozenset[int]:
    """Return which sensors (0 acceleration, 1 angular velocity) a title or label names by words, else by a unit; perhaps none."""
    words = plain(text)
    found = {0} if _ACCELERATION_WORDS.search(words) else set()
    if _RATE_WORDS.search(words):
        found.add(1)
    unit = unit_of(text)
    if unit is not None and not found:
        found.add(1 if has_unit_of(1, text) else 0)
    return frozenset(found)


def names_only(sensor: int, text: str) -> bool:
    """Return whether a text names a sensor (0 accelerometer, 1 gyroscope) or its quantity in words, and not the other's."""
    return bool(re.search(_NAMES[sensor], plain(text))) and claims(text) == {sensor}


_AXES = tuple(
    re.compile(_any_of(stem for block in languages().values() for stem in block["axes"][axis])) for axis in range(3)
)
_AXIS_LETTERS = ("x", "y", "z")


@_once
def axis_of(text: str) -> int | None:
    """Return the axis (0, 1, 2) that a curve's name means, also by words such as "yaw"; None if it means none or several."""
    words = plain(text)
    named = {axis for axis, pattern in enumerate(_AXES) if pattern.search(words)}
    spaced = re.sub(r"[^a-z0-9]+", " ", unicodedata.normalize("NFKC", text).lower())
    for axis, letter in enumerate(_AXIS_LETTERS):
        if re.search(rf"(^|\s)(a|g|w|f|acc|accel|gyro|gyr|omega|lin|ang|rate|achse)?\s?{letter}(\s|$)", spaced):
            named.add(axis)
    return named.pop() if len(named) == 1 else None


_RAW = re.compile(rf"(?<!de)(?<!de-){_words('raw')}")
_SMOOTH = re.compile(_words("filtered"))


def says_raw(name: str) -> bool:
    """Return whether a curve's name calls its data raw, noisy or the like: as they were measured."""
    return bool(_RAW.search(plain(name)))


def says_smooth(name: str) -> bool:
    """Return whether a curve's name calls its data filtered, smooth or the like, and not raw too."""
    return bool(_SMOOTH.search(plain(name))) and not says_raw(name)
