"""Charts of the noise of the submission's `NoisyIMU`: its distribution, and its Allan deviation over averaging times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grader.engine.chart_data import Chart, Panel
from grader.engine.traces import Traces
from grader.labs.imu.answers import NoiseRun
from grader.labs.imu.charts.points import curve
from grader.labs.imu.compare import Array
from grader.labs.imu.statistics import allan_deviation

_BINS = 32
_TIMES = 12


@dataclass(frozen=True)
class _Sensor:
    """The noise (states, reads, 3) of one sensor: reads minus truth and given bias; `asked` is the requested standard deviation."""

    name: str
    unit: str
    noise: Array
    asked: float


def charts(run: NoiseRun | None, truth: Traces) -> list[Chart]:
    """Return the charts of a noise model's readings; [] without `run`, or if a reading was not two vectors of finite numbers."""
    if run is None or not (np.isfinite(run.accel).all() and np.isfinite(run.gyro).all()):
        return []
    scenario = truth["noise"]
    clean, rate = scenario["acceleration"][:, None], scenario["angular_velocity"][:, None]
    asked = float(scenario.scalars["accel_noise_std"]), float(scenario.scalars["gyro_noise_std"])
    sensors = (
        _Sensor("Accelerometer", "m/s²", run.accel - clean - scenario["accel_bias"], asked[0]),
        _Sensor("Gyroscope", "rad/s", run.gyro - rate - scenario["gyro_bias"], asked[1]),
    )
    return [_histogram(sensors), _allan(sensors, float(truth["push"].scalars["timestep"]))]


def _histogram(sensors: tuple[_Sensor, ...]) -> Chart:
    """Return the chart of how the noise is distributed, one panel a sensor, with the measured standard deviations in words."""
    found = " and ".join(
        f"{np.sqrt(np.mean((s.noise - s.noise.mean(axis=1, keepdims=True)) ** 2)):.3g} {s.unit} (asked for: {s.asked:g})"
        for s in sensors
    )
    return Chart(
        "noise_model",
        "Distribution of your noise",
        "Your readings less the true ones and the bias that was given, in units of the standard deviation that was asked for. "
        f"The line is the normal distribution. Found: {found}.",
        tuple(map(_distribution, sensors)),
    )


def _distribution(sensor: _Sensor) -> Panel:
    """Return the histogram of one sensor's noise in units of the requested standard deviation, with the normal density."""
    values = np.clip(sensor.noise.ravel() / sensor.asked, -1e6, 1e6)
    reach = max(4.0, float(np.ceil(np.quantile(np.abs(values), 0.999))))
    counts, edges = np.histogram(np.clip(values, -reach, reach), _BINS, (-reach, reach))
    centres, width = (edges[:-1] + edges[1:]) / 2, edges[1] - edges[0]
    grid = np.linspace(-reach, reach, 121)
    curves = (
        curve("yours", "bars", centres, counts / (len(values) * width)),
        curve("normal distribution", "model", grid, np.exp(-(grid**2) / 2) / np.sqrt(2 * np.pi)),
    )
    return Panel(sensor.name, f"Noise (in units of {sensor.asked:g} {sensor.unit})", "Density", curves)


def _allan(sensors: tuple[_Sensor, ...], dt: float) -> Chart:
    """Return the chart of the Allan deviation of the noise, one panel a sensor, which shows noise that depends on earlier noise."""
    return Chart(
        "noise_model",
        "Allan deviation of your noise",
        "White noise falls as a straight line of slope −1/2; the dashed line is the one of the size that was asked for. "
        "A curve that flattens or rises shows noise that depends on what came before. A constant bias does not show.",
        tuple(_deviation(sensor, dt) for sensor in sensors),
    )


def _deviation(sensor: _Sensor, dt: float) -> Panel:
    """Return the panel of one sensor's Allan deviation, with that of white noise of the requested size."""
    reads = sensor.noise.shape[1]
    sizes = np.unique(np.geomspace(1, max(reads // 10, 1), _TIMES).round().astype(int))
    in_turn = np.moveaxis(sensor.noise, 1, 0)
    found = np.nan_to_num([allan_deviation(in_turn, int(m)) for m in sizes])
    some = found > 1e-9 * sensor.asked
    curves = (
        curve("white noise as asked for", "model", sizes * dt, sensor.asked / np.sqrt(sizes)),
        curve("yours", "own", (sizes * dt)[some], found[some]),
    )
    return Panel(sensor.name, "Averaging time (s)", f"Allan deviation ({sensor.unit})", curves, log=True)
