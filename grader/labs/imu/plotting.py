"""Ask the submission what it draws: the plot of given data, its files run as scripts, and the pictures that were handed in."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.figures import Picture, picture_of
from grader.engine.findings import Missing
from grader.engine.lab import Lab
from grader.engine.load_report import Loaded
from grader.engine.question import key_of
from grader.engine.submission_session import SubmissionSession, is_run
from grader.engine.traces import Traces
from grader.labs.imu.answers import Drawing, drawing_of
from grader.labs.imu.lab_copies import with_graded_robot
from grader.labs.imu.returned import Array
from grader.labs.imu.robot import robot_of
from grader.labs.imu.visualization import curves
from grader.sandbox.sandbox import Sandbox

_IMPORTS = re.compile(rb'^[ \t"]*(?:from|import)[ \t]+([\w.]+(?:[ \t]*,[ \t]*[\w.]+)*)', re.MULTILINE)
_METHODS = ("NoisyIMU.read", "LowPassFilter.update", "ComplementaryFilter.update")
_DATA_FILE = re.compile(
    rb"\.(?:np[yz]|csv|tsv|txt|dat|json|ya?ml|pkl|pickle|mat|h5|hdf5|parquet|feather|db|sqlite3?)[\"']"
)
_FURTHER = 3  # programs that are run to see what they draw


class Plotting(SubmissionSession):
    """Session with the sandbox that runs a submission's plotting code and returns what it draws, for the criterion *Visualization*.

    `truth` holds the MuJoCo model on which code is graded; scripts find it at the path from which the lab sheet loads its model.
    """

    def __init__(self, sandbox: Sandbox, lab: Lab, files: Mapping[str, bytes], *, truth: Traces, **limits: Any) -> None:
        robot = self.robot = robot_of(truth)
        lab_configuration: dict[str, Any] = {
            "model": robot.xml,
            "model_file": robot.file,
            "imu": robot.imu,
            "sheet_model": lab.model,
        }
        lab_configuration |= {"methods": _METHODS, "libraries": ("mujoco", "np", "numpy", "plt")}
        own = with_graded_robot(files, robot.xml, truth.models.get("students"))
        self.pictures = lab.pictures
        super().__init__(sandbox, lab, own, lab_configuration=lab_configuration, **limits)

    def drawings(self) -> list[Drawing]:
        """Return all that the submission has drawn so far (on import, as scripts, in `plot`), without running anything."""
        answers = (drawing_of(a.frame) if isinstance(a, Loaded) else a for a in self._answers.values())
        return [answer for answer in answers if isinstance(answer, Drawing)]

    def plot(
        self,
        *,
        data: Mapping[str, Array],
        sheet: Mapping[str, Array],
        ids: tuple[int, int],
        called: str = "",
        own_form: bool = False,
    ) -> Drawing:
        """Return what `plot_imu_data` draws and saves of a recording, in the first form of the recording that it accepts.

        The forms are, in order: `data`, a dict with the submission's own keys; what its `simulate_and_collect` returns, a dict or
        not, when the sensors `ids` measure this data; `sheet`, a dict with the lab sheet's keys. If recording or plotting
        raises, the next is tried. If all raise, the drawing of `data` counts, with its `error`.

        `own_form` says that the submission does not record in the sheet's form: if the drawing of `data` lacks a channel, the
        second form is then tried too, and counts if it lacks none. Charts find the drawing by the name `called`.
        """
        key = (key_of("plot", {"ids": ids, "own_form": own_form}, data), key_of("plot", {}, sheet))
        return self.once_named(called, key, lambda: self._plot(data, sheet, ids, own_form))

    def _plot(
        self, data: Mapping[str, Array], sheet: Mapping[str, Array], ids: tuple[int, int], own_form: bool
    ) -> Drawing:
        drawing = self._plotted(data)
        if drawing.error is None and not (own_form and curves.lacking(drawing.figures, sheet)):
            return drawing
        own = self._plotted_as_recorded(data, sheet, ids)
        if (
            own is not None
            and own.error is None
            and (drawing.error or not curves.lacking(own.figures, own.given or sheet))
        ):
            return own
        if drawing.error is None:
            return drawing
        as_on_sheet = drawing if data.keys() == sheet.keys() else self._plotted(sheet)
        return drawing if as_on_sheet.error else as_on_sheet

    def _plotted_as_recorded(
        self, data: Mapping[str, Array], sheet: Mapping[str, Array], ids: tuple[int, int]
    ) -> Drawing | None:
        """Draw the plot of what the submission's own `simulate_and_collect` returns; None if that cannot be run.

        If it stops in the submission's broken `get_imu_readings`, it runs again with the grader's version (stand-in) of that.
        """
        with self.without_standins():
            own = self._plotted_with_recorder(data, sheet, ids)
        return self._plotted_with_recorder(data, sheet, ids) if self.broken and (own is None or own.error) else own

    def _plotted_with_recorder(
        self, data: Mapping[str, Array], sheet: Mapping[str, Array], ids: tuple[int, int]
    ) -> Drawing | None:
        shown = {f"s{number}": value for number, value in enumerate(sheet.values())}
        try:
            path = self.place_of("simulate_and_collect")
            recorder = {"path": path, "model": self.robot.xml, "accel_id": ids[0], "gyro_id": ids[1]}
            return self._plotted(data, recorder | {"shows": list(shown)}, shown)
        except (Missing, NoAnswer):
            return None

    def _plotted(
        self,
        data: Mapping[str, Array],
        recorder: Mapping[str, Any] | None = None,
        shown: Mapping[str, Array] | None = None,
    ) -> Drawing:
        keys = {name: f"d{number}" for number, name in enumerate(data)}
        arrays = {keys[name]: value for name, value in data.items()} | dict(shown or {})
        place = {"path": self.place_of("plot_imu_data")}
        return drawing_of(self.ask("plot", place | {"keys": keys, "recorder": recorder}, arrays))

    def scripts(self) -> Iterator[Drawing]:
        """Yield what the submission's files draw when they are run as scripts, one by one; a caller may stop early to save runs.

        For each file, what it drew when it was imported comes first, because that takes no further run.
        """
        beside = sorted(self.broken)
        for path in self._runnable():
            for ask in (self._drawn_at_import, self._drawn_as_script, self._drawn_untouched):
                drawing = self.once((ask.__name__, path, *beside), partial(ask, path))
                if drawing is not None:
                    yield drawing
        for path in self.further_scripts():
            drawing = self.once(("script", path, *beside), partial(self._run_script, path))
            if drawing is not None:
                yield drawing
        if any(_DATA_FILE.search(content) for path, content in self.files.items() if path.endswith(".py")):
            yield from self.once(("scripts in turn", *beside), self._drawn_in_turn)

    def _runnable(self) -> list[str]:
        others = sorted(p for p in self.paths if p.endswith(".ipynb") and p not in self.used)
        return [p for p in ("filters.py", "noisy_imu.py", "imu_reader.py", *self.used, *others) if p in self.paths]

    def _drawn_at_import(self, path: str) -> Drawing | None:
        """Return what a file drew on import, and as its `error` the first exception of a statement that the loader stepped over.

        None if the file could not be loaded.
        """
        try:
            loaded = self.load(path)
        except NoAnswer:
            return None
        error = next((each.error for each in loaded.stepped_over if each.how == "raised"), None)
        return replace(drawing_of(loaded.frame), error=error)

    def _drawn_as_script(self, path: str) -> Drawing | None:
        if path.endswith(".ipynb") or not (
            self._is_unreadable(path) or b"__main__" in self.files.get(path, b"__main__")
        ):
            return None
        return self._run_script(path)

    def _is_unreadable(self, path: str) -> bool:
        try:
            return self.load(path).unreadable is not None
        except NoAnswer:
            return False

    def _run_script(self, path: str) -> Drawing | None:
        self.end_session()
        try:
            return drawing_of(self.retried(lambda: self.ask("run_script", {"path": path})))
        except NoAnswer:
            return None
        finally:
            self.end_session()

    def _drawn_in_turn(self) -> list[Drawing]:
        """Run all scripts one after the other in one folder, because a script may read a file that an earlier one wrote.

        If a script gives no answer, what was drawn before it is returned.
        """
        found = []
        self.end_session()
        try:
            for path in (*(file for file in self._lab.files if file in self.paths), *self.further_scripts()):
                found.append(drawing_of(self.ask("run_script", {"path": path})))
        except NoAnswer:
            pass  # what came before counts
        finally:
            self.end_session()
        return found

    def _drawn_untouched(self, path: str) -> Drawing | None:
        """Return what a file draws without the grader's versions of broken functions: a script may fit only its own function.

        None if no function was replaced by such a stand-in, if the file killed its process before, or if it gives no answer.
        """
        if not self.broken or path in self.deadly:
            return None
        with self.without_standins():
            if path.endswith(".ipynb"):
                return self._drawn_at_import(path)
            try:
                return drawing_of(self.retried(lambda: self.ask("run_script", {"path": path})))
            except NoAnswer:
                return None

    def picture(self, name: str) -> Picture | None:
        """Return size and colours of a handed-in picture file; None if it was not handed in, or cannot be read."""
        if name not in self.files:
            return None
        return self.once_named(name, ("picture", name), lambda: self._decode(name))

    def _decode(self, name: str) -> Picture | None:
        content = np.frombuffer(self.files[name], dtype=np.uint8)
        try:
            frame = self.retried(lambda: self.ask_fresh_worker("image", {}, {"bytes": content}))
            return picture_of(self._lab.checked("image", frame, {}, {}))
        except NoAnswer:
            return None

    def further_scripts(self) -> list[str]:
        """Return up to three ungraded .py files to run: with `savefig`, then never imported; [] if no file has `savefig`."""
        code = {path: content for path, content in self.files.items() if path.endswith((".py", ".ipynb"))}
        saving = {path for path, content in code.items() if b"savefig" in content}
        if not saving:
            return []
        imported = {name for content in code.values() for name in _imported(content)}
        known = {*self._lab.homes.values(), *self.used}
        others = [path for path in self.paths - known if path.endswith(".py") and is_run(path)]
        programs = [path for path in others if path in saving or PurePosixPath(path).stem not in imported]
        return sorted(programs, key=lambda p: (p not in saving, p))[:_FURTHER]


def _imported(content: bytes) -> set[str]:
    """Return the names of the modules that a file or notebook imports, so that a helper is not run as a script."""
    return {word.decode() for modules in _IMPORTS.findall(content) for word in re.findall(rb"\w+", modules)}
