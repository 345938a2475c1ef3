"""Grading in a worker process of a Dask cluster: each run keeps a marker open there, the object that grades submissions.

The marker has a process of its own, as on a single machine, so that it can be ended without ending the worker.
"""

from __future__ import annotations

import json
import pickle
import platform
import threading
from collections.abc import Iterable, Mapping
from contextlib import ExitStack, suppress
from importlib.metadata import version
from typing import Any, ClassVar

from distributed import Worker, WorkerPlugin, get_worker

from grader import __version__
from grader.base.errors import GraderError, RequestError
from grader.course.markers.pool import Ended, Pool, Unmarked
from grader.engine.results import Result, to_record
from grader.intake import Submission

_OURS = ("imugrade", "python")


def versions(packages: Iterable[str]) -> dict[str, str]:
    """Return the versions of imugrade, Python and `packages`, by name; they must be equal on all machines for equal grades."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"imugrade": __version__, "python": python, **{name: version(name) for name in packages}}


def as_plain_data(result: Result) -> dict[str, Any]:
    """Return a result as plain data (text, bytes and numbers), which a worker sends back over the network."""
    record = json.dumps(to_record(result), ensure_ascii=True, allow_nan=False)
    return {"record": record, "charts": result.evidence.charts, "fingerprint": list(result.evidence.fingerprint)}


def mark(run: str, submission: Mapping[str, Any]) -> dict[str, Any]:
    """Grade a submission, given by its fields, with the Dask worker's plugin named `run`.

    Return the dictionary of `GradingPlugin.mark`: the result, or the reason why there is none.
    """
    plugin = get_worker().plugins[run]
    assert isinstance(plugin, GradingPlugin)
    return plugin.mark(Submission(**submission))


class GradingPlugin(WorkerPlugin):
    """Dask worker plugin that keeps a marker, which grades submissions, open for a whole class, because opening one is slow.

    Dask installs it in every present and future worker. A process has one marker at a time: if a killed command left its marker
    open, the plugin of the next command closes it.

    Parameters
    ----------
    run
        Name of the plugin, unique to one `grade` command.
    made_by
        What `versions` returns on the machine that distributes the submissions; a worker with other versions refuses to grade.
    open_marker
        The pickled pair of marker factory and `Bounds` (limits on time and memory). It is unpickled only if the versions agree.
    """

    _at_work: ClassVar[threading.Lock] = threading.Lock()
    _taken_by: ClassVar[GradingPlugin | None] = None

    def __init__(self, run: str, made_by: Mapping[str, str], open_marker: bytes) -> None:
        self.name = run
        self._made_by = dict(made_by)
        self._open_marker = open_marker
        self._address = ""
        self._over = False
        self._opened = ExitStack()
        self._pool: Pool | None = None

    def setup(self, worker: Worker) -> None:
        self._address = worker.address
        self._agree()

    def teardown(self, worker: Worker) -> None:
        self._over = True
        self._leave_if_idle()

    def mark(self, submission: Submission) -> dict[str, Any]:
        """Grade a submission and return its result as a dictionary of text, bytes and numbers, made by `plain`.

        Without a result the keys are "trouble", the reason why, and "stopped", the same reason if a limit on time or memory ended
        the grading, else "".

        Raises
        ------
        GraderError, RequestError
            If no marker can be opened here.
        """
        try:
            with self._at_work:
                return self._marked(self._pool_here(), submission)
        finally:
            if self._over:
                self._leave_if_idle()

    def _marked(self, pool: Pool, submission: Submission) -> dict[str, Any]:
        """Grade one submission for `mark`. An error names this worker and closes the marker, so the next call opens another."""
        try:
            ((_, outcome),) = pool.run(iter([submission]))
        except (RequestError, GraderError) as problem:
            self._leave()
            raise type(problem)(f"worker {self._address}: {problem}") from problem
        if isinstance(outcome, Ended | Unmarked):
            return {"trouble": outcome.reason, "stopped": outcome.reason if isinstance(outcome, Ended) else ""}
        return as_plain_data(outcome)

    def _agree(self) -> None:
        here_are = versions(name for name in self._made_by if name not in _OURS)
        for name, here in here_are.items():
            there = self._made_by.get(name, "none")
            if here != there:
                raise RequestError(
                    f"worker {self._address} has {name} {here}, this machine has {there}; install the same on both"
                )

    def _pool_here(self) -> Pool:
        """Return this run's pool, with the marker that grades, opened on the first call. One left by an earlier run is closed."""
        if self._pool is None:
            self._agree()
            if GradingPlugin._taken_by is not None:
                GradingPlugin._taken_by._leave()
            open_marker, bounds = pickle.loads(self._open_marker)
            self._pool = self._opened.enter_context(Pool(open_marker, 1, bounds, attempts=1))
            GradingPlugin._taken_by = self
        return self._pool

    def _leave(self) -> None:
        self._pool = GradingPlugin._taken_by = None
        with suppress(Exception):  # a failed marker may fail to close, too
            self._opened.close()

    def _leave_if_idle(self) -> None:
        """Close the marker, which grades submissions, when the run is over; if it is grading just now, `mark` closes it later."""
        if self._at_work.acquire(blocking=False):
            try:
                if GradingPlugin._taken_by is self:
                    self._leave()
            finally:
                self._at_work.release()
