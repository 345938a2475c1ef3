"""The proxy that checks talk to: it asks the box, keeps the answers, and sees that one fault costs once.

A `Student` is one submission under examination. It finds where each required name is defined, asks each question once,
starts a fresh worker when one died, and puts sound stand-ins in the place of parts whose own checks are over and lost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import PurePosixPath
from typing import Any, TypeVar

import numpy as np

from . import standins
from .answers import (
    Array,
    Collection,
    Drawing,
    Fault,
    FilterRun,
    NoiseRun,
    Reading,
    Readings,
    as_collection,
    as_reading,
    shape_in_words,
    three,
)
from .errors import Crashed, Malformed, NoAnswer, TimedOut
from .replies import checked
from .sandbox.box import Box, Worker
from .sandbox.wire import Frame
from .text import printable

SEED = 0
"""Seed of the generators that student code draws from; no verdict rests on it."""

HOMES: Mapping[str, str] = {
    "get_imu_readings": "imu_reader.py",
    "simulate_and_collect": "imu_reader.py",
    "plot_imu_data": "imu_reader.py",
    "NoisyIMU": "noisy_imu.py",
    "LowPassFilter": "filters.py",
    "ComplementaryFilter": "complementary_filter.py",
    "allan_deviation": "allan_variance.py",
    "read_all_imus": "multi_imu.py",
    "live_plot": "live_plot.py",
}
_SCRIPTS = ("imu_reader.py", "noisy_imu.py", "filters.py")
_NEVER_IMPORTED = ("conftest", "sitecustomize", "usercustomize", "setup")
_SENT = (".py", ".ipynb", ".xml", ".csv", ".txt", ".json", ".yaml", ".yml", ".npy", ".npz")
_PICTURES = (".png", ".jpg", ".jpeg")
_SENT_BYTES = 24_000_000

T = TypeVar("T")


class Missing(Exception):  # noqa: N818 - it is a finding about the submission, not an error of ours
    """A required name is not there: the file is missing, does not import, or does not define it."""

    def __init__(self, name: str, mistake: str, message: str) -> None:
        super().__init__(message)
        self.name, self.mistake = name, mistake


@dataclass(frozen=True)
class FilterCase:
    """One filter over one signal; see `inside.questions.filter_cases` for the ways of handling."""

    signal: Array
    alpha: float | None = None
    initial: Array | None = None
    handling: str = "plain"


@dataclass(frozen=True)
class _Loaded:
    names: frozenset[str]
    faults: tuple[Fault, ...]
    drawing: Drawing


class _Session:
    """One worker with the submission's files in it."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        self.loaded: dict[str, _Loaded] = {}
        self.has_seen_data = False


class Student:
    """One submission under examination.

    Parameters
    ----------
    box : the zygote that workers come from
    files : relative path -> content
    lab_model : XML text of the lab model
    call_cpu_s, submission_cpu_s : limits, from the rubric
    """

    def __init__(
        self, box: Box, files: Mapping[str, bytes], *, lab_model: str, call_cpu_s: float, submission_cpu_s: float
    ) -> None:
        self._box = box
        self.files = dict(files)
        self._lab_model = lab_model
        self._call_cpu_s, self._left_cpu_s = call_cpu_s, submission_cpu_s
        self._session: _Session | None = None
        self._deadly: dict[str, NoAnswer] = {}
        self._suspects: set[str] = set()
        self._broken: set[str] = set()
        self._answers: dict[Any, Any] = {}
        self._outline: Mapping[str, Sequence[str]] | None = None
        self._paths: frozenset[str] = frozenset(files)
        self._used: list[str] = []
        self.notes: list[str] = []

    def close(self) -> None:
        self._end_session()

    # --- the conversation --------------------------------------------------------------------------------------------

    def replace_broken(self, names: Sequence[str]) -> None:
        """From now on sound stand-ins take the place of these names: their own checks are over."""
        if not self._broken.issuperset(names):
            self._broken |= set(names)
            self._end_session()

    def _end_session(self) -> None:
        if self._session is not None:
            self._session.worker.close()
            self._session = None

    def _fresh_session(self) -> _Session:
        if self._session is None or not self._session.worker.alive:
            self._end_session()
            self._session = _Session(self._box.worker())
            try:
                self._submit(self._session.worker)
            except NoAnswer:
                self._end_session()
                raise
        return self._session

    def _submit(self, worker: Worker) -> None:
        files, arrays = self._files_to_send()
        fields = {
            "files": files,
            "lab_model": self._lab_model,
            "seed": SEED,
            "withheld": sorted(self._deadly),
            "standins": {name: standins.source(name) for name in sorted(self._broken)},
        }
        self._paths = frozenset(worker.ask("submit", fields, arrays, cpu_s=self._call_cpu_s).fields["paths"])

    def _files_to_send(self) -> tuple[list[list[str]], dict[str, np.ndarray]]:
        rows: list[list[str]] = []
        arrays: dict[str, np.ndarray] = {}
        total = 0
        wanted = [p for p in self.files if PurePosixPath(p).suffix.lower() in _SENT and p not in self._deadly]
        for path in sorted(wanted, key=lambda p: (not p.endswith((".py", ".ipynb")), p)):
            content = self.files[path]
            total += len(content)
            if total > _SENT_BYTES:
                break
            key = f"f{len(rows)}"
            rows.append([path, key])
            arrays[key] = np.frombuffer(content, dtype=np.uint8)
        return rows, arrays

    def _ask(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> Frame:
        session = self._fresh_session()
        worker = session.worker
        if self._left_cpu_s <= 0:
            raise TimedOut("the submission used up its CPU time", cpu_s=0.0, wall_s=0.0)
        session.has_seen_data |= op not in ("load", "outline")
        before, cost = worker.cpu_s, 0.0
        try:
            frame = worker.ask(op, fields, arrays, cpu_s=min(self._call_cpu_s, self._left_cpu_s))
            return checked(op, frame, fields, arrays or {})
        except TimedOut as nothing:
            idle = nothing.cpu_s < self._call_cpu_s / 2
            cost = nothing.wall_s if idle else 0.0  # who sleeps uses no CPU, and still keeps others waiting
            raise
        except Malformed:
            worker.close()  # nothing more that comes from there can be relied on
            raise
        finally:
            self._left_cpu_s -= max(0.0, worker.cpu_s - before, cost)

    def _ask_aside(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        """Ask a worker that has never seen the submission: one that runs it could say anything."""
        with self._box.worker() as worker:
            return worker.ask(op, fields, arrays, cpu_s=self._call_cpu_s)

    def _once(self, key: Any, ask: Callable[[], T]) -> T:
        """Ask a question once; remember the answer, or that there was none."""
        if key not in self._answers:
            try:
                self._answers[key] = self._asked(ask)
            except (NoAnswer, Missing) as nothing:
                self._answers[key] = nothing
        answer = self._answers[key]
        if isinstance(answer, Exception):
            raise answer.with_traceback(None)  # or it would grow with every time that it is raised
        return answer  # type: ignore[no-any-return]

    def _asked(self, ask: Callable[[], T]) -> T:
        """Ask; and once more in a new process where the first one ended.

        A system that is short of memory ends processes, too, and another file in it may be to blame: who ends it by himself does so
        twice.
        """
        try:
            return ask()
        except (Crashed, Malformed):
            self._end_session()
            return ask()

    # --- finding names -----------------------------------------------------------------------------------------------

    def _load(self, path: str) -> _Loaded:
        if path in self._deadly:
            raise self._deadly[path].with_traceback(None)
        session = self._fresh_session()
        if path not in session.loaded:
            try:
                frame = self._ask("load", {"path": path})
            except NoAnswer as nothing:
                if session.loaded or self._may_be_innocent(path, nothing):
                    return self._load_alone(path)
                self._deadly[path] = nothing
                raise
            faults = tuple(f for f in map(Fault.of, frame.fields["errors"]) if f is not None)
            if faults and session.has_seen_data:
                return self._load_alone(path)  # or it might tell data of an earlier question, which may be hidden
            session.loaded[path] = _Loaded(frozenset(frame.fields["names"]), faults, _drawing(frame))
            self._answers.setdefault(("load", path), session.loaded[path])
        return session.loaded[path]

    def _may_be_innocent(self, path: str, nothing: NoAnswer) -> bool:
        """Whether a file is to be loaded once more, see `_asked`."""
        again = not isinstance(nothing, TimedOut) and path not in self._suspects
        self._suspects.add(path)
        return again

    def _load_alone(self, path: str) -> _Loaded:
        """Load a file once more where no other file has been: one that was loaded before it may have spoilt the process."""
        self._end_session()
        return self._load(path)

    def place_of(self, name: str) -> str:
        """The file that defines `name`, loaded in the present worker.

        Raises
        ------
        Missing
            Where no file defines it; the message says why.
        NoAnswer
            Where loading the file killed the worker or did not end.
        """
        home = HOMES[name]
        self._fresh_session()
        if (home in self._paths or home in self._deadly) and name in self._load(home).names:
            return home
        for path in self._elsewhere(name, home):
            if name in self._load(path).names:
                self._used += [path] if path not in self._used else []
                self._note(f"{name} was found in {printable(path, 80)}; the sheet expects it in {home}")
                return path
        raise self._missing(name, home)

    def _elsewhere(self, name: str, home: str) -> list[str]:
        if self._outline is None:
            try:
                self._outline = self._asked(lambda: self._ask("outline", {})).fields["names"]
            except NoAnswer:
                self._outline = {}
        defining = [path for path, names in self._outline.items() if path != home and name in names]
        named = [
            p
            for p in defining
            if PurePosixPath(p).stem not in _NEVER_IMPORTED and not PurePosixPath(p).name.startswith("test_")
        ]
        return sorted(named, key=lambda p: (p.count("/"), p not in _SCRIPTS, p.endswith(".ipynb"), p))

    def _missing(self, name: str, home: str) -> Missing:
        if home not in self._paths:
            return Missing(name, "file-missing", f"{home} was not handed in, and no other file defines {name}")
        faults = self._load(home).faults
        if faults:
            where = f" ({faults[0].where})" if faults[0].where else ""
            said = printable(faults[0].message, 200)
            return Missing(
                name,
                "does-not-import",
                f"{home} stopped with {faults[0].type}: {said}{where}, before it defined {name}",
            )
        return Missing(name, "name-missing", f"{home} does not define {name}")

    def has_line(self, fault: Fault) -> bool:
        """Whether a fault names a line that is there; code may claim any number, and have it stand for something."""
        content = self.files.get(fault.file or "")
        return content is not None and fault.line is not None and 0 < fault.line <= content.count(b"\n") + 1

    def load_fault(self, path: str) -> Fault | None:
        """What a file raised while it was imported, if it was."""
        loaded = self._answers.get(("load", path))
        return loaded.faults[0] if loaded is not None and loaded.faults else None

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def question(
        self, key: Any, name: str, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
    ) -> Frame:
        """The answer to one question about `name`, wherever it is defined; the same `key` is asked once."""
        return self._once((op, key), lambda: self._ask(op, {"path": self.place_of(name), **fields}, arrays))

    # --- the questions -----------------------------------------------------------------------------------------------

    def read(self, key: str, *, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        """Readings of every pair of sensors (p, 2) in every state (k, nq), (k, nv) of a model."""
        return self._once(("read", key), lambda: self._read(model, qpos, qvel, pairs))

    def _read(self, model: str, qpos: Array, qvel: Array, pairs: np.ndarray) -> Readings:
        path = self.place_of("get_imu_readings")
        frame = self._ask("read", {"path": path, "model": model}, {"qpos": qpos, "qvel": qvel, "pairs": pairs})
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
        return self._once(("simulate", key), lambda: self._simulate(duration_s, ids, timestep, dirty))

    def _simulate(
        self, duration_s: float, ids: tuple[int, int], timestep: float | None, dirty: tuple[Array, Array, float] | None
    ) -> Collection:
        path = self.place_of("simulate_and_collect")
        fields = {
            "path": path, "model": self._lab_model, "duration_s": duration_s, "timestep": timestep,
            "accel_id": ids[0], "gyro_id": ids[1], "time_s": dirty[2] if dirty else 0.0,
        }  # fmt: skip
        frame = self._ask("simulate", fields, {"qpos": dirty[0], "qvel": dirty[1]} if dirty else {})
        fault = Fault.of(frame.fields.get("error"))
        changed = tuple(frame.fields["changed"])
        if fault is not None:
            return Collection(None, None, None, changed=changed, fault=fault)
        found, keys, oddities = as_collection(frame.fields["value"], frame.arrays)
        return Collection(
            found.get("time"),
            found.get("acceleration"),
            found.get("angular_velocity"),
            keys,
            tuple(oddities),
            changed,
            first_step=_believable(frame.arrays),
        )

    def replay(self, first_step: Mapping[str, Array], steps: int, *, held: bool) -> Array | None:
        """All sensors (steps, n) of the lab model from a given state on, simulated in a worker of its own.

        With `held`, the first velocity is set to its first value before every step. None where that state cannot be
        simulated: it came out of a student's process, and may be anything.
        """
        key = ("replay", steps, held, *(value.tobytes() for value in first_step.values()))
        return self._once(key, lambda: self._replay(first_step, steps, held))

    def _replay(self, first_step: Mapping[str, Array], steps: int, held: bool) -> Array | None:
        fields = {"model": self._lab_model, "steps": steps, "held": held}
        try:
            frame = self._asked(lambda: self._ask_aside("replay", fields, first_step))
        except NoAnswer:
            return None
        rows = frame.arrays["sensordata"]
        return rows if np.isfinite(rows).all() else None

    def noise(self, key: str, *, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: tuple[float, float],
              biases: tuple[Array, Array] | None) -> NoiseRun:  # fmt: skip
        """Many reads of one `NoisyIMU` in one state after the other."""
        return self._once(("noise", key), lambda: self._noise(qpos, qvel, ids, reads, stds, biases))

    def _noise(
        self, qpos: Array, qvel: Array, ids: tuple[int, int], reads: int, stds: tuple[float, float],
        biases: tuple[Array, Array] | None,
    ) -> NoiseRun:  # fmt: skip
        fields = self._noise_fields(ids, reads, stds)
        given = {"accel_bias": biases[0], "gyro_bias": biases[1]} if biases else {}
        return _noise_run(self._ask("noise", fields, {"qpos": qpos, "qvel": qvel, **given}))

    def default_bias(self, *, qpos: Array, qvel: Array, ids: tuple[int, int], instances: int, reads: int) -> NoiseRun:
        """A few noise-free reads of many `NoisyIMU` that were given no bias: (instances, reads, 3)."""
        fields = self._noise_fields
        return self._once(
            "default_bias",
            lambda: _noise_run(
                self._ask(
                    "default_bias",
                    fields(ids, reads, (0.0, 0.0)) | {"instances": instances},
                    {"qpos": qpos, "qvel": qvel},
                )
            ),
        )

    def _noise_fields(self, ids: tuple[int, int], reads: int, stds: tuple[float, float]) -> dict[str, Any]:
        path = self.place_of("NoisyIMU")
        return {
            "path": path, "model": self._lab_model, "accel_id": ids[0], "gyro_id": ids[1], "reads": reads,
            "accel_noise_std": stds[0], "gyro_noise_std": stds[1],
        }  # fmt: skip

    def filter(self, key: str, cases: Sequence[FilterCase]) -> list[FilterRun]:
        """What `LowPassFilter` makes of each case."""
        return self._once(("filter", key), lambda: self._filter(cases))

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
        frame = self._ask("filter", {"path": path, "cases": rows}, arrays)
        return [_filter_run(answer, frame) for answer in frame.fields["cases"]]

    def plot(self, *, series: Mapping[str, Array], keys: Mapping[str, str]) -> Drawing:
        """What `plot_imu_data` draws and saves of the given series."""
        return self._once("plot", lambda: self._plot(series, keys))

    def _plot(self, series: Mapping[str, Array], keys: Mapping[str, str]) -> Drawing:
        path = self.place_of("plot_imu_data")
        return _drawing(self._ask("plot", {"path": path, "keys": dict(keys)}, series))

    def scripts(self) -> Iterator[Drawing]:
        """What the submission's files draw when they are run as scripts, one file after the other, the likeliest first.

        What they drew while they were imported comes first: it saves the time of running them again.
        """
        for path in self._runnable():
            for ask in (self._drawn_at_import, self._drawn_as_script, self._drawn_untouched):
                drawing = self._once((ask.__name__, path), partial(ask, path))
                if drawing is not None:
                    yield drawing

    def _runnable(self) -> list[str]:
        others = sorted(p for p in self._paths if p.endswith(".ipynb") and p not in self._used)
        return [p for p in ("filters.py", "noisy_imu.py", "imu_reader.py", *self._used, *others) if p in self._paths]

    def _drawn_at_import(self, path: str) -> Drawing | None:
        try:
            return self._load(path).drawing
        except NoAnswer:
            return None

    def _drawn_as_script(self, path: str) -> Drawing | None:
        if path.endswith(".ipynb") or b"__main__" not in self.files.get(path, b"__main__"):
            return None
        self._end_session()
        try:
            return _drawing(self._asked(lambda: self._ask("run_script", {"path": path})))
        except NoAnswer:
            return None
        finally:
            self._end_session()

    def _drawn_untouched(self, path: str) -> Drawing | None:
        """The same without stand-ins: a script that fits its own broken part need not fit a sound one."""
        if not self._broken or path in self._deadly or path.endswith(".ipynb"):
            return None
        broken, self._broken = self._broken, set()
        self._end_session()
        try:
            return _drawing(self._asked(lambda: self._ask("run_script", {"path": path})))
        except NoAnswer:
            return None
        finally:
            self._broken = broken
            self._end_session()

    def picture(self, name: str) -> Mapping[str, Any] | None:
        """What can be seen of a handed-in picture; None where it was not handed in."""
        if name not in self.files:
            return None
        return self._once(("picture", name), lambda: self._decode(name))

    def _decode(self, name: str) -> Mapping[str, Any]:
        content = np.frombuffer(self.files[name], dtype=np.uint8)
        try:
            frame = self._asked(lambda: self._ask_aside("image", {}, {"bytes": content}))
            return checked("image", frame, {}, {}).fields
        except NoAnswer:
            return {"readable": False, "reason": "it could not be decoded"}


def _believable(arrays: Mapping[str, Array]) -> dict[str, Array]:
    """The state that a run is said to start from; nothing where it is none: a student's process may claim anything."""
    names = ("qpos", "qvel", "gravity", "timestep")
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
        odd=shape_in_words(odd, frame.arrays) if odd else None,
        fault=Fault.of(frame.fields.get("error")),
    )


def _filter_run(answer: Mapping[str, Any], frame: Frame) -> FilterRun:
    odd = answer["odd"]
    return FilterRun(
        output=frame.arrays[answer["output"]] if answer["output"] else None,
        odd=shape_in_words(odd, frame.arrays) if odd else None,
        fault=Fault.of(answer["error"]),
        input_changed=bool(answer["input_changed"]),
    )


def _drawing(frame: Frame) -> Drawing:
    return Drawing(
        tuple(frame.fields["figures"]),
        frame.arrays,
        tuple(frame.fields["pictures"]),
        Fault.of(frame.fields.get("error")),
    )


__all__ = ["HOMES", "FilterCase", "Missing", "Reading", "Student"]
