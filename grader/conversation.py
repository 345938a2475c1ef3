"""The conversation with the box about one submission: its workers, its files, and where each required name is defined."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any, TypeVar

import numpy as np

from . import standins
from .answers import Drawing, Fault, drawing_of
from .errors import Crashed, GraderError, Malformed, NoAnswer, TimedOut
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
_IMPORTS = re.compile(rb'^[ \t"]*(?:from|import)[ \t]+([\w.]+(?:[ \t]*,[ \t]*[\w.]+)*)', re.MULTILINE)
_FURTHER = 3  # programs that are run to see what they draw
_LONGEST_NOTE = 500
_SENT = (".py", ".ipynb", ".xml", ".csv", ".txt", ".json", ".yaml", ".yml", ".toml", ".ini", ".cfg", ".npy", ".npz")
_PICTURES = (".png", ".jpg", ".jpeg")
_SENT_BYTES = 24_000_000
_THERE = "; there are numpy, scipy, matplotlib, mujoco, Python's own modules and the files that were handed in"

T = TypeVar("T")


class Missing(Exception):  # noqa: N818 - it is a finding about the submission, not an error of ours
    """A required name is not there: the file is missing, does not import, or does not define it."""

    def __init__(self, name: str, mistake: str, message: str) -> None:
        super().__init__(message)
        self.name, self.mistake = name, mistake


@dataclass(frozen=True)
class Loaded:
    names: frozenset[str]
    faults: tuple[Fault, ...]
    drawing: Drawing


class _Session:
    """One worker with the submission's files in it."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        self.loaded: dict[str, Loaded] = {}
        self.has_seen_data = False


class Conversation:
    """Asks each question about a submission once, in a fresh worker where one died, and finds the names that are asked about.

    Parameters
    ----------
    box : the zygote that workers come from
    files : relative path -> content
    above : how many folders above the others some of them lie
    lab_model : XML text of the lab model
    call_cpu_s, submission_cpu_s : limits, from the rubric
    """

    def __init__(
        self,
        box: Box,
        files: Mapping[str, bytes],
        *,
        above: Mapping[str, int],
        lab_model: str,
        call_cpu_s: float,
        submission_cpu_s: float,
    ) -> None:
        self._box, self._above = box, above
        self.files = dict(files)
        self.lab_model = lab_model
        self._call_cpu_s, self._left_cpu_s = call_cpu_s, submission_cpu_s
        self._session: _Session | None = None
        self.deadly: dict[str, NoAnswer] = {}
        self._suspects: set[str] = set()
        self.broken: set[str] = set()
        self._answers: dict[Any, Any] = {}
        self._outline: Mapping[str, Sequence[str]] | None = None
        self.paths: frozenset[str] = frozenset(files)
        self.used: list[str] = []
        self.notes: list[str] = []

    def close(self) -> None:
        self.end_session()

    # --- the conversation --------------------------------------------------------------------------------------------

    def replace_broken(self, names: Sequence[str]) -> None:
        """From now on sound stand-ins take the place of these names: their own checks are over."""
        if not self.broken.issuperset(names):
            self.broken |= set(names)
            self.end_session()

    @contextmanager
    def without_standins(self) -> Iterator[dict[Any, Any]]:
        """The submission as it was handed in, in a process of its own: its answers, forgotten unless `remember` has them."""
        (broken, self.broken), (answers, self._answers) = (self.broken, set()), (self._answers, {})
        self.end_session()
        try:
            yield self._answers
        finally:
            self.broken, self._answers = broken, answers
            self.end_session()

    def remember(self, answers: Mapping[Any, Any]) -> None:
        """Put these in the place of answers to the same questions."""
        self._answers |= answers

    def end_session(self) -> None:
        if self._session is not None:
            self._session.worker.close()
            self._session = None

    def _fresh_session(self) -> _Session:
        if self._session is None or not self._session.worker.alive:
            self.end_session()
            self._session = _Session(self._box.worker())
            try:
                self._submit(self._session.worker)
            except NoAnswer:
                self.end_session()
                raise
        return self._session

    def _submit(self, worker: Worker) -> None:
        files, arrays = self._files_to_send()
        fields = {
            "files": files,
            "lab_model": self.lab_model,
            "seed": SEED,
            "withheld": sorted(self.deadly),
            "standins": {name: standins.source(name) for name in sorted(self.broken)},
        }
        self.paths = frozenset(worker.ask("submit", fields, arrays, cpu_s=self._call_cpu_s).fields["paths"])

    def _files_to_send(self) -> tuple[list[tuple[str, str, int]], dict[str, np.ndarray]]:
        rows: list[tuple[str, str, int]] = []
        arrays: dict[str, np.ndarray] = {}
        total = 0
        wanted = [p for p in self.files if PurePosixPath(p).suffix.lower() in _SENT and p not in self.deadly]
        for path in sorted(wanted, key=lambda p: (not p.endswith((".py", ".ipynb")), p)):
            content = self.files[path]
            total += len(content)
            if total > _SENT_BYTES:
                break
            key = f"f{len(rows)}"
            rows.append((path, key, self._above.get(path, 0)))
            arrays[key] = np.frombuffer(content, dtype=np.uint8)
        return rows, arrays

    def ask(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> Frame:
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

    def ask_aside(self, op: str, fields: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Frame:
        """Ask a worker that has never seen the submission: one that runs it could say anything."""
        with self._box.worker() as worker:
            return worker.ask(op, fields, arrays, cpu_s=self._call_cpu_s)

    def once(self, key: Any, ask: Callable[[], T]) -> T:
        """Ask a question once; remember the answer, or that there was none."""
        if key not in self._answers:
            try:
                self._answers[key] = self.retried(ask)
            except (NoAnswer, Missing) as nothing:
                self._answers[key] = nothing
        answer = self._answers[key]
        if isinstance(answer, Exception):
            raise answer.with_traceback(None)  # or it would grow with every time that it is raised
        return answer  # type: ignore[no-any-return]

    def answered(self, key: Any) -> Any:
        """An answer that has been given; None where there is none. Nothing is asked."""
        answer = self._answers.get(key)
        return None if isinstance(answer, Exception) else answer

    def drawings(self) -> list[Drawing]:
        """What the submission's files have drawn so far, imported or run."""
        answers = (a.drawing if isinstance(a, Loaded) else a for a in self._answers.values())
        return [answer for answer in answers if isinstance(answer, Drawing)]

    def retried(self, ask: Callable[[], T]) -> T:
        """Ask; and once more in a new process where the first one ended.

        A system that is short of memory ends processes, too, the box's among them, and another file in it may be to blame: who ends
        it by himself does so twice.
        """
        try:
            return ask()
        except (Crashed, Malformed, GraderError):
            self.end_session()
            return ask()

    # --- finding names -----------------------------------------------------------------------------------------------

    def load(self, path: str) -> Loaded:
        if path in self.deadly:
            raise self.deadly[path].with_traceback(None)
        session = self._fresh_session()
        if path not in session.loaded:
            try:
                frame = self.ask("load", {"path": path})
            except NoAnswer as nothing:
                if session.loaded or self._may_be_innocent(path, nothing):
                    return self._load_alone(path)
                self.deadly[path] = nothing
                raise
            faults = tuple(f for f in map(Fault.of, frame.fields["errors"]) if f is not None)
            if faults and session.has_seen_data:
                return self._load_alone(path)  # or it might tell data of an earlier question, which may be hidden
            session.loaded[path] = Loaded(frozenset(frame.fields["names"]), faults, drawing_of(frame))
            self._answers.setdefault(("load", path), session.loaded[path])
        return session.loaded[path]

    def _may_be_innocent(self, path: str, nothing: NoAnswer) -> bool:
        """Whether a file is to be loaded once more, see `retried`."""
        again = not isinstance(nothing, TimedOut) and path not in self._suspects
        self._suspects.add(path)
        return again

    def _load_alone(self, path: str) -> Loaded:
        """Load a file once more where no other file has been: one that was loaded before it may have spoilt the process."""
        self.end_session()
        return self.load(path)

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
        if (home in self.paths or home in self.deadly) and name in (loaded := self.load(home)).names:
            for fault in loaded.faults[:1]:
                self.note(
                    f"{home} stops with {fault.type}: {printable(fault.message, 200)}"
                    f"{f' ({fault.where})' if fault.where else ''}; what it defines before counts"
                )
            return home
        for path in self._elsewhere(name, home):
            if name in self.load(path).names:
                self.used += [path] if path not in self.used else []
                self.note(f"{name} was found in {printable(path, 80)}; the sheet expects it in {home}")
                return path
        raise self._missing(name, home)

    def _elsewhere(self, name: str, home: str) -> list[str]:
        if self._outline is None:
            try:
                self._outline = self.retried(lambda: self.ask("outline", {})).fields["names"]
            except NoAnswer:
                self._outline = {}
        defining = [path for path, names in self._outline.items() if path != home and name in names]
        named = [path for path in defining if _is_run(path)]
        return sorted(named, key=lambda p: (p.count("/"), p not in _SCRIPTS, p.endswith(".ipynb"), p))

    def further_scripts(self) -> list[str]:
        """Programs that nothing is asked of: they save a figure, or may call what does, as nobody imports them."""
        code = {path: content for path, content in self.files.items() if path.endswith((".py", ".ipynb"))}
        saving = {path for path, content in code.items() if b"savefig" in content}
        if not saving:
            return []
        imported = {name for content in code.values() for name in _imported(content)}
        known = {*HOMES.values(), *self.used}
        others = [path for path in self.paths - known if path.endswith(".py") and _is_run(path)]
        programs = [path for path in others if path in saving or PurePosixPath(path).stem not in imported]
        return sorted(programs, key=lambda p: (p not in saving, p))[:_FURTHER]

    def _missing(self, name: str, home: str) -> Missing:
        if home not in self.paths:
            return Missing(name, "file-missing", f"{home} was not handed in, and no other file defines {name}")
        faults = self.load(home).faults
        if faults:
            where = f" ({faults[0].where})" if faults[0].where else ""
            said = printable(faults[0].message, 200)
            if faults[0].type in ("ModuleNotFoundError", "ImportError"):
                said += _THERE
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

    def note(self, text: str) -> None:
        """Tell the instructor something, once."""
        shown = printable(text, _LONGEST_NOTE)
        if shown not in self.notes:
            self.notes.append(shown)


def _is_run(path: str) -> bool:
    """Whether a file may be run because of what is in it; some files are there for tools that look for their names."""
    return PurePosixPath(path).stem not in _NEVER_IMPORTED and not PurePosixPath(path).name.startswith("test_")


def _imported(content: bytes) -> set[str]:
    """Names that a file or a notebook imports modules by, as far as a glance at its lines tells."""
    return {word.decode() for modules in _IMPORTS.findall(content) for word in re.findall(rb"\w+", modules)}
