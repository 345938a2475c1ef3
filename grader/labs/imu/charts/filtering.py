"""Chart of the submission's filter: what it makes of a noisy signal, and how much of each frequency it lets through.

References
----------
Bendat, J. S., Piersol, A. G. (2010). Random Data: Analysis and Measurement Procedures, 4th ed., chapter 6.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grader.engine.chart_data import Chart, Panel
from grader.engine.traces import Scenario
from grader.labs.imu.answers import FilterRun
from grader.labs.imu.charts.points import curve
from grader.labs.imu.compare import Array

_SHOWN = 160
_SEGMENT = 192
_LEAST_GAIN = 1e-4


def chart(runs: Sequence[FilterRun] | None, truth: Scenario) -> Chart | None:
    """Return the chart of the first of `runs` (smallest alpha) beside the lab sheet's filter; None if any output is missing."""
    signal, alpha = truth["input"], float(truth["alpha"][0])
    output = runs[0].output if runs else None
    if output is None or output.shape != signal.shape or not np.isfinite(output).all():
        return None
    caption = (
        f"The z axis of a noisy signal, filtered by your LowPassFilter with alpha {alpha:g}, and the share of each frequency that "
        "it lets through. The sheet's filter is the wide grey line."
    )
    panels = (_in_time(signal, output, truth["low_passed"][0]), _in_frequency(signal, output, alpha))
    return Chart("filtering", "Your filter at work", caption, panels)


def _in_time(signal: Array, output: Array, wanted: Array) -> Panel:
    """Return the panel of a noisy signal over time, with the filter's output and the output of the sheet's filter (`wanted`)."""
    at = np.arange(min(_SHOWN, len(signal)), dtype=np.float64)
    curves = (
        curve("input", "raw", at, signal[:_SHOWN, 2]),
        curve("sheet", "wanted", at, wanted[:_SHOWN, 2]),
        curve("yours", "own", at, output[:_SHOWN, 2]),
    )
    return Panel("A noisy signal", "Sample", "m/s²", curves)


def _in_frequency(signal: Array, output: Array, alpha: float) -> Panel:
    """Return the panel of the gain over frequency, as measured and as the sheet's filter has it."""
    share, own = _gain(signal, output)
    sheet = np.abs(alpha / (1 - (1 - alpha) * np.exp(-2j * np.pi * share)))
    curves = curve("sheet", "wanted", share, sheet), curve("yours", "own", share, np.maximum(own, _LEAST_GAIN))
    return Panel("Gain", "Frequency (in units of the sample rate)", "Output / input", curves, log=True)


def _gain(signal: Array, output: Array) -> tuple[Array, Array]:
    """Return frequencies (in units of the sample rate) and the gain |H| there: averaged cross spectrum over that of the input.

    The spectra are those of differences, in which a slow motion is no larger than the noise and leaks into no other frequency: the
    sheet's filter comes out to 2 %.
    """
    before, after = _spectra(np.diff(signal, axis=0)), _spectra(np.diff(output, axis=0))
    cross, power = (after * before.conj()).sum(axis=(0, 1)), (np.abs(before) ** 2).sum(axis=(0, 1))
    return np.arange(1, _SEGMENT // 2 + 1) / _SEGMENT, np.abs(cross / power)[1:]


def _spectra(series: Array) -> np.ndarray:
    """Return the spectra (segments, axes, frequencies) of overlapping segments, windowed so that frequencies leak little."""
    parts = np.lib.stride_tricks.sliding_window_view(series, _SEGMENT, axis=0)[:: _SEGMENT // 4]
    centred = parts - parts.mean(axis=-1, keepdims=True)
    return np.asarray(np.fft.rfft(centred * np.hanning(_SEGMENT)))
