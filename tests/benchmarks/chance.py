"""How often chance takes a point from a sound noise model, and how surely a fault is caught: `python -m tests.benchmarks.chance`.

The checks themselves are run, over reads that are drawn here instead of in the sandbox: 20,000 sound models, of which none may lose
anything, and 2,000 of each fault. A rate of none in 20,000 bounds the true one by 1.5e-4 (95 %); that it is below 1e-9 follows from
the formulas in `grader.labs.imu.statistics`, whose normal tails the small rates rest on.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from grader.engine.findings import Charged, Skipped
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.answers import NoiseRun
from grader.labs.imu.noise_model import checks
from grader.labs.imu.student import Student

Array = NDArray[np.float64]
Draw = Callable[[np.random.Generator, tuple[int, ...]], Array]

CHECKS: Mapping[str, Callable[[Student, Traces], None]] = {
    "noise_size": checks.check_noise_size,
    "given_bias": checks.check_given_bias,
    "default_bias": checks.check_default_bias,
    "white_and_gaussian": checks.check_white_and_gaussian,
    "axes_and_sensors_independent": checks.check_axes_and_sensors_independent,
}


@dataclass(frozen=True)
class Law:
    """How a model's noise is drawn, in units of the standard deviation asked for; ``(reads, 6)`` values at a time."""

    draw: Draw
    caught_by: str = ""
    offset: float = 0.0


def _normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return rng.standard_normal(shape)


def _correlated(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    noise = rng.standard_normal(shape)
    noise[:, 1] = 0.2 * noise[:, 0] + np.sqrt(1 - 0.04) * noise[:, 1]
    return noise


def _remembering(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    noise = rng.standard_normal(shape)
    for row in range(1, len(noise)):
        noise[row] = 0.3 * noise[row - 1] + np.sqrt(1 - 0.09) * noise[row]
    return noise


LAWS: Mapping[str, Law] = {
    "sound: normal": Law(_normal),
    "standard deviation 10 % too large": Law(lambda r, s: 1.1 * _normal(r, s), "noise_size"),
    "standard deviation 10 % too small": Law(lambda r, s: 0.9 * _normal(r, s), "noise_size"),
    "bias off by a fifth of sigma": Law(_normal, "given_bias", offset=0.2),
    "correlation of 0.2 between two axes": Law(_correlated, "axes_and_sensors_independent"),
    "correlation of 0.3 with the read before": Law(_remembering, "white_and_gaussian"),
    "normal law clipped at two sigma": Law(lambda r, s: np.clip(_normal(r, s), -2, 2), "white_and_gaussian"),
    "normal law clipped at three sigma": Law(lambda r, s: np.clip(_normal(r, s), -3, 3), "white_and_gaussian"),
    "uniform law": Law(lambda r, s: r.uniform(-(3**0.5), 3**0.5, s), "white_and_gaussian"),
    "Laplace law": Law(lambda r, s: r.laplace(0, 0.5**0.5, s), "white_and_gaussian"),
    "two-point law": Law(lambda r, s: r.choice([-1.0, 1.0], s), "white_and_gaussian"),
    "exponential law": Law(lambda r, s: r.exponential(1.0, s) - 1.0, "white_and_gaussian"),
}


class Model:
    """Answers the checks' questions as a student's noise model with this law would."""

    def __init__(self, law: Law, truth: Traces, rng: np.random.Generator) -> None:
        self._law, self._rng = law, rng
        self._clean = (truth["noise"]["acceleration"], truth["noise"]["angular_velocity"])
        self._answers: dict[Any, Any] = {}

    def once(self, key: Any, ask: Callable[[], Any]) -> Any:
        if key not in self._answers:
            self._answers[key] = ask()
        return self._answers[key]

    def noise(self, *, reads: int, stds: tuple[float, float], biases: tuple[Array, Array], **_: Any) -> NoiseRun:
        states = len(self._clean[0])
        unit = np.concatenate([self._law.draw(self._rng, (reads, 6)) for _ in range(states)]).reshape(states, reads, 6)
        parts = [
            clean[:, None, :] + bias + std * (part + self._law.offset)
            for clean, bias, std, part in zip(self._clean, biases, stds, (unit[..., :3], unit[..., 3:]), strict=True)
        ]
        return NoiseRun(parts[0], parts[1], np.zeros((0, 4)), None, None)

    def noise_twins(self, *, reads: int, stds: list[tuple[float, float]], biases: Array, **_: Any) -> NoiseRun:
        """Reads that no seed repeats: what is told apart by chance is told by statistics."""
        runs = [
            self.noise(reads=reads, stds=std, biases=(accel, gyro))
            for std, (accel, gyro) in zip(stds, biases, strict=True)
        ]
        accel, gyro = (np.array([getattr(run, name)[0] for run in runs]) for name in ("accel", "gyro"))
        return NoiseRun(accel, gyro, np.zeros((0, 4)), None, None)

    def default_bias(self, *, instances: int, **_: Any) -> NoiseRun:
        parts = [
            clean[0] + np.repeat(self._rng.normal(0, size, (instances, 1, 3)), 3, axis=1)  # three reads of each
            for clean, size in zip(self._clean, (0.1, 0.01), strict=True)
        ]
        return NoiseRun(parts[0], parts[1], np.zeros((0, 4)), None, None)


def losses(law: Law, runs: int, seed: int = 1) -> dict[str, int]:
    """How many of `runs` models with this law lose each check."""
    truth = bundles.shipped()
    rng = np.random.default_rng(seed)
    lost = dict.fromkeys(CHECKS, 0)
    for _ in range(runs):
        model = cast(Student, Model(law, truth, rng))
        for name, check in CHECKS.items():
            try:
                check(model, truth)
            except (Charged, Skipped):
                lost[name] += 1
    return lost


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.chance", description=__doc__)
    parser.add_argument("--sound", type=int, default=20_000, metavar="RUNS")
    parser.add_argument("--faulty", type=int, default=2_000, metavar="RUNS")
    options = parser.parse_args()
    print("| law | runs | lost by chance, or caught by | of them |\n| --- | --- | --- | --- |")
    for name, law in LAWS.items():
        runs = options.faulty if law.caught_by else options.sound
        lost = losses(law, runs)
        found = lost[law.caught_by] if law.caught_by else max(lost.values())
        print(f"| {name} | {runs:,} | {law.caught_by or 'any check'} | {found:,} |", flush=True)


if __name__ == "__main__":
    main()
