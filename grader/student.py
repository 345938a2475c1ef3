"""The proxy that checks talk to: the questions about the lab's five parts, and what came back, as plain arrays.

A `Student` is one submission under examination. Each question is asked once; sound stand-ins take the place of parts whose
own checks are over and lost, so that one fault costs once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from .answers import (
    Array,
    Collection,
    Drawing,
    Fault,
    FilterRun,
    NoiseRun,
    Readings,
    as_collection,
    as_reading,
    drawing_of,
    shape_in_words,
    three,
)
from .conversation import Conversation, Missing
from .errors import NoAnswer
from .replies import checked
from .sandbox.wire import Frame


@dataclass(frozen=True)
class FilterCase:
    """One filter over one signal; see `inside.questions.filter_cases` for the ways of handling."""

    signal: Array
    alpha: float | None = None
    initial: Array | None = None
    handling: str = "plain"


class Student(Conversation):
    """One submission under examination."""

    def question(
        self, key: Any, name: str, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
    ) -> Frame:
        """The answer to one question about `name`, wherever it is defined; the same `key` is asked once."""
        return self.once((op, key), lambda: self.ask(op, {"path": self.place_of(name), **fields}, arrays))

    def read(self, key: str, *, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        """Readings of every pair of sensors (p, 2) in every state (k, nq), (k, nv) of a model."""
        return self.once(("read", key), lambda: self._read(model, qpos, qvel, pairs))

    def _read(self, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        path = self.place_of("get_imu_readings")
        frame = self.ask("read", {"path": path, "model": model}, {"qpos": qpos, "qvel": qvel, "pairs": pairs})
        calls = [as_reading(node, frame.arrays) for node in frame.fields["calls"]]
        later = [as_reading(node, frame.arrays) for node in frame.fields["later"]]
        shape = (len(pairs), len(qpos))
        oddities = tuple(dict.fromkeys(call.oddity for call in calls if call.oddity))
        return Readings(
            accel=_grid([call.accel for call in calls], shape),
            gyro=_grid([call.gyro for call in calls], shape),
            later_accel=_grid([call.accel for call in later], shape[:1]),
            later_gyro=_grid([call.gyro for call in later], shape[:1]),
            oddities=oddities,
            disturbance=frame.arrays["disturbance"],
            fault=Fault.of(frame.fields.get("error")),
        )

    def simulate(self, key: str, *, duration_s: float, ids: tuple[int, int], timestep: float | None = None,
                 dirty: tuple[Array, Array, float] | None = None) -> Collection:  # fmt: skip
        """What `simulate_and_collect` returns on the lab model, handed over in a dirty state if one is given."""
        return self.once(("simulate", key), lambda: self._simulate(duration_s, ids, timestep, dirty))

    def _simulate(
        self, duration_s: float, ids: tuple[int, int], timestep: float | None, dirty: tuple[Array, Array, float] | None
    ) -> Collection:
        path = self.place_of("simulate_and_collect")
        fields = {
            "path": path, "model": self.lab_model, "duration_s": duration_s, "timestep": timestep,
            "accel_id": ids[0], "gyro_id": ids[1], "time_s": dirty[2] if dirty else 0.0,
        }  # fmt: skip
        frame = self.ask("simulate", fields, {"qpos": dirty[0], "qvel": dirty[1]} if dirty else {})
        fault = Fault.of(frame.fields.get("error"))
        changed = tuple(frame.fields["changed"])
        if fault is not None:
            return Collection(None, None, None, changed=changed, fault=fault)
        collected = as_collection(frame.fields["value"], frame.arrays)
        return replace(collected, changed=changed, first_step=_believable(frame.arrays))

    def replay(self, first_step: Mapping[str, Array], steps: int, *, held: bool) -> Array | None:
        """All sensors (steps, n) of the lab model from a given state on, simulated in a worker of its own.

        With `held`, the first velocity is set to its first value before every step. None where that state cannot be
        simulated: it came out of a student's process, and may be anything.
        """
        key = ("replay", steps, held, *(value.tobytes() for value in first_step.values()))
        return self.once(key, lambda: self._replay(first_step, steps, held))

    def _replay(self, first_step: Mapping[str, Array], steps: int, held: bool) -> Array | None:
        fields = {"model": self.lab_model, "steps": steps, "held": held}
        try:
            frame = self.retried(lambda: self.ask_aside("replay", fields, first_step))
        except NoAnswer:
            return None
        rows = frame.arrays["sensordata"]
        return rows if np.isfinite(rows).all() else None

    def noise(self, key: str, *, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: tuple[float, float],
              biases: tuple[Array, Array] | None) -> NoiseRun:  # fmt: skip
        """Many reads of one `NoisyIMU` in one state after the other."""
        return self.once(("noise", key), lambda: self._noise(qpos, qvel, ids, reads, stds, biases))

    def _noise(
        self, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: tuple[float, float],
        biases: tuple[Array, Array] | None,
    ) -> NoiseRun:  # fmt: skip
        fields = self._noise_fields(ids, reads, stds)
        given = {"accel_bias": biases[0], "gyro_bias": biases[1]} if biases else {}
        return _noise_run(self.ask("noise", fields, {"qpos": qpos, "qvel": qvel, **given}))

    def default_bias(self, *, qpos: Array, qvel: Array, ids: tuple[int, int], instances: int, reads: int,
                     stds: tuple[float, float]) -> NoiseRun:  # fmt: skip
        """A few reads of many `NoisyIMU` that were given no bias: (instances, reads, 3)."""
        fields = self._noise_fields
        return self.once(
            ("default_bias", stds),
            lambda: _noise_run(
                self.ask(
                    "default_bias",
                    fields(ids, reads, stds) | {"instances": instances},
                    {"qpos": qpos, "qvel": qvel},
                )
            ),
        )

    def _noise_fields(self, ids: tuple[int, int], reads: int, stds: tuple[float, float]) -> dict[str, Any]:
        path = self.place_of("NoisyIMU")
        return {
            "path": path, "model": self.lab_model, "accel_id": ids[0], "gyro_id": ids[1], "reads": reads,
            "accel_noise_std": stds[0], "gyro_noise_std": stds[1],
        }  # fmt: skip

    def filter(self, key: str, cases: Sequence[FilterCase]) -> list[FilterRun]:
        """What `LowPassFilter` makes of each case."""
        return self.once(("filter", key), lambda: self._filter(cases))

    def _filter(self, cases: Sequence[FilterCase]) -> list[FilterRun]:
        path = self.place_of("LowPassFilter")
        arrays: dict[str, np.ndarray] = {}
        rows = []
        for number, case in enumerate(cases):
            arrays[f"s{number}"] = case.signal
            initial = None
            if case.initial is not None:
                initial = f"i{number}"
                arrays[initial] = case.initial
            rows.append({"input": f"s{number}", "alpha": case.alpha, "initial": initial, "handling": case.handling})
        frame = self.ask("filter", {"path": path, "cases": rows}, arrays)
        return [_filter_run(answer, frame) for answer in frame.fields["cases"]]

    def plot(self, *, data: Mapping[str, Array], ids: tuple[int, int]) -> Drawing:
        """What `plot_imu_data` draws and saves of the given data, by the submission's own keys.

        If it raises, it is given what the submission's own recorder returns, with the data in it: an object of the
        submission's own, or a dictionary with labels and settings beside the numbers.
        """
        return self.once("plot", lambda: self._plot(data, ids))

    def _plot(self, data: Mapping[str, Array], ids: tuple[int, int]) -> Drawing:
        keys = {name: f"d{number}" for number, name in enumerate(data)}
        fields = {"path": self.place_of("plot_imu_data"), "keys": keys, "recorder": None}
        arrays = {keys[name]: value for name, value in data.items()}
        drawing = drawing_of(self.ask("plot", fields, arrays))
        if drawing.fault is None:
            return drawing
        try:
            path = self.place_of("simulate_and_collect")
            recorder = {"path": path, "model": self.lab_model, "accel_id": ids[0], "gyro_id": ids[1]}
            again = drawing_of(self.ask("plot", fields | {"recorder": recorder}, arrays))
        except (Missing, NoAnswer):
            return drawing
        return drawing if again.fault else again

    def scripts(self) -> Iterator[Drawing]:
        """What the submission's files draw when they are run as scripts, one file after the other, the likeliest first.

        What they drew while they were imported comes first: it saves the time of running them again.
        """
        for path in self._runnable():
            for ask in (self._drawn_at_import, self._drawn_as_script, self._drawn_untouched):
                drawing = self.once((ask.__name__, path), partial(ask, path))
                if drawing is not None:
                    yield drawing
        for path in self.further_scripts():
            drawing = self.once(("script", path), partial(self._run_script, path))
            if drawing is not None:
                yield drawing

    def _runnable(self) -> list[str]:
        others = sorted(p for p in self.paths if p.endswith(".ipynb") and p not in self.used)
        return [p for p in ("filters.py", "noisy_imu.py", "imu_reader.py", *self.used, *others) if p in self.paths]

    def _drawn_at_import(self, path: str) -> Drawing | None:
        try:
            return self.load(path).drawing
        except NoAnswer:
            return None

    def _drawn_as_script(self, path: str) -> Drawing | None:
        if path.endswith(".ipynb") or b"__main__" not in self.files.get(path, b"__main__"):
            return None
        return self._run_script(path)

    def _run_script(self, path: str) -> Drawing | None:
        self.end_session()
        try:
            return drawing_of(self.retried(lambda: self.ask("run_script", {"path": path})))
        except NoAnswer:
            return None
        finally:
            self.end_session()

    def _drawn_untouched(self, path: str) -> Drawing | None:
        """The same without stand-ins: a script that fits its own broken part need not fit a sound one."""
        if not self.broken or path in self.deadly or path.endswith(".ipynb"):
            return None
        with self.without_standins():
            try:
                return drawing_of(self.retried(lambda: self.ask("run_script", {"path": path})))
            except NoAnswer:
                return None

    def picture(self, name: str) -> Mapping[str, Any] | None:
        """What can be seen of a handed-in picture; None where it was not handed in."""
        if name not in self.files:
            return None
        return self.once(("picture", name), lambda: self._decode(name))

    def _decode(self, name: str) -> Mapping[str, Any]:
        content = np.frombuffer(self.files[name], dtype=np.uint8)
        try:
            frame = self.retried(lambda: self.ask_aside("image", {}, {"bytes": content}))
            return {**checked("image", frame, {}, {}).fields, **frame.arrays}
        except NoAnswer:
            return {"readable": False, "reason": "it could not be decoded"}


def _believable(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """The state that a run is said to start from; nothing where it is none: a student's process may claim anything."""
    names = ("qpos", "qvel", "gravity", "timestep", "force")
    claim = {name: arrays[f"first_{name}"] for name in names if f"first_{name}" in arrays}
    sound = len(claim) == len(names) and all(np.isfinite(value).all() for value in claim.values())
    return claim if sound and 1e-6 <= claim["timestep"][0] <= 1.0 else {}


def _grid(vectors: Sequence[Array | None], shape: tuple[int, ...]) -> Array:
    out = np.full((int(np.prod(shape)), 3), np.nan)
    for row, vector in zip(out, vectors, strict=False):
        row[:] = three(vector)
    return out.reshape(*shape, 3)


def _noise_run(frame: Frame) -> NoiseRun:
    odd = frame.fields["odd"]
    return NoiseRun(
        accel=frame.arrays["accel"],
        gyro=frame.arrays["gyro"],
        disturbance=frame.arrays.get("disturbance", np.zeros((0, 4))),
        odd=as_reading(odd, frame.arrays).oddity if odd else None,
        fault=Fault.of(frame.fields.get("error")),
    )


def _filter_run(answer: Mapping[str, Any], frame: Frame) -> FilterRun:
    odd = answer["odd"]
    return FilterRun(
        output=frame.arrays[answer["output"]] if answer["output"] else None,
        odd=shape_in_words(odd, frame.arrays) if odd else None,
        fault=Fault.of(answer["error"]),
        input_changed=bool(answer["input_changed"]),
        output_changed=bool(answer["output_changed"]),
    )
